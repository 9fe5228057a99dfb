//! One twin or many in real time: a pool of solver threads, bounded queues for all columns together, one thread for their state files
//! and one for their critical velocities.
//!
//! A column has neither thread nor timer nor queue of its own; one of many that is at rest has no entry in the schedule either. Inputs
//! come first, then forecasts, that with the fewest steps left first, then states by their deadlines: a state that is late is not lost.
//! While one column alone responds, its states come before its forecast. The results do not depend on this, bit for bit, because a twin
//! does not depend on when it is stepped. While columns respond, the solver threads allocate no memory for their states, and a single
//! one finds every lock free.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - background.rs: The one thread that computes what columns await in the background, with the lowest priority: second
//   opinions, ranges of verdicts, and the critical velocities of columns at rest
// - by_key.rs: Columns in the order of a key, from which each can be taken out: a binary heap that allocates nothing after the
//   start
// - fleet_news.rs: What the solver threads of a fleet tell those that detect impacts
// - jobs.rs: What a solver thread does for a column: it passes on an input, steps the column, computes ahead; and what the
//   column needs next
// - keeper.rs: Writes the state files in one thread, because a disk may be slow
// - readers.rs: The readers of the outputs: each has queues of its own, so that a slow one loses its own outputs only
// - schedule.rs: What the solver threads do next
// - sensors.rs: The sensors: the queues of their measurements, a few threads that detect impacts, and one that prepares
//   responses for a fleet
// - shared.rs: What the solver threads share: the columns, what is to be done next, and the ways in and out
// - sink.rs: Passes what the columns give out to the readers, to the thread that writes the state files, and to those that
//   detect impacts
// - watch.rs: Which of the solver threads that wait wakes at the next deadline
// - worker.rs: A solver thread: takes the most urgent job, does it, and says what the column needs next

mod background;
mod by_key;
mod fleet_news;
mod jobs;
mod keeper;
mod readers;
mod schedule;
mod sensors;
mod shared;
mod sink;
#[cfg(test)]
mod tests;
mod watch;
mod worker;

use std::fmt;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::thread::{self, JoinHandle};

use crossbeam_queue::ArrayQueue;
use rustix::thread::sched_getaffinity;

pub use background::{BACKGROUND_THREAD, OpinionReply};
pub use keeper::STATE_WRITER_THREAD;
pub(super) use sensors::Sensors;
pub use sensors::{FleetMeasurements, SensingStatistics};
pub(super) use shared::Upkeep;
pub use worker::{MAX_CLOCK_STEP_BACK, MAX_FLEET_COMMANDS, MAX_THREADS, SOLVER_THREAD};

use super::clock::{Clock, monotonic_nanos};
use super::inbox::{ANSWER_TIMEOUT, Reply, Request};
use super::notifier::Notifier;
use super::queue::{OutputQueue, OutputQueues, QueueStats, Receiver, WhenFull};
use super::real_time::{self, RealTime, RealTimeGrants, THREAD_STACK, Urgency};
use super::statistics::{LiveStatistics, Panicked};
use crate::column::ImpactSpecification;
use crate::parameters::Parameters;
use crate::twin::{
    Accepted, ColumnSnapshot, Command, ImpactCommand, OpinionTask, Prediction, Rejection, Striking,
    Twin,
};
use background::Background;
use keeper::Keeper;
use readers::Readers;
use schedule::Plan;
use sensors::FleetSensing;
use shared::{Agreed, Counters, Shared, Slot};

/// Outputs of each kind that wait for the reader, besides two for each column, which has a status at the start and another one
/// with its critical velocities.
const WAITING_OUTPUTS: usize = 512;

/// States that wait for the reader: four seconds of one response, or 0.4 s of ten.
const WAITING_STATES: usize = 4096;

