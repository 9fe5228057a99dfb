//! Recordings that were made to keep their reader busy: each is read in a time in proportion to its length, or rejected.
//! Without that, these tests would take minutes to hours.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use rosbag2_mcap::{PublicKey, Reader, RecordingError, SealKey};

use super::sample::{self, sample};

/// A file that never ends; the length that the system states of it is zero.
const ENDLESS: &str = "/dev/zero";

fn error_for(path: &Path) -> String {
    let error = Reader::open(path).unwrap_err();
    assert!(error.is_bad_input(), "{error:?}");
    error.to_string()
}

/// The directory of a recording with this `metadata.yaml`.
fn with_metadata(folder: &Path, text: &str) -> PathBuf {
    let directory = folder.join("bag");
    sample::write(
        &directory,
        rosbag2_mcap::ChunkCompression::None,
        &sample(10),
    );
    fs::write(directory.join("metadata.yaml"), text).unwrap();
    directory
}

fn metadata_for(text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    error_for(&with_metadata(folder.path(), text))
}

#[cfg(unix)]
#[test]
fn links_to_an_endless_file_are_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let directory = with_metadata(folder.path(), "");
    let link = directory.join("metadata.yaml");
    fs::remove_file(&link).unwrap();
    std::os::unix::fs::symlink(ENDLESS, &link).unwrap();
    let said = error_for(&directory);
    assert!(said.contains("larger than 16777216 bytes"), "{said}");
    let key = folder.path().join("key.pem");
    std::os::unix::fs::symlink(ENDLESS, &key).unwrap();
    let bad: [RecordingError; 2] = [
        SealKey::read(&key).unwrap_err(),
        PublicKey::read(&key).unwrap_err(),
    ];
    for said in bad.map(|it| it.to_string()) {
        assert!(said.contains("larger than 65536 bytes"), "{said}");
    }
}

#[test]
fn one_file_that_is_named_half_a_million_times_is_rejected() {
    let names = "- x/bag_0.mcap\n".repeat(500_000);
    let said = metadata_for(&format!(
        "rosbag2_bagfile_information:\n  storage_identifier: mcap\n  relative_file_paths:\n{}",
        names.replace("- ", "  - ")
    ));
    assert!(
        said.contains("each file once") && said.contains("bag_0.mcap"),
        "{said}"
    );
}

#[test]
fn metadata_of_nested_brackets_or_directives_is_rejected_before_it_is_parsed() {
    for (piece, expected) in [
        ("[", "brackets inside each other"),
        ("{", "brackets inside each other"),
        ("{a: [", "brackets inside each other"),
        ("- ", "entries inside each other"),
        ("-\t", "entries inside each other"),
        ("? ", "entries inside each other"),
        ("%TAG !a! x\n", "directive"),
    ] {
        let said = metadata_for(&piece.repeat(1_000_000 / piece.len()));
        assert!(
            said.contains("line 1") && said.contains(expected),
            "{piece}: {said}"
        );
    }
}

