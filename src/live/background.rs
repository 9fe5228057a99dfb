//! The thread that computes what the twin awaits in the background, with the lowest priority: the range of a verdict behind its
//! forecast, and the critical velocities of the column at rest.
//!
//! It exists only while it computes, and gets plain data. The solver's thread starts it, fetches its result, and abandons it when
//! the column or its parameters have changed: the thread ends after the response that it is computing, and nothing
//! waits for it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;

use rustix::thread::{CpuSet, sched_getaffinity};

use super::notifier::Notifier;
use super::real_time::{THREAD_STACK, lower_priority};
use crate::twin::{BackgroundTask, Command, Twin};

/// The thread's name.
pub const BACKGROUND_THREAD: &str = "column_twin/critical"; // the system shows the first 15 characters

/// The computation in the background.
#[derive(Debug)]
pub(super) struct Background {
    /// The task that was started last, until the twin no longer awaits it.
    started: Option<Started>,
    /// The processors of the program, before those of the solver were chosen.
    processors: Option<CpuSet>,
}

#[derive(Debug)]
struct Started {
    task: BackgroundTask,
    shared: Arc<SharedTask>,
}

/// What the two threads share, without a lock.
#[derive(Debug, Default)]
struct SharedTask {
    abandoned: AtomicBool,
    result: OnceLock<Command>,
}

impl Background {
    /// To be called before the calling thread gets its processors.
    pub fn new() -> Self {
        Self {
            started: None,
            processors: sched_getaffinity(None).ok(),
        }
    }

    /// Abandons what the twin no longer awaits. During a response this takes no time.
    pub fn follow(&mut self, twin: &Twin) {
        let obsolete = self.started.take_if(|it| !twin.awaits(&it.task));
        if let Some(Started { shared, .. }) = obsolete {
            shared.abandoned.store(true, Ordering::Relaxed);
        }
    }

    /// The command with the result, once it is there.
    pub fn take_result(&mut self) -> Option<Command> {
        self.started.as_ref()?.shared.result.get().cloned()
    }

    /// Starts what the twin awaits, unless it was started before. `notifier` is notified of the result.
    pub fn start(&mut self, twin: &Twin, notifier: &Arc<Notifier>) {
        if self.started.is_some() {
            return;
        }
        let Some(task) = twin.background_tasks().next() else {
            return;
        };
        let shared = Arc::<SharedTask>::default();
        self.started = Some(Started {
            task: task.clone(),
            shared: Arc::clone(&shared),
        });
        let (processors, notifier) = (self.processors, Arc::clone(notifier));
        // Without a thread the values stay unknown until something changes.
        let _ = thread::Builder::new()
            .name(BACKGROUND_THREAD.to_owned())
            .stack_size(THREAD_STACK)
            .spawn(move || {
                // A thread inherits the priority of the solver. With that it must not compute.
                if !lower_priority(processors.as_ref()) {
                    return;
                }
                let go_on = &mut || !shared.abandoned.load(Ordering::Relaxed);
                if let Some(command) = task.compute(go_on) {
                    let _ = shared.result.set(command);
                    notifier.notify();
                }
            });
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        if let Some(Started { shared, .. }) = &self.started {
            shared.abandoned.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::ImpactSpecification;
    use crate::parameters::Parameters;
    use crate::twin::ImpactCommand;

    /// A twin with so short responses that the test is short.
    fn twin() -> Twin {
        let values = [
            ("solver.dt", 1e-4.into()),
            ("response.duration", 0.05.into()),
        ];
        let parameters = Parameters::from_values(values).expect("admissible");
        Twin::new(parameters, None, Box::new(|| 0), 0).expect("stands")
    }

    #[test]
    fn the_result_becomes_a_command_once() {
        let (mut twin, mut background) = (twin(), Background::new());
        let notifier = Arc::<Notifier>::default();
        assert!(background.take_result().is_none());
        background.start(&twin, &notifier);
        let command = loop {
            notifier.wait(std::time::Duration::from_millis(10));
            background.start(&twin, &notifier);
            background.follow(&twin);
            if let Some(command) = background.take_result() {
                break command;
            }
        };
        let task = twin.critical_velocity_task().expect("awaited");
        let vehicles = task.compute(&mut || true).expect("not abandoned");
        assert_eq!(command, Command::CriticalVelocities { vehicles });
        twin.handle(command, 0, &mut Vec::new()).expect("accepted");
        background.follow(&twin);
        assert!(background.take_result().is_none());
        background.start(&twin, &notifier);
        assert!(background.started.is_none(), "nothing is to be computed");
    }

    #[test]
    fn an_impact_abandons_it() {
        let (mut twin, mut background) = (twin(), Background::new());
        background.start(&twin, &Arc::default());
        let started = background.started.as_ref().expect("awaited");
        let shared = Arc::clone(&started.shared);
        background.follow(&twin);
        assert!(!shared.abandoned.load(Ordering::Relaxed));
        let impact = Command::Impact(ImpactCommand {
            event_id: "a".to_owned(),
            column_id: twin.column_id().to_string(),
            stamp: 0,
            vehicle: String::new(),
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 5.0,
                gap: None,
                restitution: None,
                height: None,
            },
        });
        twin.handle(impact, 0, &mut Vec::new()).expect("accepted");
        background.follow(&twin);
        assert!(shared.abandoned.load(Ordering::Relaxed));
        assert!(background.started.is_none());
    }
}
