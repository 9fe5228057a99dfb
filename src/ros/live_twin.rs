//! The live twin as the node sees it: its commands, health and clock, from the start to the stop.

use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::column::{ImpactSpecification, ModelError};
use crate::live::{
    Clock, Live, LiveHandle, LiveOptions, LiveStatistics, OutputQueue, QueueStats, RealTime,
    Receiver, SimClock, SystemClock, monotonic_nanos,
};
use crate::parameters::Parameters;
use crate::twin::state_file::{self, Loaded, Reserved, StateFileError};
use crate::twin::{Accepted, Command, Prediction, Refusal, RefusalCode, Twin};

use super::pictures::{self, Pictures};

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
    #[error("the system gives no thread for the solver: {0}")]
    Thread(#[from] std::io::Error),
    /// Nobody reads the outputs.
    #[error("the options have no output queue called {name}; add OutputQueue::ros()", name = OutputQueue::ROS)]
    NoQueue,
}

/// A twin that runs in threads of its own. Called from the node's threads, never from the solver's.
pub struct LiveTwin {
    /// Until the twin is stopped.
    living: RwLock<Option<Living>>,
    viewer: Mutex<Pictures>,
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

/// The state of the twin's threads and queues.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Health {
    /// Periods of the solver that were skipped because it was late.
    pub overruns: u64,
    /// Largest lateness of the solver after its deadline \[s\].
    pub worst_lateness: f64,
    /// Events and parameters that found their queue full.
    pub dropped_inputs: u64,
    /// Samples that were not published.
    pub dropped_states: u64,
    /// Outputs that the queues to the node have dropped: they are not published, and in no recording either.
    pub dropped_recording: u64,
    /// Frames that the viewer did not show.
    pub dropped_viewer: u64,
    /// A thread of the twin has panicked: nothing is computed any more, or no damage saved.
    pub solver_ended: bool,
    /// All queues.
    pub queues: Vec<QueueStats>,
    /// Statistics of the solver, for people.
    pub statistics: Vec<(String, String)>,
    /// The parts of the real-time set-up that were not granted, with what to do about it.
    pub hints: Vec<String>,
}

impl LiveTwin {
    /// Starts the twin of these parameters with the damage in its state file, and the viewer where there is to be one.
    /// `options.state_file` and `options.real_time` are taken from the parameters. What leaves the twin comes out of the
    /// receiver.
    ///
    /// # Errors
    /// The column is impossible, or its state file or a thread cannot be had.
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
        let saved = match saved {
            Loaded::Absent => None,
            Loaded::Damage(saved) => Some(saved),
            Loaded::Rejected { reason, kept_as } => {
                tracing::warn!(
                    "the state file cannot be used, so the column starts virgin: {reason}; the file was kept as {}",
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
        pictures::ask_for_outputs(&parameters, &mut options);
        let first_parameters = Arc::new(parameters.clone());
        let new = |now| Twin::new(parameters, saved.as_deref(), Box::new(monotonic_nanos), now);
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
        let viewer = pictures::start(&first_parameters, &handle, clock.now())?;
        let twin = Self {
            living: RwLock::new(Some(Living {
                handle,
                _state_file: reserved,
            })),
            viewer: Mutex::new(viewer),
            last_health: Mutex::default(),
            clock,
            simulated,
            first_parameters,
        };
        Ok((Arc::new(twin), outputs))
    }

    /// Ends the twin's threads and the viewer. What has left the twin can still be received.
    pub fn stop(&self) {
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
        // Before anybody can ask: the last messages contain it, too.
        *last_health() = health(&handle);
        drop(place);
        match handle.stop() {
            // With what the stop itself has cost.
            Ok(statistics) => *last_health() = health_of(statistics, false),
            Err(panicked) => {
                tracing::error!("{panicked}");
                last_health().solver_ended = true;
            }
        }
        let mut viewer = self.viewer.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *viewer).stop();
    }

    /// Gives the twin a command and returns at once; the outcome comes with the outputs.
    ///
    /// # Errors
    /// The command did not reach the twin.
    pub fn submit(&self, command: Command) -> Result<(), Refusal> {
        self.ask(|handle| handle.submit(command))
    }

    /// Gives the twin a command and waits for the outcome.
    ///
    /// # Errors
    /// The command was refused; unless it did not reach the twin, the refusal is among the outputs.
    pub fn execute(&self, command: Command) -> Result<Accepted, Refusal> {
        self.ask(|handle| handle.execute(command))
    }

    /// What an impact would do to the column as it is now, computed in the caller's thread. An empty `column_id` means
    /// the twin's own.
    ///
    /// # Errors
    /// The impact would be refused, or there is no answer.
    pub fn predict(
        &self,
        column_id: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Refusal> {
        self.ask(|handle| handle.predict(column_id, impact))
    }

    /// The name of the twin's column.
    pub fn column_id(&self) -> &str {
        &self.first_parameters.settings().column_id
    }

    /// The parameters as they were last set.
    pub fn parameters(&self) -> Arc<Parameters> {
        self.ask(|handle| Ok(handle.parameters()))
            .unwrap_or_else(|_| Arc::clone(&self.first_parameters))
    }

    /// The state of the twin's threads and queues.
    pub fn health(&self) -> Health {
        self.ask(|handle| Ok(health(handle))).unwrap_or_else(|_| {
            let last = self.last_health.lock();
            last.unwrap_or_else(PoisonError::into_inner).clone()
        })
    }

    /// The time of the twin's clock, nanoseconds since the epoch.
    pub fn now(&self) -> i64 {
        self.clock.now()
    }

    /// The time on `/clock`, nanoseconds since the epoch; has no effect without `use_sim_time`.
    pub fn set_clock(&self, now: i64) {
        if let Some(clock) = &self.simulated {
            clock.set(now);
        }
    }

    /// # Errors
    /// After the stop, when there is no twin to ask.
    fn ask<T>(
        &self,
        question: impl FnOnce(&LiveHandle) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        let living = self.living.read().unwrap_or_else(PoisonError::into_inner);
        match &*living {
            Some(living) => question(&living.handle),
            None => Err(Refusal::new(RefusalCode::Stopping, "the twin is stopping")),
        }
    }
}

fn health(handle: &LiveHandle) -> Health {
    health_of(handle.statistics(), !handle.is_running())
}

fn health_of(statistics: LiveStatistics, solver_ended: bool) -> Health {
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
        dropped_viewer: dropped(&format!("states to {}", pictures::QUEUE)),
        statistics: [
            ("turns", statistics.turns),
            ("late turns", statistics.overruns),
            ("steps", statistics.steps),
            ("Newton iterations", statistics.newton_iterations),
            ("state files not written", statistics.state_file_failures),
        ]
        .map(|(name, count)| (name.to_owned(), count.to_string()))
        .to_vec(),
        hints: statistics.real_time.warnings().collect(),
        solver_ended,
        queues,
    }
}
