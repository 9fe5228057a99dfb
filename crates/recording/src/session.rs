//! What a recorder does with each message. It begins recordings at checkpoints, ends them at their limits, goes on after a
//! full disk, and deletes old recordings. The caller provides the time.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use crate::chain::Hash;
use crate::compression::ChunkCompression;
use crate::error::RecordingError;
use crate::names::directory_name;
use crate::notes::REPEATED_CHECKPOINT;
use crate::report::RecorderReport;
use crate::retention::{Limits, enforce_limits};
use crate::seal::{Beginning, PreviousRecording};
use crate::seal_key::SealKey;
use crate::syncing::Syncing;
use crate::topic::TopicInfo;
use crate::writer::{APPLICATION, EndReason, Entry, Unsaved, Writer, WriterOptions};

/// How long messages stay in memory. Together with the recorder's nap and the time of a write it is shorter than
/// [`FLUSH_WITHIN`](crate::FLUSH_WITHIN).
const FLUSH_PERIOD: Duration = Duration::from_millis(25);

/// Minimum time between two records of losses in the file.
const NOTE_PERIOD: Duration = Duration::from_secs(1);

/// Without a checkpoint, a recording ends at this multiple of its limits.
const HARD_LIMIT: u32 = 2;

/// Maximum number of chunks of one recording: each needs about 300 bytes of memory until the end of the recording.
const MAX_CHUNKS: u64 = 250_000;

/// Free space that is required before recording goes on after a full disk \[bytes\].
const ROOM_TO_RESUME: u64 = 2 << 20;

/// Maximum number of recordings that begin in the same second.
const MAX_PER_SECOND: u32 = 100;

/// Receives the reports of a recorder.
pub type OnReport = Arc<dyn Fn(&RecorderReport) + Send + Sync>;

/// Options of a recorder.
#[derive(Clone)]
pub struct RecorderOptions {
    /// Directory of the recordings; it is created if it does not exist.
    pub directory: PathBuf,
    /// Compression of the chunks.
    pub compression: ChunkCompression,
    /// Whether the written data is synced to the disk every [`FLUSH_WITHIN`](crate::FLUSH_WITHIN), so that it survives a
    /// loss of power.
    pub sync: bool,
    /// Name of the recording program; the names of recordings and threads begin with it.
    pub application: String,
    /// Notes of the recording program at the beginning of each recording: its version, for example.
    pub notes: BTreeMap<String, String>,
    /// The key with which the recordings are sealed: within [`FLUSH_WITHIN`](crate::FLUSH_WITHIN), and at their end. `None`:
    /// they are not sealed.
    pub seal: Option<SealKey>,
    /// Size at which a new recording begins \[bytes\].
    pub max_file_size: u64,
    /// Duration after which a new recording begins.
    pub max_duration: Option<Duration>,
    /// Maximum number of recordings that are kept, including the current one.
    pub max_files: Option<u64>,
    /// Maximum size of all recordings that are kept, including the current one \[bytes\].
    pub max_total_size: Option<u64>,
    /// Age at which recordings are deleted.
    pub max_age: Option<Duration>,
    /// The current time; the recorder adds the time since its start.
    pub started: SystemTime,
    /// Time after a failure until the next attempt.
    pub retry_after: Duration,
    /// Maximum number of messages in the queue.
    pub queue_messages: usize,
    /// Maximum size of the messages in the queue \[bytes\].
    pub queue_bytes: usize,
    /// Called with each report, at the start and in the recorder's threads; must return quickly.
    pub on_report: Option<OnReport>,
}

impl RecorderOptions {
    /// Options to record to `directory`, with no limits except those of the queue.
    #[must_use]
    pub fn new(directory: impl Into<PathBuf>, started: SystemTime) -> Self {
        Self {
            directory: directory.into(),
            compression: ChunkCompression::None,
            sync: true,
            application: APPLICATION.to_owned(),
            notes: BTreeMap::new(),
            seal: None,
            max_file_size: u64::MAX,
            max_duration: None,
            max_files: None,
            max_total_size: None,
            max_age: None,
            started,
            retry_after: Duration::from_secs(5),
            queue_messages: 65_536,
            queue_bytes: 64 << 20,
            on_report: None,
        }
    }

