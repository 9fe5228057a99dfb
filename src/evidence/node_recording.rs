//! The recording of a running node.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{SystemTime, UNIX_EPOCH};

use super::entries::Entries;
use super::journal_line::{Line, LineEntry};
use super::topics::Topics;
use crate::endpoints::{self, Endpoint};
use crate::live::{QueueStats, WhenFull};
use crate::messages::cdr;
use crate::messages::column_twin::TwinStatus;
use crate::messages::diagnostic_msgs::DiagnosticArray;
use crate::outgoing::{RecordingHealth, RecordingTap};
use crate::parameters::{RecordMode, RecordSettings};
use crate::recording::{
    self, Entry, Recorder, RecorderHandle, RecorderOptions, RecorderStatistics, RecordingError,
};
use crate::twin::Journal;

/// Takes a copy of everything that a node receives and sends; a thread of its own writes it.
///
/// The mode `events` leaves out what only repeats itself while the column is at rest: status, and diagnostics in which
/// no level changes. Every input, all that it leads to, and every checkpoint is recorded in both modes.
pub struct NodeRecording {
    /// Until it is stopped.
    recorder: RwLock<Option<RecorderHandle>>,
    entries: Entries,
    events_only: bool,
    /// Something has happened since the last status at rest.
    going_on: AtomicBool,
    /// The levels of the newest diagnostics.
    levels: Mutex<Option<Vec<u8>>>,
    /// Recorded times never go back, whatever is done to the clock \[ns\].
    last_time: AtomicI64,
    /// What could not even be offered to the recorder.
    unencoded: AtomicU64,
}

impl NodeRecording {
    /// Starts to record as the parameters say; `None` where they say nothing is. `options` have the last word.
    ///
    /// # Errors
    /// The directory cannot be written, or there is no thread.
    pub fn start(
        record: &RecordSettings,
        topics: &Topics,
        options: impl FnOnce(RecorderOptions) -> RecorderOptions,
    ) -> Result<Option<Arc<Self>>, RecordingError> {
        let events_only = match record.mode {
            RecordMode::Off => return Ok(None),
            RecordMode::Events => true,
            RecordMode::Always => false,
        };
        let options = options(recording::recorder_options(record, SystemTime::now()));
        let recorder = Recorder::start(options, topics.declared()?)?;
        Ok(Some(Arc::new(Self {
            recorder: RwLock::new(Some(recorder)),
            entries: Entries::new(topics),
            events_only,
            going_on: AtomicBool::new(true),
            levels: Mutex::default(),
            last_time: AtomicI64::new(0),
            unencoded: AtomicU64::new(0),
        })))
    }

    /// Writes what is waiting and ends the recording. `None` where it has ended before.
    pub fn stop(&self) -> Option<RecorderStatistics> {
        let recorder = self
            .recorder
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let mut statistics = recorder.map(RecorderHandle::stop)?;
        statistics.lost += self.unencoded.load(Ordering::Relaxed);
        Some(statistics)
    }

    fn now(&self) -> i64 {
        let since = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let now = i64::try_from(since.as_nanos()).unwrap_or(i64::MAX);
        self.last_time.fetch_max(now, Ordering::Relaxed).max(now)
    }

    fn offer(&self, entry: Option<Entry>) {
        let recorder = self.recorder.read().unwrap_or_else(PoisonError::into_inner);
        if let (Some(recorder), Some(entry)) = (&*recorder, entry) {
            recorder.record(entry); // what is refused is counted there
        }
    }

