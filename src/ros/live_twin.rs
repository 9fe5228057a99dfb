//! The live twin behind the node's [`Twin`]: translates, and decides nothing.

use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use crate::column::ModelError;
use crate::live::{
    AskError, Clock, Live, LiveHandle, LiveOptions, OutputQueue, Receiver, SimClock, SystemClock,
    WhenFull, monotonic_nanos,
};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{ImpactEvent, ImpactReport, PredictImpactRequest, TwinStatus};
use crate::parameters::Parameters;
use crate::twin::state_file::{self, Loaded, StateFileError};
use crate::twin::{self, RefusedInput, TwinPhase};

use super::bridge::{
    Health, Output, Outputs, ParameterChange, QueueHealth, ReportOutput, Severity, Twin,
};
use super::run::StartedTwin;

/// Name of the queue of [`OutputQueue::ros`].
const READER: &str = "ros";

/// Why there is no live twin.
#[derive(Debug, thiserror::Error)]
pub enum LiveTwinError {
    /// The state file is there and cannot be read.
    #[error(transparent)]
    StateFile(#[from] StateFileError),
    /// The column is impossible.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// No thread.
    #[error("no thread for the solver: {0}")]
    Thread(#[from] std::io::Error),
    /// Nobody reads.
    #[error("the options have no queue of outputs called {READER}; add OutputQueue::ros()")]
    NoQueue,
}

struct LiveTwin {
    /// Until the twin is stopped.
    handle: RwLock<Option<LiveHandle>>,
    clock: Arc<dyn Clock>,
    /// Under `use_sim_time` the same clock, which can be set.
    simulated: Option<Arc<SimClock>>,
    parameters: Mutex<Arc<Parameters>>,
}

/// Starts the twin of these parameters with the damage that its state file holds. `options.state_file` is taken from the
/// parameters.
///
/// # Errors
/// When the column is impossible, or its state file or a thread cannot be had.
pub fn start_live_twin(
    parameters: Parameters,
    options: LiveOptions,
) -> Result<StartedTwin, LiveTwinError> {
    let simulated = parameters.settings().use_sim_time;
    let simulated = simulated.then(|| Arc::new(SimClock::new(0)));
    let path = state_file::path(&parameters);
    let saved = match &path {
        None => Loaded::Absent,
        Some(path) => state_file::load(path, &parameters)?,
    };
    let saved = match saved {
        Loaded::Absent => None,
        Loaded::Damage(saved) => Some(saved),
        Loaded::Rejected { reason, kept_as } => {
            tracing::warn!(
                "the state file cannot be used, the column starts virgin: {reason}; it is kept as {}",
                kept_as.display()
            );
            None
        }
    };
    let mut options = LiveOptions {
        state_file: path,
        ..options
    };
    super::pictures::ask_for_outputs(&parameters, &mut options);
    let held = Arc::new(parameters.clone());
    let new = |now| twin::Twin::new(parameters, saved.as_deref(), Box::new(monotonic_nanos), now);
    let (clock, handle): (Arc<dyn Clock>, _) = match &simulated {
        Some(clock) => {
            let twin = new(clock.now())?;
            (
                Arc::clone(clock) as _,
                Live::start(twin, Arc::clone(clock), options)?,
            )
        }
        None => {
            let clock = Arc::new(SystemClock::new());
            let twin = new(clock.now())?;
            (Arc::clone(&clock) as _, Live::start(twin, clock, options)?)
        }
    };
    for warning in handle.statistics().real_time.warnings() {
        tracing::warn!("{warning}");
    }
    let outputs = handle.outputs(READER).ok_or(LiveTwinError::NoQueue)?;
    let pictures = super::pictures::start(&held, &handle, clock.now())?;
    let twin = Arc::new(LiveTwin {
        handle: RwLock::new(Some(handle)),
        clock,
        simulated,
        parameters: Mutex::new(held),
    });
    let ending = Arc::clone(&twin);
    Ok(StartedTwin {
        twin,
        outputs: Box::new(LiveOutputs(outputs)),
        stop: Box::new(move || {
            ending.stop();
            pictures.stop();
        }),
    })
}

impl LiveTwin {
    /// Asks the handle; after the stop there is nobody to ask.
    fn ask<T>(&self, question: impl FnOnce(&LiveHandle) -> Result<T, String>) -> Result<T, String> {
        let handle = self.handle.read().unwrap_or_else(PoisonError::into_inner);
        handle
            .as_ref()
            .map_or_else(|| Err("the twin is stopping".to_owned()), question)
    }

    fn stop(&self) {
        let handle = self
            .handle
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(Err(panicked)) = handle.map(LiveHandle::stop) {
            tracing::error!("{panicked}");
        }
    }
}

impl Twin for LiveTwin {
    fn submit_impact(&self, event: ImpactEvent) -> Result<(), String> {
        let event = twin::ImpactEvent {
            stamp: nanos(event.header.stamp),
            event_id: event.event_id,
            column_id: event.column_id,
            impact_mass: event.mass,
            velocity: event.velocity,
            gap: given(event.gap),
            restitution: given(event.restitution),
            height: given(event.height),
        };
        self.ask(|handle| {
            let submitted = handle.submit(twin::Input::Impact(event));
            submitted.map_err(|full| full.to_string())
        })
    }

    fn set_parameters(&self, change: ParameterChange) -> Result<(), String> {
        let mut held = self
            .parameters
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let own = &held.settings().column_id;
        if let Some(other) = change.column_id.filter(|id| id != own) {
            return Err(format!(
                "they are for the column {other:?}, and this is {own:?}"
            ));
        }
        let values = change.values.clone();
        self.ask(|handle| {
            let answer = handle.change_parameters(values, change.source);
            answer.map(|_| ()).map_err(words)
        })?;
        // The twin has found them valid; those that wait for the end of a response count as set.
        if let Ok(changed) = held.with_changes(change.values) {
            *held = Arc::new(changed);
        }
        Ok(())
    }

    fn parameters(&self) -> Arc<Parameters> {
        Arc::clone(
            &self
                .parameters
                .lock()
                .unwrap_or_else(PoisonError::into_inner),
        )
    }

    fn reset(&self) -> Result<String, String> {
        self.ask(|handle| handle.reset("service ~/reset").map_err(words))
            .map(|()| "the column is virgin".to_owned())
    }

    fn predict(&self, request: &PredictImpactRequest) -> Result<ImpactReport, String> {
        let blow = twin::Blow {
            mass: request.mass,
            velocity: request.velocity,
            gap: given(request.gap),
            restitution: given(request.restitution),
            height: given(request.height),
        };
        let prediction =
            self.ask(|handle| handle.predict(&request.column_id, &blow).map_err(words))?;
        Ok(ImpactReport {
            compute_time: prediction.compute_time,
            ..ImpactReport::from(&prediction.report)
        })
    }

    fn health(&self) -> Health {
        self.ask(|handle| Ok(health(handle))).unwrap_or_default()
    }

    fn now(&self) -> i64 {
        self.clock.now()
    }

    fn set_clock(&self, now: i64) {
        if let Some(clock) = &self.simulated {
            clock.set(now);
        }
    }
}

fn health(handle: &LiveHandle) -> Health {
    let statistics = handle.statistics();
    let queues: Vec<_> = statistics.queues.into_iter().map(queue_health).collect();
    let dropped = |name: &str| {
        let queue = queues.iter().find(|queue| queue.name == name);
        queue.map_or(0, |queue| queue.dropped)
    };
    let of_ros = OutputQueue::ros().name;
    Health {
        overruns: statistics.skipped_periods,
        worst_lateness: 1e-9 * statistics.worst_lateness as f64,
        dropped_inputs: dropped("inputs"),
        dropped_states: dropped(&format!("states to {of_ros}")),
        dropped_viewer: dropped(&format!("states to {}", super::pictures::QUEUE)),
        statistics: [
            ("turns", statistics.turns),
            ("late turns", statistics.overruns),
            ("steps", statistics.steps),
            ("Newton corrections", statistics.newton_corrections),
            ("state files not written", statistics.state_file_failures),
        ]
        .map(|(name, count)| (name.to_owned(), count.to_string()))
        .to_vec(),
        hints: statistics.real_time.warnings().collect(),
        queues,
        ..Health::default()
    }
}

fn queue_health(queue: crate::live::QueueStats) -> QueueHealth {
    QueueHealth {
        name: queue.name,
        capacity: queue.capacity,
        len: queue.len,
        policy: match queue.when_full {
            WhenFull::Refuse => "refused and said so",
            WhenFull::DropOldest => "oldest dropped",
            WhenFull::DropNewest => "newest dropped",
        },
        pushed: queue.pushed,
        dropped: queue.dropped,
    }
}

/// What leaves the live twin, as the node knows it.
struct LiveOutputs(Receiver);

impl Outputs for LiveOutputs {
    fn receive(&mut self, timeout: Duration) -> Result<Output, RecvTimeoutError> {
        let deadline = Instant::now() + timeout;
        loop {
            while let Some(output) = self.0.try_next() {
                if let Some(output) = translated(output) {
                    return Ok(output);
                }
            }
            let rest = deadline.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Err(RecvTimeoutError::Timeout);
            }
            self.0.wait(rest);
        }
    }
}

/// `None` for what is not the node's business.
fn translated(output: twin::Output) -> Option<Output> {
    Some(match output {
        twin::Output::State(state) => Output::State {
            stamp: state.stamp,
            event_id: state.event_id,
            sample: state.sample,
            phase: phase_code(state.phase),
        },
        twin::Output::Forecast(report) => Output::Forecast(report_output(report)),
        twin::Output::Report(report) => Output::Report(report_output(report)),
        twin::Output::Status(status) => Output::Status {
            stamp: status.stamp,
            status: Box::new(status_message(&status)),
        },
        twin::Output::Refused(refused) => Output::Refused {
            what: match refused.what {
                RefusedInput::Impact => format!("impact event {:?}", refused.event_id),
                RefusedInput::Parameters => format!("change of parameters by {}", refused.source),
            },
            reason: refused.reason.to_string(),
        },
        twin::Output::ParametersChanged(changed) => Output::ParametersChanged(changed.parameters),
        twin::Output::Notice(notice) => Output::Notice {
            severity: match notice.severity {
                twin::Severity::Info => Severity::Info,
                twin::Severity::Warning => Severity::Warning,
                twin::Severity::Error => Severity::Error,
            },
            text: notice.text,
        },
        twin::Output::Save(_) => return None,
    })
}

fn report_output(report: twin::ReportOutput) -> ReportOutput {
    ReportOutput {
        stamp: report.stamp,
        event_id: report.event_id,
        report: report.report,
        compute_time: report.compute_time,
    }
}

/// Header, column and the threads' part are the node's to fill in.
fn status_message(status: &twin::Status) -> TwinStatus {
    TwinStatus {
        phase: phase_code(status.phase),
        event_id: status.event_id.to_string(),
        events_accepted: status.counts.events_accepted,
        events_refused: status.counts.events_refused,
        parameters_accepted: status.counts.parameters_accepted,
        parameters_refused: status.counts.parameters_refused,
        last_refusal_reason: status.last_refusal_reason.to_string(),
        last_refusal_event_id: status.last_refusal_event_id.to_string(),
        fault: status.fault.to_string(),
        impacts_since_reset: status.impacts_since_reset,
        residual_v1: status.residual_v1,
        residual_u2: status.residual_u2,
        plastic_work_since_reset: status.plastic_work_since_reset,
        plastic_rotation: status.plastic_rotation,
        plastic_elongation: status.plastic_elongation,
        ..TwinStatus::default()
    }
}

fn phase_code(phase: TwinPhase) -> u8 {
    match phase {
        TwinPhase::Idle => TwinStatus::IDLE,
        TwinPhase::Approach => TwinStatus::APPROACH,
        TwinPhase::Contact => TwinStatus::CONTACT,
        TwinPhase::Free => TwinStatus::FREE,
        TwinPhase::Rest => TwinStatus::REST,
        TwinPhase::Collapsed => TwinStatus::COLLAPSED,
        TwinPhase::Faulted => TwinStatus::FAULTED,
    }
}

/// NaN leaves it to the parameter. An infinite number is given, and wrong.
fn given(number: f64) -> Option<f64> {
    (!number.is_nan()).then_some(number)
}

/// Both parts count, whatever they are, so that the twin can say how far off a wrong stamp is.
fn nanos(stamp: Time) -> i64 {
    i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec)
}

fn words(error: AskError) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_left_open_and_infinity_is_not() {
        assert_eq!(given(f64::NAN), None);
        assert_eq!(given(f64::INFINITY), Some(f64::INFINITY));
    }

    #[test]
    fn an_impossible_stamp_is_still_an_instant() {
        let stamp = Time {
            sec: 1,
            nanosec: u32::MAX,
        };
        assert_eq!(nanos(stamp), 1_000_000_000 + i64::from(u32::MAX));
    }
}