    fn writer_options(&self) -> WriterOptions {
        WriterOptions {
            compression: self.compression,
            sync: self.sync,
            application: self.application.clone(),
            notes: self.notes.clone(),
            seal: self.seal.clone(),
        }
    }

    pub(crate) fn report(&self, report: &RecorderReport) {
        if let Some(on_report) = &self.on_report {
            on_report(report);
        }
    }
}

impl fmt::Debug for RecorderOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RecorderOptions")
            .field("directory", &self.directory)
            .finish_non_exhaustive()
    }
}

/// Counters that other threads read while the recorder works.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    pub written: AtomicU64,
    pub written_bytes: AtomicU64,
    /// Messages that did not fit into the queue.
    pub rejected: AtomicU64,
    /// Messages that were taken from the queue and could not be written.
    pub unwritten: AtomicU64,
    pub write_errors: AtomicU64,
    pub finished: AtomicU64,
    pub failing: Mutex<Option<Arc<str>>>,
    pub current: Mutex<Option<PathBuf>>,
}

fn set<T>(place: &Mutex<Option<T>>, value: Option<T>) {
    *place.lock().unwrap_or_else(PoisonError::into_inner) = value;
}

/// Writes one recording after the other: what a [`Recorder`](crate::Recorder) does in its thread, for a caller with messages and a time
/// of its own.
pub struct Session {
    options: RecorderOptions,
    topics: Vec<TopicInfo>,
    counters: Arc<Counters>,
    syncing: Syncing,
    writer: Option<Current>,
    /// The newest checkpoint; a recording that cannot wait for the next one begins with it.
    checkpoint: Option<Entry>,
    /// How the seal of the next recording begins.
    beginning: Option<Beginning>,
    retry_at: Option<Duration>,
    /// Losses that are recorded in a file.
    noted: u64,
    /// Losses that were reported.
    reported: u64,
    last_note: Option<Duration>,
}

struct Current {
    writer: Writer,
    began: Duration,
    last_flush: Duration,
    /// Whether messages wait to be flushed.
    unflushed: bool,
    /// All messages in it.
    written: Unsaved,
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session")
            .field("options", &self.options)
            .field("counters", &self.counters)
            .finish_non_exhaustive()
    }
}

impl Session {
    /// A session that writes to the directory of the options, which must exist. A recording begins with the first message.
    ///
    /// # Errors
    /// The system provides no thread to sync files, or no random numbers for the seal.
    pub fn start(options: RecorderOptions, topics: Vec<TopicInfo>) -> Result<Self, RecordingError> {
        Self::counting(options, topics, Arc::default())
    }

    /// As [`start`](Self::start), with counters that others read.
    pub(crate) fn counting(
        options: RecorderOptions,
        topics: Vec<TopicInfo>,
        counters: Arc<Counters>,
    ) -> Result<Self, RecordingError> {
        Ok(Self {
            syncing: Syncing::start(&options.application)?,
            beginning: options.seal.as_ref().map(Beginning::new).transpose()?,
            options,
            topics,
            counters,
            writer: None,
            checkpoint: None,
            retry_at: None,
            noted: 0,
            reported: 0,
            last_note: None,
        })
    }

    /// Records a message at the time `now` since the start.
    pub fn take(&mut self, entry: Entry, now: Duration) {
        if entry.checkpoint {
            self.checkpoint = Some(entry.clone());
        }
        let times = if entry.checkpoint { 1 } else { HARD_LIMIT };
        if self
            .writer
            .as_ref()
            .is_some_and(|current| self.is_past_limits(current, now, times))
        {
            self.end(EndReason::Rotated);
        }
        if self.writer.is_none() && !self.begin(&entry, now) {
            self.counters.unwritten.fetch_add(1, Ordering::Relaxed);
            return;
        }
        self.write(&entry, now);
    }

    fn is_past_limits(&self, current: &Current, now: Duration, times: u32) -> bool {
        let options = &self.options;
        let size = options.max_file_size.saturating_mul(u64::from(times));
        let age = options
            .max_duration
            .map(|limit| limit.saturating_mul(times));
        current.writer.bytes() >= size
            || age.is_some_and(|age| now.saturating_sub(current.began) >= age)
            || current.writer.chunks() >= MAX_CHUNKS * u64::from(times)
    }

