//! The solver's thread: in each cycle it handles requests, steps the twin, computes a part of the forecast, and sleeps.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use super::background::Background;
use super::clock::{Clock, monotonic_nanos};
use super::inbox::{Inbox, MAX_COMMANDS, Request};
use super::lateness::lateness;
use super::queue::OutputQueues;
use super::real_time::{Patience, URGENT_BEFORE_DEADLINE, Urgency};
#[cfg(feature = "study")]
use super::sensing_news::SensingNews;
use super::state_writer::StateWriter;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{ColumnSnapshot, Command, NoticeLevel, Output, Outputs, Refusal, Twin};

/// The thread's name.
pub const SOLVER_THREAD: &str = "column_twin/solver"; // the system shows the first 15 characters

/// Maximum number of requests per cycle, so that a flood of requests does not delay the steps.
const MAX_REQUESTS_PER_CYCLE: usize = 8;

/// Steps of a forecast between two readings of the clock, while the response is on time. The forecast cannot use a
/// remainder before a deadline that is too short for a slice; shorter slices spend a tenth of the time on reading clocks.
const SLICE: u64 = 16;

/// Of the time between two deadlines, one part in this many is spent on what is not urgent, the error of a forecast and
/// forecasts of earlier responses: this thread has a high priority, and on two processors those who publish and receive the
/// samples need the rest. A response takes 3 % of its own time to compute, and its error twice as much.
const BACKGROUND_SHARE: u64 = 4;

/// A thread is not started later than this before the next sample \[ns\]. It takes a tenth of that.
const TIME_TO_START_A_THREAD: Nanos = 500_000;

/// Steps of a forecast per cycle while the response catches up, when samples are late anyway.
const SLICE_WHILE_BEHIND: u64 = 1_000;

/// Maximum number of steps with which a stop completes a forecast: less than a second.
pub(super) const MAX_STEPS_AT_STOP: u64 = 200_000;

/// A clock that goes back by at most this much is waited for; a larger jump is that of a looped recording or of a clock that
/// was set \[ns\].
pub const MAX_CLOCK_STEP_BACK: Nanos = 100_000_000;

/// Requests wait for at most this many cycles until a response is complete during which the clock has jumped back: less than
/// a second. Impacts that are handled before have stamps that are out of order.
pub(super) const MAX_CYCLES_COMPLETING: u32 = 200;

/// The state that the solver's thread shares with the others.
#[derive(Debug)]
pub(super) struct Shared {
    pub inbox: Inbox,
    pub stop: AtomicBool,
    pub cycles: AtomicU64,
    pub overruns: AtomicU64,
    pub skipped_periods: AtomicU64,
    pub worst_lateness: AtomicU64,
    pub steps: AtomicU64,
    pub newton_iterations: AtomicU64,
}

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            inbox: Inbox::new(),
            stop: AtomicBool::new(false),
            cycles: AtomicU64::new(0),
            overruns: AtomicU64::new(0),
            skipped_periods: AtomicU64::new(0),
            worst_lateness: AtomicU64::new(0),
            steps: AtomicU64::new(0),
            newton_iterations: AtomicU64::new(0),
        }
    }

    /// A copy of the current state of the column.
    ///
    /// # Errors
    /// The solver does not answer in time.
    pub fn snapshot(&self) -> Result<ColumnSnapshot, Refusal> {
        self.inbox.ask(|reply| Request::Snapshot { reply })
    }
}

/// The planned start of the next cycle.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlannedCycle {
    deadline: Nanos,
    period: u64,
}

/// The content of the solver's thread.
pub(super) struct Solver {
    pub twin: Twin,
    pub clock: Arc<dyn Clock>,
    pub shared: Arc<Shared>,
    pub sink: Sink,
    /// What is computed with the lowest priority.
    pub background: Background,
    /// The time of the clock in the last cycle.
    pub latest: Option<Nanos>,
    /// Cycles since the clock jumped back, while the response is completed.
    pub completing_cycles: u32,
    /// When the next cycle is to start, if that is known.
    pub planned: Option<PlannedCycle>,
    /// The priority of the thread.
    pub urgency: Urgency,
    /// With the forecast that is awaited.
    pub patience: Patience,
}

