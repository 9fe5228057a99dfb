//! The twin in real time: clocks, deadlines, bounded queues, the solver's thread.
//!
//! The solver's thread waits for absolute deadlines. If it is late, it skips whole periods, counts them, and makes up for
//! their steps, so that no sample is lost. During a response it takes no lock, allocates no memory and writes no log:
//! outputs go into bounded lock-free queues, and a slow reader loses only its own samples, which are counted. The forecast
//! is computed in slices between the deadlines. A prediction runs in the thread of the caller. A separate thread writes
//! the state file. Another one, which exists only while it computes, finds the critical velocities of the column at rest. If
//! there are sensors, a further one feels impacts with them.

mod background;
mod clock;
mod inbox;
mod lateness;
#[cfg(feature = "study")]
mod libraries;
mod marked;
mod measurements;
mod notifier;
mod pool;
pub(crate) mod queue;
mod real_time;
mod recent_batches;
#[cfg(feature = "study")]
mod sensing;
#[cfg(feature = "study")]
mod sensing_news;
mod solver;
mod state_writer;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::thread::{self, JoinHandle};

use thiserror::Error;

pub use background::BACKGROUND_THREAD;
pub use clock::{Clock, SimClock, SystemClock, monotonic_nanos};
pub use inbox::MAX_COMMANDS;
pub use lateness::{Lateness, lateness};
#[cfg(feature = "study")]
pub use libraries::{LIBRARY_THREAD, LibraryStatistics, MAX_LIBRARIES, MAX_LIBRARY_BYTES};
pub use measurements::{
    MAX_QUEUED_BATCHES, MAX_QUEUED_BATCHES_OF_A_FLEET, MAX_QUEUED_SAMPLES, MeasurementQueue,
};
pub use notifier::Notifier;
pub use pool::{FleetHandle, FleetOptions, LiveFleet, MAX_FLEET_COMMANDS, MAX_THREADS};
#[cfg(feature = "study")]
pub use pool::{FleetMeasurements, SensingStatistics};
pub use queue::{OutputQueue, OutputSource, QueueStats, Receiver, Waker, WhenFull};
pub use real_time::{Grant, RealTime, RealTimeGrants, THREAD_STACK, request_for_publisher};
use real_time::{Patience, Urgency};
pub use recent_batches::RecentBatches;
#[cfg(feature = "study")]
pub use sensing::{Deliver, MAX_ESTIMATED_AT_ONCE, SENSING_THREAD};
pub use solver::{MAX_CLOCK_STEP_BACK, SOLVER_THREAD};
pub use state_writer::STATE_WRITER_THREAD;

use crate::column::ImpactSpecification;
use crate::parameters::Parameters;
use crate::twin::{Accepted, ColumnSnapshot, Command, Prediction, Refusal, Twin};
use background::Background;
use inbox::{ANSWER_TIMEOUT, Reply, Request};
use queue::OutputQueues;
#[cfg(feature = "study")]
use sensing::{SensingThread, Surroundings};
#[cfg(feature = "study")]
use sensing_news::SensingNews;
use solver::{Shared, Sink, Solver};
use state_writer::StateWriter;

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
    /// Takes the estimates of impacts that the sensors have felt; `None`: the twin.
    #[cfg(feature = "study")]
    pub estimates: Option<Deliver>,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            real_time: RealTime::default(),
            state_file: None,
            outputs: vec![OutputQueue::ros()],
            measurements: None,
            #[cfg(feature = "study")]
            estimates: None,
        }
    }
}

