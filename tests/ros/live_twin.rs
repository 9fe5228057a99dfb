//! The live twin and its node in this process: a reader receives in real time what the simulation computes.

use std::time::Instant;

use column_twin::live::LiveOptions;
use column_twin::messages::column_twin_msgs::{ColumnState, HingeForces, ImpactEvent, TwinStatus};
use column_twin::parameters::{Parameters, Value};
use column_twin::ros::{LiveColumns, Names, RosoutQueue, TwinNode, qos};
use rustdds::GUID;

use super::domain::{Domain, PATIENCE};
use super::loopback::{Incoming, Outgoing, event, now, reader};
use super::simulation;

/// A live twin and its node.
pub struct RunningTwin {
    node: TwinNode,
}

impl RunningTwin {
    /// Starts the default column with these changes, without a state file and without real-time scheduling.
    pub fn start(domain: &Domain, changes: &[(&str, Value)]) -> Self {
        Self::start_logging(domain, changes, None)
    }

    /// As [`start`](Self::start), with log messages for `/rosout`.
    pub fn start_logging(
        domain: &Domain,
        changes: &[(&str, Value)],
        log: Option<RosoutQueue>,
    ) -> Self {
        let (twin, outputs) =
            LiveColumns::start_one(parameters(changes), LiveOptions::default()).unwrap();
        let names = Names::new("/", "column_twin", &[]).unwrap();
        let node = TwinNode::start(&domain.environment, names, twin, outputs, log, None).unwrap();
        Self { node }
    }

    /// Waits until the node receives what this publisher sends. The publisher finds the node's reader by itself, perhaps earlier;
    /// what it sends in between on a topic of best effort is lost.
    pub fn wait_for(&self, publisher: GUID) {
        let deadline = Instant::now() + PATIENCE;
        let is_known = self.node.matches().wait_for_peer(publisher, deadline);
        assert!(is_known, "the node has not found {publisher:?}");
    }

    /// Ends node and twin.
    pub fn stop(self) {
        self.node.stop();
    }
}

/// The default column with these changes, without a state file and without real-time scheduling.
pub fn parameters(changes: &[(&str, Value)]) -> Parameters {
    let quiet = [
        ("state.directory", Value::from("")),
        ("real_time.priority", Value::Integer(0)),
        ("real_time.lock_memory", Value::Bool(false)),
    ];
    Parameters::from_values(quiet.iter().chain(changes).cloned()).unwrap()
}

#[test]
fn the_stream_in_real_time_is_that_of_the_simulation() {
    let domain = Domain::fresh();
    let parameters = parameters(&[]);
    let (expected, report) = simulation::stream(&parameters, 1500.0, 10.0);
    let twin = RunningTwin::start(&domain, &[]);
    let mut reader = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let states = Incoming::<ColumnState>::start(&mut reader, &qos::COLUMN_STATE);
    let forces = Incoming::<HingeForces>::start(&mut reader, &qos::HINGE_FORCES);
    // Readers are announced in their order: one that gets what is kept for late joiners is not the first that is known.
    drop(Incoming::<TwinStatus>::start(&mut reader, &qos::TWIN_STATUS).next());
    let stamp = now();
    assert!(events.publish(event("e1", stamp, 1500.0, 10.0)));
    println!("{} samples, {report:?}", expected.len());
    for mut sample in expected {
        let (state, forces) = (states.next(), forces.next());
        assert_eq!(
            state.header.stamp.to_nanos(),
            Some(stamp + sample.since),
            "none is missing"
        );
        for (header, column_id, event_id) in [
            (
                &mut sample.state.header,
                &mut sample.state.column_id,
                &mut sample.state.event_id,
            ),
            (
                &mut sample.forces.header,
                &mut sample.forces.column_id,
                &mut sample.forces.event_id,
            ),
        ] {
            header.clone_from(&state.header);
            "column".clone_into(column_id);
            "e1".clone_into(event_id);
        }
        assert_eq!(state, sample.state);
        assert_eq!(forces, sample.forces);
    }
    drop((states, forces));
    twin.stop();
}
