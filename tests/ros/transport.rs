//! The transport: what late joiners get, where sockets listen, how much memory a long run takes.

use std::time::{Duration, Instant};

use column_twin::endpoints::Qos;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{ImpactReport, TwinStatus};
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{Node, Publisher};
use futures::future::{AbortHandle, Abortable};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};

/// More than any depth that the table offers.
pub const MANY: i32 = 500;

/// Time in which nothing more comes.
const QUIET: Duration = Duration::from_millis(500);

/// A publisher in a node of its own, whose events are followed.
pub struct Sender<M: Serialize> {
    pub publisher: Publisher<M>,
    abort: AbortHandle,
    node: Node,
}

impl<M: Serialize> Sender<M> {
    pub fn start(domain: &Domain, endpoint: &Endpoint) -> Self {
        let mut node = reader(domain);
        let publisher = node.publisher::<M>(endpoint).unwrap();
        let (abort, registration) = AbortHandle::new_pair();
        let events = Abortable::new(node.participant_events(), registration);
        std::thread::spawn(move || futures::executor::block_on(events));
        Self {
            publisher,
            abort,
            node,
        }
    }

    /// Waits until so many readers are matched.
    pub fn wait_for_readers(&self, count: usize) {
        let deadline = Instant::now() + PATIENCE;
        let matches = self.node.matches();
        assert!(matches.wait_for(self.publisher.guid(), count, deadline));
    }
}

impl<M: Serialize> Drop for Sender<M> {
    fn drop(&mut self) {
        self.abort.abort();
    }
}

pub fn status(number: i32) -> TwinStatus {
    let mut status = TwinStatus::default();
    status.header.stamp = Time {
        sec: number,
        nanosec: 0,
    };
    status
}

pub fn report(number: i32) -> ImpactReport {
    let mut report = ImpactReport::default();
    report.header.stamp = Time {
        sec: number,
        nanosec: 0,
    };
    report
}

/// What a reader that joins now gets of the past.
fn past<M: DeserializeOwned + Send + 'static>(domain: &Domain, endpoint: &Endpoint) -> Vec<M> {
    let mut node = reader(domain);
    let incoming = Incoming::<M>::start(&mut node, endpoint);
    let mut got = vec![incoming.next()];
    while let Ok(message) = incoming.messages.recv_timeout(QUIET) {
        got.push(message);
    }
    got
}

fn seconds(reports: &[ImpactReport]) -> Vec<i32> {
    reports.iter().map(|it| it.header.stamp.sec).collect()
}

/// RustDDS 0.15.1 kept every sample that was ever written: a late joiner got 8352 statuses where one is offered.
#[test]
fn a_late_joiner_gets_one_status_and_not_all_that_were_ever_sent() {
    let domain = Domain::fresh();
    let sender = Sender::start(&domain, &qos::TWIN_STATUS);
    for number in 1..=MANY {
        sender.publisher.publish(status(number)).unwrap();
    }
    let got = past::<TwinStatus>(&domain, &qos::TWIN_STATUS);
    let stamps: Vec<_> = got.iter().map(|it| it.header.stamp.sec).collect();
    assert_eq!(stamps, [MANY]);
}

#[test]
fn a_late_joiner_gets_ten_forecasts_also_when_another_reader_is_there() {
    let domain = Domain::fresh();
    let sender = Sender::start(&domain, &qos::IMPACT_FORECAST);
    let deep = Endpoint {
        qos: Qos {
            depth: 1000,
            ..qos::IMPACT_FORECAST.qos
        },
        ..qos::IMPACT_FORECAST
    };
    let mut node = reader(&domain);
    let first = Incoming::<ImpactReport>::early(&mut node, &deep);
    sender.wait_for_readers(1);
    for number in 1..=MANY {
        sender.publisher.publish(report(number)).unwrap();
    }
    for number in 1..=MANY {
        assert_eq!(first.next().header.stamp.sec, number, "nothing is lost");
    }
    let got = past::<ImpactReport>(&domain, &qos::IMPACT_FORECAST);
    assert_eq!(seconds(&got), Vec::from_iter(MANY - 9..=MANY));
}

/// A best-effort reader never acknowledges anything.
#[test]
fn a_late_joiner_gets_ten_forecasts_also_when_a_best_effort_reader_is_there() {
    let domain = Domain::fresh();
    let sender = Sender::start(&domain, &qos::IMPACT_FORECAST);
    let best_effort = Endpoint {
        qos: Qos {
            reliable: false,
            transient_local: false,
            ..qos::IMPACT_FORECAST.qos
        },
        ..qos::IMPACT_FORECAST
    };
    let mut node = reader(&domain);
    let first = Incoming::<ImpactReport>::early(&mut node, &best_effort);
    sender.wait_for_readers(1);
    for number in 1..=MANY {
        sender.publisher.publish(report(number)).unwrap();
    }
    let got = past::<ImpactReport>(&domain, &qos::IMPACT_FORECAST);
    assert_eq!(seconds(&got), Vec::from_iter(MANY - 9..=MANY));
    drop(first);
}

/// RustDDS 0.15.1 announced itself to the first twelve participants of a host alone, and loopback has no multicast.
#[test]
fn the_fifteenth_and_the_sixteenth_participant_of_a_machine_find_each_other() {
    let domain = Domain::fresh();
    let others: Vec<_> = (0..14).map(|_| reader(&domain)).collect();
    let sender = Sender::start(&domain, &qos::TWIN_STATUS);
    sender.publisher.publish(status(1)).unwrap();
    let got = past::<TwinStatus>(&domain, &qos::TWIN_STATUS);
    assert_eq!(got.len(), 1);
    drop(others);
}