/// Options of a live fleet.
#[derive(Debug, Clone)]
pub struct FleetOptions {
    /// The real-time properties to request for the solver threads.
    pub real_time: RealTime,
    /// Number of solver threads, 1 to [`MAX_THREADS`].
    pub threads: usize,
    /// Where to save the damage, a path for each column; empty: it is not saved.
    pub state_files: Vec<PathBuf>,
    /// Whether the outputs have the journals of the columns, for a recording: of each column from its first command on.
    pub journals: bool,
    /// The queues to further readers of the outputs, who do not get the journals: [`FleetHandle::outputs`].
    pub further_outputs: Vec<OutputQueue>,
}

impl FleetOptions {
    /// Number of solver threads by the parameter `real_time.threads`: with 0, as many as processors.
    #[must_use]
    pub fn threads_of(parameters: &Parameters) -> usize {
        let processors = || thread::available_parallelism().map_or(1, usize::from);
        let wanted = match parameters.settings().real_time.threads {
            0 => processors(),
            given => usize::from(given),
        };
        wanted.clamp(1, MAX_THREADS)
    }
}

/// Starts live fleets.
pub struct LiveFleet;

impl LiveFleet {
    /// Starts the threads of these twins, whose indices name them from now on.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn start(
        twins: Vec<Twin>,
        clock: Arc<dyn Clock>,
        options: FleetOptions,
    ) -> std::io::Result<(FleetHandle, Receiver)> {
        let queue = OutputQueue {
            name: OutputQueue::ROS.to_owned(),
            states: WAITING_STATES,
            others: WAITING_OUTPUTS + 2 * twins.len(),
            when_full: WhenFull::DropOldest,
        };
        let first = Arc::new(OutputQueues::new(&queue));
        let receiver = Receiver::new(Arc::clone(&first));
        let further = options.further_outputs.iter();
        let further = further.map(|it| Arc::new(OutputQueues::new(it)));
        let sensors = {
            let is_sensed = |twin: &Twin| !twin.parameters().settings().sensors.names.is_empty();
            Sensors::of_columns(twins.iter().map(is_sensed).collect())
        };
        let pool = Pool {
            real_time: options.real_time,
            threads: options.threads.clamp(1, MAX_THREADS),
            state_files: options.state_files,
            outputs: [first].into_iter().chain(further).collect(),
            taken_outputs: 1,
            journals: usize::from(options.journals),
            upkeep: Upkeep::OnDemand,
            max_requests: MAX_FLEET_COMMANDS,
            sensors,
        };
        Ok((pool.start(twins, clock)?, receiver))
    }
}

/// A pool of solver threads that is to be started.
pub(super) struct Pool {
    pub real_time: RealTime,
    /// 1 to [`MAX_THREADS`].
    pub threads: usize,
    /// A path for each column, or none.
    pub state_files: Vec<PathBuf>,
    pub outputs: Vec<Arc<OutputQueues>>,
    /// So many of them have a receiver already.
    pub taken_outputs: usize,
    /// So many of them get the journals.
    pub journals: usize,
    pub upkeep: Upkeep,
    pub max_requests: usize,
    pub sensors: Option<Sensors>,
}

