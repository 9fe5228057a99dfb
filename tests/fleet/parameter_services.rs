//! The parameters of the columns of a fleet over the services behind `ros2 param`.

use column_twin::messages::cdr;
use column_twin::messages::rcl_interfaces::ParameterEvent;
use column_twin::ros::qos::{self, Endpoint};
use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse,
};

use super::domain::Domain;
use super::incoming::{Incoming, reader};
use super::node::{Running, call};

fn of_node(name: &'static str, endpoint: Endpoint) -> Endpoint {
    Endpoint { name, ..endpoint }
}

fn get(domain: &Domain, names: &[&str]) -> Vec<raw::ParameterValue> {
    let endpoint = of_node("/column_twin/get_parameters", qos::GET_PARAMETERS);
    let names = names.iter().map(|it| (*it).to_owned()).collect();
    let answer: GetParametersResponse = call(domain, endpoint, &GetParametersRequest { names });
    answer.values
}

fn list(domain: &Domain, prefixes: &[&str]) -> (Vec<String>, Vec<String>) {
    let endpoint = of_node("/column_twin/list_parameters", qos::LIST_PARAMETERS);
    let prefixes = prefixes.iter().map(|it| (*it).to_owned()).collect();
    let request = ListParametersRequest { prefixes, depth: 0 };
    let answer: ListParametersResponse = call(domain, endpoint, &request);
    (answer.result.names, answer.result.prefixes)
}

/// A double; NaN stands for the value "not set".
fn double(name: &str, value: f64) -> raw::Parameter {
    let is_set = !value.is_nan();
    raw::Parameter {
        name: name.to_owned(),
        value: raw::ParameterValue {
            ptype: if is_set {
                raw::ParameterType::DOUBLE
            } else {
                0
            },
            boolean_value: false,
            int_value: 0,
            double_value: value,
            string_value: String::new(),
            byte_array: vec![],
            bool_array: vec![],
            int_array: vec![],
            double_array: vec![],
            string_array: vec![],
        },
    }
}

fn set(domain: &Domain, parameters: Vec<raw::Parameter>) -> Vec<(bool, String)> {
    let endpoint = of_node("/column_twin/set_parameters", qos::SET_PARAMETERS);
    let request = SetParametersRequest {
        parameter: parameters,
    };
    let answer: SetParametersResponse = call(domain, endpoint, &request);
    let results = answer.results.into_iter();
    results.map(|it| (it.successful, it.reason)).collect()
}

fn set_atomically(domain: &Domain, parameters: Vec<raw::Parameter>) -> (bool, String) {
    let name = "/column_twin/set_parameters_atomically";
    let request = SetParametersRequest {
        parameter: parameters,
    };
    let endpoint = of_node(name, qos::SET_PARAMETERS_ATOMICALLY);
    let answer: SetParametersAtomicallyResponse = call(domain, endpoint, &request);
    (answer.result.successful, answer.result.reason)
}

#[test]
fn parameters_of_columns_have_the_name_of_the_column_before_theirs() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 3);
    let (names, prefixes) = list(&domain, &[]);
    for name in ["c0.top.load", "c2.solver.dt", "use_sim_time", "record.mode"] {
        assert!(names.iter().any(|it| it == name), "{name}: {names:?}");
    }
    assert!(
        !names
            .iter()
            .any(|it| it == "top.load" || it == "c0.record.mode")
    );
    assert!(prefixes.iter().any(|it| it == "c1.top") && prefixes.iter().any(|it| it == "c1"));
    let (names, prefixes) = list(&domain, &["c1"]);
    assert!(names.len() > 50 && names.iter().all(|it| it.starts_with("c1.")));
    assert!(
        prefixes
            .iter()
            .all(|it| it == "c1" || it.starts_with("c1."))
    );
    let (names, _) = list(&domain, &["c1.top"]);
    assert!(
        names.contains(&"c1.top.load".to_owned()) && names.len() < 10,
        "{names:?}"
    );

    let some = [
        "c1.top.load",
        "c9.top.load",
        "top.load",
        "use_sim_time",
        "c1.use_sim_time",
    ];
    let types: Vec<_> = get(&domain, &some).iter().map(|it| it.ptype).collect();
    assert_eq!(types, [3, 0, 0, 1, 0]);
    let request = GetParameterTypesRequest {
        names: some.map(str::to_owned).to_vec(),
    };
    let endpoint = of_node("/column_twin/get_parameter_types", qos::GET_PARAMETER_TYPES);
    let same: GetParameterTypesResponse = call(&domain, endpoint, &request);
    assert_eq!(same.values, types);
    let endpoint = of_node("/column_twin/describe_parameters", qos::DESCRIBE_PARAMETERS);
    let request = DescribeParametersRequest {
        names: some.map(str::to_owned).to_vec(),
    };
    let described: DescribeParametersResponse = call(&domain, endpoint, &request);
    let described: Vec<_> = described
        .values
        .iter()
        .map(|it| {
            (
                it.name.as_str(),
                it.read_only,
                it.floating_point_range.len(),
            )
        })
        .collect();
    let expected = [
        ("c1.top.load", false, 1),
        ("", false, 0),
        ("", false, 0),
        ("use_sim_time", true, 0),
        ("", false, 0),
    ];
    assert_eq!(described, expected);
    running.node.stop();
}

