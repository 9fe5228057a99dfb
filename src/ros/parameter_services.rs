//! The six services behind `ros2 param`, and `/parameter_events`.
//!
//! ros2-client has such services, but theirs know no description, no range and no read-only flag, check one value at a
//! time and never a set as a whole, refuse a whole number for a `double`, and run their set action at declaration.

use std::collections::BTreeSet;

use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};

use crate::parameters::{Admissible, Kind, PARAMETERS, Parameter, Parameters, Value};
use crate::twin::{Command, Refusal, RefusalCode};

use super::live_twin::LiveTwin;

/// Most parameters in one request: more than there are, and little enough to answer.
const MAX_PARAMETERS_PER_REQUEST: usize = 1024;

/// `~/get_parameters`: unknown names are "not set", as in rclpy.
pub(super) fn get(
    parameters: &Parameters,
    request: &GetParametersRequest,
) -> GetParametersResponse {
    let value = |name: &String| parameters.get(name).map_or_else(not_set, raw_value);
    GetParametersResponse {
        values: each(&request.names, value, |_| not_set()),
    }
}

/// `~/get_parameter_types`
pub(super) fn types(request: &GetParameterTypesRequest) -> GetParameterTypesResponse {
    let type_of = |name: &String| {
        Parameter::named(name).map_or(raw::ParameterType::NOT_SET, |it| type_code(it.kind()))
    };
    GetParameterTypesResponse {
        values: each(&request.names, type_of, |_| raw::ParameterType::NOT_SET),
    }
}

/// `~/describe_parameters`: an unknown name has an empty description, as in rclpy.
pub(super) fn describe(request: &DescribeParametersRequest) -> DescribeParametersResponse {
    let described = |name: &String| Parameter::named(name).map_or_else(no_descriptor, descriptor);
    DescribeParametersResponse {
        values: each(&request.names, described, |description| {
            raw::ParameterDescriptor {
                description,
                ..no_descriptor()
            }
        }),
    }
}

/// One answer for each that is asked for, as the services promise: with `answer` up to the bound, behind it with `refuse`,
/// which is given the reason: once in words, so that the reply does not grow beyond the request, then empty.
fn each<T, A>(asked: &[T], answer: impl Fn(&T) -> A, refuse: impl Fn(String) -> A) -> Vec<A> {
    let (answered, refused) = asked.split_at(asked.len().min(MAX_PARAMETERS_PER_REQUEST));
    let refusals = (0..refused.len()).map(|index| {
        refuse(match index {
            0 => too_many(asked.len()),
            _ => String::new(),
        })
    });
    answered.iter().map(answer).chain(refusals).collect()
}

fn too_many(count: usize) -> String {
    format!(
        "expected at most {MAX_PARAMETERS_PER_REQUEST} parameters in one request, found {count}; send several requests"
    )
}

/// `~/list_parameters`, as rclcpp answers it: with no prefix all names of less than `depth` dots (0: of any number), with
/// prefixes those that are one, or lie below one with less than `depth` dots behind it, the first one counted.
pub(super) fn list(request: &ListParametersRequest) -> ListParametersResponse {
    let within = |dots: usize| request.depth == 0 || (dots as u64) < request.depth;
    let below = |name: &str, prefix: &String| {
        name == prefix
            || name
                .strip_prefix(prefix.as_str())
                .and_then(|rest| rest.strip_prefix('.'))
                .is_some_and(|rest| within(rest.matches('.').count() + 1))
    };
    let mut names: Vec<String> = PARAMETERS
        .iter()
        .map(|parameter| parameter.name)
        .filter(|name| match request.prefixes.is_empty() {
            true => within(name.matches('.').count()),
            false => request.prefixes.iter().any(|prefix| below(name, prefix)),
        })
        .map(str::to_owned)
        .collect();
    names.sort();
    let prefixes: BTreeSet<String> = names
        .iter()
        .filter_map(|name| name.rsplit_once('.'))
        .map(|(group, _)| group.to_owned())
        .collect();
    ListParametersResponse {
        result: ListParametersResult {
            names,
            prefixes: prefixes.into_iter().collect(),
        },
    }
}

/// `~/set_parameters`: one by one, each with its own result.
pub(super) fn set(twin: &LiveTwin, request: SetParametersRequest) -> SetParametersResponse {
    let set_one = |it: &raw::Parameter| result(set_all(twin, vec![it.clone()]));
    SetParametersResponse {
        results: each(&request.parameter, set_one, |reason| result(Err(reason))),
    }
}

