//! A solver thread of a fleet: takes the most urgent job, does it, and says what the column needs next.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

use crossbeam_queue::ArrayQueue;

use super::super::clock::{Clock, monotonic_nanos};
use super::super::inbox::Request;
use super::super::lateness::lateness;
use super::super::notifier::Notifier;
use super::super::real_time::{Patience, Urgency};
use super::super::solver::{MAX_CLOCK_STEP_BACK, MAX_CYCLES_COMPLETING, MAX_STEPS_AT_STOP};
use super::background::{Background, Known};
use super::keeper::Keeper;
use super::readers::Readers;
use super::schedule::{Job, Plan, Schedule};
use super::watch::Watch;
use crate::parameters::MAX_COLUMNS;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{
    Accepted, BackgroundKind, Command, NoticeLevel, Output, Outputs, Refusal, RefusalCode, Twin,
};

/// Maximum number of requests to the columns of a fleet that wait; more are rejected. All columns may be hit at once.
pub const MAX_FLEET_COMMANDS: usize = 2 * MAX_COLUMNS;

/// Steps of a forecast, and of what is not urgent, in one job: less than 0.1 ms, after which inputs of other columns come first.
const SLICE: u64 = 64;

/// How often a thread looks whether the clock was set while no column responds \[ns\]: what other threads stamp would be wrong
/// until the next impact.
const CLOCK_CHECK_PERIOD: Nanos = 1_000_000_000;

/// Maximum number of solver threads: one bit for each in the mask of those that wait.
pub const MAX_THREADS: usize = 64;

/// What a column is told.
#[derive(Debug)]
pub enum Input {
    Request(Request),
    /// What was computed for it in the background.
    Known(Box<Known>),
}

/// A column of the fleet in the pool.
pub struct Slot {
    pub twin: Twin,
    /// Jumps of the clock that it knows.
    jumps: u64,
    /// What is being computed for it in the background, by its kind. The critical velocities of a column that was hit do not wait
    /// for those of before.
    is_wanted: [bool; BackgroundKind::COUNT],
    /// It has executed a command since the start.
    is_touched: bool,
    /// With its forecast.
    patience: Patience,
}

impl Slot {
    pub fn new(twin: Twin) -> Self {
        Self {
            twin,
            jumps: 0,
            is_wanted: [false; BackgroundKind::COUNT],
            is_touched: false,
            patience: Patience::default(),
        }
    }
}

/// What the threads agree about, held only to choose a job, and only with the priority of real time: a thread of normal priority
/// may lose its processor while others wait for the lock.
pub struct Agreed {
    pub schedule: Schedule<Input>,
    watch: Watch,
    /// The latest time of the clock.
    latest: Option<Nanos>,
    /// How often the clock has jumped back, and how far at last.
    jumps: u64,
    last_jump: u64,
}

/// A job, and what the clock has done until it was taken.
struct Task {
    column: u32,
    job: Job<Input>,
    jumps: u64,
    last_jump: u64,
}

