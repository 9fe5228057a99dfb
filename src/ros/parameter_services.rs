//! The six services behind `ros2 param`, and `/parameter_events`.
//!
//! Of a fleet, `a3.top.load` is the parameter `top.load` of column `a3`. The parameters that belong to the node of a fleet keep their
//! names, and are read-only. A single twin has its parameters under their own names.
//!
//! The services of ros2-client have neither descriptions nor ranges nor read-only flags, check one value at a time and
//! never a set as a whole, reject a whole number for a `double`, and run their set action at declaration.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};

use crate::parameters::{
    Admissible, DeclaredParameter, Kind, Parameter, Parameters, Value, is_of_the_fleet,
};
use crate::twin::{Accepted, Command, Rejection, RejectionCode};

use super::face::Face;
use super::live_columns::LiveColumns;

/// Maximum number of parameters in one request: more than exist, and few enough to answer quickly.
const MAX_PARAMETERS_PER_REQUEST: usize = 1024;

/// Maximum number of names in a request that is answered name by name. The answer to more of them would be longer than what
/// RustDDS and others take as one message, and would vanish.
const MAX_NAMES_ANSWERED: usize = 10 * MAX_PARAMETERS_PER_REQUEST;

/// Most names in one list, so that it fits into a message: the prefixes name the columns whose parameters are left out.
const MAX_LISTED: usize = 8192;

/// What a client has to know of a change that is accepted during a response.
const WAITS: &str = "takes effect when the response ends";

/// What to do if a value is admissible by itself, but not together with the others.
const TOGETHER: &str = "set parameters that depend on one another in one request, with ~/set_parameters_atomically or a \
                        message on column_parameters";

/// Columns whose parameters can be read and changed.
pub(super) trait Configurable {
    /// The columns, and how others tell them apart.
    fn face(&self) -> &Face;

    /// The parameters of the node.
    fn node_parameters(&self) -> &Arc<Parameters>;

    /// The parameters of a column that hold.
    fn parameters(&self, column: u32) -> Arc<Parameters>;

    /// Executes a command of a column, and waits for the outcome.
    fn execute(&self, column: u32, command: Command) -> Result<Accepted, Rejection>;
}

impl Configurable for LiveColumns {
    fn face(&self) -> &Face {
        self.face()
    }

    fn node_parameters(&self) -> &Arc<Parameters> {
        self.node_parameters()
    }

    fn parameters(&self, column: u32) -> Arc<Parameters> {
        self.parameters(column)
    }

    fn execute(&self, column: u32, command: Command) -> Result<Accepted, Rejection> {
        self.execute(column, command)
    }
}

/// Where a parameter is.
struct Place<'a> {
    /// The index of its column; `None` if it belongs to the node of a fleet.
    column: Option<u32>,
    /// Its name there.
    name: &'a str,
    parameters: Arc<Parameters>,
}

/// Finds a parameter by its name; `None` if there is none. An identifier may contain dots, so that the longest one wins.
fn place<'a>(columns: &impl Configurable, full_name: &'a str) -> Option<Place<'a>> {
    let face = columns.face();
    let in_column = |column, name| {
        let parameters = columns.parameters(column);
        let is_known = is_of_a_column(face, name) && parameters.declared(name).is_some();
        is_known.then_some(Place {
            column: Some(column),
            name,
            parameters,
        })
    };
    if !face.is_fleet() {
        return in_column(0, full_name);
    }
    let in_node = || {
        let parameters = columns.node_parameters();
        let is_known = is_of_the_fleet(full_name) && parameters.declared(full_name).is_some();
        is_known.then(|| Place {
            column: None,
            name: full_name,
            parameters: Arc::clone(parameters),
        })
    };
    let mut dots = full_name.rmatch_indices('.');
    let found = dots.find_map(|(dot, _)| {
        let column = face.index_of(&full_name[..dot])?;
        in_column(column, &full_name[dot + 1..])
    });
    found.or_else(in_node)
}

/// Whether each column has this parameter for itself.
pub(super) fn is_of_a_column(face: &Face, name: &str) -> bool {
    !face.is_fleet() || !is_of_the_fleet(name)
}

/// `~/get_parameters`: the values that hold; a change that waits for the end of a response is not among them yet. Unknown names
/// are "not set", as in rclpy.
pub(super) fn get(
    columns: &impl Configurable,
    request: &GetParametersRequest,
) -> GetParametersResponse {
    let value = |name: &String| value_of(columns, name).map_or_else(not_set, raw_value);
    GetParametersResponse {
        values: each(&request.names, value, |_| not_set()),
    }
}

/// The value of a parameter that holds; `None` if there is no such parameter.
pub(super) fn value_of(columns: &impl Configurable, name: &str) -> Option<Value> {
    place(columns, name).and_then(|it| it.parameters.get(it.name))
}