#[test]
fn a_column_takes_its_parameters_as_a_whole() {
    let domain = Domain::fresh();
    let running = Running::start(&domain, 2);
    let mut node = reader(&domain);
    let events = Incoming::<ParameterEvent>::start(&mut node, &qos::PARAMETER_EVENTS);
    let load = |column: u32| running.fleet.parameters(column).get("top.load");
    let before = load(0);

    let results = set(
        &domain,
        vec![
            double("c1.top.load", 3.0e5),
            double("c1.top.load", -1.0),
            double("c1.top.laod", 1.0),
            double("c7.top.load", 3.0e5),
            double("top.load", 3.0e5),
            double("c1.solver.dt", f64::NAN),
        ],
    );
    assert_eq!(results[0], (true, String::new()));
    let reasons = [
        "`-1.0` is out of range; allowed: 0 to 1e9 N",
        "c1.top.laod is no parameter of this fleet of 2 columns; expected COLUMN.PARAMETER",
        "c7.top.load is no parameter of this fleet of 2 columns",
        "top.load is a parameter of every column; name the column, for example c0.top.load",
        "cannot be undeclared",
    ];
    for ((successful, reason), expected) in results[1..].iter().zip(reasons) {
        assert!(
            !successful && reason.contains(expected),
            "{expected}\n{reason}"
        );
    }
    assert_eq!((load(0), load(1)), (before, Some(3.0e5.into())));
    assert_eq!(get(&domain, &["c1.top.load"])[0].double_value, 3.0e5);
    let event = events.find("the change", |it| !it.changed_parameters.is_empty());
    assert_eq!(event.changed_parameters[0].name, "c1.top.load");

    let (successful, reason) = set_atomically(
        &domain,
        vec![double("c0.top.load", 1.0e5), double("c1.top.load", 1.0e5)],
    );
    assert!(
        !successful && reason.contains("expected parameters of one column"),
        "{reason}"
    );
    let (successful, reason) = set_atomically(
        &domain,
        vec![
            double("c1.top.load", 1.0e5),
            double("c1.geometry.length_below", 1e9),
        ],
    );
    assert!(!successful && reason.contains("column \"c1\""), "{reason}");
    assert_eq!(load(1), Some(3.0e5.into()));
    let both = vec![
        double("c1.top.load", 1.0e5),
        double("c1.geometry.length_below", 1.25),
    ];
    assert_eq!(set_atomically(&domain, both), (true, String::new()));
    assert_eq!(load(1), Some(1.0e5.into()));

    let mut clock = double("use_sim_time", 0.0);
    clock.value.ptype = raw::ParameterType::BOOL;
    assert_eq!(set(&domain, vec![clock.clone()]), [(true, String::new())]);
    clock.value.boolean_value = true;
    let results = set(&domain, vec![clock]);
    assert!(
        !results[0].0 && results[0].1.contains("read-only"),
        "{results:?}"
    );
    drop(events);
    running.node.stop();
}

/// Only a single twin announced its parameters.
#[test]
fn a_fleet_announces_the_parameters_of_its_node_and_of_each_column() {
    let domain = Domain::fresh();
    let mut node = reader(&domain);
    let events = Incoming::<ParameterEvent>::early(&mut node, &qos::PARAMETER_EVENTS);
    let running = Running::start(&domain, 3);
    let mut announced = Vec::new();
    for prefix in ["", "c0.", "c1.", "c2."] {
        let event = events.next();
        assert_eq!(event.node, "/column_twin");
        assert!(event.changed_parameters.is_empty() && event.deleted_parameters.is_empty());
        let bytes = cdr::encode(&event).unwrap().len();
        println!("{bytes} bytes of {:?}", event.new_parameters[0].name);
        let names = event.new_parameters.into_iter().map(|it| it.name);
        let names: Vec<_> = names.collect();
        assert!(names.iter().all(|it| it.starts_with(prefix)), "{names:?}");
        announced.extend(names);
    }
    announced.sort();
    assert_eq!(announced, list(&domain, &[]).0);
    drop(events);
    running.node.stop();
}
