//! What a recording of this program contains, read by the mcap crate's own reader and by ours.

use std::fs;

use column_twin::column::Outcome;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::{INTERFACES, Message as _, cdr, find, type_hash::TypeHash};
use column_twin::recording::{
    ChunkCompression, Decoder, OfferedQos, Reader, check_definition, summarise_events, topic,
};

use super::sample::{self, sample, topics};

/// Summary, indexes, schemas and channels, as the mcap crate reads them.
#[test]
fn the_file_has_the_layout_of_rosbag2() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(3000);
    sample::write(&directory, ChunkCompression::Zstd, &messages);
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
        assert_eq!(
            &*schema.data,
            interface.schema_text(INTERFACES).unwrap().as_bytes()
        );
        assert_eq!(
            channel.metadata["topic_type_hash"],
            TypeHash::of(interface, INTERFACES).unwrap().to_string()
        );
        assert!(channel.metadata["offered_qos_profiles"].contains("history: keep_last"));
    }
    let names: Vec<_> = summary
        .metadata_indexes
        .iter()
        .map(|it| it.name.as_str())
        .collect();
    // Written sealed: the seals are records that other readers ignore.
    assert_eq!(names.first(), Some(&"rosbag2_mcap/seal_begin"));
    assert_eq!(names.last(), Some(&"rosbag2_mcap/seal"));
    assert_eq!(summary.attachment_indexes.len(), 1);
    assert_eq!(summary.attachment_indexes[0].name, "rosbag2_mcap/seal");
    let mut notes = names;
    notes.retain(|name| !name.starts_with("rosbag2_mcap/"));
    assert_eq!(
        notes,
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
fn the_reader_knows_topics_and_their_quality_of_service() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, ChunkCompression::Lz4, &sample(10));
    let reader = Reader::open(&directory).unwrap();
    sample::assert_reads_back(&reader, &sample(10));
    for (found, declared) in reader.topics().iter().zip(topics()) {
        assert_eq!(
            (&*found.name, &*found.type_name),
            (&*declared.name, &*declared.type_name)
        );
        assert_eq!(found.qos, Some(declared.qos));
        check_definition(found).unwrap();
    }
    let notes = reader.start_notes().unwrap();
    assert_eq!(notes["program"], "column-twin");
    assert_eq!(notes["version"], env!("CARGO_PKG_VERSION"));
}

/// Every field of every type, decoded by the definition in the recording, equals what serde makes of the struct.
#[test]
fn messages_are_decoded_by_the_definitions_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    let messages = sample(100);
    sample::write(&directory, ChunkCompression::None, &messages);
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
fn impacts_are_summarised() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, ChunkCompression::None, &sample(10));
    let (events, beyond) = summarise_events(&Reader::open(&directory).unwrap()).unwrap();
    assert_eq!((events.len(), beyond), (2, 0));
    let [hit, rejected] = &events[..] else {
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
        (Some(Outcome::Plastic), Some(0.0946), Some(0.08934))
    );
    assert_eq!(hit.forecast_max_v1, Some(0.0946));
    assert_eq!(
        rejected.rejected.as_deref(),
        Some("mass and velocity must be above 0")
    );
    assert_eq!(rejected.outcome, None);
}

#[test]
fn our_types_are_read_by_our_structs() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("bag");
    sample::write(&directory, ChunkCompression::None, &sample(10));
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

#[test]
fn a_changed_definition_is_rejected_with_the_difference() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let text = column_twin::messages::find("column_twin_msgs/msg/ImpactReport")
        .unwrap()
        .schema_text(INTERFACES)
        .unwrap();
    let old = text.replace("float64 residual_v1", "float32 residual_v1");
    assert_ne!(old, text);
    let schema = writer
        .add_schema(
            "column_twin_msgs/msg/ImpactReport",
            "ros2msg",
            old.as_bytes(),
        )
        .unwrap();
    writer
        .add_channel(
            schema,
            "/impact_report",
            "cdr",
            &std::collections::BTreeMap::new(),
        )
        .unwrap();
    writer.finish().unwrap();
    let reader = Reader::open(&path).unwrap();
    let error = check_definition(&reader.topics()[0]).unwrap_err();
    assert!(error.is_bad_input());
    let said = error.to_string();
    for part in [
        "expected column_twin_msgs/ImpactReport: float64 residual_v1",
        "found column_twin_msgs/ImpactReport: float32 residual_v1",
        "export",
    ] {
        assert!(said.contains(part), "{part:?} is not in: {said}");
    }
}

#[test]
fn a_type_without_definition_is_not_recorded() {
    let qos = OfferedQos {
        reliable: true,
        transient_local: false,
        depth: 1,
    };
    let error = topic("/x", "no_msgs/msg/Such", qos).unwrap_err();
    assert!(error.to_string().contains("no_msgs/msg/Such"), "{error}");
}