impl Solver {
    pub fn run(mut self) {
        while !self.shared.stop.load(Ordering::SeqCst) {
            if let Some(deadline) = self.turn() {
                self.clock
                    .wait_until(deadline, self.shared.inbox.notifier());
            }
        }
        self.finish();
    }

    /// One cycle. The deadline of the next one, or `None` if that is to follow at once.
    fn turn(&mut self) -> Option<Nanos> {
        let planned = self.planned.take();
        self.note_lateness(planned);
        self.note_clock();
        let disturbed = self.handle_requests();
        self.take_background_result();
        self.twin.advance_to(self.clock.now(), &mut self.sink);
        self.sink.notify();
        self.look_ahead();
        self.publish_statistics();
        self.planned = self.plan(planned, disturbed);
        // A thread that owes a forecast does not sleep: less than a slice is left before the deadline.
        let is_busy = self.twin.awaits_forecast() || self.twin.is_completing();
        if is_busy || !self.shared.inbox.is_empty() {
            return None;
        }
        self.start_background();
        Some(self.twin.next_deadline(self.clock.now()))
    }

    /// Passes a jump of the clock to the twin.
    fn note_clock(&mut self) {
        let now = self.clock.now();
        let back = self.latest.replace(now).unwrap_or(now).saturating_sub(now);
        if back > MAX_CLOCK_STEP_BACK {
            let by = back.unsigned_abs();
            let command = Command::ClockJumpedBack { by };
            // The twin takes it in every state.
            let _ = self.twin.handle(command, now, &mut self.sink);
        }
    }

    /// `true` if there was a request, so that the planned deadline no longer measures lateness.
    fn handle_requests(&mut self) -> bool {
        if !self.twin.is_responding() {
            self.clock.resynchronise();
        }
        if !self.twin.is_completing() {
            self.completing_cycles = 0;
        } else if self.completing_cycles < MAX_CYCLES_COMPLETING {
            self.completing_cycles += 1;
            return false;
        }
        let mut any = false;
        for _ in 0..MAX_REQUESTS_PER_CYCLE {
            let Some(request) = self.shared.inbox.take() else {
                break;
            };
            match request {
                Request::Command { command, reply } => {
                    let result = self.twin.handle(command, self.clock.now(), &mut self.sink);
                    reply.send(result);
                }
                Request::Check { command, reply } => {
                    reply.send(self.twin.check_impact(&command, self.clock.now()));
                }
                Request::Snapshot { reply } => reply.send(self.twin.snapshot()),
            }
            any = true;
        }
        any
    }

    /// Abandons what is computed in the background for another column than the present one, or takes the result.
    fn take_background_result(&mut self) {
        self.background.follow(&self.twin);
        if let Some(command) = self.background.take_result() {
            let now = self.clock.now();
            // The twin takes it in every state.
            let _ = self.twin.handle(command, now, &mut self.sink);
            self.background.follow(&self.twin);
        }
    }

    /// Lets something be computed in the background, if nothing else is to be done. During a response the thread is started where
    /// this does not delay a sample.
    fn start_background(&mut self) {
        let now = self.clock.now();
        let has_time = !self.twin.is_responding()
            || self.twin.next_deadline(now).saturating_sub(now) > TIME_TO_START_A_THREAD;
        if has_time && !self.twin.is_looking_ahead() {
            self.background
                .start(&self.twin, self.shared.inbox.notifier());
        }
    }

    fn look_ahead(&mut self) {
        let mut before = self.clock.now();
        if self.twin.next_deadline(before) <= before {
            if self.twin.awaits_forecast() {
                self.twin
                    .run_ahead(SLICE_WHILE_BEHIND, before, &mut self.sink);
                self.sink.notify();
            }
            return;
        }
        let mut slice_nanos = 0;
        let (started, share) = (monotonic_nanos(), self.twin.period() / BACKGROUND_SHARE);
        let is_patient = self.patience.lasts(self.twin.awaits_forecast(), started);
        while self.twin.is_looking_ahead()
            && (self.twin.awaits_forecast() || monotonic_nanos().saturating_sub(started) < share)
            && before.saturating_add(slice_nanos) < self.twin.next_deadline(before)
        {
            let left = self.twin.next_deadline(before).saturating_sub(before);
            if is_patient && left > URGENT_BEFORE_DEADLINE {
                self.urgency.relax();
            } else {
                self.restore_urgency();
            }
            self.twin.run_ahead(SLICE, before, &mut self.sink);
            // At once, because a reader of the forecast would otherwise wait for the deadline.
            self.sink.notify();
            let now = self.clock.now();
            slice_nanos = now.saturating_sub(before).max(0);
            before = now;
            // Under a clock that does not advance, no deadline ends the loop.
            if self.has_requests() {
                break;
            }
        }
        self.restore_urgency();
    }

