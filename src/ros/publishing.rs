//! The publishing thread: takes what leaves the twin and sends it. The solver never waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use ros2_client::{Publisher, parameters::raw};
use serde::Serialize;

use crate::column::Sample;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{ColumnState, HingeForces, ImpactReport, TwinStatus};
use crate::messages::diagnostic_msgs::DiagnosticArray;
use crate::messages::sensor_msgs::JointState;
use crate::messages::std_msgs::Header;
use crate::messages::visualization_msgs::MarkerArray;
use crate::parameters::Parameters;
use crate::shape::Lengths;

use super::bridge::{Output, Outputs, ReportOutput, Severity, Twin};
use super::diagnostics::{NodeCounters, diagnostics, same_state};
use super::joint_states::JointStates;
use super::markers::markers;
use super::node::{Node, NodeError};
use super::parameter_services;
use super::qos;

/// Longest time between two diagnostics.
const DIAGNOSTICS_PERIOD: Duration = Duration::from_secs(1);

/// Longest wait for an output, after which the thread looks whether it is to stop.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Longest time that what is waiting at the end may take.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// Shortest time between two joint states, in the time of the samples: 100 Hz show all that a plot can.
const JOINT_STATES_PERIOD: i64 = 10_000_000;

/// Shortest time between two marker arrays, in the time of the samples: 25 Hz are a film.
const MARKERS_PERIOD: i64 = 40_000_000;

/// Sends everything that leaves the twin.
pub(super) struct Publishing {
    publishers: Publishers,
    twin: Arc<dyn Twin>,
    counters: Arc<NodeCounters>,
    node_name: String,
    fully_qualified: String,
    column_id: String,
    frame_id: String,
    parameters: Arc<Parameters>,
    status: TwinStatus,
    last_diagnostics: Option<(Instant, DiagnosticArray)>,
    joints: JointStates,
    joint_states: Thinning,
    markers: Thinning,
}

struct Publishers {
    column_state: Publisher<ColumnState>,
    hinge_forces: Publisher<HingeForces>,
    impact_forecast: Publisher<ImpactReport>,
    impact_report: Publisher<ImpactReport>,
    twin_status: Publisher<TwinStatus>,
    joint_states: Publisher<JointState>,
    markers: Publisher<MarkerArray>,
    diagnostics: Publisher<DiagnosticArray>,
    parameter_events: Publisher<raw::ParameterEvent>,
}

impl Publishing {
    pub fn new(
        node: &mut Node,
        twin: Arc<dyn Twin>,
        counters: Arc<NodeCounters>,
    ) -> Result<Self, NodeError> {
        let parameters = twin.parameters();
        let settings = parameters.settings();
        Ok(Self {
            publishers: Publishers {
                column_state: node.publisher(&qos::COLUMN_STATE)?,
                hinge_forces: node.publisher(&qos::HINGE_FORCES)?,
                impact_forecast: node.publisher(&qos::IMPACT_FORECAST)?,
                impact_report: node.publisher(&qos::IMPACT_REPORT)?,
                twin_status: node.publisher(&qos::TWIN_STATUS)?,
                joint_states: node.publisher(&qos::JOINT_STATES)?,
                markers: node.publisher(&qos::MARKERS)?,
                diagnostics: node.publisher(&qos::DIAGNOSTICS)?,
                parameter_events: node.publisher(&qos::PARAMETER_EVENTS)?,
            },
            node_name: node.names().node().to_owned(),
            fully_qualified: node.names().fully_qualified(),
            column_id: settings.column_id.clone(),
            frame_id: settings.frame_id.clone(),
            status: TwinStatus {
                column_id: settings.column_id.clone(),
                ..TwinStatus::default()
            },
            parameters: Arc::clone(&parameters),
            twin,
            counters,
            last_diagnostics: None,
            joints: JointStates::default(),
            joint_states: Thinning::new(JOINT_STATES_PERIOD),
            markers: Thinning::new(MARKERS_PERIOD),
        })
    }

