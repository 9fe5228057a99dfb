//! The error for a bad recording tells what is wrong and what to do.

use std::fs;
use std::path::{Path, PathBuf};

use rosbag2_mcap::{ChunkCompression, Decoder, Reader, RecordingError, repair};

use super::sample::{self, sample};

struct Bag {
    _folder: tempfile::TempDir,
    directory: PathBuf,
    file: PathBuf,
}

fn bag() -> Bag {
    bag_of(ChunkCompression::None)
}

fn bag_of(compression: ChunkCompression) -> Bag {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, compression, &sample(3000));
    let file = directory.join("bag_0.mcap");
    Bag {
        _folder: folder,
        directory,
        file,
    }
}

/// The error for a file with this content.
fn error_for(content: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    fs::write(&path, content).unwrap();
    error_for_path(&path)
}

fn error_for_path(path: &Path) -> String {
    let error = Reader::open(path).unwrap_err();
    assert!(error.is_bad_input(), "{error:?}");
    error.to_string()
}

fn assert_says(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{part:?} is not in: {said}");
    }
}

#[test]
fn files_that_are_not_mcap() {
    let text = error_for(b"time,v1\n0,0\n");
    assert_says(
        &text,
        &[
            "not an MCAP file",
            "found 74 69 6d 65",
            "give the directory of a recording",
        ],
    );
    assert_says(
        &error_for(b""),
        &["is empty (0 bytes)", "nothing to repair"],
    );
    assert_says(&error_for(b"\x89MCA"), &["cut off in its first bytes"]);
    assert_says(
        &error_for(b"SQLite format 3\0"),
        &["rosbag2 in SQLite", "ros2 bag convert"],
    );
    assert_says(&error_for(b"#ROSBAG V2.0\n"), &["ROS 1", "rosbags-convert"]);
    assert_says(
        &error_for(&[0x28, 0xb5, 0x2f, 0xfd, 0, 0, 0, 0]),
        &["zstd -d"],
    );
}

#[test]
fn paths_that_are_not_recordings() {
    let folder = tempfile::tempdir().unwrap();
    assert_says(
        &error_for_path(&folder.path().join("nowhere")),
        &["does not exist", "give the directory"],
    );
    assert_says(
        &error_for_path(folder.path()),
        &["no metadata.yaml", "no .mcap file"],
    );
}

#[test]
fn a_directory_without_metadata() {
    let bag = bag();
    fs::remove_file(bag.directory.join("metadata.yaml")).unwrap();
    let said = error_for_path(&bag.directory);
    assert_says(&said, &["no metadata.yaml", "bag_0.mcap", "repair"]);
    // The file itself is whole; the repair writes the missing metadata.yaml.
    assert!(Reader::open(&bag.file).unwrap().wholeness().is_whole());
    let repaired = repair(&bag.directory, None).unwrap().unwrap();
    assert_says(&repaired.to_string(), &["without metadata.yaml"]);
    sample::assert_reads_back(&Reader::open(&repaired.directory).unwrap(), &sample(3000));
}

#[test]
fn metadata_that_does_not_match() {
    let bag = bag();
    let path = bag.directory.join("metadata.yaml");
    let good = fs::read_to_string(&path).unwrap();
    let said_with = |text: &str| {
        fs::write(&path, text).unwrap();
        error_for_path(&bag.directory)
    };
    assert_says(&said_with("a: [1"), &["metadata.yaml", "repair"]);
    let repaired = repair(&bag.directory, None).unwrap().unwrap();
    assert_says(&repaired.to_string(), &["with a damaged metadata.yaml"]);
    sample::assert_reads_back(&Reader::open(&repaired.directory).unwrap(), &sample(3000));
    assert_says(&said_with("{}"), &["rosbag2_bagfile_information"]);
    assert_says(
        &said_with(&good.replace("identifier: mcap", "identifier: sqlite3")),
        &["found sqlite3", "ros2 bag convert"],
    );
    assert_says(
        &said_with(&good.replace("bag_0.mcap", "bag_7.mcap")),
        &["bag_7.mcap, which is not in the same directory"],
    );
    let modes = good.replace("compression_mode: ''", "compression_mode: FILE");
    assert_ne!(modes, good);
    assert_says(
        &said_with(&modes),
        &["compressed by file", "ros2 bag convert"],
    );
    // Of a path that leads out of the directory only the name counts.
    fs::write(
        &path,
        good.replace("- bag_0.mcap", "- ../../etc/bag_0.mcap"),
    )
    .unwrap();
    Reader::open(&bag.directory).unwrap();
}