/// `~/get_parameter_types`
pub(super) fn types(
    columns: &impl Configurable,
    request: &GetParameterTypesRequest,
) -> GetParameterTypesResponse {
    let type_of = |name: &String| {
        let place = place(columns, name);
        let known = place.as_ref();
        let known = known.and_then(|it| it.parameters.declared(it.name));
        known.map_or(raw::ParameterType::NOT_SET, |it| type_code(it.row.kind()))
    };
    GetParameterTypesResponse {
        values: each(&request.names, type_of, |_| raw::ParameterType::NOT_SET),
    }
}

/// `~/describe_parameters`: an unknown name has an empty description, as in rclpy.
pub(super) fn describe(
    columns: &impl Configurable,
    request: &DescribeParametersRequest,
) -> DescribeParametersResponse {
    let described = |name: &String| {
        let Some(place) = place(columns, name) else {
            return no_descriptor();
        };
        let declared = place.parameters.declared(place.name);
        let mut it = declared.map_or_else(no_descriptor, descriptor);
        it.name.clone_from(name);
        it.read_only |= place.column.is_none();
        it
    };
    DescribeParametersResponse {
        values: each(&request.names, described, |description| {
            raw::ParameterDescriptor {
                description,
                ..no_descriptor()
            }
        }),
    }
}

/// One reply for each request, as the services require: `answer` up to the bound, `reject` beyond it. `reject` receives the
/// reason, which is empty after the first one, so that the reply does not grow beyond the request. Far beyond the bound there is
/// no reply for any of them, as in rclcpp where it cannot answer, and a warning.
fn each<T, A>(requested: &[T], answer: impl Fn(&T) -> A, reject: impl Fn(String) -> A) -> Vec<A> {
    if requested.len() > MAX_NAMES_ANSWERED {
        tracing::warn!(
            "a request about parameters was answered with an empty list: {}",
            too_many(requested.len())
        );
        return Vec::new();
    }
    let (answered, rejected) = requested.split_at(requested.len().min(MAX_PARAMETERS_PER_REQUEST));
    let rejections = (0..rejected.len()).map(|index| {
        reject(match index {
            0 => too_many(requested.len()),
            _ => String::new(),
        })
    });
    answered.iter().map(answer).chain(rejections).collect()
}

fn too_many(count: usize) -> String {
    format!(
        "expected at most {MAX_PARAMETERS_PER_REQUEST} parameters in one request, found {count}; send several requests"
    )
}

/// Whether a request asks for this name, as in rclpy: without prefixes all names with fewer than `depth` dots (0: any number);
/// with prefixes the names equal to one of them, or below one with fewer than `depth` dots behind it and its own dot.
fn is_listed(name: &str, request: &ListParametersRequest) -> bool {
    let within = |dots: usize| request.depth == 0 || (dots as u64) < request.depth;
    let below = |name: &str, prefix: &String| {
        name == prefix
            || name
                .strip_prefix(prefix.as_str())
                .and_then(|rest| rest.strip_prefix('.'))
                .is_some_and(|rest| within(rest.matches('.').count()))
    };
    match request.prefixes.is_empty() {
        true => within(name.matches('.').count()),
        false => request.prefixes.iter().any(|prefix| below(name, prefix)),
    }
}

/// `~/list_parameters`: the names for which [`is_listed`] holds, of the node and of every column, at most [`MAX_LISTED`]. The prefixes
/// include every column of a fleet that the request asks for.
pub(super) fn list(
    columns: &impl Configurable,
    request: &ListParametersRequest,
) -> ListParametersResponse {
    let face = columns.face();
    let mut names = Vec::new();
    let mut prefixes = BTreeSet::new();
    if face.is_fleet() {
        let declared = columns.node_parameters().all_declared();
        let own = declared.map(|it| it.name.to_owned());
        names.extend(own.filter(|name| is_of_the_fleet(name) && is_listed(name, request)));
    }
    for (column, column_id) in (0..).zip(face.ids()) {
        if face.is_fleet() {
            if !asks_for_column(request, column_id) {
                continue;
            }
            prefixes.insert(column_id.to_string());
        }
        if names.len() >= MAX_LISTED {
            continue;
        }
        let (parameters, prefix) = (columns.parameters(column), face.parameter_prefix(column));
        let own = parameters.all_declared().map(|it| it.name);
        let own = own.filter(|name| is_of_a_column(face, name));
        let own = own.map(|name| format!("{prefix}{name}"));
        names.extend(own.filter(|name| is_listed(name, request)));
    }
    names.truncate(MAX_LISTED);
    names.sort();
    let groups = names.iter().filter_map(|name| name.rsplit_once('.'));
    prefixes.extend(groups.map(|(group, _)| group.to_owned()));
    ListParametersResponse {
        result: ListParametersResult {
            names,
            prefixes: prefixes.into_iter().collect(),
        },
    }
}