    fn offer_line(&self, line: Result<Option<Entry>, super::JournalError>) {
        match line {
            Ok(entry) => self.offer(entry),
            Err(_) => {
                self.unencoded.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    /// Whether the mode lets it through.
    fn wanted(&self, endpoint: &Endpoint, bytes: &[u8]) -> bool {
        if !self.events_only {
            return true;
        }
        let repeats = [endpoints::TWIN_STATUS.name, endpoints::DIAGNOSTICS.name];
        if !repeats.contains(&endpoint.name) {
            return true;
        }
        let going_on = self.going_on.load(Ordering::Relaxed);
        if endpoint.name == endpoints::DIAGNOSTICS.name {
            return self.changes_a_level(bytes) || going_on;
        }
        if is_at_rest(bytes) {
            self.going_on.store(false, Ordering::Relaxed);
        }
        going_on
    }

    /// Whether these diagnostics say of something that it is better or worse than before.
    fn changes_a_level(&self, diagnostics: &[u8]) -> bool {
        let Ok(array) = cdr::decode::<DiagnosticArray>(diagnostics) else {
            return true;
        };
        let levels = Some(array.status.iter().map(|it| it.level).collect());
        let mut last = self.levels.lock().unwrap_or_else(PoisonError::into_inner);
        let changed = *last != levels;
        *last = levels;
        changed
    }
}

/// Whether a status says that nothing goes on.
fn is_at_rest(status: &[u8]) -> bool {
    cdr::decode::<TwinStatus>(status).is_ok_and(|status| {
        !matches!(
            status.phase,
            TwinStatus::APPROACH | TwinStatus::CONTACT | TwinStatus::FREE
        )
    })
}

impl RecordingTap for NodeRecording {
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>) {
        if self.wanted(endpoint, bytes) {
            let now = self.now();
            self.offer(Entries::message(endpoint, Arc::clone(bytes), now, now));
        }
    }

    fn received(&self, endpoint: &Endpoint, bytes: Vec<u8>, source_stamp: Option<i64>) {
        let now = self.now();
        let published = source_stamp.filter(|stamp| *stamp >= 0).unwrap_or(now);
        self.offer(Entries::message(endpoint, bytes.into(), now, published));
    }

    fn not_taken(&self, endpoint: &Endpoint, what: &str, reason: &str) {
        let stamp = self.now();
        let entry = LineEntry::RefusedByNode {
            stamp,
            topic: endpoint.name.to_owned(),
            what: what.to_owned(),
            reason: reason.to_owned(),
        };
        self.offer_line(Entries::line(&Line::new(entry, None), stamp));
    }

    fn journal(&self, entry: &Journal) {
        match entry {
            Journal::Command(_) => self.going_on.store(true, Ordering::Relaxed),
            // It goes with the status that follows it, and that one is left out.
            Journal::Status(_) if self.events_only && !self.going_on.load(Ordering::Relaxed) => {
                return;
            }
            Journal::Checkpoint(_) | Journal::Status(_) => {}
        }
        self.offer_line(self.entries.journal(entry, self.now()));
    }

    fn health(&self) -> RecordingHealth {
        let recorder = self.recorder.read().unwrap_or_else(PoisonError::into_inner);
        let Some(recorder) = &*recorder else {
            return stopped();
        };
        let RecorderStatistics {
            queue,
            waiting_bytes,
            capacity_bytes,
            written,
            written_bytes,
            lost,
            write_errors,
            failing,
            current,
            finished,
        } = recorder.statistics();
        let current = current.map_or_else(
            || "none".to_owned(),
            |directory| directory.display().to_string(),
        );
        let values = [
            ("recording", current),
            (
                "waiting bytes",
                format!("{waiting_bytes} of {capacity_bytes}"),
            ),
            ("messages written", written.to_string()),
            ("bytes written", written_bytes.to_string()),
            ("write errors", write_errors.to_string()),
            ("recordings finished", finished.to_string()),
        ];
        RecordingHealth {
            queue: QueueStats {
                name: "recording".to_owned(),
                capacity: queue.capacity,
                len: queue.len,
                when_full: WhenFull::DropNewest,
                pushed: queue.pushed,
                dropped: queue.dropped,
            },
            lost: lost + self.unencoded.load(Ordering::Relaxed),
            problem: failing.map(|reason| reason.to_string()),
            values: values
                .map(|(name, value)| (name.to_owned(), value))
                .to_vec(),
        }
    }
}

fn stopped() -> RecordingHealth {
    RecordingHealth {
        queue: QueueStats {
            name: "recording".to_owned(),
            capacity: 0,
            len: 0,
            when_full: WhenFull::DropNewest,
            pushed: 0,
            dropped: 0,
        },
        lost: 0,
        problem: None,
        values: Vec::new(),
    }
}
