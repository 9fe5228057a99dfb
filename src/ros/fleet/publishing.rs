//! What the publishing thread of a fleet publishes besides the outputs of its columns: the status of all columns in few messages, copies
//! in the namespaces of single columns, and which columns a vehicle does not hit.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use crate::endpoints::{Endpoint, NodeKind};
use crate::fleet::{NotHit, StatusBatch, StatusBoard};
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::{
    ColumnStatus, FleetStatus, ImpactEvent, ImpactReport, TwinStatus,
};
use crate::messages::diagnostic_msgs::DiagnosticStatus;
use crate::messages::std_msgs::Header;
use crate::outgoing::{Message, Outgoing, Topic};
use crate::ros::counters::NodeCounters;
use crate::ros::live_columns::LiveColumns;
use crate::ros::measurements::SensedColumns;
use crate::ros::node::{Node, NodeError};
use crate::ros::notice_log::log;
use crate::ros::qos;
use crate::ros::sending::{Sending, encoded};
use crate::ros::transport::Publisher;
use crate::twin::{Output, Status};
use ros_node::matches::Matches;
use ros_node::raw::Raw;

use super::column_topics::{ColumnChange, ColumnWriters, TopicCounts};
use super::diagnostics::{Summary, column_statuses, summary, topics_status};
use super::rows::RowImpacts;
use super::sensors::{FleetSensors, SensorCount};

/// Maximum wait for an output before the thread checks whether there are new readers. A stop wakes it.
const MAX_WAIT: Duration = Duration::from_millis(250);

/// Minimum time between two rounds of all columns that new readers cause.
const READER_PERIOD: Duration = Duration::from_secs(1);

/// The last messages of a column that late joiners get.
#[derive(Default)]
struct Latest {
    /// From which the messages that show the column at rest are made.
    status: Option<Status>,
    /// Of topics that are kept for late joiners, except what follows from the status.
    messages: [Option<Raw>; Topic::COUNT],
}

/// What a fleet publishes besides the outputs of its columns.
pub(in crate::ros) struct FleetPublishing {
    fleet_status: Publisher<Raw>,
    matches: Arc<Matches>,
    /// Vehicles that hit several columns: the forecasts tell what comes next.
    rows: Arc<RowImpacts>,
    /// The health of the sensors, if there are any.
    sensors: Option<FleetSensors>,
    /// The writers of the columns that have topics of their own, because somebody listens there, and what changes of them.
    writers: HashMap<u32, ColumnWriters>,
    column_changes: mpsc::Receiver<ColumnChange>,
    topic_counts: Arc<TopicCounts>,
    /// For readers that join when a column gets topics of its own.
    latest: HashMap<u32, Latest>,
    board: StatusBoard,
    started: Instant,
    /// Readers of the status, when they were counted last, and when a new one got a round.
    readers: usize,
    last_reader_round: Option<Instant>,
}

impl FleetPublishing {
    pub fn new(
        node: &mut Node,
        columns: &LiveColumns,
        rows: Arc<RowImpacts>,
        sensed: Option<Arc<SensedColumns>>,
        (column_changes, topic_counts): (mpsc::Receiver<ColumnChange>, Arc<TopicCounts>),
    ) -> Result<Self, NodeError> {
        let ids = columns.face().ids().iter();
        Ok(Self {
            // Before the shared topics, so that others know that it is a fleet when they know of those.
            fleet_status: node.publisher(&qos::FLEET_STATUS)?,
            matches: node.matches(),
            rows,
            sensors: sensed.map(FleetSensors::new),
            writers: HashMap::new(),
            column_changes,
            topic_counts,
            latest: HashMap::new(),
            board: StatusBoard::new(ids.map(ToString::to_string)),
            started: Instant::now(),
            readers: 0,
            last_reader_round: None,
        })
    }

    /// The endpoint of a topic that the columns share, with a history for all of them; `None` if the topic shows one column only.
    pub fn shared_topic(&self, topic: Topic) -> Option<Endpoint> {
        let endpoint = topic.endpoint();
        let shared = || endpoint.kept_of_all(self.board.columns().len());
        endpoint.is_of(NodeKind::Fleet).then(shared)
    }