/// Whether a request asks for parameters of this column.
fn asks_for_column(request: &ListParametersRequest, column_id: &str) -> bool {
    let is_within = |outer: &str, inner: &str| {
        let rest = inner.strip_prefix(outer);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let mut prefixes = request.prefixes.iter();
    request.prefixes.is_empty()
        || prefixes.any(|it| is_within(column_id, it) || is_within(it, column_id))
}

/// `~/set_parameters`: one by one, each with its own result.
pub(super) fn set(
    columns: &impl Configurable,
    request: &SetParametersRequest,
) -> SetParametersResponse {
    let set_one = |it: &raw::Parameter| result(set_together(columns, vec![it.clone()]));
    SetParametersResponse {
        results: each(&request.parameter, set_one, |reason| result(Err(reason))),
    }
}

/// The answer to a request that is not carried out.
pub(super) fn set_rejected(
    request: &SetParametersRequest,
    rejection: &Rejection,
) -> SetParametersResponse {
    let rejected = |_: &raw::Parameter| result(Err(rejection.tagged()));
    SetParametersResponse {
        results: each(&request.parameter, rejected, |reason| result(Err(reason))),
    }
}

/// The answer to a request that is not carried out.
pub(super) fn set_rejected_atomically(rejection: &Rejection) -> SetParametersAtomicallyResponse {
    SetParametersAtomicallyResponse {
        result: result(Err(rejection.tagged())),
    }
}

/// `~/set_parameters_atomically`: all or none of one column, validated as a whole.
pub(super) fn set_atomically(
    columns: &impl Configurable,
    request: SetParametersRequest,
) -> SetParametersAtomicallyResponse {
    let outcome = match request.parameter.len() > MAX_PARAMETERS_PER_REQUEST {
        true => Err(too_many(request.parameter.len())),
        false => set_together(columns, request.parameter),
    };
    SetParametersAtomicallyResponse {
        result: result(outcome),
    }
}

/// Changes parameters of one column as a whole. Parameters of the node of a fleet may be among them if they keep their values, as when
/// a dump is loaded.
fn set_together(columns: &impl Configurable, given: Vec<raw::Parameter>) -> Result<String, String> {
    let face = columns.face();
    if !face.is_fleet() {
        // It rejects names that it does not know, and counts the rejections.
        return set_all(columns, 0, given);
    }
    let mut of: Option<u32> = None;
    let mut changes = Vec::new();
    for raw::Parameter { name, value } in given {
        let Some(found) = place(columns, &name) else {
            return Err(unknown(columns, &name).tagged());
        };
        let parameter = raw::Parameter {
            name: found.name.to_owned(),
            value,
        };
        let Some(column) = found.column else {
            check_unchanged(&found.parameters, parameter).map_err(|it| it.tagged())?;
            continue;
        };
        let first = *of.get_or_insert(column);
        if first != column {
            let reason = format!(
                "expected parameters of one column in one request, found parameters of {:?} and {:?}; send a request for each column",
                face.id(first),
                face.id(column)
            );
            return Err(Rejection::new(RejectionCode::ParametersInvalid, reason).tagged());
        }
        changes.push(parameter);
    }
    let Some(column) = of else {
        return Ok(String::new());
    };
    set_all(columns, column, changes)
        .map_err(|reason| format!("{reason}; column {:?}", face.id(column)))
}

/// # Errors
/// The parameter of the node would have another value.
fn check_unchanged(node: &Parameters, given: raw::Parameter) -> Result<(), Rejection> {
    let name = given.name.clone();
    let value = settable_value(node, given)?;
    let row = node.declared(&name).map(|it| it.row);
    let checked = row.and_then(|it| it.check(&value).ok());
    if checked.is_some() && checked == node.get(&name) {
        return Ok(());
    }
    let reason = format!(
        "{name} belongs to the node of the fleet and is read-only while it runs; set it when starting the fleet (-p {name}:=...)"
    );
    Err(Rejection::new(RejectionCode::ParametersReadOnly, reason))
}

/// Why a fleet has no parameter of this name.
fn unknown(columns: &impl Configurable, name: &str) -> Rejection {
    let first = columns.face().id(0);
    let reason = match columns.parameters(0).declared(name) {
        Some(_) => format!(
            "{name} is a parameter of every column; name the column, for example {first}.{name}"
        ),
        None => format!(
            "{name} is no parameter of this fleet of {} columns; expected COLUMN.PARAMETER, for example {first}.top.load",
            columns.face().ids().len()
        ),
    };
    Rejection::new(RejectionCode::ParametersInvalid, reason)
}

/// Changes parameters as a whole; returns what the client should know: that the change waits, or uses a deprecated value.
fn set_all(
    columns: &impl Configurable,
    column: u32,
    parameters: Vec<raw::Parameter>,
) -> Result<String, String> {
    const SOURCE: &str = "parameter service";
    let current = columns.parameters(column);
    let is_single = parameters.len() == 1;
    let values: Result<Vec<_>, Rejection> = parameters
        .into_iter()
        .map(|parameter| {
            let name = parameter.name.clone();
            Ok((name, settable_value(&current, parameter)?))
        })
        .collect();
    let source = SOURCE.into();
    let (command, mut remarks, is_admissible_alone) = match values {
        Ok(changes) => {
            let remarks: Vec<_> = changes.iter().filter_map(deprecation).collect();
            let alone = is_single && changes.iter().all(is_admissible);
            (Command::SetParameters { changes, source }, remarks, alone)
        }
        Err(rejection) => (Command::RejectedChange { rejection, source }, vec![], false),
    };
    let accepted = columns.execute(column, command).map_err(|rejection| {
        let tagged = rejection.tagged();
        match rejection.code {
            RejectionCode::ParametersInvalid if is_admissible_alone => {
                format!("{tagged}; {TOGETHER}")
            }
            _ => tagged,
        }
    })?;
    for warning in &remarks {
        tracing::warn!("{warning}");
    }
    if accepted == Accepted::Waiting {
        remarks.insert(0, WAITS.to_owned());
    }
    Ok(remarks.join("; "))
}

/// Whether the parameter may have this value, whatever the others are.
fn is_admissible((name, value): &(String, Value)) -> bool {
    Parameter::named(name).is_some_and(|parameter| parameter.check(value).is_ok())
}

fn deprecation((name, value): &(String, Value)) -> Option<String> {
    let Value::String(word) = value else {
        return None;
    };
    let replacement = Parameter::named(name)?.replacement_of(word)?;
    Some(format!(
        "{name}: `{word}` is deprecated; write {replacement}"
    ))
}

/// The value, if the parameter can be set while the node runs, or has this value already: `ros2 param load` sends back a whole
/// dump.
fn settable_value(current: &Parameters, parameter: raw::Parameter) -> Result<Value, Rejection> {
    let raw::Parameter { name, value } = parameter;
    // What becomes of an array of other elements is the same for all, unless it is empty.
    let array = |is_empty: bool| is_empty.then(|| Value::DoubleArray(vec![]));
    let found = match value.ptype {
        raw::ParameterType::BOOL => Some(Value::Bool(value.boolean_value)),
        raw::ParameterType::INTEGER => Some(Value::Integer(value.int_value)),
        raw::ParameterType::DOUBLE => Some(Value::Double(value.double_value)),
        raw::ParameterType::STRING => Some(Value::String(value.string_value)),
        raw::ParameterType::BYTE_ARRAY => array(value.byte_array.is_empty()),
        raw::ParameterType::BOOL_ARRAY => array(value.bool_array.is_empty()),
        // A whole number is accepted where a double is expected.
        raw::ParameterType::INTEGER_ARRAY => {
            let numbers = value.int_array.iter().map(|it| *it as f64);
            Some(Value::DoubleArray(numbers.collect()))
        }
        raw::ParameterType::DOUBLE_ARRAY => Some(Value::DoubleArray(value.double_array)),
        raw::ParameterType::STRING_ARRAY => Some(Value::StringArray(value.string_array)),
        _ => None,
    };
    let Some(known) = current.declared(&name).map(|it| it.row) else {
        // The twin rejects the name, with a suggestion.
        return Ok(found.unwrap_or(Value::Bool(false)));
    };
    let found = found.map(|value| known.meant_in_yaml_1_1(value));
    let is_unchanged = || {
        let value = found.as_ref().and_then(|value| known.check(value).ok());
        value.is_some() && value == current.get(&name)
    };
    if known.read_only() && !is_unchanged() {
        let reason = format!(
            "{name} is read-only while the node runs; set it when starting the node (-p {name}:=...)"
        );
        return Err(Rejection::new(RejectionCode::ParametersReadOnly, reason));
    }
    found.ok_or_else(|| {
        let problem = match value.ptype {
            raw::ParameterType::NOT_SET => "cannot be undeclared",
            raw::ParameterType::BYTE_ARRAY => "is a list of bytes",
            raw::ParameterType::BOOL_ARRAY => "is a list of booleans",
            _ => "has an unknown type",
        };
        let reason = format!("{name} {problem}; allowed: {}", known.expectation());
        Rejection::new(RejectionCode::ParametersInvalid, reason)
    })
}

fn result(outcome: Result<String, String>) -> raw::SetParametersResult {
    raw::SetParametersResult {
        successful: outcome.is_ok(),
        reason: outcome.unwrap_or_else(|reason| reason),
    }
}

/// The message on `/parameter_events` after a change from `before` to `now` of the parameters whose names are among the `own` ones; at
/// the start there is no `before`, and all of these are new.
pub(super) fn event(
    node: String,
    stamp: i64,
    before: Option<&Parameters>,
    now: &Parameters,
    own: impl Fn(&str) -> bool,
) -> Option<raw::ParameterEvent> {
    let all = now.iter().filter(|(it, _)| own(it.name));
    let (new, changed) = match before {
        None => (all.map(entry).collect(), vec![]),
        Some(before) => {
            let changed = now.changed_from(before).into_iter();
            let names: HashSet<_> = changed.map(|it| it.name).collect();
            let changed = all.filter(|(it, _)| names.contains(it.name));
            (vec![], changed.map(entry).collect())
        }
    };
    (!new.is_empty() || !changed.is_empty()).then(|| raw::ParameterEvent {
        stamp: ros2_client::builtin_interfaces::Time::from_nanos(stamp),
        node,
        new_parameters: new,
        changed_parameters: changed,
        deleted_parameters: vec![],
    })
}

fn entry((parameter, value): (DeclaredParameter<'_>, Value)) -> raw::Parameter {
    raw::Parameter {
        name: parameter.name.to_owned(),
        value: raw_value(value),
    }
}

fn descriptor(declared: DeclaredParameter<'_>) -> raw::ParameterDescriptor {
    let mut it = no_descriptor();
    it.name = declared.name.to_owned();
    let parameter = declared.row;
    it.r#type = type_code(parameter.kind());
    it.description = match parameter.unit {
        "" => parameter.meaning.to_owned(),
        unit => format!("{} [{unit}]", parameter.meaning),
    };
    it.additional_constraints = parameter.expectation();
    it.read_only = parameter.read_only();
    let reals = |from_value, to_value| raw::FloatingPointRange {
        from_value,
        to_value,
        step: 0.0,
    };
    // The range of an array is that of its elements.
    let admissible = match parameter.admissible {
        Admissible::List { of, .. } => *of,
        other => other,
    };
    match admissible {
        Admissible::Integer { min, max } => it.integer_range.push(raw::IntegerRange {
            from_value: min,
            to_value: max,
            // A step of 0 would rule out all values between the ends.
            step: 1,
        }),
        Admissible::Sign => it.integer_range.push(raw::IntegerRange {
            from_value: -1,
            to_value: 1,
            step: 2,
        }),
        Admissible::Real { min, max } => it.floating_point_range.push(reals(min, max)),
        // A range has no gap; the additional constraint describes the rest.
        Admissible::RealOrZero { max, .. }
        | Admissible::RealOrOpen { max, .. }
        | Admissible::WholeNanoseconds { max, .. } => {
            it.floating_point_range.push(reals(0.0, max));
        }
        Admissible::Switch
        | Admissible::Choice(_)
        | Admissible::Text { .. }
        | Admissible::SectionName
        | Admissible::VehicleName
        | Admissible::SteelGrade
        | Admissible::Processors
        | Admissible::Sender
        | Admissible::SensorName
        | Admissible::List { .. } => {}
    }
    it
}

fn no_descriptor() -> raw::ParameterDescriptor {
    raw::ParameterDescriptor {
        name: String::new(),
        r#type: raw::ParameterType::NOT_SET,
        description: String::new(),
        additional_constraints: String::new(),
        read_only: false,
        dynamic_typing: false,
        floating_point_range: vec![],
        integer_range: vec![],
    }
}

fn type_code(kind: Kind) -> u8 {
    match kind {
        Kind::Bool => raw::ParameterType::BOOL,
        Kind::Integer => raw::ParameterType::INTEGER,
        Kind::Double => raw::ParameterType::DOUBLE,
        Kind::String => raw::ParameterType::STRING,
        Kind::DoubleArray => raw::ParameterType::DOUBLE_ARRAY,
        Kind::StringArray => raw::ParameterType::STRING_ARRAY,
    }
}

pub(super) fn raw_value(value: Value) -> raw::ParameterValue {
    let mut raw = not_set();
    raw.ptype = type_code(value.kind());
    match value {
        Value::Bool(value) => raw.boolean_value = value,
        Value::Integer(value) => raw.int_value = value,
        Value::Double(value) => raw.double_value = value,
        Value::String(value) => raw.string_value = value,
        Value::DoubleArray(values) => raw.double_array = values,
        Value::StringArray(values) => raw.string_array = values,
    }
    raw
}

fn not_set() -> raw::ParameterValue {
    raw::ParameterValue {
        ptype: raw::ParameterType::NOT_SET,
        boolean_value: false,
        int_value: 0,
        double_value: 0.0,
        string_value: String::new(),
        byte_array: vec![],
        bool_array: vec![],
        int_array: vec![],
        double_array: vec![],
        string_array: vec![],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{PARAMETERS, SENSOR_PARAMETERS};

    /// A single twin with fixed parameters.
    struct Fixed(Face, Arc<Parameters>);

    impl Configurable for Fixed {
        fn face(&self) -> &Face {
            &self.0
        }

        fn node_parameters(&self) -> &Arc<Parameters> {
            &self.1
        }

        fn parameters(&self, _: u32) -> Arc<Parameters> {
            Arc::clone(&self.1)
        }

        fn execute(&self, _: u32, _: Command) -> Result<Accepted, Rejection> {
            Err(Rejection::new(RejectionCode::ParametersReadOnly, "a test"))
        }
    }

    fn fixed(parameters: &Parameters) -> Fixed {
        Fixed(Face::of_one("column"), Arc::new(parameters.clone()))
    }

    fn names(prefixes: &[&str], depth: u64) -> Vec<String> {
        let prefixes = prefixes.iter().map(|it| (*it).to_owned()).collect();
        list(
            &fixed(&Parameters::default()),
            &ListParametersRequest { prefixes, depth },
        )
        .result
        .names
    }

    #[test]
    fn lists_as_rclpy_does() {
        assert_eq!(names(&[], 0).len(), PARAMETERS.len());
        assert!(names(&[], 1).iter().all(|name| !name.contains('.')));
        assert_eq!(names(&[], 3).len(), PARAMETERS.len());
        let nested = "vehicle.spring_1.crush".to_owned();
        assert!(names(&["vehicle"], 2).contains(&nested));
        // It was empty: the dot behind the prefix does not count.
        let direct = names(&["vehicle"], 1);
        assert!(direct.contains(&"vehicle.name".to_owned()) && !direct.contains(&nested));
        assert!(names(&["top"], 0).contains(&"top.load".to_owned()));
        assert_eq!(names(&["top"], 1), names(&["top"], 0));
        assert_eq!(names(&["column_id", "nothing"], 0), ["column_id"]);
        let all = list(
            &fixed(&Parameters::default()),
            &ListParametersRequest {
                prefixes: vec![],
                depth: 0,
            },
        );
        assert!(all.result.prefixes.contains(&"geometry".to_owned()));
    }

    #[test]
    fn every_parameter_has_a_description_and_its_default_lies_in_its_range() {
        let request = DescribeParametersRequest {
            names: PARAMETERS.iter().map(|it| it.name.to_owned()).collect(),
        };
        let descriptors = describe(&fixed(&Parameters::default()), &request).values;
        for (parameter, descriptor) in PARAMETERS.iter().zip(&descriptors) {
            assert_eq!(descriptor.name, parameter.name);
            assert!(!descriptor.description.is_empty());
            assert_eq!(descriptor.read_only, parameter.read_only());
            match (
                &descriptor.floating_point_range[..],
                parameter.default_value(),
            ) {
                ([range], Value::Double(value)) => {
                    assert!((range.from_value..=range.to_value).contains(&value));
                }
                ([range], Value::DoubleArray(values)) => {
                    let all = range.from_value..=range.to_value;
                    assert!(values.iter().all(|value| all.contains(value)));
                }
                ([], value) => assert!(
                    !matches!(value, Value::Double(_) | Value::DoubleArray(_)),
                    "{}",
                    parameter.name
                ),
                _ => panic!("{} has a range and is no number", parameter.name),
            }
        }
        let unknown = describe(
            &fixed(&Parameters::default()),
            &DescribeParametersRequest {
                names: vec!["x".to_owned()],
            },
        );
        assert_eq!(unknown.values[0].name, "");
    }

    #[test]
    fn oversized_requests_are_answered() {
        let many = MAX_PARAMETERS_PER_REQUEST + 2;
        let names = vec!["top.load".to_owned(); many];
        let parameters = Parameters::default();
        let values = get(
            &fixed(&parameters),
            &GetParametersRequest {
                names: names.clone(),
            },
        )
        .values;
        assert_eq!(values.len(), many);
        let types = types(
            &fixed(&Parameters::default()),
            &GetParameterTypesRequest {
                names: names.clone(),
            },
        )
        .values;
        assert_eq!(
            types[many - 3..],
            [
                raw::ParameterType::DOUBLE,
                raw::ParameterType::NOT_SET,
                raw::ParameterType::NOT_SET
            ]
        );
        let descriptors = describe(
            &fixed(&Parameters::default()),
            &DescribeParametersRequest { names },
        )
        .values;
        assert_eq!(descriptors.len(), many);
        assert_eq!(descriptors[many - 3].name, "top.load");
        assert_eq!(descriptors[many - 1].description, "");
        assert_eq!(
            descriptors[many - 2].description,
            "expected at most 1024 parameters in one request, found 1026; send several requests"
        );
    }

    /// They were answered with more than a message holds, and the client waited for ever.
    #[test]
    fn a_request_with_a_hundred_thousand_names_is_answered_with_an_empty_list() {
        let names = vec!["top.load".to_owned(); 100_000];
        let parameters = Parameters::default();
        let request = GetParametersRequest {
            names: names.clone(),
        };
        assert!(get(&fixed(&parameters), &request).values.is_empty());
        let request = DescribeParametersRequest { names };
        assert!(describe(&fixed(&parameters), &request).values.is_empty());
    }

    #[test]
    fn values_have_their_types() {
        let request = GetParametersRequest {
            names: [
                "column_id",
                "top.load",
                "viewer.port",
                "use_sim_time",
                "x",
                "vehicle.masses",
                "assessment.criteria",
            ]
            .map(str::to_owned)
            .to_vec(),
        };
        let types: Vec<_> = get(&fixed(&Parameters::default()), &request)
            .values
            .iter()
            .map(|value| value.ptype)
            .collect();
        assert_eq!(types, [4, 3, 2, 1, 0, 8, 9]);
        let same = super::types(
            &fixed(&Parameters::default()),
            &GetParameterTypesRequest {
                names: request.names,
            },
        );
        assert_eq!(same.values, types);
    }

    #[test]
    fn values_that_cannot_be_set_are_rejected_with_the_reason() {
        let current = Parameters::default();
        let given = |name: &str, value: raw::ParameterValue| {
            let name = name.to_owned();
            settable_value(&current, raw::Parameter { name, value })
        };
        let reason = given("column_id", raw_value(Value::from("x"))).expect_err("read-only");
        assert!(
            reason
                .reason
                .starts_with("column_id is read-only while the node runs"),
            "{reason}"
        );
        let reason = given("top.load", not_set()).expect_err("undeclared");
        assert!(
            reason.reason.starts_with("top.load cannot be undeclared"),
            "{reason}"
        );
        let flags = raw::ParameterValue {
            ptype: raw::ParameterType::BOOL_ARRAY,
            bool_array: vec![true],
            ..not_set()
        };
        let reason = given("top.load", flags).expect_err("a list");
        assert_eq!(
            &*reason.reason,
            "top.load is a list of booleans; allowed: 0 to 1e9 N"
        );
        assert_eq!(
            given("top.load", raw_value(Value::Integer(3))),
            Ok(Value::Integer(3))
        );
    }

    /// `ros2 param set /column_twin top.load 4.0e5` sends a string, because YAML 1.1 reads one; so does `ros2 param load` for
    /// 2e-05, and for a list of unlike elements.
    #[test]
    fn a_number_that_yaml_1_1_reads_as_text_is_a_double() {
        let current = Parameters::default();
        let given = |name: &str, value: Value| {
            let (name, value) = (name.to_owned(), raw_value(value));
            settable_value(&current, raw::Parameter { name, value }).map_err(|it| it.reason)
        };
        assert_eq!(given("top.load", "4.0e5".into()), Ok(Value::Double(4e5)));
        assert_eq!(given("solver.dt", "2e-05".into()), Ok(Value::Double(2e-5)));
        assert_eq!(
            given("vehicle.masses", "[4.0e2, 800]".into()),
            Ok(Value::from(vec![400.0, 800.0]))
        );
        assert_eq!(given("top.load", "heavy".into()), Ok(Value::from("heavy")));
    }

    /// `ros2 param load` of a dump sends every parameter, read-only ones too.
    #[test]
    fn a_read_only_parameter_accepts_the_value_that_it_has() {
        let current = Parameters::default();
        for parameter in PARAMETERS.iter().filter(|it| it.read_only()) {
            let value = current.get(parameter.name).expect("known");
            let raw = raw::Parameter {
                name: parameter.name.to_owned(),
                value: raw_value(value.clone()),
            };
            assert_eq!(settable_value(&current, raw), Ok(value));
        }
    }

    #[test]
    fn arrays_are_read_written_and_described() {
        let current = Parameters::default();
        let given = |name: &str, value: raw::ParameterValue| {
            let name = name.to_owned();
            settable_value(&current, raw::Parameter { name, value })
        };
        let numbers = Value::from(vec![3.0, 4.5]);
        let words = Value::from(vec!["damage_20".to_owned()]);
        assert_eq!(
            given("vehicle.masses", raw_value(numbers.clone())),
            Ok(numbers.clone())
        );
        assert_eq!(
            given("assessment.criteria", raw_value(words.clone())),
            Ok(words.clone())
        );
        let whole = raw::ParameterValue {
            ptype: raw::ParameterType::INTEGER_ARRAY,
            int_array: vec![3, 4],
            ..not_set()
        };
        assert_eq!(
            given("vehicle.masses", whole),
            Ok(Value::from(vec![3.0, 4.0]))
        );
        // rclpy sends an empty list as an array of booleans.
        let empty = raw::ParameterValue {
            ptype: raw::ParameterType::BOOL_ARRAY,
            ..not_set()
        };
        let empty = given("vehicle.slack", empty).expect("an empty list");
        // A vehicle by numbers, with two masses and so one slack.
        let by_numbers = [
            ("vehicle.name", Value::from("")),
            ("vehicle.masses", Value::from(vec![1.0, 2.0])),
            ("vehicle.slack", Value::from(vec![0.1])),
            ("vehicle.spring_1.crush", Value::from(vec![1.0])),
            ("vehicle.spring_1.force", Value::from(vec![10.0])),
            ("vehicle.spring_1.unloading_stiffness", Value::from(10.0)),
            ("vehicle.spring_2.crush", Value::from(vec![1.0])),
            ("vehicle.spring_2.force", Value::from(vec![10.0])),
            ("vehicle.spring_2.unloading_stiffness", Value::from(10.0)),
        ];
        let before = Parameters::from_values(by_numbers).expect("admissible");
        let changes = [
            ("vehicle.masses", numbers.clone()),
            ("assessment.criteria", words.clone()),
        ];
        let now = before.with_changes(changes).expect("admissible");
        let none = now.with_changes([("vehicle.slack", empty)]);
        let none = none.expect("admissible").get("vehicle.slack");
        assert_eq!(none, Some(Value::DoubleArray(vec![])));

        let names = ["vehicle.masses", "assessment.criteria"].map(str::to_owned);
        let request = GetParametersRequest {
            names: names.to_vec(),
        };
        let values = get(&fixed(&now), &request).values;
        assert_eq!(values[0].double_array, [3.0, 4.5]);
        assert_eq!(values[1].string_array, ["damage_20"]);
        let event =
            event("/n".to_owned(), 5, Some(&before), &now, |_| true).expect("both have changed");
        let changed = event.changed_parameters.iter();
        let changed: Vec<_> = changed
            .map(|it| (it.name.as_str(), it.value.ptype))
            .collect();
        assert_eq!(changed, [(names[0].as_str(), 8), (names[1].as_str(), 9)]);

        let descriptors = describe(
            &fixed(&Parameters::default()),
            &DescribeParametersRequest {
                names: names.to_vec(),
            },
        );
        let [numbers, words] = &descriptors.values[..] else {
            panic!("{descriptors:?}");
        };
        assert_eq!((numbers.r#type, words.r#type), (8, 9));
        let range = &numbers.floating_point_range[0];
        assert_eq!((range.from_value, range.to_value), (1e-3, 1e6));
        assert_eq!(
            numbers.additional_constraints,
            "a list of 0 to 3 elements, each 0.001 to 1e6 kg"
        );
        let constraints = &words.additional_constraints;
        assert!(
            constraints.starts_with("a list of 1 to 36 elements, each collapse, "),
            "{constraints}"
        );
    }

    #[test]
    fn sensors_are_listed_described_and_read_only() {
        let given = [
            ("sensors.names", Value::from(vec!["laser".to_owned()])),
            ("sensors.laser.quantity", "displacement".into()),
            ("sensors.laser.height", 1.0.into()),
        ];
        let parameters = Parameters::from_values(given).expect("admissible");
        let request = ListParametersRequest {
            prefixes: vec!["sensors".to_owned()],
            depth: 0,
        };
        let names = list(&fixed(&parameters), &request).result.names;
        assert_eq!(names.len(), 1 + SENSOR_PARAMETERS.len());
        assert!(names.contains(&"sensors.laser.fibre".to_owned()));
        let values = get(
            &fixed(&parameters),
            &GetParametersRequest {
                names: names.clone(),
            },
        )
        .values;
        let same = types(
            &fixed(&parameters),
            &GetParameterTypesRequest {
                names: names.clone(),
            },
        )
        .values;
        let descriptors = describe(
            &fixed(&parameters),
            &DescribeParametersRequest {
                names: names.clone(),
            },
        )
        .values;
        for (index, name) in names.iter().enumerate() {
            let (value, descriptor) = (&values[index], &descriptors[index]);
            assert_eq!((&descriptor.name, descriptor.r#type), (name, value.ptype));
            assert_eq!(same[index], value.ptype);
            assert!(descriptor.read_only && !descriptor.description.is_empty());
            let unchanged = raw::Parameter {
                name: name.clone(),
                value: value.clone(),
            };
            assert!(settable_value(&parameters, unchanged).is_ok(), "{name}");
        }
        let sign = descriptors.iter().find(|it| it.name.ends_with(".sign"));
        let sign = &sign.expect("described").integer_range[0];
        assert_eq!((sign.from_value, sign.to_value, sign.step), (-1, 1, 2));
        let moved = raw::Parameter {
            name: "sensors.laser.height".to_owned(),
            value: raw_value(2.0.into()),
        };
        let reason = settable_value(&parameters, moved).expect_err("read-only");
        assert_eq!(reason.code, RejectionCode::ParametersReadOnly);
        // A sensor that is not declared is no parameter of this node.
        let unknown = vec![
            "sensors.lidar.height".to_owned(),
            "sensors.<name>.height".to_owned(),
        ];
        let described = describe(
            &fixed(&parameters),
            &DescribeParametersRequest { names: unknown },
        );
        assert!(described.values.iter().all(|it| it.name.is_empty()));
        let first = event("/n".to_owned(), 5, None, &parameters, |_| true).expect("all are new");
        let announced: Vec<_> = first.new_parameters.iter().map(|it| &it.name).collect();
        assert!(names.iter().all(|name| announced.contains(&name)));
    }

    #[test]
    fn deprecated_values_are_reported() {
        let old = ("solver.scheme".to_owned(), Value::from("energy"));
        assert_eq!(
            deprecation(&old).as_deref(),
            Some("solver.scheme: `energy` is deprecated; write conserving_midpoint")
        );
        let new = ("solver.scheme".to_owned(), Value::from("midpoint"));
        assert_eq!(deprecation(&new), None);
    }

    #[test]
    fn events_name_new_and_changed_parameters() {
        let before = Parameters::default();
        let now = before.with_changes([("top.load", 1e5)].map(|(n, v)| (n, Value::Double(v))));
        let now = now.expect("a valid change");
        let first = event("/n".to_owned(), 5, None, &before, |_| true).expect("all are new");
        assert_eq!(first.new_parameters.len(), PARAMETERS.len());
        let change =
            event("/n".to_owned(), 5, Some(&before), &now, |_| true).expect("one has changed");
        assert_eq!(change.changed_parameters[0].name, "top.load");
        assert_eq!(change.changed_parameters.len(), 1);
        assert!(event("/n".to_owned(), 5, Some(&now), &now, |_| true).is_none());
    }
}
