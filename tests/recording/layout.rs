//! What stands in a recording, judged by the mcap crate's own reader and by the text of metadata.yaml.

use std::fs;

use column_twin::messages::column_twin::ImpactReport;
use column_twin::messages::{Message as _, cdr, find, type_hash::TypeHash};
use column_twin::parameters::Compression;
use column_twin::recording::{
    Decoder, OfferedQos, Reader, RecordingError, TopicInfo, Writer, WriterOptions, summarise_events,
};
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
        sample::assert_reads_back(&reader, &messages);
        // The file alone says as much.
        let file = Reader::open(&directory.join("bag_0.mcap")).unwrap();
        sample::assert_reads_back(&file, &messages);
        for topic in reader.topics() {
            topic.check_definition().unwrap();
        }
    }
}

/// By the mcap crate: summary, indexes, schemas, channels, in the words of rosbag2.
#[test]
fn the_file_is_laid_out_as_rosbag2_does() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(3000);
    sample::write(&directory, Compression::Zstd, &messages);
    let bytes = fs::read(directory.join("bag_0.mcap")).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.unwrap();
    assert_eq!(statistics.message_count, messages.len() as u64);
    assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
    assert!(statistics.chunk_count > 3);
    assert!(
        summary
            .chunk_indexes
            .iter()
            .any(|it| it.message_index_length > 0)
    );
    assert_eq!(summary.channels.len(), topics().len());
    for channel in summary.channels.values() {
        let schema = channel.schema.as_ref().unwrap();
        let interface = find(&schema.name).unwrap();
        assert_eq!(
            (schema.encoding.as_str(), channel.message_encoding.as_str()),
            ("ros2msg", "cdr")
        );
        assert_eq!(&*schema.data, interface.schema_text().unwrap().as_bytes());
        assert_eq!(
            channel.metadata["topic_type_hash"],
            TypeHash::of(interface).unwrap().to_string()
        );
        assert!(channel.metadata["offered_qos_profiles"].contains("history: keep_last"));
    }
    let names: Vec<_> = summary
        .metadata_indexes
        .iter()
        .map(|it| it.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["column_twin_start", "column_twin_losses", "rosbag2"]
    );
    let mut read = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        assert_eq!(message.unwrap().data[..4], [0, 1, 0, 0]);
        read += 1;
    }
    assert_eq!(read, messages.len());
}

#[test]
fn metadata_yaml_says_what_rosbag2_wants_to_know() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(10);
    sample::write(&directory, Compression::None, &messages);
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
    assert_eq!(information["duration"]["nanoseconds"], 20_000_002);
    let listed = information["topics_with_message_count"]
        .as_sequence()
        .unwrap();
    assert_eq!(listed.len(), topics().len());
    let status = listed
        .iter()
        .find(|it| it["topic_metadata"]["name"] == "/garage/twin_status")
        .unwrap();
    assert_eq!(status["message_count"], 1);
    let profile = &status["topic_metadata"]["offered_qos_profiles"][0];
    assert_eq!(
        (&profile["durability"], &profile["depth"]),
        (&Value::from("transient_local"), &Value::from(1))
    );
    assert_eq!(profile["deadline"]["sec"], 9_223_372_036_u64);
    // Nothing else is in the directory.
    assert_eq!(fs::read_dir(&directory).unwrap().count(), 2);
}

#[test]
fn the_reader_knows_topics_and_their_quality_of_service() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, Compression::Lz4, &sample(10));
    let reader = Reader::open(&directory).unwrap();
    for (found, declared) in reader.topics().iter().zip(topics()) {
        assert_eq!(
            (&*found.name, &*found.type_name),
            (&*declared.name, declared.type_name)
        );
        assert_eq!(found.qos, Some(declared.qos));
    }
    let notes = reader.start_notes().unwrap();
    assert_eq!(notes["program"], "column-twin");
    assert_eq!(notes["version"], env!("CARGO_PKG_VERSION"));
}