/// A thread of the twin panicked; its message is on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("thread {0} panicked; please report its message on standard error")]
pub struct Panicked(&'static str);

/// Statistics of a live twin.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveStatistics {
    /// Cycles of the solver's thread.
    pub cycles: u64,
    /// Cycles that started at least one period late.
    pub overruns: u64,
    /// Periods skipped by late cycles.
    pub skipped_periods: u64,
    /// Maximum delay of a cycle after its deadline \[ns\].
    pub worst_lateness: u64,
    /// Steps of all responses.
    pub steps: u64,
    /// Newton iterations of these steps.
    pub newton_iterations: u64,
    /// State files that could not be written.
    pub state_file_failures: u64,
    /// Estimates that the twin could not take.
    pub lost_estimates: u64,
    /// All queues.
    pub queues: Vec<QueueStats>,
    /// The real-time properties that were granted.
    pub real_time: RealTimeGrants,
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
        let clock: Arc<dyn Clock> = Arc::new(clock);
        let queues: Vec<_> = options
            .outputs
            .iter()
            .map(|it| Arc::new(OutputQueues::new(it)))
            .collect();
        let shared = Arc::new(Shared::new());
        clock.serve(shared.inbox.notifier());
        let mut handle = LiveHandle {
            receivers: Mutex::new(
                queues
                    .iter()
                    .map(|it| Receiver::new(Arc::clone(it)))
                    .collect(),
            ),
            queues: queues.clone(),
            shared: Arc::clone(&shared),
            state_writer: None,
            solver: None,
            measurements: options.measurements.clone(),
            #[cfg(feature = "study")]
            sensing: None,
            real_time: RealTimeGrants::default(),
            parameters: Arc::new(RwLock::new(Arc::clone(twin.parameters()))),
        };
        if let Some(path) = options.state_file {
            handle.state_writer = Some(StateWriter::start(
                path,
                queues.clone(),
                Arc::clone(&clock),
            )?);
        }
        let state_writer = handle
            .state_writer
            .as_ref()
            .map(|(state_writer, _)| Arc::clone(state_writer));
        let parameters = Arc::clone(&handle.parameters);
        #[cfg(feature = "study")]
        let news = options
            .measurements
            .as_ref()
            .map(|it| Arc::new(SensingNews::new([true], Arc::clone(it))));
        let sink = Sink {
            queues: queues.clone(),
            state_writer,
            parameters,
            #[cfg(feature = "study")]
            news: news.clone(),
            unnotified: false,
        };
        #[cfg(feature = "study")]
        let to_the_twin = {
            let shared = Arc::clone(&shared);
            Deliver::new(move |record| {
                shared.inbox.submit(Request::Command {
                    command: Command::Estimate(Arc::new(record)),
                    reply: Reply::none(),
                })
            })
        };
        #[cfg(feature = "study")]
        let surroundings = news.map(|news| Surroundings {
            clock: Arc::clone(&clock),
            outputs: queues.clone(),
            news,
            snapshot: {
                let shared = Arc::clone(&shared);
                Box::new(move |_| shared.snapshot().ok())
            },
            reserved: options.real_time.processors.clone(),
            libraries: None,
        });
        let mut solver = Solver {
            twin,
            clock,
            shared,
            sink,
            background: Background::new(),
            latest: None,
            completing_cycles: 0,
            planned: None,
            urgency: Urgency::default(),
            patience: Patience::default(),
        };
        let (sender, grants) = sync_channel(1);
        let real_time = options.real_time;
        handle.solver = Some(
            thread::Builder::new()
                .name(SOLVER_THREAD.to_owned())
                .stack_size(THREAD_STACK)
                .spawn(move || {
                    let grants = real_time::request(&real_time);
                    solver.urgency = Urgency::of(&real_time, &grants);
                    let _ = sender.try_send(grants); // there is room for one
                    solver.run();
                })?,
        );
        handle.real_time = grants.recv_timeout(ANSWER_TIMEOUT).unwrap_or_default();
        #[cfg(feature = "study")]
        if let (Some(measurements), Some(surroundings)) = (options.measurements, surroundings) {
            let deliver = options.estimates.unwrap_or(to_the_twin);
            handle.sensing = Some(SensingThread::start(measurements, deliver, surroundings)?);
        }
        Ok(handle)
    }
}

/// A twin that runs in its own thread. Dropping the handle stops it.
#[derive(Debug)]
pub struct LiveHandle {
    shared: Arc<Shared>,
    queues: Vec<Arc<OutputQueues>>,
    receivers: Mutex<Vec<Receiver>>,
    state_writer: Option<(Arc<StateWriter>, JoinHandle<()>)>,
    solver: Option<JoinHandle<()>>,
    measurements: Option<Arc<MeasurementQueue>>,
    #[cfg(feature = "study")]
    sensing: Option<SensingThread>,
    real_time: RealTimeGrants,
    parameters: Arc<RwLock<Arc<Parameters>>>,
}

impl LiveHandle {
    /// Submits a command without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The queue of commands is full.
    pub fn submit(&self, command: Command) -> Result<(), Refusal> {
        self.shared.inbox.submit(Request::Command {
            command,
            reply: Reply::none(),
        })
    }

