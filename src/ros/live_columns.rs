//! The live columns of a node, one or many: commands, health and clock, from start to stop.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::column::{ImpactSpecification, ModelError};
use crate::fleet::{FleetStartError, make_twins};
use crate::live::{
    Clock, FleetHandle, FleetMeasurements, FleetOptions, Live, LiveFleet, LiveOptions,
    LiveStatistics, OpinionReply, OutputQueue, QueueStats, RealTime, Receiver, SensingStatistics,
    SimClock, SystemClock, monotonic_nanos,
};
use crate::parameters::{
    FleetColumn, FleetColumns, MAX_SELECTED_COLUMNS, ParameterFaults, Parameters, RecordMode,
    SelectionError, select_columns,
};
use crate::state_home;
use crate::twin::state_file::{self, Loaded, Reserved, StateFileError};
use crate::twin::{
    Accepted, Command, Condition, ImpactCommand, OpinionTask, Prediction, Rejection, RejectionCode,
    SavedState, Striking, Twin,
};

use super::face::Face;
use super::node_viewer::{self, NodeViewer};
use super::utc::Utc;

/// Most topics, besides the one that all sensors share, that the sensors of a fleet may name: each is an endpoint, of which every peer
/// is told.
const MAX_SENSOR_TOPICS: usize = 256;

