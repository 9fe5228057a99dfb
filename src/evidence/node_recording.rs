//! The recording of a running node.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{SystemTime, UNIX_EPOCH};

use super::entry_encoder::EntryEncoder;
use super::fleet_recording::FleetRecording;
use super::journal_line::JournalEntry;
use super::selection::{Selection, SingleRecording};
use super::topics::Topics;
use crate::endpoints::{self, Endpoint, NodeKind};
use crate::estimation::{Intake, IntakeState};
use crate::live::{QueueStats, WhenFull};
use crate::outgoing::{RecordingHealth, RecordingTap};
use crate::parameters::{RecordMode, RecordSettings};
use crate::recording::{
    self, Entry, Recorder, RecorderHandle, RecorderOptions, RecorderStatistics, RecordingError,
};
use crate::time::Nanos;
use crate::twin::{Journal, RejectionCode};

/// Records everything that a node receives and sends; a separate thread writes it.
///
/// The mode `events` leaves out the periodic messages while the column is at rest: status, and diagnostics without a
/// change of level. Both modes record every command, all its consequences, every checkpoint, and all measurements.
pub struct NodeRecording {
    /// Where the measurements come from, of the columns with sensors, which are named as in [`RecordingTap`]. Each is locked before
    /// `open`.
    intakes: RwLock<HashMap<Option<String>, Arc<Mutex<Intake>>>>,
    /// Held while a message gets its time and is queued, so that messages are recorded in the order of their times.
    open: Mutex<Open>,
    /// Journal entries that could not be encoded.
    unencoded: AtomicU64,
}

/// Gives the system time \[ns since 1970\].
pub type WallClock = Box<dyn Fn() -> Nanos + Send>;

fn system_time() -> Nanos {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    Nanos::try_from(since.as_nanos()).unwrap_or(Nanos::MAX)
}

/// The recorder, and what the next message of the recording needs.
struct Open {
    clock: WallClock,
    /// `None` after the stop.
    recorder: Option<RecorderHandle>,
    encoder: EntryEncoder,
    selection: Box<dyn Selection>,
    /// The last recorded time \[ns\]: recorded times never decrease, even if the system clock is set back.
    last_time: i64,
}

impl Open {
    fn now(&mut self) -> i64 {
        self.last_time = self.last_time.max((self.clock)());
        self.last_time
    }

    /// Records a message; `false` if the recorder has dropped it, which it counts.
    fn record(&mut self, entry: Option<Entry>) -> bool {
        let recorder = self.recorder.as_ref();
        entry.is_some_and(|entry| recorder.is_some_and(|recorder| recorder.record(entry)))
    }

    /// Records a message of the node; `false` as of [`record`](Self::record).
    fn message(&mut self, endpoint: &Endpoint, bytes: Arc<[u8]>, now: i64, published: i64) -> bool {
        let length = bytes.len();
        let entry = self.encoder.message(endpoint, bytes, now, published);
        let is_recorded = self.record(entry);
        if is_recorded {
            self.encoder.recorded_message(endpoint, now);
            self.selection.recorded(length);
        }
        is_recorded
    }
}

impl NodeRecording {
    /// Starts the recording of a node with these topics and columns as the parameters describe it, with `options` adjusted by the
    /// caller; `None` if `record.mode` is `off`. Of a fleet, both modes leave out the status of columns at rest, which need no place
    /// in the recording before they execute a command.
    ///
    /// # Errors
    /// The directory cannot be written, or the thread cannot be started.
    pub fn start(
        record: &RecordSettings,
        topics: &Topics,
        columns: Arc<[Arc<str>]>,
        options: impl FnOnce(RecorderOptions) -> RecorderOptions,
    ) -> Result<Option<Arc<Self>>, RecordingError> {
        let events_only = match record.mode {
            RecordMode::Off => return Ok(None),
            RecordMode::Events => true,
            RecordMode::Always => false,
        };
        let options = options(recording::recorder_options(record, SystemTime::now())?);
        let recorder = Recorder::start(options, topics.declared()?)?;
        let recording = Self {
            intakes: RwLock::default(),
            open: Mutex::new(Open {
                clock: Box::new(system_time),
                recorder: Some(recorder),
                encoder: EntryEncoder::new(topics, events_only),
                selection: match topics.kind() {
                    NodeKind::Single => Box::new(SingleRecording::new(events_only)),
                    NodeKind::Fleet => Box::new(FleetRecording::new(columns, record)),
                },
                last_time: 0,
            }),
            unencoded: AtomicU64::new(0),
        };
        let mut open = recording.open();
        let now = open.now();
        recording.list_columns(&mut open, now, true);
        drop(open);
        Ok(Some(Arc::new(recording)))
    }

    /// Takes the times of what follows from this clock instead of the system: in a test, hours pass at once.
    pub fn follow(&self, clock: WallClock) {
        self.open().clock = clock;
    }

