//! The publishing thread: publishes the outputs of all columns. The solver never waits for it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::live::OutputSource;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::messages::diagnostic_msgs::DiagnosticArray;
use crate::messages::rcl_interfaces::ParameterEvent;
use crate::messages::std_msgs::Header;
use crate::outgoing::{Message, Outgoing, Topic};
use crate::parameters::{Parameters, is_of_the_fleet};
use crate::twin::{Accepted, Output, ParametersChanged, TwinPhase};

use super::counters::NodeCounters;
use super::diagnostics::{Observed, diagnostics, same_state, sensors_status, twin_status};
use super::fleet::FleetPublishing;
use super::loss_log::LossLog;
use super::measurements::SensedColumns;
use super::metrics::Known;
use super::node::{Node, NodeError};
use super::output_log::OutputLog;
use super::parameter_services;
use super::qos;
use super::security_health::security_health;
use super::sending::{Sending, encoded};
use super::transport::Publisher;
use super::unannounced::Unannounced;
use super::withheld::{SAVING_INTERVAL, Withheld};
use ros_node::clock_watch::SeldomWarning;
use ros_node::matches::Matches;
use ros_node::raw::Raw;
use ros_node::security::{Peers, Protection};

/// Maximum time between two diagnostics, and the time after which they go out with whatever is published: so they follow the status, which
/// comes every second, and a node at rest wakes once and not twice.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_millis(1050);
const DIAGNOSTICS_DUE: Duration = Duration::from_millis(950);

/// How long the status is published after the last response of a managed node that is not active: until that of a fleet has been told
/// as well.
const LAST_STATUS_TIME: Duration = Duration::from_secs(2);

/// Maximum time to publish queued outputs after the stop.
const FINAL_PUBLISHING_TIME: Duration = Duration::from_millis(300);

/// Publishes all outputs of the columns, and passes the same bytes to the recording.
pub(super) struct Publishing {
    sending: Sending,
    /// In the order of [`Topic::ALL`]; `None` for what a fleet publishes in the namespaces of its columns only.
    publishers: Vec<Option<Publisher<Raw>>>,
    diagnostics: Publisher<Raw>,
    parameter_events: Publisher<Raw>,
    /// The peers of `parameter_events`.
    matches: Arc<Matches>,
    /// What a fleet publishes besides.
    fleet: Option<FleetPublishing>,
    /// The sensors, if there are any.
    sensed: Option<Arc<SensedColumns>>,
    protection: Arc<Protection>,
    peers: Arc<Peers>,
    node_name: String,
    fully_qualified: String,
    /// Of the diagnostics: a fleet has none.
    frame_id: String,
    /// The converters of the columns: they know what was published of a response.
    converters: HashMap<u32, Outgoing>,
    /// The parameters of the columns whose parameters have changed since the start.
    changed_parameters: HashMap<u32, Arc<Parameters>>,
    unannounced: Unannounced,
    /// What waits until damage is written.
    withheld: Withheld,
    /// The parameters of a single twin that wait for the end of the response.
    waiting: Vec<String>,
    /// The status of a single twin.
    status: TwinStatus,
    last_diagnostics: Option<(Instant, DiagnosticArray)>,
    /// When a column of a managed node was seen to respond last.
    last_response: Option<Instant>,
    clock_warning: SeldomWarning,
    loss_log: LossLog,
    log: OutputLog,
}