    /// Takes note of an output of a column before it is published.
    pub fn note(&mut self, column: u32, output: &Output, columns: &LiveColumns) {
        let column_id = columns.face().id(column);
        self.rows
            .take(column_id, output, || columns.parameters(column));
        if let Output::Status(status) = output {
            self.latest.entry(column).or_default().status = Some(status.clone());
        }
    }

    /// Takes the status of a column into the status of the fleet.
    pub fn update(&mut self, column: u32, status: &TwinStatus) {
        self.board
            .update(column as usize, ColumnStatus::from(status));
    }

    /// Whether a column has topics of its own.
    pub fn has_topics(&self, column: u32) -> bool {
        self.writers.contains_key(&column)
    }

    /// How long nothing is to be done, at most `longest`.
    pub fn wait(&self, columns: &LiveColumns, longest: Duration) -> Duration {
        let status = self.board.rest(self.started.elapsed());
        let longest = longest.min(status).min(MAX_WAIT);
        self.rows.rest(columns, longest)
    }

    /// Does what is due: for new readers, for vehicles that hit several columns, and for the status of all columns.
    pub fn look_around(
        &mut self,
        sending: &Sending,
        publishers: &[Option<Publisher<Raw>>],
        is_stopping: bool,
    ) {
        self.change_columns(sending);
        if !is_stopping {
            self.rows.submit_due();
        }
        self.not_hit(sending, publishers);
        if !sending.is_over {
            self.statuses(sending);
        }
    }

    /// Publishes the last messages of the fleet.
    pub fn finish(&mut self, sending: &Sending, publishers: &[Option<Publisher<Raw>>]) {
        self.rows.stop();
        self.not_hit(sending, publishers);
        self.statuses(sending);
    }

    /// The status of the fleet, that of all its sensors, and those of the columns that need somebody.
    pub fn diagnose(
        &mut self,
        columns: &LiveColumns,
        counters: &NodeCounters,
    ) -> (
        DiagnosticStatus,
        Option<DiagnosticStatus>,
        Vec<DiagnosticStatus>,
    ) {
        if let Some(sensors) = &mut self.sensors {
            let board = &mut self.board;
            sensors.look(columns.now(), |column, problem| {
                board.note_sensors(column as usize, problem);
            });
        }
        let first = summary(&Summary {
            columns: self.board.columns(),
            active: columns.active(),
            uncomputed: columns.without_critical_velocities(),
            threads: columns.threads(),
            ignored: counters.ignored.load(Ordering::Relaxed),
        });
        let sensors = self.sensors.as_ref();
        let sensing = columns.sensing_statistics().unwrap_or_default();
        let of_sensors = sensors.map(|it| it.status(sensing));
        let mut of_columns = column_statuses(self.board.columns());
        of_columns.extend(sensors.into_iter().flat_map(FleetSensors::worst));
        (first, of_sensors, of_columns)
    }

    /// Whether a column responds to an impact.
    pub fn is_responding(&self) -> bool {
        self.board.columns().iter().any(|it| !it.is_at_rest())
    }

    /// The status of the topics of single columns.
    pub fn topics_status(&self) -> DiagnosticStatus {
        topics_status(&self.topic_counts)
    }

    /// Takes the columns that have got topics of their own, or have lost them.
    fn change_columns(&mut self, sending: &Sending) {
        while let Ok(change) = self.column_changes.try_recv() {
            match change {
                ColumnChange::Opened(column, writers) => {
                    self.writers.insert(column, writers);
                    self.send_latest(sending, column);
                }
                ColumnChange::Closed(column) => {
                    self.writers.remove(&column);
                }
            }
        }
    }

    /// Gives the readers of a column that has got topics of its own what those of a single twin would get.
    fn send_latest(&self, sending: &Sending, column: u32) {
        let Some(latest) = self.latest.get(&column) else {
            return;
        };
        for (topic, raw) in Topic::ALL.into_iter().zip(&latest.messages) {
            if let Some(raw) = raw {
                self.copy(sending, column, topic, raw);
            }
        }
        let Some(mut status) = latest.status.clone() else {
            return;
        };
        if let Some(resting) = &mut status.at_rest {
            // These readers have not seen it.
            resting.is_unseen = true;
        }
        let mut outgoing = Outgoing::new(&sending.columns.parameters(column));
        outgoing.convert(&Output::Status(status), |mut message| {
            if let Message::TwinStatus(status) = &mut message {
                sending.add_health(status);
            }
            if let Some(raw) = encoded(message.encode()) {
                self.copy(sending, column, message.topic(), &raw);
            }
        });
    }

