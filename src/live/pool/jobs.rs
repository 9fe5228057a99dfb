//! What a solver thread does for a column: it passes on an input, steps the column, computes ahead; and what the column needs next.

use std::sync::atomic::Ordering;

use super::schedule::{BACKGROUND_SHARE, Job, Plan};
use super::shared::{Input, Shared, Slot, Upkeep};
use super::sink::Sink;
use crate::live::clock::monotonic_nanos;
use crate::live::inbox::Request;
use crate::live::lateness::lateness;
use crate::live::real_time::{URGENT_BEFORE_DEADLINE, Urgency};
use crate::time::Nanos;
use crate::twin::{Accepted, BackgroundKind, Command, NoticeLevel, Outputs, Rejection};

/// Steps that are computed ahead between two readings of the clock. What is left before a deadline and is too short for that is not
/// used; shorter slices spend a tenth of the time on reading clocks.
const SLICE: u64 = 16;

/// Steps of a forecast in one job while several columns respond: less than 0.1 ms, after which inputs of other columns come first.
const SLICE_OF_MANY: u64 = 64;

/// Steps of a forecast after each call that catches up with the clock, when samples are late anyway.
const SLICE_WHILE_BEHIND: u64 = 1_000;

/// A request waits for at most this many calls until a response is complete during which the clock has jumped back: less than
/// a second. Impacts that are handled before have stamps that are out of order.
const MAX_CALLS_COMPLETING: u32 = 200;

/// A job, and what the clock has done until it was taken.
pub struct Task {
    pub column: u32,
    pub job: Job<Input>,
    pub jumps: u64,
    pub last_jump: u64,
}

impl Shared {
    /// Does a job; what the column needs next. What is computed ahead has normal priority, all else that of real time: see
    /// [`Urgency`].
    pub fn perform(&self, task: Task, urgency: &mut Urgency) -> Plan {
        let Task {
            column,
            job,
            jumps,
            last_jump,
        } = task;
        let mut slot = self.locked(&self.slots[column as usize]);
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
        let is_request = matches!(job, Job::Input(Input::Request(_)));
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
                let end = now.saturating_add_unsigned(share);
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
        self.plan_of(column, slot, is_request)
    }

    /// Carries on what is computed ahead, slice by slice until `end` and not beyond `deadline`, at least by one; the priority is that of
    /// real time again before `deadline`.
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
            urgency.give_way();
            // At once, because a reader of the forecast would otherwise wait for the deadline, or for the lock.
            sink.notify();
            let before = std::mem::replace(&mut now, self.clock.now());
            let taken = now.saturating_sub(before).max(0);
            let is_done =
                !slot.twin.is_looking_ahead() || slot.twin.awaits_forecast() != awaits_forecast;
            let is_over = now >= end || now.saturating_add(taken) >= deadline;
            // Under a clock that does not advance, no deadline ends the loop.
            if is_done || is_over || self.has_requests() {
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
        let late = lateness(deadline, slot.twin.period(), self.clock.could_act_at(now));
        let counters = &self.counters;
        late.count(
            &counters.worst_lateness,
            &counters.overruns,
            &counters.skipped_periods,
        );
    }

    fn plan_of(&self, column: u32, slot: &mut Slot, is_request: bool) -> Plan {
        let now = self.clock.now();
        let twin = &mut slot.twin;
        for wanted in slot.wanted.iter().flatten() {
            if !twin.awaits(&wanted.task) {
                wanted.abandon();
            }
        }
        let is_quiet = twin.is_quiet(now);
        // The second opinion and the range of a verdict are wanted during the response already.
        let is_unasked = |kind| slot.wanted[kind as usize].is_none();
        let is_due = (twin.awaits_opinion() && is_unasked(BackgroundKind::SecondOpinion))
            || (twin.awaits_range() && is_unasked(BackgroundKind::Range));
        if is_quiet || is_due {
            for task in twin.background_tasks() {
                let wanted = &mut slot.wanted[task.kind() as usize];
                if wanted.is_none() {
                    *wanted = self.background.want(column, task);
                }
            }
        }
        let deadline = twin.next_deadline(now);
        let was_on_time = slot.is_on_time && !is_request;
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

    pub fn sink(&self, column: u32, slot: &Slot) -> Sink<'_> {
        Sink {
            shared: self,
            column,
            has_journal: slot.is_touched,
            is_unnotified: false,
        }
    }

    /// Lets a column execute a command. If it is one of many, what a recording needs before the command of a column at rest comes first,
    /// and what the column knows of its past does not depend on when a thread had time to let it forget.
    fn execute(
        &self,
        slot: &mut Slot,
        command: Command,
        now: Nanos,
        sink: &mut Sink<'_>,
    ) -> Result<Accepted, Rejection> {
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
