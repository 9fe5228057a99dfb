//! The one thread that computes the critical velocities of all columns of a fleet at rest, with the lowest priority.
//!
//! Columns that differ by their names only have the same critical velocities, which are computed once. The solver threads and
//! this one share lock-free queues only: a thread with the lowest priority must not hold a lock that they need.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use rustix::thread::CpuSet;

use super::super::background::BACKGROUND_THREAD;
use super::super::notifier::Notifier;
use super::super::real_time::THREAD_STACK;
use super::super::real_time::lower_priority;
use crate::study::VehicleLimits;
use crate::twin::CriticalVelocityTask;

/// Maximum sleep between two checks of the stop flag.
const MAX_SLEEP: Duration = Duration::from_secs(3600);

/// Results that are kept for further columns of the same kind; the oldest is dropped.
const MAX_KNOWN: usize = 64;

/// A column and what is to be computed for it.
pub type Wanted = (u32, CriticalVelocityTask);

/// A column, what was computed for it, and the result.
pub type Known = (u32, CriticalVelocityTask, Arc<[VehicleLimits]>);

/// The computation in the background.
#[derive(Debug)]
pub struct Background {
    wanted: ArrayQueue<Box<Wanted>>,
    known: ArrayQueue<Box<Known>>,
    notifier: Notifier,
    stop: AtomicBool,
}

impl Background {
    /// For a fleet of so many columns, each of which wants at most one result at a time.
    pub fn new(columns: usize) -> Self {
        Self {
            wanted: ArrayQueue::new(columns.max(1)),
            known: ArrayQueue::new(columns.max(1)),
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
        let taken = self.wanted.push(Box::new((column, task))).is_ok();
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

    /// Lets the thread end after the response that it is computing.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.notifier.notify();
    }

    fn run(&self, tell: &dyn Fn()) {
        let mut found: VecDeque<(CriticalVelocityTask, Arc<[VehicleLimits]>)> = VecDeque::new();
        while !self.stop.load(Ordering::SeqCst) {
            let Some(wanted) = self.wanted.pop() else {
                self.notifier.wait(MAX_SLEEP);
                continue;
            };
            let (column, task) = *wanted;
            let same = found.iter().find(|(it, _)| task.has_the_result_of(it));
            let vehicles = match same {
                Some((_, vehicles)) => Arc::clone(vehicles),
                None => {
                    let go_on = &mut || !self.stop.load(Ordering::Relaxed);
                    let Some(vehicles) = task.compute(go_on) else {
                        return;
                    };
                    if found.len() == MAX_KNOWN {
                        found.pop_front();
                    }
                    found.push_back((task.clone(), Arc::clone(&vehicles)));
                    vehicles
                }
            };
            // There is room: a column wants nothing more before it has taken its result.
            let _ = self.known.push(Box::new((column, task, vehicles)));
            tell();
        }
    }
}
