//! The live twin from the point of view of the node: commands, health and clock, from start to stop.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::column::{ImpactSpecification, ModelError};
use crate::live::{
    Clock, Live, LiveHandle, LiveOptions, LiveStatistics, MeasurementQueue, OutputQueue,
    QueueStats, RealTime, Receiver, SimClock, SystemClock, monotonic_nanos,
};
use crate::parameters::Parameters;
use crate::twin::state_file::{self, Loaded, Reserved, StateFileError};
use crate::twin::{
    Accepted, Command, Condition, Prediction, Refusal, RefusalCode, SavedState, Twin,
};

use super::node_viewer::{self, NodeViewer};
use super::utc::Utc;

/// Why the live twin cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum LiveTwinError {
    /// The state file cannot be read or reserved.
    #[error(transparent)]
    StateFile(#[from] StateFileError),
    /// The column is impossible.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A thread cannot be started.
    #[error("a thread cannot be started: {0}; check the limit of processes (ulimit -u)")]
    Thread(#[from] std::io::Error),
    /// The options lack the queue to the node.
    #[error("the options have no output queue called {name}; add OutputQueue::ros()", name = OutputQueue::ROS)]
    NoQueue,
}

/// A twin that runs in its own threads. Called from the threads of the node, never from the solver's.
pub struct LiveTwin {
    /// `None` after the stop.
    running: RwLock<Option<Running>>,
    viewer: Mutex<NodeViewer>,
    /// The health at the stop.
    last_health: Mutex<Health>,
    clock: Arc<dyn Clock>,
    /// The same clock under `use_sim_time`, which can be set.
    simulated: Option<Arc<SimClock>>,
    /// The parameters at the start, including those that cannot change.
    initial_parameters: Arc<Parameters>,
    /// The queue of measurements, if there are sensors.
    measurements: Option<Arc<MeasurementQueue>>,
}

/// What the stop drops, in this order.
struct Running {
    handle: LiveHandle,
    /// Reserved until the last damage is written.
    _state_file: Option<Reserved>,
}

/// The state of the twin's threads and queues.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Health {
    /// Periods that the solver skipped because it was late.
    pub overruns: u64,
    /// Maximum delay of the solver after its deadline \[s\].
    pub worst_lateness: f64,
    /// Events and parameter changes rejected because the queue was full.
    pub dropped_inputs: u64,
    /// Samples that were not published.
    pub dropped_states: u64,
    /// Outputs dropped by the queues to the node, which are neither published nor recorded.
    pub dropped_recording: u64,
    /// States that the viewer did not show.
    pub dropped_viewer: u64,
    /// Writes of a state file that failed.
    pub unsaved_states: u64,
    /// A thread of the twin panicked: nothing is computed, or no damage is saved.
    pub has_panicked: bool,
    /// All queues.
    pub queues: Vec<QueueStats>,
    /// Statistics of the solver, for people.
    pub statistics: Vec<(String, String)>,
    /// The real-time properties that were denied, and how to obtain them.
    pub hints: Vec<String>,
}

