//! Repairs a recording that was cut off or damaged by writing a new one. The original is not changed.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use mcap::records::Metadata;

use crate::described::Described;
use crate::error::RecordingError;
use crate::notes::{REPAIR, UNREAD, record, record_name};
use crate::reader::{Item, Reader};
use crate::retention::mcap_files;
use crate::seal::{BEGIN, SEAL};
use crate::seal_check::Seal;
use crate::storage::is_being_written;
use crate::writer::{APPLICATION, EndReason, Writer, WriterOptions};

/// End of the name of a repaired recording.
const SUFFIX: &str = "_repaired";

/// Beginning of the names of the temporary directories of repairs.
pub(crate) const TEMPORARY: &str = ".rosbag2-repair-";

/// A recording that was repaired.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repaired {
    /// The original.
    pub source: PathBuf,
    /// The new recording.
    pub directory: PathBuf,
    /// Number of saved messages.
    pub messages: u64,
    /// Number of damaged records, which are left out.
    pub left_out: u64,
    /// Whether the file ended in the middle of a record.
    pub in_record: bool,
    /// What was wrong with the original.
    pub fault: String,
    /// The seal of the original, which the new recording has, too.
    pub seal: Option<Seal>,
    /// Whether the original had seals that the new recording has not, because they were of several files.
    pub seals_lost: bool,
}

impl fmt::Display for Repaired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            source,
            directory,
            messages,
            left_out,
            fault,
            seal,
            seals_lost,
            ..
        } = self;
        write!(
            f,
            "{} was {fault}. Its {messages} messages were saved to {}; the original was not changed.",
            source.display(),
            directory.display()
        )?;
        if *left_out > 0 {
            write!(f, " {left_out} damaged records could not be saved.")?;
        }
        match seal {
            Some(Seal {
                fault: Some(reason),
                covered,
                ..
            }) => write!(
                f,
                " Its seal covers the first {covered} messages only, and does not hold beyond them: {reason}."
            )?,
            Some(Seal { covered: 0, .. }) => f.write_str(" Its seal covers none of them.")?,
            Some(Seal {
                covered,
                uncovered: 0,
                ..
            }) => {
                write!(f, " Its seal covers all of the {covered} messages.")?;
            }
            Some(Seal {
                covered, uncovered, ..
            }) => write!(
                f,
                " Its seal covers the first {covered} messages, and not the last {uncovered}."
            )?,
            None if *seals_lost => {
                f.write_str(" The seals were lost, because several files have become one.")?;
            }
            None => {}
        }
        Ok(())
    }
}

/// Repairs the recording `source` (a directory or an `.mcap` file) into the new directory `output`; the default is a
/// directory next to it whose name ends with `_repaired`. Nothing is overwritten. `None`: there is nothing to repair.
///
/// # Errors
/// There is no recording, nothing in it can be saved, or the new recording cannot be written; in that case none is left.
pub fn repair(source: &Path, output: Option<&Path>) -> Result<Option<Repaired>, RecordingError> {
    repair_unless(source, output, &AtomicBool::new(false))
}

pub(crate) fn repair_unless(
    source: &Path,
    output: Option<&Path>,
    stop: &AtomicBool,
) -> Result<Option<Repaired>, RecordingError> {
    let (reader, no_metadata) = match Reader::open(source) {
        Err(RecordingError::NoMetadata { .. }) => (open_unfinished(source)?, Some("without")),
        Err(RecordingError::BadMetadata { .. }) => {
            (open_unfinished(source)?, Some("with a damaged"))
        }
        opened => (opened?, None),
    };
    if no_metadata.is_none() && reader.wholeness().is_whole() {
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
            reason: format!("it declares no topic, and it is {}", reader.wholeness()),
        });
    }
    let directory = output.map_or_else(|| beside(source), Path::to_path_buf);
    if directory.symlink_metadata().is_ok() {
        return Err(RecordingError::Exists { path: directory });
    }
    let fault = match no_metadata.filter(|_| reader.wholeness().is_whole()) {
        Some(how) => format!("{how} metadata.yaml"),
        None => reader.wholeness().to_string(),
    };
    let messages = write_copy(&reader, &fault, &directory, stop)?;
    Ok(Some(Repaired {
        source: source.to_path_buf(),
        directory,
        messages,
        left_out: reader.wholeness().damaged,
        in_record: reader.wholeness().ends_in_record,
        fault,
        seal: kept_seal(&reader).cloned(),
        seals_lost: kept_seal(&reader).is_none() && reader.seals().iter().any(Option::is_some),
    }))
}

