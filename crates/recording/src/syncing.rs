//! Makes data survive a loss of power, in a separate thread, because a disk may need half a second for it.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use crate::error::RecordingError;
use crate::storage::{FileIdentity, Unsynced};

/// The thread and its next task. Only the newest task matters, because it includes the ones before.
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
    /// The newest failure, with the file that it concerns.
    failure: Option<(FileIdentity, RecordingError)>,
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

    /// Requests synchronization without waiting for it.
    pub fn request(&self, mut unsynced: Unsynced) {
        let mut state = self.shared.lock();
        // A new directory entry that has not been synced yet is kept.
        let written = unsynced.storage.identity();
        let waiting = (state.next.take()).filter(|it| it.storage.identity() == written);
        unsynced.directory = unsynced.directory.or(waiting.and_then(|it| it.directory));
        state.next = Some(unsynced);
        self.shared.changed.notify_one();
    }

    /// The failure since the last call, if there was one that concerns the file `written`. The end of an earlier recording has been
    /// reported, and its failures must not end the next one.
    pub fn take_failure(&self, written: &FileIdentity) -> Option<RecordingError> {
        let (failed, error) = self.shared.lock().failure.take()?;
        (failed == *written).then_some(error)
    }
}

impl Drop for Syncing {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // a panic was reported by the thread itself
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
                self.lock().failure = Some((unsynced.storage.identity(), error));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::Storage;

    /// The thread noticed that a directory had been removed only after the next recording had begun, and ended that one, even one that had
    /// got the path of the first.
    #[test]
    fn a_failure_of_an_earlier_recording_does_not_end_the_next_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("removed.mcap");
        let fail = || {
            let syncing = Syncing::start("test").unwrap();
            let storage = Storage::create(&path).unwrap();
            let failed = storage.identity();
            syncing.request(Unsynced {
                storage,
                path: path.clone(),
                directory: Some(folder.path().join("removed")),
            });
            std::fs::remove_file(&path).unwrap();
            while syncing.shared.lock().failure.is_none() {
                thread::yield_now();
            }
            (syncing, failed)
        };
        let (syncing, _) = fail();
        let next = Storage::create(&path).unwrap();
        assert!(syncing.take_failure(&next.identity()).is_none());
        drop(next);
        std::fs::remove_file(&path).unwrap();
        let (syncing, failed) = fail();
        assert!(syncing.take_failure(&failed).is_some());
    }
}
