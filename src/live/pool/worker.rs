//! A solver thread: takes the most urgent job, does it, and says what the column needs next.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::jobs::Task;
use super::schedule::Job;
use super::shared::{Agreed, Input, Shared, Upkeep};
use super::sink::Sink;
use super::watch::Watch;
use crate::live::inbox::Request;
use crate::live::real_time::Urgency;
use crate::parameters::MAX_COLUMNS;
use crate::time::Nanos;
use crate::twin::{Command, Output, Outputs};

/// The threads' name.
pub const SOLVER_THREAD: &str = "column_twin/solver"; // the system shows the first 15 characters

/// Maximum number of requests to the columns of a fleet that wait; more are rejected. All columns may be hit at once.
pub const MAX_FLEET_COMMANDS: usize = 2 * MAX_COLUMNS;

/// A clock that goes back by at most this much is waited for; a larger jump is that of a looped recording or of a clock that
/// was set \[ns\].
pub const MAX_CLOCK_STEP_BACK: Nanos = 100_000_000;

/// How often a thread looks whether the clock was set while no column responds \[ns\]: what other threads stamp would be wrong
/// until the next impact.
const CLOCK_CHECK_PERIOD: Nanos = 1_000_000_000;

/// Maximum number of solver threads: one bit for each in the mask of those that wait.
pub const MAX_THREADS: usize = 64;

/// Maximum number of steps with which a stop completes the forecast of a column: less than a second.
const MAX_STEPS_AT_STOP: u64 = 200_000;

impl Shared {
    /// The content of solver thread number `me`, with its priority.
    pub fn work(&self, me: usize, mut urgency: Urgency) {
        while !self.stop.load(Ordering::SeqCst) {
            match self.take_task(me) {
                Ok(task) => self.do_task(task, &mut urgency),
                // What came after it was looked for has seen this thread wait, or is seen here.
                Err(_) if self.has_news() => {}
                Err(deadline) => {
                    let notifier = &self.notifiers[me];
                    match self.notifiers.len() {
                        // It shares its work with no other thread, and a request does not disturb the samples.
                        1 => self.clock.wait_until(deadline, notifier),
                        _ => self.clock.wait_for_news(deadline, notifier),
                    }
                }
            }
        }
        // The others may wait for this thread to watch the deadlines.
        self.wake_all();
    }

    /// The next job of thread number `me`; until when it is to wait if there is none.
    pub fn take_task(&self, me: usize) -> Result<Task, Nanos> {
        let bit = 1_u64 << me;
        let mut agreed = self.agreed();
        self.waiting.fetch_and(!bit, Ordering::SeqCst);
        agreed.watch.leave(me);
        // While nothing responds, a clock that has been set may jump, before anything is judged by it. The thread that watches
        // would wake too late.
        if agreed.schedule.is_at_rest() && self.clock.resynchronise() {
            agreed.watch = Watch::default();
        }
        let now = self.clock.now();
        self.take_news(&mut agreed, now);
        self.note_active(&agreed);
        let Some((column, job)) = agreed.schedule.take(now) else {
            self.waiting.fetch_or(bit, Ordering::SeqCst);
            let next = agreed.schedule.next_deadline();
            let check = now.saturating_add(CLOCK_CHECK_PERIOD);
            let next = match agreed.schedule.is_at_rest() {
                true => Some(next.map_or(check, |it| it.min(check))),
                false => next,
            };
            return Err(agreed.watch.wait(me, next).unwrap_or(Nanos::MAX));
        };
        if matches!(job, Job::Input(Input::Request(_))) {
            let waiting = &self.counters.waiting_requests;
            waiting.fetch_sub(1, Ordering::Relaxed);
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
        Ok(task)
    }

    /// Does a job, and puts what its column needs next into the schedule.
    pub fn do_task(&self, task: Task, urgency: &mut Urgency) {
        let (column, jumps) = (task.column, task.jumps);
        let mut plan = self.perform(task, urgency);
        let mut agreed = self.agreed();
        if agreed.jumps != jumps {
            // The clock was set back while this thread worked, so that the deadline is one of before.
            plan.deadline = plan.deadline.map(|_| Nanos::MIN);
        }
        agreed.schedule.give_back(column, plan, self.clock.now());
        self.note_active(&agreed);
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
}
