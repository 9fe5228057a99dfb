//! Publishing at 1 kHz for a long time: what is lost, and the memory of the node.

use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnState, HingeForces};
use column_twin::ros::{Environment, qos};
use sros2_keystore::{SecuritySettings, SecurityStrategy};

use super::domain::Domain;
use super::peers::{Arrival, Peer, Reader};
use super::processor::{resident_mebibytes, share_during};
use super::program::Program;
use super::stream::Impacts;
use super::table::{number, row};

/// Between two looks at the memory, as long as that; a shorter measurement is divided into `MIN_LOOKS`.
const MAX_INTERVAL: Duration = Duration::from_secs(60);
const MIN_LOOKS: u32 = 4;

/// Target: growth of the resident memory after the first interval \[MiB\].
const GROWTH: f64 = 2.0;

/// Maximum time in transit of the last messages.
const STRAGGLERS: Duration = Duration::from_secs(1);

/// Counts the messages of one writer by their sequence numbers.
#[derive(Default)]
struct Count {
    first: Option<i64>,
    last: i64,
    received: i64,
    out_of_order: u64,
}

impl Count {
    fn take(&mut self, arrival: &Arrival) {
        let number = arrival.sequence.expect("a Rust reader knows it");
        self.first.get_or_insert(number);
        self.out_of_order += u64::from(number < self.last);
        self.last = self.last.max(number);
        self.received += 1;
    }

    fn lost(&self) -> i64 {
        self.first.map_or(0, |first| self.last - first + 1) - self.received
    }

    fn take_waiting(&mut self, reader: &Reader<Arrival>) {
        reader.arrivals.try_iter().for_each(|it| self.take(&it));
    }
}

pub fn run(span: Duration) {
    let mut domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let security = Environment::of_process().expect("valid variables").security;
    let program = if security.keystore.is_some() {
        println!("with DDS security");
        domain.environment.security = SecuritySettings {
            is_enabled: true,
            strategy: SecurityStrategy::Enforce,
            enclave: "/operator".to_owned(),
            ..security
        };
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command
            .args(["run", "--ros-args", "--enclave", "/column_twin"])
            .env("ROS_SECURITY_ENABLE", "true")
            .env("ROS_SECURITY_STRATEGY", "Enforce");
        let mut program = Program::spawn(&domain, folder.path(), command);
        program.wait_for("is ready in domain");
        program
    } else {
        Program::ready(&domain, folder.path(), &[])
    };
    let mut peer = Peer::new(&domain);
    let readers = [
        peer.reader(
            &qos::COLUMN_STATE,
            |_: ColumnState, it| it,
            |it| it.header.stamp,
        ),
        peer.reader(
            &qos::HINGE_FORCES,
            |_: HingeForces, it| it,
            |it| it.header.stamp,
        ),
    ];
    let mut impacts = Impacts::new(&mut peer);
    // Messages sent before the first acknowledgement of a reader may be lost, and are excluded.
    impacts.for_a_while(Duration::from_millis(500));
    for reader in &readers {
        while reader.arrivals.recv_timeout(STRAGGLERS).is_ok() {}
    }
    let mut counts = [Count::default(), Count::default()];
    let interval = (span / MIN_LOOKS).min(MAX_INTERVAL);
    let begin = Instant::now();
    let mut first = None;
    println!("{span:?} of responses at 1 kHz; impacts follow one another without a pause");
    row(
        "after [s]",
        ["memory [MiB]", "growth", "% of a core"].map(str::to_owned),
    );
    while begin.elapsed() < span {
        let share = share_during(program.id(), || impacts.for_a_while(interval));
        for (count, reader) in counts.iter_mut().zip(&readers) {
            count.take_waiting(reader);
        }
        let memory = resident_mebibytes(program.id());
        let growth = memory - *first.get_or_insert(memory);
        row(
            &format!("{:.0}", begin.elapsed().as_secs_f64()),
            [memory, growth, 100.0 * share].map(number),
        );
    }
    let growth = resident_mebibytes(program.id()) - first.unwrap_or_default();
    row(
        "growth after the first interval / 2 MiB",
        [number(growth / GROWTH)],
    );
    row("", ["received", "lost", "out of order"].map(str::to_owned));
    for ((count, reader), name) in counts
        .iter_mut()
        .zip(&readers)
        .zip(["column_state", "hinge_forces"])
    {
        while let Ok(arrival) = reader.arrivals.recv_timeout(STRAGGLERS) {
            count.take(&arrival);
        }
        row(
            name,
            [
                count.received.to_string(),
                count.lost().to_string(),
                count.out_of_order.to_string(),
            ],
        );
    }
}
