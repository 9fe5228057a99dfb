//! Writes the state files of a fleet in one thread, because a disk may be slow.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::super::clock::Clock;
use super::super::notifier::Notifier;
use super::super::state_writer::STATE_WRITER_THREAD;
use super::readers::Readers;
use crate::twin::{Notice, NoticeLevel, Output, SavedState, state_file};

/// Its stack \[B\]: a state is written as text, and the memory may be locked.
const STACK: usize = 256 << 10;

/// The states to be written: of each column the newest, so that there are at most as many as columns.
#[derive(Debug)]
pub struct Keeper {
    newest: Mutex<BTreeMap<u32, Arc<SavedState>>>,
    notifier: Notifier,
    stop: AtomicBool,
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
            newest: Mutex::default(),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
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
        self.newest().insert(column, saved);
        self.notifier.notify();
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

    /// Held for a map operation only, never while a file is written.
    fn newest(&self) -> std::sync::MutexGuard<'_, BTreeMap<u32, Arc<SavedState>>> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, paths: &[PathBuf], outputs: &Readers, clock: &dyn Clock) {
        // One notice for a disk that is full, not one for each column.
        let mut failing = false;
        loop {
            let stop = self.stop.load(Ordering::SeqCst);
            let next = self.newest().pop_first();
            let Some((column, saved)) = next else {
                if stop {
                    return;
                }
                self.notifier.wait(Duration::MAX);
                continue;
            };
            let Some(path) = paths.get(column as usize) else {
                continue;
            };
            let result = state_file::store(path, &saved);
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
