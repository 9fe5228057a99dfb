//! `/parameter_events`: what the node announces of its parameters.

use column_twin::messages::rcl_interfaces::ParameterEvent;
use column_twin::parameters::PARAMETERS;
use column_twin::ros::qos;

use super::domain::Domain;
use super::live_twin::RunningTwin;
use super::loopback::{Incoming, reader};

/// Every node had a second publisher, that of the client library, and announced its parameters before anybody could be matched.
#[test]
fn one_publisher_announces_all_parameters_to_the_first_reader() {
    let domain = Domain::fresh();
    let mut node = reader(&domain);
    let events = Incoming::<ParameterEvent>::early(&mut node, &qos::PARAMETER_EVENTS);
    let twin = RunningTwin::start(&domain, &[]);
    let first = events.next();
    assert_eq!(first.node, "/column_twin");
    let names: Vec<_> = first
        .new_parameters
        .iter()
        .map(|it| it.name.as_str())
        .collect();
    let all: Vec<_> = PARAMETERS.iter().map(|it| it.name).collect();
    assert_eq!(names, all);
    assert!(first.changed_parameters.is_empty() && first.deleted_parameters.is_empty());
    // The publishers of a node are announced in their order, and that of the client library would be the first.
    assert_eq!(node.matches().count(events.guid), 1);
    twin.stop();
}
