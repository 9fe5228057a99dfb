//! The six services behind `ros2 param` of a fleet: `a3.top.load` is the parameter `top.load` of column `a3`. The parameters that
//! belong to the node keep their names, and are read-only.

use std::collections::BTreeSet;
use std::sync::Arc;

use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};

use crate::parameters::{Parameters, is_of_the_fleet};
use crate::twin::{Accepted, Command, Refusal, RefusalCode};

use super::super::parameter_services::{
    Configurable, MAX_PARAMETERS_PER_REQUEST, descriptor, each, is_listed, no_descriptor, not_set,
    raw_value, result, set_all, settable_value, too_many, type_code,
};
use super::live_fleet::FleetTwin;

/// Most names in one list, so that it fits into a message: the prefixes name the columns whose parameters are left out.
const MAX_LISTED: usize = 8192;

/// Where a parameter is.
struct Place<'a> {
    /// Index and identifier of its column; `None` if it belongs to the node.
    column: Option<(u32, &'a str)>,
    /// Its name there.
    name: &'a str,
    parameters: Arc<Parameters>,
}

/// Finds a parameter by its name; `None` if there is none. An identifier may contain dots, so that the longest one wins.
fn place<'a>(fleet: &FleetTwin, full_name: &'a str) -> Option<Place<'a>> {
    let in_column = full_name.rmatch_indices('.').find_map(|(dot, _)| {
        let (column_id, name) = (&full_name[..dot], &full_name[dot + 1..]);
        let column = fleet.index_of(column_id)?;
        let parameters = fleet.parameters(column);
        let is_known = !is_of_the_fleet(name) && parameters.declared(name).is_some();
        is_known.then_some(Place {
            column: Some((column, column_id)),
            name,
            parameters,
        })
    });
    let in_node = || {
        let parameters = fleet.node_parameters();
        let is_known = is_of_the_fleet(full_name) && parameters.declared(full_name).is_some();
        is_known.then(|| Place {
            column: None,
            name: full_name,
            parameters: Arc::clone(parameters),
        })
    };
    in_column.or_else(in_node)
}

/// `~/get_parameters`
pub(super) fn get(fleet: &FleetTwin, request: &GetParametersRequest) -> GetParametersResponse {
    let value = |name: &String| {
        let value = place(fleet, name).and_then(|it| it.parameters.get(it.name));
        value.map_or_else(not_set, raw_value)
    };
    GetParametersResponse {
        values: each(&request.names, value, |_| not_set()),
    }
}

/// `~/get_parameter_types`
pub(super) fn types(
    fleet: &FleetTwin,
    request: &GetParameterTypesRequest,
) -> GetParameterTypesResponse {
    let type_of = |name: &String| {
        let place = place(fleet, name);
        let declared = place
            .as_ref()
            .and_then(|it| it.parameters.declared(it.name));
        declared.map_or(raw::ParameterType::NOT_SET, |it| type_code(it.row.kind()))
    };
    GetParameterTypesResponse {
        values: each(&request.names, type_of, |_| raw::ParameterType::NOT_SET),
    }
}