impl Publishing {
    /// `fleet` is what a fleet publishes besides.
    pub fn new(
        node: &mut Node,
        sending: Sending,
        sensed: Option<Arc<SensedColumns>>,
        fleet: Option<FleetPublishing>,
    ) -> Result<Self, NodeError> {
        let columns = Arc::clone(&sending.columns);
        let publishers: Result<_, _> = Topic::ALL
            .iter()
            .map(|topic| match &fleet {
                None => node.publisher(topic.endpoint()).map(Some),
                Some(fleet) => {
                    let shared = fleet.shared_topic(*topic);
                    shared.map(|it| node.publisher(&it)).transpose()
                }
            })
            .collect();
        let settings = columns.node_parameters().settings();
        let is_single = fleet.is_none();
        let of_single = |text: &String| match is_single {
            true => text.clone(),
            false => String::new(),
        };
        Ok(Self {
            publishers: publishers?,
            diagnostics: node.publisher(&qos::DIAGNOSTICS)?,
            parameter_events: node.publisher(&qos::PARAMETER_EVENTS)?,
            matches: node.matches(),
            fleet,
            sensed,
            protection: node.protection(),
            peers: node.security_peers(),
            node_name: node.names().node().to_owned(),
            fully_qualified: node.names().fully_qualified(),
            frame_id: of_single(&settings.frame_id),
            converters: HashMap::new(),
            changed_parameters: HashMap::new(),
            unannounced: Unannounced::new(columns.face()),
            withheld: Withheld::default(),
            waiting: Vec::new(),
            status: TwinStatus {
                column_id: of_single(&settings.column_id),
                ..TwinStatus::default()
            },
            last_diagnostics: None,
            last_response: None,
            clock_warning: SeldomWarning::default(),
            loss_log: LossLog::default(),
            log: OutputLog::new(columns),
            sending,
        })
    }

    /// Publishes until `stop` is set and no outputs are queued. A stop takes effect when the source of the outputs is woken. The
    /// columns must be stopped before, so that their queues bound the remaining outputs.
    pub fn run(mut self, mut outputs: impl OutputSource, stop: &AtomicBool) {
        let mut end = None;
        loop {
            let is_stopping = stop.load(Ordering::Relaxed);
            self.announce_parameters(is_stopping);
            self.look_at_lifecycle();
            if is_stopping {
                let end = *end.get_or_insert_with(|| Instant::now() + FINAL_PUBLISHING_TIME);
                if Instant::now() >= end && !self.sending.is_over {
                    self.end_publishing();
                }
            }
            self.release();
            let next = match outputs.receive_of(Duration::ZERO) {
                None if !is_stopping || !self.withheld.is_empty() => {
                    outputs.receive_of(self.wait())
                }
                next => next,
            };
            match next {
                Some((column, output)) => self.pass(column, output),
                None if is_stopping && self.withheld.is_empty() => return self.finish(),
                None => {}
            }
            if let Some(fleet) = &mut self.fleet {
                fleet.look_around(&self.sending, &self.publishers, is_stopping);
            }
            if !self.sending.is_over {
                self.warn_of_a_missing_clock();
                let last = self.last_diagnostics.as_ref();
                if last.is_none_or(|(at, _)| at.elapsed() >= DIAGNOSTICS_DUE) {
                    self.look_at_sensors();
                    self.diagnose(true);
                }
            }
        }
    }

    /// Tells the alarms how the sensors are, and that the node lives; shows the newest metrics.
    fn look_at_sensors(&mut self) {
        let is_wanted = self.sending.metrics.is_some();
        #[cfg(feature = "alarm")]
        let is_wanted = is_wanted || self.sending.alarms.is_some();
        if !is_wanted {
            return;
        }
        let now = self.sending.columns.now();
        let sensed = self.sensed.iter().flat_map(|it| it.columns());
        let sensors: Vec<_> = sensed
            .map(|it| (it.column_id().to_owned(), it.health(now)))
            .collect();
        let mut channels = Vec::new();
        #[cfg(feature = "alarm")]
        if let Some(alarms) = &mut self.sending.alarms {
            // While impacts are rejected, whoever waits for signs of life must be told.
            if self.sending.counters.is_active() {
                alarms.sign_of_life();
                for (column_id, health) in &sensors {
                    alarms.sensors(column_id, health);
                }
            }
            channels = alarms.channels();
        }
        #[cfg(not(feature = "alarm"))]
        channels.clear();
        if let Some(metrics) = &self.sending.metrics {
            let health = self.sending.columns.health();
            metrics.show(&Known {
                recording: self.sending.recording_health(&health).as_ref(),
                health: &health,
                counters: &self.sending.counters,
                sensors: &sensors,
                alarms: &channels,
                foxglove: self.sending.foxglove_counts(),
            });
        }
    }

