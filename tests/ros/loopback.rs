//! Node and reader in Rust, on loopback.

use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin::{ColumnState, HingeForces, ImpactEvent, TwinStatus};
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::Parameters;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{ImpactOptions, ImpactOutcome, Names, Node, TwinNode, send_impact};
use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};
use serde::de::DeserializeOwned;

use super::domain::Domain;
use super::scripted_twin::{SAMPLE_PERIOD, ScriptedTwin, response};

/// Discovery and a whole response take a second; this is for machines that have much else to do.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A node of a scripted twin.
pub fn start(domain: &Domain) -> TwinNode {
    let (twin, outputs) = ScriptedTwin::start(Parameters::default());
    let names = Names::new("/", "column_twin", &[]).unwrap();
    TwinNode::start(&domain.environment, names, twin, outputs, None).unwrap()
}

/// Reads one topic in a thread of its own until it is dropped.
pub struct Incoming<M> {
    messages: Receiver<M>,
    abort: AbortHandle,
    thread: Option<JoinHandle<()>>,
}

impl<M: DeserializeOwned + Send + 'static> Incoming<M> {
    /// Subscribes, and waits until there is a publisher.
    pub fn start(node: &mut Node, endpoint: &Endpoint) -> Self {
        let subscription = node.subscription::<M>(endpoint).unwrap();
        let guid = subscription.guid();
        let (sender, messages) = channel();
        let events = node.participant_events();
        let (abort, registration) = AbortHandle::new_pair();
        let read = move || {
            let each = subscription.async_stream().for_each(|message| {
                let _ = sender.send(message.unwrap().0);
                futures::future::ready(())
            });
            let all = async { futures::join!(events, each) };
            let _ = futures::executor::block_on(Abortable::new(all, registration));
        };
        let thread = Some(std::thread::spawn(read));
        let deadline = Instant::now() + PATIENCE;
        assert!(
            node.matches().wait_for(guid, 1, deadline),
            "no {} found",
            endpoint.name
        );
        Self {
            messages,
            abort,
            thread,
        }
    }

    /// The next message.
    pub fn next(&self) -> M {
        self.messages.recv_timeout(PATIENCE).expect("a message")
    }
}

impl<M> Drop for Incoming<M> {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

#[test]
fn the_stream_of_a_response_arrives_whole_and_in_order() {
    let domain = Domain::fresh();
    let twin = start(&domain);
    let names = Names::new("/", "reader", &[]).unwrap();
    let mut node = Node::new(&domain.environment, names).unwrap();
    let publisher = node.publisher::<ImpactEvent>(&qos::IMPACT_EVENT).unwrap();
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let forces = Incoming::<HingeForces>::start(&mut node, &qos::HINGE_FORCES);
    assert!(
        node.matches()
            .wait_for(publisher.guid(), 1, Instant::now() + PATIENCE)
    );
    let stamp = 1_700_000_000_250_000_000;
    let event = ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap(),
            frame_id: String::new(),
        },
        event_id: "e1".to_owned(),
        mass: 1500.0,
        velocity: 1.0,
        ..ImpactEvent::default()
    };
    publisher.publish(event).unwrap();
    let (samples, _) = response(&Parameters::default(), 1500.0, 1.0);
    println!("{} samples", samples.len());
    for (sample, expected) in samples
        .iter()
        .zip((stamp..).step_by(SAMPLE_PERIOD as usize))
    {
        let (state, forces) = (states.next(), forces.next());
        assert_eq!(state.header.stamp.to_nanos(), Some(expected));
        assert_eq!(forces.header.stamp, state.header.stamp);
        let mut of_sample = ColumnState::from(sample);
        (of_sample.header, of_sample.phase) = (state.header.clone(), state.phase);
        (of_sample.column_id, of_sample.event_id) = ("column".to_owned(), "e1".to_owned());
        assert_eq!(state, of_sample);
        assert_eq!(forces.moment, sample.hinges.map(|hinge| hinge.moment));
    }
    drop((states, forces));
    twin.stop(|| {});
}

#[test]
fn a_late_joiner_gets_the_status() {
    let domain = Domain::fresh();
    let twin = start(&domain);
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    let names = Names::new("/", "reader", &[]).unwrap();
    let mut node = Node::new(&domain.environment, names).unwrap();
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    while statuses.next().events_accepted != 1 {}
    drop(statuses);
    twin.stop(|| {});
}

#[test]
fn an_impact_from_the_command_line_is_answered_or_refused() {
    let domain = Domain::fresh();
    let nobody = impact(&domain, 1500.0, Duration::from_millis(300));
    assert!(
        nobody
            .unwrap_err()
            .contains("no twin listens on /impact_event in domain")
    );
    let twin = start(&domain);
    match impact(&domain, 1500.0, PATIENCE) {
        Ok(ImpactOutcome::Forecast(report)) => assert!(report.max_v1 > 0.0),
        other => panic!("{other:?}"),
    }
    let refused = impact(&domain, -1.0, PATIENCE).unwrap();
    let reason = "mass and velocity must be above 0".to_owned();
    assert_eq!(refused, ImpactOutcome::Refused(reason));
    twin.stop(|| {});
}

/// Sends one impact of 1 m/s as `column-twin impact` does.
pub fn impact(
    domain: &Domain,
    mass: f64,
    match_timeout: Duration,
) -> Result<ImpactOutcome, String> {
    let options = ImpactOptions {
        column_id: "column".to_owned(),
        event_id: None,
        mass,
        velocity: 1.0,
        gap: None,
        restitution: None,
        height: None,
        match_timeout,
        answer_timeout: PATIENCE,
    };
    send_impact(&domain.environment, &[], &options, &mut |_| {}).map_err(|error| error.to_string())
}

#[test]
fn a_node_with_readers_stops() {
    let domain = Domain::fresh();
    let twin = start(&domain);
    let names = Names::new("/", "reader", &[]).unwrap();
    let mut node = Node::new(&domain.environment, names).unwrap();
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let start = Instant::now();
    twin.stop(|| {});
    println!("stopped within {:?}", start.elapsed());
    drop(states);
}
