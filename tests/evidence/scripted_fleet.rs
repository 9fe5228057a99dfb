//! The columns of a fleet under a mock clock, recorded as by the node of a fleet.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use column_twin::endpoints::{self, NodeKind};
use column_twin::evidence::{NodeRecording, Topics};
use column_twin::fleet::StatusBoard;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{ColumnStatus, FleetStatus};
use column_twin::messages::std_msgs::Header;
use column_twin::outgoing::{Message, Outgoing, RecordingTap as _};
use column_twin::parameters::{Parameters, RecordMode, RecordSettings, Value};
use column_twin::recording::RecorderOptions;
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, Output, RejectionCode, Twin, TwinPhase};
use tempfile::TempDir;

use super::recorded_twin::{MS, START, event, message_of, parameter_event, system_time};

struct Column {
    id: String,
    twin: Twin,
    outgoing: Outgoing,
    announced: Arc<Parameters>,
    /// When it has something to do.
    deadline: Option<Nanos>,
}

impl Column {
    /// As the pool does, which leaves a column alone that has nothing to do.
    fn plan(&mut self, now: Nanos) {
        self.twin.forget_what_is_too_old(now);
        self.deadline = match self.twin.is_quiet(now) {
            false => Some(now),
            true => self.twin.remembers_until().map(|it| it + 1),
        };
    }
}

pub struct ScriptedFleet {
    pub now: Nanos,
    columns: Vec<Column>,
    board: StatusBoard,
    recording: Arc<NodeRecording>,
    passed: Arc<AtomicI64>,
    directory: TempDir,
}

impl ScriptedFleet {
    pub fn new(count: usize, parameters: &Parameters, mode: RecordMode) -> Self {
        let directory = TempDir::new().expect("a directory");
        let record = RecordSettings {
            mode,
            directory: directory.path().display().to_string(),
            ..parameters.settings().record.clone()
        };
        let column = |number: usize| {
            let id = format!("c{number}");
            let own = [
                ("column_id", Value::from(id.as_str())),
                // The twins follow a mock clock that tells another day than the recording.
                ("use_sim_time", Value::from(true)),
            ];
            let parameters = Arc::new(parameters.with_changes(own).expect("admissible"));
            Column {
                outgoing: Outgoing::new(&parameters),
                twin: Twin::new(Arc::clone(&parameters), None, Box::new(|| 0), START)
                    .expect("stands"),
                announced: parameters,
                deadline: None,
                id,
            }
        };
        let columns: Vec<_> = (0..count).map(column).collect();
        let ids = columns.iter().map(|it| it.id.as_str().into()).collect();
        let unsynced = |options| RecorderOptions {
            sync: false,
            ..options
        };
        let topics = Topics::of_default_node(NodeKind::Fleet);
        let recording = NodeRecording::start(&record, &topics, ids, unsynced);
        let recording = recording.expect("starts").expect("is asked for");
        let (began, passed) = (system_time(), Arc::<AtomicI64>::default());
        let clock = Arc::clone(&passed);
        recording.follow(Box::new(move || began + clock.load(Ordering::Relaxed)));
        Self {
            now: START,
            board: StatusBoard::new(columns.iter().map(|it| it.id.clone())),
            columns,
            recording,
            passed,
            directory,
        }
    }

    pub fn event(&self, column: usize, id: &str) -> ImpactCommand {
        ImpactCommand {
            column_id: self.columns[column].id.clone(),
            ..event(id, self.now)
        }
    }

    pub fn is_responding(&self) -> bool {
        self.columns.iter().any(|it| it.twin.is_responding())
    }

    /// The node receives an impact, which its column is given later.
    pub fn receive_event(&self, event: &ImpactCommand) {
        let endpoint = &endpoints::IMPACT_EVENT;
        let bytes = cdr::encode(&message_of(event)).expect("bytes");
        let sent = system_time() - MS / 2;
        self.recording
            .received(Some(&event.column_id), endpoint, bytes, Some(sent));
    }

