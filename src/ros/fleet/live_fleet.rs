//! The live fleet from the point of view of its node: columns by name, commands, health and clock, from start to stop.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::column::ImpactSpecification;
use crate::fleet::{FleetStartError, make_twins};
use crate::live::{
    Clock, FleetHandle, FleetMeasurements, FleetOptions, LiveFleet, RealTime, Receiver,
    SensingStatistics, SimClock, SystemClock, monotonic_nanos,
};
use crate::parameters::{
    FleetColumns, MAX_SELECTED_COLUMNS, ParameterFaults, Parameters, RecordMode, SelectionError,
    SensorMessage, select_columns,
};
use crate::twin::state_file::{self, Loaded, Reserved, StateFileError};
use crate::twin::{Accepted, Command, ImpactCommand, Prediction, Refusal, RefusalCode, Striking};

use super::super::live_twin::{Health, health_of};
use super::super::node_viewer::{self, NodeViewer};

/// Why a fleet cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum FleetTwinError {
    /// Columns are selected for the viewer that cannot be shown.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A sensor of a column sends on a topic of its own, or without the name of its column.
    #[error(
        "sensors.{sensor}.{name} of column {column_id:?} is {value:?}, but the sensors of a fleet send column_twin_msgs/msg/Measurement on \
         the topic measurements, which has the column_id; leave sensors.{sensor}.{name} out and convert the messages of the driver, \
         or run the column with `column-twin run`"
    )]
    SensorSource {
        /// The first column that has such a sensor.
        column_id: String,
        /// Its name.
        sensor: String,
        /// The parameter, without the name of the sensor.
        name: &'static str,
        /// Its value.
        value: String,
    },
    /// Parameters are not valid.
    #[error(transparent)]
    Parameters(#[from] ParameterFaults),
    /// A state file or the folder of the state files cannot be used.
    #[error(transparent)]
    StateFile(#[from] StateFileError),
    /// Columns are impossible.
    #[error(transparent)]
    Columns(#[from] FleetStartError),
    /// A thread cannot be started.
    #[error("a thread cannot be started: {0}; check the limit of processes (ulimit -u)")]
    Thread(#[from] std::io::Error),
}

/// A fleet that runs in its own threads. Called from the threads of the node, never from the solvers'.
pub struct FleetTwin {
    /// `None` after the stop.
    running: RwLock<Option<Running>>,
    viewer: Mutex<NodeViewer>,
    last_health: Mutex<Health>,
    clock: Arc<dyn Clock>,
    /// The same clock under `use_sim_time`, which can be set.
    simulated: Option<Arc<SimClock>>,
    /// The identifiers of the columns, by their indices.
    column_ids: Vec<Arc<str>>,
    by_id: HashMap<Arc<str>, u32>,
    /// Their full names, by their indices.
    column_names: Vec<Arc<str>>,
    /// The parameters of the columns at the start.
    initial: Vec<Arc<Parameters>>,
    /// The parameters of the node.
    node: Arc<Parameters>,
    /// Where measurements go; `None` without sensors.
    measurements: Option<FleetMeasurements>,
}

/// What the stop drops, in this order.
struct Running {
    handle: FleetHandle,
    /// Reserved until the last damage is written.
    _state_directory: Option<Reserved>,
}

/// A topic for each column, or for each sensor, would be thousands of endpoints, and other messages do not say which column they are
/// about.
fn check_sensors(parameters: &Parameters) -> Result<(), FleetTwinError> {
    let sensors = parameters.sensors();
    for (sensor, source) in sensors.iter().zip(parameters.sensor_sources()) {
        let (name, value) = match source.message {
            _ if !source.topic.is_empty() => ("topic", source.topic.as_str()),
            SensorMessage::Measurement => continue,
            other => ("message", other.word()),
        };
        return Err(FleetTwinError::SensorSource {
            column_id: parameters.settings().column_id.clone(),
            sensor: sensor.name.clone(),
            name,
            value: value.to_owned(),
        });
    }
    Ok(())
}

impl FleetTwin {
    /// Starts the columns with the damage in their state files. The receiver returns the outputs of all of them.
    ///
    /// # Errors
    /// Columns are impossible or have sensors, columns are selected that cannot be shown, the state directory cannot be used, or a
    /// thread cannot be started.
    pub fn start(fleet: &FleetColumns) -> Result<(Arc<Self>, Receiver), FleetTwinError> {
        let FleetColumns { columns, node, .. } = fleet;
        let selected = &node.settings().viewer.select;
        let selected = select_columns(columns, selected, MAX_SELECTED_COLUMNS)?;
        for column in columns {
            check_sensors(&column.parameters)?;
        }
        let directory = &node.settings().state.directory;
        let reserved = match directory.is_empty() {
            true => None,
            false => Some(state_file::reserve_folder(Path::new(directory))?),
        };
        let (mut saved, mut state_files) = (Vec::new(), Vec::new());
        let mut rejected = Vec::new();
        for column in columns {
            let Some(path) = state_file::path(&column.parameters) else {
                continue;
            };
            saved.push(match state_file::load(&path, &column.parameters)? {
                Loaded::Absent => None,
                Loaded::Damage(state) => Some(state),
                Loaded::Rejected { reason, kept_as } => {
                    tracing::warn!(
                        "the state file of {} cannot be used, so the column starts virgin, and its status calls for an inspection until ~/reset_column: {reason}; the file was renamed to {}",
                        column.name,
                        kept_as.display()
                    );
                    rejected.push((saved.len(), path.clone()));
                    None
                }
            });
            state_files.push(path);
        }
        let restored = saved.iter().flatten().count();
        if restored > 0 {
            tracing::info!("the damage of {restored} columns was restored from {directory}");
        }
        let simulated = node.settings().use_sim_time;
        let simulated = simulated.then(|| Arc::new(SimClock::new(0)));
        let clock: Arc<dyn Clock> = match &simulated {
            Some(clock) => Arc::clone(clock) as _,
            None => Arc::new(SystemClock::new()),
        };
        let mut twins = make_twins(columns, &saved, monotonic_nanos, clock.now())?;
        for (index, path) in rejected {
            // Saved at once, so that the next start still knows it.
            if let Some(twin) = twins.get_mut(index) {
                twin.note_unknown_damage();
                state_file::store(&path, &twin.saved_state(clock.now()))?;
            }
        }
        let options = FleetOptions {
            real_time: RealTime::of(node),
            threads: FleetOptions::threads_of(node),
            state_files,
            journals: node.settings().record.mode != RecordMode::Off,
            further_outputs: node_viewer::fleet_queues(fleet),
        };
        let column_ids: Vec<Arc<str>> = twins.iter().map(|it| Arc::clone(it.column_id())).collect();
        let (handle, receiver) = LiveFleet::start(twins, Arc::clone(&clock), options)?;
        for warning in handle.statistics().real_time.warnings() {
            tracing::warn!("{warning}");
        }
        let viewer = node_viewer::start_of_fleet(fleet, selected, &handle, clock.now())?;
        let measurements = handle.measurements().cloned();
        let fleet = Self {
            measurements,
            running: RwLock::new(Some(Running {
                handle,
                _state_directory: reserved,
            })),
            viewer: Mutex::new(viewer),
            last_health: Mutex::default(),
            clock,
            simulated,
            by_id: column_ids.iter().map(Arc::clone).zip(0..).collect(),
            column_ids,
            column_names: columns.iter().map(|it| it.name.as_str().into()).collect(),
            initial: columns
                .iter()
                .map(|it| Arc::clone(&it.parameters))
                .collect(),
            node: Arc::new(node.clone()),
        };
        Ok((Arc::new(fleet), receiver))
    }

    /// Stops the threads of the fleet. Queued outputs can still be received.
    pub fn stop(&self) {
        let last_health = || {
            let last = self.last_health.lock();
            last.unwrap_or_else(PoisonError::into_inner)
        };
        let mut running = self.running.write().unwrap_or_else(PoisonError::into_inner);
        let Some(Running {
            handle,
            _state_directory,
        }) = running.take()
        else {
            return;
        };
        // Set before the lock is released, because the last messages contain it.
        *last_health() = health_of(handle.statistics(), !handle.is_running());
        drop(running);
        match handle.stop() {
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

    /// The index of a column; `None` if it is not in this fleet.
    #[must_use]
    pub fn index_of(&self, column_id: &str) -> Option<u32> {
        self.by_id.get(column_id).copied()
    }

    /// The identifiers of the columns, by their indices.
    #[must_use]
    pub fn column_ids(&self) -> &[Arc<str>] {
        &self.column_ids
    }

    /// The full names of the columns, such as `/garage/a3`, by their indices.
    #[must_use]
    pub fn column_names(&self) -> &[Arc<str>] {
        &self.column_names
    }

    /// The parameters of the node, which all columns share.
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
            .unwrap_or_else(|_| self.initial_parameters(column))
    }

    /// The parameters of a column at the start.
    ///
    /// # Panics
    /// There is no column with this index.
    #[must_use]
    pub fn initial_parameters(&self, column: u32) -> Arc<Parameters> {
        Arc::clone(&self.initial[column as usize])
    }

    /// Submits a command to a column without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The command did not reach the twin.
    pub fn submit(&self, column: u32, command: Command) -> Result<(), Refusal> {
        self.ask(|handle| handle.submit(column, command))
    }

    /// Submits a command to a column and waits for the outcome.
    ///
    /// # Errors
    /// The command was rejected. If it reached the twin, the refusal is also among the outputs.
    pub fn execute(&self, column: u32, command: Command) -> Result<Accepted, Refusal> {
        self.ask(|handle| handle.execute(column, command))
    }

    /// Whether a column would take this impact now, with what the command leaves open; its stamp counts only if it is not ahead
    /// of the clock.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer.
    pub fn check_impact(&self, column: u32, command: ImpactCommand) -> Result<Striking, Refusal> {
        self.ask(|handle| handle.check_impact(column, command))
    }

    /// Predicts the outcome of an impact on a column in its current state, in the thread of the caller.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer.
    pub fn predict(
        &self,
        column: u32,
        vehicle: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Refusal> {
        self.ask(|handle| handle.predict(column, vehicle, impact))
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

    /// The time of the fleet's clock \[ns since the epoch\].
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
    /// The fleet has been stopped.
    fn ask<T>(
        &self,
        question: impl FnOnce(&FleetHandle) -> Result<T, Refusal>,
    ) -> Result<T, Refusal> {
        let running = self.running.read().unwrap_or_else(PoisonError::into_inner);
        match &*running {
            Some(running) => question(&running.handle),
            None => Err(Refusal::new(RefusalCode::Stopping, "the fleet is stopping")),
        }
    }
}
