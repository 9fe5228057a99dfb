//! Node and reader in Rust, on loopback.

use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use column_twin::column::ImpactSpecification;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport, TwinStatus};
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::Value;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{ImpactOptions, ImpactOutcome, ImpactRequest, Node, Publisher, send_impact};
use futures::future::{AbortHandle, Abortable};
use rustdds::GUID;
use serde::Serialize;

use super::domain::Domain;
pub use super::domain::PATIENCE;
pub use super::incoming::{Incoming, reader};
use super::live_twin::RunningTwin;

/// The time of day \[ns\].
pub fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    i64::try_from(since.as_nanos()).unwrap()
}

/// An event for the default column that leaves vehicle, gap, restitution and height open.
pub fn event(event_id: &str, stamp: i64, mass: f64, velocity: f64) -> ImpactEvent {
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap(),
            frame_id: String::new(),
        },
        column_id: "column".to_owned(),
        event_id: event_id.to_owned(),
        mass,
        velocity,
        ..ImpactEvent::default()
    }
}

/// Publishes on one topic from its own node.
pub struct Outgoing<M: Serialize> {
    publisher: Publisher<M>,
    abort: AbortHandle,
    thread: Option<JoinHandle<()>>,
    pub node: Node,
}

impl<M: Serialize> Outgoing<M> {
    /// Waits until there is a reader. The reader may know the publisher later: on a topic of best effort,
    /// [`RunningTwin::wait_for`] waits for that, too.
    pub fn start(domain: &Domain, endpoint: &Endpoint) -> Self {
        let mut node = reader(domain);
        let publisher = node.publisher::<M>(endpoint).unwrap();
        let events = node.participant_events();
        let (abort, registration) = AbortHandle::new_pair();
        let follow = move || {
            let _ = futures::executor::block_on(Abortable::new(events, registration));
        };
        let thread = Some(std::thread::spawn(follow));
        let deadline = Instant::now() + PATIENCE;
        assert!(
            node.matches().wait_for(publisher.guid(), 1, deadline),
            "nobody reads {}",
            endpoint.name
        );
        Self {
            publisher,
            abort,
            thread,
            node,
        }
    }

    pub fn guid(&self) -> GUID {
        self.publisher.guid()
    }

    /// Returns `false` if the reader was too slow for the writer's window.
    pub fn publish(&self, message: M) -> bool {
        self.publisher.publish(message).is_ok()
    }
}

impl<M: Serialize> Drop for Outgoing<M> {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

#[test]
fn a_late_joiner_gets_the_status() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    let mut node = reader(&domain);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    statuses.find("an accepted event", |it| it.events_accepted == 1);
    drop(statuses);
    twin.stop();
}

#[test]
fn an_impact_from_the_command_line_is_answered_or_rejected() {
    let domain = Domain::fresh();
    let nobody = impact(&domain, 1500.0, Duration::from_millis(300));
    assert!(
        nobody
            .unwrap_err()
            .contains("no twin subscribes to /impact_event in domain")
    );
    let twin = RunningTwin::start(&domain, &[]);
    match impact(&domain, 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(report)) => assert!(report.max_v1 > 0.0),
        other => panic!("{other:?}"),
    }
    match impact(&domain, -1.0, PATIENCE) {
        Ok(ImpactOutcome::Rejected(reason)) => {
            assert!(reason.starts_with("mass = -1: is out of range"), "{reason}");
        }
        other => panic!("{other:?}"),
    }
    twin.stop();
}

/// `column-twin impact` without `--column` finds the only twin there is, and lists several.
#[test]
fn an_impact_without_a_column_goes_to_the_only_twin() {
    let domain = Domain::fresh();
    let first = RunningTwin::start(&domain, &[("column_id", Value::from("a3"))]);
    match impact_on(&domain, None, 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(report)) => assert_eq!(report.column_id, "a3"),
        other => panic!("{other:?}"),
    }
    let second = RunningTwin::start(&domain, &[("column_id", Value::from("b1"))]);
    // The second twin may not be known at once.
    let listed = (0..20).find_map(|_| impact_on(&domain, None, 1500.0, PATIENCE).err());
    let expected = "there are twins of several columns: \"a3\", \"b1\"; choose one with --column";
    assert_eq!(listed.as_deref(), Some(expected));
    match impact_on(&domain, Some("b1"), 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(report)) => assert_eq!(report.column_id, "b1"),
        other => panic!("{other:?}"),
    }
    first.stop();
    second.stop();
}

