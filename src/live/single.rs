//! A single twin: a pool of one column.

use std::path::PathBuf;
use std::sync::Arc;

use super::clock::{Clock, monotonic_nanos};
use super::inbox::MAX_COMMANDS;
use super::measurements::MeasurementQueue;
use super::pool::Sensors;
use super::pool::{FleetHandle, Pool, Upkeep};
use super::queue::{OutputQueue, OutputQueues, Receiver};
use super::real_time::RealTime;
use super::sensing::Deliver;
use super::statistics::{LiveStatistics, Panicked};
use crate::column::ImpactSpecification;
use crate::parameters::Parameters;
use crate::twin::{Accepted, ColumnSnapshot, Command, Prediction, Rejection, Twin};

/// The index of the only column.
const COLUMN: u32 = 0;

/// Options of a live twin.
#[derive(Debug, Clone)]
pub struct LiveOptions {
    /// The real-time properties to request.
    pub real_time: RealTime,
    /// Where to save the damage, see [`state_file::path`](crate::twin::state_file::path); `None`: it is not saved.
    pub state_file: Option<PathBuf>,
    /// The queues to the readers of the outputs.
    pub outputs: Vec<OutputQueue>,
    /// The queue of measurements; `None` without sensors.
    pub measurements: Option<Arc<MeasurementQueue>>,
    /// Takes the estimates of impacts that the sensors have detected; `None`: the twin.
    pub estimates: Option<Deliver>,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            real_time: RealTime::default(),
            state_file: None,
            outputs: vec![OutputQueue::ros()],
            measurements: None,
            estimates: None,
        }
    }
}

/// Starts live twins.
pub struct Live;

impl Live {
    /// Starts the solver's thread and, if there is a state file, the thread that writes it.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn start(
        twin: Twin,
        clock: impl Clock + 'static,
        options: LiveOptions,
    ) -> std::io::Result<LiveHandle> {
        let outputs = options.outputs.iter();
        let outputs: Vec<_> = outputs.map(|it| Arc::new(OutputQueues::new(it))).collect();
        let measurements = options.measurements;
        let sensors = measurements.map(|it| Sensors::of_one(it, options.estimates));
        let pool = Pool {
            real_time: options.real_time,
            threads: 1,
            state_files: options.state_file.into_iter().collect(),
            journals: outputs.len(),
            outputs,
            taken_outputs: 0,
            upkeep: Upkeep::Constant,
            max_requests: MAX_COMMANDS,
            sensors,
        };
        Ok(LiveHandle {
            pool: pool.start(vec![twin], Arc::new(clock))?,
        })
    }
}

/// A twin that runs in its own threads, a pool of one column. Dropping the handle stops it.
#[derive(Debug)]
pub struct LiveHandle {
    pool: FleetHandle,
}

impl LiveHandle {
    /// Submits a command without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The queue of commands is full.
    pub fn submit(&self, command: Command) -> Result<(), Rejection> {
        self.pool.submit(COLUMN, command)
    }

    /// Submits a command and waits for the outcome.
    ///
    /// # Errors
    /// The command is rejected, or the solver does not answer in time.
    pub fn execute(&self, command: Command) -> Result<Accepted, Rejection> {
        self.pool.execute(COLUMN, command)
    }

    /// The outputs for the reader with this name; `None` if there is no such queue, or its receiver was taken before.
    pub fn outputs(&self, name: &str) -> Option<Receiver> {
        self.pool.outputs(name)
    }

    /// The parameters that hold; a change that waits for the end of a response is not among them yet.
    #[must_use]
    pub fn parameters(&self) -> Arc<Parameters> {
        self.pool.parameters(COLUMN)
    }

    /// A copy of the current state of the column.
    ///
    /// # Errors
    /// The solver does not answer in time.
    pub fn snapshot(&self) -> Result<ColumnSnapshot, Rejection> {
        self.pool.snapshot(COLUMN)
    }

    /// Predicts the outcome of an impact on the column in its current state, in the thread of the caller. An empty
    /// `column_id` means the column of this twin, an empty `vehicle` that of the parameters.
    ///
    /// # Errors
    /// The impact would be rejected, its response cannot be computed, or the solver does not answer in time.
    pub fn predict(
        &self,
        column_id: &str,
        vehicle: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Rejection> {
        self.snapshot()?
            .predict(column_id, vehicle, impact, &monotonic_nanos)
    }

    /// The pool of which this is the only column.
    #[must_use]
    pub fn into_pool(self) -> FleetHandle {
        self.pool
    }

    /// Statistics since the start.
    pub fn statistics(&self) -> LiveStatistics {
        self.pool.statistics()
    }

    /// Whether the solver's thread is running. Before a stop it ends only if it panics.
    pub fn is_running(&self) -> bool {
        self.pool.is_running()
    }

    /// Stops within a second, and returns the final statistics. The damage is saved; for a running response, the predicted
    /// damage. A [`Notice`](crate::twin::Notice) lists what is lost nevertheless. Queued outputs can still be received.
    ///
    /// # Errors
    /// A thread panicked.
    pub fn stop(self) -> Result<LiveStatistics, Panicked> {
        self.pool.stop()
    }
}
