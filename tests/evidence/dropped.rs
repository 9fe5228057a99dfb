//! Messages that do not reach the recording, or reach it late.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use column_twin::endpoints::{Endpoint, NodeKind};
use column_twin::estimation::Intake;
use column_twin::evidence::{NodeRecording, Topics, verify};
use column_twin::live::{
    LiveOptions, OutputQueue, OutputSource, QueueStats, RealTime, Receiver, WhenFull,
};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::TwinStatus;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::outgoing::{RecordingHealth, RecordingTap};
use column_twin::parameters::{RecordMode, RecordSettings};
use column_twin::recording::Reader;
use column_twin::ros::{LiveColumns, Names, TwinNode, qos};
use column_twin::twin::{Command, Journal, Output, Rejection, RejectionCode};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::node::slow_impact;
use super::recorded_twin::{START, parameters, the_one_recording};

/// Keeps the messages that the node sends.
#[derive(Default)]
struct Tap(Mutex<Vec<(&'static str, Vec<u8>)>>);

impl Tap {
    fn of<M: column_twin::messages::Message + serde::de::DeserializeOwned>(
        &self,
        endpoint: &Endpoint,
    ) -> Vec<M> {
        let all = self.0.lock().unwrap();
        all.iter()
            .filter(|(name, _)| *name == endpoint.name)
            .map(|(_, bytes)| cdr::decode(bytes).unwrap())
            .collect()
    }
}

impl RecordingTap for Tap {
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>) {
        let mut all = self.0.lock().unwrap();
        all.push((endpoint.name, bytes.to_vec()));
    }

    fn received(&self, _: Option<&str>, _: &Endpoint, _: Vec<u8>, _: Option<i64>) {}

    fn sensors(&self, _: Option<&str>, _: &Arc<Mutex<Intake>>) {}

    fn measured(&self, _: Option<&str>, _: &Endpoint, _: Vec<u8>, _: i64, _: &Intake) {}

    fn rejected(&self, _: Option<&str>, _: &Endpoint, _: &str, _: Option<RejectionCode>, _: &str) {}

    fn journal(&self, _: Option<&str>, _: &Journal) {}

    fn health(&self) -> RecordingHealth {
        RecordingHealth {
            queue: QueueStats {
                name: "recording".to_owned(),
                capacity: 1,
                len: 0,
                when_full: WhenFull::DropNewest,
                pushed: 0,
                dropped: 0,
            },
            lost: 2,
            problem: None,
            values: Vec::new(),
        }
    }
}

fn started() -> (Arc<LiveColumns>, Receiver) {
    let options = LiveOptions {
        real_time: RealTime::none(),
        ..LiveOptions::default()
    };
    LiveColumns::start_one(parameters(), options).unwrap()
}

fn node(
    domain: &Domain,
    twin: &Arc<LiveColumns>,
    outputs: impl OutputSource,
    recording: &Arc<Tap>,
) -> TwinNode {
    TwinNode::start(
        &domain.environment,
        Names::new("/", "column_twin", &[]).unwrap(),
        Arc::clone(twin),
        outputs,
        None,
        Some(Arc::clone(recording) as _),
    )
    .unwrap()
}

/// Outputs dropped by the queue to the node are missing in its recording: an error, whose count is kept after the stop.
#[test]
fn outputs_dropped_by_the_queue_to_the_node_are_missing_in_the_recording() {
    let domain = Domain::fresh();
    let (twin, outputs) = started();
    let begin = Instant::now();
    while twin.health().dropped_recording == 0 {
        // No reader takes the rejections.
        let _ = twin.submit(
            0,
            Command::RejectedChange {
                rejection: Rejection::new(RejectionCode::OtherColumn, "a test"),
                source: "test".into(),
            },
        );
        assert!(begin.elapsed() < PATIENCE, "{:?}", twin.health());
    }
    let recording = Arc::<Tap>::default();
    let node = node(&domain, &twin, outputs, &recording);
    let latest = || recording.of::<TwinStatus>(&qos::TWIN_STATUS).pop();
    while latest().is_none() {
        assert!(begin.elapsed() < PATIENCE, "no status");
        std::thread::sleep(Duration::from_millis(10));
    }
    node.stop();
    let health = twin.health();
    let lost = health.dropped_recording;
    assert!(lost > 0 && !health.has_panicked, "{health:?}");
    assert!(!health.queues.is_empty() && !health.statistics.is_empty());
    assert_eq!(latest().unwrap().dropped_recording, lost + 2);
    let diagnostics = recording.of::<DiagnosticArray>(&qos::DIAGNOSTICS);
    let mut statuses = diagnostics.last().unwrap().status.iter();
    let of_recording = statuses.find(|it| it.name.ends_with(": recording"));
    let of_recording = of_recording.unwrap();
    assert_eq!(of_recording.level, DiagnosticStatus::ERROR);
    assert_eq!(
        of_recording.message,
        format!("{} messages are missing from the recording", lost + 2)
    );
}

/// A slow source of outputs.
struct Slow(Vec<Output>);

impl OutputSource for Slow {
    fn receive(&mut self, timeout: Duration) -> Option<Output> {
        std::thread::sleep(Duration::from_millis(10));
        let output = self.0.pop();
        if output.is_none() {
            std::thread::sleep(timeout);
        }
        output
    }
}

#[test]
fn outputs_that_are_too_late_to_be_published_are_recorded() {
    const COUNT: usize = 100;
    let domain = Domain::fresh();
    let (twin, _) = started();
    let model = column_twin::twin::Twin::new(parameters(), None, Box::new(|| 0), START).unwrap();
    let status = (0..COUNT).map(|_| Output::Status(model.status(START)));
    let recording = Arc::<Tap>::default();
    let node = node(&domain, &twin, Slow(status.collect()), &recording);
    node.stop();
    assert_eq!(
        recording.of::<TwinStatus>(&qos::TWIN_STATUS).len(),
        COUNT,
        "of {COUNT}"
    );
}

/// At rest, the mode `events` records diagnostics only if a level changes.
#[test]
fn diagnostics_at_rest_are_recorded_when_a_level_changes() {
    let directory = tempfile::TempDir::new().unwrap();
    let record = RecordSettings {
        mode: RecordMode::Events,
        directory: directory.path().display().to_string(),
        ..parameters().settings().record.clone()
    };
    let recording = NodeRecording::start(
        &record,
        &Topics::of_default_node(NodeKind::Single),
        Arc::new(["column".into()]),
        |it| it,
    )
    .unwrap()
    .unwrap();
    let send = |endpoint, bytes: Vec<u8>| recording.sent(endpoint, &bytes.into());
    send(
        &qos::TWIN_STATUS,
        cdr::encode(&TwinStatus::default()).unwrap(),
    );
    for level in [0, 0, 2, 2, 2, 0, 0] {
        let one = DiagnosticStatus {
            level,
            ..DiagnosticStatus::default()
        };
        let array = DiagnosticArray {
            status: vec![DiagnosticStatus::default(), one],
            ..DiagnosticArray::default()
        };
        send(&qos::DIAGNOSTICS, cdr::encode(&array).unwrap());
    }
    assert_eq!(recording.stop().unwrap().lost, 0);
    let reader = Reader::open(&the_one_recording(directory.path())).unwrap();
    let levels: Vec<u8> = reader
        .messages()
        .map(|it| it.unwrap())
        .filter(|it| *it.topic == *qos::DIAGNOSTICS.name)
        .map(|it| cdr::decode::<DiagnosticArray>(&it.data).unwrap().status[1].level)
        .collect();
    assert_eq!(levels, [0, 2, 0]);
}

/// A source that pauses now and then, so that the queue before it overflows.
struct Hesitant {
    outputs: Receiver,
    taken: u32,
}

impl OutputSource for Hesitant {
    fn receive(&mut self, timeout: Duration) -> Option<Output> {
        self.taken += 1;
        if self.taken.is_multiple_of(20) {
            std::thread::sleep(Duration::from_millis(60));
        }
        self.outputs.receive(timeout)
    }
}

/// What the queue to the node drops is missing, and declared when it is dropped.
#[test]
fn a_recording_of_a_node_whose_queue_overflows_is_equal() {
    let domain = Domain::fresh();
    let directory = tempfile::TempDir::new().unwrap();
    let record = RecordSettings {
        mode: RecordMode::Always,
        directory: directory.path().display().to_string(),
        ..parameters().settings().record.clone()
    };
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let topics =
        Topics::resolved(NodeKind::Single, |it| names.resolve(it.kind(), it.name)).unwrap();
    let recording = NodeRecording::start(&record, &topics, Arc::new(["column".into()]), |it| it)
        .unwrap()
        .unwrap();
    let options = LiveOptions {
        real_time: RealTime::none(),
        outputs: vec![OutputQueue {
            states: 16,
            ..OutputQueue::ros()
        }],
        ..LiveOptions::default()
    };
    let (twin, outputs) = LiveColumns::start_one(parameters(), options).unwrap();
    let node = TwinNode::start(
        &domain.environment,
        names,
        Arc::clone(&twin),
        Hesitant { outputs, taken: 0 },
        None,
        Some(Arc::clone(&recording) as _),
    )
    .unwrap();
    let mut peer = reader(&domain);
    let statuses = Incoming::<TwinStatus>::start(&mut peer, &qos::TWIN_STATUS);
    for (id, accepted) in [("a", 1), ("b", 2), ("c", 3)] {
        slow_impact(&domain, id);
        if id == "b" {
            // In the middle of the response.
            let source = "test".into();
            twin.execute(0, Command::Reset { source }).unwrap();
        } else {
            statuses.find("the end of the response", |it| {
                it.is_at_rest() && it.events_accepted == accepted
            });
        }
    }
    drop(statuses);
    assert!(twin.health().dropped_states > 0, "{:?}", twin.health());
    node.stop();
    recording.stop().unwrap();
    let found = verify(&the_one_recording(directory.path())).unwrap();
    assert!(found.is_equal(), "{found}");
    assert!(found.missing() > 0 && found.undeclared == 0, "{found}");
    assert!(found.compared() > 100, "{found}");
}
