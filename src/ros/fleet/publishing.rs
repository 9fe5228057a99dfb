//! The publishing thread of a fleet: publishes the outputs of all columns on the topics that they share.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use ros2_client::Publisher;

use crate::endpoints::Endpoint;
use crate::fleet::{NotHit, StatusBatch, StatusBoard};
use crate::live::Receiver;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin_msgs::{
    ColumnStatus, FleetStatus, ImpactEvent, ImpactReport, TwinStatus,
};
use crate::messages::rcl_interfaces::ParameterEvent;
use crate::messages::std_msgs::Header;
use crate::outgoing::{Message, Outgoing, RecordingHealth, RecordingTap, Topic};
use crate::parameters::Parameters;
use crate::twin::{Notice, NoticeLevel, Output, Refused, RefusedInput, Status, TwinPhase};

use super::super::clock_watch::SeldomWarning;
use super::super::diagnostics::NodeCounters;
use super::super::live_twin::Health;
use super::super::loss_log::LossLog;
use super::super::matches::Matches;
use super::super::measurements::SensedColumns;
use super::super::node::{Node, NodeError};
use super::super::parameter_services;
use super::super::qos;
use super::super::raw::Raw;
use super::super::security::{Peers, Protection};
use super::column_topics::{ColumnChange, ColumnWriters, TopicCounts};
use super::diagnostics::{FleetObserved, fleet_diagnostics};
use super::live_fleet::FleetTwin;
use super::rows::RowImpacts;
use super::sensors::{FleetSensors, SensorCount};

/// Maximum time between two diagnostics.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// Maximum wait for an output before the thread checks whether there are new readers. A stop wakes it.
const MAX_WAIT: Duration = Duration::from_millis(250);

/// Minimum time between two rounds of all columns that new readers cause.
const READER_PERIOD: Duration = Duration::from_secs(1);

/// Maximum time to publish queued outputs after the stop.
const FINAL_PUBLISHING_TIME: Duration = Duration::from_millis(300);

/// Messages that are kept for late joiners, for each column: a forecast, and the same with the error of its time step. A report takes
/// 6 kB; with ten of each column, a thousand columns took 200 MB more once all of them had been hit.
const KEPT_OF_A_COLUMN: usize = 2;

/// Most messages that a writer keeps: as many as RustDDS allows to be unacknowledged.
const MAX_KEPT: usize = 8192;

/// The shared topics of a fleet among those of a twin. The others show one column: joint states and markers.
const TOPICS: [Topic; 6] = [
    Topic::ColumnState,
    Topic::HingeForces,
    Topic::ImpactForecast,
    Topic::ImpactReport,
    Topic::ImpactEstimate,
    Topic::TwinStatus,
];

/// The last messages of a column that late joiners get.
#[derive(Default)]
struct Latest {
    /// From which the messages that show the column at rest are made.
    status: Option<Status>,
    /// Of topics that are kept for late joiners, except what follows from the status.
    messages: [Option<Raw>; Topic::COUNT],
}

/// Publishes all outputs of the columns.
pub(super) struct FleetPublishing {
    of_columns: Vec<(Topic, Publisher<Raw>)>,
    fleet_status: Publisher<Raw>,
    diagnostics: Publisher<Raw>,
    parameter_events: Publisher<Raw>,
    /// The parameters of the columns whose parameters have changed since the start.
    changed_parameters: HashMap<u32, Arc<Parameters>>,
    recording: Option<Arc<dyn RecordingTap>>,
    matches: Arc<Matches>,
    fleet: Arc<FleetTwin>,
    /// Vehicles that hit several columns: the forecasts tell what comes next.
    rows: Arc<RowImpacts>,
    counters: Arc<NodeCounters>,
    /// The health of the sensors, if there are any.
    sensors: Option<FleetSensors>,
    protection: Arc<Protection>,
    peers: Arc<Peers>,
    node_name: String,
    fully_qualified: String,
    /// The converters of the columns that respond: they know what was published of the response.
    converters: HashMap<u32, Outgoing>,
    /// The writers of the columns that have topics of their own, because somebody listens there, and what changes of them.
    columns: HashMap<u32, ColumnWriters>,
    column_changes: mpsc::Receiver<ColumnChange>,
    topic_counts: Arc<TopicCounts>,
    /// For readers that join when a column gets topics of its own.
    latest: HashMap<u32, Latest>,
    board: StatusBoard,
    started: Instant,
    /// Readers of the status, when they were counted last, and when a new one got a round.
    readers: usize,
    last_reader_round: Option<Instant>,
    last_diagnostics: Option<Instant>,
    clock_warning: SeldomWarning,
    loss_log: LossLog,
    /// The time to publish is over.
    is_over: bool,
}

