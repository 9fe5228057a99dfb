//! Writes the state file in a separate thread, because a disk may be slow.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::clock::Clock;
use super::notifier::Notifier;
use super::queue::{OutputQueues, Queue, QueueStats, WhenFull};
use super::real_time::THREAD_STACK;
use crate::twin::{Notice, NoticeLevel, Output, SavedState, state_file};

/// The thread's name.
pub const STATE_WRITER_THREAD: &str = "column_twin/state_file"; // the system shows the first 15 characters

/// The state to be written: only the newest matters.
#[derive(Debug)]
pub(super) struct StateWriter {
    newest: Queue<Arc<SavedState>>,
    notifier: Notifier,
    stop: AtomicBool,
    failures: AtomicU64,
}

impl StateWriter {
    pub fn start(
        path: PathBuf,
        outputs: Vec<Arc<OutputQueues>>,
        clock: Arc<dyn Clock>,
    ) -> std::io::Result<(Arc<Self>, JoinHandle<()>)> {
        let state_writer = Arc::new(Self {
            newest: Queue::new("state file".to_owned(), 1, WhenFull::DropOldest),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
            failures: AtomicU64::new(0),
        });
        let shared = Arc::clone(&state_writer);
        let thread = thread::Builder::new()
            .name(STATE_WRITER_THREAD.to_owned())
            .stack_size(THREAD_STACK)
            .spawn(move || shared.run(&path, &outputs, &*clock))?;
        Ok((state_writer, thread))
    }

    pub fn write(&self, saved: Arc<SavedState>) {
        self.newest.push(saved);
        self.notifier.notify();
    }

    /// Lets the thread write the last state and end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.notifier.notify();
    }

    /// Number of failed writes.
    pub fn failures(&self) -> u64 {
        self.failures.load(Ordering::Relaxed)
    }

    pub fn stats(&self) -> QueueStats {
        // A state that is replaced by a newer one before it is written is not lost.
        QueueStats {
            dropped: 0,
            ..self.newest.stats()
        }
    }

    fn run(&self, path: &std::path::Path, outputs: &[Arc<OutputQueues>], clock: &dyn Clock) {
        let mut failing = false;
        loop {
            let stop = self.stop.load(Ordering::SeqCst);
            let Some(saved) = self.newest.pop() else {
                if stop {
                    return;
                }
                self.notifier.wait(Duration::MAX);
                continue;
            };
            let result = state_file::store(path, &saved);
            if let Err(error) = &result {
                self.failures.fetch_add(1, Ordering::Relaxed);
                if !failing {
                    report(error.to_string(), outputs, clock);
                }
            }
            failing = result.is_err();
        }
    }
}

fn report(text: String, outputs: &[Arc<OutputQueues>], clock: &dyn Clock) {
    let text: Arc<str> = text.into();
    for queues in outputs {
        let text = Arc::clone(&text);
        queues.push(Output::Notice(Notice {
            stamp: clock.now(),
            level: NoticeLevel::Error,
            text,
        }));
        queues.notify();
    }
}
