//! A program that is killed while it records loses very little, and its recording can be repaired.

use rosbag2_mcap::{ChunkCompression, FLUSH_WITHIN};

use super::killed_process::{RATE, missing_after_a_kill};
use super::sample::COMPRESSIONS;

/// Number of kills.
const KILLS: usize = 30;

#[test]
fn messages_before_a_kill_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let missing = missing_after_a_kill(folder.path(), ChunkCompression::None, 3000);
    println!("missing after a kill: {missing:?}");
}

#[test]
#[ignore = "slow: 30 kills; takes half a minute, and a machine that is not overloaded"]
fn thirty_kills_at_any_instant_lose_less_than_promised() {
    let mut all = Vec::new();
    for kill in 0..KILLS {
        let folder = tempfile::tempdir().unwrap();
        let compression = COMPRESSIONS[kill % COMPRESSIONS.len()];
        // From 0.1 s to 0.9 s, at irregular instants.
        let messages = 1000 + (kill as u64 * 7919) % 8000;
        all.push(missing_after_a_kill(folder.path(), compression, messages));
    }
    all.sort();
    println!(
        "missing after {KILLS} kills at {RATE} messages/s: median {:?}, most {:?}",
        all[KILLS / 2],
        all[KILLS - 1]
    );
    assert!(all[KILLS - 1] <= FLUSH_WITHIN, "{all:?}");
}