impl LiveTwin {
    /// Starts the twin with the damage in its state file and, depending on the parameters, the viewer. The parameters
    /// replace `options.state_file`, `options.real_time` and `options.measurements`. The receiver returns the outputs of the twin.
    ///
    /// # Errors
    /// The column is impossible, its state file cannot be used, or a thread cannot be started.
    pub fn start(
        parameters: Parameters,
        options: LiveOptions,
    ) -> Result<(Arc<Self>, Receiver), LiveTwinError> {
        let simulated = parameters.settings().use_sim_time;
        let simulated = simulated.then(|| Arc::new(SimClock::new(0)));
        let path = state_file::path(&parameters);
        let reserved = path.as_deref().map(state_file::reserve).transpose()?;
        let saved = match &path {
            None => Loaded::Absent,
            Some(path) => state_file::load(path, &parameters)?,
        };
        let is_rejected = matches!(saved, Loaded::Rejected { .. });
        let saved = match saved {
            Loaded::Absent => None,
            Loaded::Damage(saved) => {
                let path = path.as_deref().unwrap_or(Path::new(""));
                tracing::info!("{}", restored(&saved, path, simulated.is_some()));
                Some(saved)
            }
            Loaded::Rejected { reason, kept_as } => {
                tracing::warn!(
                    "the state file cannot be used, so the column starts virgin, and its status calls for an inspection until ~/reset: {reason}; the file was renamed to {}",
                    kept_as.display()
                );
                None
            }
        };
        let has_sensors = !parameters.settings().sensors.names.is_empty();
        let measurements =
            has_sensors.then(|| Arc::new(node_viewer::measurement_queue(&parameters)));
        let path_of_state = path.clone();
        let mut options = LiveOptions {
            state_file: path,
            real_time: RealTime::of(&parameters),
            measurements: measurements.clone(),
            ..options
        };
        node_viewer::add_queue(&parameters, &mut options);
        let initial_parameters = Arc::new(parameters.clone());
        let stored = path_of_state.filter(|_| is_rejected);
        let new = |now| -> Result<Twin, LiveTwinError> {
            let mut twin = Twin::new(parameters, saved.as_deref(), Box::new(monotonic_nanos), now)?;
            if let Some(path) = stored {
                // Saved at once, so that the next start still knows it.
                twin.note_unknown_damage();
                state_file::store(&path, &twin.saved_state(now))?;
            }
            Ok(twin)
        };
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
        let outputs = handle
            .outputs(OutputQueue::ROS)
            .ok_or(LiveTwinError::NoQueue)?;
        let viewer = node_viewer::start(&initial_parameters, &handle, clock.now())?;
        let twin = Self {
            running: RwLock::new(Some(Running {
                handle,
                _state_file: reserved,
            })),
            viewer: Mutex::new(viewer),
            last_health: Mutex::default(),
            clock,
            simulated,
            initial_parameters,
            measurements,
        };
        Ok((Arc::new(twin), outputs))
    }

    /// Stops the threads of the twin and the viewer. Queued outputs can still be received.
    pub fn stop(&self) {
        let last_health = || {
            self.last_health
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        let mut running = self.running.write().unwrap_or_else(PoisonError::into_inner);
        let Some(Running {
            handle,
            _state_file,
        }) = running.take()
        else {
            return;
        };
        // Set before the lock is released, because the last messages contain it.
        *last_health() = health(&handle);
        drop(running);
        match handle.stop() {
            // Includes what the stop itself lost.
            Ok(statistics) => {
                let mut last = last_health();
                let stopped = health_of(statistics, false);
                // The writer of the state file has gone, and with it its count.
                let unsaved_states = last.unsaved_states.max(stopped.unsaved_states);
                *last = Health {
                    unsaved_states,
                    ..stopped
                };
            }
            Err(panicked) => {
                tracing::error!("{panicked}");
                last_health().has_panicked = true;
            }
        }
        let mut viewer = self.viewer.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *viewer).stop();
    }

    /// Submits a command without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The command did not reach the twin.
    pub fn submit(&self, command: Command) -> Result<(), Refusal> {
        self.ask(|handle| handle.submit(command))
    }

    /// Submits a command and waits for the outcome.
    ///
    /// # Errors
    /// The command was rejected. If it reached the twin, the refusal is also among the outputs.
    pub fn execute(&self, command: Command) -> Result<Accepted, Refusal> {
        self.ask(|handle| handle.execute(command))
    }

