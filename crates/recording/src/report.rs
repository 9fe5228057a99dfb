//! Reports of what happens to a recorder.

use std::fmt;
use std::path::PathBuf;

use crate::repair::Repaired;
use crate::seal_key::PublicKey;
use crate::writer::Finished;

/// How important a report is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportLevel {
    /// Normal operation.
    Info,
    /// Something went wrong earlier and was put right, or should be changed.
    Warning,
    /// Messages are lost, or recording is not possible.
    Error,
}

/// Something that happened to a recorder; its display text is a line for a log.
#[derive(Debug, Clone, PartialEq)]
pub enum RecorderReport {
    /// Recordings are sealed.
    Sealing {
        /// The public part of the key.
        key: PublicKey,
        /// The file of the private part; `None` if the key was made for this run.
        path: Option<PathBuf>,
    },
    /// The key of the seals is not protected.
    ExposedKey {
        /// What is wrong, and what to do.
        warning: String,
    },
    /// A recording began.
    Began {
        /// Its directory.
        directory: PathBuf,
    },
    /// A recording was finished.
    Finished(Finished),
    /// An old recording was deleted to keep within the limits.
    Deleted {
        /// Its directory.
        directory: PathBuf,
    },
    /// A recording that a crash had cut off was repaired.
    Repaired(Box<Repaired>),
    /// A recording that a crash had cut off could not be repaired.
    NotRepaired {
        /// Its directory.
        directory: PathBuf,
        /// Why.
        reason: String,
    },
    /// Nothing can be recorded now.
    Failing {
        /// Why, and what to do.
        reason: String,
    },
    /// Recording goes on after a failure.
    Resumed {
        /// The new recording.
        directory: PathBuf,
        /// Messages that are in no file, not counting those that were reported before.
        lost: u64,
    },
    /// The queue was full, or writing failed.
    Lost {
        /// Messages that are in no file, not counting those that were reported before.
        messages: u64,
    },
}

impl RecorderReport {
    /// How important it is: every loss is an error.
    #[must_use]
    pub fn level(&self) -> ReportLevel {
        match self {
            Self::Sealing { .. }
            | Self::Began { .. }
            | Self::Finished(_)
            | Self::Deleted { .. } => ReportLevel::Info,
            Self::Repaired(_) | Self::ExposedKey { .. } => ReportLevel::Warning,
            Self::NotRepaired { .. }
            | Self::Failing { .. }
            | Self::Resumed { .. }
            | Self::Lost { .. } => ReportLevel::Error,
        }
    }
}

impl fmt::Display for RecorderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sealing { key, path } => {
                write!(f, "recordings are sealed with the key {key}")?;
                match path {
                    Some(path) => write!(f, " (private part: {})", path.display()),
                    None => f.write_str(
                        ", made for this run only; keep this line apart from the recordings to recognise their seals",
                    ),
                }
            }
            Self::ExposedKey { warning } => f.write_str(warning),
            Self::Began { directory } => write!(f, "recording to {}", directory.display()),
            Self::Finished(it) => {
                write!(
                    f,
                    "recorded {} messages, {} bytes in {}",
                    it.messages,
                    it.bytes,
                    it.directory.display()
                )?;
                if it.lost > 0 {
                    write!(f, "; {} messages are missing", it.lost)?;
                }
                Ok(())
            }
            Self::Deleted { directory } => {
                write!(
                    f,
                    "deleted the old recording {} to keep within the limits",
                    directory.display()
                )
            }
            Self::Repaired(it) => write!(f, "{it}"),
            Self::NotRepaired { directory, reason } => {
                write!(
                    f,
                    "the recording {} was cut off and cannot be repaired: {reason}",
                    directory.display()
                )
            }
            Self::Failing { reason } => write!(f, "recording has stopped: {reason}"),
            Self::Resumed { directory, lost } => {
                write!(
                    f,
                    "recording to {} again; {lost} messages were lost",
                    directory.display()
                )
            }
            Self::Lost { messages } => {
                write!(
                    f,
                    "{messages} messages were lost: the queue was full, or they could not be written"
                )
            }
        }
    }
}