    /// Submits a command and waits for the outcome.
    ///
    /// # Errors
    /// The command is rejected, or the solver does not answer in time.
    pub fn execute(&self, command: Command) -> Result<Accepted, Refusal> {
        self.shared
            .inbox
            .ask(|reply| Request::Command { command, reply })?
    }

    /// The outputs for the reader with this name; `None` if there is no such queue, or its receiver was taken before.
    pub fn outputs(&self, name: &str) -> Option<Receiver> {
        let mut receivers = self
            .receivers
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let index = receivers.iter().position(|it| it.name() == name)?;
        Some(receivers.swap_remove(index))
    }

    /// The newest measurements; `None` if they are not remembered for those who look at them.
    #[must_use]
    pub fn recent_measurements(&self) -> Option<Arc<RecentBatches>> {
        self.measurements.as_ref().and_then(|it| it.recent())
    }

    /// The parameters that hold; a change that waits for the end of a response is not among them yet.
    #[must_use]
    pub fn parameters(&self) -> Arc<Parameters> {
        let latest = self.parameters.read();
        Arc::clone(&latest.unwrap_or_else(PoisonError::into_inner))
    }

    /// A copy of the current state of the column.
    ///
    /// # Errors
    /// The solver does not answer in time.
    pub fn snapshot(&self) -> Result<ColumnSnapshot, Refusal> {
        self.shared.snapshot()
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
    ) -> Result<Prediction, Refusal> {
        self.snapshot()?
            .predict(column_id, vehicle, impact, &monotonic_nanos)
    }

    /// Statistics since the start.
    pub fn statistics(&self) -> LiveStatistics {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let shared = &self.shared;
        let state_writer = self
            .state_writer
            .as_ref()
            .map(|(state_writer, _)| state_writer);
        let mut queues = vec![shared.inbox.stats()];
        queues.extend(self.queues.iter().flat_map(|it| it.stats()));
        queues.extend(state_writer.map(|it| it.stats()));
        queues.extend(self.measurements.as_ref().map(|it| it.stats()));
        LiveStatistics {
            cycles: read(&shared.cycles),
            overruns: read(&shared.overruns),
            skipped_periods: read(&shared.skipped_periods),
            worst_lateness: read(&shared.worst_lateness),
            steps: read(&shared.steps),
            newton_iterations: read(&shared.newton_iterations),
            state_file_failures: state_writer.map_or(0, |it| it.failures()),
            lost_estimates: self.lost_estimates(),
            queues,
            real_time: self.real_time.clone(),
        }
    }

    fn lost_estimates(&self) -> u64 {
        #[cfg(feature = "study")]
        if let Some(sensing) = &self.sensing {
            return sensing.lost_estimates();
        }
        0
    }

    /// Whether the solver's thread is running. Before a stop it ends only if it panics.
    pub fn is_running(&self) -> bool {
        self.solver
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Stops within a second, and returns the final statistics. The damage is saved; for a running response, the predicted
    /// damage. A [`Notice`](crate::twin::Notice) lists what is lost nevertheless. Queued outputs can still be received.
    ///
    /// # Errors
    /// A thread panicked.
    pub fn stop(mut self) -> Result<LiveStatistics, Panicked> {
        self.join()?;
        Ok(self.statistics())
    }

    fn join(&mut self) -> Result<(), Panicked> {
        // First, because its estimates are commands to the solver.
        #[cfg(feature = "study")]
        let sensing = self.sensing.as_mut().is_none_or(SensingThread::stop);
        #[cfg(not(feature = "study"))]
        let sensing = true;
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.inbox.notifier().notify();
        let solver = self
            .solver
            .take()
            .is_none_or(|thread| thread.join().is_ok());
        let state_writer = self
            .state_writer
            .take()
            .is_none_or(|(state_writer, thread)| {
                state_writer.stop();
                thread.join().is_ok()
            });
        match (solver, state_writer, sensing) {
            (false, _, _) => Err(Panicked(SOLVER_THREAD)),
            (_, false, _) => Err(Panicked(STATE_WRITER_THREAD)),
            (_, _, false) => Err(Panicked("column_twin/sense")),
            (true, true, true) => Ok(()),
        }
    }
}

impl Drop for LiveHandle {
    fn drop(&mut self) {
        let _ = self.join(); // a thread that panicked has printed its message
    }
}