impl FleetPublishing {
    pub fn new(
        node: &mut Node,
        fleet: Arc<FleetTwin>,
        counters: Arc<NodeCounters>,
        rows: Arc<RowImpacts>,
        sensed: Option<Arc<SensedColumns>>,
        recording: Option<Arc<dyn RecordingTap>>,
        (column_changes, topic_counts): (mpsc::Receiver<ColumnChange>, Arc<TopicCounts>),
    ) -> Result<Self, NodeError> {
        let columns = fleet.column_ids().len();
        // First, so that others know that it is a fleet when they know of its other topics.
        let fleet_status = node.publisher(&qos::FLEET_STATUS)?;
        let mut of_columns = Vec::new();
        for topic in TOPICS {
            let publisher = node.publisher(&kept_of_all(topic.endpoint(), columns))?;
            of_columns.push((topic, publisher));
        }
        Ok(Self {
            of_columns,
            fleet_status,
            diagnostics: node.publisher(&qos::DIAGNOSTICS)?,
            parameter_events: node.publisher(&qos::PARAMETER_EVENTS)?,
            changed_parameters: HashMap::new(),
            recording,
            matches: node.matches(),
            board: StatusBoard::new(fleet.column_ids().iter().map(ToString::to_string)),
            fleet,
            rows,
            counters,
            sensors: sensed.map(FleetSensors::new),
            protection: node.protection(),
            peers: node.security_peers(),
            node_name: node.names().node().to_owned(),
            fully_qualified: node.names().fully_qualified(),
            converters: HashMap::new(),
            columns: HashMap::new(),
            column_changes,
            topic_counts,
            latest: HashMap::new(),
            started: Instant::now(),
            readers: 0,
            last_reader_round: None,
            last_diagnostics: None,
            clock_warning: SeldomWarning::default(),
            loss_log: LossLog::default(),
            is_over: false,
        })
    }

    /// Publishes until `stop` is set and no outputs are queued. The fleet must be stopped before, so that its queues bound the
    /// remaining outputs.
    pub fn run(mut self, mut outputs: Receiver, stop: &AtomicBool) {
        let mut end = None;
        loop {
            let is_stopping = stop.load(Ordering::Relaxed);
            if is_stopping {
                let end = *end.get_or_insert_with(|| Instant::now() + FINAL_PUBLISHING_TIME);
                if Instant::now() >= end && !std::mem::replace(&mut self.is_over, true) {
                    let what = match &self.recording {
                        Some(_) => "recorded only",
                        None => "lost",
                    };
                    tracing::error!(
                        "some outputs could not be published before the end; they are {what}"
                    );
                }
            }
            match outputs.try_next_of() {
                Some((column, output)) => {
                    self.rows.take(self.column_id(column), &output, || {
                        self.fleet.parameters(column)
                    });
                    self.publish(column, output);
                }
                None if is_stopping => {
                    self.rows.stop();
                    self.not_hit();
                    self.statuses();
                    return;
                }
                None => outputs.wait(self.wait()),
            }
            self.change_columns();
            if !is_stopping {
                self.rows.submit_due(&self.fleet);
            }
            self.not_hit();
            if !self.is_over {
                self.statuses();
                self.diagnose_now_and_then();
            }
        }
    }

