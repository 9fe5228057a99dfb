//! The live twin behind the node, in this process: what a reader receives in real time is what the simulation computes.

use column_twin::live::LiveOptions;
use column_twin::messages::column_twin::{ColumnState, HingeForces, ImpactEvent, TwinStatus};
use column_twin::parameters::{Parameters, Value};
use column_twin::ros::{LiveTwin, Names, RosoutQueue, TwinNode, qos};

use super::domain::Domain;
use super::loopback::{Incoming, Outgoing, event, now, reader};
use super::simulation;

/// A live twin and its node.
pub struct RunningTwin {
    node: TwinNode,
}

impl RunningTwin {
    /// Of the default column with these changes. Keeps no damage and asks the system for nothing.
    pub fn start(domain: &Domain, changes: &[(&str, Value)]) -> Self {
        Self::start_logging(domain, changes, None)
    }

    /// The same with log messages on their way to `/rosout`.
    pub fn start_logging(
        domain: &Domain,
        changes: &[(&str, Value)],
        log: Option<RosoutQueue>,
    ) -> Self {
        let (twin, outputs) = LiveTwin::start(parameters(changes), LiveOptions::default()).unwrap();
        let names = Names::new("/", "column_twin", &[]).unwrap();
        let node = TwinNode::start(&domain.environment, names, twin, outputs, log, None).unwrap();
        Self { node }
    }

    /// Ends node and twin.
    pub fn stop(self) {
        self.node.stop();
    }
}

/// The default column with these changes, without a state file and without any wish for real time.
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
