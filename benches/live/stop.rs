//! Time from SIGTERM during a response to the end of the program, which saves the damage.

use std::time::Duration;

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent};
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Peer, event, now};
use super::program::Program;
use super::table::{Ranked, number, row};

const STOPS: usize = 10;

/// The target \[s\].
const TARGET: f64 = 1.0;

fn stop() -> f64 {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let program = Program::ready(&domain, folder.path(), &[]);
    let mut peer = Peer::new(&domain);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |state: ColumnState, _| state.phase,
        |it| it.header.stamp,
    );
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    events
        .publish(event("stop", now(), 1500.0, 10.0))
        .expect("room for one");
    states.find(|phase| *phase == ColumnState::CONTACT);
    let (ended, took, log) = program.terminate();
    assert!(ended.success(), "{ended}: {log:#?}");
    assert!(
        folder.path().join("column_twin/state/column.json").exists(),
        "the damage is saved"
    );
    took.as_secs_f64()
}

pub fn run(_: Duration) {
    let took = Ranked::new((0..STOPS).map(|_| stop()));
    println!("time from SIGTERM during contact to the end of the program, {STOPS} times");
    row("", ["p50 [s]".into(), "max [s]".into(), "/ target".into()]);
    let (median, longest) = (took.percentile(50.0), took.max());
    row("stop", [median, longest, longest / TARGET].map(number));
}