    /// Takes the columns that have got topics of their own, or have lost them.
    fn change_columns(&mut self) {
        while let Ok(change) = self.column_changes.try_recv() {
            match change {
                ColumnChange::Opened(column, writers) => {
                    self.columns.insert(column, writers);
                    self.send_latest(column);
                }
                ColumnChange::Closed(column) => {
                    self.columns.remove(&column);
                }
            }
        }
    }

    /// Gives the readers of a column that has got topics of its own what those of a single twin would get.
    fn send_latest(&self, column: u32) {
        let Some(latest) = self.latest.get(&column) else {
            return;
        };
        for (topic, raw) in Topic::ALL.into_iter().zip(&latest.messages) {
            if let Some(raw) = raw {
                self.copy(column, topic, raw);
            }
        }
        let Some(mut status) = latest.status.clone() else {
            return;
        };
        if let Some(resting) = &mut status.at_rest {
            // These readers have not seen it.
            resting.is_unseen = true;
        }
        let mut outgoing = Outgoing::new(&self.fleet.parameters(column));
        outgoing.convert(&Output::Status(status), |mut message| {
            if let Message::TwinStatus(status) = &mut message {
                self.add_health(status);
            }
            if let Some(raw) = encoded(&message) {
                self.copy(column, message.topic(), &raw);
            }
        });
    }

    /// Sends a message in the namespace of a column, if somebody listens there. A copy is not recorded: the shared topics are.
    fn copy(&self, column: u32, topic: Topic, raw: &Raw) {
        let writer = self.columns.get(&column).and_then(|it| it.of(topic));
        if let Some(writer) = writer
            && !self.is_over
            && !self.publish_raw(writer, raw.clone())
        {
            NodeCounters::count(&self.counters.unpublished);
            let name = &self.fleet.column_names()[column as usize];
            tracing::debug!(
                "a message on {name}/{} was not published",
                topic.endpoint().name
            );
        }
    }

    fn wait(&self) -> Duration {
        let since = self.last_diagnostics.as_ref().map(Instant::elapsed);
        let diagnostics = since.map_or(Duration::ZERO, |it| DIAGNOSTICS_PERIOD.saturating_sub(it));
        let status = self.board.rest(self.started.elapsed());
        let longest = diagnostics.min(status).min(MAX_WAIT);
        self.rows.rest(&self.fleet, longest)
    }

    /// Publishes which columns a vehicle that was to hit several does not hit.
    fn not_hit(&mut self) {
        for ended in self.rows.take_ended() {
            let NotHit {
                impacts,
                reason,
                level,
                is_rejected,
            } = ended;
            if !is_rejected {
                let ids: Vec<_> = impacts.iter().map(|it| it.column_id.as_str()).collect();
                let text = format!("columns that are not hit: {}; {reason}", ids.join(", "));
                log(level, &text);
            }
            let end = match is_rejected {
                true => ImpactReport::END_REJECTED,
                false => ImpactReport::END_NOT_HIT,
            };
            for impact in impacts {
                let ImpactEvent {
                    header,
                    column_id,
                    event_id,
                    vehicle,
                    mass,
                    velocity,
                    ..
                } = impact;
                self.send_not_recorded(&Message::ImpactForecast(ImpactReport {
                    header,
                    column_id,
                    event_id,
                    vehicle,
                    mass,
                    velocity,
                    ..ImpactReport::without_results(ImpactReport::NO_FORECAST, end, &reason)
                }));
            }
        }
    }

