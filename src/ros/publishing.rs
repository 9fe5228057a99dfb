//! The publishing thread: publishes the outputs of the twin. The solver never waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ros2_client::{Publisher, parameters::raw};

use crate::endpoints::Endpoint;
use crate::live::OutputSource;
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin_msgs::TwinStatus;
use crate::messages::diagnostic_msgs::DiagnosticArray;
use crate::messages::rcl_interfaces::ParameterEvent;
use crate::outgoing::{Message, Outgoing, RecordingHealth, RecordingTap, Topic};
use crate::parameters::Parameters;
use crate::twin::{
    Accepted, Command, Journal, Notice, NoticeLevel, Output, ParametersChanged, Refused,
    RefusedInput,
};

use super::clock_watch::SeldomWarning;
use super::diagnostics::{NodeCounters, Observed, diagnostics, same_state};
use super::live_twin::{Health, LiveTwin};
use super::loss_log::LossLog;
use super::matches::Matches;
use super::node::{Node, NodeError};
use super::parameter_services;
use super::qos;
use super::raw::Raw;
use super::security::{Peers, Protection};

/// Maximum time between two diagnostics.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// States that are published later than this are logged at the level `debug` \[ns\].
const LATE: i64 = 2_000_000;

/// Maximum wait for a first reader of `/parameter_events` before the parameters are announced without one. Discovery between ROS 2
/// programs takes up to 3.5 s.
const MAX_WAIT_FOR_READER: Duration = Duration::from_secs(5);

/// Maximum time to publish queued outputs after the stop.
const FINAL_PUBLISHING_TIME: Duration = Duration::from_millis(300);

/// Publishes all outputs of the twin, and passes the same bytes to the recording.
pub(super) struct Publishing {
    publishers: Publishers,
    recording: Option<Arc<dyn RecordingTap>>,
    outgoing: Outgoing,
    twin: Arc<LiveTwin>,
    counters: Arc<NodeCounters>,
    protection: Arc<Protection>,
    peers: Arc<Peers>,
    node_name: String,
    fully_qualified: String,
    parameters: Arc<Parameters>,
    /// `new_parameters` has not been published: until then with the deadline for the first reader.
    unannounced: Option<Instant>,
    /// The parameters that wait for the end of the response.
    waiting: Vec<String>,
    status: TwinStatus,
    last_diagnostics: Option<(Instant, DiagnosticArray)>,
    clock_warning: SeldomWarning,
    loss_log: LossLog,
    /// Stamp of the last state.
    last_state: Option<i64>,
    /// The time to publish is over: the remaining outputs are only recorded.
    is_over: bool,
}

struct Publishers {
    /// The peers of `parameter_events`.
    matches: Arc<Matches>,
    /// In the order of [`Topic::ALL`].
    of_twin: Vec<Publisher<Raw>>,
    diagnostics: Publisher<Raw>,
    parameter_events: Publisher<Raw>,
}

impl Publishing {
    pub fn new(
        node: &mut Node,
        twin: Arc<LiveTwin>,
        counters: Arc<NodeCounters>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        let parameters = twin.parameters();
        let of_twin: Result<_, _> = Topic::ALL
            .iter()
            .map(|topic| node.publisher(topic.endpoint()))
            .collect();
        Ok(Self {
            publishers: Publishers {
                matches: node.matches(),
                of_twin: of_twin?,
                diagnostics: node.publisher(&qos::DIAGNOSTICS)?,
                parameter_events: node.publisher(&qos::PARAMETER_EVENTS)?,
            },
            recording,
            outgoing: Outgoing::new(&parameters),
            node_name: node.names().node().to_owned(),
            fully_qualified: node.names().fully_qualified(),
            status: TwinStatus {
                column_id: parameters.settings().column_id.clone(),
                ..TwinStatus::default()
            },
            parameters: Arc::clone(&parameters),
            unannounced: Some(Instant::now() + MAX_WAIT_FOR_READER),
            waiting: Vec::new(),
            twin,
            counters,
            protection: node.protection(),
            peers: node.security_peers(),
            last_diagnostics: None,
            clock_warning: SeldomWarning::default(),
            loss_log: LossLog::default(),
            last_state: None,
            is_over: false,
        })
    }