/// Wherever a file ends, exactly what precedes the cut is read and saved.
#[test]
fn of_a_file_cut_at_200_places_everything_before_the_cut_is_saved() {
    const CUTS: usize = 200;
    let bag = bag_of(ChunkCompression::Lz4);
    let whole = fs::read(&bag.file).unwrap();
    fs::remove_file(bag.directory.join("metadata.yaml")).unwrap();
    let expected = sample(3000);
    let mut last = 0;
    for cut in 1..=CUTS {
        fs::write(&bag.file, &whole[..whole.len() * cut / (CUTS + 1)]).unwrap();
        let reader = Reader::open(&bag.file).unwrap();
        assert!(!reader.wholeness().is_whole(), "cut {cut}");
        let read = reader.message_count();
        assert!(read >= last, "cut {cut}: {read} after {last}");
        last = read;
        let saved = bag.directory.with_file_name(format!("cut_{cut}"));
        if reader.topics().is_empty() {
            let nothing = repair(&bag.directory, Some(&saved));
            assert!(
                matches!(nothing, Err(RecordingError::NothingToSave { .. })),
                "cut {cut}"
            );
            continue;
        }
        let repaired = repair(&bag.directory, Some(&saved)).unwrap().unwrap();
        assert_eq!(repaired.messages, read, "cut {cut}");
        let copy = Reader::open(&saved).unwrap();
        assert!(copy.wholeness().is_whole(), "cut {cut}");
        sample::assert_reads_back(&copy, &expected[..usize::try_from(read).unwrap()]);
    }
    assert!(last > 1500, "{last}");
}