    fn publish(&mut self, column: u32, output: Output) {
        match &output {
            Output::Refused(refused) => return self.log_refusal(column, refused),
            Output::Notice(notice) => return self.log_notice(column, notice),
            Output::ParametersChanged(changed) => {
                tracing::info!(
                    "parameters of column {:?}: {}",
                    self.column_id(column),
                    changed.names.join(", ")
                );
                // It knows the names and lengths of before.
                self.converters.remove(&column);
                self.parameters_changed(column, &changed.parameters);
                return;
            }
            Output::Journal(entry) => {
                if let Some(recording) = &self.recording {
                    recording.journal(Some(self.column_id(column)), entry);
                }
                return;
            }
            Output::Save(_) => return,
            Output::State(_)
            | Output::Forecast(_)
            | Output::Report(_)
            | Output::Ranged(_)
            | Output::Withdrawn(_)
            | Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::Calibrated(_)
            | Output::Status(_) => {}
        }
        if !self.converters.contains_key(&column) {
            let parameters = self.fleet.parameters(column);
            self.converters.insert(column, Outgoing::new(&parameters));
        }
        let Some(outgoing) = self.converters.get_mut(&column) else {
            return;
        };
        let mut messages = Vec::new();
        outgoing.convert(&output, |message| messages.push(message));
        for mut message in messages {
            if let Message::TwinStatus(status) = &mut message {
                self.add_health(status);
                self.board
                    .update(column as usize, ColumnStatus::from(&*status));
            }
            self.send(column, &message);
        }
        if let Output::Status(status) = &output {
            self.latest.entry(column).or_default().status = Some(status.clone());
        }
        // A column at rest needs no converter.
        if let Output::Status(status) = &output
            && !matches!(
                status.phase,
                TwinPhase::Approach | TwinPhase::Contact | TwinPhase::Free
            )
        {
            self.converters.remove(&column);
        }
    }

    /// Publishes which parameters of a column have other values now.
    fn parameters_changed(&mut self, column: u32, now: &Arc<Parameters>) {
        let before = match self.changed_parameters.insert(column, Arc::clone(now)) {
            Some(before) => before,
            None => self.fleet.initial_parameters(column),
        };
        let node = self.fully_qualified.clone();
        let stamp = self.fleet.now();
        let Some(mut event) = parameter_services::event(node, stamp, Some(&before), now) else {
            return;
        };
        let column_id = self.column_id(column);
        for it in &mut event.changed_parameters {
            it.name = format!("{column_id}.{}", it.name);
        }
        self.send_bytes(
            &self.parameter_events,
            &qos::PARAMETER_EVENTS,
            cdr::encode_as::<ParameterEvent, _>(&event),
        );
    }

    /// Adds the state of threads and queues, which all columns share and the twin does not know.
    fn add_health(&self, status: &mut TwinStatus) {
        let health = self.fleet.health();
        status.overruns = health.overruns;
        status.worst_lateness = health.worst_lateness;
        status.dropped_inputs = health.dropped_inputs + self.counters.rejected_senders();
        status.dropped_states = health.dropped_states;
        status.dropped_recording = self.recording_health(&health).map_or(0, |it| it.lost);
    }

    /// Outputs that the queue to this thread dropped are missing in the recording too, which receives its messages here.
    fn recording_health(&self, health: &Health) -> Option<RecordingHealth> {
        let mut recording = self.recording.as_ref()?.health();
        recording.lost += health.dropped_recording;
        Some(recording)
    }

    fn column_id(&self, column: u32) -> &str {
        let ids = self.fleet.column_ids();
        ids.get(column as usize).map_or("", |it| it)
    }

    /// Publishes what is due of the statuses.
    fn statuses(&mut self) {
        self.look_for_readers();
        for batch in self.board.due(self.started.elapsed()) {
            let status = self.fleet_status(batch);
            self.send_bytes(&self.fleet_status, &qos::FLEET_STATUS, cdr::encode(&status));
        }
    }