    /// Publishes until `stop` is set and no outputs are queued. A stop takes effect when the source of the outputs is woken. The
    /// twin must be stopped before, so that its queues bound the
    /// remaining outputs.
    pub fn run(mut self, mut outputs: impl OutputSource, stop: &AtomicBool) {
        let mut end = None;
        loop {
            self.announce_parameters(stop.load(Ordering::Relaxed));
            if stop.load(Ordering::Relaxed) {
                let end = *end.get_or_insert_with(|| Instant::now() + FINAL_PUBLISHING_TIME);
                if Instant::now() >= end && !self.is_over {
                    self.is_over = true;
                    tracing::warn!(
                        "some outputs could not be published before the end; they are recorded only"
                    );
                }
            }
            match outputs.receive(self.wait()) {
                Some(output) => self.publish(output),
                None if stop.load(Ordering::Relaxed) => return,
                None => {}
            }
            self.warn_of_a_missing_clock();
            let last = self.last_diagnostics.as_ref();
            if !self.is_over && last.is_none_or(|(at, _)| at.elapsed() >= DIAGNOSTICS_PERIOD) {
                self.diagnose(true);
            }
        }
    }

    fn warn_of_a_missing_clock(&mut self) {
        let Some(clock) = self.counters.clock.as_ref().filter(|it| it.count() == 0) else {
            return;
        };
        let now = Instant::now();
        if let Some(problem) = clock.problem(now)
            && self.clock_warning.is_due(now)
        {
            tracing::warn!("{problem}");
        }
    }

    fn wait(&self) -> Duration {
        if self.is_over {
            return Duration::ZERO;
        }
        let since = self.last_diagnostics.as_ref().map(|(at, _)| at.elapsed());
        since.map_or(Duration::ZERO, |since| {
            DIAGNOSTICS_PERIOD.saturating_sub(since)
        })
    }

    fn publish(&mut self, output: Output) {
        self.note(&output);
        let mut messages = Vec::new();
        self.outgoing
            .convert(&output, |message| messages.push(message));
        for message in messages {
            match message {
                Message::TwinStatus(status) => self.twin_status(status),
                other => self.send(&other),
            }
        }
        match output {
            Output::Journal(entry) => {
                if let Some(recording) = &self.recording {
                    recording.journal(None, &entry);
                }
            }
            Output::Refused(refused) => log_refusal(&refused),
            Output::Notice(notice) => log_notice(&notice),
            Output::ParametersChanged(changed) => self.parameters_changed(changed),
            Output::State(_)
            | Output::Forecast(_)
            | Output::Report(_)
            | Output::Ranged(_)
            | Output::Withdrawn(_)
            | Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::Calibrated(_)
            | Output::Status(_)
            | Output::Save(_) => {}
        }
    }