#[test]
fn a_truncated_file_is_read_up_to_its_end_and_repaired() {
    for compression in sample::COMPRESSIONS {
        let bag = bag_of(compression);
        let whole = fs::read(&bag.file).unwrap();
        let cut = whole.len() / 2;
        fs::write(&bag.file, &whole[..cut]).unwrap();
        fs::remove_file(bag.directory.join("metadata.yaml")).unwrap();
        let reader = Reader::open(&bag.file).unwrap();
        assert!(!reader.wholeness().is_whole());
        assert_says(
            &reader.wholeness().to_string(),
            &[
                "not whole",
                "bag_0.mcap is cut off in the record that begins at byte",
            ],
        );
        let read = reader.message_count();
        assert!(read > 500 && read < 3000, "{read}");
        let repaired = repair(&bag.directory, None).unwrap().unwrap();
        assert_eq!((repaired.messages, repaired.in_record), (read, true));
        let copy = Reader::open(&repaired.directory).unwrap();
        assert!(copy.wholeness().is_whole());
        assert_eq!(
            (copy.message_count(), copy.compression(), copy.ended()),
            (read, compression, Some("repaired"))
        );
        let expected = sample(3000);
        sample::assert_reads_back(&copy, &expected[..usize::try_from(read).unwrap()]);
        // The original is unchanged, and nothing is overwritten.
        assert_eq!(fs::read(&bag.file).unwrap(), whole[..cut]);
        assert!(matches!(
            repair(&bag.directory, None),
            Err(RecordingError::Exists { .. })
        ));
        assert_eq!(repair(&repaired.directory, None).unwrap(), None);
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_counted() {
    for compression in sample::COMPRESSIONS {
        let bag = bag_of(compression);
        let mut bytes = fs::read(&bag.file).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let mut chunks: Vec<_> = summary
            .chunk_indexes
            .iter()
            .filter(|it| it.message_index_length > 0)
            .collect();
        chunks.sort_by_key(|it| it.chunk_start_offset);
        let chunk = chunks[1];
        let middle = chunk.chunk_start_offset + chunk.chunk_length - chunk.compressed_size / 2;
        bytes[usize::try_from(middle).unwrap()] ^= 0x10;
        fs::write(&bag.file, &bytes).unwrap();
        let reader = Reader::open(&bag.file).unwrap();
        assert_eq!(reader.wholeness().damaged, 1);
        let said = reader.wholeness().to_string();
        assert_says(&said, &[&format!("at byte {}", chunk.chunk_start_offset)]);
        let all = sample(3000).len() as u64;
        assert_eq!(reader.message_count(), all - 500);
        assert_eq!(
            reader
                .messages()
                .filter(|it| matches!(it, Err(RecordingError::Damaged { .. })))
                .count(),
            1
        );
        assert_eq!(
            reader.messages().filter_map(Result::ok).count() as u64,
            all - 500
        );
        let repaired = repair(&bag.file, None).unwrap().unwrap();
        assert_eq!((repaired.messages, repaired.left_out), (all - 500, 1));
    }
}

/// The reader does not trust the indexes.
#[test]
fn a_wrong_index_changes_nothing() {
    let bag = bag();
    let mut bytes = fs::read(&bag.file).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let data_end = summary
        .chunk_indexes
        .iter()
        .map(|it| it.chunk_start_offset + it.chunk_length)
        .max()
        .unwrap();
    // Everything behind the last chunk except the footer: indexes, statistics, offsets.
    let (begin, end) = (usize::try_from(data_end).unwrap(), bytes.len() - 37);
    let lengths = 9..;
    let mut at = begin;
    while at < end {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let next = at + lengths.start + usize::try_from(length).unwrap();
        // Metadata, end of data, schemas and channels stay as they are; they are not indexes.
        if !matches!(bytes[at], 0x0c | 0x0f | 0x03 | 0x04) {
            bytes[at + 9..next].fill(0xff);
        }
        at = next;
    }
    fs::write(&bag.file, &bytes).unwrap();
    let reader = Reader::open(&bag.file).unwrap();
    assert!(reader.wholeness().is_whole());
    sample::assert_reads_back(&reader, &sample(3000));
}

#[test]
fn zeros_at_the_end_are_not_records() {
    let bag = bag();
    let mut bytes = fs::read(&bag.file).unwrap();
    bytes.truncate(bytes.len() / 2);
    let end = bytes.len() + 100_000;
    bytes.resize(end, 0);
    fs::write(&bag.file, &bytes).unwrap();
    let reader = Reader::open(&bag.file).unwrap();
    assert!(!reader.wholeness().is_whole());
    assert!(reader.message_count() > 500);
}

/// A recording of another program, with other types and messages that are not CDR.
#[test]
fn a_recording_of_another_program_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let metadata = std::collections::BTreeMap::new();
    let ros = writer
        .add_schema("other_msgs/msg/Pair", "ros2msg", b"int32 a\nfloat32 b\n")
        .unwrap();
    let proto = writer
        .add_schema("other.Thing", "protobuf", b"\x00\x01")
        .unwrap();
    let ros = writer.add_channel(ros, "/pair", "cdr", &metadata).unwrap();
    let proto = writer
        .add_channel(proto, "/thing", "protobuf", &metadata)
        .unwrap();
    for (channel_id, data) in [
        (ros, &[0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 128, 63][..]),
        (proto, &[8, 1]),
    ] {
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: 5,
            publish_time: 5,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.lost_messages(), None);
    let messages: Vec<_> = reader.messages().map(Result::unwrap).collect();
    let [pair, thing] = reader.topics() else {
        panic!("two topics")
    };
    let content = Decoder::new(pair).unwrap().decode(&messages[0]).unwrap();
    assert_eq!(
        serde_json::to_string(&content).unwrap(),
        r#"{"a":7,"b":1.0}"#
    );
    let error = Decoder::new(thing).unwrap_err();
    assert_says(
        &error.to_string(),
        &[
            "/thing",
            "other.Thing",
            "expected messages in cdr",
            "protobuf",
        ],
    );
    assert_says(
        &pair
            .check_definition("int32 a\nfloat64 b\n")
            .unwrap_err()
            .to_string(),
        &[
            "/pair",
            "other_msgs/msg/Pair",
            "expected other_msgs/Pair: float64 b",
        ],
    );
}

#[test]
fn definitions_that_make_no_sense() {
    let said = |name: &str, text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.mcap");
        let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
        let schema = writer.add_schema(name, "ros2msg", text.as_bytes()).unwrap();
        writer
            .add_channel(schema, "/x", "cdr", &std::collections::BTreeMap::new())
            .unwrap();
        writer.finish().unwrap();
        Decoder::new(&Reader::open(&path).unwrap().topics()[0])
            .unwrap_err()
            .to_string()
    };
    let dependency =
        |name: &str, text: &str| format!("\n{}\nMSG: a/{name}\n{text}\n", "=".repeat(80));
    assert_says(&said("a/msg/A", "a/B b"), &["a/B, which is not defined"]);
    assert_says(
        &said("a/msg/A", &format!("B b{}", dependency("B", "A[] a"))),
        &["a/A"],
    );
    let cycle = format!("B b{}{}", dependency("B", "C c"), dependency("C", "B b"));
    assert_says(&said("a/msg/A", &cycle), &["contains itself"]);
    let chain: String = (0..1000)
        .map(|index| dependency(&format!("T{index}"), &format!("T{} x", index + 1)))
        .collect();
    assert_says(
        &said("a/msg/A", &format!("T0 x{chain}")),
        &["inside each other"],
    );
    assert_says(&said("a/msg/A", "what is this"), &["cannot be read"]);
}