    /// A reader that has joined gets all columns: what is kept for late joiners may be changes of a few.
    fn look_for_readers(&mut self) {
        let readers = self.matches.count(self.fleet_status.guid());
        let is_spaced = self
            .last_reader_round
            .is_none_or(|last| last.elapsed() >= READER_PERIOD);
        if readers > self.readers && is_spaced {
            self.board.want_round();
            self.last_reader_round = Some(Instant::now());
            self.readers = readers;
        }
        self.readers = self.readers.min(readers);
    }

    fn fleet_status(&self, batch: StatusBatch) -> FleetStatus {
        let health = self.fleet.health();
        let sensors = self.sensors.as_ref();
        let sensors = sensors.map_or_else(SensorCount::default, FleetSensors::count);
        let number = |it: usize| u32::try_from(it).unwrap_or(u32::MAX);
        FleetStatus {
            header: self.header(),
            columns_total: number(self.board.columns().len()),
            columns_active: number(self.fleet.active()),
            of_all: batch.of_all,
            ignored: self.counters.ignored.load(Ordering::Relaxed),
            dropped_inputs: health.dropped_inputs
                + self.counters.rejected_senders()
                + self.counters.rejected_rows.load(Ordering::Relaxed),
            dropped_states: health.dropped_states,
            dropped_outputs: health
                .dropped_recording
                .saturating_sub(health.dropped_states),
            late_states: health.overruns,
            worst_lateness: health.worst_lateness,
            sensors_total: number(sensors.total),
            sensors_faulty: number(sensors.faulty),
            dropped_measurements: sensors.lost_batches,
            columns: batch.columns,
        }
    }

    fn header(&self) -> Header {
        Header {
            stamp: Time::from_nanos(self.fleet.now()).unwrap_or_default(),
            frame_id: String::new(),
        }
    }

    fn diagnose_now_and_then(&mut self) {
        if let Some(clock) = self.counters.clock.as_ref().filter(|it| it.count() == 0) {
            let now = Instant::now();
            if let Some(problem) = clock.problem(now)
                && self.clock_warning.is_due(now)
            {
                tracing::warn!("{problem}");
            }
        }
        let last = self.last_diagnostics.as_ref();
        if last.is_some_and(|at| at.elapsed() < DIAGNOSTICS_PERIOD) {
            return;
        }
        let health: Health = self.fleet.health();
        self.loss_log.look(&health, &self.counters, Instant::now());
        if let Some(sensors) = &mut self.sensors {
            sensors.look(self.fleet.now(), |column, problem| {
                self.board.note_sensors(column as usize, problem);
            });
        }
        let array = fleet_diagnostics(
            self.header(),
            &self.node_name,
            FleetObserved {
                columns: self.board.columns(),
                active: self.fleet.active(),
                uncomputed: self.fleet.without_critical_velocities(),
                threads: self.fleet.threads(),
                health: &health,
                recording: self.recording_health(&health).as_ref(),
                security: self.protection.health(&self.peers),
                sensors: self.sensors.as_ref(),
                sensing: self.fleet.sensing_statistics(),
                counters: &self.counters,
                topics: &self.topic_counts,
            },
        );
        self.send_bytes(&self.diagnostics, &qos::DIAGNOSTICS, cdr::encode(&array));
        self.last_diagnostics = Some(Instant::now());
    }

    /// Publishes what no column has told. It is not part of what a column does, so that a recording does not contain it.
    fn send_not_recorded(&self, message: &Message) {
        let topic = message.topic();
        let publisher = self.of_columns.iter().find(|(it, _)| *it == topic);
        let raw = encoded(message);
        let column = message.column_id().and_then(|it| self.fleet.index_of(it));
        if let (Some(column), Some(raw)) = (column, &raw) {
            self.copy(column, topic, raw);
        }
        let is_sent = match (publisher, raw) {
            (Some((_, publisher)), Some(raw)) => self.publish_raw(publisher, raw),
            _ => false,
        };
        if !is_sent {
            NodeCounters::count(&self.counters.unpublished);
        }
    }

