//! The twin in real time: clocks, deadlines, bounded queues, the solver's thread.
//!
//! The solver's thread waits for absolute deadlines; when it is late it skips whole periods, counts them, and makes up
//! for their steps, so that no sample is lost. While a response runs it takes no lock and no memory and writes no log:
//! what leaves the twin goes into bounded queues without locks, and a slow reader loses its own samples, counted. The
//! forecast is computed in slices between the deadlines. A what-if runs in the thread of whoever asks. The state file
//! is written by a thread of its own.

mod clock;
mod inbox;
mod lateness;
mod notifier;
pub(crate) mod queue;
mod real_time;
mod solver;
mod state_writer;

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use thiserror::Error;

pub use clock::{Clock, SimClock, SystemClock, monotonic_nanos};
pub use inbox::MAX_COMMANDS;
pub use lateness::{Lateness, lateness};
pub use notifier::Notifier;
pub use queue::{OutputQueue, OutputSource, QueueStats, Receiver, WhenFull};
pub use real_time::{Grant, RealTime, RealTimeGrants, ask_for_sender};
pub use solver::SOLVER_THREAD;
pub use state_writer::STATE_WRITER_THREAD;

use crate::column::ImpactSpecification;
use crate::parameters::Parameters;
use crate::twin::{Accepted, ColumnSnapshot, Command, Prediction, Refusal, RefusalCode, Twin};
use inbox::{Reply, Request};
use queue::OutputQueues;
use solver::{Shared, Sink, Solver};
use state_writer::StateWriter;

/// How long an answer of the solver is waited for.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// How a twin is to live.
#[derive(Debug, Clone)]
pub struct LiveOptions {
    /// What to ask the system for.
    pub real_time: RealTime,
    /// Where the damage is kept, see [`state_file::path`](crate::twin::state_file::path); `None`: nowhere.
    pub state_file: Option<PathBuf>,
    /// Who reads what leaves the twin.
    pub outputs: Vec<OutputQueue>,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            real_time: RealTime::default(),
            state_file: None,
            outputs: vec![OutputQueue::ros()],
        }
    }
}

/// A thread of the twin panicked; its message is on the standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("thread {0} panicked; please report the message on the standard error")]
pub struct Panicked(&'static str);

/// How the live twin does.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveStatistics {
    /// Turns of the solver's thread.
    pub turns: u64,
    /// Turns that began a whole period late, or more.
    pub overruns: u64,
    /// Periods that were skipped by then.
    pub skipped_periods: u64,
    /// Largest lateness of a turn after its deadline \[ns\].
    pub worst_lateness: u64,
    /// Steps of all responses.
    pub steps: u64,
    /// Newton iterations of these steps.
    pub newton_iterations: u64,
    /// State files that could not be written.
    pub state_file_failures: u64,
    /// Every queue.
    pub queues: Vec<QueueStats>,
    /// What the system granted.
    pub real_time: RealTimeGrants,
}

/// Starts twins.
pub struct Live;

impl Live {
    /// Starts the solver's thread, and the one that keeps the damage.
    ///
    /// # Errors
    /// The system gives no thread.
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
        let sink = Sink {
            queues,
            state_writer,
            parameters,
            unheard: false,
        };
        let solver = Solver {
            twin,
            clock,
            shared,
            sink,
        };
        let (told, grants) = sync_channel(1);
        let wishes = options.real_time;
        handle.solver = Some(
            thread::Builder::new()
                .name(SOLVER_THREAD.to_owned())
                .spawn(move || {
                    let _ = told.try_send(real_time::ask(&wishes)); // there is room for one
                    solver.run();
                })?,
        );
        handle.real_time = grants.recv_timeout(ANSWER_WITHIN).unwrap_or_default();
        Ok(handle)
    }
}

/// A twin that lives in its own thread. Dropped, it stops.
#[derive(Debug)]
pub struct LiveHandle {
    shared: Arc<Shared>,
    queues: Vec<Arc<OutputQueues>>,
    receivers: Mutex<Vec<Receiver>>,
    state_writer: Option<(Arc<StateWriter>, JoinHandle<()>)>,
    solver: Option<JoinHandle<()>>,
    real_time: RealTimeGrants,
    parameters: Arc<RwLock<Arc<Parameters>>>,
}

