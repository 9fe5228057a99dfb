//! The one thread that computes the critical velocities of all columns of a fleet at rest, with the lowest priority.
//!
//! Columns that differ by their names only have the same critical velocities, which are computed once. Columns that have been hit
//! come first. For the others, of which there are many after the start, the thread takes only a part of a processor, because they
//! are not urgent. The solver threads and this one share queues without locks only: a thread with the lowest priority must not hold a
//! lock that they need. Whoever pops while another thread is preempted in the middle of its push has to wait, which is seldom.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use rustix::thread::CpuSet;
use rustix::time::{ClockId, clock_gettime};

use super::super::background::BACKGROUND_THREAD;
use super::super::clock::monotonic_nanos;
use super::super::notifier::Notifier;
use super::super::real_time::THREAD_STACK;
use super::super::real_time::lower_priority;
use crate::parameters::MAX_COLUMNS;
use crate::study::VehicleLimits;
use crate::twin::CriticalVelocityTask;

/// Maximum sleep between two checks of the stop flag.
const MAX_SLEEP: Duration = Duration::from_secs(3600);

/// Results that are kept for further columns of the same kind; the oldest is dropped.
const MAX_KNOWN: usize = MAX_COLUMNS;

/// For columns that have not been hit, the thread rests this many times as long as it has computed: it takes a fifth of a
/// processor.
const REST: u64 = 4;

/// Processor time between two rests \[ns\], or that of one response if it takes longer.
const BURST: u64 = 20_000_000;

/// A column and what is to be computed for it.
pub type Wanted = (u32, CriticalVelocityTask);

/// A column, what was computed for it, and the result.
pub type Known = (u32, CriticalVelocityTask, Arc<[VehicleLimits]>);

/// The computation in the background.
#[derive(Debug)]
pub struct Background {
    /// Columns that have been hit.
    hit: ArrayQueue<Box<Wanted>>,
    /// The other ones.
    others: ArrayQueue<Box<Wanted>>,
    /// Columns in both queues, and the one that is being computed.
    unknown: AtomicUsize,
    known: ArrayQueue<Box<Known>>,
    notifier: Notifier,
    stop: AtomicBool,
}

impl Background {
    /// For a fleet of so many columns, each of which wants at most one result of each queue at a time.
    pub fn new(columns: usize) -> Self {
        Self {
            hit: ArrayQueue::new(columns.max(1)),
            others: ArrayQueue::new(columns.max(1)),
            unknown: AtomicUsize::new(0),
            known: ArrayQueue::new(2 * columns.max(1)),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
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
                // With a real-time priority it must not compute.
                if lower_priority(processors.as_ref()) {
                    shared.run(&tell);
                }
            })
    }

    /// Asks for the critical velocities of a column; `false` if there is no room.
    pub fn want(&self, column: u32, task: CriticalVelocityTask) -> bool {
        let queue = match task.is_damaged() {
            true => &self.hit,
            false => &self.others,
        };
        // Before the thread can take it out of the count.
        self.unknown.fetch_add(1, Ordering::Relaxed);
        let taken = queue.push(Box::new((column, task))).is_ok();
        if !taken {
            self.unknown.fetch_sub(1, Ordering::Relaxed);
        }
        self.notifier.notify();
        taken
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
        let mut found: VecDeque<(CriticalVelocityTask, Arc<[VehicleLimits]>)> = VecDeque::new();
        let mut rested = processor_time();
        while !self.stop.load(Ordering::SeqCst) {
            let Some(wanted) = self.hit.pop().or_else(|| self.others.pop()) else {
                self.notifier.wait(MAX_SLEEP);
                continue;
            };
            let (column, task) = *wanted;
            let same = found.iter().find(|(it, _)| task.has_the_result_of(it));
            let vehicles = match same {
                Some((_, vehicles)) => Arc::clone(vehicles),
                None => {
                    let is_damaged = task.is_damaged();
                    let go_on = &mut || {
                        if !is_damaged {
                            self.rest(&mut rested);
                        }
                        !self.stop.load(Ordering::Relaxed)
                    };
                    let Some(vehicles) = task.compute(go_on) else {
                        return;
                    };
                    if is_damaged {
                        // It took no part of the others' time.
                        rested = processor_time();
                    }
                    if found.len() == MAX_KNOWN {
                        found.pop_front();
                    }
                    found.push_back((task.clone(), Arc::clone(&vehicles)));
                    vehicles
                }
            };
            // There is room: a column wants nothing more of a queue before it has taken its result.
            let _ = self.known.push(Box::new((column, task, vehicles)));
            self.unknown.fetch_sub(1, Ordering::Relaxed);
            tell();
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
        while self.hit.is_empty() && !self.stop.load(Ordering::SeqCst) {
            let left = end.saturating_sub(monotonic_nanos());
            if left == 0 {
                break;
            }
            self.notifier.wait(Duration::from_nanos(left));
        }
        *rested = processor_time();
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
    use super::*;
    use crate::column::ImpactSpecification;
    use crate::parameters::Parameters;
    use crate::twin::{Command, ImpactCommand, Twin};

    /// A twin with short responses, after an impact if `is_hit`.
    fn task(is_hit: bool) -> CriticalVelocityTask {
        let values = [
            ("solver.dt", 1e-4.into()),
            ("response.duration", 0.05.into()),
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
        twin.critical_velocity_task().expect("at rest")
    }

    #[test]
    fn columns_that_have_been_hit_come_first_and_equal_ones_are_computed_once() {
        let (virgin, hit) = (task(false), task(true));
        assert!(hit.is_damaged() && !virgin.is_damaged());
        let background = Arc::new(Background::new(4));
        for (column, task) in [(0, &virgin), (1, &virgin), (2, &hit), (3, &virgin)] {
            assert!(background.want(column, task.clone()));
        }
        assert_eq!(background.unknown(), 4);
        let (sender, told) = std::sync::mpsc::sync_channel(4);
        let thread = background.start(None, move || sender.send(()).expect("listened to"));
        let results: Vec<_> = (0..4)
            .map(|_| {
                told.recv_timeout(Duration::from_secs(120))
                    .expect("a result");
                *background.take().expect("a result")
            })
            .collect();
        assert_eq!(background.unknown(), 0);
        let order: Vec<_> = results.iter().map(|(column, _, _)| *column).collect();
        assert_eq!(order, [2, 0, 1, 3]);
        for (_, task, vehicles) in &results {
            assert_eq!(Some(vehicles), task.compute(&mut || true).as_ref());
        }
        assert!(Arc::ptr_eq(&results[1].2, &results[3].2));
        background.stop();
        thread.expect("starts").join().expect("no panic");
    }
}
