//! The one thread that computes what columns await in the background, with the lowest priority: second opinions, ranges of verdicts,
//! and the critical velocities of columns at rest.
//!
//! Second opinions on impacts come first, the newest before the others; then second opinions on predictions, then ranges, then the
//! critical velocities of columns that have been hit. What is more urgent interrupts what is being computed, before its next response.
//! Columns that differ by their names only have the same results, which are computed once. For the critical velocities of the other
//! columns, of which a fleet has many after the start, the thread takes only a part of a processor, because they are not urgent. What
//! a column no longer awaits is abandoned, after the response that is being computed. The solver threads and this one share queues
//! without locks only: a thread with the lowest priority must not hold a lock that they need. A pop may spin while a push is
//! preempted, which is rare.

use std::collections::VecDeque;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use rustix::thread::CpuSet;
use rustix::time::{ClockId, clock_gettime};

use crate::live::clock::monotonic_nanos;
use crate::live::notifier::Notifier;
use crate::live::real_time::{THREAD_STACK, lower_priority};
use crate::parameters::MAX_COLUMNS;
use crate::twin::{BackgroundKind, BackgroundTask, BeamResult, Command, OpinionTask};

/// The thread's name.
pub const BACKGROUND_THREAD: &str = "column_twin/critical"; // the system shows the first 15 characters

/// Maximum sleep between two checks of the stop flag.
const MAX_SLEEP: Duration = Duration::from_secs(3600);

/// Results that are kept for further columns of the same kind; the oldest is dropped.
const MAX_KNOWN: usize = MAX_COLUMNS;

/// For columns of a fleet that have not been hit, the thread rests this many times as long as it has computed: it takes a fifth of a
/// processor.
const REST: u64 = 4;

/// Processor time between two rests \[ns\], or that of one response if it takes longer.
const BURST: u64 = 20_000_000;

/// Most second opinions that wait for somebody who has asked for them.
const MAX_ASKED: usize = 16;

/// What becomes of a second opinion that somebody has asked for.
pub type OpinionReply = Box<dyn FnOnce(Arc<BeamResult>) + Send>;

/// A second opinion that somebody has asked for.
struct Asked {
    task: OpinionTask,
    reply: OpinionReply,
}

impl fmt::Debug for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Asked")
            .field("task", &self.task)
            .finish_non_exhaustive()
    }
}

/// What is to be computed for a column.
#[derive(Debug)]
pub struct Wanted {
    pub column: u32,
    pub task: BackgroundTask,
    is_abandoned: AtomicBool,
}

impl Wanted {
    /// The column no longer awaits it.
    pub fn abandon(&self) {
        self.is_abandoned.store(true, Ordering::Relaxed);
    }

    fn is_abandoned(&self) -> bool {
        self.is_abandoned.load(Ordering::Relaxed)
    }
}

/// What was wanted, and the command with the result; `None` if it was abandoned.
pub type Known = (Arc<Wanted>, Option<Command>);

/// The computation in the background.
#[derive(Debug)]
pub struct Background {
    /// By their [`BackgroundKind`].
    wanted: [ArrayQueue<Arc<Wanted>>; BackgroundKind::COUNT],
    /// Second opinions on predictions, in the order in which they were asked for.
    asked: ArrayQueue<Asked>,
    /// Whether what is not urgent takes a part of a processor only.
    rests: bool,
    /// Columns that want critical velocities, with the one for which they are being computed.
    unknown: AtomicUsize,
    known: ArrayQueue<Box<Known>>,
    notifier: Notifier,
    stop: AtomicBool,
    has_ended: AtomicBool,
}

impl Background {
    /// For so many columns, each of which wants at most one result of each queue at a time.
    pub fn new(columns: usize) -> Self {
        Self {
            wanted: std::array::from_fn(|_| ArrayQueue::new(columns.max(1))),
            asked: ArrayQueue::new(MAX_ASKED),
            rests: columns > 1,
            unknown: AtomicUsize::new(0),
            known: ArrayQueue::new(BackgroundKind::COUNT * columns.max(1)),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
            has_ended: AtomicBool::new(false),
        }
    }

    /// Starts the thread, which calls `tell` after each result.
    pub fn start(
        self: &Arc<Self>,
        processors: Option<CpuSet>,
        tell: impl Fn() + Send + 'static,
    ) -> std::io::Result<JoinHandle<()>> {
        let shared = Arc::clone(self);
        thread::Builder::new()
            .name(BACKGROUND_THREAD.to_owned())
            .stack_size(THREAD_STACK)
            .spawn(move || {
                let _end = AtEnd(&shared);
                // With a real-time priority it must not compute.
                if lower_priority(processors.as_ref()) {
                    shared.run(&tell);
                }
            })
    }