    /// Begins a recording with the message `first`, unless it is too early for the next attempt.
    fn begin(&mut self, first: &Entry, now: Duration) -> bool {
        if self.retry_at.is_some_and(|at| now < at) {
            return false;
        }
        let room = if self.retry_at.is_some() {
            ROOM_TO_RESUME
        } else {
            0
        };
        let point = self.checkpoint.clone().filter(|_| !first.checkpoint);
        match self.create(now, room, point.is_some()) {
            Ok(writer) => {
                self.begun(writer, now);
                if let Some(point) = point {
                    self.write(&point, now);
                }
                self.writer.is_some()
            }
            Err(error) => {
                self.fail(&error, now);
                false
            }
        }
    }

    fn begun(&mut self, writer: Writer, now: Duration) {
        let directory = writer.directory().to_path_buf();
        set(&self.counters.current, Some(directory.clone()));
        set(&self.counters.failing, None);
        let report = match self.retry_at.take() {
            None => RecorderReport::Began {
                directory: directory.clone(),
            },
            Some(_) => RecorderReport::Resumed {
                directory: directory.clone(),
                lost: self.losses_to_report(),
            },
        };
        self.options.report(&report);
        self.writer = Some(Current {
            writer,
            began: now,
            last_flush: now,
            unflushed: false,
            written: Unsaved::default(),
        });
        self.delete_old(&directory, now);
    }

    fn create(
        &self,
        now: Duration,
        room: u64,
        repeats_checkpoint: bool,
    ) -> Result<Writer, RecordingError> {
        let directory = self.claim_directory(now)?;
        let mut options = self.options.writer_options();
        if repeats_checkpoint {
            let note = "an earlier recording has the messages that followed the first checkpoint";
            options
                .notes
                .insert(REPEATED_CHECKPOINT.to_owned(), note.to_owned());
        }
        let created = Writer::create_with_room(
            &directory,
            &options,
            &self.topics,
            self.beginning.clone(),
            room,
        );
        if created.is_err() {
            // The directory was created just now; if it is gone, there is nothing to remove.
            let _ = fs::remove_dir_all(&directory);
        }
        created
    }

    /// Whether this is the name of the sealed recording before, even if that was removed: the next one refers to it.
    fn is_previous(&self, name: &str) -> bool {
        let previous = self.beginning.as_ref().and_then(|it| it.previous.as_ref());
        previous.is_some_and(|it| it.name == name)
    }

    /// Creates a directory with a new name.
    fn claim_directory(&self, now: Duration) -> Result<PathBuf, RecordingError> {
        let parent = &self.options.directory;
        // It existed at the start, and may have been removed with a recording in it.
        fs::create_dir_all(parent)
            .map_err(|source| RecordingError::io("create the directory", parent, source))?;
        let name = directory_name(&self.options.application, self.options.started + now);
        for attempt in 0..MAX_PER_SECOND {
            let name = match attempt {
                0 => name.clone(),
                attempt => format!("{name}_{attempt}"),
            };
            if self.is_previous(&name) {
                continue;
            }
            let directory = parent.join(name);
            match fs::create_dir(&directory) {
                Ok(()) => return Ok(directory),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(source) => {
                    return Err(RecordingError::io(
                        "create the directory",
                        &directory,
                        source,
                    ));
                }
            }
        }
        Err(RecordingError::Exists {
            path: parent.join(name),
        })
    }

    fn delete_old(&self, current: &Path, now: Duration) {
        let limits = Limits {
            files: self.options.max_files,
            total_size: self.options.max_total_size,
            age: self.options.max_age,
        };
        for directory in enforce_limits(
            &self.options.application,
            &self.options.directory,
            current,
            self.options.started + now,
            limits,
        ) {
            self.options.report(&RecorderReport::Deleted { directory });
        }
    }

    fn write(&mut self, entry: &Entry, now: Duration) {
        let Some(current) = &mut self.writer else {
            return;
        };
        match current.writer.write(entry) {
            Ok(()) => {
                current.unflushed = true;
                current.written.messages += 1;
                current.written.bytes += entry.data.len() as u64;
                self.counters.written.fetch_add(1, Ordering::Relaxed);
                self.counters
                    .written_bytes
                    .fetch_add(entry.data.len() as u64, Ordering::Relaxed);
            }
            Err(error) => {
                self.counters.unwritten.fetch_add(1, Ordering::Relaxed);
                self.fail(&error, now);
            }
        }
    }

