//! A node that is killed during a response.

use std::path::Path;
use std::time::{Duration, Instant};

use column_twin::evidence::verify;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::ColumnState;
use column_twin::recording::{FLUSH_WITHIN, Reader, repair};
use column_twin::ros::qos;
use tempfile::TempDir;

use super::domain::{Domain, PATIENCE};
use super::incoming::reader;
use super::node::{Bytes, program, slow_impact};
use super::recorded_twin::the_one_recording;

const KILLS: u64 = 30;

fn stamps(states: impl Iterator<Item = Vec<u8>>) -> Vec<i64> {
    let state = |bytes: Vec<u8>| cdr::decode::<ColumnState>(&bytes).unwrap();
    states
        .map(|bytes| state(bytes).header.stamp.to_nanos().unwrap())
        .collect()
}

fn recorded(path: &Path) -> Vec<i64> {
    let reader = Reader::open(path).unwrap();
    assert!(reader.wholeness().is_whole(), "{}", reader.wholeness());
    let messages = reader.messages().map(Result::unwrap);
    let states = messages.filter(|it| *it.topic == *"/column_state");
    stamps(states.map(|it| it.data))
}

/// Kills a node at a time after the column started to move, repairs and verifies its recording, and returns the duration of
/// received states that it lacks.
fn missing_after_a_kill(after: Duration) -> Duration {
    let directory = TempDir::new().unwrap();
    let domain = Domain::fresh();
    let mut node = program(&domain, directory.path());
    let mut reader = reader(&domain);
    let states = Bytes::start(&mut reader, &qos::COLUMN_STATE);
    slow_impact(&domain, "a");
    let first = states.messages.recv_timeout(PATIENCE).expect("a state");
    let kill_at = Instant::now() + after;
    std::thread::sleep(kill_at.saturating_duration_since(Instant::now()));
    node.kill().unwrap();
    node.wait().unwrap();
    // Messages in transit arrive after a moment.
    let rest = std::iter::from_fn(|| {
        let more = states.messages.recv_timeout(Duration::from_millis(200));
        more.ok().map(|it| it.bytes().to_vec())
    });
    let received = stamps(std::iter::once(first.bytes().to_vec()).chain(rest));
    let cut_off = the_one_recording(directory.path());
    let to = directory.path().join("repaired");
    let path = match repair(&cut_off, Some(&to)).unwrap() {
        Some(repaired) => repaired.directory,
        None => cut_off,
    };
    let found = verify(&path).unwrap();
    assert!(found.is_equal(), "{found}");
    assert_sealed_up_to_the_last_flush(&path);
    let kept = recorded(&path);
    assert!(!kept.is_empty(), "nothing is left after {after:?}");
    let (last, kept) = (received[received.len() - 1], kept[kept.len() - 1]);
    Duration::from_nanos(u64::try_from(last - kept).unwrap_or(0))
}

/// The seal of a killed node holds; it covers all but what was written within one flush.
fn assert_sealed_up_to_the_last_flush(path: &Path) {
    let reader = Reader::open(path).unwrap();
    let seal = reader.seals()[0].as_ref().expect("the node seals");
    assert!(seal.holds() && !seal.is_final, "{seal:?}");
    let within = i64::try_from(FLUSH_WITHIN.as_nanos()).unwrap();
    let end = reader.span().unwrap().1;
    assert!(end - seal.covered_until.unwrap() <= within, "{seal:?}");
}

#[test]
#[ignore = "slow: 30 nodes on loopback are killed"]
fn recordings_of_thirty_killed_nodes_are_verified() {
    let mut all: Vec<_> = (0..KILLS)
        // From 0.06 s to 0.3 s of a response of a third of a second, at irregular times.
        .map(|kill| missing_after_a_kill(Duration::from_micros(60_000 + (kill * 79_193) % 240_000)))
        .collect();
    all.sort();
    println!(
        "missing after {KILLS} kills of a node: median {:?}, most {:?}",
        all[all.len() / 2],
        all[all.len() - 1]
    );
    assert!(all[all.len() - 1] <= FLUSH_WITHIN, "{all:?}");
}
