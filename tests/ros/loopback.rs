//! Node and reader in Rust, on loopback.

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin::{ColumnState, HingeForces, ImpactEvent};
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::Parameters;
use column_twin::ros::{ImpactOptions, ImpactOutcome, Names, Node, TwinNode, qos, send_impact};
use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};

use super::domain::Domain;
use super::scripted_twin::{SAMPLE_PERIOD, ScriptedTwin, response};

/// Discovery and a whole response take a second; this is for machines that have much else to do.
const PATIENCE: Duration = Duration::from_secs(30);

fn start(domain: &Domain) -> TwinNode {
    let (twin, outputs) = ScriptedTwin::start(Parameters::default());
    let names = Names::new("/", "column_twin", &[]).unwrap();
    TwinNode::start(&domain.environment, names, twin, outputs, None).unwrap()
}

/// Reads both streams in a thread of its own until it is dropped.
struct Reader {
    states: Receiver<ColumnState>,
    forces: Receiver<HingeForces>,
    abort: AbortHandle,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Reader {
    fn start(node: &mut Node) -> Self {
        let state = node
            .subscription::<ColumnState>(&qos::COLUMN_STATE)
            .unwrap();
        let force = node
            .subscription::<HingeForces>(&qos::HINGE_FORCES)
            .unwrap();
        let guids = [state.guid(), force.guid()];
        let ((to_states, states), (to_forces, forces)) = (channel(), channel());
        let events = node.participant_events();
        let (abort, registration) = AbortHandle::new_pair();
        let read = move || {
            let state = state.async_stream().for_each(|message| {
                let _ = to_states.send(message.unwrap().0);
                futures::future::ready(())
            });
            let force = force.async_stream().for_each(|message| {
                let _ = to_forces.send(message.unwrap().0);
                futures::future::ready(())
            });
            let all = async { futures::join!(events, state, force) };
            let _ = futures::executor::block_on(Abortable::new(all, registration));
        };
        let thread = Some(std::thread::spawn(read));
        let deadline = Instant::now() + PATIENCE;
        for guid in guids {
            assert!(
                node.matches().wait_for(guid, 1, deadline),
                "no publisher found"
            );
        }
        Self {
            states,
            forces,
            abort,
            thread,
        }
    }
}

impl Drop for Reader {
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
    let reader = Reader::start(&mut node);
    let deadline = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(publisher.guid(), 1, deadline));
    let stamp = 1_700_000_000_250_000_000;
    publisher
        .publish(ImpactEvent {
            header: Header {
                stamp: Time::from_nanos(stamp).unwrap(),
                frame_id: String::new(),
            },
            column_id: "column".to_owned(),
            event_id: "e1".to_owned(),
            mass: 1500.0,
            velocity: 10.0,
            ..ImpactEvent::default()
        })
        .unwrap();
    let (samples, _) = response(&Parameters::default(), 1500.0, 10.0);
    let mut before = (None::<HingeForces>, 0);
    for (index, sample) in samples.iter().enumerate() {
        let state = reader.states.recv_timeout(PATIENCE).expect("a state");
        let forces = reader.forces.recv_timeout(PATIENCE).expect("forces");
        let expected = stamp + SAMPLE_PERIOD * i64::try_from(index).unwrap();
        assert_eq!(state.header.stamp.to_nanos(), Some(expected));
        assert_eq!(forces.header.stamp, state.header.stamp);
        assert_eq!(
            (state.v1, state.u2, state.contact_force),
            (sample.v1, sample.u2, sample.contact_force)
        );
        assert_eq!(forces.moment, sample.hinges.map(|hinge| hinge.moment));
        assert_eq!(
            (state.column_id.as_str(), state.event_id.as_str()),
            ("column", "e1")
        );
        before = (Some(forces), index);
    }
    assert_eq!(before.1 + 1, samples.len());
    drop(reader);
    drop(publisher);
    drop(node);
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
    assert_eq!(
        refused,
        ImpactOutcome::Refused("mass and velocity must be above 0".to_owned())
    );
    twin.stop(|| {});
}

fn impact(domain: &Domain, mass: f64, match_timeout: Duration) -> Result<ImpactOutcome, String> {
    let options = ImpactOptions {
        column_id: "column".to_owned(),
        event_id: None,
        mass,
        velocity: 10.0,
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
    let reader = Reader::start(&mut node);
    let start = Instant::now();
    twin.stop(|| {});
    println!("stopped within {:?}", start.elapsed());
    drop(reader);
}