impl LiveHandle {
    /// Gives the twin a command without waiting for the outcome, which comes with the outputs.
    ///
    /// # Errors
    /// Too many commands wait already.
    pub fn submit(&self, command: Command) -> Result<(), Refusal> {
        self.shared.inbox.submit(Request::Command {
            command,
            reply: Reply::none(),
        })
    }

    /// Gives the twin a command and waits for the outcome.
    ///
    /// # Errors
    /// The command is refused, or there is no answer in time.
    pub fn execute(&self, command: Command) -> Result<Accepted, Refusal> {
        self.ask(|reply| Request::Command { command, reply })?
    }

    fn ask<T>(&self, request: impl FnOnce(Reply<T>) -> Request) -> Result<T, Refusal> {
        let (reply, answer) = Reply::channel();
        self.shared.inbox.submit(request(reply))?;
        answer.wait(ANSWER_WITHIN).map_err(|_| {
            let reason = format!(
                "the solver did not answer within {} s; the command may still be executed, see twin_status",
                ANSWER_WITHIN.as_secs()
            );
            Refusal::new(RefusalCode::NoAnswer, reason)
        })
    }

    /// The outputs for the reader of this name; `None` where there is none, or it was taken before.
    pub fn outputs(&self, name: &str) -> Option<Receiver> {
        let mut receivers = self
            .receivers
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let index = receivers.iter().position(|it| it.name() == name)?;
        Some(receivers.swap_remove(index))
    }

    /// The parameters as they were last set; those that wait for the end of a response count as set, until they are
    /// refused then.
    #[must_use]
    pub fn parameters(&self) -> Arc<Parameters> {
        let latest = self.parameters.read();
        Arc::clone(&latest.unwrap_or_else(PoisonError::into_inner))
    }

    /// A copy of the column as it is now.
    ///
    /// # Errors
    /// There is no answer in time.
    pub fn snapshot(&self) -> Result<ColumnSnapshot, Refusal> {
        self.ask(|reply| Request::Look { reply })
    }

    /// What an impact would do to the column as it is now, computed in the caller's thread. An empty `column_id` means
    /// the twin's own.
    ///
    /// # Errors
    /// The impact would be refused, its response cannot be computed, or there is no answer in time.
    pub fn predict(
        &self,
        column_id: &str,
        impact: &ImpactSpecification,
    ) -> Result<Prediction, Refusal> {
        self.snapshot()?
            .predict(column_id, impact, &monotonic_nanos)
    }

    /// How the twin does.
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
        LiveStatistics {
            turns: read(&shared.turns),
            overruns: read(&shared.overruns),
            skipped_periods: read(&shared.skipped_periods),
            worst_lateness: read(&shared.worst_lateness),
            steps: read(&shared.steps),
            newton_iterations: read(&shared.newton_iterations),
            state_file_failures: state_writer.map_or(0, |it| it.failures()),
            queues,
            real_time: self.real_time.clone(),
        }
    }

    /// Whether the solver's thread runs; without a stop it ends by a panic only.
    pub fn is_running(&self) -> bool {
        self.solver
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Stops within a second: the damage is kept, that of a response under way as it is forecast. What is lost all the
    /// same is said in one [`Notice`](crate::twin::Notice). What has left the twin can still be received; the statistics are
    /// the last.
    ///
    /// # Errors
    /// A thread had ended by a panic.
    pub fn stop(mut self) -> Result<LiveStatistics, Panicked> {
        self.join()?;
        Ok(self.statistics())
    }

    fn join(&mut self) -> Result<(), Panicked> {
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
        match (solver, state_writer) {
            (false, _) => Err(Panicked(SOLVER_THREAD)),
            (_, false) => Err(Panicked(STATE_WRITER_THREAD)),
            (true, true) => Ok(()),
        }
    }
}

impl Drop for LiveHandle {
    fn drop(&mut self) {
        let _ = self.join(); // a panic has been written by its thread
    }
}