/// The client once took the rejection by a twin of another column for the answer, because it sent the event before it had found
/// the one that it was for.
#[test]
fn an_impact_reaches_its_column_among_ten() {
    let domain = Domain::fresh();
    let columns: Vec<_> = (0..10).map(|number| format!("c{number}")).collect();
    let twins: Vec<_> = columns
        .iter()
        .map(|id| RunningTwin::start(&domain, &[("column_id", Value::from(id.as_str()))]))
        .collect();
    for column in &columns {
        match impact_on(&domain, Some(column), 10.0, PATIENCE) {
            Ok(ImpactOutcome::Forecast(report)) => assert_eq!(&report.column_id, column),
            other => panic!("{column}: {other:?}"),
        }
    }
    match impact_on(&domain, Some("c10"), 10.0, PATIENCE) {
        Ok(ImpactOutcome::Rejected(reason)) => assert!(reason.contains("c10"), "{reason}"),
        other => panic!("{other:?}"),
    }
    twins.into_iter().for_each(RunningTwin::stop);
}

/// The client once took the rejection by a twin of another column for the answer of one whose status had not arrived before the event
/// was sent.
#[test]
fn the_rejection_by_another_twin_is_no_answer_if_the_forecast_follows() {
    let domain = Domain::fresh();
    let other = RunningTwin::start(&domain, &[]);
    let mut silent = Outgoing::<TwinStatus>::start(&domain, &qos::TWIN_STATUS);
    let forecasts = silent.node.publisher(&qos::IMPACT_FORECAST).unwrap();
    let events = Incoming::<ImpactEvent>::early(&mut silent.node, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::early(&mut silent.node, &qos::TWIN_STATUS);
    let outcome = std::thread::scope(|scope| {
        let sender = scope.spawn(|| impact_on(&domain, Some("silent"), 10.0, PATIENCE));
        let event = events.find("the event", |it| it.column_id == "silent");
        statuses.find("the rejection", |it| {
            it.last_rejection_event_id == event.event_id
        });
        forecasts.publish(forecast_of(event)).unwrap();
        sender.join().unwrap()
    });
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    other.stop();
}

/// The client once sent the event as soon as the status of the column had arrived: a twin that it did not know as a reader of
/// events yet never received it.
#[test]
fn an_impact_waits_until_its_twin_is_known_as_a_reader() {
    let domain = Domain::fresh();
    // With this one all endpoints of the client are matched.
    let other = RunningTwin::start(&domain, &[]);
    let outcome = std::thread::scope(|scope| {
        let sender = scope.spawn(|| impact_on(&domain, Some("late"), 10.0, PATIENCE));
        let mut late = Outgoing::<TwinStatus>::start(&domain, &qos::TWIN_STATUS);
        let forecasts = late.node.publisher(&qos::IMPACT_FORECAST).unwrap();
        assert!(late.publish(TwinStatus {
            column_id: "late".to_owned(),
            ..TwinStatus::default()
        }));
        // That the client does not send yet is nothing to wait for: this is the time in which one that does not wait would send. A
        // client that waits passes however long it is.
        std::thread::sleep(Duration::from_millis(500));
        let events = Incoming::<ImpactEvent>::early(&mut late.node, &qos::IMPACT_EVENT);
        let event = events.find("the event", |it| it.column_id == "late");
        forecasts.publish(forecast_of(event)).unwrap();
        sender.join().unwrap()
    });
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    other.stop();
}

/// What a twin answers to an event that it accepts.
fn forecast_of(event: ImpactEvent) -> ImpactReport {
    ImpactReport {
        event_id: event.event_id,
        ..ImpactReport::default()
    }
}

/// Sends an impact of 1 m/s as `column-twin impact` does.
pub fn impact(
    domain: &Domain,
    mass: f64,
    match_timeout: Duration,
) -> Result<ImpactOutcome, String> {
    impact_on(domain, Some("column"), mass, match_timeout)
}

fn impact_on(
    domain: &Domain,
    column_id: Option<&str>,
    mass: f64,
    match_timeout: Duration,
) -> Result<ImpactOutcome, String> {
    let options = ImpactOptions {
        column_id: column_id.map(str::to_owned),
        request: ImpactRequest {
            event_id: None,
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass,
                velocity: 1.0,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout,
            answer_timeout: PATIENCE,
        },
    };
    send_impact(&domain.environment, &[], &options, &mut |_| {}).map_err(|error| error.to_string())
}

#[test]
fn a_node_with_readers_stops() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let (stopped, end) = sync_channel(1);
    let stopping = std::thread::spawn(move || {
        twin.stop();
        let _ = stopped.send(());
    });
    assert!(end.recv_timeout(PATIENCE).is_ok(), "the node does not stop");
    stopping.join().expect("no panic");
    drop(states);
}