/// `~/set_parameters_atomically`: all or none, valid as a whole.
pub(super) fn set_atomically(
    twin: &LiveTwin,
    request: SetParametersRequest,
) -> SetParametersAtomicallyResponse {
    let outcome = if request.parameter.len() > MAX_PARAMETERS_PER_REQUEST {
        Err(too_many(request.parameter.len()))
    } else {
        set_all(twin, request.parameter)
    };
    SetParametersAtomicallyResponse {
        result: result(outcome),
    }
}

fn set_all(twin: &LiveTwin, parameters: Vec<raw::Parameter>) -> Result<(), String> {
    const SOURCE: &str = "parameter service";
    let values: Result<Vec<_>, Refusal> = parameters
        .into_iter()
        .map(|parameter| Ok((parameter.name.clone(), settable_value(parameter)?)))
        .collect();
    let source = SOURCE.into();
    let command = match values {
        Ok(changes) => Command::SetParameters { changes, source },
        Err(refusal) => Command::RejectedChange { refusal, source },
    };
    match twin.execute(command) {
        Ok(_) => Ok(()),
        Err(refusal) => Err(refusal.tagged()),
    }
}

/// The value, if a running node lets anybody set it.
fn settable_value(parameter: raw::Parameter) -> Result<Value, Refusal> {
    let raw::Parameter { name, value } = parameter;
    let found = match value.ptype {
        raw::ParameterType::BOOL => Some(Value::Bool(value.boolean_value)),
        raw::ParameterType::INTEGER => Some(Value::Integer(value.int_value)),
        raw::ParameterType::DOUBLE => Some(Value::Double(value.double_value)),
        raw::ParameterType::STRING => Some(Value::String(value.string_value)),
        _ => None,
    };
    let Some(known) = Parameter::named(&name) else {
        // The twin says which name may have been meant.
        return Ok(found.unwrap_or(Value::Bool(false)));
    };
    if known.read_only() {
        let reason = format!(
            "{name} is read-only while the node runs; give it when the node starts (-p {name}:=...)"
        );
        return Err(Refusal::new(RefusalCode::ParametersReadOnly, reason));
    }
    found.ok_or_else(|| {
        let problem = match value.ptype {
            raw::ParameterType::NOT_SET => "cannot be undeclared",
            _ => "is a list",
        };
        let reason = format!("{name} {problem}; allowed: {}", known.expectation());
        Refusal::new(RefusalCode::ParametersInvalid, reason)
    })
}

fn result(outcome: Result<(), String>) -> raw::SetParametersResult {
    raw::SetParametersResult {
        successful: outcome.is_ok(),
        reason: outcome.err().unwrap_or_default(),
    }
}

