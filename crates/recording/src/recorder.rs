//! The recorder: a thread with a bounded queue in front of it, so that the sender of a message never waits for a disk.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::described::check_topics;
use crate::error::RecordingError;
use crate::report::RecorderReport;
use crate::session::{Counters, RecorderOptions, Session};
use crate::startup::repair_unfinished;
use crate::statistics::{QueueStatistics, RecorderStatistics};
use crate::topic::TopicInfo;
use crate::writer::Entry;

/// How long the recorder sleeps when the queue is empty. Senders do not wake it, because that would cost them time.
const NAP: Duration = Duration::from_millis(5);

/// Messages between two looks at the clock.
const BATCH: usize = 256;

/// Starts recorders.
pub struct Recorder;

impl Recorder {
    /// Starts a recorder, and repairs recordings in its directory that a crash has cut off. A recording begins with the
    /// first message.
    ///
    /// # Errors
    /// The directory cannot be written to, a topic is declared twice, or the system provides no thread.
    pub fn start(
        options: RecorderOptions,
        topics: Vec<TopicInfo>,
    ) -> Result<RecorderHandle, RecordingError> {
        check_topics(&topics)?;
        check_directory(&options.directory)?;
        if let Some(key) = &options.seal {
            options.report(&RecorderReport::Sealing {
                key: key.public_key(),
                path: key.path().map(Path::to_path_buf),
            });
            if let Some(warning) = key.warning() {
                let warning = warning.to_owned();
                options.report(&RecorderReport::ExposedKey { warning });
            }
        }
        let application = options.application.clone();
        let (sender, receiver) = sync_channel(options.queue_messages.max(1));
        let shared = Arc::new(Shared {
            capacity: options.queue_messages.max(1),
            capacity_bytes: options.queue_bytes,
            pushed: AtomicU64::new(0),
            waiting: AtomicUsize::new(0),
            waiting_bytes: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
            counters: Arc::default(),
        });
        let repairing = {
            let (shared, options) = (Arc::clone(&shared), options.clone());
            spawn(format!("{application}/repair"), move || {
                repair_unfinished(&options, &shared.stop)
            })?
        };
        let recording = {
            let shared = Arc::clone(&shared);
            let session = Session::counting(options, topics, Arc::clone(&shared.counters))?;
            spawn(format!("{application}/recorder"), move || {
                shared.run(&receiver, session);
            })?
        };
        Ok(RecorderHandle {
            sender,
            shared,
            threads: Some([recording, repairing]),
        })
    }
}

fn spawn(
    name: String,
    work: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, RecordingError> {
    thread::Builder::new()
        .name(name)
        .spawn(work)
        .map_err(RecordingError::Thread)
}

/// Checks that recordings can be written to the directory before the first message arrives.
fn check_directory(directory: &Path) -> Result<(), RecordingError> {
    let unusable = |source| RecordingError::Directory {
        path: directory.to_path_buf(),
        source,
    };
    fs::create_dir_all(directory).map_err(unusable)?;
    tempfile::tempfile_in(directory).map_err(unusable)?;
    Ok(())
}

#[derive(Debug)]
struct Shared {
    capacity: usize,
    capacity_bytes: usize,
    /// Messages that were offered.
    pushed: AtomicU64,
    /// Messages in the queue.
    waiting: AtomicUsize,
    /// Their bytes.
    waiting_bytes: AtomicUsize,
    stop: AtomicBool,
    counters: Arc<Counters>,
}

impl Shared {
    fn run(&self, queue: &Receiver<Entry>, mut session: Session) {
        let started = Instant::now();
        loop {
            // Read before the queue, so that everything recorded before the stop is written.
            let stop = self.stop.load(Ordering::SeqCst);
            // At most the content of one full queue, so that a sender that never pauses cannot prevent the stop.
            for (taken, entry) in queue.try_iter().take(self.capacity).enumerate() {
                self.waiting.fetch_sub(1, Ordering::Relaxed);
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
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let dropped = read(&counters.rejected);
        RecorderStatistics {
            queue: QueueStatistics {
                capacity: self.capacity,
                len: self.waiting.load(Ordering::Relaxed),
                pushed: read(&self.pushed),
                dropped,
            },
            waiting_bytes: self.waiting_bytes.load(Ordering::Relaxed),
            capacity_bytes: self.capacity_bytes,
            written: read(&counters.written),
            written_bytes: read(&counters.written_bytes),
            lost: dropped + read(&counters.unwritten),
            write_errors: read(&counters.write_errors),
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
            finished: read(&counters.finished),
        }
    }
}

/// A running recorder. It stops when it is dropped.
#[derive(Debug)]
pub struct RecorderHandle {
    sender: SyncSender<Entry>,
    shared: Arc<Shared>,
    threads: Option<[JoinHandle<()>; 2]>,
}

impl RecorderHandle {
    /// Gives a message to the recorder without waiting. If the queue is full, the message is dropped and counted, and
    /// the result is `false`.
    pub fn record(&self, entry: Entry) -> bool {
        let shared = &self.shared;
        let bytes = entry.data.len();
        shared.pushed.fetch_add(1, Ordering::Relaxed);
        shared.waiting.fetch_add(1, Ordering::Relaxed);
        let waiting = shared.waiting_bytes.fetch_add(bytes, Ordering::Relaxed);
        let taken = waiting.saturating_add(bytes) <= shared.capacity_bytes
            && self.sender.try_send(entry).is_ok();
        if !taken {
            shared.waiting.fetch_sub(1, Ordering::Relaxed);
            shared.waiting_bytes.fetch_sub(bytes, Ordering::Relaxed);
            shared.counters.rejected.fetch_add(1, Ordering::Relaxed);
        }
        taken
    }

    /// The state of the recorder.
    #[must_use]
    pub fn statistics(&self) -> RecorderStatistics {
        self.shared.statistics()
    }

    /// Writes the waiting messages, finishes the recording, and returns the final statistics. If messages were
    /// [lost](RecorderStatistics::lost), the program should end with an error.
    #[must_use]
    pub fn stop(mut self) -> RecorderStatistics {
        let panicked = self.join();
        let mut statistics = self.statistics();
        if panicked {
            let reason =
                "the recorder's thread panicked; please report its output on the standard error";
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
