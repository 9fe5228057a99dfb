//! Writes a recording anew that was cut off or damaged. The original stays as it is.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use mcap::records::Metadata;

use crate::bag_metadata::METADATA_FILE;
use crate::error::RecordingError;
use crate::reader::{Reader, RecordedTopic};
use crate::report::RecorderReport;
use crate::retention::{find_recordings, mcap_files};
use crate::session::RecorderOptions;
use crate::storage::is_being_written;
use crate::writer::{
    APPLICATION, Described, Ended, LOSSES, REPAIR, Writer, WriterOptions, record, record_name,
};

/// What the name of a recording that was written anew ends with.
const SUFFIX: &str = "_repaired";

/// What the names of directories begin with in which a recording is written anew.
const WORKSHOP: &str = ".rosbag2-repair-";

/// Most recordings that are repaired at a start, the newest first.
const MAX_AT_START: usize = 16;

/// A recording that was written anew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repaired {
    /// What was read.
    pub source: PathBuf,
    /// What was written.
    pub directory: PathBuf,
    /// Messages that were saved.
    pub messages: u64,
    /// Records that were damaged and are left out.
    pub left_out: u64,
    /// Whether the file ended in the middle of a record.
    pub in_record: bool,
    /// What was wrong.
    pub fault: String,
}

impl fmt::Display for Repaired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            source,
            directory,
            messages,
            left_out,
            fault,
            ..
        } = self;
        write!(
            f,
            "{} was {fault}. Its {messages} messages are written anew to {}; the original stays as it was.",
            source.display(),
            directory.display()
        )?;
        if *left_out > 0 {
            write!(f, " {left_out} damaged records could not be saved.")?;
        }
        Ok(())
    }
}

/// Writes the recording `source` (a directory or an `.mcap` file) anew to the directory `output`, by default beside it with
/// `_repaired` behind its name. Nothing is overwritten. `None` where there is nothing to repair.
///
/// # Errors
/// There is no recording, nothing in it can be saved, or the new one cannot be written; then none is left behind.
pub fn repair(source: &Path, output: Option<&Path>) -> Result<Option<Repaired>, RecordingError> {
    repair_unless(source, output, &AtomicBool::new(false))
}

fn repair_unless(
    source: &Path,
    output: Option<&Path>,
    stop: &AtomicBool,
) -> Result<Option<Repaired>, RecordingError> {
    let has_metadata = !source.is_dir() || source.join(METADATA_FILE).exists();
    let reader = if has_metadata {
        Reader::open(source)?
    } else {
        open_unfinished(source)?
    };
    if has_metadata && reader.wholeness().is_whole() {
        return Ok(None);
    }
    if reader.files().iter().any(|file| is_being_written(file)) {
        return Err(RecordingError::BeingWritten {
            path: source.to_path_buf(),
        });
    }
    if reader.topics().is_empty() {
        return Err(RecordingError::NothingToSave {
            path: source.to_path_buf(),
            reason: format!("it declares no topic; it is {}", reader.wholeness()),
        });
    }
    let directory = output.map_or_else(|| beside(source), Path::to_path_buf);
    if directory.symlink_metadata().is_ok() {
        return Err(RecordingError::Exists { path: directory });
    }
    let fault = match reader.wholeness().is_whole() {
        true => "without metadata.yaml".to_owned(),
        false => reader.wholeness().to_string(),
    };
    let messages = write_anew(&reader, &fault, &directory, stop)?;
    Ok(Some(Repaired {
        source: source.to_path_buf(),
        directory,
        messages,
        left_out: reader.wholeness().damaged,
        in_record: reader.wholeness().ends_in_record,
        fault,
    }))
}

/// A directory that its writer could not finish.
fn open_unfinished(directory: &Path) -> Result<Reader, RecordingError> {
    let files =
        mcap_files(directory).map_err(|source| RecordingError::io("read", directory, source))?;
    if files.is_empty() || files.iter().any(|file| is_being_written(file)) {
        // Says why.
        return Reader::open(directory);
    }
    Reader::open_files(directory, files)
}

/// Where the new recording goes.
fn beside(source: &Path) -> PathBuf {
    let whole = fs::canonicalize(source).unwrap_or_else(|_| source.to_path_buf());
    let name = match source.is_dir() {
        true => whole.file_name(),
        false => whole.file_stem(),
    };
    let name = name.unwrap_or_default().to_string_lossy();
    let parent = source.parent().unwrap_or(Path::new(""));
    parent.join(format!("{name}{SUFFIX}"))
}