    /// Tells what leaves the twin, and where it leaves late.
    fn note(&mut self, output: &Output) {
        if !tracing::enabled!(tracing::Level::DEBUG) {
            return;
        }
        match output {
            Output::State(state) => {
                let last = self.last_state.replace(state.stamp);
                let gap = last.map_or(0, |last| state.stamp.saturating_sub(last));
                let late = self.twin.now().saturating_sub(state.stamp);
                if late > LATE {
                    tracing::debug!(
                        "state {:.6} s after the one before leaves {:.6} s late",
                        1e-9 * gap as f64,
                        1e-9 * late as f64
                    );
                }
            }
            Output::Forecast(forecast) => tracing::debug!(
                "forecast of impact {:?} leaves {:.6} s after its stamp, {:.6} s of computing, error estimate {:?}",
                forecast.event_id,
                1e-9 * self.twin.now().saturating_sub(forecast.stamp) as f64,
                forecast.compute_time,
                forecast.error_estimate,
            ),
            Output::Withdrawn(it) => tracing::debug!(
                "no result of impact {:?}: {}",
                it.impact.event_id,
                it.reason
            ),
            Output::Report(it) => tracing::debug!(
                "report of impact {:?}, {:.6} s of computing",
                it.event_id,
                it.compute_time
            ),
            Output::Ranged(it) => tracing::debug!(
                "range of the verdict on impact {:?}: {:?}",
                it.report.event_id,
                it.report.range
            ),
            Output::Status(status) => tracing::debug!("status: {:?}", status.phase),
            Output::Journal(Journal::Checkpoint(it)) => {
                tracing::debug!("checkpoint {} after response {}", it.number, it.response);
            }
            Output::Journal(Journal::Command(it)) => {
                let kind = match &it.command {
                    Command::Impact(impact) => format!("impact {:?}", impact.event_id),
                    Command::SetParameters { changes, .. } => {
                        format!("change of {} parameters", changes.len())
                    }
                    Command::RejectedChange { .. } => "change that cannot be read".to_owned(),
                    Command::Reset { .. } => "reset".to_owned(),
                    Command::ClockJumpedBack { .. } => "jump of the clock".to_owned(),
                    Command::CriticalVelocities { vehicles } => {
                        format!("critical velocities of {} vehicles", vehicles.len())
                    }
                    Command::VerdictRange(range) => format!("range of the verdict: {range}"),
                    Command::Estimate(it) => format!("estimate {} of {:?}", it.update, it.event_id),
                    Command::DecideEstimate(it) => match it.accept {
                        true => format!("confirmation of {:?}", it.event_id),
                        false => format!("rejection of {:?}", it.event_id),
                    },
                    Command::Calibrate(it) => format!("calibration by a {}", it.quantity),
                };
                let outcome = it.refusal.as_ref().map_or("accepted", |it| it.code.name());
                let at = it.position;
                tracing::debug!("command {}: {kind} at {at:?}: {outcome}", it.number);
            }
            Output::Estimate(it) => tracing::debug!(
                "estimate {} of {:?}: {} kg, {} m/s, {:?}",
                it.record.update,
                it.record.event_id,
                it.record.estimate.mass.mean,
                it.record.estimate.velocity.mean,
                it.decision
            ),
            Output::Journal(Journal::Status(_))
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::Calibrated(_)
            | Output::Refused(_)
            | Output::ParametersChanged(_)
            | Output::Notice(_)
            | Output::Save(_) => {}
        }
    }

    /// Adds the state of threads and queues, which the twin does not know.
    fn twin_status(&mut self, status: TwinStatus) {
        let health = self.twin.health();
        let lost = self.recording_health(&health).map(|it| it.lost);
        self.status = TwinStatus {
            overruns: health.overruns,
            worst_lateness: health.worst_lateness,
            dropped_inputs: health.dropped_inputs + self.counters.rejected_senders(),
            dropped_states: health.dropped_states,
            dropped_recording: lost.unwrap_or(0),
            dropped_viewer: health.dropped_viewer,
            ..status
        };
        self.send(&Message::TwinStatus(self.status.clone()));
        self.diagnose(false);
    }

    /// Outputs that the queue to this thread dropped are missing in the recording too, which receives its messages here.
    fn recording_health(&self, health: &Health) -> Option<RecordingHealth> {
        let mut recording = self.recording.as_ref()?.health();
        recording.lost += health.dropped_recording;
        Some(recording)
    }

    /// Publishes all parameters as new, once: as soon as there is a reader, which is only then matched, or after a while
    /// without one, for the recording. `at_once` does not wait.
    fn announce_parameters(&mut self, at_once: bool) {
        let Some(deadline) = self.unannounced else {
            return;
        };
        let Publishers {
            matches,
            parameter_events,
            ..
        } = &self.publishers;
        if !at_once && Instant::now() < deadline && matches.count(parameter_events.guid()) == 0 {
            return;
        }
        self.unannounced = None;
        let stamp = self.twin.now();
        let node = self.fully_qualified.clone();
        if let Some(event) = parameter_services::event(node, stamp, None, &self.parameters) {
            self.send_parameter_event(event);
        }
    }

