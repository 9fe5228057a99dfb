//! Makes data survive a loss of power, in a thread of its own: a disk may take half a second for that.

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use crate::error::RecordingError;
use crate::storage::Storage;
use crate::writer::sync_directory;

/// What was handed to the system and is to reach the disk.
#[derive(Debug, Clone)]
pub(crate) struct Unsynced {
    pub storage: Storage,
    pub path: PathBuf,
    /// The directory, whose entry of the file is new.
    pub directory: Option<PathBuf>,
}

impl Unsynced {
    /// Waits until it is on the disk.
    pub fn sync(&self) -> Result<(), RecordingError> {
        self.storage
            .sync_data()
            .map_err(|source| RecordingError::io("sync", &self.path, source))?;
        self.directory.as_deref().map_or(Ok(()), sync_directory)
    }
}

/// The thread, and what it is to do next: only the newest matters, for it holds what was before.
#[derive(Debug)]
pub(crate) struct Syncing {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    next: Option<Unsynced>,
    failure: Option<RecordingError>,
    stop: bool,
}

impl Syncing {
    /// Starts the thread `{application}/sync`.
    pub fn start(application: &str) -> Result<Self, RecordingError> {
        let shared = Arc::new(Shared::default());
        let work = Arc::clone(&shared);
        let thread = thread::Builder::new()
            .name(format!("{application}/sync"))
            .spawn(move || work.run())
            .map_err(RecordingError::Thread)?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Does not wait.
    pub fn request(&self, mut unsynced: Unsynced) {
        let mut state = self.shared.lock();
        // A new directory entry that is still to be synced stays so.
        let waiting = state.next.take().filter(|it| it.path == unsynced.path);
        unsynced.directory = unsynced.directory.or(waiting.and_then(|it| it.directory));
        state.next = Some(unsynced);
        self.shared.changed.notify_one();
    }

    /// What went wrong since this was asked last.
    pub fn take_failure(&self) -> Option<RecordingError> {
        self.shared.lock().failure.take()
    }
}

impl Drop for Syncing {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // a panic has been written by its thread
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self) {
        loop {
            let mut state = self.lock();
            let unsynced = loop {
                match state.next.take() {
                    Some(unsynced) => break unsynced,
                    None if state.stop => return,
                    None => {
                        state = self
                            .changed
                            .wait(state)
                            .unwrap_or_else(PoisonError::into_inner);
                    }
                }
            };
            drop(state);
            if let Err(error) = unsynced.sync() {
                self.lock().failure = Some(error);
            }
        }
    }
}
