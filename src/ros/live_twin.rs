//! The live twin behind the node's [`Twin`]: translates, and decides nothing.

use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

use crate::column::ModelError;
use crate::live::{
    AskError, Clock, Live, LiveHandle, LiveOptions, LiveStatistics, OutputQueue, RealTime,
    Receiver, SimClock, SystemClock, monotonic_nanos,
};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{ImpactEvent, ImpactReport, PredictImpactRequest};
use crate::parameters::Parameters;
use crate::twin::state_file::{self, Loaded, Reserved, StateFileError};
use crate::twin::{self, Output};

use super::bridge::{Health, NotChanged, Outputs, ParameterChange, QueueHealth, Twin};
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
    living: RwLock<Option<Living>>,
    /// As it was at the stop.
    last_health: Mutex<Health>,
    clock: Arc<dyn Clock>,
    /// Under `use_sim_time` the same clock, which can be set.
    simulated: Option<Arc<SimClock>>,
    /// Those of the start, among them the ones that are read-only.
    first_parameters: Arc<Parameters>,
}

/// What ends with the stop, in this order.
struct Living {
    handle: LiveHandle,
    /// No other program's until the last damage is written.
    _state_file: Option<Reserved>,
}

/// Starts the twin of these parameters with the damage that its state file holds. `options.state_file` and
/// `options.real_time` are taken from the parameters.
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
    let reserved = path.as_deref().map(state_file::reserve).transpose()?;
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
        real_time: RealTime::of(&parameters),
        ..options
    };
    super::pictures::ask_for_outputs(&parameters, &mut options);
    let first_parameters = Arc::new(parameters.clone());
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
    let pictures = super::pictures::start(&first_parameters, &handle, clock.now())?;
    let twin = Arc::new(LiveTwin {
        living: RwLock::new(Some(Living {
            handle,
            _state_file: reserved,
        })),
        last_health: Mutex::default(),
        clock,
        simulated,
        first_parameters,
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
    /// Asks the handle; `None` after the stop, when there is nobody to ask.
    fn ask<T>(&self, question: impl FnOnce(&LiveHandle) -> T) -> Option<T> {
        let living = self.living.read().unwrap_or_else(PoisonError::into_inner);
        living.as_ref().map(|living| question(&living.handle))
    }

    fn stop(&self) {
        let last_health = || {
            self.last_health
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        let mut place = self.living.write().unwrap_or_else(PoisonError::into_inner);
        let Some(Living {
            handle,
            _state_file,
        }) = place.take()
        else {
            return;
        };
        // Before anybody can ask: what is sent last says it too.
        *last_health() = health(&handle);
        drop(place);
        match handle.stop() {
            // With what the end itself has cost.
            Ok(statistics) => *last_health() = health_of(statistics, false),
            Err(panicked) => {
                tracing::error!("{panicked}");
                last_health().solver_ended = true;
            }
        }
    }

    /// Whether the twin takes note of a change that it is not asked for.
    fn note_refusal(&self, source: &'static str, reason: &str) -> bool {
        let noted = self.ask(|handle| handle.refuse_change(reason, source));
        if let Some(Err(full)) = noted {
            tracing::warn!("a change of parameters by {source} is refused: {reason}; {full}");
        }
        noted == Some(Ok(()))
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
        self.ask(|handle| handle.submit(twin::Input::Impact(event)).map_err(words))
            .unwrap_or_else(stopping)
    }

    fn set_parameters(&self, change: ParameterChange) -> Result<(), NotChanged> {
        let own = &self.first_parameters.settings().column_id;
        if let Some(other) = change.column_id.filter(|id| id != own) {
            let reason = format!("they are for the column {other:?}, and this is {own:?}");
            let is_in_journal = self.note_refusal(change.source, &reason);
            return Err(NotChanged {
                reason,
                is_in_journal,
            });
        }
        let source = change.source;
        let answer = self.ask(|handle| {
            let answer = handle.change_parameters(change.values, source);
            answer.map_err(|error| (error, handle.is_running()))
        });
        let (reason, is_in_journal) = match answer {
            Some(Ok(_)) => return Ok(()),
            // The twin says it.
            Some(Err((AskError::Refused(reason), _))) => (reason.to_string(), true),
            Some(Err((error @ AskError::QueueFull(_), _))) => {
                tracing::warn!("a change of parameters by {source} is refused: {error}");
                (error.to_string(), false)
            }
            Some(Err((error @ AskError::NoAnswer, is_running))) => {
                tracing::warn!("a change of parameters by {source} has no answer: {error}");
                (error.to_string(), is_running)
            }
            None => (STOPPING.to_owned(), false),
        };
        Err(NotChanged {
            reason,
            is_in_journal,
        })
    }

    fn refuse_parameters(&self, source: &'static str, reason: &str) {
        self.note_refusal(source, reason);
    }

    fn parameters(&self) -> Arc<Parameters> {
        self.ask(LiveHandle::parameters)
            .unwrap_or_else(|| Arc::clone(&self.first_parameters))
    }

    fn reset(&self) -> Result<String, String> {
        self.ask(|handle| handle.reset("service ~/reset").map_err(words))
            .unwrap_or_else(stopping)
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
        let prediction = self
            .ask(|handle| handle.predict(&request.column_id, &blow).map_err(words))
            .unwrap_or_else(stopping)?;
        Ok(ImpactReport {
            compute_time: prediction.compute_time,
            ..ImpactReport::from(&prediction.report)
        })
    }

    fn health(&self) -> Health {
        self.ask(health).unwrap_or_else(|| {
            let last = self.last_health.lock();
            last.unwrap_or_else(PoisonError::into_inner).clone()
        })
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
    health_of(handle.statistics(), !handle.is_running())
}

fn health_of(statistics: LiveStatistics, solver_ended: bool) -> Health {
    let queues: Vec<_> = statistics
        .queues
        .into_iter()
        .map(QueueHealth::from)
        .collect();
    let dropped = |name: &str| {
        let queue = queues.iter().find(|queue| queue.name == name);
        queue.map_or(0, |queue| queue.dropped)
    };
    let of_ros = OutputQueue::ros().name;
    let to_ros = format!(" to {of_ros}");
    let dropped_to_ros = queues.iter().filter(|queue| queue.name.ends_with(&to_ros));
    Health {
        overruns: statistics.skipped_periods,
        worst_lateness: 1e-9 * statistics.worst_lateness as f64,
        dropped_inputs: dropped("inputs"),
        dropped_states: dropped(&format!("states to {of_ros}")),
        dropped_recording: dropped_to_ros.map(|queue| queue.dropped).sum(),
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
        solver_ended,
        queues,
    }
}

/// What leaves the live twin.
struct LiveOutputs(Receiver);

impl Outputs for LiveOutputs {
    fn receive(&mut self, timeout: Duration) -> Result<Output, RecvTimeoutError> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some(output) = self.0.try_next() {
                return Ok(output);
            }
            let rest = deadline.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return Err(RecvTimeoutError::Timeout);
            }
            self.0.wait(rest);
        }
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

fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

const STOPPING: &str = "the twin is stopping";

fn stopping<T>() -> Result<T, String> {
    Err(STOPPING.to_owned())
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
