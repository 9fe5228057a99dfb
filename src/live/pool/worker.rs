//! A solver thread: takes the most urgent job, does it, and says what the column needs next.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};

use crossbeam_queue::ArrayQueue;

use super::super::clock::{Clock, monotonic_nanos};
use super::super::inbox::{ANSWER_TIMEOUT, Reply, Request};
use super::super::lateness::lateness;
use super::super::notifier::Notifier;
use super::super::real_time::{Patience, URGENT_BEFORE_DEADLINE, Urgency};
use super::background::{Background, Known, Wanted};
use super::keeper::Keeper;
use super::readers::Readers;
use super::schedule::{BACKGROUND_SHARE, Job, Plan, Schedule};
use super::watch::Watch;
use crate::parameters::MAX_COLUMNS;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{
    Accepted, BackgroundKind, Command, NoticeLevel, Output, Outputs, Refusal, RefusalCode,
    SolverStatistics, Twin,
};

/// Maximum number of requests to the columns of a fleet that wait; more are rejected. All columns may be hit at once.
pub const MAX_FLEET_COMMANDS: usize = 2 * MAX_COLUMNS;

/// Steps that are computed ahead between two readings of the clock. What is left before a deadline and is too short for that is not
/// used; shorter slices spend a tenth of the time on reading clocks.
const SLICE: u64 = 16;

/// Steps of a forecast in one job while several columns respond: less than 0.1 ms, after which inputs of other columns come first.
const SLICE_OF_MANY: u64 = 64;

/// Steps of a forecast after each call that catches up with the clock, when samples are late anyway.
const SLICE_WHILE_BEHIND: u64 = 1_000;

/// Maximum number of steps with which a stop completes the forecast of a column: less than a second.
const MAX_STEPS_AT_STOP: u64 = 200_000;

/// A clock that goes back by at most this much is waited for; a larger jump is that of a looped recording or of a clock that
/// was set \[ns\].
pub const MAX_CLOCK_STEP_BACK: Nanos = 100_000_000;

/// A request waits for at most this many calls until a response is complete during which the clock has jumped back: less than
/// a second. Impacts that are handled before have stamps that are out of order.
const MAX_CALLS_COMPLETING: u32 = 200;

/// How often a thread looks whether the clock was set while no column responds \[ns\]: what other threads stamp would be wrong
/// until the next impact.
const CLOCK_CHECK_PERIOD: Nanos = 1_000_000_000;

/// Maximum number of solver threads: one bit for each in the mask of those that wait.
pub const MAX_THREADS: usize = 64;

