//! What the node costs while nothing happens.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin::{ColumnState, TwinStatus};
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::Peer;
use super::program::Program;
use super::table::{number, row};

/// The target \[s of processor time per s\].
const TARGET: f64 = 0.01;

/// Unit of the times in `/proc` \[1/s\], the same on every Linux that has not been made anew.
const USER_HZ: f64 = 100.0;

/// Processor time that a process has used \[s\], from fields 14 and 15 of `/proc/PID/stat`.
fn processor_time(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).expect("it runs");
    // The name of the program stands in brackets and may hold anything.
    let behind_name = stat.rsplit_once(')').expect("a name").1;
    let ticks = |field: usize| -> f64 {
        let text = behind_name.split_ascii_whitespace().nth(field - 3);
        text.and_then(|it| it.parse().ok()).expect("a number")
    };
    (ticks(14) + ticks(15)) / USER_HZ
}

fn share(id: u32, span: Duration) -> f64 {
    let (before, began) = (processor_time(id), Instant::now());
    std::thread::sleep(span);
    (processor_time(id) - before) / began.elapsed().as_secs_f64()
}

pub fn run(span: Duration) {
    let span = span.min(Duration::from_secs(30));
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let program = Program::ready(&domain, folder.path(), &[]);
    let alone = share(program.id(), span);
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
    let with_readers = share(program.id(), span);
    drop((states, statuses));
    println!(
        "processor time of the node at rest over {} s",
        span.as_secs()
    );
    row("", ["% of a core".into(), "/ target".into()]);
    for (name, share) in [("alone", alone), ("with readers", with_readers)] {
        row(name, [number(100.0 * share), number(share / TARGET)]);
    }
}
