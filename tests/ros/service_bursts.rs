//! Many requests at once: each is answered, or counted.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{PredictImpactRequest, PredictImpactResponse};
use column_twin::messages::std_msgs;
use column_twin::ros::qos::{self, Endpoint};
use ros2_client::rcl_interfaces::{GetParametersRequest, GetParametersResponse};
use ros2_client::{Client, Message};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::live_twin::RunningTwin;
use super::transport::Sender;

/// The same service, as another node calls it.
fn called(endpoint: &Endpoint, name: &'static str) -> Endpoint {
    Endpoint { name, ..*endpoint }
}

/// Sends so many requests without a pause; returns how many of them are answered.
fn answered<Request, Response>(
    client: &Client<Request, Response>,
    request: &Request,
    count: usize,
) -> usize
where
    Request: Message + Clone + 'static,
    Response: Message + 'static,
{
    // A request or an answer that comes before its reader is known is lost.
    let deadline = Instant::now() + PATIENCE;
    while !matches!(client.receive_response(), Ok(Some(_))) {
        assert!(Instant::now() < deadline, "no answer");
        client.send_request(request.clone()).unwrap();
        std::thread::park_timeout(Duration::from_millis(200));
    }
    std::thread::park_timeout(Duration::from_millis(500));
    while let Ok(Some(_)) = client.receive_response() {}
    let mut open: BTreeSet<_> = (0..count)
        .map(|_| client.send_request(request.clone()).unwrap())
        .collect();
    let deadline = Instant::now() + PATIENCE;
    while !open.is_empty() && Instant::now() < deadline {
        match client.receive_response() {
            Ok(Some((id, _))) => {
                open.remove(&id);
            }
            _ => std::thread::park_timeout(Duration::from_millis(5)),
        }
    }
    count - open.len()
}

/// 74 of 200 were answered, and `/diagnostics` said "nothing lost".
#[test]
fn two_hundred_predictions_at_once_are_all_answered() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let endpoint = called(&qos::PREDICT, "/column_twin/predict");
    let client = node
        .client::<PredictImpactRequest, PredictImpactResponse>(&endpoint)
        .unwrap();
    let request = PredictImpactRequest {
        mass: 1500.0,
        velocity: 2.0,
        gap: f64::NAN,
        restitution: f64::NAN,
        height: f64::NAN,
        ..PredictImpactRequest::default()
    };
    assert_eq!(answered(&client, &request, 200), 200);
    twin.stop();
}

/// 592 of 1000 were answered; a node with rclpy answers all.
#[test]
fn a_thousand_requests_for_parameters_at_once_are_all_answered() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let endpoint = called(&qos::GET_PARAMETERS, "/column_twin/get_parameters");
    let client = node
        .client::<GetParametersRequest, GetParametersResponse>(&endpoint)
        .unwrap();
    let names = vec!["top.load".to_owned()];
    assert_eq!(
        answered(&client, &GetParametersRequest { names }, 1000),
        1000
    );
    twin.stop();
}

/// A deep history takes bursts of short requests, but not gigabytes.
#[test]
fn a_reader_that_takes_nothing_keeps_at_most_64_mebibytes() {
    const LENGTH: usize = 2 << 20;
    const SENT: usize = 48;
    let deep = Endpoint {
        name: "long_texts",
        type_name: "std_msgs/msg/String",
        direction: qos::Direction::Out,
        ..qos::PREDICT
    };
    let domain = Domain::fresh();
    let sender = Sender::<std_msgs::String>::start(&domain, &deep);
    let mut node = reader(&domain);
    let subscription = node.subscription::<std_msgs::String>(&deep).unwrap();
    // Another reader tells what has arrived. That of another participant may be ahead on a busy machine, where fragments are lost
    // and sent again; readers of one participant share the samples.
    let arrived = Incoming::<std_msgs::String>::start(&mut node, &deep);
    sender.wait_for_readers(2);
    for number in 0..SENT {
        let data = format!("{number}{}", " ".repeat(LENGTH));
        sender.publisher.publish(std_msgs::String { data }).unwrap();
        arrived.next();
    }
    let deadline = Instant::now() + PATIENCE;
    let mut taken = Vec::new();
    let is_last = |text: &str| text.trim_end().parse() == Ok(SENT - 1);
    while !taken.last().is_some_and(|it: &String| is_last(it)) {
        assert!(Instant::now() < deadline, "the last one has not arrived");
        match subscription.take() {
            Ok(Some((message, _))) => taken.push(message.data),
            _ => std::thread::park_timeout(Duration::from_millis(5)),
        }
    }
    // One more comes before the next collection.
    let most = (64 << 20) / LENGTH + 1;
    assert!(taken.len() <= most, "{} of {SENT}", taken.len());
    drop(arrived);
}