impl Pool {
    /// Starts the threads of these twins, whose indices name them from now on.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn start(self, twins: Vec<Twin>, clock: Arc<dyn Clock>) -> std::io::Result<FleetHandle> {
        let receivers = self.outputs.iter().skip(self.taken_outputs);
        let receivers = receivers.map(|it| Receiver::new(Arc::clone(it))).collect();
        let outputs = Arc::new(Readers::new(self.outputs.clone(), self.journals));
        let (keeper, keeping) = match self.state_files.is_empty() {
            true => (None, None),
            false => {
                let (paths, outputs) = (self.state_files.clone(), Arc::clone(&outputs));
                let (keeper, thread) = Keeper::start(paths, outputs, Arc::clone(&clock))?;
                (Some(keeper), Some(thread))
            }
        };
        let processors = sched_getaffinity(None).ok();
        let shared = Arc::new(self.share(twins, clock, outputs, keeper));
        let mut handle = FleetHandle {
            shared: Arc::clone(&shared),
            receivers: Mutex::new(receivers),
            solvers: Vec::new(),
            keeping,
            sensing: None,
            real_time: RealTimeGrants::default(),
            is_stopped: false,
        };
        let told = Arc::clone(&shared);
        let background = &shared.background;
        // Nothing waits for its end, because it gets only the time that no other thread wants.
        background.start(processors, move || told.wake_one())?;
        let (sender, grants) = sync_channel(self.threads);
        for number in 0..self.threads {
            let (shared, sender) = (Arc::clone(&shared), sender.clone());
            let real_time = self.real_time.clone();
            let solver = thread::Builder::new()
                .name(SOLVER_THREAD.to_owned())
                .stack_size(THREAD_STACK)
                .spawn(move || {
                    let grants = real_time::request(&real_time);
                    let urgency = Urgency::of(&real_time, &grants);
                    let _ = sender.try_send(grants); // there is room for each
                    shared.work(number, urgency);
                })?;
            handle.solvers.push(solver);
        }
        handle.real_time = grants.recv_timeout(ANSWER_TIMEOUT).unwrap_or_default();
        if let Some(sensors) = self.sensors {
            let reserved = &self.real_time.processors;
            handle.sensing = Some(FleetSensing::start(sensors, &shared, reserved, processors)?);
        }
        Ok(handle)
    }

    /// What the threads will share.
    fn share(
        &self,
        twins: Vec<Twin>,
        clock: Arc<dyn Clock>,
        outputs: Arc<Readers>,
        keeper: Option<Arc<Keeper>>,
    ) -> Shared {
        let (now, columns) = (clock.now(), twins.len());
        let mut agreed = Agreed::new(columns, self.max_requests);
        for column in 0..columns {
            // Its first status, and what is to be computed for it.
            let plan = Plan {
                deadline: Some(now),
                ..Plan::default()
            };
            agreed.schedule.plan(column as u32, plan);
        }
        let notifiers: Box<[Arc<Notifier>]> = (0..self.threads).map(|_| Arc::default()).collect();
        notifiers.iter().for_each(|it| clock.serve(it));
        let parameters = |twin: &Twin| RwLock::new(Arc::clone(twin.parameters()));
        let slot = |twin| Mutex::new(Slot::new(twin, self.upkeep));
        Shared {
            parameters: twins.iter().map(parameters).collect(),
            slots: twins.into_iter().map(slot).collect(),
            agreed: Mutex::new(agreed),
            inbox: ArrayQueue::new(self.max_requests),
            notifiers,
            waiting: AtomicU64::new(0),
            clock,
            stop: AtomicBool::new(false),
            outputs,
            keeper,
            upkeep: self.upkeep,
            max_requests: self.max_requests,
            background: Arc::new(Background::new(columns)),
            news: self.sensors.as_ref().map(Sensors::news),
            counters: Counters {
                active: AtomicUsize::new(columns),
                ..Counters::default()
            },
        }
    }
}

/// A fleet that runs in its own threads. Dropping the handle stops it.
pub struct FleetHandle {
    shared: Arc<Shared>,
    /// The ends of the queues to further readers, until they are taken.
    receivers: Mutex<Vec<Receiver>>,
    solvers: Vec<JoinHandle<()>>,
    keeping: Option<JoinHandle<()>>,
    /// `None` without sensors.
    sensing: Option<FleetSensing>,
    real_time: RealTimeGrants,
    is_stopped: bool,
}

impl fmt::Debug for FleetHandle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut it = f.debug_struct("FleetHandle");
        it.field("columns", &self.columns())
            .field("threads", &self.solvers.len())
            .finish_non_exhaustive()
    }
}