    /// Asks for a result for a column; `None` if there is no room.
    pub fn want(&self, column: u32, task: BackgroundTask) -> Option<Arc<Wanted>> {
        let kind = task.kind();
        let is_counted = usize::from(kind.is_of_critical_velocities());
        // Before the thread can take it out of the count.
        self.unknown.fetch_add(is_counted, Ordering::Relaxed);
        let wanted = Arc::new(Wanted {
            column,
            task,
            is_abandoned: AtomicBool::new(false),
        });
        let taken = self.wanted[kind as usize].push(Arc::clone(&wanted)).is_ok();
        if !taken {
            self.unknown.fetch_sub(is_counted, Ordering::Relaxed);
        }
        self.notifier.notify();
        taken.then_some(wanted)
    }

    /// Asks for a second opinion on a prediction, which is given to `reply`. Once the thread has ended, by a stop or a panic, `reply`
    /// is dropped. `false` if there is no room.
    pub fn ask(&self, task: OpinionTask, reply: OpinionReply) -> bool {
        let taken = self.asked.push(Asked { task, reply }).is_ok();
        // After the push: the thread may have ended before it, and would never see it.
        if self.has_ended.load(Ordering::SeqCst) {
            self.drop_asked();
            return true;
        }
        self.notifier.notify();
        taken
    }

    /// Tells those who wait that there will be no second opinion.
    fn drop_asked(&self) {
        while self.asked.pop().is_some() {}
    }

    /// The next result.
    pub fn take(&self) -> Option<Box<Known>> {
        self.known.pop()
    }

    pub fn has_results(&self) -> bool {
        !self.known.is_empty()
    }

    /// Columns whose critical velocities are still to be computed.
    pub fn unknown(&self) -> usize {
        self.unknown.load(Ordering::Relaxed)
    }

    /// Lets the thread end after the response that it is computing.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.notifier.notify();
    }

    fn run(&self, tell: &dyn Fn()) {
        let mut work = Work::new(self, tell);
        while !self.stop.load(Ordering::SeqCst) {
            if !work.do_one(BackgroundKind::COUNT) {
                self.notifier.wait(MAX_SLEEP);
            }
        }
    }

    /// Waits if enough has been computed since the last rest, which ended at `rested` \[ns of processor time\], unless a column
    /// has been hit.
    fn rest(&self, rested: &mut u64) {
        let computed = processor_time().saturating_sub(*rested);
        if computed < BURST {
            return;
        }
        let end = monotonic_nanos().saturating_add(REST * computed);
        let [opinions, ranges, hit, _] = &self.wanted;
        let is_idle =
            || opinions.is_empty() && self.asked.is_empty() && ranges.is_empty() && hit.is_empty();
        while is_idle() && !self.stop.load(Ordering::SeqCst) {
            let left = end.saturating_sub(monotonic_nanos());
            if left == 0 {
                break;
            }
            self.notifier.wait(Duration::from_nanos(left));
        }
        *rested = processor_time();
    }
}

/// What the thread has at hand.
struct Work<'a> {
    shared: &'a Background,
    tell: &'a dyn Fn(),
    /// Second opinions that wait, the newest last.
    opinions: Vec<Arc<Wanted>>,
    found: VecDeque<(BackgroundTask, Command)>,
    /// Processor time at the end of the last rest \[ns\].
    rested: u64,
}

impl<'a> Work<'a> {
    fn new(shared: &'a Background, tell: &'a dyn Fn()) -> Self {
        Self {
            shared,
            tell,
            opinions: Vec::new(),
            found: VecDeque::new(),
            rested: processor_time(),
        }
    }

    /// Does the most urgent of what waits, if its kind comes before this one; `false` if there is nothing of the sort.
    fn do_one(&mut self, before: usize) -> bool {
        let shared = self.shared;
        if before == BackgroundKind::SecondOpinion as usize {
            return false;
        }
        // The newest first: who has just been hit is looked at now.
        while let Some(opinion) = shared.wanted[BackgroundKind::SecondOpinion as usize].pop() {
            self.opinions.push(opinion);
        }
        if let Some(opinion) = self.opinions.pop() {
            self.answer(opinion);
        } else if let Some(Asked { task, reply }) = shared.asked.pop() {
            // Somebody waits for it; a column that has been hit comes first.
            reply(task.compute());
        } else if let Some(other) = shared.wanted[..before].iter().find_map(ArrayQueue::pop) {
            self.answer(other);
        } else {
            return false;
        }
        true
    }

