//! A twin under a mock clock, recorded as by the node.

use column_twin::column::ImpactSpecification;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{SystemTime, UNIX_EPOCH};

use column_twin::endpoints::{self, Endpoint, NodeKind};
use column_twin::estimation::{Batch, Intake};
use column_twin::evidence::{NodeRecording, Topics, Verification, verify};
use column_twin::incoming::{column_command, raw_batch};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{ColumnParameters, ImpactEvent, Measurement};
use column_twin::messages::rcl_interfaces::{Parameter, ParameterEvent, ParameterValue};
use column_twin::messages::std_msgs::Header;
use column_twin::messages::{Message, cdr};
use column_twin::outgoing::{Message as TwinMessage, Outgoing, RecordingTap as _};
use column_twin::parameters::{Parameters, RecordMode, RecordSettings, Value};
use column_twin::recording::RecorderOptions;
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, Output, ParametersChanged, RejectionCode, Twin};
use tempfile::TempDir;

pub const START: Nanos = 1_800_000_000_000_000_000;
pub const MS: Nanos = 1_000_000;

/// The default column with few steps, without a state file.
pub fn parameters() -> Parameters {
    let values = [
        ("solver.dt", Value::from(1e-4)),
        ("state.directory", Value::from("")),
        ("assessment.ultimate_rotation", Value::from(0.0)),
    ];
    Parameters::from_values(values).expect("admissible")
}

pub fn event(id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        event_id: id.to_owned(),
        column_id: "column".to_owned(),
        stamp,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity: 5.0,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    }
}

/// The message that becomes this command.
pub fn message_of(event: &ImpactCommand) -> ImpactEvent {
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(event.stamp).expect("a stamp"),
            frame_id: "map".to_owned(),
        },
        column_id: event.column_id.clone(),
        event_id: event.event_id.clone(),
        vehicle: event.vehicle.clone(),
        ..ImpactEvent::from(&event.impact)
    }
}

/// The bytes on `/parameter_events` after a change from `before` of parameters that are numbers or lists of texts, with their
/// names behind this prefix;
/// `None` if they have their values still.
pub fn parameter_event(
    changed: &ParametersChanged,
    before: &Parameters,
    prefix: &str,
) -> Option<Arc<[u8]>> {
    let parameter = |name: &String| {
        let value = match changed.parameters.get(name) {
            Some(Value::Double(number)) => ParameterValue {
                kind: 3,
                double_value: number,
                ..ParameterValue::default()
            },
            // Of the inputs that are assumed, one that is given is none any more.
            Some(Value::StringArray(texts)) => ParameterValue {
                kind: 9,
                string_array_value: texts,
                ..ParameterValue::default()
            },
            other => panic!("{name} is {other:?}"),
        };
        let name = format!("{prefix}{name}");
        Parameter { name, value }
    };
    let is_changed = |name: &&String| before.get(name) != changed.parameters.get(name);
    let names = changed.names.iter().filter(is_changed);
    let event = ParameterEvent {
        stamp: Time::from_nanos(changed.stamp).expect("a stamp"),
        node: "/column_twin".to_owned(),
        changed_parameters: names.map(parameter).collect(),
        ..ParameterEvent::default()
    };
    (!event.changed_parameters.is_empty()).then(|| cdr::encode(&event).expect("bytes").into())
}

pub struct RecordedTwin {
    pub twin: Twin,
    pub now: Nanos,
    /// States that the queue to the node will drop.
    states_to_drop: u64,
    dropped_states: u64,
    outgoing: Outgoing,
    recording: Arc<NodeRecording>,
    /// Where its measurements come from, if it has sensors.
    intake: Option<Arc<Mutex<Intake>>>,
    /// Time since [`START`], by which the recording goes as well if it [follows](Self::follow_mock_clock) the twin.
    passed: Arc<AtomicI64>,
    /// The parameters whose change is published, if it is.
    announced: Option<Arc<Parameters>>,
    directory: TempDir,
}

/// The system time \[ns since 1970\].
pub fn system_time() -> Nanos {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("after");
    Nanos::try_from(now.as_nanos()).expect("before 2262")
}

impl RecordedTwin {
    pub fn new(parameters: Parameters) -> Self {
        Self::with_mode(parameters, RecordMode::Always)
    }

    pub fn with_mode(parameters: Parameters, mode: RecordMode) -> Self {
        Self::with_options(parameters, mode, |options| options)
    }

