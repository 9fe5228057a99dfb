//! Lateness of the solver while other programs use all processors.

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use column_twin::messages::column_twin_msgs::{ColumnState, TwinStatus};
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Arrival, Peer};
use super::program::Program;
use super::stream::Impacts;
use super::table::{Ranked, number, row};

const LONGEST: Duration = Duration::from_secs(15);

/// A program that uses a processor until it is dropped.
struct Hog(Child);

impl Hog {
    fn start() -> Self {
        let child = Command::new("sh")
            .args(["-c", "while :; do :; done"])
            .stdin(Stdio::null())
            .spawn();
        Self(child.expect("a shell"))
    }
}

impl Drop for Hog {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn measure(span: Duration, hogs: usize, priority: &str) -> [String; 6] {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let priority = format!("real_time.priority:={priority}");
    let _program = Program::ready(&domain, folder.path(), &["-p", &priority]);
    let mut peer = Peer::new(&domain);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, it| it,
        |it| it.header.stamp,
    );
    let statuses = peer.reader(
        &qos::TWIN_STATUS,
        |it: TwinStatus, _| it,
        |it| it.header.stamp,
    );
    let mut impacts = Impacts::new(&mut peer);
    let hogs: Vec<_> = (0..hogs).map(|_| Hog::start()).collect();
    impacts.for_a_while(span);
    drop(hogs);
    let last = statuses.arrivals.try_iter().last().expect("a status");
    let late = states
        .arrivals
        .try_iter()
        .map(|Arrival { stamp, source, .. }| 1e-6 * (source - stamp) as f64);
    let late = Ranked::new(late);
    [
        late.len().to_string(),
        number(1e3 * last.worst_lateness),
        last.overruns.to_string(),
        last.dropped_states.to_string(),
        number(late.percentile(50.0)),
        number(late.percentile(99.0)),
    ]
}

pub fn run(span: Duration) {
    let span = span.min(LONGEST);
    let processors = std::thread::available_parallelism().map_or(2, usize::from);
    println!(
        "responses for {} s; load: {} computing programs on {processors} processors",
        span.as_secs(),
        2 * processors
    );
    let heads = [
        "samples",
        "worst [ms]",
        "skipped",
        "dropped",
        "p50 [ms]",
        "p99 [ms]",
    ];
    row(
        "lateness: maximum of the solver; of publication",
        heads.map(str::to_owned),
    );
    for (name, hogs, priority) in [
        ("quiet, SCHED_FIFO if granted", 0, "50"),
        ("quiet, normal scheduling", 0, "0"),
        ("load, SCHED_FIFO if granted", 2 * processors, "50"),
        ("load, normal scheduling", 2 * processors, "0"),
    ] {
        row(name, measure(span, hogs, priority));
    }
}