    fn restore_urgency(&mut self) {
        if let Err(reason) = self.urgency.restore() {
            let now = self.clock.now();
            self.sink.notice(NoticeLevel::Warning, now, reason);
        }
    }

    /// Whether a request or a stop is pending.
    fn has_requests(&self) -> bool {
        !self.shared.inbox.is_empty() || self.shared.stop.load(Ordering::SeqCst)
    }

    /// A deadline in the past counts only if the response was on time before: while it catches up with a late event, the
    /// solver is not to blame for the delay.
    fn plan(&self, before: Option<PlannedCycle>, disturbed: bool) -> Option<PlannedCycle> {
        if !self.twin.is_responding() || self.twin.is_completing() {
            return None;
        }
        let now = self.clock.now();
        let deadline = self.twin.next_deadline(now);
        let was_on_time = before.is_some() && !disturbed;
        (deadline > now || was_on_time).then(|| PlannedCycle {
            deadline,
            period: self.twin.period(),
        })
    }

    fn note_lateness(&self, planned: Option<PlannedCycle>) {
        let Some(PlannedCycle { deadline, period }) = planned else {
            return;
        };
        let late = lateness(deadline, period, self.clock.now());
        let shared = &self.shared;
        late.count(
            &shared.worst_lateness,
            &shared.overruns,
            &shared.skipped_periods,
        );
    }

    fn publish_statistics(&self) {
        let statistics = self.twin.statistics();
        self.shared.cycles.fetch_add(1, Ordering::Relaxed);
        self.shared.steps.store(statistics.steps, Ordering::Relaxed);
        self.shared
            .newton_iterations
            .store(statistics.newton_iterations, Ordering::Relaxed);
    }

    /// Completes the forecast of a running response, so that its damage is saved, and reports what is lost.
    fn finish(mut self) {
        let now = self.clock.now();
        self.twin.run_ahead(MAX_STEPS_AT_STOP, now, &mut self.sink);
        self.twin.abandon_forecasts(&mut self.sink);
        if !self.twin.is_responding() {
            let saved = self.twin.saved_state(now);
            self.sink.put(Output::Save(Arc::new(saved)));
        }
        let mut lost = self.twin.lost_by_a_stop();
        lost.extend(self.unhandled_requests());
        if !lost.is_empty() {
            let text = format!("lost by the stop: {}", lost.join("; "));
            self.sink.notice(NoticeLevel::Error, now, text);
        }
        self.sink.notify();
    }

    /// Describes the commands that were queued and did not reach the twin.
    fn unhandled_requests(&self) -> Option<String> {
        let (mut impacts, mut others) = (0, 0);
        for request in std::iter::from_fn(|| self.shared.inbox.take()).take(MAX_COMMANDS) {
            match request {
                Request::Command {
                    command: Command::Impact(_),
                    ..
                } => impacts += 1,
                Request::Command { .. } => others += 1,
                Request::Check { .. } | Request::Snapshot { .. } => {}
            }
        }
        (impacts + others > 0).then(|| {
            format!("{impacts} impacts and {others} other commands in the queue of the solver")
        })
    }
}

/// Passes the outputs of the twin to their readers.
pub(super) struct Sink {
    pub queues: Vec<Arc<OutputQueues>>,
    pub state_writer: Option<Arc<StateWriter>>,
    /// The parameters that hold. Readers hold the lock only while they copy the pointer; this thread takes it only for a change.
    pub parameters: Arc<RwLock<Arc<Parameters>>>,
    /// What the thread is told that feels impacts; `None` if there is none.
    #[cfg(feature = "study")]
    pub news: Option<Arc<SensingNews>>,
    /// There are outputs of which the readers have not been notified.
    pub unnotified: bool,
}