    /// Ends the current recording as well as possible, and schedules the next attempt.
    fn fail(&mut self, error: &RecordingError, now: Duration) {
        self.counters.write_errors.fetch_add(1, Ordering::Relaxed);
        let reason: Arc<str> = error.to_string().into();
        let first = self.retry_at.is_none();
        self.retry_at = Some(match error {
            // The disk is as it was.
            RecordingError::Removed { .. } => now,
            _ => now + self.options.retry_after,
        });
        if matches!(error, RecordingError::NoRoom { .. }) {
            self.end(EndReason::NoRoom);
        } else if let Some(current) = self.writer.take() {
            self.ends_at(current.writer.directory(), current.writer.signed());
            let unsaved = current.writer.abandon();
            self.cut_off(match error {
                RecordingError::Removed { .. } => current.written,
                _ => unsaved,
            });
        }
        set(&self.counters.current, None);
        set(&self.counters.failing, Some(Arc::clone(&reason)));
        if first {
            self.options.report(&RecorderReport::Failing {
                reason: reason.to_string(),
            });
        }
    }

    /// Finishes the recording, if there is one.
    fn end(&mut self, reason: EndReason) {
        let losses = self.new_losses();
        let Some(mut current) = self.writer.take() else {
            return;
        };
        if let Err(error) = current.writer.check_in_place() {
            self.cut_off(current.written);
            set(&self.counters.current, None);
            self.counters.write_errors.fetch_add(1, Ordering::Relaxed);
            self.options.report(&RecorderReport::Failing {
                reason: error.to_string(),
            });
            return;
        }
        current.writer.add_lost(losses);
        set(&self.counters.current, None);
        let directory = current.writer.directory().to_path_buf();
        let signed = current.writer.signed();
        match current.writer.finish_because(reason) {
            Ok(finished) => {
                self.ends_at(&directory, finished.signed);
                self.noted += losses;
                // A loss is an error even if only the end of the file records it.
                let messages = self.losses_to_report();
                if messages > 0 {
                    self.options.report(&RecorderReport::Lost { messages });
                }
                self.counters.finished.fetch_add(1, Ordering::Relaxed);
                self.options.report(&RecorderReport::Finished(finished));
            }
            Err((error, unsaved)) => {
                self.ends_at(&directory, signed);
                self.cut_off(unsaved);
                self.counters.write_errors.fetch_add(1, Ordering::Relaxed);
                self.options.report(&RecorderReport::Failing {
                    reason: error.to_string(),
                });
            }
        }
    }

    /// The next recording continues after this one, of which the last seal has signed `head`.
    fn ends_at(&mut self, directory: &Path, head: Option<Hash>) {
        if let Some((beginning, head)) = self.beginning.as_mut().zip(head) {
            let name = directory.file_name().unwrap_or_default();
            beginning.recording += 1;
            beginning.previous = Some(PreviousRecording {
                name: name.to_string_lossy().into_owned(),
                head,
            });
        }
    }

    /// Counts messages as lost that were counted as written and did not reach the file.
    fn cut_off(&self, unsaved: Unsaved) {
        let counters = &self.counters;
        counters
            .unwritten
            .fetch_add(unsaved.messages, Ordering::Relaxed);
        counters
            .written
            .fetch_sub(unsaved.messages, Ordering::Relaxed);
        counters
            .written_bytes
            .fetch_sub(unsaved.bytes, Ordering::Relaxed);
    }

    /// Losses that were not reported yet; they count as reported from now on.
    fn losses_to_report(&mut self) -> u64 {
        let lost = self.lost();
        lost - std::mem::replace(&mut self.reported, lost)
    }

    /// Losses that are not recorded in a file yet.
    fn new_losses(&self) -> u64 {
        self.lost().saturating_sub(self.noted)
    }

    /// Messages that are in no file.
    fn lost(&self) -> u64 {
        self.counters.rejected.load(Ordering::Relaxed)
            + self.counters.unwritten.load(Ordering::Relaxed)
    }

