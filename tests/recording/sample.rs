//! A recording with messages of many types, and what must be read from it.

use std::path::Path;
use std::sync::Arc;

use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport, TwinStatus,
};
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use column_twin::messages::geometry_msgs::Point;
use column_twin::messages::sensor_msgs::JointState;
use column_twin::messages::std_msgs::{Header, String as Text};
use column_twin::messages::visualization_msgs::{Marker, MarkerArray};
use column_twin::messages::{Message, cdr};
use column_twin::parameters::Compression;
use column_twin::recording::{
    ChunkCompression, Entry, Finished, OfferedQos, Reader, SealKey, TopicInfo, Writer,
    WriterOptions, topic, writer_options,
};
use serde_json::{Value, json};

/// When the sample begins \[ns\].
pub const START: i64 = 1_795_246_800_000_000_000;

/// Every compression.
pub const COMPRESSIONS: [ChunkCompression; 3] = [
    ChunkCompression::None,
    ChunkCompression::Lz4,
    ChunkCompression::Zstd,
];

const RELIABLE: OfferedQos = OfferedQos {
    reliable: true,
    transient_local: false,
    depth: 1000,
};
const LATCHED: OfferedQos = OfferedQos {
    reliable: true,
    transient_local: true,
    depth: 1,
};
const BEST_EFFORT: OfferedQos = OfferedQos {
    reliable: false,
    transient_local: false,
    depth: 5,
};

/// The topics of the sample; the last has no message.
pub fn topics() -> Vec<TopicInfo> {
    [
        (
            "/garage/column_state",
            "column_twin_msgs/msg/ColumnState",
            RELIABLE,
        ),
        (
            "/garage/hinge_forces",
            "column_twin_msgs/msg/HingeForces",
            RELIABLE,
        ),
        (
            "/garage/impact_event",
            "column_twin_msgs/msg/ImpactEvent",
            RELIABLE,
        ),
        (
            "/garage/impact_forecast",
            "column_twin_msgs/msg/ImpactReport",
            LATCHED,
        ),
        (
            "/garage/impact_report",
            "column_twin_msgs/msg/ImpactReport",
            LATCHED,
        ),
        (
            "/garage/twin_status",
            "column_twin_msgs/msg/TwinStatus",
            LATCHED,
        ),
        (
            "/garage/joint_states",
            "sensor_msgs/msg/JointState",
            BEST_EFFORT,
        ),
        (
            "/garage/markers",
            "visualization_msgs/msg/MarkerArray",
            LATCHED,
        ),
        (
            "/diagnostics",
            "diagnostic_msgs/msg/DiagnosticArray",
            RELIABLE,
        ),
        (
            "/garage/column_twin/journal",
            "std_msgs/msg/String",
            RELIABLE,
        ),
        (
            "/garage/column_parameters",
            "column_twin_msgs/msg/ColumnParameters",
            RELIABLE,
        ),
    ]
    .map(|(name, type_name, qos)| topic(name, type_name, qos).unwrap())
    .into()
}

/// A message with what other readers must find in it.
pub struct Expected {
    pub entry: Entry,
    pub content: Value,
}

fn expect<M: Message>(topic: usize, log_time: i64, message: &M) -> Expected {
    Expected {
        entry: Entry {
            topic,
            log_time,
            publish_time: log_time - 1_000,
            data: cdr::encode(message).unwrap().into(),
            checkpoint: topic == 9,
        },
        content: serde_json::to_value(message).unwrap(),
    }
}

fn header(nanos: i64) -> Header {
    Header {
        stamp: Time::from_nanos(nanos).unwrap(),
        frame_id: "column".to_owned(),
    }
}

/// Numbers that show a reader that rounds, swaps bytes or loses a sign.
fn numbers(index: usize) -> [f64; 4] {
    let x = index as f64;
    [
        x * 0.1 - 3.0,
        f64::NAN,
        -1.0 / (x + 3.0),
        f64::MIN_POSITIVE * (x + 1.0),
    ]
}

fn state(index: usize, nanos: i64) -> ColumnState {
    let [v1, u1, beta1, u2] = numbers(index);
    ColumnState {
        header: header(nanos),
        column_id: "A3".to_owned(),
        event_id: format!("event {}", index / 1000),
        phase: ColumnState::FREE,
        time: index as f64 * 1e-3,
        v1,
        u1,
        beta1,
        u2,
        impact_impulse: f64::INFINITY,
        ledger_residual: 1e-300,
        ..ColumnState::default()
    }
}

fn report(kind: u8, event: &str, nanos: i64) -> ImpactReport {
    ImpactReport {
        header: header(nanos),
        column_id: "A3".to_owned(),
        event_id: event.to_owned(),
        kind,
        outcome: ImpactReport::PLASTIC,
        max_v1: 0.0946,
        max_v1_time: 0.01979,
        residual_v1: 0.08934,
        peak_contact_force: 746.9e3,
        first_yield_time: [f64::NAN, 0.1, 0.2, 0.3].into(),
        ..ImpactReport::default()
    }
}

