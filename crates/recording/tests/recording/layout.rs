//! What a recording contains, judged by our reader and by the text of metadata.yaml.

use std::fs;

use rosbag2_mcap::{ChunkCompression, Reader, RecordingError, Writer, WriterOptions};
use serde_yaml_ng::Value;

use super::sample::{self, COMPRESSIONS, sample, text_entry, text_topics, topics};

#[test]
fn every_message_reads_back_in_order() {
    let messages = sample(3000);
    for compression in COMPRESSIONS {
        let folder = tempfile::tempdir().unwrap();
        let directory = folder.path().join("bag");
        let finished = sample::write(&directory, compression, &messages);
        assert_eq!(
            (finished.messages, finished.lost),
            (messages.len() as u64, 0)
        );
        let reader = Reader::open(&directory).unwrap();
        assert!(reader.wholeness().is_whole(), "{}", reader.wholeness());
        assert_eq!(
            (reader.compression(), reader.bytes()),
            (compression, finished.bytes)
        );
        assert_eq!(
            (reader.lost_messages(), reader.ended()),
            (Some(0), Some("stopped"))
        );
        assert_eq!(reader.profile(), "ros2");
        assert_eq!(reader.application(), Some("recording"));
        sample::assert_reads_back(&reader, &messages);
        // The file alone contains as much.
        let file = Reader::open(&directory.join("bag_0.mcap")).unwrap();
        sample::assert_reads_back(&file, &messages);
    }
}

#[test]
fn a_recording_without_messages_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let finished = sample::write(&directory, ChunkCompression::None, &[]);
    assert_eq!(finished.messages, 0);
    let reader = Reader::open(&directory).unwrap();
    assert_eq!((reader.span(), reader.message_count()), (None, 0));
    assert!(reader.wholeness().is_whole());
    assert_eq!(reader.topics().len(), topics().len());
}

#[test]
fn nothing_is_overwritten_and_nothing_undeclared_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let options = WriterOptions::default();
    sample::write(&directory, ChunkCompression::None, &[]);
    let again = Writer::create(&directory, &options, &topics()).unwrap_err();
    assert!(matches!(again, RecordingError::Exists { .. }), "{again}");
    let twice = [text_topics(), text_topics()].concat();
    let error = Writer::create(&folder.path().join("c"), &options, &twice).unwrap_err();
    assert!(
        matches!(error, RecordingError::DuplicateTopic { .. }),
        "{error}"
    );
    let mut writer = Writer::create(&folder.path().join("d"), &options, &text_topics()).unwrap();
    let error = writer.write(&text_entry(1, 0, "", false)).unwrap_err();
    assert!(
        matches!(
            error,
            RecordingError::UndeclaredTopic {
                index: 1,
                topics: 1
            }
        ),
        "{error}"
    );
}

/// Like a bag that rosbag2 has split.
#[test]
fn a_directory_of_several_files_is_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("a"), folder.path().join("b"));
    let messages = sample(100);
    let (begin, end) = messages.split_at(70);
    for (directory, part) in [(&first, begin), (&second, end)] {
        let mut writer = Writer::create(directory, &WriterOptions::default(), &topics()).unwrap();
        part.iter().for_each(|it| writer.write(it).unwrap());
        writer.finish().unwrap();
    }
    fs::rename(second.join("b_0.mcap"), first.join("a_1.mcap")).unwrap();
    let metadata = first.join("metadata.yaml");
    let text = fs::read_to_string(&metadata).unwrap();
    let listed = "relative_file_paths:\n  - a_0.mcap\n";
    assert!(text.contains(listed), "{text}");
    fs::write(
        &metadata,
        text.replace(listed, &format!("{listed}  - a_1.mcap\n")),
    )
    .unwrap();
    let reader = Reader::open(&first).unwrap();
    assert_eq!(reader.files().len(), 2);
    assert_eq!(reader.topics().len(), topics().len());
    sample::assert_reads_back(&reader, &messages);
}

#[test]
fn metadata_yaml_contains_what_rosbag2_expects() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(10);
    sample::write(&directory, ChunkCompression::None, &messages);
    let text = fs::read_to_string(directory.join("metadata.yaml")).unwrap();
    let document: Value = serde_yaml_ng::from_str(&text).unwrap();
    let information = &document["rosbag2_bagfile_information"];
    assert_eq!(information["version"], 9);
    assert_eq!(information["storage_identifier"], "mcap");
    assert_eq!(information["relative_file_paths"][0], "bag_0.mcap");
    assert_eq!(information["message_count"], messages.len());
    assert_eq!(
        information["starting_time"]["nanoseconds_since_epoch"],
        sample::START
    );
    assert_eq!(information["duration"]["nanoseconds"], 20_000_000);
    let listed = information["topics_with_message_count"]
        .as_sequence()
        .unwrap();
    assert_eq!(listed.len(), topics().len());
    let status = listed
        .iter()
        .find(|it| it["topic_metadata"]["name"] == "/latched")
        .unwrap();
    assert_eq!(status["message_count"], 2);
    let profile = &status["topic_metadata"]["offered_qos_profiles"][0];
    assert_eq!(
        (&profile["durability"], &profile["depth"]),
        (&Value::from("transient_local"), &Value::from(1))
    );
    assert_eq!(profile["deadline"]["sec"], 9_223_372_036_u64);
    // The directory contains nothing else.
    assert_eq!(fs::read_dir(&directory).unwrap().count(), 2);
}