/// Writes it in a directory of another name, which gets its own when it is complete.
fn write_anew(
    reader: &Reader,
    fault: &str,
    directory: &Path,
    stop: &AtomicBool,
) -> Result<u64, RecordingError> {
    let parent = match directory.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let failed = |source| RecordingError::io("write to", parent, source);
    let workshop = tempfile::Builder::new()
        .prefix(WORKSHOP)
        .tempdir_in(parent)
        .map_err(failed)?;
    let name = directory.file_name().unwrap_or_default();
    let unnamed = workshop.path().join(name);
    let topics = reader.topics().iter().map(Described::from).collect();
    let options = WriterOptions {
        compression: reader.compression(),
        application: application(reader).to_owned(),
        ..WriterOptions::default()
    };
    let mut writer = Writer::create_with(&unnamed, &options, topics, &records(reader, fault), 0)?;
    writer.add_lost(reader.lost_messages().unwrap_or(0));
    for message in reader.messages_as_written() {
        if stop.load(Ordering::Relaxed) {
            return Err(failed(std::io::Error::from(
                std::io::ErrorKind::Interrupted,
            )));
        }
        // Damage was counted when the recording was opened.
        let message = match message {
            Ok(message) => message,
            Err(RecordingError::Damaged { .. }) => continue,
            Err(error) => return Err(error),
        };
        let [log_time, publish_time] =
            [message.log_time, message.publish_time].map(|it| u64::try_from(it).unwrap_or(0));
        writer.write_message(message.topic_index, log_time, publish_time, &message.data)?;
    }
    let finished = writer
        .finish_because(Ended::Repaired)
        .map_err(|(error, _)| error)?;
    if directory.symlink_metadata().is_ok() {
        return Err(RecordingError::Exists {
            path: directory.to_path_buf(),
        });
    }
    fs::rename(&unnamed, directory)
        .map_err(|source| RecordingError::io("name", directory, source))?;
    Ok(finished.messages)
}

/// The program that recorded it.
fn application(reader: &Reader) -> &str {
    reader.application().unwrap_or(APPLICATION)
}

/// The metadata that is kept, and that of the repair.
fn records(reader: &Reader, fault: &str) -> Vec<Metadata> {
    let kept = reader
        .metadata()
        .iter()
        .filter(|(name, _)| name != "rosbag2" && !name.ends_with(LOSSES));
    let mut records: Vec<Metadata> = kept
        .map(|(name, entries)| Metadata {
            name: name.clone(),
            metadata: entries.clone(),
        })
        .collect();
    let source = reader
        .path()
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let damaged = reader.wholeness().damaged.to_string();
    records.push(record(
        record_name(application(reader), REPAIR),
        [
            ("source", source),
            ("fault", fault.to_owned()),
            ("damaged_records", damaged),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ],
    ));
    records
}

impl From<&RecordedTopic> for Described {
    fn from(topic: &RecordedTopic) -> Self {
        Self {
            name: topic.name.to_string(),
            type_name: topic.type_name.to_string(),
            schema_encoding: topic.schema_encoding.clone(),
            schema: topic.schema.to_vec(),
            message_encoding: topic.encoding.clone(),
            metadata: topic.metadata.clone(),
        }
    }
}

/// Repairs what crashes have left in the directory of the recordings.
pub(crate) fn repair_unfinished(options: &RecorderOptions, stop: &AtomicBool) {
    remove_workshops(&options.directory);
    let unfinished: Vec<PathBuf> = find_recordings(&options.application, &options.directory)
        .into_iter()
        .map(|found| found.directory)
        .filter(|directory| is_unfinished(directory))
        .collect();
    for directory in unfinished.into_iter().rev().take(MAX_AT_START) {
        let report = match repair_unless(&directory, None, stop) {
            Ok(None) => continue,
            Ok(Some(repaired)) => RecorderReport::Repaired(repaired),
            Err(_) if stop.load(Ordering::Relaxed) => return,
            Err(error) => RecorderReport::NotRepaired {
                directory,
                reason: error.to_string(),
            },
        };
        options.say(&report);
    }
}

fn is_unfinished(directory: &Path) -> bool {
    let files = mcap_files(directory).unwrap_or_default();
    !files.is_empty()
        && !directory.join(METADATA_FILE).exists()
        && !beside(directory).exists()
        && !files.iter().any(|file| is_being_written(file))
}

/// Removes what repairs have left that were themselves cut off.
fn remove_workshops(parent: &Path) {
    let entries = fs::read_dir(parent).into_iter().flatten().flatten();
    for workshop in entries.filter(|it| it.file_name().to_string_lossy().starts_with(WORKSHOP)) {
        let inside = fs::read_dir(workshop.path())
            .into_iter()
            .flatten()
            .flatten();
        let mut files = inside.flat_map(|it| mcap_files(&it.path()).unwrap_or_default());
        if !files.any(|file| is_being_written(&file)) {
            // Should it stay, it is tried again at the next start.
            let _ = fs::remove_dir_all(workshop.path());
        }
    }
}