/// Every field of every type, taken apart by the recording's own definition, is what serde says of the struct.
#[test]
fn messages_are_taken_apart_by_the_definitions_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(100);
    sample::write(&directory, Compression::None, &messages);
    let reader = Reader::open(&directory).unwrap();
    let decoders: Vec<_> = reader
        .topics()
        .iter()
        .map(|topic| Decoder::new(topic).unwrap())
        .collect();
    for (found, expected) in reader.messages().zip(sample::in_order(&messages)) {
        let found = found.unwrap();
        let content = decoders[found.topic_index].decode(&found).unwrap();
        let words = ["\"NaN\"", "\"Infinity\"", "\"-Infinity\""];
        let text = words
            .iter()
            .fold(serde_json::to_string(&content).unwrap(), |text, word| {
                text.replace(word, "null")
            });
        let content: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(content, expected.content, "{}", found.topic);
    }
}

#[test]
fn impacts_are_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, Compression::None, &sample(10));
    let (events, beyond) = summarise_events(&Reader::open(&directory).unwrap()).unwrap();
    assert_eq!((events.len(), beyond), (2, 0));
    let [hit, refused] = &events[..] else {
        unreachable!("there are two")
    };
    assert_eq!(
        (hit.event_id.as_str(), hit.column_id.as_str()),
        ("event 0", "A3")
    );
    assert_eq!(
        (hit.stamp, hit.mass, hit.velocity),
        (Some(sample::START), Some(1500.0), Some(10.0))
    );
    assert_eq!(
        (hit.outcome, hit.max_v1, hit.residual_v1),
        (Some("plastic"), Some(0.0946), Some(0.08934))
    );
    assert_eq!(hit.forecast_max_v1, Some(0.0946));
    assert_eq!(
        refused.refused.as_deref(),
        Some("mass and velocity must be above 0")
    );
    assert_eq!(refused.outcome, None);
}

#[test]
fn a_recording_without_messages_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let finished = sample::write(&directory, Compression::None, &[]);
    assert_eq!(finished.messages, 0);
    let reader = Reader::open(&directory).unwrap();
    assert_eq!((reader.span(), reader.message_count()), (None, 0));
    assert!(reader.wholeness().is_whole());
    assert_eq!(reader.topics().len(), topics().len());
}

#[test]
fn nothing_is_overwritten_and_nothing_unknown_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let options = WriterOptions::default();
    sample::write(&directory, Compression::None, &[]);
    let again = Writer::create(&directory, &options, &topics()).unwrap_err();
    assert!(matches!(again, RecordingError::Exists { .. }), "{again}");
    let qos = OfferedQos {
        reliable: true,
        transient_local: false,
        depth: 1,
    };
    let unknown = TopicInfo {
        name: "/x".to_owned(),
        type_name: "no_msgs/msg/Such",
        qos,
    };
    let error = Writer::create(&folder.path().join("b"), &options, &[unknown]).unwrap_err();
    assert!(
        error.to_string().contains("found no_msgs/msg/Such"),
        "{error}"
    );
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

/// As a bag that was split by rosbag2.
#[test]
fn a_directory_of_several_files_is_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("a"), folder.path().join("b"));
    let messages = sample(100);
    let (begin, end) = messages.split_at(70);
    for (directory, part) in [(&first, begin), (&second, end)] {
        let mut writer = Writer::create(directory, &WriterOptions::default(), &topics()).unwrap();
        part.iter().for_each(|it| writer.write(&it.entry).unwrap());
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
fn our_types_are_read_by_our_structs() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, Compression::None, &sample(10));
    let reader = Reader::open(&directory).unwrap();
    let name = ImpactReport::INTERFACE.ros_name();
    let reports: Vec<ImpactReport> = reader
        .messages()
        .map(Result::unwrap)
        .filter(|message| *message.type_name == *name)
        .map(|message| cdr::decode(&message.data).unwrap())
        .collect();
    assert_eq!(reports.len(), 2);
    assert_eq!(reports[1].max_v1, 0.0946);
}