    /// Writes what is queued and ends the recording; `None` if it has ended already.
    pub fn stop(&self) -> Option<RecorderStatistics> {
        let mut open = self.open();
        let now = open.now();
        self.line(&mut open, JournalEntry::End {}, None, now, None);
        let recorder = open.recorder.take();
        drop(open);
        let mut statistics = recorder.map(RecorderHandle::stop)?;
        statistics.lost += self.unencoded.load(Ordering::Relaxed);
        Some(statistics)
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn intake_of(&self, column: Option<&str>) -> Option<Arc<Mutex<Intake>>> {
        let intakes = self.intakes.read().unwrap_or_else(PoisonError::into_inner);
        intakes.get(&column.map(str::to_owned)).map(Arc::clone)
    }

    /// Lists the columns where it is due and another recording can begin; `begins` as in [`Selection::due_list`].
    fn list_columns(&self, open: &mut Open, now: i64, begins: bool) {
        if let Some(list) = open.selection.due_list(now, begins) {
            self.line(open, list, None, now, None);
        }
    }

    /// Records a line of the journal.
    fn line(
        &self,
        open: &mut Open,
        entry: JournalEntry,
        column: Option<&str>,
        now: i64,
        intake: Option<IntakeState>,
    ) {
        if open.recorder.is_none() {
            return;
        }
        let Ok(line) = open.encoder.line(entry, column, now, intake) else {
            self.unencoded.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let length = line.as_ref().map_or(0, |it| it.data.len());
        if open.record(line) {
            open.encoder.recorded_line();
            if column.is_some() {
                open.selection.recorded(length);
            }
        }
    }
}

impl RecordingTap for NodeRecording {
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>) {
        let mut open = self.open();
        let now = open.now();
        self.list_columns(&mut open, now, false);
        if open.selection.is_recorded(endpoint, bytes, now) {
            open.message(endpoint, Arc::clone(bytes), now, now);
        }
    }

    fn received(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        bytes: Vec<u8>,
        source_stamp: Option<i64>,
    ) {
        let mut open = self.open();
        let now = open.now();
        self.list_columns(&mut open, now, true);
        open.selection.received(column, now);
        let published = source_stamp.filter(|stamp| *stamp >= 0).unwrap_or(now);
        let line = EntryEncoder::received(endpoint, &bytes, published);
        open.message(endpoint, bytes.into(), now, published);
        self.line(&mut open, line, column, now, None);
    }

    fn sensors(&self, column: Option<&str>, intake: &Arc<Mutex<Intake>>) {
        let mut intakes = self.intakes.write().unwrap_or_else(PoisonError::into_inner);
        intakes.insert(column.map(str::to_owned), Arc::clone(intake));
    }

    fn measured(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        bytes: Vec<u8>,
        received: Nanos,
        intake: &Intake,
    ) {
        let mut open = self.open();
        let now = open.now();
        self.list_columns(&mut open, now, true);
        let bytes = Arc::<[u8]>::from(bytes);
        if open.message(endpoint, Arc::clone(&bytes), now, received) {
            open.encoder.recorded_measurement(received, &bytes);
        } else {
            open.encoder.lost_measurement();
        }
        if open.selection.owes_sensors(column) {
            let sensors = intake.sensors().cloned().collect();
            let entry = JournalEntry::Sensors { sensors };
            self.line(&mut open, entry, column, now, Some(intake.state()));
        }
    }

    fn rejected(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        what: &str,
        code: Option<RejectionCode>,
        reason: &str,
    ) {
        let mut open = self.open();
        let stamp = open.now();
        let entry = JournalEntry::RejectedByNode {
            stamp,
            topic: endpoint.name.to_owned(),
            what: what.to_owned(),
            code,
            reason: reason.to_owned(),
        };
        if endpoint.name == endpoints::MEASUREMENTS.name && code.is_none() {
            // The node took what it could not encode.
            open.encoder.lost_measurement();
        }
        self.line(&mut open, entry, column, stamp, None);
        // A sender that is not admitted has not been received before.
        let is_received = !matches!(
            code,
            Some(RejectionCode::SenderNotAllowed | RejectionCode::SenderTooFast)
        );
        if is_received {
            open.selection.rejected(column);
        }
    }

    fn journal(&self, column: Option<&str>, entry: &Journal) {
        // Locked until the line is recorded, so that no measurement comes between the two.
        let intake = match entry {
            Journal::Checkpoint(_) => self.intake_of(column),
            Journal::Command(_) | Journal::Status(_) => None,
        };
        let intake = intake.as_ref();
        let intake = intake.map(|it| it.lock().unwrap_or_else(PoisonError::into_inner));
        let state = intake.as_ref().map(|it| it.state());
        let mut open = self.open();
        let now = open.now();
        self.list_columns(&mut open, now, !matches!(entry, Journal::Status(_)));
        if open.selection.journal(column, entry, now) {
            let entry = JournalEntry::Twin(entry.clone());
            self.line(&mut open, entry, column, now, state);
        }
    }

    fn health(&self) -> RecordingHealth {
        let open = self.open();
        let Some(recorder) = &open.recorder else {
            return health_after_stop();
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

fn health_after_stop() -> RecordingHealth {
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