impl Sink {
    fn notify(&mut self) {
        if std::mem::take(&mut self.unnotified) {
            self.queues.iter().for_each(|queues| queues.notify());
        }
    }
}

impl Outputs for Sink {
    fn put(&mut self, output: Output) {
        #[cfg(feature = "study")]
        if let Some(lost) = self.news.as_ref().and_then(|it| it.take(0, &output)) {
            self.put(Output::Notice(lost));
        }
        if let Output::Save(saved) = &output {
            if let Some(state_writer) = &self.state_writer {
                state_writer.write(Arc::clone(saved));
            }
            return;
        }
        if let Output::ParametersChanged(changed) = &output {
            let mut latest = self
                .parameters
                .write()
                .unwrap_or_else(PoisonError::into_inner);
            *latest = Arc::clone(&changed.parameters);
        }
        self.unnotified = true;
        if let Some((last, others)) = self.queues.split_last() {
            others.iter().for_each(|queues| queues.push(output.clone()));
            last.push(output);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::clock::SimClock;
    use super::super::inbox::Reply;
    use super::super::queue::{OutputQueue, Receiver, WhenFull};
    use super::*;
    use crate::column::ImpactSpecification;
    use crate::twin::ImpactCommand;

    fn impact(event_id: &str) -> Command {
        Command::Impact(ImpactCommand {
            event_id: event_id.to_owned(),
            column_id: "column".to_owned(),
            stamp: 0,
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 10.0,
                gap: Some(0.1),
                restitution: None,
                height: None,
            },
        })
    }

    #[test]
    fn a_stop_reports_the_commands_that_it_loses() {
        let twin = Twin::new(Parameters::default(), None, Box::new(|| 0), 0).expect("stands");
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let shared = Arc::new(Shared::new());
        shared.stop.store(true, Ordering::Relaxed);
        let (reply, _answer) = Reply::channel();
        assert!(shared.inbox.submit(Request::Snapshot { reply }).is_ok());
        let reset = Command::Reset {
            source: "test".into(),
        };
        for command in [impact("a"), reset, impact("b")] {
            let request = Request::Command {
                command,
                reply: Reply::none(),
            };
            assert!(shared.inbox.submit(request).is_ok());
        }
        let solver = Solver {
            twin,
            clock: Arc::new(SimClock::new(0)),
            shared,
            sink: Sink {
                queues: vec![Arc::clone(&queues)],
                state_writer: None,
                parameters: Arc::default(),
                #[cfg(feature = "study")]
                news: None,
                unnotified: false,
            },
            background: Background::new(),
            latest: None,
            completing_cycles: 0,
            planned: None,
            urgency: Urgency::default(),
            patience: Patience::default(),
        };
        solver.run();
        let mut receiver = Receiver::new(queues);
        let Some(Output::Notice(notice)) = receiver.try_next() else {
            panic!("no notice");
        };
        assert_eq!(notice.level, NoticeLevel::Error);
        assert!(
            notice.text.contains("2 impacts and 1 other commands"),
            "{}",
            notice.text
        );
    }

    /// From the step to the queues, one of which is full.
    #[test]
    fn a_response_allocates_no_memory() {
        let few = OutputQueue {
            name: "few".to_owned(),
            states: 3,
            others: 3,
            when_full: WhenFull::DropNewest,
        };
        let queues = [OutputQueue::ros(), few]
            .map(|it| Arc::new(OutputQueues::new(&it)))
            .to_vec();
        let mut sink = Sink {
            queues,
            state_writer: None,
            parameters: Arc::default(),
            #[cfg(feature = "study")]
            news: None,
            unnotified: false,
        };
        let mut twin = Twin::new(Parameters::default(), None, Box::new(|| 0), 0).expect("stands");
        twin.handle(impact("a"), 0, &mut sink).expect("accepted");
        let memory = allocation_counter::measure(|| {
            for now in 1..40 {
                twin.advance_to(now * 1_000_000, &mut sink);
                sink.notify();
            }
        });
        assert!(twin.is_responding() && twin.statistics().newton_iterations > 0);
        assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
    }
}