/// Opens all files in the directory of a recording without a valid metadata.yaml.
fn open_unfinished(directory: &Path) -> Result<Reader, RecordingError> {
    let files =
        mcap_files(directory).map_err(|source| RecordingError::io("read", directory, source))?;
    Reader::open_files(directory, files)
}

/// The default path of the new recording.
pub(crate) fn beside(source: &Path) -> PathBuf {
    let whole = fs::canonicalize(source).unwrap_or_else(|_| source.to_path_buf());
    let name = match source.is_dir() {
        true => whole.file_name(),
        false => whole.file_stem(),
    };
    let name = name.unwrap_or_default().to_string_lossy();
    let parent = source.parent().unwrap_or(Path::new(""));
    parent.join(format!("{name}{SUFFIX}"))
}

/// Writes the recording to a temporary directory, which is renamed when it is complete.
fn write_copy(
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
    let temporary = tempfile::Builder::new()
        .prefix(TEMPORARY)
        .tempdir_in(parent)
        .map_err(failed)?;
    let name = directory.file_name().unwrap_or_default();
    let unfinished = temporary.path().join(name);
    let topics = reader.topics().iter().map(Described::from).collect();
    let options = WriterOptions {
        compression: reader.compression(),
        application: application(reader).to_owned(),
        ..WriterOptions::default()
    };
    let mut writer = Writer::create_with(&unfinished, &options, topics, 0)?;
    let keeps_seal = kept_seal(reader).is_some();
    reader.for_each_as_written(|item| {
        if stop.load(Ordering::Relaxed) {
            return Err(failed(std::io::Error::from(
                std::io::ErrorKind::Interrupted,
            )));
        }
        match item {
            Item::Message(topic, header, data) => {
                writer.write_message(topic.index, header.log_time, header.publish_time, &data)
            }
            Item::Metadata(it) if is_kept(&it.name, keeps_seal) => writer.copy_metadata(&it),
            Item::SealAttachment(it) if keeps_seal => writer.copy_attachment(&it),
            Item::Metadata(_) | Item::SealAttachment(_) => Ok(()),
        }
    })?;
    // Behind everything that a seal covers.
    writer.copy_metadata(&repair_record(reader, fault))?;
    match reader.lost_messages() {
        Some(lost) => writer.add_lost(lost),
        None => writer.forget_losses(),
    }
    let finished = writer
        .finish_because(EndReason::Repaired)
        .map_err(|(error, _)| error)?;
    if directory.symlink_metadata().is_ok() {
        return Err(RecordingError::Exists {
            path: directory.to_path_buf(),
        });
    }
    fs::rename(&unfinished, directory)
        .map_err(|source| RecordingError::io("name", directory, source))?;
    Ok(finished.messages)
}

/// Name of the program that recorded the original.
fn application(reader: &Reader) -> &str {
    reader.application().unwrap_or(APPLICATION)
}

/// The seal that the new recording has, too. Those of several files cannot be kept in one.
fn kept_seal(reader: &Reader) -> Option<&Seal> {
    match reader.seals() {
        [Some(seal)] => Some(seal),
        _ => None,
    }
}

/// Whether a metadata record is copied. A seal covers all that precede it.
fn is_kept(name: &str, keeps_seal: bool) -> bool {
    keeps_seal || ![BEGIN, SEAL, "rosbag2"].contains(&name)
}

fn repair_record(reader: &Reader, fault: &str) -> Metadata {
    let source = reader
        .path()
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let damaged = reader.wholeness().damaged.to_string();
    record(
        record_name(application(reader), REPAIR),
        [
            ("source", source),
            ("fault", fault.to_owned()),
            ("damaged_records", damaged),
            (UNREAD, reader.unread_messages().to_string()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ],
    )
}
