//! Many twins on one machine, each in a process of its own.

use std::collections::BTreeSet;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::TwinStatus;
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::Peer;
use super::processor::{resident_mebibytes, share_together};
use super::program::Program;
use super::table::{number, row};

/// Number of twins.
const TWINS: usize = 40;

/// The target for all of them together \[s of processor time per s\].
const TARGET: f64 = 0.15;

pub fn run(span: Duration) {
    let span = span.min(Duration::from_secs(30));
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let began = Instant::now();
    let programs: Vec<_> = (0..TWINS)
        .map(|twin| {
            let column = format!("column_id:=c{twin:02}");
            Program::ready(&domain, folder.path(), &["-p", &column])
        })
        .collect();
    let started = began.elapsed();
    // After the start, each computes the critical velocities of its column, once.
    let (known, _) = statuses(&domain, |status| !status.critical_vehicle.is_empty());
    let ids: Vec<_> = programs.iter().map(Program::id).collect();
    let packets = loopback_packets();
    let share = share_together(&ids, span);
    let packets = (loopback_packets() - packets) / span.as_secs_f64();
    let memory: f64 = ids.iter().map(|id| resident_mebibytes(*id)).sum();
    let (found, late) = statuses(&domain, |_| true);
    let reached = (0..TWINS).filter(|twin| reaches(&domain, *twin)).count();
    println!(
        "{TWINS} twins in {TWINS} processes, at rest over {} s",
        span.as_secs()
    );
    row("", ["found".into(), "/ target".into()]);
    let count = |count: usize| [count.to_string(), number(count as f64 / TWINS as f64)];
    row(
        "processor time [% of a core]",
        [number(100.0 * share), number(share / TARGET)],
    );
    row(
        "packets on loopback, of all programs [1/s]",
        [number(packets)],
    );
    row(
        "resident memory of one [MiB]",
        [number(memory / TWINS as f64)],
    );
    row("start of all [s]", [number(started.as_secs_f64())]);
    row("statuses with critical velocities", count(known));
    row("statuses that a late reader gets", count(found));
    row("  after [s]", [number(late.as_secs_f64())]);
    row("twins that `column-twin impact` reaches", count(reached));
}

/// Of how many columns a late reader gets a status for which this holds, and how long that takes.
fn statuses(domain: &Domain, is_it: impl Fn(&TwinStatus) -> bool) -> (usize, Duration) {
    let began = Instant::now();
    let mut peer = Peer::new(domain);
    let reader = peer.reader(
        &qos::TWIN_STATUS,
        |status: TwinStatus, _| status,
        |it| it.header.stamp,
    );
    let mut columns = BTreeSet::new();
    while columns.len() < TWINS {
        let status = reader.next();
        if is_it(&status) {
            columns.insert(status.column_id);
        }
    }
    (columns.len(), began.elapsed())
}

/// An impact on an undamaged column that it hardly detects.
fn reaches(domain: &Domain, twin: usize) -> bool {
    let column = format!("c{twin:02}");
    let arguments = [
        "impact",
        "--column",
        &column,
        "--mass",
        "10",
        "--velocity",
        "0.1",
        "--vehicle",
        "rigid",
    ];
    let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .expect("runs");
    output.status.success()
}

/// Packets that the loopback interface has received since the start of the machine.
fn loopback_packets() -> f64 {
    let text = std::fs::read_to_string("/proc/net/dev").expect("Linux");
    let line = text
        .lines()
        .find_map(|line| line.trim().strip_prefix("lo:"));
    let packets = line.and_then(|line| line.split_whitespace().nth(1));
    packets.and_then(|it| it.parse().ok()).expect("a number")
}
