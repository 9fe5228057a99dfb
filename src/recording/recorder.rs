//! The recorder: a thread and a bounded queue in front of it, so that nobody ever waits for a disk.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::error::RecordingError;
use super::repair::repair_unfinished;
use super::session::{Counters, RecorderOptions, Session};
use super::statistics::RecorderStatistics;
use super::topic::TopicInfo;
use super::writer::{Entry, check_topics};
use crate::live::{QueueStats, WhenFull, queue::Queue};

/// Name of the recorder's thread.
pub const RECORDER_THREAD: &str = "column_twin/recorder"; // the system shows the first 15 characters

/// Name of the thread that repairs at the start.
const REPAIR_THREAD: &str = "column_twin/repair";

/// How long the recorder sleeps when there is nothing to do. It is not woken: who sends would pay for that.
const NAP: Duration = Duration::from_millis(5);

/// Messages between two looks at the clock.
const BATCH: usize = 256;

/// Starts recorders.
pub struct Recorder;

impl Recorder {
    /// Starts a recorder, and repairs what a crash has left in its directory. Recordings begin with the first message.
    ///
    /// # Errors
    /// The directory cannot be written to, a topic is of an unknown type or stands twice, or the system gives no thread.
    pub fn start(
        options: RecorderOptions,
        topics: Vec<TopicInfo>,
    ) -> Result<RecorderHandle, RecordingError> {
        check_topics(&topics)?;
        check_directory(&options.directory)?;
        let shared = Arc::new(Shared {
            queue: Queue::new(
                "recording".to_owned(),
                options.queue_messages,
                WhenFull::DropNewest,
            ),
            capacity_bytes: options.queue_bytes,
            waiting_bytes: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
            counters: Arc::default(),
        });
        let repairing = {
            let (shared, options) = (Arc::clone(&shared), options.clone());
            spawn(REPAIR_THREAD, move || {
                repair_unfinished(&options, &shared.stop)
            })?
        };
        let recording = {
            let shared = Arc::clone(&shared);
            let session = Session::start(options, topics, Arc::clone(&shared.counters))?;
            spawn(RECORDER_THREAD, move || shared.run(session))?
        };
        Ok(RecorderHandle {
            shared,
            threads: Some([recording, repairing]),
        })
    }
}

fn spawn(
    name: &str,
    work: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, RecordingError> {
    thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map_err(RecordingError::Thread)
}

/// Whether recordings can be made there, found out before the first is needed.
fn check_directory(directory: &Path) -> Result<(), RecordingError> {
    let refused = |source| RecordingError::Directory {
        path: directory.to_path_buf(),
        source,
    };
    fs::create_dir_all(directory).map_err(refused)?;
    tempfile::tempfile_in(directory).map_err(refused)?;
    Ok(())
}

#[derive(Debug)]
struct Shared {
    queue: Queue<Entry>,
    capacity_bytes: usize,
    waiting_bytes: AtomicUsize,
    stop: AtomicBool,
    counters: Arc<Counters>,
}

impl Shared {
    fn record(&self, entry: Entry) -> bool {
        let bytes = entry.data.len();
        let waiting = self.waiting_bytes.fetch_add(bytes, Ordering::Relaxed);
        let taken = waiting.saturating_add(bytes) <= self.capacity_bytes && self.queue.push(entry);
        if !taken {
            self.waiting_bytes.fetch_sub(bytes, Ordering::Relaxed);
            self.counters.refused.fetch_add(1, Ordering::Relaxed);
        }
        taken
    }

    fn run(&self, mut session: Session) {
        let started = Instant::now();
        loop {
            // Looked at before the queue: what was recorded before the stop is written.
            let stop = self.stop.load(Ordering::SeqCst);
            // No more than one filling, so that who goes on sending cannot keep it from stopping.
            for taken in 0..self.queue.stats().capacity {
                let Some(entry) = self.queue.pop() else { break };
                self.waiting_bytes
                    .fetch_sub(entry.data.len(), Ordering::Relaxed);
                if taken % BATCH == 0 {
                    session.tick(started.elapsed());
                }
                session.take(entry, started.elapsed());
            }
            session.tick(started.elapsed());
            if stop {
                session.finish();
                return;
            }
            thread::park_timeout(NAP);
        }
    }

    fn statistics(&self) -> RecorderStatistics {
        let counters = &self.counters;
        let [
            written,
            written_bytes,
            refused,
            unwritten,
            write_errors,
            finished,
        ] = [
            &counters.written,
            &counters.written_bytes,
            &counters.refused,
            &counters.unwritten,
            &counters.write_errors,
            &counters.finished,
        ]
        .map(|counter| counter.load(Ordering::Relaxed));
        let queue = self.queue.stats();
        RecorderStatistics {
            queue: QueueStats {
                // Those that did not fit by their bytes were not offered to the queue itself.
                pushed: queue.pushed + refused.saturating_sub(queue.dropped),
                dropped: refused,
                ..queue
            },
            waiting_bytes: self.waiting_bytes.load(Ordering::Relaxed),
            capacity_bytes: self.capacity_bytes,
            written,
            written_bytes,
            lost: refused + unwritten,
            write_errors,
            failing: counters
                .failing
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clone(),
            current: counters
                .current
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clone(),
            finished,
        }
    }
}

/// A recorder that runs. Dropped, it stops.
#[derive(Debug)]
pub struct RecorderHandle {
    shared: Arc<Shared>,
    threads: Option<[JoinHandle<()>; 2]>,
}

impl RecorderHandle {
    /// Gives a message to the recorder, without waiting for anything; `false`, and counted, where the queue is full.
    pub fn record(&self, entry: Entry) -> bool {
        self.shared.record(entry)
    }

    /// How it does.
    #[must_use]
    pub fn statistics(&self) -> RecorderStatistics {
        self.shared.statistics()
    }

    /// Writes what waits, finishes the recording, and says how it did. Where something was
    /// [lost](RecorderStatistics::lost), the program's exit code is to be 3.
    #[must_use]
    pub fn stop(mut self) -> RecorderStatistics {
        let panicked = self.join();
        let mut statistics = self.statistics();
        if panicked {
            let reason =
                "the recorder ended by a panic; please report what it wrote to the standard error";
            statistics.failing = Some(reason.into());
            statistics.lost = statistics.lost.max(1);
        }
        statistics
    }

    fn join(&mut self) -> bool {
        self.shared.stop.store(true, Ordering::SeqCst);
        let Some(threads) = self.threads.take() else {
            return false;
        };
        threads.into_iter().fold(false, |panicked, thread| {
            thread.thread().unpark();
            thread.join().is_err() | panicked
        })
    }
}

impl Drop for RecorderHandle {
    fn drop(&mut self) {
        self.join();
    }
}