    /// Does what is due: hands data to the operating system, records losses. Has to be called regularly.
    pub fn tick(&mut self, now: Duration) {
        // First, because a file that was removed cannot be synced either, and then everything in it is lost.
        if let Some(current) = &self.writer
            && let Err(error) = current.writer.check_in_place()
        {
            self.fail(&error, now);
        }
        if let Some(current) = &self.writer
            && let Some(error) = self.syncing.take_failure(&current.writer.file())
        {
            self.fail(&error, now);
        }
        self.note_losses(now);
        let Some(current) = &mut self.writer else {
            return;
        };
        if !current.unflushed || now.saturating_sub(current.last_flush) < FLUSH_PERIOD {
            return;
        }
        current.last_flush = now;
        current.unflushed = false;
        match current.writer.hand_over() {
            Ok(Some(unsynced)) => self.syncing.request(unsynced),
            Ok(None) => {}
            Err(error) => self.fail(&error, now),
        }
    }

    fn note_losses(&mut self, now: Duration) {
        let losses = self.new_losses();
        let recently = self
            .last_note
            .is_some_and(|last| now.saturating_sub(last) < NOTE_PERIOD);
        let Some(current) = self.writer.as_mut().filter(|_| losses > 0 && !recently) else {
            return;
        };
        self.last_note = Some(now);
        current.writer.add_lost(losses);
        let noted = current.writer.note_lost();
        let messages = self.losses_to_report();
        if messages > 0 {
            self.options.report(&RecorderReport::Lost { messages });
        }
        match noted {
            Ok(()) => self.noted += losses,
            Err(error) => self.fail(&error, now),
        }
    }

    /// Finishes the current recording.
    pub fn finish(&mut self) {
        self.end(EndReason::Stopped);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reader::Reader;
    use crate::topic::OfferedQos;

    fn entry(checkpoint: bool) -> Entry {
        Entry {
            topic: 0,
            log_time: 0,
            publish_time: 0,
            data: [0, 1, 0, 0, 1, 0, 0, 0, 0].as_slice().into(),
            checkpoint,
        }
    }

    fn session(options: RecorderOptions) -> (Session, Arc<Counters>) {
        let topic = TopicInfo {
            name: "/text".to_owned(),
            type_name: "std_msgs/msg/String".to_owned(),
            schema: "string data\n".to_owned(),
            type_hash: String::new(),
            qos: OfferedQos {
                reliable: true,
                transient_local: false,
                depth: 1,
            },
        };
        let counters = Arc::<Counters>::default();
        let session = Session::counting(options, vec![topic], Arc::clone(&counters)).unwrap();
        (session, counters)
    }

    /// The numbers of messages and of lost messages of the recordings in `folder`, by name.
    fn contents(folder: &Path) -> Vec<(u64, Option<u64>)> {
        let mut directories: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|it| it.unwrap().path())
            .collect();
        directories.sort();
        let file = |it: &PathBuf| it.join(crate::writer::file_name(it));
        directories
            .iter()
            .map(|it| Reader::open(&file(it)).unwrap())
            .map(|it| (it.message_count(), it.lost_messages()))
            .collect()
    }

