//! What the solver threads share: the columns, what is to be done next, and the ways in and out.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, TryLockError};

use crossbeam_queue::ArrayQueue;

use super::background::{Background, Known, Wanted};
use super::fleet_news::FleetNews;
use super::keeper::Keeper;
use super::readers::Readers;
use super::schedule::Schedule;
use super::watch::Watch;
use crate::live::clock::Clock;
use crate::live::inbox::{ANSWER_TIMEOUT, Reply, Request};
use crate::live::notifier::Notifier;
use crate::live::real_time::Patience;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{BackgroundKind, Rejection, RejectionCode, SolverStatistics, Twin};

/// What a column is told.
#[derive(Debug)]
pub enum Input {
    Request(Box<(u32, Request)>),
    /// What was computed for it in the background.
    Known(Box<Known>),
}

/// What the threads agree about, held only to choose a job, and only with the priority of real time: a thread of normal priority
/// may lose its processor while others wait for the lock.
pub struct Agreed {
    pub schedule: Schedule<Input>,
    pub watch: Watch,
    /// The latest time of the clock.
    pub latest: Option<Nanos>,
    /// How often the clock has jumped back, and how far at last.
    pub jumps: u64,
    pub last_jump: u64,
}

/// What a column does by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upkeep {
    /// It says once per second how it is, its journal begins with the program, and it is saved at the stop.
    Constant,
    /// One of many, to most of which nothing ever happens: at rest it does nothing, and forgets what no event can need any more. Until
    /// its first command it has no journal, and it is not saved.
    OnDemand,
}

/// A column in the pool.
pub struct Slot {
    pub twin: Twin,
    /// Jumps of the clock that it knows.
    pub jumps: u64,
    /// What is being computed for it in the background, by its kind. The critical velocities of a column that was hit do not wait
    /// for those of before.
    pub wanted: [Option<Arc<Wanted>>; BackgroundKind::COUNT],
    /// Its journal is wanted, and it is saved at the stop.
    pub is_touched: bool,
    /// It was on time when its next deadline was set, so that a delay is one of the solver.
    pub is_on_time: bool,
    /// What its solver has done, as it was counted last.
    pub counted: SolverStatistics,
    /// With its forecast.
    pub patience: Patience,
}

impl Slot {
    pub fn new(twin: Twin, upkeep: Upkeep) -> Self {
        Self {
            twin,
            jumps: 0,
            wanted: [const { None }; BackgroundKind::COUNT],
            is_touched: upkeep == Upkeep::Constant,
            is_on_time: false,
            counted: SolverStatistics::default(),
            patience: Patience::default(),
        }
    }
}

impl Agreed {
    /// For so many columns and requests.
    pub fn new(columns: usize, requests: usize) -> Self {
        Self {
            // Each column has at most one result of each kind, besides what is requested.
            schedule: Schedule::new(columns, requests + BackgroundKind::COUNT * columns),
            watch: Watch::default(),
            latest: None,
            jumps: 0,
            last_jump: 0,
        }
    }
}

#[derive(Debug, Default)]
pub struct Counters {
    /// See [`Schedule::active`], for threads that must not take the lock.
    pub active: AtomicUsize,
    pub jobs: AtomicU64,
    pub overruns: AtomicU64,
    pub skipped_periods: AtomicU64,
    pub worst_lateness: AtomicU64,
    pub steps: AtomicU64,
    pub newton_iterations: AtomicU64,
    /// Locks for which a solver thread had to wait.
    pub contended_locks: AtomicU64,
    /// Requests that are taken and not begun.
    pub waiting_requests: AtomicUsize,
    pub submitted: AtomicU64,
    pub rejected: AtomicU64,
}

/// What the threads share.
pub struct Shared {
    pub slots: Box<[Mutex<Slot>]>,
    pub agreed: Mutex<Agreed>,
    /// Requests from other threads, without a lock, until a solver thread puts them into the schedule.
    pub inbox: ArrayQueue<Box<(u32, Request)>>,
    /// One for each solver thread.
    pub notifiers: Box<[Arc<Notifier>]>,
    /// One bit for each solver thread that waits.
    pub waiting: AtomicU64,
    pub clock: Arc<dyn Clock>,
    pub stop: AtomicBool,
    pub outputs: Arc<Readers>,
    pub keeper: Option<Arc<Keeper>>,
    pub upkeep: Upkeep,
    /// Most requests that wait; more are rejected.
    pub max_requests: usize,
    pub parameters: Box<[RwLock<Arc<Parameters>>]>,
    pub background: Arc<Background>,
    /// News for the threads that detect impacts; `None` without sensors.
    pub news: Option<FleetNews>,
    pub counters: Counters,
}

impl Shared {
    /// Wakes a thread that waits, if there is one: the others look for themselves when they have done their job.
    pub fn wake_one(&self) {
        let waiting = self.waiting.load(Ordering::SeqCst);
        if waiting != 0
            && let Some(notifier) = self.notifiers.get(waiting.trailing_zeros() as usize)
        {
            notifier.notify();
        }
    }

    /// Passes a request on, unless there is no room.
    pub fn submit(&self, column: u32, request: Request) -> Result<(), Rejection> {
        let counters = &self.counters;
        counters.submitted.fetch_add(1, Ordering::Relaxed);
        // The requests in the schedule count, too: otherwise a sender that never pauses would fill the memory and keep the thread
        // that takes its requests from everything else.
        let most = self.max_requests;
        let has_room = counters.waiting_requests.fetch_add(1, Ordering::Relaxed) < most;
        let is_taken = has_room && self.inbox.push(Box::new((column, request))).is_ok();
        self.wake_one();
        if is_taken {
            return Ok(());
        }
        counters.waiting_requests.fetch_sub(1, Ordering::Relaxed);
        counters.rejected.fetch_add(1, Ordering::Relaxed);
        let whose = match self.upkeep {
            Upkeep::Constant => "the solver",
            Upkeep::OnDemand => "the fleet's solvers",
        };
        let reason = format!(
            "the queue of {whose} is full ({most} commands); try again, or send fewer events and parameter changes"
        );
        Err(Rejection::new(RejectionCode::QueueFull, reason))
    }

    /// Submits a request and waits for its answer.
    ///
    /// # Errors
    /// The queue is full, or the solver does not answer in time.
    pub fn ask<T>(
        &self,
        column: u32,
        request: impl FnOnce(Reply<T>) -> Request,
    ) -> Result<T, Rejection> {
        let (reply, answer) = Reply::channel();
        self.submit(column, request(reply))?;
        answer
            .wait(ANSWER_TIMEOUT)
            .map_err(|_| Rejection::no_answer(ANSWER_TIMEOUT.as_secs()))
    }

    pub fn wake_all(&self) {
        self.notifiers.iter().for_each(|it| it.notify());
    }

    pub fn agreed(&self) -> MutexGuard<'_, Agreed> {
        self.locked(&self.agreed)
    }

    /// Takes a lock, and counts it where another thread has it.
    pub fn locked<'a, T>(&self, lock: &'a Mutex<T>) -> MutexGuard<'a, T> {
        match lock.try_lock() {
            Ok(guard) => guard,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                let contended = &self.counters.contended_locks;
                contended.fetch_add(1, Ordering::Relaxed);
                lock.lock().unwrap_or_else(PoisonError::into_inner)
            }
        }
    }

    /// Whether there is something that no thread has put into the schedule.
    pub fn has_news(&self) -> bool {
        !self.inbox.is_empty() || self.background.has_results() || self.stop.load(Ordering::SeqCst)
    }
}
