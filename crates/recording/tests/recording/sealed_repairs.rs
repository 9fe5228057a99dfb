//! Repairs of sealed recordings keep the seals, or say what they lose.

use std::fs;

use rosbag2_mcap::{ChunkCompression, Reader, SealKey, repair};
use tempfile::TempDir;

use super::sample::{self, sample};
use super::seal::{FLUSHED, Sealed, opened, seal_of, write};

/// Cut off at any byte: what precedes the last seal is proved, and a repair keeps that.
#[test]
fn a_cut_off_recording_is_sealed_up_to_the_last_flush_and_stays_so_when_repaired() {
    let sealed = Sealed::new();
    let bytes = fs::read(&sealed.file).unwrap();
    let directory = sealed.folder.path().join("cut");
    let file = directory.join("cut_0.mcap");
    fs::create_dir(&directory).unwrap();
    let mut most_uncovered = 0;
    for (round, length) in (2000..bytes.len()).step_by(997).enumerate() {
        fs::write(&file, &bytes[..length]).unwrap();
        let reader = Reader::open(&file).unwrap();
        let Some(seal) = seal_of(&reader) else {
            continue;
        };
        assert_eq!(seal.fault, None, "{length} bytes");
        assert!(seal.covered % FLUSHED as u64 == 0 || seal.covered == 136);
        assert_eq!(seal.covered + seal.uncovered, reader.message_count());
        most_uncovered = most_uncovered.max(seal.uncovered);
        let to = sealed.folder.path().join(format!("repaired_{round}"));
        let repaired = repair(&file, Some(&to)).unwrap().unwrap();
        assert_eq!(repaired.seal.as_ref(), Some(&seal));
        let kept = Reader::open(&to).unwrap();
        assert!(kept.wholeness().is_whole() && kept.repair_notes().is_some());
        assert_eq!(seal_of(&kept), Some(seal.clone()), "{length} bytes");
        assert_eq!(kept.ended(), Some("repaired"));
        let covers = match seal.covered {
            0 => "covers none of them".to_owned(),
            covered => format!("{covered} messages"),
        };
        assert!(repaired.to_string().contains(&covers), "{repaired}");
    }
    // A seal follows its messages at once; a cut between the two leaves them uncovered.
    assert!(most_uncovered <= FLUSHED as u64, "{most_uncovered}");
}

/// Only metadata.yaml is missing.
#[test]
fn a_repair_of_a_whole_file_keeps_the_last_seal() {
    let sealed = Sealed::new();
    let directory = sealed.file.parent().unwrap();
    fs::remove_file(directory.join("metadata.yaml")).unwrap();
    let repaired = repair(directory, None).unwrap().unwrap();
    let seal = opened(&repaired.directory);
    assert_eq!(Some(&seal), repaired.seal.as_ref());
    assert!(
        seal.holds() && seal.is_final && seal.uncovered == 0,
        "{seal:?}"
    );
    let text = repaired.to_string();
    assert!(text.contains("covers all of the 136 messages"), "{text}");
    // The repaired recording is found by readers that use its metadata.yaml.
    sample::assert_reads_back(&Reader::open(&repaired.directory).unwrap(), &sample(100));
}

/// A chunk in the middle is damaged: what precedes it is still proved, and the repair says what is not.
#[test]
fn a_repair_that_leaves_out_a_chunk_says_what_its_seal_still_covers() {
    let sealed = Sealed::new();
    let mut bytes = fs::read(&sealed.file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&sealed.file, &bytes).unwrap();
    let repaired = repair(sealed.file.parent().unwrap(), None)
        .unwrap()
        .unwrap();
    assert_eq!(repaired.left_out, 1);
    let seal = opened(&repaired.directory);
    assert_eq!(Some(&seal), repaired.seal.as_ref());
    assert!(
        !seal.holds() && seal.covered > 0 && seal.uncovered > 0,
        "{seal:?}"
    );
    let text = repaired.to_string();
    let expected = format!(
        "covers the first {} messages only, and does not hold",
        seal.covered
    );
    assert!(text.contains(&expected), "{text}");
}

#[test]
fn a_repair_of_several_files_says_that_their_seals_are_lost() {
    let folder = TempDir::new().unwrap();
    let key = SealKey::fresh().unwrap();
    let [first, second] =
        ["a", "b"].map(|it| write(folder.path(), it, &key, ChunkCompression::None, &sample(10)));
    fs::rename(second.join("b_0.mcap"), first.join("a_1.mcap")).unwrap();
    fs::remove_file(first.join("metadata.yaml")).unwrap();
    let repaired = repair(&first, None).unwrap().unwrap();
    assert!(repaired.seals_lost && repaired.seal.is_none());
    assert!(
        repaired.to_string().contains("seals were lost"),
        "{repaired}"
    );
    let reader = Reader::open(&repaired.directory).unwrap();
    assert_eq!(seal_of(&reader), None);
    assert_eq!(reader.message_count(), 2 * sample(10).len() as u64);
}