impl Agreed {
    pub fn new() -> Self {
        Self {
            schedule: Schedule::new(),
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
    /// Requests that are taken and not begun.
    pub waiting_requests: AtomicUsize,
    pub submitted: AtomicU64,
    pub rejected: AtomicU64,
}

/// What the threads of a fleet share.
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
    /// Whether the outputs have the journals of the columns.
    pub journals: bool,
    pub parameters: Box<[RwLock<Arc<Parameters>>]>,
    pub background: Arc<Background>,
    /// News for the threads that feel impacts; `None` without sensors.
    #[cfg(feature = "study")]
    pub news: Option<super::fleet_news::FleetNews>,
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
    pub fn submit(&self, column: u32, request: Request) -> Result<(), Refusal> {
        let counters = &self.counters;
        counters.submitted.fetch_add(1, Ordering::Relaxed);
        // The requests in the schedule count, too: otherwise a sender that never pauses would fill the memory and keep the thread
        // that takes its requests from everything else.
        let has_room =
            counters.waiting_requests.fetch_add(1, Ordering::Relaxed) < MAX_FLEET_COMMANDS;
        let is_taken = has_room && self.inbox.push(Box::new((column, request))).is_ok();
        self.wake_one();
        if is_taken {
            return Ok(());
        }
        counters.waiting_requests.fetch_sub(1, Ordering::Relaxed);
        counters.rejected.fetch_add(1, Ordering::Relaxed);
        let reason = format!(
            "the queue of the fleet's solvers is full ({MAX_FLEET_COMMANDS} commands); try again, or send fewer events and \
             parameter changes"
        );
        Err(Refusal::new(RefusalCode::QueueFull, reason))
    }

    pub fn wake_all(&self) {
        self.notifiers.iter().for_each(|it| it.notify());
    }

    fn agreed(&self) -> MutexGuard<'_, Agreed> {
        self.agreed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn has_news(&self) -> bool {
        !self.inbox.is_empty() || self.background.has_results() || self.stop.load(Ordering::SeqCst)
    }

    /// The content of solver thread number `me`, with its priority.
    pub fn work(&self, me: usize, mut urgency: Urgency) {
        while let Some(task) = self.next_task(me) {
            let (column, jumps) = (task.column, task.jumps);
            let mut plan = self.perform(task, &mut urgency);
            let mut agreed = self.agreed();
            if agreed.jumps != jumps {
                // The clock was set back while this thread worked, so that the deadline is one of before.
                plan.deadline = plan.deadline.map(|_| Nanos::MIN);
            }
            agreed.schedule.give_back(column, plan);
            self.note_active(&agreed);
        }
        // The others may wait for this thread to watch the deadlines.
        self.wake_all();
    }

    /// Waits for the next job; `None` at a stop.
    fn next_task(&self, me: usize) -> Option<Task> {
        let bit = 1_u64 << me;
        loop {
            let mut agreed = self.agreed();
            self.waiting.fetch_and(!bit, Ordering::SeqCst);
            agreed.watch.leave(me);
            if self.stop.load(Ordering::SeqCst) {
                return None;
            }
            // While nothing responds, a clock that has been set may jump, before anything is judged by it. The thread that watches
            // would wake too late.
            if agreed.schedule.is_at_rest() && self.clock.resynchronise() {
                agreed.watch = Watch::default();
            }
            let now = self.clock.now();
            self.take_news(&mut agreed, now);
            self.note_active(&agreed);
            if let Some((column, job)) = agreed.schedule.take(now) {
                if matches!(job, Job::Input(Input::Request(_))) {
                    self.counters
                        .waiting_requests
                        .fetch_sub(1, Ordering::Relaxed);
                }
                let task = Task {
                    column,
                    job,
                    jumps: agreed.jumps,
                    last_jump: agreed.last_jump,
                };
                let next = agreed.schedule.next_deadline();
                let is_unwatched = next.is_some_and(|it| !agreed.watch.covers(it));
                let others_can_help = is_unwatched || agreed.schedule.has_work(now);
                drop(agreed);
                if others_can_help {
                    self.wake_one();
                }
                return Some(task);
            }
            self.waiting.fetch_or(bit, Ordering::SeqCst);
            let next = agreed.schedule.next_deadline();
            let check = now.saturating_add(CLOCK_CHECK_PERIOD);
            let next = match agreed.schedule.is_at_rest() {
                true => Some(next.map_or(check, |it| it.min(check))),
                false => next,
            };
            let deadline = agreed.watch.wait(me, next);
            drop(agreed);
            // What came after it was looked for has seen this thread wait, or is seen here.
            if self.has_news() {
                continue;
            }
            let deadline = deadline.unwrap_or(Nanos::MAX);
            self.clock.wait_for_news(deadline, &self.notifiers[me]);
        }
    }

    fn note_active(&self, agreed: &Agreed) {
        let active = agreed.schedule.active();
        self.counters.active.store(active, Ordering::Relaxed);
    }

    fn take_news(&self, agreed: &mut Agreed, now: Nanos) {
        let back = agreed
            .latest
            .replace(now)
            .unwrap_or(now)
            .saturating_sub(now);
        if back > MAX_CLOCK_STEP_BACK {
            agreed.jumps += 1;
            agreed.last_jump = back.unsigned_abs();
            agreed.schedule.make_all_due();
        }
        while let Some(request) = self.inbox.pop() {
            let (column, request) = *request;
            agreed.schedule.add_input(column, Input::Request(request));
        }
        while let Some(known) = self.background.take() {
            agreed.schedule.add_input(known.0, Input::Known(known));
        }
    }

    /// Does a job; what the column needs next. What is computed ahead has normal priority, all else that of real time: see
    /// [`Urgency`].
    fn perform(&self, task: Task, urgency: &mut Urgency) -> Plan {
        let Task {
            column,
            job,
            jumps,
            last_jump,
        } = task;
        let slot = &self.slots[column as usize];
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        let slot = &mut *slot;
        let mut sink = self.sink(column, slot);
        self.counters.jobs.fetch_add(1, Ordering::Relaxed);
        let now = self.clock.now();
        if slot.jumps != jumps {
            slot.jumps = jumps;
            let command = Command::ClockJumpedBack { by: last_jump };
            // The twin takes it in every state.
            let _ = execute(slot, command, now, &mut sink);
        }
        match job {
            Job::Input(input) => self.take_input(slot, input, &mut sink),
            Job::Forecast | Job::Spare => self.run_ahead(slot, now, urgency, &mut sink),
            Job::Advance(deadline) => {
                self.note_lateness(slot, deadline, now);
                slot.twin.advance_to(now, &mut sink);
            }
        }
        sink.notify();
        self.plan_of(column, slot)
    }

    /// Carries on what is computed ahead, by one slice.
    fn run_ahead(&self, slot: &mut Slot, now: Nanos, urgency: &mut Urgency, sink: &mut Sink<'_>) {
        let awaits_forecast = slot.twin.awaits_forecast();
        if slot.patience.lasts(awaits_forecast, monotonic_nanos()) {
            urgency.relax();
        }
        slot.twin.run_ahead(SLICE, now, sink);
        // At once, because a reader of the forecast would otherwise wait for the lock.
        sink.notify();
        if let Err(reason) = urgency.restore() {
            sink.notice(NoticeLevel::Warning, now, reason);
        }
    }

    fn take_input(&self, slot: &mut Slot, input: Input, sink: &mut Sink<'_>) {
        // An impact would be earlier than the response that is carried to its end after a jump of the clock.
        for _ in 0..MAX_CYCLES_COMPLETING {
            if !slot.twin.is_completing() {
                break;
            }
            slot.twin.advance_to(self.clock.now(), sink);
        }
        let now = self.clock.now();
        match input {
            Input::Request(Request::Command { command, reply }) => {
                slot.is_touched = true;
                sink.has_journal = self.journals;
                reply.send(execute(slot, command, now, sink));
            }
            Input::Request(Request::Check { command, reply }) => {
                reply.send(slot.twin.check_impact(&command, now));
            }
            Input::Request(Request::Snapshot { reply }) => reply.send(slot.twin.snapshot()),
            Input::Known(known) => {
                let (_, task, command) = *known;
                slot.is_wanted[task.kind() as usize] = false;
                if slot.twin.awaits(&task) {
                    // The twin takes it in every state.
                    let _ = execute(slot, command, now, sink);
                }
            }
        }
        slot.twin.advance_to(now, sink);
    }

    fn note_lateness(&self, slot: &Slot, deadline: Nanos, now: Nanos) {
        if !slot.twin.is_responding() || deadline == Nanos::MIN {
            return;
        }
        let late = lateness(deadline, slot.twin.period(), now);
        let counters = &self.counters;
        late.count(
            &counters.worst_lateness,
            &counters.overruns,
            &counters.skipped_periods,
        );
    }

    fn plan_of(&self, column: u32, slot: &mut Slot) -> Plan {
        let now = self.clock.now();
        let twin = &mut slot.twin;
        let is_quiet = twin.is_quiet(now);
        // The range of a verdict is wanted during the response already.
        let is_range_due = twin.awaits_range() && !slot.is_wanted[BackgroundKind::Range as usize];
        if is_quiet || is_range_due {
            for task in twin.background_tasks() {
                let is_wanted = &mut slot.is_wanted[task.kind() as usize];
                if !*is_wanted {
                    *is_wanted = self.background.want(column, task);
                }
            }
        }
        if !is_quiet {
            return Plan {
                is_responding: true,
                deadline: Some(twin.next_deadline(now)),
                forecast_left: twin.forecast_steps_left(),
                has_spare: twin.is_looking_ahead() && !twin.awaits_forecast(),
            };
        }
        twin.forget_what_is_too_old(now);
        Plan {
            deadline: twin.remembers_until().map(|it| it.saturating_add(1)),
            ..Plan::default()
        }
    }

    fn sink(&self, column: u32, slot: &Slot) -> Sink<'_> {
        Sink {
            shared: self,
            column,
            has_journal: self.journals && slot.is_touched,
            is_unnotified: false,
        }
    }

