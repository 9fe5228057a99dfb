//! Recordings without a seal, or with less of a seal than is demanded, as a user verifies them.

use std::fs;
use std::path::Path;

use column_twin::endpoints::NodeKind;
use column_twin::evidence::Topics;
use column_twin::recording::{Entry, SealKey, Writer, WriterOptions};
use tempfile::TempDir;

use super::commands::typed;
use super::copies::messages;
use super::forging::Parts;

/// A recorded impact in `bag`, with these further options.
fn recorded(options: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let (code, _, said) = typed(
        folder.path(),
        format!("simulate --record bag -p record.compression:=none {options}").trim_end(),
    );
    assert_eq!(code, 0, "{said}");
    folder
}

fn file(folder: &TempDir) -> std::path::PathBuf {
    folder.path().join("bag/bag_0.mcap")
}

/// `verify` said "Equal", and `export` gave each of both values the name of the other.
#[test]
fn swapped_field_names_in_the_definition_of_a_type_are_a_difference() {
    let folder = recorded("-p record.seal:=false");
    let mut parts = Parts::read(&file(&folder));
    let swapped = |text: &str| {
        let swap = |line: &str| match line.split(['#', ' ']).collect::<Vec<_>>()[..] {
            ["float64", "v1", ..] => line.replacen("v1", "u1", 1),
            ["float64", "u1", ..] => line.replacen("u1", "v1", 1),
            _ => line.to_owned(),
        };
        text.lines()
            .map(|line| swap(line) + "\n")
            .collect::<String>()
    };
    for (header, text) in parts.schemas.values_mut() {
        if header.name == "column_twin_msgs/msg/ColumnState" {
            let changed = swapped(std::str::from_utf8(text).unwrap());
            assert_ne!(changed.as_bytes(), &text[..]);
            *text = changed.into_bytes();
        }
    }
    parts.write(&folder.path().join("forged.mcap"));
    let (code, text, fault) = typed(folder.path(), "verify forged.mcap");
    assert_eq!(code, 1, "{text}{fault}");
    assert!(text.contains("the definition of its type"), "{text}");
    // The name of the type alone is a definition, too.
    let mut parts = Parts::read(&file(&folder));
    for (header, _) in parts.schemas.values_mut() {
        if header.name == "column_twin_msgs/msg/ColumnState" {
            header.name = "other_twin/msg/ColumnState".to_owned();
        }
    }
    parts.write(&folder.path().join("renamed.mcap"));
    let (code, text, fault) = typed(folder.path(), "verify renamed.mcap");
    assert_eq!(code, 1, "{text}{fault}");
}

/// The recorded impact again, flushed many times, as a node writes it; sealed at each flush, if there is a key.
fn in_many_chunks(folder: &TempDir, seal: Option<SealKey>) {
    let topics = Topics::of_default_node(NodeKind::Single)
        .declared()
        .unwrap();
    let options = WriterOptions {
        sync: false,
        seal,
        ..WriterOptions::default()
    };
    let mut writer = Writer::create(&folder.path().join("many"), &options, &topics).unwrap();
    for (index, message) in messages(&folder.path().join("bag")).iter().enumerate() {
        let topic = topics.iter().position(|it| *it.name == *message.topic);
        let entry = Entry {
            topic: topic.unwrap(),
            log_time: message.log_time,
            publish_time: message.publish_time,
            data: message.data.clone().into(),
            checkpoint: false,
        };
        writer.write(&entry).unwrap();
        if index % 20 == 19 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Flips a bit in the middle of each chunk with messages but the first and the last.
fn damage_most_chunks(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let mut chunks: Vec<_> = summary
        .chunk_indexes
        .iter()
        .filter(|it| !it.message_index_offsets.is_empty())
        .map(|it| (it.chunk_start_offset, it.chunk_length))
        .collect();
    chunks.sort_unstable();
    assert!(chunks.len() > 4, "{chunks:?}");
    for (offset, length) in &chunks[1..chunks.len() - 1] {
        bytes[usize::try_from(offset + length / 2).unwrap()] ^= 1;
    }
    fs::write(path, bytes).unwrap();
}

/// A flipped bit drops a whole chunk, and what was left verified, even if that was two messages.
#[test]
fn a_recording_of_which_flipped_bits_dropped_most_chunks_does_not_verify() {
    let folder = recorded("");
    in_many_chunks(&folder, None);
    let (code, text, _) = typed(folder.path(), "verify many");
    assert_eq!(code, 0, "{text}");
    let undamaged = text;
    damage_most_chunks(&folder.path().join("many/many_0.mcap"));
    let (code, text, fault) = typed(folder.path(), "verify many");
    let first = text.lines().next().unwrap();
    assert_eq!(code, 1, "{text}{fault}");
    assert!(first.starts_with("Compared "), "{first}");
    assert!(
        fault.contains("could be compared") || fault.contains("could be checked"),
        "{fault}"
    );
    let first = undamaged.lines().next().unwrap();
    assert!(
        first.starts_with("Compared ") && first.ends_with(" (100.0 %)"),
        "{first}"
    );
    // The same after a repair.
    let (code, _, said) = typed(folder.path(), "repair many");
    assert_eq!(code, 3, "{said}");
    let (code, text, fault) = typed(folder.path(), "verify many_repaired");
    assert_eq!(code, 1, "{text}{fault}");
}

/// The file with only what precedes the final seal looks as if a crash had cut it off, and passed `--require-seal`.
#[test]
fn a_file_cut_at_a_flush_fails_where_a_seal_is_required_and_is_not_called_complete() {
    let folder = recorded("");
    in_many_chunks(&folder, Some(SealKey::fresh().unwrap()));
    let bytes = fs::read(folder.path().join("many/many_0.mcap")).unwrap();
    let mut seals = bytes
        .windows(20)
        .enumerate()
        .filter(|(_, it)| it.starts_with(b"\x11\0\0\0rosbag2_mcap/sea"))
        .map(|(at, _)| at);
    let at = seals.nth(2).unwrap();
    let length = u64::from_le_bytes(bytes[at - 8..at].try_into().unwrap());
    let end = at + usize::try_from(length).unwrap();
    assert!(end < bytes.len());
    fs::write(folder.path().join("cut.mcap"), &bytes[..end]).unwrap();
    let (_, text, _) = typed(folder.path(), "info cut.mcap");
    assert!(text.contains("it has no final seal"), "{text}");
    let (code, text, fault) = typed(folder.path(), "verify cut.mcap --require-seal");
    assert_eq!(code, 1, "{text}{fault}");
    assert!(fault.contains("has no final seal"), "{fault}");
    let (code, _, said) = typed(folder.path(), "repair cut.mcap -o kept");
    // Every record that the file has was saved.
    assert_eq!(code, 0, "{said}");
    let (_, text, _) = typed(folder.path(), "info kept");
    assert!(
        text.contains("Complete    no: its end was cut off"),
        "{text}"
    );
    assert!(text.contains("Lost        unknown"), "{text}");
}

/// Anyone can make a key and seal with it what never was recorded.
#[test]
fn a_seal_by_a_key_that_is_not_trusted_does_not_say_as_they_were_recorded() {
    let folder = recorded("");
    for line in ["info bag", "verify bag"] {
        let (code, text, _) = typed(folder.path(), line);
        assert_eq!(code, 0, "{text}");
        assert!(!text.contains("as they were recorded"), "{text}");
        assert!(
            text.contains("as the owner of that key has sealed them"),
            "{text}"
        );
    }
}