/// A sample of about `states` messages; a few are a little out of order, as those of several threads are.
pub fn sample(states: usize) -> Vec<Expected> {
    let journal = Text {
        data: "{\"umlauts\": \"äöü €\", \"empty\": \"\"}".to_owned(),
    };
    let event = ImpactEvent {
        header: header(START),
        column_id: "A3".to_owned(),
        event_id: "event 0".to_owned(),
        mass: 1500.0,
        velocity: 10.0,
        ..ImpactEvent::default()
    };
    let mut all = vec![
        expect(9, START, &journal),
        expect(2, START + 1_000_000, &event),
        expect(
            3,
            START + 2_000_000,
            &report(ImpactReport::FORECAST, "event 0", START),
        ),
    ];
    for index in 0..states {
        let time = START + 1_000_000 * (index as i64 + 3);
        all.push(expect(0, time, &state(index, time)));
        if index % 3 == 0 {
            // Recorded by a thread that was a little late.
            all.push(expect(1, time - 1_500_000, &hinges(index, time)));
        }
        if index % 40 == 0 {
            all.push(expect(6, time, &joints(index, time)));
            all.push(expect(7, time, &markers(time)));
        }
    }
    let end = START + 1_000_000 * (states as i64 + 10);
    let rejected = TwinStatus {
        header: header(end),
        column_id: "A3".to_owned(),
        last_rejection_reason: "mass and velocity must be above 0".to_owned(),
        last_rejection_event_id: "event 1".to_owned(),
        events_accepted: 1,
        events_rejected: 1,
        ..TwinStatus::default()
    };
    all.push(expect(
        4,
        end,
        &report(ImpactReport::RESULT, "event 0", START),
    ));
    all.push(expect(5, end + 1, &rejected));
    all.push(expect(8, end + 2, &diagnostics(end)));
    all
}

fn hinges(index: usize, nanos: i64) -> HingeForces {
    HingeForces {
        header: header(nanos),
        column_id: "A3".to_owned(),
        event_id: String::new(),
        moment: numbers(index).into(),
        plastic_rotation: numbers(index + 1).into(),
        state: [0, 1, 2, 1].into(),
        ..HingeForces::default()
    }
}

fn joints(index: usize, nanos: i64) -> JointState {
    JointState {
        header: header(nanos),
        name: ["hinge_1a", "hinge_1b", "hinge_2", "hinge_3"]
            .map(str::to_owned)
            .into(),
        position: numbers(index).into(),
        velocity: Vec::new(),
        effort: vec![1.0; 4],
    }
}

fn markers(nanos: i64) -> MarkerArray {
    let marker = Marker {
        header: header(nanos),
        ns: "column".to_owned(),
        points: vec![
            Point {
                x: 1.0,
                y: -2.0,
                z: 0.5
            };
            3
        ],
        text: "v1".to_owned(),
        ..Marker::default()
    };
    MarkerArray {
        markers: vec![marker.clone(), marker],
    }
}

fn diagnostics(nanos: i64) -> DiagnosticArray {
    let value = KeyValue {
        key: "lost".to_owned(),
        value: "0".to_owned(),
    };
    let status = DiagnosticStatus {
        level: 2,
        name: "recorder".to_owned(),
        values: vec![value],
        ..DiagnosticStatus::default()
    };
    DiagnosticArray {
        header: header(nanos),
        status: vec![status],
    }
}

/// Writes the messages to `directory`, sealed.
pub fn write(directory: &Path, compression: ChunkCompression, messages: &[Expected]) -> Finished {
    let options = WriterOptions {
        compression,
        seal: Some(SealKey::fresh().unwrap()),
        ..writer_options(Compression::None)
    };
    let mut writer = Writer::create(directory, &options, &topics()).unwrap();
    for (index, message) in messages.iter().enumerate() {
        writer.write(&message.entry).unwrap();
        if index % 500 == 499 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap()
}

/// In the order of their times, as every reader must show them.
pub fn in_order(messages: &[Expected]) -> Vec<&Expected> {
    let mut sorted: Vec<&Expected> = messages.iter().collect();
    sorted.sort_by_key(|it| it.entry.log_time);
    sorted
}

/// Holds all that our reader finds to what was written.
pub fn assert_reads_back(reader: &Reader, messages: &[Expected]) {
    let topics = topics();
    let mut expected = in_order(messages).into_iter();
    for found in reader.messages() {
        let found = found.unwrap();
        let Expected { entry, .. } = expected.next().expect("no more messages than were written");
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

/// One line per message, in order, for scripts in other languages. Numbers that JSON cannot write are null.
pub fn expected_lines(messages: &[Expected], topics: &[TopicInfo]) -> String {
    let line = |it: &&Expected| {
        let topic = &topics[it.entry.topic];
        let bytes: String = it
            .entry
            .data
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        json!({
            "topic": topic.name,
            "type": topic.type_name,
            "log_time": it.entry.log_time.to_string(),
            "publish_time": it.entry.publish_time.to_string(),
            "data": bytes,
            "message": it.content,
        })
        .to_string()
            + "\n"
    };
    in_order(messages).iter().map(line).collect()
}

/// An entry with nothing but a text in it.
pub fn text_entry(topic: usize, log_time: i64, text: &str, checkpoint: bool) -> Entry {
    let data: Arc<[u8]> = cdr::encode(&Text {
        data: text.to_owned(),
    })
    .unwrap()
    .into();
    Entry {
        topic,
        log_time,
        publish_time: log_time,
        data,
        checkpoint,
    }
}

/// One topic of texts.
pub fn text_topics() -> Vec<TopicInfo> {
    vec![topic("/text", "std_msgs/msg/String", RELIABLE).unwrap()]
}