    /// Completes the forecasts of running responses, so that their damage is saved, and reports what is lost. Called when the
    /// solver threads have ended.
    pub fn finish(&self) {
        let mut lost_inputs = 0_u64;
        let mut agreed = self.agreed();
        self.take_news(&mut agreed, self.clock.now());
        self.counters.waiting_requests.store(0, Ordering::Relaxed);
        for (_, input) in agreed.schedule.take_inputs() {
            let is_command = matches!(input, Input::Request(Request::Command { .. }));
            lost_inputs += u64::from(is_command);
        }
        drop(agreed);
        let now = self.clock.now();
        for (column, slot) in (0..).zip(&self.slots) {
            let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
            if !slot.is_touched {
                continue;
            }
            let mut sink = self.sink(column, &slot);
            let twin = &mut slot.twin;
            twin.run_ahead(MAX_STEPS_AT_STOP, now, &mut sink);
            twin.abandon_forecasts(&mut sink);
            if !twin.is_responding() {
                sink.put(Output::Save(Arc::new(twin.saved_state(now))));
            }
            let lost = twin.lost_by_a_stop();
            if !lost.is_empty() {
                let text = format!("lost by the stop: {}", lost.join("; "));
                sink.notice(NoticeLevel::Error, now, text);
            }
            sink.notify();
        }
        if lost_inputs > 0 {
            let mut sink = Sink {
                shared: self,
                column: 0,
                has_journal: false,
                is_unnotified: false,
            };
            let text = format!(
                "lost by the stop: {lost_inputs} commands to columns of the fleet in the queue of the solvers"
            );
            sink.notice(NoticeLevel::Error, now, text);
            sink.notify();
        }
    }
}