    fn send(&mut self, column: u32, message: &Message) {
        let topic = message.topic();
        let publisher = self.of_columns.iter().find(|(it, _)| *it == topic);
        // Joint states and markers are for readers of one column only.
        if publisher.is_none() && !self.columns.contains_key(&column) {
            return;
        }
        let raw = encoded(message);
        if let Some((_, publisher)) = publisher {
            self.send_raw(publisher, topic.endpoint(), raw.as_ref());
        }
        let Some(raw) = raw else {
            return;
        };
        self.copy(column, topic, &raw);
        let is_of_status = matches!(
            topic,
            Topic::TwinStatus | Topic::JointStates | Topic::Markers
        );
        if topic.endpoint().qos.transient_local && !is_of_status {
            let latest = self.latest.entry(column).or_default();
            latest.messages[topic.index()] = Some(raw);
        }
    }

    /// Publishes one message without waiting. If a reader is so slow that the history is full, the message is lost for it, and
    /// counted.
    fn send_bytes(
        &self,
        publisher: &Publisher<Raw>,
        endpoint: &Endpoint,
        bytes: Result<Vec<u8>, CdrError>,
    ) {
        let raw = bytes.ok().and_then(|bytes| Raw::new(bytes.into()).ok());
        self.send_raw(publisher, endpoint, raw.as_ref());
    }

    fn send_raw(&self, publisher: &Publisher<Raw>, endpoint: &Endpoint, raw: Option<&Raw>) {
        if let (Some(recording), Some(raw)) = (&self.recording, raw) {
            recording.sent(endpoint, raw.bytes());
        }
        let is_sent = raw.is_some_and(|raw| self.publish_raw(publisher, raw.clone()));
        if !is_sent {
            NodeCounters::count(&self.counters.unpublished);
            tracing::debug!("a message on {} was not published", endpoint.name);
        }
    }

    /// Returns whether it is sent.
    fn publish_raw(&self, publisher: &Publisher<Raw>, raw: Raw) -> bool {
        self.counters.lost_peers.count_published();
        !self.is_over && publisher.publish(raw).is_ok()
    }

    fn log_refusal(&self, column: u32, refused: &Refused) {
        let Refused {
            refusal,
            event_id,
            source,
            ..
        } = refused;
        let column_id = self.column_id(column);
        match refused.what {
            RefusedInput::Impact => tracing::warn!(
                "impact event {event_id:?} for column {column_id:?} was rejected: {refusal}"
            ),
            RefusedInput::Parameters => tracing::warn!(
                "a change of parameters of column {column_id:?} by {source} was rejected: {refusal}"
            ),
            RefusedInput::Estimate | RefusedInput::Calibration => tracing::warn!(
                "what the sensors of column {column_id:?} tell was rejected: {refusal}"
            ),
        }
    }

    fn log_notice(&self, column: u32, notice: &Notice) {
        let (column_id, text) = (self.column_id(column), &notice.text);
        log(notice.level, &format!("column {column_id:?}: {text}"));
    }
}

fn encoded(message: &Message) -> Option<Raw> {
    let bytes = message.encode().ok()?;
    Raw::new(bytes.into()).ok()
}

fn log(level: NoticeLevel, text: &str) {
    match level {
        NoticeLevel::Info => tracing::info!("{text}"),
        NoticeLevel::Warning => tracing::warn!("{text}"),
        NoticeLevel::Error => tracing::error!("{text}"),
    }
}

/// The endpoint with a history for all columns, if it keeps messages for late joiners.
fn kept_of_all(endpoint: &Endpoint, columns: usize) -> Endpoint {
    let mut endpoint = *endpoint;
    if endpoint.qos.transient_local {
        let of_each = endpoint.qos.depth.min(KEPT_OF_A_COLUMN);
        endpoint.qos.depth = (of_each * columns).clamp(endpoint.qos.depth, MAX_KEPT);
    }
    endpoint
}