/// `~/describe_parameters`
pub(super) fn describe(
    fleet: &FleetTwin,
    request: &DescribeParametersRequest,
) -> DescribeParametersResponse {
    let described = |name: &String| {
        let Some(place) = place(fleet, name) else {
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

/// `~/list_parameters`: names of the node and of every column, at most [`MAX_LISTED`]; the prefixes include every column that the
/// request asks for.
pub(super) fn list(fleet: &FleetTwin, request: &ListParametersRequest) -> ListParametersResponse {
    let node = fleet.node_parameters();
    let mut names: Vec<String> = node
        .all_declared()
        .map(|it| it.name)
        .filter(|name| is_of_the_fleet(name) && is_listed(name, request))
        .map(str::to_owned)
        .collect();
    let mut prefixes = BTreeSet::new();
    for (column, column_id) in (0..).zip(fleet.column_ids()) {
        let is_within = |outer: &str, inner: &str| {
            let rest = inner.strip_prefix(outer);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let is_asked_for =
            |prefix: &String| is_within(column_id, prefix) || is_within(prefix, column_id);
        if !request.prefixes.is_empty() && !request.prefixes.iter().any(is_asked_for) {
            continue;
        }
        prefixes.insert(column_id.to_string());
        if names.len() >= MAX_LISTED {
            continue;
        }
        let parameters = fleet.parameters(column);
        let own = parameters
            .all_declared()
            .filter(|it| !is_of_the_fleet(it.name));
        let own = own.map(|it| format!("{column_id}.{}", it.name));
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

/// `~/set_parameters`: one by one, each with its own result.
pub(super) fn set(fleet: &FleetTwin, request: &SetParametersRequest) -> SetParametersResponse {
    let set_one = |it: &raw::Parameter| result(set_together(fleet, vec![it.clone()]));
    SetParametersResponse {
        results: each(&request.parameter, set_one, |reason| result(Err(reason))),
    }
}

/// `~/set_parameters_atomically`: all or none of one column, validated as a whole.
pub(super) fn set_atomically(
    fleet: &FleetTwin,
    request: SetParametersRequest,
) -> SetParametersAtomicallyResponse {
    let outcome = match request.parameter.len() > MAX_PARAMETERS_PER_REQUEST {
        true => Err(too_many(request.parameter.len())),
        false => set_together(fleet, request.parameter),
    };
    SetParametersAtomicallyResponse {
        result: result(outcome),
    }
}

/// Changes parameters of one column as a whole. Parameters of the node may be among them if they keep their values, as when a dump is
/// loaded.
fn set_together(fleet: &FleetTwin, given: Vec<raw::Parameter>) -> Result<String, String> {
    let mut of: Option<(u32, String)> = None;
    let mut changes = Vec::new();
    for raw::Parameter { name, value } in given {
        let Some(found) = place(fleet, &name) else {
            return Err(unknown(fleet, &name).tagged());
        };
        let parameter = raw::Parameter {
            name: found.name.to_owned(),
            value,
        };
        let Some((column, column_id)) = found.column else {
            check_unchanged(&found.parameters, parameter).map_err(|it| it.tagged())?;
            continue;
        };
        match &of {
            Some((first, first_id)) if *first != column => {
                let reason = format!(
                    "expected parameters of one column in one request, found those of {first_id:?} and {column_id:?}; send a \
                     request for each column"
                );
                return Err(Refusal::new(RefusalCode::ParametersInvalid, reason).tagged());
            }
            Some(_) => {}
            None => of = Some((column, column_id.to_owned())),
        }
        changes.push(parameter);
    }
    let Some((column, column_id)) = of else {
        return Ok(String::new());
    };
    let column = FleetColumn { fleet, column };
    set_all(&column, changes).map_err(|reason| format!("{reason}; column {column_id:?}"))
}

/// # Errors
/// The parameter of the node would have another value.
fn check_unchanged(node: &Parameters, given: raw::Parameter) -> Result<(), Refusal> {
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
    Err(Refusal::new(RefusalCode::ParametersReadOnly, reason))
}

/// Why there is no parameter of this name.
fn unknown(fleet: &FleetTwin, name: &str) -> Refusal {
    let first = fleet.column_ids().first().map_or("COLUMN", |it| &**it);
    let is_of_columns = fleet.index_of(first).is_some_and(|column| {
        let parameters = fleet.parameters(column);
        parameters.declared(name).is_some()
    });
    let reason = match is_of_columns {
        true => format!(
            "{name} is a parameter of every column; name the column, for example {first}.{name}"
        ),
        false => format!(
            "{name} is no parameter of this fleet of {} columns; expected COLUMN.PARAMETER, for example {first}.top.load",
            fleet.column_ids().len()
        ),
    };
    Refusal::new(RefusalCode::ParametersInvalid, reason)
}

/// One column of a fleet.
struct FleetColumn<'a> {
    fleet: &'a FleetTwin,
    column: u32,
}

impl Configurable for FleetColumn<'_> {
    fn parameters(&self) -> Arc<Parameters> {
        self.fleet.parameters(self.column)
    }

    fn execute(&self, command: Command) -> Result<Accepted, Refusal> {
        self.fleet.execute(self.column, command)
    }
}