    pub fn with_options(
        parameters: Parameters,
        mode: RecordMode,
        options: impl FnOnce(RecorderOptions) -> RecorderOptions,
    ) -> Self {
        let directory = TempDir::new().expect("a directory");
        let record = RecordSettings {
            mode,
            directory: directory.path().display().to_string(),
            ..parameters.settings().record.clone()
        };
        // The twin follows a mock clock, and the recorder that of the system.
        let parameters = parameters
            .with_changes([("use_sim_time", Value::from(true))])
            .expect("admissible");
        let topics = Topics::of_default_node(NodeKind::Single);
        let recording =
            NodeRecording::start(&record, &topics, Arc::new(["column".into()]), options)
                .expect("starts")
                .expect("is asked for");
        let sensors = parameters.sensors();
        let intake = (!sensors.is_empty()).then(|| {
            let intake = Intake::new(&sensors, &parameters.settings().column_id);
            let intake = Arc::new(Mutex::new(intake));
            recording.sensors(None, &intake);
            intake
        });
        let outgoing = Outgoing::new(&parameters);
        let twin = Twin::new(parameters, None, Box::new(|| 0), START).expect("stands");
        let mut recorded = Self {
            twin,
            now: START,
            states_to_drop: 0,
            dropped_states: 0,
            outgoing,
            recording,
            intake,
            passed: Arc::default(),
            announced: None,
            directory,
        };
        recorded.advance(0);
        recorded
    }

    /// From now on the log times of the recording pass with the mock clock, and changes of parameters, all of them numbers, are published.
    pub fn follow_mock_clock(&mut self) {
        self.announced = Some(Arc::clone(self.twin.parameters()));
        let (began, passed) = (system_time(), Arc::clone(&self.passed));
        let clock = move || began + passed.load(Ordering::Relaxed);
        self.recording.follow(Box::new(clock));
    }

    fn put(&mut self, out: Vec<Output>) {
        self.passed.store(self.now - START, Ordering::Relaxed);
        for output in out {
            if matches!(output, Output::State(_)) && self.states_to_drop > 0 {
                self.states_to_drop -= 1;
                self.dropped_states += 1;
                continue;
            }
            let (recording, dropped) = (&self.recording, self.dropped_states);
            if let (Some(before), Output::ParametersChanged(changed)) =
                (&mut self.announced, &output)
            {
                if let Some(event) = parameter_event(changed, before, "") {
                    recording.sent(&endpoints::PARAMETER_EVENTS, &event);
                }
                *before = Arc::clone(&changed.parameters);
            }
            self.outgoing.convert(&output, |mut message| {
                if let TwinMessage::TwinStatus(status) = &mut message {
                    status.dropped_states = dropped;
                    status.dropped_recording = dropped;
                }
                let bytes = message.encode().expect("bytes").into();
                recording.sent(message.topic().endpoint(), &bytes);
            });
            if let Output::Journal(entry) = output {
                recording.journal(None, &entry);
            }
        }
    }

    pub fn execute(&mut self, command: Command) {
        let mut out = Vec::new();
        let _ = self.twin.handle(command, self.now, &mut out);
        self.put(out);
    }

    /// The queue to the node drops the next states.
    pub fn drop_states(&mut self, count: u64) {
        self.states_to_drop = count;
    }

    /// The node receives an impact.
    pub fn hit(&mut self, event: ImpactCommand) {
        self.receive_event(&event);
        self.execute(Command::Impact(event));
    }

    /// The node receives an impact, which the twin is given later.
    pub fn receive_event(&self, event: &ImpactCommand) {
        self.receive(&endpoints::IMPACT_EVENT, &message_of(event));
    }

    /// The node rejects an impact that it has received, before it reaches the twin.
    pub fn reject(&self, event: &ImpactCommand, code: RejectionCode) {
        let endpoint = &endpoints::IMPACT_EVENT;
        self.recording
            .rejected(None, endpoint, &event.event_id, Some(code), "for a test");
    }

    /// The node receives a set of parameters.
    pub fn set_column(&mut self, message: &ColumnParameters) {
        self.receive(&endpoints::COLUMN_PARAMETERS, message);
        let column_id = self.twin.column_id().to_string();
        self.execute(column_command(message, &column_id));
    }

    /// Records a message that the node receives, which was sent half a millisecond before.
    fn receive<M: Message>(&self, endpoint: &Endpoint, message: &M) {
        self.passed.store(self.now - START, Ordering::Relaxed);
        let bytes = cdr::encode(message).expect("bytes");
        let sent = system_time() - MS / 2;
        self.recording.received(None, endpoint, bytes, Some(sent));
    }

