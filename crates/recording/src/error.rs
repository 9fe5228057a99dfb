//! What can go wrong with a recording, and what to do then.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a recording cannot be written or read. Each says what was expected, what was found, where, and what to do.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The system refuses.
    #[error("cannot {doing} {}: {source}", path.display())]
    Io {
        /// What was to be done.
        doing: &'static str,
        /// With what.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// No room, a quota or a limit is reached.
    #[error("no room for the recording {}: {source}; free some, the rest goes into a new recording then", path.display())]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The recordings' directory cannot be used.
    #[error("cannot write recordings to {}: {source}; make it writable or set record.directory to another", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Something is in the way.
    #[error("{} exists already; nothing is overwritten: choose another name, or move it away", path.display())]
    Exists {
        /// What exists.
        path: PathBuf,
    },
    /// A name twice.
    #[error("topic {topic} is declared twice; declare it once")]
    DuplicateTopic {
        /// The name.
        topic: String,
    },
    /// A message of a topic that was not declared.
    #[error("expected the index of one of {topics} declared topics, found {index}")]
    UndeclaredTopic {
        /// What was found.
        index: usize,
        /// Number of topics.
        topics: usize,
    },
    /// The MCAP library refuses.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: mcap::McapError,
    },
    /// The text of the metadata cannot be made.
    #[error("cannot write the metadata of {}: {reason}", path.display())]
    WriteMetadata {
        /// The recording.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The system gives no thread.
    #[error("cannot start the recorder's thread: {0}")]
    Thread(#[source] io::Error),
    /// Nothing there.
    #[error("there is no {}; give the directory of a recording, or its .mcap file", path.display())]
    Missing {
        /// What was asked for.
        path: PathBuf,
    },
    /// Zero bytes.
    #[error("{} is empty (0 bytes): nothing was recorded in it; there is nothing to repair", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Another format.
    #[error("{} is not an MCAP file: expected it to begin with 89 4d 43 41 50 30 0d 0a, found {found}{hint}", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// Its first bytes.
        found: String,
        /// What it is, where it is known.
        hint: &'static str,
    },
    /// A directory that is no finished recording.
    #[error("{} has no metadata.yaml, so it is no finished recording; {advice}", path.display())]
    NoMetadata {
        /// The directory.
        path: PathBuf,
        /// What can be done with what is there.
        advice: String,
    },
    /// Its writer has not finished.
    #[error("{} is being recorded just now; stop the program that records it, which finishes it", path.display())]
    BeingWritten {
        /// The recording.
        path: PathBuf,
    },
    /// metadata.yaml is not what rosbag2 writes.
    #[error("{}: {reason}; read the .mcap file itself, or write the recording anew with: column-twin repair", path.display())]
    BadMetadata {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Another storage.
    #[error("{}: expected storage_identifier mcap, found {found}; convert it with: ros2 bag convert", path.display())]
    OtherStorage {
        /// metadata.yaml.
        path: PathBuf,
        /// What was found.
        found: String,
    },
    /// Whole files or messages are compressed by rosbag2 on top of MCAP.
    #[error("{}: rosbag2 compressed {mode} by itself, which this program does not read; convert it with: ros2 bag convert", path.display())]
    OuterCompression {
        /// metadata.yaml.
        path: PathBuf,
        /// What is compressed.
        mode: String,
    },
    /// A file that metadata.yaml names is not there.
    #[error("{}: names the file {name}, which is not beside it; bring it back, or read the other .mcap files one by one", path.display())]
    MissingFile {
        /// metadata.yaml.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// Something in the file is not what it should be.
    #[error("{}: at byte {offset}: {reason}; what can be read of it is written anew by: column-twin repair {}", path.display(), path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        offset: u64,
        /// What was expected and what was found.
        reason: String,
    },
    /// Messages are too far out of order to be put in order.
    #[error(
        "{}: more than {} MiB of messages are recorded before others that are older; put it in order with: mcap sort {} -o OUT.mcap", path.display(), crate::reader::MAX_OUT_OF_ORDER >> 20, path.display()
    )]
    OutOfOrder {
        /// The file.
        path: PathBuf,
    },
    /// The file changed while it was read.
    #[error("{} changed while it was read; read it again when its writer has finished", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// A schema that cannot be understood.
    #[error(
        "topic {topic}: the definition of {type_name} in the recording cannot be read: {reason}"
    )]
    Schema {
        /// Its name.
        topic: String,
        /// Its type.
        type_name: String,
        /// What is wrong.
        reason: String,
    },
    /// A message that does not fit its definition.
    #[error(
        "topic {topic}, message at {log_time} ns: {reason}; it does not fit the definition of {type_name} in the recording"
    )]
    Content {
        /// Its name.
        topic: String,
        /// Its type.
        type_name: String,
        /// Which message.
        log_time: i64,
        /// What is wrong.
        reason: String,
    },
    /// The recording's definition of one of our types is not that of this program.
    #[error(
        "topic {topic}: the recording's definition of {type_name} differs from this program's: {difference}; \
         read it with the version that recorded it, or export it, which uses the recording's own definition"
    )]
    OtherDefinition {
        /// Its name.
        topic: String,
        /// Its type.
        type_name: String,
        /// What differs first.
        difference: String,
    },
    /// Repair found nothing to keep.
    #[error("{}: nothing in it can be saved: {reason}", path.display())]
    NothingToSave {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

impl RecordingError {
    /// An error of the system; one that says that there is no room is told apart.
    pub(crate) fn io(doing: &'static str, path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        if is_no_room(&source) {
            Self::NoRoom { path, source }
        } else {
            Self::Io {
                doing,
                path,
                source,
            }
        }
    }

    /// An error of the MCAP library while writing.
    pub(crate) fn write(path: &Path, source: mcap::McapError) -> Self {
        match source {
            mcap::McapError::Io(source) => Self::io("write", path, source),
            source => Self::Write {
                path: path.to_path_buf(),
                source,
            },
        }
    }

    /// Whether the input is at fault, and not what was to be done with it: exit code 2 and not 1.
    #[must_use]
    pub fn is_bad_input(&self) -> bool {
        !matches!(
            self,
            Self::Io { .. }
                | Self::NoRoom { .. }
                | Self::Write { .. }
                | Self::WriteMetadata { .. }
                | Self::Thread(_)
        )
    }
}

/// Whether there is no room for what was to be written: a full disk, a quota, a limit on the size of files.
pub(crate) fn is_no_room(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge
    )
}