    /// The node rejects an impact that it has received, before it reaches its column.
    pub fn reject(&self, event: &ImpactCommand, code: RejectionCode) {
        let (column, endpoint) = (Some(event.column_id.as_str()), &endpoints::IMPACT_EVENT);
        self.recording
            .rejected(column, endpoint, &event.event_id, Some(code), "for a test");
    }

    pub fn hit(&mut self, column: usize, event: ImpactCommand) {
        self.receive_event(&event);
        self.execute(column, Command::Impact(event));
    }

    /// As a thread of the pool, which gives a column its checkpoint before its command.
    pub fn execute(&mut self, column: usize, command: Command) {
        let (now, mut out) = (self.now, Vec::new());
        let at = &mut self.columns[column];
        at.twin.forget_what_is_too_old(now);
        at.twin.demand_checkpoint();
        let _ = at.twin.handle(command, now, &mut out);
        at.twin.advance_to(now, &mut out);
        at.plan(now);
        self.put(column, out);
    }

    fn put(&mut self, column: usize, out: Vec<Output>) {
        let (recording, board) = (&self.recording, &mut self.board);
        let Column {
            id,
            outgoing,
            announced,
            ..
        } = &mut self.columns[column];
        for output in out {
            if let Output::ParametersChanged(changed) = &output {
                *outgoing = Outgoing::new(&changed.parameters);
                if let Some(event) = parameter_event(changed, announced, &format!("{id}.")) {
                    recording.sent(&endpoints::PARAMETER_EVENTS, &event);
                }
                *announced = Arc::clone(&changed.parameters);
            }
            if let Output::Journal(entry) = &output {
                recording.journal(Some(id), entry);
                continue;
            }
            outgoing.convert(&output, |message| {
                if let Message::TwinStatus(status) = &message {
                    board.update(column, ColumnStatus::from(status));
                }
                // Joint states and markers are for readers of one column only.
                if message.column_id().is_some() {
                    let bytes = message.encode().expect("bytes").into();
                    recording.sent(message.topic().endpoint(), &bytes);
                }
            });
            // A column at rest needs no converter.
            let moving = [TwinPhase::Approach, TwinPhase::Contact, TwinPhase::Free];
            if matches!(&output, Output::Status(status) if !moving.contains(&status.phase)) {
                *outgoing = Outgoing::new(announced);
            }
        }
    }

    /// All columns that have something to do are advanced, and the node publishes what has changed.
    pub fn advance(&mut self, nanos: Nanos) {
        self.now += nanos;
        self.passed.store(self.now - START, Ordering::Relaxed);
        for column in 0..self.columns.len() {
            let (now, mut out) = (self.now, Vec::new());
            let at = &mut self.columns[column];
            if at.deadline.is_some_and(|it| it <= now) {
                at.twin.advance_to(now, &mut out);
                at.twin.run_ahead(64, now, &mut out);
                at.plan(now);
            }
            self.put(column, out);
        }
        let passed = Duration::from_nanos((self.now - START).unsigned_abs());
        for batch in self.board.due(passed) {
            let status = FleetStatus {
                header: Header {
                    stamp: Time::from_nanos(self.now).expect("a stamp"),
                    frame_id: String::new(),
                },
                columns_total: u32::try_from(self.columns.len()).expect("few"),
                of_all: batch.of_all,
                columns: batch.columns,
                ..FleetStatus::default()
            };
            let bytes = cdr::encode(&status).expect("bytes").into();
            self.recording.sent(&endpoints::FLEET_STATUS, &bytes);
        }
    }

    pub fn until_rest(&mut self) {
        while self.is_responding() {
            self.advance(MS);
        }
        self.advance(MS);
    }

    /// Ends the recording, and returns the directory that contains it.
    pub fn finish(self) -> TempDir {
        let statistics = self.recording.stop().expect("it ran");
        assert_eq!((statistics.lost, statistics.write_errors), (0, 0));
        self.directory
    }
}