    /// The node receives measurements now, and records others; what the intake makes of those that it receives.
    pub fn measure_but_record(&self, message: &Measurement, recorded: &Measurement) -> Batch {
        let intake = self.intake.as_ref().expect("sensors");
        let mut intake = intake.lock().expect("no panic");
        let batch = intake.take(&raw_batch(message), self.now).expect("taken");
        self.measure(recorded);
        batch
    }

    /// Records measurements that the node receives now.
    pub fn measure(&self, message: &Measurement) {
        let bytes = cdr::encode(message).expect("bytes");
        // Only that of a column of a fleet is looked at.
        let unused = Intake::new(&[], "");
        self.recording
            .measured(None, &endpoints::MEASUREMENTS, bytes, self.now, &unused);
    }

    /// The node sends a message that does not come from the twin.
    pub fn send<M: Message>(&self, endpoint: &Endpoint, message: &M) {
        let bytes = cdr::encode(message).expect("bytes").into();
        self.recording.sent(endpoint, &bytes);
    }

    pub fn set(&mut self, changes: &[(&str, Value)]) {
        let changes = changes
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()))
            .collect();
        self.execute(Command::SetParameters {
            changes,
            source: "test".into(),
        });
    }

    pub fn reset(&mut self) {
        self.execute(Command::Reset {
            source: "test".into(),
        });
    }

    /// The critical velocities of the column at rest have been computed.
    pub fn know_critical_velocities(&mut self) {
        let task = self.twin.critical_velocity_task().expect("awaited");
        let vehicles = task.compute(&mut || true).expect("not abandoned");
        self.execute(Command::CriticalVelocities { vehicles });
    }

    /// The second opinion on the present or the last impact has been computed.
    pub fn know_opinion(&mut self) {
        let task = self.twin.opinion_task().expect("awaited");
        self.execute(Command::SecondOpinion(task.compute()));
    }

    /// The range of the verdict on the present or the last impact has been computed, and the second opinion before it.
    pub fn know_range(&mut self) {
        if self.twin.awaits_opinion() {
            self.know_opinion();
        }
        let task = self.twin.range_task().expect("awaited");
        let range = task.compute(&mut || true).expect("not abandoned");
        self.execute(Command::VerdictRange(range));
    }

    /// One cycle of a solver that wakes after `nanos`, with a slice of the forecast.
    pub fn advance(&mut self, nanos: Nanos) {
        self.now += nanos;
        let mut out = Vec::new();
        self.twin.advance_to(self.now, &mut out);
        self.twin.run_ahead(64, self.now, &mut out);
        self.put(out);
    }

    /// The clock jumps back, as the thread of the solver notices it.
    pub fn jump_back(&mut self, nanos: Nanos) {
        self.now -= nanos;
        let by = nanos.unsigned_abs();
        self.execute(Command::ClockJumpedBack { by });
    }

    pub fn until_rest(&mut self) {
        while self.twin.is_responding() {
            self.advance(MS);
        }
    }

    /// The directory of the recordings.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// Ends the recording.
    pub fn finish(self) -> Finished {
        self.finish_with_loss(0)
    }

    /// As [`finish`](Self::finish) of a recorder that has lost so many messages.
    pub fn finish_with_loss(self, lost: u64) -> Finished {
        let statistics = self.recording.stop().expect("it ran");
        assert_eq!((statistics.lost, statistics.write_errors), (lost, 0));
        Finished {
            directory: self.directory,
        }
    }
}

/// A finished recording.
pub struct Finished {
    directory: TempDir,
}

impl Finished {
    /// The path of the only recording.
    pub fn path(&self) -> PathBuf {
        the_one_recording(self.directory.path())
    }

    /// The paths of all recordings, in order.
    pub fn paths(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.directory.path()).expect("readable");
        let mut found: Vec<_> = entries
            .map(|entry| entry.expect("readable").path())
            .collect();
        // `_2` precedes `_10`.
        found.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
        found
    }

    pub fn verify(&self) -> Verification {
        verify(&self.path()).expect("can be verified")
    }

    /// Verifies that everything was compared, and is equal.
    pub fn assert_verified(&self) -> Verification {
        let found = self.verify();
        assert!(found.is_equal(), "{found}");
        assert_eq!(found.unchecked, Vec::<String>::new(), "{found}");
        assert_eq!(
            (found.unchecked_messages(), found.missing()),
            (0, 0),
            "{found}"
        );
        found
    }
}

pub fn the_one_recording(directory: &Path) -> PathBuf {
    let mut found: Vec<_> = std::fs::read_dir(directory)
        .expect("readable")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.is_dir())
        .collect();
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}