    #[test]
    fn what_a_failed_write_cuts_off_is_lost_and_reported_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut options = RecorderOptions::new(folder.path(), SystemTime::UNIX_EPOCH);
        let told = Arc::new(Mutex::new(Vec::new()));
        let telling = Arc::clone(&told);
        options.on_report = Some(Arc::new(move |it| {
            telling.lock().unwrap().push(it.clone());
        }));
        let (mut session, counters) = session(options);
        let counted = || {
            let count = |it: &AtomicU64| it.load(Ordering::Relaxed);
            (count(&counters.written), count(&counters.unwritten))
        };
        let at = Duration::from_millis;
        (0..4).for_each(|index| session.take(entry(index == 0), at(0)));
        session.tick(at(100));
        (0..3).for_each(|_| session.take(entry(false), at(110)));
        assert_eq!(counted(), (7, 0));
        session.writer.as_ref().unwrap().writer.break_disk();
        session.tick(at(200));
        assert_eq!(counted(), (4, 3));
        // Before the next attempt.
        session.take(entry(false), at(300));
        assert_eq!(counted(), (4, 4));
        session.take(entry(false), at(6000));
        (0..30).for_each(|index| session.tick(at(6100 + 100 * index)));
        session.take(entry(false), at(9200));
        session.writer.as_ref().unwrap().writer.break_disk();
        session.finish();
        assert_eq!(counted(), (4 + 2, 4 + 1));
        assert_eq!(contents(folder.path()), [(4, None), (2, Some(4))]);
        let told = told.lock().unwrap();
        let resumed = RecorderReport::Resumed {
            directory: folder.path().join("recording_1970_01_01-00_00_06"),
            lost: 4,
        };
        assert!(
            matches!(
                &told[..],
                [
                    RecorderReport::Began { .. },
                    RecorderReport::Failing { .. },
                    second,
                    RecorderReport::Failing { .. },
                ] if *second == resumed
            ),
            "{told:?}"
        );
    }

    /// The loss was noticed at the stop, and not counted. Then what came within the time until the next attempt was lost, too.
    #[test]
    fn a_recording_that_is_removed_while_it_is_written_is_lost_and_another_one_begins_at_once() {
        for (with_parent, is_sealed) in [(false, false), (true, false), (false, true)] {
            let folder = tempfile::tempdir().unwrap();
            let parent = folder.path().join("recordings");
            fs::create_dir(&parent).unwrap();
            let mut options = RecorderOptions::new(&parent, SystemTime::UNIX_EPOCH);
            options.seal = is_sealed.then(|| SealKey::fresh().unwrap());
            let told = Arc::new(Mutex::new(Vec::new()));
            let telling = Arc::clone(&told);
            options.on_report = Some(Arc::new(move |it| {
                telling.lock().unwrap().push(it.to_string());
            }));
            let (mut session, counters) = session(options);
            let counted = || {
                let count = |it: &AtomicU64| it.load(Ordering::Relaxed);
                (count(&counters.written), count(&counters.unwritten))
            };
            let at = Duration::from_millis;
            (0..4).for_each(|index| session.take(entry(index == 0), at(0)));
            session.tick(at(100));
            assert_eq!(counted(), (4, 0));
            let recording = parent.join("recording_1970_01_01-00_00_00");
            fs::remove_dir_all(if with_parent { &parent } else { &recording }).unwrap();
            session.tick(at(200));
            assert_eq!(counted(), (0, 4));
            assert!(told.lock().unwrap()[1].contains("was removed while"));
            session.take(entry(false), at(200));
            session.tick(at(300));
            assert_eq!(counted(), (2, 4));
            // Its seal refers to the one before.
            let again = parent.join(match is_sealed {
                true => "recording_1970_01_01-00_00_00_1",
                false => "recording_1970_01_01-00_00_00",
            });
            fs::remove_dir_all(again).unwrap();
            session.finish();
            assert_eq!(counted(), (0, 6));
        }
    }

    #[test]
    fn a_new_recording_begins_at_a_checkpoint_or_at_the_hard_limit() {
        let folder = tempfile::tempdir().unwrap();
        let mut options = RecorderOptions::new(folder.path(), SystemTime::UNIX_EPOCH);
        options.max_duration = Some(Duration::from_secs(10));
        let (mut session, counters) = session(options);
        let names = || {
            let mut names: Vec<_> = fs::read_dir(folder.path())
                .unwrap()
                .map(|it| it.unwrap().file_name().into_string().unwrap())
                .collect();
            names.sort();
            names
        };
        for (second, checkpoint, recordings) in [
            (0, true, 1),
            (9, true, 1),
            (15, false, 1),
            (16, true, 2),
            (35, false, 2),
            (36, false, 3),
        ] {
            session.take(entry(checkpoint), Duration::from_secs(second));
            assert_eq!(names().len(), recordings, "second {second}");
        }
        session.finish();
        assert_eq!(
            names(),
            ["00", "16", "36"].map(|second| format!("recording_1970_01_01-00_00_{second}"))
        );
        // The last began with the checkpoint of second 16.
        assert_eq!(counters.written.load(Ordering::Relaxed), 6 + 1);
        assert_eq!(counters.finished.load(Ordering::Relaxed), 3);
    }
}
