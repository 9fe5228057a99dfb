//! The allow-list of senders and their rate limit, with real senders.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ImpactEvent, TwinStatus};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::messages::std_srvs::{TriggerRequest, TriggerResponse};
use column_twin::parameters::Value;
use column_twin::ros::qos::{self, Endpoint};

use super::domain::Domain;
use super::live_twin::RunningTwin;
use super::loopback::{Incoming, Outgoing, PATIENCE, event, now, reader};

/// The service of the twin, as another node calls it.
const RESET: Endpoint = Endpoint {
    name: "/column_twin/reset",
    ..qos::RESET
};

fn counted(array: &DiagnosticArray, name: &str) -> Option<u64> {
    let mut values = array.status.iter().flat_map(|status| &status.values);
    values.find(|value| value.key == name)?.value.parse().ok()
}

#[test]
fn a_sender_that_is_not_allowed_gets_nothing_through() {
    let domain = Domain::fresh();
    let mut allowed = reader(&domain);
    let publisher = allowed
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .unwrap();
    let prefix: String = publisher.guid().to_bytes()[..12]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    // An enclave is known only with DDS security.
    let list = vec![prefix, "/garage/operator".to_owned()];
    let twin = RunningTwin::start(&domain, &[("senders.allowed", Value::from(list))]);
    let statuses = Incoming::<TwinStatus>::start(&mut allowed, &qos::TWIN_STATUS);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut allowed, &qos::DIAGNOSTICS);
    let stranger = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let mut asking = reader(&domain);
    let client = asking
        .client::<TriggerRequest, TriggerResponse>(&RESET)
        .unwrap();

    assert!(stranger.publish(event("from a stranger", now(), 1500.0, 1.0)));
    diagnostics.find("the rejected event", |it| {
        counted(it, "rejected, not allowed") == Some(1)
    });
    let deadline = Instant::now() + PATIENCE;
    let answer = loop {
        assert!(Instant::now() < deadline, "~/reset does not answer");
        // A request that is sent before the service is found is lost.
        client.send_request(TriggerRequest::default()).unwrap();
        std::thread::park_timeout(Duration::from_millis(200));
        if let Ok(Some((_, answer))) = client.receive_response() {
            break answer;
        }
    };
    assert!(!answer.success);
    assert!(
        answer.message.starts_with("[sender_not_allowed] "),
        "{answer:?}"
    );
    let deadline = Instant::now() + PATIENCE;
    assert!(allowed.matches().wait_for(publisher.guid(), 1, deadline));
    publisher
        .publish(event("from a friend", now(), 1500.0, 1.0))
        .unwrap();
    let status = statuses.find("an accepted event", |it| it.events_accepted > 0);
    assert_eq!(
        (status.events_accepted, status.event_id.as_str()),
        (1, "from a friend")
    );
    assert!(status.dropped_inputs >= 2, "{status:?}");
    drop((statuses, diagnostics, stranger));
    twin.stop();
}

#[test]
fn a_sender_that_is_too_fast_is_limited() {
    let domain = Domain::fresh();
    // A further event in a quarter of an hour.
    let limits = [
        ("senders.max_rate", Value::from(1e-3)),
        ("senders.burst", Value::Integer(2)),
    ];
    let twin = RunningTwin::start(&domain, &limits);
    let mut node = reader(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    for number in 0..50 {
        assert!(events.publish(event(&number.to_string(), now(), 10.0, 0.5)));
    }
    diagnostics.find("48 rejected and 2 accepted events", |it| {
        counted(it, "rejected, too fast") == Some(48) && counted(it, "events accepted") == Some(2)
    });
    drop((diagnostics, events));
    twin.stop();
}

/// Each rejected event takes 3.7 kB of a recording: one sender at 1 kHz rotated all default recordings out in 7.5 h.
#[test]
fn by_default_a_sender_that_sends_without_end_is_limited() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let too_fast = |it: &DiagnosticArray| counted(it, "rejected, too fast");
    diagnostics.find("the counter of the limit", |it| too_fast(it) == Some(0));
    let deadline = Instant::now() + PATIENCE;
    let mut rejected = 0;
    while rejected == 0 {
        assert!(Instant::now() < deadline, "nothing is limited");
        // A writer whose window is full waits for its reader.
        while !events.publish(event("the same again and again", now(), 10.0, 0.5)) {
            std::thread::yield_now();
        }
        rejected = diagnostics
            .newest()
            .and_then(|it| too_fast(&it))
            .unwrap_or_default();
    }
    drop((diagnostics, events));
    twin.stop();
}