/// A file with these channels of one schema, and one message of each.
fn with_channels(
    path: &Path,
    schema: &str,
    channels: impl Iterator<Item = (String, BTreeMap<String, String>)>,
) {
    let file = fs::File::create(path).unwrap();
    let options = mcap::WriteOptions::new().compression(None);
    let mut writer = options.create(std::io::BufWriter::new(file)).unwrap();
    let schema = writer
        .add_schema("std_msgs/msg/String", "ros2msg", schema.as_bytes())
        .unwrap();
    for (id, (name, metadata)) in (1..).zip(channels) {
        writer
            .add_channel_with_id(id, schema, &name, "cdr", &metadata)
            .unwrap();
        let header = MessageHeader {
            channel_id: id,
            sequence: 0,
            log_time: 5,
            publish_time: 5,
        };
        writer
            .write_to_known_channel(&header, b"\0\x01\0\0\x01\0\0\0\0")
            .unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn as_many_topics_as_mcap_can_number_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let name = |index: u32| format!("/{}/{index}", "x".repeat(500));
    let channels = (1..=65_535).map(|index| (name(index), BTreeMap::new()));
    with_channels(&path, "string data\n", channels);
    let reader = Reader::open(&path).unwrap();
    assert_eq!(
        (reader.topics().len(), reader.message_count()),
        (65_535, 65_535)
    );
    assert!(reader.topics().iter().all(|it| it.messages == 1));
    let last = reader.messages().last().unwrap().unwrap();
    assert_eq!((&*last.topic, last.topic_index), (&*name(65_535), 65_534));
}

/// Each of these channels has a definition of 20 MB, which was read for each of them.
#[test]
fn many_channels_with_one_long_schema_are_one_topic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let schema = format!("string data\n#{}\n", "x".repeat(20_000_000));
    let channels = (1..=65_535).map(|_| ("/text".to_owned(), BTreeMap::new()));
    with_channels(&path, &schema, channels);
    let reader = Reader::open(&path).unwrap();
    assert_eq!((reader.topics().len(), reader.message_count()), (1, 65_535));
    assert_eq!(reader.topics()[0].schema.len(), schema.len());
    // Where they differ, as publishers of one topic may, the definition counts for each, and the bound on texts holds.
    let each = |index: u32| BTreeMap::from([("publisher".to_owned(), index.to_string())]);
    with_channels(
        &path,
        &schema,
        (1..=65_535).map(|it| ("/text".to_owned(), each(it))),
    );
    let reader = Reader::open(&path).unwrap();
    assert_eq!((reader.topics().len(), reader.message_count()), (1, 2));
    assert!(reader.wholeness().to_string().contains("64 MiB of schemas"));
}

#[test]
fn a_quality_of_service_of_nested_brackets_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), "[".repeat(3_000_000))]);
    let channels = (1..=20).map(|index| (format!("/text{index}"), metadata.clone()));
    with_channels(&path, "string data\n", channels);
    let reader = Reader::open(&path).unwrap();
    assert_eq!(reader.message_count(), 20);
    assert!(reader.topics().iter().all(|it| it.qos.is_none()));
}

/// Each chunk of zeros is within the limit of a chunk, and together they would unpack to 25 GB.
#[test]
fn chunks_that_unpack_to_gigabytes_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let options = mcap::WriteOptions::new()
        .compression(Some(mcap::Compression::Zstd))
        .chunk_size(None);
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = writer
        .add_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
        .unwrap();
    let channel_id = writer
        .add_channel(schema, "/text", "cdr", &BTreeMap::new())
        .unwrap();
    let header = MessageHeader {
        channel_id,
        sequence: 0,
        log_time: 5,
        publish_time: 5,
    };
    let zeros = vec![0; 250 << 20];
    writer.write_to_known_channel(&header, &zeros).unwrap();
    writer.flush().unwrap();
    writer.finish().unwrap();
    let whole = writer.into_inner().into_inner();
    // The chunk, a hundred times.
    let chunk = mcap::Summary::read(&whole).unwrap().unwrap().chunk_indexes[0].clone();
    let begin = usize::try_from(chunk.chunk_start_offset).unwrap();
    let end = begin + usize::try_from(chunk.chunk_length).unwrap();
    let mut bytes = whole[..begin].to_vec();
    bytes.extend(whole[begin..end].repeat(100));
    fs::write(&path, &bytes).unwrap();
    let reader = Reader::open(&path).unwrap();
    assert_eq!(
        (reader.message_count(), reader.wholeness().damaged),
        (2, 98)
    );
    let said = reader.wholeness().to_string();
    assert!(said.contains("unpack to at most 255 times"), "{said}");
}

/// The reader waited for somebody to write into the pipe, without end.
#[cfg(unix)]
#[test]
fn a_pipe_in_place_of_the_metadata_is_rejected_and_not_waited_for() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let folder = tempfile::tempdir().unwrap();
    let directory = with_metadata(folder.path(), "");
    let pipe = directory.join("metadata.yaml");
    fs::remove_file(&pipe).unwrap();
    mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    let said = Reader::open(&directory).unwrap_err().to_string();
    assert!(said.contains("expected a file"), "{said}");
}