    fn parameters_changed(&mut self, changed: ParametersChanged) {
        self.announce_parameters(true);
        let ParametersChanged {
            names,
            change,
            waiting,
            parameters,
            ..
        } = changed;
        if change == Accepted::Waiting {
            tracing::info!("wait for the end of the response: {}", names.join(", "));
        }
        self.waiting = waiting;
        let stamp = self.twin.now();
        let node = self.fully_qualified.clone();
        let before = Some(&*self.parameters);
        if let Some(event) = parameter_services::event(node, stamp, before, &parameters) {
            for it in &event.changed_parameters {
                let name = &it.name;
                if let (Some(old), Some(new)) = (self.parameters.get(name), parameters.get(name)) {
                    tracing::info!("parameter {name} changed from {old} to {new}");
                }
            }
            self.send_parameter_event(event);
        }
        self.parameters = parameters;
    }

    /// Publishes diagnostics if they have changed, or always if `unconditionally`.
    fn diagnose(&mut self, unconditionally: bool) {
        let health = self.twin.health();
        self.loss_log.look(&health, &self.counters, Instant::now());
        let array = diagnostics(
            self.outgoing.header(self.twin.now()),
            &self.node_name,
            Observed {
                twin: &self.status,
                waiting: &self.waiting,
                health: &health,
                recording: self.recording_health(&health).as_ref(),
                security: self.protection.health(&self.peers),
                counters: &self.counters,
            },
        );
        let last = self.last_diagnostics.as_ref();
        if unconditionally || !last.is_some_and(|(_, last)| same_state(last, &array)) {
            self.send_bytes(
                &self.publishers.diagnostics,
                &qos::DIAGNOSTICS,
                cdr::encode(&array),
            );
            self.last_diagnostics = Some((Instant::now(), array));
        }
    }

    fn send(&self, message: &Message) {
        let topic = message.topic();
        let publisher = &self.publishers.of_twin[topic.index()];
        self.send_bytes(publisher, topic.endpoint(), message.encode());
    }

    /// Publishes and records one message without waiting. If a reader is so slow that the history is full, the message is
    /// lost for it, and counted.
    fn send_bytes(
        &self,
        publisher: &Publisher<Raw>,
        endpoint: &Endpoint,
        bytes: Result<Vec<u8>, CdrError>,
    ) {
        let bytes = bytes.map(Arc::<[u8]>::from);
        let Some((raw, bytes)) = bytes
            .ok()
            .and_then(|bytes| Some((Raw::new(Arc::clone(&bytes)).ok()?, bytes)))
        else {
            return NodeCounters::count(&self.counters.unpublished);
        };
        self.counters.lost_peers.count_published();
        if self.is_over || publisher.publish(raw).is_err() {
            NodeCounters::count(&self.counters.unpublished);
        }
        if let Some(recording) = &self.recording {
            recording.sent(endpoint, &bytes);
        }
    }

    fn send_parameter_event(&self, event: raw::ParameterEvent) {
        self.send_bytes(
            &self.publishers.parameter_events,
            &qos::PARAMETER_EVENTS,
            cdr::encode_as::<ParameterEvent, _>(&event),
        );
    }
}

fn log_notice(notice: &Notice) {
    let text = &notice.text;
    match notice.level {
        NoticeLevel::Info => tracing::info!("{text}"),
        NoticeLevel::Warning => tracing::warn!("{text}"),
        NoticeLevel::Error => tracing::error!("{text}"),
    }
}

fn log_refusal(refused: &Refused) {
    let Refused {
        refusal,
        event_id,
        source,
        ..
    } = refused;
    match refused.what {
        RefusedInput::Impact => {
            tracing::warn!("impact event {event_id:?} was rejected: {refusal}");
        }
        RefusedInput::Parameters => {
            tracing::warn!("a change of parameters by {source} was rejected: {refusal}");
        }
        RefusedInput::Estimate => {
            tracing::warn!("a decision about an estimate by {source} was rejected: {refusal}");
        }
        RefusedInput::Calibration => {
            tracing::warn!("a calibration by {source} was rejected: {refusal}");
        }
    }
}