/// Why the live columns cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// Columns are selected for the viewer that cannot be shown.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// The sensors of a fleet name more topics than it reads.
    #[error(
        "the sensors of the fleet name {found} topics of their own, but a fleet reads at most {MAX_SENSOR_TOPICS}, because each takes an \
         endpoint; let the others send column_twin_msgs/msg/Measurement on the topic measurements, which all sensors share, or run the \
         columns as several fleets"
    )]
    SensorTopics {
        /// Number of topics.
        found: usize,
    },
    /// Parameters are not valid.
    #[error(transparent)]
    Parameters(#[from] ParameterFaults),
    /// A state file or the folder of the state files cannot be read or reserved.
    #[error(transparent)]
    StateFile(#[from] StateFileError),
    /// The column of a single twin is impossible.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Columns of a fleet are impossible.
    #[error(transparent)]
    Columns(#[from] FleetStartError),
    /// A thread cannot be started.
    #[error("a thread cannot be started: {0}; check the limit of processes (ulimit -u)")]
    Thread(#[from] std::io::Error),
    /// The options lack the queue to the node.
    #[error("the options have no output queue called {name}; add OutputQueue::ros()", name = OutputQueue::ROS)]
    NoQueue,
}

/// Columns that run in threads of their own. Called from the threads of the node, never from the solver's.
pub struct LiveColumns {
    /// `None` after the stop.
    running: RwLock<Option<Running>>,
    viewer: Mutex<NodeViewer>,
    /// The health at the stop.
    last_health: Mutex<Health>,
    clock: Arc<dyn Clock>,
    /// The same clock under `use_sim_time`, which can be set.
    simulated: Option<Arc<SimClock>>,
    face: Face,
    /// The parameters of the columns at the start, by their indices.
    initial: Vec<Arc<Parameters>>,
    /// The parameters of the node: those of its column, or those that all columns of a fleet share.
    node: Arc<Parameters>,
    /// Where measurements go; `None` without sensors.
    measurements: Option<FleetMeasurements>,
}

/// What the stop drops, in this order.
struct Running {
    handle: FleetHandle,
    /// The state files, until the last damage is written.
    _reserved: Option<Reserved>,
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

impl LiveColumns {
    /// Starts a single twin with the damage in its state file and, depending on the parameters, the viewer. The parameters replace
    /// `options.state_file`, `options.real_time` and `options.measurements`. The receiver returns the outputs of the twin.
    ///
    /// # Errors
    /// The column is impossible, its state file cannot be used, or a thread cannot be started.
    pub fn start_one(
        parameters: Parameters,
        options: LiveOptions,
    ) -> Result<(Arc<Self>, Receiver), StartError> {
        let parameters = Arc::new(parameters);
        let settings = parameters.settings();
        let (simulated, clock) = clocks(&parameters);
        let path = state_file::path(&parameters);
        let reserved = path.as_deref().map(state_file::reserve).transpose()?;
        let mut stored = Stored::default();
        let about = |saved: &SavedState, path: &Path| {
            tracing::info!("{}", restored(saved, path, simulated.is_some()));
        };
        stored.load(&parameters, "", "~/reset", about)?;
        let saved = stored.saved.first().and_then(Option::as_deref);
        let stopwatch = Box::new(monotonic_nanos);
        let mut twin = Twin::new(Arc::clone(&parameters), saved, stopwatch, clock.now())?;
        stored.keep_unknown_damage(std::slice::from_mut(&mut twin), clock.now())?;
        let has_sensors = !settings.sensors.names.is_empty();
        let mut options = LiveOptions {
            state_file: path,
            real_time: RealTime::of(&parameters),
            measurements: has_sensors.then(Arc::default),
            ..options
        };
        let viewer_queues = node_viewer::queues(&parameters, 1);
        options.outputs.extend(viewer_queues);
        let handle = Live::start(twin, Arc::clone(&clock), options)?.into_pool();
        let outputs = handle
            .outputs(OutputQueue::ROS)
            .ok_or(StartError::NoQueue)?;
        let viewer = node_viewer::start(&parameters, None, &handle, clock.now())?;
        let face = Face::of_one(&settings.column_id);
        let initial = vec![Arc::clone(&parameters)];
        let running = Running {
            handle,
            _reserved: reserved,
        };
        let columns = Self::new(
            running,
            viewer,
            (clock, simulated),
            face,
            initial,
            parameters,
        );
        Ok((columns, outputs))
    }

    /// Starts the columns of a fleet with the damage in their state files and, depending on the parameters, the viewer. The receiver
    /// returns the outputs of all of them.
    ///
    /// # Errors
    /// Columns are impossible, their sensors name too many topics, columns are selected that cannot be shown, the state directory
    /// cannot be used, or a thread cannot be started.
    pub fn start_fleet(fleet: &FleetColumns) -> Result<(Arc<Self>, Receiver), StartError> {
        let FleetColumns { columns, node, .. } = fleet;
        let node = Arc::new(node.clone());
        let settings = node.settings();
        let selected = &settings.viewer.select;
        let selected = select_columns(columns, selected, MAX_SELECTED_COLUMNS)?;
        check_sensor_topics(columns)?;
        let directory = state_home::resolve(&settings.state.directory);
        let reserved = match settings.state.directory.is_empty() {
            true => None,
            false => Some(state_file::reserve_folder(&directory)?),
        };
        let (simulated, clock) = clocks(&node);
        let mut stored = Stored::default();
        let mut restored = 0;
        for FleetColumn { name, parameters } in columns {
            let name = format!(" of {name}");
            stored.load(parameters, &name, "~/reset_column", |_, _| restored += 1)?;
        }
        if restored > 0 {
            tracing::info!(
                "the damage of {restored} columns was restored from {}",
                directory.display()
            );
        }
        let mut twins = make_twins(columns, &stored.saved, monotonic_nanos, clock.now())?;
        stored.keep_unknown_damage(&mut twins, clock.now())?;
        let options = FleetOptions {
            real_time: RealTime::of(&node),
            threads: FleetOptions::threads_of(&node),
            state_files: stored.paths,
            journals: settings.record.mode != RecordMode::Off,
            further_outputs: node_viewer::queues(&node, columns.len()),
        };
        let ids = twins.iter().map(|it| Arc::clone(it.column_id())).collect();
        let (handle, outputs) = LiveFleet::start(twins, Arc::clone(&clock), options)?;
        let shown = Some((columns.as_slice(), selected));
        let viewer = node_viewer::start(&node, shown, &handle, clock.now())?;
        let names = columns.iter().map(|it| it.name.as_str().into()).collect();
        let face = Face::of_many(ids, names);
        let initial = columns.iter().map(|it| Arc::clone(&it.parameters));
        let running = Running {
            handle,
            _reserved: reserved,
        };
        let (clock, initial) = ((clock, simulated), initial.collect());
        let columns = Self::new(running, viewer, clock, face, initial, node);
        Ok((columns, outputs))
    }

    fn new(
        running: Running,
        viewer: NodeViewer,
        (clock, simulated): (Arc<dyn Clock>, Option<Arc<SimClock>>),
        face: Face,
        initial: Vec<Arc<Parameters>>,
        node: Arc<Parameters>,
    ) -> Arc<Self> {
        for warning in running.handle.statistics().real_time.warnings() {
            tracing::warn!("{warning}");
        }
        Arc::new(Self {
            measurements: running.handle.measurements().cloned(),
            running: RwLock::new(Some(running)),
            viewer: Mutex::new(viewer),
            last_health: Mutex::default(),
            clock,
            simulated,
            face,
            initial,
            node,
        })
    }

    /// Stops the threads of the columns and the viewer. Queued outputs can still be received.
    pub fn stop(&self) {
        let last_health = || {
            let last = self.last_health.lock();
            last.unwrap_or_else(PoisonError::into_inner)
        };
        let mut running = self.running.write().unwrap_or_else(PoisonError::into_inner);
        let Some(Running { handle, _reserved }) = running.take() else {
            return;
        };
        // Set before the lock is released, because the last messages contain it.
        *last_health() = health_of(handle.statistics(), !handle.is_running());
        drop(running);
        match handle.stop() {
            // Includes what the stop itself lost.
            Ok(statistics) => *last_health() = health_of(statistics, false),
            Err(panicked) => {
                tracing::error!("{panicked}");
                last_health().has_panicked = true;
            }
        }
        // It shows what the columns have given out at the end.
        let mut viewer = self.viewer.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut *viewer).stop();
    }

    /// The columns, and how others tell them apart.
    #[must_use]
    pub fn face(&self) -> &Face {
        &self.face
    }

    /// The parameters of the node: those of its column at the start, or those that all columns of a fleet share.
    #[must_use]
    pub fn node_parameters(&self) -> &Arc<Parameters> {
        &self.node
    }

    /// The parameters of a column that hold; after the stop, those of the start.
    ///
    /// # Panics
    /// There is no column with this index.
    #[must_use]
    pub fn parameters(&self, column: u32) -> Arc<Parameters> {
        self.ask(|handle| Ok(handle.parameters(column)))
            .unwrap_or_else(|_| Arc::clone(self.initial_parameters(column)))
    }

    /// The parameters of a column at the start.
    ///
    /// # Panics
    /// There is no column with this index.
    #[must_use]
    pub fn initial_parameters(&self, column: u32) -> &Arc<Parameters> {
        &self.initial[column as usize]
    }

    /// Submits a command to a column without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The command did not reach the twin.
    pub fn submit(&self, column: u32, command: Command) -> Result<(), Rejection> {
        self.ask(|handle| handle.submit(column, command))
    }

    /// Submits a command to a column and waits for the outcome.
    ///
    /// # Errors
    /// The command was rejected. If it reached the twin, the rejection is also among the outputs.
    pub fn execute(&self, column: u32, command: Command) -> Result<Accepted, Rejection> {
        self.ask(|handle| handle.execute(column, command))
    }

    /// Whether a column would take this impact now, with what the command leaves open; its stamp counts only if it is not ahead
    /// of the clock.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer.
    pub fn check_impact(&self, column: u32, command: ImpactCommand) -> Result<Striking, Rejection> {
        self.ask(|handle| handle.check_impact(column, command))
    }

    /// Predicts the outcome of an impact on a column in its current state, in the thread of the caller. An empty `vehicle` means that
    /// of the parameters.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer.
    pub fn predict(
        &self,
        column: u32,
        vehicle: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Rejection> {
        self.ask(|handle| handle.predict(column, vehicle, impact))
    }

    /// Asks for the second opinion on a prediction, which is computed with the lowest priority and given to `reply`. `reply` is dropped
    /// by a stop, see [`is_stopping`](Self::is_stopping), and if the thread that computes second opinions has panicked.
    ///
    /// # Errors
    /// The columns have stopped, or too many second opinions are asked for.
    pub fn ask_opinion(&self, task: OpinionTask, reply: OpinionReply) -> Result<(), Rejection> {
        self.ask(|handle| match handle.ask_opinion(task, reply) {
            true => Ok(()),
            false => Err(Rejection::new(
                RejectionCode::NoAnswer,
                "too many predictions wait for their second opinion; ask again later",
            )),
        })
    }

    /// Whether the columns have been stopped, or are being stopped.
    #[must_use]
    pub fn is_stopping(&self) -> bool {
        let running = self.running.read().unwrap_or_else(PoisonError::into_inner);
        running.is_none()
    }

    /// Where the measurements of the columns go; `None` if no column has sensors.
    #[must_use]
    pub fn measurements(&self) -> Option<&FleetMeasurements> {
        self.measurements.as_ref()
    }

    /// What was counted of the sensing; `None` without sensors, or after the stop.
    #[must_use]
    pub fn sensing_statistics(&self) -> Option<SensingStatistics> {
        self.ask(|handle| Ok(handle.sensing_statistics()))
            .unwrap_or(None)
    }

    /// The state of threads and queues.
    #[must_use]
    pub fn health(&self) -> Health {
        self.ask(|handle| Ok(health_of(handle.statistics(), !handle.is_running())))
            .unwrap_or_else(|_| {
                let last = self.last_health.lock();
                last.unwrap_or_else(PoisonError::into_inner).clone()
            })
    }

    /// Whether the damage of this column is still to be written, and that of few others; `false` after the stop.
    #[must_use]
    pub fn is_saving(&self, column: u32) -> bool {
        self.ask(|handle| Ok(handle.is_saving(column)))
            .unwrap_or(false)
    }

    /// Number of columns that respond or have something to do soon.
    #[must_use]
    pub fn active(&self) -> usize {
        self.ask(|handle| Ok(handle.active())).unwrap_or(0)
    }

    /// Number of columns at rest whose critical velocities are not computed yet.
    #[must_use]
    pub fn without_critical_velocities(&self) -> usize {
        self.ask(|handle| Ok(handle.without_critical_velocities()))
            .unwrap_or(0)
    }

    /// Number of solver threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.ask(|handle| Ok(handle.threads())).unwrap_or(0)
    }

    /// The time of the clock that drives the columns \[ns since the epoch\].
    #[must_use]
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
    /// The columns have been stopped.
    fn ask<T>(
        &self,
        question: impl FnOnce(&FleetHandle) -> Result<T, Rejection>,
    ) -> Result<T, Rejection> {
        let running = self.running.read().unwrap_or_else(PoisonError::into_inner);
        match &*running {
            Some(running) => question(&running.handle),
            None => {
                let reason = format!("the {} is stopping", self.face.noun());
                Err(Rejection::new(RejectionCode::Stopping, reason))
            }
        }
    }
}

/// The clock that drives the columns, and the same under `use_sim_time`, which can be set.
fn clocks(node: &Parameters) -> (Option<Arc<SimClock>>, Arc<dyn Clock>) {
    let simulated = node.settings().use_sim_time;
    let simulated = simulated.then(|| Arc::new(SimClock::new(0)));
    let clock: Arc<dyn Clock> = match &simulated {
        Some(clock) => Arc::clone(clock) as _,
        None => Arc::new(SystemClock::new()),
    };
    (simulated, clock)
}

/// What the state files of the columns contain. Either every column has one or none.
#[derive(Default)]
struct Stored {
    paths: Vec<PathBuf>,
    saved: Vec<Option<Box<SavedState>>>,
    /// Columns whose file cannot be used.
    rejected: Vec<usize>,
}

impl Stored {
    /// Loads the file of the next column; `of` names the column in the log, and `reset` the service after which a rejected file has no
    /// effect any more.
    fn load(
        &mut self,
        parameters: &Parameters,
        of: &str,
        reset: &str,
        restored: impl FnOnce(&SavedState, &Path),
    ) -> Result<(), StateFileError> {
        let Some(path) = state_file::path(parameters) else {
            return Ok(());
        };
        self.saved.push(match state_file::load(&path, parameters)? {
            Loaded::Absent => None,
            Loaded::Damage(saved) => {
                restored(&saved, &path);
                Some(saved)
            }
            Loaded::Rejected { reason, kept_as } => {
                tracing::warn!(
                    "the state file{of} cannot be used, so the column starts undamaged, and its status calls for an inspection until {reset}: {reason}; the file was renamed to {}",
                    kept_as.display()
                );
                self.rejected.push(self.saved.len());
                None
            }
        });
        self.paths.push(path);
        Ok(())
    }

    /// Saves at once that a file could not be used, so that the next start still knows it.
    fn keep_unknown_damage(&self, twins: &mut [Twin], now: i64) -> Result<(), StateFileError> {
        for index in &self.rejected {
            let twin = &mut twins[*index];
            twin.note_unknown_damage();
            state_file::store(&self.paths[*index], &twin.saved_state(now))?;
        }
        Ok(())
    }
}

/// # Errors
/// The sensors of these columns name too many topics.
fn check_sensor_topics(columns: &[FleetColumn]) -> Result<(), StartError> {
    let topics = columns.iter().map(|it| {
        let sources = it.parameters.sensor_sources();
        let named: BTreeSet<_> = sources.into_iter().map(|it| it.topic).collect();
        named.iter().filter(|it| !it.is_empty()).count()
    });
    match topics.sum() {
        found if found > MAX_SENSOR_TOPICS => Err(StartError::SensorTopics { found }),
        _ => Ok(()),
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
        Condition::Fractured => "is fractured",
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

fn health_of(statistics: LiveStatistics, has_panicked: bool) -> Health {
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
            ("locks waited for", statistics.contended_locks),
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
