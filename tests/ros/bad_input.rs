//! What others send by mistake or on purpose: counted, said, and the node goes on.

use std::time::Instant;

use column_twin::messages::column_twin::ImpactEvent;
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::messages::std_msgs;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{Names, Node};
use serde::Serialize;

use super::domain::Domain;
use super::loopback::{Incoming, PATIENCE, start};

/// Begins as an event does, and then announces a string of 1 GiB that is not there.
#[derive(Debug, Serialize)]
struct Announcement {
    sec: i32,
    nanosec: u32,
    frame_id_length: u32,
}

/// The node's count of messages that it could not read, as its diagnostics say it.
fn unreadable(array: &DiagnosticArray) -> u64 {
    let values = array.status.iter().flat_map(|status| &status.values);
    let mut counts = values.filter(|value| value.key == "unreadable messages");
    counts
        .next()
        .map_or(0, |value| value.value.parse().unwrap())
}

#[test]
fn what_cannot_be_read_is_counted_and_the_node_goes_on() {
    let domain = Domain::fresh();
    let twin = start(&domain);
    let names = Names::new("/", "vandal", &[]).unwrap();
    let mut node = Node::new(&domain.environment, names).unwrap();
    let truncated = node
        .publisher::<std_msgs::String>(&qos::IMPACT_EVENT)
        .unwrap();
    let huge = node.publisher::<Announcement>(&qos::IMPACT_EVENT).unwrap();
    let good = node.publisher::<ImpactEvent>(&qos::IMPACT_EVENT).unwrap();
    let other_type = Endpoint {
        type_name: "std_msgs/msg/String",
        name: "impact_event",
        ..qos::IMPACT_EVENT
    };
    let wrong_type = node.publisher::<std_msgs::String>(&other_type).unwrap();
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let deadline = Instant::now() + PATIENCE;
    for guid in [truncated.guid(), huge.guid(), good.guid()] {
        assert!(node.matches().wait_for(guid, 1, deadline));
    }
    truncated
        .publish(std_msgs::String {
            data: "x".to_owned(),
        })
        .unwrap();
    huge.publish(Announcement {
        sec: 1,
        nanosec: 2,
        frame_id_length: 1 << 30,
    })
    .unwrap();
    wrong_type
        .publish(std_msgs::String {
            data: "x".to_owned(),
        })
        .unwrap();
    let event = ImpactEvent {
        mass: 1500.0,
        velocity: 1.0,
        ..ImpactEvent::default()
    };
    good.publish(event).unwrap();
    let (mut counted, mut responded) = (0, false);
    while counted < 2 || !responded {
        let array = diagnostics.next();
        counted = unreadable(&array);
        let values = array.status.iter().flat_map(|status| &status.values);
        responded |= values
            .clone()
            .any(|it| it.key == "events accepted" && it.value == "1");
    }
    println!("{counted} messages were unreadable");
    drop(diagnostics);
    twin.stop(|| {});
}