    /// Predicts the outcome of an impact on the column in its current state, in the thread of the caller. An empty
    /// `column_id` means the column of this twin, an empty `vehicle` that of the parameters.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer.
    pub fn predict(
        &self,
        column_id: &str,
        vehicle: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Refusal> {
        self.ask(|handle| handle.predict(column_id, vehicle, impact))
    }

    /// The identifier of the column.
    pub fn column_id(&self) -> &str {
        &self.initial_parameters.settings().column_id
    }

    /// The queue of measurements; `None` without sensors.
    pub fn measurements(&self) -> Option<&Arc<MeasurementQueue>> {
        self.measurements.as_ref()
    }

    /// The parameters that hold.
    pub fn parameters(&self) -> Arc<Parameters> {
        self.ask(|handle| Ok(handle.parameters()))
            .unwrap_or_else(|_| Arc::clone(&self.initial_parameters))
    }

    /// The state of the twin's threads and queues.
    pub fn health(&self) -> Health {
        self.ask(|handle| Ok(health(handle))).unwrap_or_else(|_| {
            let last = self.last_health.lock();
            last.unwrap_or_else(PoisonError::into_inner).clone()
        })
    }

    /// The time of the twin's clock \[ns since the epoch\].
    pub fn now(&self) -> i64 {
        self.clock.now()
    }

    /// Sets the simulated time \[ns since the epoch\]; has no effect without `use_sim_time`.
    pub fn set_clock(&self, now: i64) {
        if let Some(clock) = &self.simulated {
            clock.set(now);
        }
    }

    /// # Errors
    /// The twin has been stopped.
    fn ask<T>(
        &self,
        question: impl FnOnce(&LiveHandle) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        let running = self.running.read().unwrap_or_else(PoisonError::into_inner);
        match &*running {
            Some(running) => question(&running.handle),
            None => Err(Refusal::new(RefusalCode::Stopping, "the twin is stopping")),
        }
    }
}

/// What was restored: how much, from which file, of which time.
fn restored(saved: &SavedState, path: &Path, is_simulated: bool) -> String {
    let SavedState {
        column_id,
        stamp,
        condition,
        displacement,
        plastic_work_since_reset,
        impacts_since_reset,
        last_event_id,
        ..
    } = saved;
    let when = match is_simulated {
        true => format!("at {} s of simulated time", *stamp as f64 * 1e-9),
        false => format!("on {}", Utc(*stamp)),
    };
    let last = match last_event_id.is_empty() {
        true => String::new(),
        false => format!(", the last of them {last_event_id:?}"),
    };
    let condition = match condition {
        Condition::Standing => "stands",
        Condition::Collapsed => "has collapsed",
        Condition::Severed => "is severed",
        Condition::Faulted(_) => "could not be computed any further",
    };
    format!(
        "the damage of column {column_id:?} was restored from {}, saved {when}: it {condition}, v1 is {:.3} mm, {:.1} J were \
         dissipated in {impacts_since_reset} impacts since the last reset{last}",
        path.display(),
        1e3 * displacement.v1,
        plastic_work_since_reset,
    )
}

fn health(handle: &LiveHandle) -> Health {
    health_of(handle.statistics(), !handle.is_running())
}

pub(super) fn health_of(statistics: LiveStatistics, has_panicked: bool) -> Health {
    let queues = statistics.queues;
    let dropped = |name: &str| {
        let queue = queues.iter().find(|queue| queue.name == name);
        queue.map_or(0, |queue| queue.dropped)
    };
    let to_ros = format!(" to {}", OutputQueue::ROS);
    let dropped_to_ros = queues.iter().filter(|queue| queue.name.ends_with(&to_ros));
    Health {
        overruns: statistics.skipped_periods,
        worst_lateness: 1e-9 * statistics.worst_lateness as f64,
        dropped_inputs: dropped("inputs"),
        dropped_states: dropped(&format!("states to {}", OutputQueue::ROS)),
        dropped_recording: dropped_to_ros.map(|queue| queue.dropped).sum(),
        dropped_viewer: dropped(&format!("states to {}", node_viewer::QUEUE)),
        statistics: [
            ("cycles", statistics.cycles),
            ("late cycles", statistics.overruns),
            ("steps", statistics.steps),
            ("Newton iterations", statistics.newton_iterations),
            ("state files not written", statistics.state_file_failures),
        ]
        .map(|(name, count)| (name.to_owned(), count.to_string()))
        .to_vec(),
        hints: statistics.real_time.warnings().collect(),
        unsaved_states: statistics.state_file_failures,
        has_panicked,
        queues,
    }
}