    /// What is queued still is only recorded.
    fn end_publishing(&mut self) {
        self.sending.is_over = true;
        let what = match &self.sending.recording {
            Some(_) => "recorded only",
            None => "lost",
        };
        tracing::error!("some outputs could not be published before the end; they are {what}");
    }

    fn finish(&mut self) {
        if let Some(fleet) = &mut self.fleet {
            fleet.finish(&self.sending, &self.publishers);
        }
        #[cfg(feature = "alarm")]
        if let Some(alarms) = self.sending.alarms.take() {
            alarms.stop();
        }
    }

    fn warn_of_a_missing_clock(&mut self) {
        let Some(clock) = &self.sending.counters.clock else {
            return;
        };
        let now = Instant::now();
        if let Some(problem) = clock.problem(now, || self.is_responding())
            && self.clock_warning.is_due(now)
        {
            tracing::warn!("{problem}");
        }
    }

    /// Whether a column responds to an impact.
    fn is_responding(&self) -> bool {
        let fleet = self.fleet.as_ref();
        fleet.map_or(!self.status.is_at_rest(), FleetPublishing::is_responding)
    }

    fn wait(&self) -> Duration {
        let since = self.last_diagnostics.as_ref().map(|(at, _)| at.elapsed());
        let rest = since.map_or(Duration::ZERO, |it| DIAGNOSTICS_PERIOD.saturating_sub(it));
        let rest = rest.min(self.unannounced.wait());
        let rest = match self.withheld.is_empty() {
            true => rest,
            false => rest.min(SAVING_INTERVAL),
        };
        let fleet = self.fleet.as_ref();
        fleet.map_or(rest, |it| it.wait(&self.sending.columns, rest))
    }

    /// Publishes an output, unless it has to wait until the damage of its column is written.
    fn pass(&mut self, column: u32, output: Output) {
        let columns = &self.sending.columns;
        let is_saving = |column| columns.is_saving(column);
        let passed = self
            .withheld
            .pass(column, output, Instant::now(), is_saving);
        if let Some(output) = passed {
            self.publish(column, output);
        }
    }

    /// Publishes what need not wait any longer.
    fn release(&mut self) {
        loop {
            let columns = &self.sending.columns;
            let is_saving = |column| columns.is_saving(column);
            let released = self.withheld.release(Instant::now(), is_saving);
            let Some((column, forecast, behind)) = released else {
                return;
            };
            self.publish(column, forecast);
            for output in behind {
                self.pass(column, output);
            }
        }
    }

    fn publish(&mut self, column: u32, output: Output) {
        let is_fleet = self.fleet.is_some();
        self.log.note(column, &output);
        let columns = &self.sending.columns;
        #[cfg(feature = "alarm")]
        if let Some(alarms) = &mut self.sending.alarms {
            alarms.note(columns.face().id(column), &output);
        }
        if let Some(metrics) = &mut self.sending.metrics {
            metrics.note(columns.face().id(column), &output, columns.now());
        }
        if let Some(fleet) = &mut self.fleet {
            fleet.note(column, &output, &self.sending.columns);
        }
        self.messages(column, &output);
        match output {
            Output::Journal(entry) => {
                if let Some(recording) = &self.sending.recording {
                    let column = self.sending.columns.face().recorded(column);
                    recording.journal(column, &entry);
                }
            }
            Output::ParametersChanged(changed) => {
                self.parameters_changed(column, changed);
                if is_fleet {
                    // It knows the names and lengths of before.
                    self.converters.remove(&column);
                }
            }
            // A column of a fleet that is at rest needs no converter.
            Output::Status(status) if is_fleet && !is_responding(status.phase) => {
                self.converters.remove(&column);
            }
            Output::Status(_)
            | Output::State(_)
            | Output::Forecast(_)
            | Output::Report(_)
            | Output::Supplemented(_)
            | Output::Withdrawn(_)
            | Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::Rejected(_)
            | Output::Notice(_)
            | Output::Save(_) => {}
        }
    }