/// The decoder does not trust the lengths in a message.
#[test]
fn messages_that_announce_more_than_they_contain() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let text = format!(
        "string[] names\nNothing[] nothing\n\n{}\nMSG: a/Nothing\nuint8[0] none\n",
        "=".repeat(80)
    );
    let schema = writer
        .add_schema("a/msg/A", "ros2msg", text.as_bytes())
        .unwrap();
    let channel_id = writer
        .add_channel(schema, "/x", "cdr", &std::collections::BTreeMap::new())
        .unwrap();
    let messages: [&[u8]; 5] = [
        &[],
        &[0, 7, 0, 0],
        &[0, 1, 0, 0, 255, 255, 255, 255],
        &[0, 1, 0, 0, 1, 0, 0, 0, 255, 255, 255, 127],
        &[0, 1, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255],
    ];
    for data in messages {
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: 5,
            publish_time: 5,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    let reader = Reader::open(&path).unwrap();
    let decoder = Decoder::new(&reader.topics()[0]).unwrap();
    for message in reader.messages() {
        let error = decoder.decode(&message.unwrap()).unwrap_err();
        assert_says(&error.to_string(), &["/x", "at 5 ns", "a/msg/A"]);
    }
}

#[test]
fn repair_tells_what_it_cannot_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    fs::write(&path, b"\x89MCAP0\r\n").unwrap();
    let error = repair(&path, None).unwrap_err();
    assert_says(
        &error.to_string(),
        &["nothing in it can be saved", "declares no topic"],
    );
    assert!(error.is_bad_input());
    assert!(matches!(
        repair(folder.path(), None),
        Err(RecordingError::NothingToSave { .. })
    ));
    let bag = bag();
    let whole = fs::read(&bag.file).unwrap();
    fs::write(&bag.file, &whole[..whole.len() - 3]).unwrap();
    let nowhere = folder.path().join("no/such/folder");
    assert!(repair(&bag.file, Some(&nowhere)).is_err());
    let elsewhere = folder.path().join("elsewhere");
    assert_eq!(
        repair(&bag.file, Some(&elsewhere))
            .unwrap()
            .unwrap()
            .directory,
        elsewhere
    );
    assert!(elsewhere.join("elsewhere_0.mcap").exists());
}