/// What to publish on `/parameter_events` when `now` hold instead of `before`; at the start `before` is nothing, and all
/// are new.
pub(super) fn event(
    node: String,
    stamp: i64,
    before: Option<&Parameters>,
    now: &Parameters,
) -> Option<raw::ParameterEvent> {
    let (new, changed) = match before {
        None => (now.iter().map(entry).collect(), vec![]),
        Some(before) => {
            let changed = now.changed_from(before).into_iter();
            let value = |it: &'static Parameter| Some(entry((it, now.get(it.name)?)));
            (vec![], changed.filter_map(value).collect())
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

fn entry((parameter, value): (&'static Parameter, Value)) -> raw::Parameter {
    raw::Parameter {
        name: parameter.name.to_owned(),
        value: raw_value(value),
    }
}

fn descriptor(parameter: &'static Parameter) -> raw::ParameterDescriptor {
    let mut it = no_descriptor();
    it.name = parameter.name.to_owned();
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
    match parameter.admissible {
        Admissible::Integer { min, max } => it.integer_range.push(raw::IntegerRange {
            from_value: min,
            to_value: max,
            // 0 would forbid all values between the two ends.
            step: 1,
        }),
        Admissible::Real { min, max } | Admissible::WholeNanoseconds { min, max } => {
            it.floating_point_range.push(reals(min, max));
        }
        // A range has no hole: the constraint in words says the rest.
        Admissible::RealOrZero { max, .. } => it.floating_point_range.push(reals(0.0, max)),
        Admissible::Switch
        | Admissible::Choice(_)
        | Admissible::Text { .. }
        | Admissible::SectionName
        | Admissible::SteelGrade
        | Admissible::Processors => {}
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
    }
}

fn raw_value(value: Value) -> raw::ParameterValue {
    let mut raw = not_set();
    raw.ptype = type_code(value.kind());
    match value {
        Value::Bool(value) => raw.boolean_value = value,
        Value::Integer(value) => raw.int_value = value,
        Value::Double(value) => raw.double_value = value,
        Value::String(value) => raw.string_value = value,
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

    fn names(prefixes: &[&str], depth: u64) -> Vec<String> {
        let prefixes = prefixes.iter().map(|it| (*it).to_owned()).collect();
        list(&ListParametersRequest { prefixes, depth })
            .result
            .names
    }

    #[test]
    fn lists_as_rclcpp_does() {
        assert_eq!(names(&[], 0).len(), PARAMETERS.len());
        assert!(names(&[], 1).iter().all(|name| !name.contains('.')));
        assert_eq!(names(&[], 2).len(), PARAMETERS.len());
        assert!(names(&["top"], 0).contains(&"top.load".to_owned()));
        // The dot behind the prefix counts too.
        assert!(names(&["top"], 1).is_empty());
        assert_eq!(names(&["top"], 2), names(&["top"], 0));
        assert_eq!(names(&["column_id", "nothing"], 0), ["column_id"]);
        let all = list(&ListParametersRequest {
            prefixes: vec![],
            depth: 0,
        });
        assert!(all.result.prefixes.contains(&"geometry".to_owned()));
    }

    #[test]
    fn every_parameter_has_a_description_and_its_default_lies_in_its_range() {
        let request = DescribeParametersRequest {
            names: PARAMETERS.iter().map(|it| it.name.to_owned()).collect(),
        };
        let descriptors = describe(&request).values;
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
                ([], value) => assert!(!matches!(value, Value::Double(_)), "{}", parameter.name),
                _ => panic!("{} has a range and is no number", parameter.name),
            }
        }
        let unknown = describe(&DescribeParametersRequest {
            names: vec!["x".to_owned()],
        });
        assert_eq!(unknown.values[0].name, "");
    }

    #[test]
    fn what_is_too_much_is_answered_as_such() {
        let many = MAX_PARAMETERS_PER_REQUEST + 2;
        let names = vec!["top.load".to_owned(); many];
        let parameters = Parameters::default();
        let values = get(
            &parameters,
            &GetParametersRequest {
                names: names.clone(),
            },
        )
        .values;
        assert_eq!(values.len(), many);
        let types = types(&GetParameterTypesRequest {
            names: names.clone(),
        })
        .values;
        assert_eq!(
            types[many - 3..],
            [
                raw::ParameterType::DOUBLE,
                raw::ParameterType::NOT_SET,
                raw::ParameterType::NOT_SET
            ]
        );
        let descriptors = describe(&DescribeParametersRequest { names }).values;
        assert_eq!(descriptors.len(), many);
        assert_eq!(descriptors[many - 3].name, "top.load");
        assert_eq!(descriptors[many - 1].description, "");
        assert_eq!(
            descriptors[many - 2].description,
            "expected at most 1024 parameters in one request, found 1026; send several requests"
        );
    }

    #[test]
    fn values_go_out_with_their_types() {
        let request = GetParametersRequest {
            names: ["column_id", "top.load", "viewer.port", "use_sim_time", "x"]
                .map(str::to_owned)
                .to_vec(),
        };
        let types: Vec<_> = get(&Parameters::default(), &request)
            .values
            .iter()
            .map(|value| value.ptype)
            .collect();
        assert_eq!(types, [4, 3, 2, 1, 0]);
        let same = super::types(&GetParameterTypesRequest {
            names: request.names,
        });
        assert_eq!(same.values, types);
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_the_reason() {
        let given = |name: &str, value: raw::ParameterValue| {
            settable_value(raw::Parameter {
                name: name.to_owned(),
                value,
            })
        };
        let reason = given("column_id", raw_value(Value::from("x"))).expect_err("read-only");
        assert!(
            reason.starts_with("column_id is read-only while the node runs"),
            "{reason}"
        );
        let reason = given("top.load", not_set()).expect_err("undeclared");
        assert!(
            reason.starts_with("top.load cannot be undeclared"),
            "{reason}"
        );
        let list = raw::ParameterValue {
            ptype: raw::ParameterType::DOUBLE_ARRAY,
            ..not_set()
        };
        let reason = given("top.load", list).expect_err("a list");
        assert_eq!(reason, "top.load is a list; allowed: 0 to 1e9 N");
        assert_eq!(
            given("top.load", raw_value(Value::Integer(3))),
            Ok(Value::Integer(3))
        );
    }

    #[test]
    fn events_name_what_is_new_and_what_has_changed() {
        let before = Parameters::default();
        let now = before.with_changes([("top.load", 1e5)].map(|(n, v)| (n, Value::Double(v))));
        let now = now.expect("a valid change");
        let first = event("/n".to_owned(), 5, None, &before).expect("all are new");
        assert_eq!(first.new_parameters.len(), PARAMETERS.len());
        let change = event("/n".to_owned(), 5, Some(&before), &now).expect("one has changed");
        assert_eq!(change.changed_parameters[0].name, "top.load");
        assert_eq!(change.changed_parameters.len(), 1);
        assert!(event("/n".to_owned(), 5, Some(&now), &now).is_none());
    }
}
