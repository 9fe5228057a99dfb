//! Processor time of the node at rest, beside that of a participant that does nothing else.

use std::time::Duration;

use column_twin::messages::column_twin_msgs::{ColumnState, TwinStatus};
use column_twin::ros::qos;

use super::bare::Bare;
use super::domain::Domain;
use super::peers::Peer;
use super::processor::share_at_rest;
use super::program::Program;
use super::table::{number, row};

/// The target \[s of processor time per s\], and that of what the node takes above the bare participant.
const TARGET: f64 = 0.01;
const TARGET_ABOVE: f64 = 0.001;

/// For which the bare participant is left alone once it has started.
const START: Duration = Duration::from_secs(3);

pub fn run(span: Duration) {
    let span = span.min(Duration::from_secs(30));
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let program = Program::ready(&domain, folder.path(), &[]);
    // After the start, the node computes the critical velocities of its column, once.
    let mut waiting = Peer::new(&domain);
    waiting
        .reader(
            &qos::TWIN_STATUS,
            |status: TwinStatus, _| status.critical_vehicle.len(),
            |it| it.header.stamp,
        )
        .find(|vehicles| *vehicles > 0);
    drop(waiting);
    let other = Domain::fresh();
    let bare = Bare::echo(&other);
    std::thread::sleep(START);
    let mut alone = 0.0;
    let wait = || std::thread::sleep(span);
    let of_bare = share_at_rest(bare.id(), || alone = share_at_rest(program.id(), wait));
    drop(bare);
    let mut peer = Peer::new(&domain);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, _| (),
        |it| it.header.stamp,
    );
    let statuses = peer.reader(
        &qos::TWIN_STATUS,
        |_: TwinStatus, _| (),
        |it| it.header.stamp,
    );
    let with_readers = share_at_rest(program.id(), wait);
    drop((states, statuses));
    println!(
        "processor time of the node at rest over {} s",
        span.as_secs()
    );
    row("", ["% of a core".into(), "/ target".into()]);
    for (name, share, target) in [
        ("alone", alone, TARGET),
        ("with readers", with_readers, TARGET),
        ("a bare participant", of_bare, TARGET),
        ("alone, above the bare one", alone - of_bare, TARGET_ABOVE),
    ] {
        row(name, [number(100.0 * share), number(share / target)]);
    }
}
