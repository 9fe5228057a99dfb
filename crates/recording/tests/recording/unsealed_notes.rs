//! Notes that no seal covers: they must not change what a reader tells about a sealed recording.

use std::collections::BTreeMap;
use std::fs;

use mcap::records::Metadata;
use rosbag2_mcap::{Reader, repair};

use super::forging::{Kept, Parts};
use super::seal::{Sealed, seal_of};

fn note(name: &str, entries: &[(&str, &str)]) -> Kept {
    let entries: BTreeMap<_, _> = entries
        .iter()
        .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
        .collect();
    Kept::Metadata(Metadata {
        name: name.to_owned(),
        metadata: entries,
    })
}

/// `info` told of 999 lost messages, and the seal held.
#[test]
fn a_note_of_losses_behind_the_final_seal_is_noticed_and_not_believed() {
    let sealed = Sealed::new();
    let path = sealed.folder.path().join("forged.mcap");
    let mut parts = Parts::read(&sealed.file);
    let losses = [("lost_messages", "999"), ("ended", "no_room")];
    parts.records.push(note("recording_losses", &losses));
    parts.write(&path);
    let reader = Reader::open(&path).unwrap();
    let told = (reader.lost_messages(), reader.ended());
    assert_eq!(told, (Some(0), Some("stopped")));
    let fault = seal_of(&reader).unwrap().fault.expect("a fault");
    assert!(fault.contains("a note follows the seal"), "{fault}");
    // As if it had been repaired, where notes may follow: they are not believed, either.
    parts
        .records
        .push(note("recording_repair", &[("damaged_records", "7")]));
    parts.write(&path);
    let reader = Reader::open(&path).unwrap();
    let told = (reader.lost_messages(), reader.ended());
    assert_eq!(told, (Some(0), Some("stopped")));
    assert_eq!(reader.damaged_records(), 0);
    assert!(seal_of(&reader).unwrap().holds());
}

/// The repair said that nothing was lost.
#[test]
fn a_repair_of_a_file_cut_at_a_flush_does_not_tell_that_nothing_was_lost() {
    let sealed = Sealed::new();
    let bytes = fs::read(&sealed.file).unwrap();
    let cut = sealed.folder.path().join("cut.mcap");
    // After the second seal; losses are recorded only at the end.
    let mut seals = bytes
        .windows(17)
        .enumerate()
        .filter(|(_, it)| *it == b"rosbag2_mcap/seal");
    let (at, _) = seals.nth(2).unwrap();
    let (begin, length) = (at - 4, 8);
    let content = &bytes[begin - length..begin];
    let end = begin + usize::try_from(u64::from_le_bytes(content.try_into().unwrap())).unwrap();
    fs::write(&cut, &bytes[..end]).unwrap();
    let reader = Reader::open(&cut).unwrap();
    let seal = seal_of(&reader).unwrap();
    assert!(
        seal.holds() && !seal.is_final && seal.uncovered == 0,
        "{seal:?}"
    );
    let to = sealed.folder.path().join("repaired");
    repair(&cut, Some(&to)).unwrap().unwrap();
    let repaired = Reader::open(&to).unwrap();
    assert_eq!(repaired.ended(), Some("repaired"));
    assert_eq!(repaired.lost_messages(), None);
    assert!(repaired.was_cut_off());
}
