//! The sealed recordings of one run of a recorder are linked: one that is removed from the middle or replaced is noticed.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use rosbag2_mcap::{Predecessor, Reader, Recorder, RecorderOptions, SealKey};
use tempfile::TempDir;

use super::forging::Parts;
use super::recorder::recordings;
use super::sample::{text_entry, text_topics};
use super::seal::{opened, seal_of};

/// Three recordings of one session.
fn session(folder: &Path) -> Vec<PathBuf> {
    session_by(folder, SealKey::fresh().unwrap())
}

fn session_by(folder: &Path, key: SealKey) -> Vec<PathBuf> {
    let mut options = RecorderOptions::new(folder, SystemTime::UNIX_EPOCH);
    options.max_file_size = 100_000;
    options.seal = Some(key);
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let text = "x".repeat(10_000);
    for index in 0..30 {
        assert!(recorder.record(text_entry(0, index, &text, index % 11 == 0)));
    }
    let statistics = recorder.stop();
    assert_eq!((statistics.finished, statistics.lost), (3, 0));
    let mut found = recordings(folder);
    found.sort_by_key(|it| opened(it).recording);
    found
}

#[test]
fn the_recordings_of_a_session_follow_one_another() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    for (number, directory) in found.iter().enumerate() {
        let reader = Reader::open(directory).unwrap();
        let seal = seal_of(&reader).unwrap();
        assert!(
            seal.holds() && seal.is_final && seal.uncovered == 0,
            "{seal:?}"
        );
        assert_eq!(
            (seal.recording, &seal.session),
            (number as u64, &opened(&found[0]).session)
        );
        let expected = match number {
            0 => Predecessor::None,
            _ => Predecessor::Found(fs::canonicalize(&found[number - 1]).unwrap()),
        };
        assert_eq!(reader.predecessor(), expected);
        assert!(!reader.predecessor().is_fault());
    }
}

#[test]
fn a_recording_removed_from_the_middle_of_a_session_is_noticed() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    fs::remove_dir_all(&found[1]).unwrap();
    let reader = Reader::open(&found[2]).unwrap();
    assert!(seal_of(&reader).unwrap().holds());
    let missing = Predecessor::Missing {
        name: found[1].file_name().unwrap().to_string_lossy().into_owned(),
        earlier: fs::canonicalize(&found[0]).unwrap(),
    };
    assert_eq!(reader.predecessor(), missing);
    assert!(missing.is_fault());
    // The limits of a recorder delete the oldest recordings first.
    fs::remove_dir_all(&found[0]).unwrap();
    let gone = reader.predecessor();
    assert!(
        matches!(&gone, Predecessor::Gone { .. }) && !gone.is_fault(),
        "{gone:?}"
    );
}

#[test]
fn a_recording_that_was_changed_or_replaced_in_a_session_is_noticed() {
    let folder = TempDir::new().unwrap();
    let found = session(folder.path());
    let last = Reader::open(&found[2]).unwrap();
    let before = recordings(&found[1])
        .into_iter()
        .find(|it| it.extension().unwrap() == "mcap");
    let before = before.unwrap();
    let original = fs::read(&before).unwrap();
    let mut parts = Parts::read(&before);
    parts.message(3).1[50] ^= 1;
    parts.write(&before);
    assert!(matches!(last.predecessor(), Predecessor::Changed(_)));
    // Shortened to an earlier seal, as if it had been cut off.
    let mut parts = Parts::read(&before);
    parts.message(3).1[50] ^= 1;
    let last_seals = parts.records.iter().rposition(|it| !it.is_seal()).unwrap();
    parts.records.truncate(last_seals.min(parts.messages()[5]));
    parts.write(&before);
    assert!(matches!(last.predecessor(), Predecessor::Changed(_)));
    // Under another name it is still the same.
    fs::write(&before, original).unwrap();
    let renamed = folder.path().join("renamed");
    fs::rename(&found[1], &renamed).unwrap();
    let expected = Predecessor::Found(fs::canonicalize(&renamed).unwrap());
    assert_eq!(last.predecessor(), expected);
}

/// Its session differs, so that it counted as deleted to keep within the limits.
#[test]
fn the_oldest_recording_replaced_by_that_of_another_run_with_the_same_key_is_noticed() {
    let key = SealKey::fresh().unwrap();
    let [folder, other] = [(); 2].map(|()| TempDir::new().unwrap());
    let found = session_by(folder.path(), key.clone());
    let others = session_by(other.path(), key);
    let next = Reader::open(&found[1]).unwrap();
    let replaced = || Reader::open(&found[0]).unwrap();
    assert_eq!(replaced().contradicting_successor(), None);

    fs::remove_dir_all(&found[0]).unwrap();
    fs::rename(&others[0], &found[0]).unwrap();
    let changed = Predecessor::Changed(fs::canonicalize(&found[0]).unwrap());
    assert_eq!(next.predecessor(), changed);
    // Verifying the replacement itself reports it, too.
    assert!(seal_of(&replaced()).unwrap().holds());
    assert_eq!(
        replaced().contradicting_successor(),
        Some(fs::canonicalize(&found[1]).unwrap())
    );
}
