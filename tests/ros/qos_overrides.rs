//! Overrides of the quality of service, as a peer of the node meets them.

use column_twin::messages::column_twin_msgs::ColumnState;
use column_twin::messages::rcl_interfaces::ParameterEvent;
use column_twin::ros::qos::{self, Endpoint, Qos};

use super::domain::Domain;
use super::live_twin::RunningTwin;
use super::loopback::{Incoming, reader};
use super::program::Program;

/// DDS matches a reader that asks for earlier messages only with a writer that keeps them.
#[test]
fn a_topic_that_was_made_transient_local_matches_a_reader_that_asks_for_it() {
    let domain = Domain::fresh();
    let name = "qos_overrides./column_state.publisher.durability";
    let mut node = reader(&domain);
    let events = Incoming::<ParameterEvent>::early(&mut node, &qos::PARAMETER_EVENTS);
    let twin = RunningTwin::start(&domain, &[(name, "transient_local".into())]);
    let wanted = Endpoint {
        qos: Qos {
            transient_local: true,
            ..qos::COLUMN_STATE.qos
        },
        ..qos::COLUMN_STATE
    };
    // It waits until it is matched.
    drop(Incoming::<ColumnState>::start(&mut node, &wanted));
    let announced = events.next().new_parameters;
    let found = announced.iter().find(|it| it.name == name);
    let value = found.map(|it| it.value.string_value.as_str());
    assert_eq!(value, Some("transient_local"));
    twin.stop();
}

#[test]
fn an_override_of_a_topic_that_the_node_does_not_have_is_an_error_at_the_start() {
    let (domain, folder) = (Domain::fresh(), tempfile::tempdir().unwrap());
    let arguments = ["-p", "qos_overrides./impact_result.publisher.depth:=3"];
    let (status, log) = Program::start(&domain, folder.path(), &arguments).end();
    assert_eq!(status.code(), Some(2), "{log:#?}");
    let is_told = |text: &str| log.iter().any(|line| line.contains(text));
    assert!(
        is_told("impact_result") && is_told("/impact_report"),
        "{log:#?}"
    );
}