    fn answer(&mut self, wanted: Arc<Wanted>) {
        let command = self.result(&wanted);
        let is_counted = usize::from(wanted.task.kind().is_of_critical_velocities());
        // There is room: a column wants nothing more of a queue before it has taken its result.
        let _ = self.shared.known.push(Box::new((wanted, command)));
        self.shared.unknown.fetch_sub(is_counted, Ordering::Relaxed);
        (self.tell)();
    }

    /// Computes a result, or finds it among those of before; `None` if it is no longer awaited.
    fn result(&mut self, wanted: &Wanted) -> Option<Command> {
        let task = &wanted.task;
        if let Some((_, command)) = self.found.iter().find(|(it, _)| task.has_the_result_of(it)) {
            return Some(command.clone());
        }
        let (shared, kind) = (self.shared, task.kind());
        let is_urgent = !shared.rests || kind != BackgroundKind::Undamaged;
        let command = task.compute(&mut || {
            if !is_urgent {
                shared.rest(&mut self.rested);
            }
            // The critical velocities take seconds, for which a verdict would wait.
            while !shared.stop.load(Ordering::Relaxed) {
                if !self.do_one(kind as usize) {
                    break;
                }
            }
            !shared.stop.load(Ordering::Relaxed) && !wanted.is_abandoned()
        });
        if is_urgent {
            // It took no part of the others' time.
            self.rested = processor_time();
        }
        let command = command?;
        if self.found.len() == MAX_KNOWN {
            self.found.pop_front();
        }
        self.found.push_back((task.clone(), command.clone()));
        Some(command)
    }
}

/// When the thread ends, even by a panic, tells those who wait that there will be no second opinion.
struct AtEnd<'a>(&'a Background);

impl Drop for AtEnd<'_> {
    fn drop(&mut self) {
        // Before what is asked for is dropped: what is asked for later sees it.
        self.0.has_ended.store(true, Ordering::SeqCst);
        self.0.drop_asked();
    }
}

