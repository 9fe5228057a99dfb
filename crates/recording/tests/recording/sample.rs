//! A recording with messages of several types, and what must be read from it.

use std::path::Path;
use std::sync::Arc;

use byteorder::LittleEndian;
use rosbag2_mcap::{
    ChunkCompression, Entry, Finished, OfferedQos, Reader, TopicInfo, Writer, WriterOptions,
};
use serde::Serialize;

/// When the sample begins \[ns\].
pub const START: i64 = 1_795_246_800_000_000_000;

/// Every compression.
pub const COMPRESSIONS: [ChunkCompression; 3] = [
    ChunkCompression::None,
    ChunkCompression::Lz4,
    ChunkCompression::Zstd,
];

/// Definition of [`Measurement`].
pub const MEASUREMENT: &str = "\
# A measurement.
Stamp stamp
string name
float64[4] values # [m]
uint8[] levels

================================================================================
MSG: test_msgs/Stamp
int32 sec
uint32 nanosec
";

#[derive(Serialize)]
struct Stamp {
    sec: i32,
    nanosec: u32,
}

#[derive(Serialize)]
struct Measurement {
    stamp: Stamp,
    name: String,
    values: [f64; 4],
    levels: Vec<u8>,
}

fn topic(name: &str, type_name: &str, schema: &str, depth: usize) -> TopicInfo {
    TopicInfo {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        schema: schema.to_owned(),
        type_hash: String::new(),
        qos: OfferedQos {
            reliable: depth > 1,
            transient_local: depth == 1,
            depth,
        },
    }
}

/// One topic of texts.
pub fn text_topics() -> Vec<TopicInfo> {
    vec![topic("/text", "std_msgs/msg/String", "string data\n", 1000)]
}

/// The topics of the sample; the last has no message.
pub fn topics() -> Vec<TopicInfo> {
    let measurement = |name| topic(name, "test_msgs/msg/Measurement", MEASUREMENT, 1000);
    vec![
        measurement("/fast"),
        measurement("/slow"),
        topic("/latched", "std_msgs/msg/String", "string data\n", 1),
        measurement("/silent"),
    ]
}

/// A message with its encapsulation header.
fn encode(message: &impl Serialize) -> Arc<[u8]> {
    let mut bytes = vec![0, 1, 0, 0];
    cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message).unwrap();
    bytes.into()
}

fn measurement(topic: usize, index: i64, log_time: i64) -> Entry {
    let x = index as f64;
    let message = Measurement {
        stamp: Stamp {
            sec: i32::try_from(log_time / 1_000_000_000).unwrap(),
            nanosec: u32::try_from(log_time % 1_000_000_000).unwrap(),
        },
        name: format!("measurement {index}, {}", "äöü €".repeat(20)),
        values: [0.1 * x - 3.0, f64::NAN, -1.0 / (x + 3.0), 1e-300],
        levels: vec![1, 2, 3],
    };
    Entry {
        topic,
        log_time,
        publish_time: log_time - 1_000,
        data: encode(&message),
        checkpoint: false,
    }
}

/// A message that is nothing but a text.
pub fn text_entry(topic: usize, log_time: i64, text: &str, checkpoint: bool) -> Entry {
    Entry {
        topic,
        log_time,
        publish_time: log_time,
        data: encode(&text),
        checkpoint,
    }
}

/// `count` messages of the first topic and a third as many of the second, which are a little late, as if another thread
/// had recorded them; two texts.
pub fn sample(count: i64) -> Vec<Entry> {
    let mut all = vec![text_entry(2, START, "begin", true)];
    for index in 0..count {
        let time = START + 1_000_000 * (index + 3);
        all.push(measurement(0, index, time));
        if index % 3 == 0 {
            all.push(measurement(1, index, time - 1_500_000));
        }
    }
    all.push(text_entry(
        2,
        START + 1_000_000 * (count + 10),
        "end",
        false,
    ));
    all
}

/// Writes the messages to `directory`.
pub fn write(directory: &Path, compression: ChunkCompression, messages: &[Entry]) -> Finished {
    let options = WriterOptions {
        compression,
        ..WriterOptions::default()
    };
    let mut writer = Writer::create(directory, &options, &topics()).unwrap();
    for (index, message) in messages.iter().enumerate() {
        writer.write(message).unwrap();
        if index % 500 == 499 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap()
}

/// Compares everything that the reader finds with what was written.
pub fn assert_reads_back(reader: &Reader, messages: &[Entry]) {
    let topics = topics();
    let mut sorted: Vec<&Entry> = messages.iter().collect();
    sorted.sort_by_key(|it| it.log_time);
    let mut expected = sorted.into_iter();
    for found in reader.messages() {
        let found = found.unwrap();
        let entry = expected.next().expect("no more messages than were written");
        let topic = &topics[entry.topic];
        assert_eq!(
            (&*found.topic, &*found.type_name),
            (&*topic.name, &*topic.type_name)
        );
        assert_eq!(
            (found.log_time, found.publish_time),
            (entry.log_time, entry.publish_time)
        );
        assert_eq!(found.data, *entry.data);
    }
    assert_eq!(expected.count(), 0, "messages that were not found");
}
