//! The errors of recordings, each with what to do next.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a recording cannot be written or read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The operating system reported an error.
    #[error("cannot {doing} {}: {source}", path.display())]
    Io {
        /// The operation.
        doing: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The disk is full, or a quota or limit is reached.
    #[error("no room for the recording {}: {source}; free some space, then recording goes on in a new recording", path.display())]
    NoRoom {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The recordings' directory cannot be used.
    #[error("cannot write recordings to {}: {source}; make it writable or choose another directory", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file was removed while it was being written.
    #[error("the recording {} was removed while it was being written, and all of its messages are lost; leave the directory of a recording in place until it is finished", path.display())]
    Removed {
        /// The file.
        path: PathBuf,
    },
    /// The output exists already.
    #[error("{} exists already; nothing is overwritten: choose another name, or move it away", path.display())]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// Two topics have the same name.
    #[error("topic {topic} is declared twice; declare it once")]
    DuplicateTopic {
        /// The topic.
        topic: String,
    },
    /// The topic of a message was not declared.
    #[error("expected the index of one of {topics} declared topics, found {index}")]
    UndeclaredTopic {
        /// The index of the message.
        index: usize,
        /// Number of declared topics.
        topics: usize,
    },
    /// The mcap crate reported an error.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: mcap::McapError,
    },
    /// The text of the metadata cannot be serialized.
    #[error("cannot write the metadata of {}: {reason}", path.display())]
    WriteMetadata {
        /// The recording.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The operating system provides no thread.
    #[error("cannot start the recorder's thread: {0}")]
    Thread(#[source] io::Error),
    /// The system provides no random numbers.
    #[error("cannot make a key: the system provides no random numbers: {0}")]
    Random(String),
    /// The file of a key cannot be used.
    #[error("cannot use the key {}: {reason}", path.display())]
    BadKey {
        /// The file.
        path: PathBuf,
        /// What was expected, what was found, and what to do.
        reason: String,
    },
    /// The path does not exist.
    #[error("{} does not exist; give the directory of a recording, or its .mcap file", path.display())]
    Missing {
        /// The path.
        path: PathBuf,
    },
    /// The file is empty.
    #[error("{} is empty (0 bytes): it contains no messages, and there is nothing to repair", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file has another format.
    #[error("{} is not an MCAP file: expected 89 4d 43 41 50 30 0d 0a at the beginning, found {found}{hint}", path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// Its first bytes.
        found: String,
        /// What the file is instead, if it was recognised.
        hint: &'static str,
    },
    /// The directory is not a finished recording.
    #[error("{} has no metadata.yaml, so it is not a finished recording; read {} itself, or repair the recording", path.display(), file.display())]
    NoMetadata {
        /// The directory.
        path: PathBuf,
        /// An MCAP file in it.
        file: PathBuf,
    },
    /// The directory contains no recording.
    #[error("{} is not a recording: it has no metadata.yaml and no .mcap file; give the directory of a recording, or its .mcap file", path.display())]
    NoRecording {
        /// The directory.
        path: PathBuf,
    },
    /// The writer of the recording has not finished.
    #[error("{} is still being recorded; stop the program that records it, which finishes the recording", path.display())]
    BeingWritten {
        /// The recording.
        path: PathBuf,
    },
    /// metadata.yaml is not as rosbag2 writes it.
    #[error("{}: {reason}; read the .mcap file itself, or repair the recording", path.display())]
    BadMetadata {
        /// metadata.yaml.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// rosbag2 stored or compressed the recording in another way.
    #[error("{}: {reason}; convert it with: ros2 bag convert", path.display())]
    OtherStorage {
        /// metadata.yaml.
        path: PathBuf,
        /// What was expected and what was found.
        reason: String,
    },
    /// A file that metadata.yaml names is missing.
    #[error("{}: names the file {name}, which is not in the same directory; restore it, or read the other .mcap files one by one", path.display())]
    MissingFile {
        /// metadata.yaml.
        path: PathBuf,
        /// The missing file.
        name: String,
    },
    /// A part of the file is damaged.
    #[error("{}: at byte {offset}: {reason}; repair the recording to save the readable part", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Position in the file.
        offset: u64,
        /// What was expected and what was found.
        reason: String,
    },
    /// Messages are too far out of order to be sorted.
    #[error(
        "{}: more than {} MiB of messages are recorded before older ones; sort the file with: mcap sort {} -o OUT.mcap", path.display(), crate::reordering::MAX_OUT_OF_ORDER >> 20, path.display()
    )]
    OutOfOrder {
        /// The file.
        path: PathBuf,
    },
    /// The file changed while it was being read.
    #[error("{} changed while it was being read; read it again when its writer has finished", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// A definition cannot be read.
    #[error("topic {topic}: the definition of {type_name} cannot be read: {reason}")]
    Schema {
        /// The topic.
        topic: String,
        /// ROS name of its type.
        type_name: String,
        /// What is wrong.
        reason: String,
    },
    /// A message does not match its definition.
    #[error(
        "topic {topic}, message at {log_time} ns: {reason}; it does not match the definition of {type_name} in the recording"
    )]
    Content {
        /// The topic.
        topic: String,
        /// ROS name of its type.
        type_name: String,
        /// Log time of the message \[ns\].
        log_time: i64,
        /// What is wrong.
        reason: String,
    },
    /// The recording defines a type differently from the reading program.
    #[error(
        "topic {topic}: the recording's definition of {type_name} differs from this program's: {difference}; \
         read it with the version that recorded it, or by the definition in the recording, as an export does"
    )]
    OtherDefinition {
        /// The topic.
        topic: String,
        /// ROS name of its type.
        type_name: String,
        /// The first difference.
        difference: String,
    },
    /// The program that opened the recording does not read recordings of this kind.
    #[error("{}: {reason}", path.display())]
    OtherProgram {
        /// The recording.
        path: PathBuf,
        /// Why, and what to do.
        reason: String,
    },
    /// Repair found nothing to save.
    #[error("{}: nothing in it can be saved: {reason}", path.display())]
    NothingToSave {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

impl RecordingError {
    /// An error of the operating system; a lack of room becomes [`NoRoom`](Self::NoRoom).
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

    /// An error of the mcap crate while writing.
    pub(crate) fn write(path: &Path, source: mcap::McapError) -> Self {
        match source {
            mcap::McapError::Io(source) => Self::io("write", path, source),
            source => Self::Write {
                path: path.to_path_buf(),
                source,
            },
        }
    }

    /// The path that [`repair`](fn@crate::repair) may be able to save, if the recording is incomplete or damaged.
    #[must_use]
    pub fn repairable(&self) -> Option<&Path> {
        match self {
            Self::NoMetadata { path, .. } | Self::Damaged { path, .. } => Some(path),
            Self::BadMetadata { path, .. } => path.parent(),
            _ => None,
        }
    }

    /// Whether the input is wrong, rather than the operation having failed.
    #[must_use]
    pub fn is_bad_input(&self) -> bool {
        !matches!(
            self,
            Self::Io { .. }
                | Self::NoRoom { .. }
                | Self::Removed { .. }
                | Self::Write { .. }
                | Self::WriteMetadata { .. }
                | Self::Thread(_)
                | Self::Random(_)
        )
    }
}

/// Whether there was no room to write: a full disk, a quota, or a limit on the size of files.
pub(crate) fn is_no_room(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge
    )
}