/// Processor time of the calling thread \[ns\].
fn processor_time() -> u64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    let seconds = time.tv_sec.unsigned_abs() * 1_000_000_000;
    seconds + time.tv_nsec.unsigned_abs()
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{RecvTimeoutError, sync_channel};

    use super::*;
    use crate::column::ImpactSpecification;
    use crate::parameters::Parameters;
    use crate::twin::{Command, ImpactCommand, Twin};

    /// A twin with short responses and without the beam, after an impact if `is_hit`.
    fn twin(is_hit: bool) -> Twin {
        let values = [
            ("solver.dt", 1e-4.into()),
            ("response.duration", 0.05.into()),
            ("beam.mode", "off".into()),
        ];
        let parameters = Parameters::from_values(values).expect("admissible");
        let mut twin = Twin::new(parameters, None, Box::new(|| 0), 0).expect("stands");
        if is_hit {
            let impact = Command::Impact(ImpactCommand {
                event_id: "a".to_owned(),
                column_id: twin.column_id().to_string(),
                stamp: 0,
                vehicle: String::new(),
                impact: ImpactSpecification {
                    mass: 1500.0,
                    velocity: 8.0,
                    gap: None,
                    restitution: None,
                    height: None,
                    direction: None,
                },
            });
            let (mut now, mut out) = (0, Vec::new());
            twin.handle(impact, now, &mut out).expect("accepted");
            while twin.is_responding() {
                now += 1_000_000;
                twin.advance_to(now, &mut out);
                twin.run_ahead(u64::MAX, now, &mut out);
            }
        }
        twin
    }

    fn task(is_hit: bool) -> BackgroundTask {
        let task = twin(is_hit).critical_velocity_task().expect("at rest");
        BackgroundTask::CriticalVelocities(Box::new(task))
    }

    /// The critical velocities began while the second opinion was computed, and the range of the verdict waited for their end, which
    /// took longer than people watched.
    #[test]
    fn the_range_of_a_verdict_does_not_wait_for_critical_velocities_that_are_being_computed() {
        let background = Background::new(1);
        let tell = || {};
        let mut work = Work::new(&background, &tell);
        assert!(background.want(0, task(true)).is_some());
        let begun = background.wanted[BackgroundKind::Damaged as usize].pop();
        let range = twin(true).range_task().expect("awaited");
        let range = BackgroundTask::Range(Box::new(range));
        assert!(background.want(0, range).is_some());
        work.answer(begun.expect("wanted"));
        let results = std::iter::from_fn(|| background.take());
        let order: Vec<_> = results
            .map(|known| (known.0.task.kind(), known.1.is_some()))
            .collect();
        assert_eq!(
            order,
            [
                (BackgroundKind::Range, true),
                (BackgroundKind::Damaged, true)
            ]
        );
        assert_eq!(background.unknown(), 0);
    }

    #[test]
    fn columns_that_have_been_hit_come_first_and_equal_ones_are_computed_once() {
        let (undamaged, hit) = (task(false), task(true));
        assert_eq!(hit.kind(), BackgroundKind::Damaged);
        assert_eq!(undamaged.kind(), BackgroundKind::Undamaged);
        let background = Arc::new(Background::new(4));
        for (column, task) in [(0, &undamaged), (1, &undamaged), (2, &hit), (3, &undamaged)] {
            assert!(background.want(column, task.clone()).is_some());
        }
        assert_eq!(background.unknown(), 4);
        let (sender, told) = sync_channel(4);
        let thread = background.start(None, move || sender.send(()).expect("listened to"));
        let results: Vec<_> = (0..4)
            .map(|_| {
                told.recv_timeout(Duration::from_secs(120))
                    .expect("a result");
                *background.take().expect("a result")
            })
            .collect();
        assert_eq!(background.unknown(), 0);
        let order: Vec<_> = results.iter().map(|(wanted, _)| wanted.column).collect();
        assert_eq!(order, [2, 0, 1, 3]);
        for (wanted, command) in &results {
            assert_eq!(*command, wanted.task.compute(&mut || true));
        }
        let vehicles = |index: usize| match &results[index].1 {
            Some(Command::CriticalVelocities { vehicles }) => Arc::clone(vehicles),
            other => panic!("{other:?}"),
        };
        assert!(Arc::ptr_eq(&vehicles(1), &vehicles(3)));
        background.stop();
        thread.expect("starts").join().expect("no panic");
    }

    #[test]
    fn what_is_no_longer_awaited_is_not_computed() {
        let background = Arc::new(Background::new(1));
        let wanted = background.want(0, task(false)).expect("room");
        wanted.abandon();
        let (sender, told) = sync_channel(1);
        let thread = background.start(None, move || sender.send(()).expect("listened to"));
        told.recv_timeout(Duration::from_secs(120))
            .expect("an answer");
        let (answered, command) = *background.take().expect("an answer");
        assert!(Arc::ptr_eq(&answered, &wanted) && command.is_none());
        assert_eq!(background.unknown(), 0);
        background.stop();
        thread.expect("starts").join().expect("no panic");
    }

    /// A hit out of the plane of the two bars, which the beam would compute.
    fn opinion_task() -> OpinionTask {
        let given = Parameters::load(&["config/heb220_s355.yaml".into()], &[]);
        let changes = [("solver.dt", 1e-4.into())];
        let parameters = given.expect("admissible").with_changes(changes);
        let parameters = parameters.expect("admissible");
        let twin = Twin::new(parameters, None, Box::new(|| 0), 0).expect("stands");
        let impact = ImpactSpecification {
            mass: 1500.0,
            velocity: 6.0,
            gap: None,
            restitution: None,
            height: Some(1.0),
            direction: Some(0.2),
        };
        let prediction = twin.snapshot().predict("", "rigid", &impact, &|| 0);
        let prediction = prediction.expect("a prediction");
        prediction.opinion_task().expect("awaited")
    }

    /// A panic left those who waited for a second opinion waiting for ever, and so those who asked afterwards.
    #[test]
    fn a_panic_of_the_thread_drops_what_is_asked_for_before_and_after() {
        let awaited = opinion_task();
        let background = Arc::new(Background::new(1));
        let ask = || {
            let (sender, opinion) = sync_channel(1);
            let reply = Box::new(move |found| sender.send(found).expect("listened to"));
            assert!(background.ask(awaited.clone(), reply), "there is room");
            opinion
        };
        // Its result is told at once.
        let wanted = background.want(0, task(false)).expect("room");
        wanted.abandon();
        let (reached, is_told) = sync_channel(1);
        let (asked, goes_on) = sync_channel::<()>(1);
        let thread = background.start(None, move || {
            reached.send(()).expect("listened to");
            goes_on.recv().expect("told");
            panic!("on purpose");
        });
        is_told
            .recv_timeout(Duration::from_secs(120))
            .expect("a result");
        let before = ask();
        asked.send(()).expect("listened to");
        let panicked = thread.expect("starts").join();
        assert!(panicked.is_err());
        let after = ask();
        for opinion in [before, after] {
            let found = opinion.recv_timeout(Duration::from_secs(120));
            assert_eq!(found, Err(RecvTimeoutError::Disconnected));
        }
    }
}
