//! Writes the state files in one thread, because a disk may be slow.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;

use super::readers::Readers;
use crate::live::clock::Clock;
use crate::live::marked::Marked;
use crate::live::notifier::Notifier;
use crate::live::queue::{QueueStats, WhenFull};
use crate::twin::{Notice, NoticeLevel, Output, SavedState, state_file};

/// The thread's name.
pub const STATE_WRITER_THREAD: &str = "column_twin/state_file"; // the system shows the first 15 characters

/// Its stack \[B\]: a state is written as text, and the memory may be locked.
const STACK: usize = 256 << 10;

/// Most columns with a state to be written for which somebody waits for one of them: many columns that are hit at once must not hold
/// up their forecasts.
const FEW: usize = 4;

/// The states to be written, without a lock: of each column only the newest matters.
#[derive(Debug)]
pub struct Keeper {
    newest: Box<[ArrayQueue<Arc<SavedState>>]>,
    /// The columns with a state to be written.
    waiting: Marked,
    /// One more than the index of the column whose state is being written; 0: none.
    writing: AtomicUsize,
    notifier: Notifier,
    stop: AtomicBool,
    given: AtomicU64,
    failures: AtomicU64,
    written: AtomicU64,
}

impl Keeper {
    /// `paths` are the files of the columns, by their indices.
    pub fn start(
        paths: Vec<PathBuf>,
        outputs: Arc<Readers>,
        clock: Arc<dyn Clock>,
    ) -> std::io::Result<(Arc<Self>, JoinHandle<()>)> {
        let keeper = Arc::new(Self {
            newest: paths.iter().map(|_| ArrayQueue::new(1)).collect(),
            waiting: Marked::new(paths.len()),
            writing: AtomicUsize::new(0),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
            given: AtomicU64::new(0),
            failures: AtomicU64::new(0),
            written: AtomicU64::new(0),
        });
        let shared = Arc::clone(&keeper);
        let thread = thread::Builder::new()
            .name(STATE_WRITER_THREAD.to_owned())
            .stack_size(STACK)
            .spawn(move || shared.run(&paths, &outputs, &*clock))?;
        Ok((keeper, thread))
    }

    pub fn write(&self, column: u32, saved: Arc<SavedState>) {
        if let Some(newest) = self.newest.get(column as usize) {
            newest.force_push(saved);
            self.given.fetch_add(1, Ordering::Relaxed);
            self.waiting.mark(column);
            self.notifier.notify();
        }
    }

    /// Whether a state of this column is still to be written, and few others are.
    pub fn is_saving(&self, column: u32) -> bool {
        let index = column as usize;
        let is_waiting = self.newest.get(index).is_some_and(|it| !it.is_empty());
        (is_waiting || self.writing.load(Ordering::SeqCst) == index + 1)
            && self.waiting.len() <= FEW
    }

    /// Lets the thread write the last states and end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.notifier.notify();
    }

    /// Failed writes.
    pub fn failures(&self) -> u64 {
        self.failures.load(Ordering::Relaxed)
    }

    /// Files written.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    pub fn stats(&self) -> QueueStats {
        QueueStats {
            name: "state file".to_owned(),
            capacity: self.newest.len(),
            len: self.waiting.len(),
            when_full: WhenFull::DropOldest,
            pushed: self.given.load(Ordering::Relaxed),
            // A state that is replaced by a newer one before it is written is not lost.
            dropped: 0,
        }
    }

    fn run(&self, paths: &[PathBuf], outputs: &Readers, clock: &dyn Clock) {
        // One notice for a disk that is full, not one for each column.
        let mut failing = false;
        loop {
            let stop = self.stop.load(Ordering::SeqCst);
            let Some(column) = self.waiting.next() else {
                if stop {
                    return;
                }
                self.notifier.wait(Duration::MAX);
                continue;
            };
            let place = (self.newest.get(column as usize), paths.get(column as usize));
            let (Some(newest), Some(path)) = place else {
                continue;
            };
            // Before it is taken, so that at every instant it is waiting or being written.
            self.writing.store(column as usize + 1, Ordering::SeqCst);
            let Some(saved) = newest.pop() else {
                self.writing.store(0, Ordering::SeqCst);
                continue;
            };
            let result = state_file::store(path, &saved);
            self.writing.store(0, Ordering::SeqCst);
            match &result {
                Ok(()) => {
                    self.written.fetch_add(1, Ordering::Relaxed);
                }
                Err(error) => {
                    self.failures.fetch_add(1, Ordering::Relaxed);
                    if !failing {
                        let notice = Notice {
                            stamp: clock.now(),
                            level: NoticeLevel::Error,
                            text: error.to_string().into(),
                        };
                        outputs.push_of(column, Output::Notice(notice));
                        outputs.notify();
                    }
                }
            }
            failing = result.is_err();
        }
    }
}