/// What a column is told.
#[derive(Debug)]
pub enum Input {
    Request(Box<(u32, Request)>),
    /// What was computed for it in the background.
    Known(Box<Known>),
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
    jumps: u64,
    /// What is being computed for it in the background, by its kind. The critical velocities of a column that was hit do not wait
    /// for those of before.
    wanted: [Option<Arc<Wanted>>; BackgroundKind::COUNT],
    /// Its journal is wanted, and it is saved at the stop.
    is_touched: bool,
    /// It was on time when its next deadline was set, so that a delay is one of the solver.
    is_on_time: bool,
    /// What its solver has done, as it was counted last.
    counted: SolverStatistics,
    /// With its forecast.
    patience: Patience,
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
        Err(Refusal::new(RefusalCode::QueueFull, reason))
    }

    /// Submits a request and waits for its answer.
    ///
    /// # Errors
    /// The queue is full, or the solver does not answer in time.
    pub fn ask<T>(
        &self,
        column: u32,
        request: impl FnOnce(Reply<T>) -> Request,
    ) -> Result<T, Refusal> {
        let (reply, answer) = Reply::channel();
        self.submit(column, request(reply))?;
        answer
            .wait(ANSWER_TIMEOUT)
            .map_err(|_| Refusal::no_answer(ANSWER_TIMEOUT.as_secs()))
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
            agreed.schedule.give_back(column, plan, self.clock.now());
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
            let (deadline, notifier) = (deadline.unwrap_or(Nanos::MAX), &self.notifiers[me]);
            match self.notifiers.len() {
                // It shares its work with no other thread, and a request does not disturb the samples.
                1 => self.clock.wait_until(deadline, notifier),
                _ => self.clock.wait_for_news(deadline, notifier),
            }
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
            let column = request.0;
            agreed.schedule.add_input(column, Input::Request(request));
        }
        while let Some(known) = self.background.take() {
            let column = known.0.column;
            agreed.schedule.add_input(column, Input::Known(known));
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
            let _ = self.execute(slot, command, now, &mut sink);
        }
        let is_input = matches!(job, Job::Input(_));
        match job {
            Job::Input(input) => self.take_input(slot, input, &mut sink),
            Job::Forecast(Some(deadline)) => {
                self.run_ahead(slot, SLICE, deadline, deadline, urgency, &mut sink);
            }
            Job::Forecast(None) => {
                self.run_ahead(slot, SLICE_OF_MANY, Nanos::MAX, now, urgency, &mut sink);
            }
            Job::Spare(deadline) => {
                let deadline = deadline.unwrap_or(Nanos::MAX);
                let share = slot.twin.period() / BACKGROUND_SHARE;
                let end = deadline.min(now.saturating_add_unsigned(share));
                self.run_ahead(slot, SLICE, deadline, end, urgency, &mut sink);
            }
            Job::Advance(deadline) => {
                self.note_lateness(slot, deadline, now);
                slot.twin.advance_to(now, &mut sink);
                self.run_ahead_while_behind(slot, &mut sink);
            }
        }
        sink.notify();
        self.count_steps(slot);
        self.plan_of(column, slot, is_input)
    }

    /// Carries on what is computed ahead, slice by slice until `end`, at least by one; the priority is that of real time again before
    /// `deadline`.
    fn run_ahead(
        &self,
        slot: &mut Slot,
        slice: u64,
        deadline: Nanos,
        end: Nanos,
        urgency: &mut Urgency,
        sink: &mut Sink<'_>,
    ) {
        let mut now = self.clock.now();
        let awaits_forecast = slot.twin.awaits_forecast();
        let is_patient = slot.patience.lasts(awaits_forecast, monotonic_nanos());
        loop {
            if is_patient && deadline.saturating_sub(now) > URGENT_BEFORE_DEADLINE {
                urgency.relax();
            } else {
                restore(urgency, now, sink);
            }
            slot.twin.run_ahead(slice, now, sink);
            // At once, because a reader of the forecast would otherwise wait for the deadline, or for the lock.
            sink.notify();
            let before = std::mem::replace(&mut now, self.clock.now());
            let taken = now.saturating_sub(before).max(0);
            let is_done =
                !slot.twin.is_looking_ahead() || slot.twin.awaits_forecast() != awaits_forecast;
            // Under a clock that does not advance, no deadline ends the loop.
            if is_done || now.saturating_add(taken) >= end || self.has_requests() {
                break;
            }
        }
        restore(urgency, now, sink);
    }

    /// A forecast gets on even if the computer is too slow for the response.
    fn run_ahead_while_behind(&self, slot: &mut Slot, sink: &mut Sink<'_>) {
        let now = self.clock.now();
        if slot.twin.awaits_forecast() && slot.twin.next_deadline(now) <= now {
            // What is late is not to wait for the forecast.
            sink.notify();
            slot.twin.run_ahead(SLICE_WHILE_BEHIND, now, sink);
        }
    }

    /// Whether a request or a stop is pending.
    fn has_requests(&self) -> bool {
        self.counters.waiting_requests.load(Ordering::Relaxed) > 0
            || self.stop.load(Ordering::SeqCst)
    }

    /// Counts what the solver has done since it was counted last.
    fn count_steps(&self, slot: &mut Slot) {
        let now = slot.twin.statistics();
        let before = std::mem::replace(&mut slot.counted, now);
        let counters = &self.counters;
        // Iterations of a response that is taken back are taken back, too; adding wraps around.
        for (counter, now, before) in [
            (&counters.steps, now.steps, before.steps),
            (
                &counters.newton_iterations,
                now.newton_iterations,
                before.newton_iterations,
            ),
        ] {
            counter.fetch_add(now.wrapping_sub(before), Ordering::Relaxed);
        }
    }

    fn take_input(&self, slot: &mut Slot, input: Input, sink: &mut Sink<'_>) {
        // An impact would be earlier than the response that is carried to its end after a jump of the clock.
        for _ in 0..MAX_CALLS_COMPLETING {
            if !slot.twin.is_completing() {
                break;
            }
            slot.twin.advance_to(self.clock.now(), sink);
        }
        let now = self.clock.now();
        match input {
            Input::Request(request) => match request.1 {
                Request::Command { command, reply } => {
                    slot.is_touched = true;
                    sink.has_journal = true;
                    reply.send(self.execute(slot, command, now, sink));
                }
                Request::Check { command, reply } => {
                    reply.send(slot.twin.check_impact(&command, now));
                }
                Request::Snapshot { reply } => reply.send(slot.twin.snapshot()),
            },
            Input::Known(known) => {
                let (wanted, command) = *known;
                slot.wanted[wanted.task.kind() as usize] = None;
                if let Some(command) = command
                    && slot.twin.awaits(&wanted.task)
                {
                    // The twin takes it in every state.
                    let _ = self.execute(slot, command, now, sink);
                }
            }
        }
        slot.twin.advance_to(now, sink);
    }

    /// A deadline in the past counts only if the column was on time before: while it catches up with a late event, the solver is not
    /// to blame for the delay.
    fn note_lateness(&self, slot: &Slot, deadline: Nanos, now: Nanos) {
        if !slot.is_on_time || !slot.twin.is_responding() || deadline == Nanos::MIN {
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

    fn plan_of(&self, column: u32, slot: &mut Slot, is_input: bool) -> Plan {
        let now = self.clock.now();
        let twin = &mut slot.twin;
        for wanted in slot.wanted.iter().flatten() {
            if !twin.awaits(&wanted.task) {
                wanted.abandon();
            }
        }
        let is_quiet = twin.is_quiet(now);
        // The range of a verdict is wanted during the response already.
        let is_range_due =
            twin.awaits_range() && slot.wanted[BackgroundKind::Range as usize].is_none();
        if is_quiet || is_range_due {
            for task in twin.background_tasks() {
                let wanted = &mut slot.wanted[task.kind() as usize];
                if wanted.is_none() {
                    *wanted = self.background.want(column, task);
                }
            }
        }
        let deadline = twin.next_deadline(now);
        let was_on_time = slot.is_on_time && !is_input;
        slot.is_on_time =
            twin.is_responding() && !twin.is_completing() && (deadline > now || was_on_time);
        let deadline = match self.upkeep {
            Upkeep::OnDemand if is_quiet => {
                twin.forget_what_is_too_old(now);
                twin.remembers_until().map(|it| it.saturating_add(1))
            }
            Upkeep::OnDemand | Upkeep::Constant => Some(deadline),
        };
        Plan {
            is_responding: !is_quiet,
            deadline,
            forecast_left: twin.forecast_steps_left(),
            has_spare: twin.is_looking_ahead() && !twin.awaits_forecast(),
        }
    }

    fn sink(&self, column: u32, slot: &Slot) -> Sink<'_> {
        Sink {
            shared: self,
            column,
            has_journal: slot.is_touched,
            is_unnotified: false,
        }
    }

    /// Completes the forecasts of running responses, so that their damage is saved, and reports what is lost. Called when the
    /// solver threads have ended.
    pub fn finish(&self) {
        let mut agreed = self.agreed();
        self.take_news(&mut agreed, self.clock.now());
        self.counters.waiting_requests.store(0, Ordering::Relaxed);
        let (mut impacts, mut others) = (0, 0);
        for (_, input) in agreed.schedule.take_inputs() {
            if let Input::Request(request) = input
                && let Request::Command { command, .. } = &request.1
            {
                let is_impact = matches!(command, Command::Impact(_));
                *(if is_impact { &mut impacts } else { &mut others }) += 1;
            }
        }
        drop(agreed);
        let mut lost_inputs = (impacts + others > 0).then(|| match self.upkeep {
            Upkeep::Constant => {
                format!("{impacts} impacts and {others} other commands in the queue of the solver")
            }
            Upkeep::OnDemand => format!(
                "{} commands to columns of the fleet in the queue of the solvers",
                impacts + others
            ),
        });
        let now = self.clock.now();
        for (column, slot) in (0..).zip(&self.slots) {
            // What a panic has left behind is not saved.
            let Ok(mut slot) = slot.lock() else {
                continue;
            };
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
            let mut lost = twin.lost_by_a_stop();
            if self.upkeep == Upkeep::Constant {
                lost.extend(lost_inputs.take());
            }
            sink.lost_by_a_stop(&lost, now);
        }
        let mut sink = Sink {
            shared: self,
            column: 0,
            has_journal: false,
            is_unnotified: false,
        };
        sink.lost_by_a_stop(lost_inputs.as_slice(), now);
    }

    /// Lets a column execute a command. If it is one of many, what a recording needs before the command of a column at rest comes first,
    /// and what the column knows of its past does not depend on when a thread had time to let it forget.
    fn execute(
        &self,
        slot: &mut Slot,
        command: Command,
        now: Nanos,
        sink: &mut Sink<'_>,
    ) -> Result<Accepted, Refusal> {
        if self.upkeep == Upkeep::OnDemand {
            slot.twin.forget_what_is_too_old(now);
            if sink.has_journal && self.outputs.have_journals() {
                slot.twin.demand_checkpoint();
            }
        }
        slot.twin.handle(command, now, sink)
    }
}

fn restore(urgency: &mut Urgency, now: Nanos, sink: &mut Sink<'_>) {
    if let Err(reason) = urgency.restore() {
        sink.notice(NoticeLevel::Warning, now, reason);
    }
}

/// Passes the outputs of one column to the readers.
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

    fn lost_by_a_stop(&mut self, lost: &[String], now: Nanos) {
        if !lost.is_empty() {
            let text = format!("lost by the stop: {}", lost.join("; "));
            self.notice(NoticeLevel::Error, now, text);
        }
        self.notify();
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