/// Lets a column execute a command. What a recording needs before the command of a column at rest comes first, and what the column
/// knows of its past does not depend on when a thread had time to let it forget.
fn execute(
    slot: &mut Slot,
    command: Command,
    now: Nanos,
    sink: &mut Sink<'_>,
) -> Result<Accepted, Refusal> {
    slot.twin.forget_what_is_too_old(now);
    if sink.has_journal {
        slot.twin.demand_checkpoint();
    }
    slot.twin.handle(command, now, sink)
}

/// Passes the outputs of one column to the readers of the fleet's.
struct Sink<'a> {
    shared: &'a Shared,
    column: u32,
    /// The entries of its journal are wanted. A column that has executed no command since the start has none, so that one that is
    /// never hit costs nothing.
    has_journal: bool,
    is_unnotified: bool,
}

impl Sink<'_> {
    fn notify(&mut self) {
        if std::mem::take(&mut self.is_unnotified) {
            self.shared.outputs.notify();
        }
    }
}

impl Outputs for Sink<'_> {
    fn put(&mut self, output: Output) {
        #[cfg(feature = "study")]
        if let Some(news) = &self.shared.news
            && let Some(lost) = news.of(self.column).take(self.column, &output)
        {
            self.put(Output::Notice(lost));
        }
        match output {
            Output::Save(saved) => {
                if let Some(keeper) = &self.shared.keeper {
                    keeper.write(self.column, saved);
                }
            }
            Output::Journal(_) if !self.has_journal => {}
            output => {
                if let Output::ParametersChanged(changed) = &output {
                    let latest = self.shared.parameters[self.column as usize].write();
                    *latest.unwrap_or_else(PoisonError::into_inner) =
                        Arc::clone(&changed.parameters);
                }
                self.is_unnotified = true;
                self.shared.outputs.push_of(self.column, output);
            }
        }
    }
}