    /// Sends a message of a column in its namespace too, and keeps it for those who will join there.
    pub fn copy_and_keep(&mut self, sending: &Sending, column: u32, topic: Topic, raw: Raw) {
        self.copy(sending, column, topic, &raw);
        // The last status brings what shows the column at rest.
        let endpoint = topic.endpoint();
        if endpoint.qos.transient_local && !endpoint.shows_rest {
            let latest = self.latest.entry(column).or_default();
            latest.messages[topic.index()] = Some(raw);
        }
    }

    /// Sends a message in the namespace of a column, if somebody listens there. A copy is not recorded: the shared topics are.
    fn copy(&self, sending: &Sending, column: u32, topic: Topic, raw: &Raw) {
        let writer = self.writers.get(&column).and_then(|it| it.of(topic));
        if let Some(writer) = writer
            && !sending.is_over
            && !sending.withholds(topic.endpoint())
            && !sending.publish(writer, raw.clone())
        {
            NodeCounters::count(&sending.counters.unpublished);
            let name = &sending.columns.face().names()[column as usize];
            tracing::debug!(
                "a message on {name}/{} was not published",
                topic.endpoint().name
            );
        }
    }

    /// Publishes which columns a vehicle that was to hit several does not hit.
    fn not_hit(&self, sending: &Sending, publishers: &[Option<Publisher<Raw>>]) {
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
                    direction,
                    ..
                } = impact;
                self.send_not_recorded(
                    sending,
                    publishers,
                    &Message::ImpactForecast(ImpactReport {
                        header,
                        column_id,
                        event_id,
                        vehicle,
                        mass,
                        velocity,
                        direction,
                        ..ImpactReport::without_results(ImpactReport::NO_FORECAST, end, &reason)
                    }),
                );
            }
        }
    }

    /// Publishes what no column has told. It is not part of what a column does, so that a recording does not contain it.
    fn send_not_recorded(
        &self,
        sending: &Sending,
        publishers: &[Option<Publisher<Raw>>],
        message: &Message,
    ) {
        let topic = message.topic();
        let raw = encoded(message.encode());
        let face = sending.columns.face();
        let column = message.column_id().and_then(|it| face.index_of(it));
        if let (Some(column), Some(raw)) = (column, &raw) {
            self.copy(sending, column, topic, raw);
        }
        let is_sent = match (&publishers[topic.index()], raw) {
            (Some(publisher), Some(raw)) => sending.publish(publisher, raw),
            _ => false,
        };
        if !is_sent {
            NodeCounters::count(&sending.counters.unpublished);
        }
    }

    /// Publishes what is due of the statuses.
    fn statuses(&mut self, sending: &Sending) {
        self.look_for_readers();
        for batch in self.board.due(self.started.elapsed()) {
            let status = self.fleet_status(sending, batch);
            let bytes = cdr::encode(&status);
            sending.send(&self.fleet_status, &qos::FLEET_STATUS, bytes);
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

    fn fleet_status(&self, sending: &Sending, batch: StatusBatch) -> FleetStatus {
        let Sending {
            columns, counters, ..
        } = sending;
        let health = columns.health();
        let sensors = self.sensors.as_ref();
        let sensors = sensors.map_or_else(SensorCount::default, FleetSensors::count);
        let number = |it: usize| u32::try_from(it).unwrap_or(u32::MAX);
        FleetStatus {
            header: Header {
                stamp: Time::from_nanos(columns.now()).unwrap_or_default(),
                frame_id: String::new(),
            },
            columns_total: number(self.board.columns().len()),
            columns_active: number(columns.active()),
            of_all: batch.of_all,
            ignored: counters.ignored.load(Ordering::Relaxed),
            dropped_inputs: health.dropped_inputs
                + counters.rejected_senders()
                + counters.rejected_rows.load(Ordering::Relaxed),
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
}