    /// Publishes the messages of an output.
    fn messages(&mut self, column: u32, output: &Output) {
        let columns = &self.sending.columns;
        let outgoing = match self.converters.entry(column) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(_) if !has_messages(output) => return,
            Entry::Vacant(new) => new.insert(Outgoing::new(&columns.parameters(column))),
        };
        let mut messages = Vec::new();
        outgoing.convert(output, |message| messages.push(message));
        for mut message in messages {
            if let Message::TwinStatus(status) = &mut message {
                self.sending.add_health(status);
                match &mut self.fleet {
                    Some(fleet) => fleet.update(column, status),
                    None => self.status = status.clone(),
                }
            }
            self.send(column, &message);
            if matches!(message, Message::TwinStatus(_)) && self.fleet.is_none() {
                self.diagnose(false);
            }
        }
    }

    fn send(&mut self, column: u32, message: &Message) {
        let topic = message.topic();
        let publisher = self.publishers[topic.index()].as_ref();
        let fleet = self.fleet.as_mut();
        // What is published for the readers of one column only.
        if publisher.is_none() && !fleet.as_ref().is_some_and(|it| it.has_topics(column)) {
            return;
        }
        let raw = encoded(message.encode());
        if let Some(publisher) = publisher {
            self.sending
                .send_raw(publisher, topic.endpoint(), raw.as_ref());
        }
        if let (Some(fleet), Some(raw)) = (fleet, raw) {
            fleet.copy_and_keep(&self.sending, column, topic, raw);
        }
    }

    /// Decides whether a managed node is silent: while it is not active, except for the end of a response. Publishes the status of a
    /// single twin when the silence ends: its readers have got nothing until then. It has been recorded already.
    fn look_at_lifecycle(&mut self) {
        if self.sending.counters.lifecycle.is_none() {
            return;
        }
        let now = Instant::now();
        if self.is_responding() {
            self.last_response = Some(now);
        }
        let since = self.last_response.map(|it| now.duration_since(it));
        let is_silent =
            !self.sending.counters.is_active() && since.is_none_or(|it| it >= LAST_STATUS_TIME);
        let was_silent = std::mem::replace(&mut self.sending.is_silent, is_silent);
        let has_status = self.fleet.is_none() && self.converters.contains_key(&0);
        if is_silent || !was_silent || !has_status {
            return;
        }
        let status = Message::TwinStatus(self.status.clone());
        let publisher = self.publishers[status.topic().index()].as_ref();
        let raw = encoded(status.encode());
        if let (Some(publisher), Some(raw)) = (publisher, raw)
            && !self.sending.publish(publisher, raw)
        {
            NodeCounters::count(&self.sending.counters.unpublished);
        }
    }

    /// Publishes all parameters as new, once: as soon as there is a reader, which is only then matched, or after a while
    /// without one, for the recording. `at_once` does not wait.
    fn announce_parameters(&mut self, at_once: bool) {
        let readers = || self.matches.count(self.parameter_events.guid());
        if let Some(of) = self
            .unannounced
            .next(Instant::now(), at_once, || readers() > 0)
        {
            self.announce(of);
        }
    }

    fn announce(&self, of: Option<u32>) {
        let columns = &self.sending.columns;
        let parameters = match of {
            Some(column) => columns.initial_parameters(column),
            None => columns.node_parameters(),
        };
        self.send_parameter_event(of, None, parameters);
    }

    fn parameters_changed(&mut self, column: u32, changed: ParametersChanged) {
        if self.unannounced.take(column) {
            self.announce(Some(column));
        }
        let ParametersChanged {
            names,
            change,
            waiting,
            parameters,
            ..
        } = changed;
        let columns = &self.sending.columns;
        let of = columns.face().words("of", column);
        if change == Accepted::Waiting {
            tracing::info!("wait for the end of the response{of}: {}", names.join(", "));
        }
        if self.fleet.is_none() {
            self.waiting = waiting;
        }
        let before = self
            .changed_parameters
            .insert(column, Arc::clone(&parameters))
            .unwrap_or_else(|| Arc::clone(columns.initial_parameters(column)));
        self.send_parameter_event(Some(column), Some(&before), &parameters);
    }

    /// Publishes which parameters of a column, or of the node of a fleet, are new or have other values now, and logs the latter.
    fn send_parameter_event(
        &self,
        column: Option<u32>,
        before: Option<&Parameters>,
        now: &Parameters,
    ) {
        let columns = &self.sending.columns;
        let (node, stamp) = (self.fully_qualified.clone(), columns.now());
        let face = columns.face();
        let is_own = |name: &str| match column {
            Some(_) => parameter_services::is_of_a_column(face, name),
            None => is_of_the_fleet(name),
        };
        let Some(mut event) = parameter_services::event(node, stamp, before, now, is_own) else {
            return;
        };
        let (of, prefix) = column.map_or_else(Default::default, |column| {
            (face.words("of", column), face.parameter_prefix(column))
        });
        for it in &mut event.new_parameters {
            it.name.insert_str(0, &prefix);
        }
        for it in &mut event.changed_parameters {
            let name = &it.name;
            let old = before.and_then(|it| it.get(name));
            if let (Some(old), Some(new)) = (old, now.get(name)) {
                tracing::info!("parameter {name}{of} changed from {old} to {new}");
            }
            it.name.insert_str(0, &prefix);
        }
        #[cfg(feature = "foxglove")]
        if let Some(foxglove) = &self.sending.foxglove {
            let changed = event.changed_parameters.iter();
            let names: Vec<_> = changed.map(|it| it.name.clone()).collect();
            foxglove.changed(&names);
        }
        self.sending.send(
            &self.parameter_events,
            &qos::PARAMETER_EVENTS,
            cdr::encode_as::<ParameterEvent, _>(&event),
        );
    }

    /// Publishes diagnostics if they have changed, or always if `unconditionally`.
    fn diagnose(&mut self, unconditionally: bool) {
        let Sending {
            columns, counters, ..
        } = &self.sending;
        let (health, now) = (columns.health(), columns.now());
        self.loss_log.look(&health, counters, Instant::now());
        let (first, sensors, of_columns) = match &mut self.fleet {
            None => {
                let sensors = self.sensed.as_ref().and_then(|it| it.columns().first());
                let sensors = sensors.map(|it| sensors_status(it.status(now)));
                (
                    twin_status(&self.status, &self.waiting),
                    sensors,
                    Vec::new(),
                )
            }
            Some(fleet) => fleet.diagnose(columns, counters),
        };
        let hardware_id = match &self.fleet {
            None => &self.status.column_id,
            Some(_) => &self.node_name,
        };
        let header = Header {
            stamp: Time::from_nanos(now).unwrap_or_default(),
            frame_id: self.frame_id.clone(),
        };
        let array = diagnostics(
            header,
            &self.node_name,
            Observed {
                first,
                hardware_id,
                health: &health,
                topics: self.fleet.as_ref().map(FleetPublishing::topics_status),
                recording: self.sending.recording_health(&health).as_ref(),
                security: security_health(&self.protection, &self.peers),
                #[cfg(feature = "alarm")]
                alarms: self.sending.alarms.as_ref().map(|it| it.status()),
                foxglove: self.sending.foxglove_counts(),
                sensors,
                of_columns,
                is_responding: self.is_responding(),
                counters,
            },
        );
        let last = self.last_diagnostics.as_ref();
        if unconditionally || !last.is_some_and(|(_, last)| same_state(last, &array)) {
            self.sending
                .send(&self.diagnostics, &qos::DIAGNOSTICS, cdr::encode(&array));
            self.last_diagnostics = Some((Instant::now(), array));
        }
    }
}

/// Whether an output is published.
fn has_messages(output: &Output) -> bool {
    !matches!(
        output,
        Output::Journal(_)
            | Output::Rejected(_)
            | Output::ParametersChanged(_)
            | Output::Notice(_)
            | Output::Save(_)
    )
}

/// Whether a column responds to an impact.
fn is_responding(phase: TwinPhase) -> bool {
    matches!(
        phase,
        TwinPhase::Approach | TwinPhase::Contact | TwinPhase::Free
    )
}