    /// Sends until the twin has ended, or `stop` is set and nothing is waiting any more.
    pub fn run(mut self, mut outputs: impl Outputs, stop: &AtomicBool) {
        self.announce_parameters();
        let mut end = None;
        loop {
            if stop.load(Ordering::Relaxed) {
                let end = *end.get_or_insert_with(|| Instant::now() + LAST_WORDS);
                if Instant::now() >= end {
                    return;
                }
            }
            match outputs.receive(self.wait()) {
                Ok(output) => self.publish(output),
                Err(RecvTimeoutError::Timeout) if stop.load(Ordering::Relaxed) => return,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let last = self.last_diagnostics.as_ref();
            if last.is_none_or(|(at, _)| at.elapsed() >= DIAGNOSTICS_PERIOD) {
                self.diagnose(true);
            }
        }
    }

    fn wait(&self) -> Duration {
        let since = self.last_diagnostics.as_ref().map(|(at, _)| at.elapsed());
        since.map_or(Duration::ZERO, |since| {
            DIAGNOSTICS_PERIOD.saturating_sub(since).min(LONGEST_WAIT)
        })
    }

    fn publish(&mut self, output: Output) {
        match output {
            Output::State {
                stamp,
                event_id,
                sample,
                phase,
            } => self.state(stamp, &event_id, &sample, phase),
            Output::Forecast(forecast) => {
                let message = self.report(forecast, ImpactReport::FORECAST);
                self.send(|it| &it.impact_forecast, message);
            }
            Output::Report(report) => {
                let message = self.report(report, ImpactReport::RESULT);
                self.send(|it| &it.impact_report, message);
            }
            Output::Status { stamp, status } => self.twin_status(stamp, *status),
            Output::Refused { what, reason } => tracing::warn!("{what} is refused: {reason}"),
            Output::Notice { severity, text } => match severity {
                Severity::Info => tracing::info!("{text}"),
                Severity::Warning => tracing::warn!("{text}"),
                Severity::Error => tracing::error!("{text}"),
            },
            Output::ParametersChanged(parameters) => self.parameters_changed(parameters),
        }
    }

    fn state(&mut self, stamp: i64, event_id: &str, sample: &Sample, phase: u8) {
        let header = self.header(stamp);
        let mut state = ColumnState::from(sample);
        state.phase = phase;
        state.header.clone_from(&header);
        state.column_id.clone_from(&self.column_id);
        state.event_id = event_id.to_owned();
        self.send(|it| &it.column_state, state);
        let mut forces = HingeForces::from(sample);
        forces.header.clone_from(&header);
        forces.column_id.clone_from(&self.column_id);
        forces.event_id = event_id.to_owned();
        self.send(|it| &it.hinge_forces, forces);
        let running = (ColumnState::APPROACH..=ColumnState::FREE).contains(&phase);
        if self.joint_states.passes(stamp, running) {
            let message = self.joints.convert(header.clone(), sample);
            self.send(|it| &it.joint_states, message);
        }
        if self.markers.passes(stamp, running) {
            let lengths = Lengths::from(&*self.parameters);
            let message = markers(&header, lengths, sample);
            self.send(|it| &it.markers, message);
        }
    }

    fn report(&self, output: ReportOutput, kind: u8) -> ImpactReport {
        let mut message = ImpactReport::from(&output.report);
        message.header = self.header(output.stamp);
        message.column_id.clone_from(&self.column_id);
        message.event_id = output.event_id.to_string();
        message.kind = kind;
        message.compute_time = output.compute_time;
        message
    }

    /// Adds what the twin does not know: who it is, and how its threads and queues are.
    fn twin_status(&mut self, stamp: i64, status: TwinStatus) {
        let health = self.twin.health();
        self.status = TwinStatus {
            header: self.header(stamp),
            column_id: self.column_id.clone(),
            overruns: health.overruns,
            worst_lateness: health.worst_lateness,
            dropped_inputs: health.dropped_inputs,
            dropped_states: health.dropped_states,
            dropped_recording: health.dropped_recording,
            dropped_viewer: health.dropped_viewer,
            ..status
        };
        self.send(|it| &it.twin_status, self.status.clone());
        self.diagnose(false);
    }

    fn announce_parameters(&self) {
        let stamp = self.twin.now();
        let node = self.fully_qualified.clone();
        if let Some(event) = parameter_services::event(node, stamp, None, &self.parameters) {
            self.send(|it| &it.parameter_events, event);
        }
    }

    fn parameters_changed(&mut self, parameters: Arc<Parameters>) {
        let stamp = self.twin.now();
        let node = self.fully_qualified.clone();
        let before = Some(&*self.parameters);
        if let Some(event) = parameter_services::event(node, stamp, before, &parameters) {
            for it in &event.changed_parameters {
                tracing::info!("parameter {} has a new value", it.name);
            }
            self.send(|it| &it.parameter_events, event);
        }
        self.parameters = parameters;
    }

    /// Publishes diagnostics when something has changed in them, or in any case.
    fn diagnose(&mut self, in_any_case: bool) {
        let header = self.header(self.twin.now());
        let health = self.twin.health();
        let array = diagnostics(
            header,
            &self.node_name,
            &self.status,
            &health,
            &self.counters,
        );
        let last = self.last_diagnostics.as_ref();
        if in_any_case || !last.is_some_and(|(_, last)| same_state(last, &array)) {
            self.send(|it| &it.diagnostics, array.clone());
            self.last_diagnostics = Some((Instant::now(), array));
        }
    }

    fn header(&self, stamp: i64) -> Header {
        Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: self.frame_id.clone(),
        }
    }

    /// Sends one message. Does not wait: where a reader has been too slow for the writer's whole window, it is lost and
    /// counted.
    fn send<M: Serialize>(&self, publisher: impl FnOnce(&Publishers) -> &Publisher<M>, message: M) {
        if publisher(&self.publishers).publish(message).is_err() {
            NodeCounters::count(&self.counters.unpublished);
        }
    }
}

/// Lets through what is far enough apart in the time of the samples.
#[derive(Debug, Clone)]
struct Thinning {
    period: i64,
    last: Option<i64>,
}

impl Thinning {
    fn new(period: i64) -> Self {
        Self { period, last: None }
    }

    /// Whether this one is let through. While nothing is `running` every one is: it is the last that is seen for long.
    fn passes(&mut self, stamp: i64, running: bool) -> bool {
        let passes = !running
            || self
                .last
                .is_none_or(|last| stamp < last || stamp - last >= self.period);
        if passes {
            self.last = Some(stamp);
        }
        passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_first_the_spaced_and_the_last() {
        let mut thinning = Thinning::new(10);
        let passed: Vec<i64> = (0..35)
            .filter(|stamp| thinning.passes(*stamp, true))
            .collect();
        assert_eq!(passed, [0, 10, 20, 30]);
        assert!(thinning.passes(35, false));
        // A new impact that was late, or a bag that was wound back.
        assert!(thinning.passes(3, true));
    }
}