impl FleetHandle {
    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.shared.slots.len()
    }

    /// The outputs for the further reader with this name; `None` if there is no such queue, or its receiver was taken before.
    pub fn outputs(&self, name: &str) -> Option<Receiver> {
        let receivers = self.receivers.lock();
        let mut receivers = receivers.unwrap_or_else(PoisonError::into_inner);
        let index = receivers.iter().position(|it| it.name() == name)?;
        Some(receivers.swap_remove(index))
    }

    /// Submits a command to a column without waiting for the outcome, which is among the outputs.
    ///
    /// # Errors
    /// The queue of commands is full.
    ///
    /// # Panics
    /// There is no column with this index.
    pub fn submit(&self, column: u32, command: Command) -> Result<(), Rejection> {
        self.check(column);
        let reply = Reply::none();
        self.shared
            .submit(column, Request::Command { command, reply })
    }

    /// Submits a command to a column and waits for the outcome.
    ///
    /// # Errors
    /// The command is rejected, or the solver does not answer in time.
    ///
    /// # Panics
    /// There is no column with this index.
    pub fn execute(&self, column: u32, command: Command) -> Result<Accepted, Rejection> {
        self.ask(column, |reply| Request::Command { command, reply })?
    }

    /// Whether a column would take this impact now, with what the command leaves open; its stamp counts only if it is not ahead
    /// of the clock.
    ///
    /// # Errors
    /// The impact would be rejected, or the solver does not answer in time.
    ///
    /// # Panics
    /// There is no column with this index.
    pub fn check_impact(&self, column: u32, command: ImpactCommand) -> Result<Striking, Rejection> {
        let command = Box::new(command);
        self.ask(column, |reply| Request::Check { command, reply })?
    }

    /// Predicts the outcome of an impact on a column in its current state, in the thread of the caller.
    ///
    /// # Errors
    /// The impact would be rejected, its response cannot be computed, or the solver does not answer in time.
    ///
    /// # Panics
    /// There is no column with this index.
    pub fn predict(
        &self,
        column: u32,
        vehicle: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Rejection> {
        self.snapshot(column)?
            .predict("", vehicle, impact, &monotonic_nanos)
    }

    /// Asks the thread of the lowest priority for the second opinion on a prediction, which it gives to `reply`; it drops `reply` when
    /// the columns stop. `false` if too many wait.
    pub fn ask_opinion(&self, task: OpinionTask, reply: OpinionReply) -> bool {
        self.shared.background.ask(task, reply)
    }

    /// A copy of the current state of a column.
    ///
    /// # Errors
    /// The solver does not answer in time.
    ///
    /// # Panics
    /// There is no column with this index.
    pub fn snapshot(&self, column: u32) -> Result<ColumnSnapshot, Rejection> {
        self.ask(column, |reply| Request::Snapshot { reply })
    }

    /// The parameters of a column that hold; a change that waits for the end of a response is not among them yet.
    ///
    /// # Panics
    /// There is no column with this index.
    #[must_use]
    pub fn parameters(&self, column: u32) -> Arc<Parameters> {
        let latest = self.shared.parameters[column as usize].read();
        Arc::clone(&latest.unwrap_or_else(PoisonError::into_inner))
    }

    fn ask<T>(
        &self,
        column: u32,
        request: impl FnOnce(Reply<T>) -> Request,
    ) -> Result<T, Rejection> {
        self.check(column);
        self.shared.ask(column, request)
    }

    fn check(&self, column: u32) {
        assert!((column as usize) < self.columns(), "a column of the fleet");
    }

    /// Where the measurements of the columns go; `None` without sensors.
    #[must_use]
    pub fn measurements(&self) -> Option<&FleetMeasurements> {
        self.sensing.as_ref().map(|it| &it.measurements)
    }

    /// What was counted of the sensing since the start; `None` without sensors.
    #[must_use]
    pub fn sensing_statistics(&self) -> Option<SensingStatistics> {
        self.sensing.as_ref().map(FleetSensing::statistics)
    }

    fn lost_estimates(&self) -> u64 {
        if let Some(sensing) = &self.sensing {
            return sensing.lost_estimates();
        }
        0
    }

    /// Statistics since the start, of all columns together.
    #[must_use]
    pub fn statistics(&self) -> LiveStatistics {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let shared = &self.shared;
        let mut queues = vec![QueueStats {
            name: "inputs".to_owned(),
            capacity: shared.max_requests,
            len: shared.counters.waiting_requests.load(Ordering::Relaxed),
            when_full: WhenFull::Reject,
            pushed: read(&shared.counters.submitted),
            dropped: read(&shared.counters.rejected),
        }];
        queues.extend(shared.outputs.stats());
        queues.extend(shared.keeper.as_ref().map(|it| it.stats()));
        queues.extend(
            self.measurements()
                .into_iter()
                .flat_map(FleetMeasurements::stats),
        );
        LiveStatistics {
            cycles: read(&shared.counters.jobs),
            overruns: read(&shared.counters.overruns),
            skipped_periods: read(&shared.counters.skipped_periods),
            worst_lateness: read(&shared.counters.worst_lateness),
            steps: read(&shared.counters.steps),
            newton_iterations: read(&shared.counters.newton_iterations),
            state_file_failures: shared.keeper.as_ref().map_or(0, |it| it.failures()),
            lost_estimates: self.lost_estimates(),
            queues,
            real_time: self.real_time.clone(),
        }
    }

    /// Whether the damage of this column is still to be written, and that of few others.
    #[must_use]
    pub fn is_saving(&self, column: u32) -> bool {
        let keeper = self.shared.keeper.as_ref();
        keeper.is_some_and(|it| it.is_saving(column))
    }

    /// State files written since the start.
    #[must_use]
    pub fn states_written(&self) -> u64 {
        self.shared.keeper.as_ref().map_or(0, |it| it.written())
    }

    /// Columns that respond to an impact, or have something else to do soon.
    #[must_use]
    pub fn active(&self) -> usize {
        self.shared.counters.active.load(Ordering::Relaxed)
    }

    /// Columns at rest whose critical velocities are not computed yet.
    #[must_use]
    pub fn without_critical_velocities(&self) -> usize {
        self.shared.background.unknown()
    }

    /// Number of solver threads.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.shared.notifiers.len()
    }

    /// Whether all solver threads run. Before a stop one ends only if it panics.
    #[must_use]
    pub fn is_running(&self) -> bool {
        !self.solvers.iter().any(JoinHandle::is_finished)
    }

    /// Stops, and returns the final statistics. The damage of every column that was hit is saved, of one that is responding the
    /// predicted damage. A [`Notice`](crate::twin::Notice) lists what is lost nevertheless. Queued outputs can still be received.
    ///
    /// # Errors
    /// A thread panicked.
    pub fn stop(mut self) -> Result<LiveStatistics, Panicked> {
        self.join()?;
        Ok(self.statistics())
    }

    fn join(&mut self) -> Result<(), Panicked> {
        if std::mem::replace(&mut self.is_stopped, true) {
            return Ok(());
        }
        // First, because its estimates are commands to the solvers.
        let sensing = self.sensing.as_mut().map_or(Ok(()), FleetSensing::stop);
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.background.stop();
        self.shared.wake_all();
        let ended = std::mem::take(&mut self.solvers).into_iter();
        // All of them are joined, whatever one returns.
        let panicked = ended.map(JoinHandle::join).filter(Result::is_err).count();
        self.shared.finish();
        if let Some(keeper) = &self.shared.keeper {
            keeper.stop();
        }
        let keeping = self.keeping.take().is_none_or(|it| it.join().is_ok());
        match (panicked, keeping) {
            (1.., _) => Err(Panicked(SOLVER_THREAD)),
            (_, false) => Err(Panicked(STATE_WRITER_THREAD)),
            (0, true) => sensing,
        }
    }
}

impl Drop for FleetHandle {
    fn drop(&mut self) {
        let _ = self.join(); // a thread that panicked has printed its message
    }
}
