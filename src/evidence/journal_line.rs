//! The text of an entry of the journal: one line of JSON, numbers to the last bit.

use serde::{Deserialize, Serialize};

use super::about::About;
use crate::messages::cdr::{self, CdrError};
use crate::messages::std_msgs;
use crate::twin::{Journal, Nanos};

/// What an entry says it is.
pub const JOURNAL_FORMAT: &str = "column_twin journal";

/// Version of what is written, and the only one that is read.
pub const JOURNAL_VERSION: u32 = 2;

/// One entry of the journal, as it is recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    format: String,
    version: u32,
    /// With each checkpoint, so that every recording says whose it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<About>,
    /// What there is to say.
    pub entry: LineEntry,
}

/// What an entry of the journal can be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LineEntry {
    /// Of the twin itself.
    Twin(Journal),
    /// Refused by the node, on its own behalf or the twin's; not needed to recompute anything.
    RefusedByNode {
        /// When.
        stamp: Nanos,
        /// Topic, in the table of endpoints.
        topic: String,
        /// The event, or who asked.
        what: String,
        /// Why.
        reason: String,
    },
}

/// Why a message is no entry of the journal.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// No text.
    #[error(transparent)]
    Message(#[from] CdrError),
    /// No JSON of the expected form.
    #[error("an entry of the journal cannot be read: {0}")]
    Malformed(#[from] serde_json::Error),
    /// Of another version.
    #[error(
        "an entry of the journal has format {format:?}, version {version}; expected {JOURNAL_FORMAT:?}, version \
         {JOURNAL_VERSION}; use the version of column-twin that recorded it"
    )]
    Foreign {
        /// What it says it is.
        format: String,
        /// Its version.
        version: u32,
    },
}

/// What can be read of any version.
#[derive(Deserialize)]
struct Label {
    format: String,
    version: u32,
}

impl Line {
    /// An entry; `about` with a checkpoint.
    #[must_use]
    pub fn new(entry: LineEntry, about: Option<About>) -> Self {
        Self {
            format: JOURNAL_FORMAT.to_owned(),
            version: JOURNAL_VERSION,
            about,
            entry,
        }
    }

    /// Whether a recording can begin with it.
    #[must_use]
    pub fn is_checkpoint(&self) -> bool {
        matches!(self.entry, LineEntry::Twin(Journal::Checkpoint(_)))
    }

    /// Its bytes as a `std_msgs/msg/String`.
    ///
    /// # Errors
    /// None that is known of: numbers and texts can be written.
    pub fn encode(&self) -> Result<Vec<u8>, JournalError> {
        let data = serde_json::to_string(self)?;
        Ok(cdr::encode(&std_msgs::String { data })?)
    }

    /// Reads an entry.
    ///
    /// # Errors
    /// It is none, or of another version.
    pub fn decode(bytes: &[u8]) -> Result<Self, JournalError> {
        let message: std_msgs::String = cdr::decode(bytes)?;
        let Label { format, version } = serde_json::from_str(&message.data)?;
        if format != JOURNAL_FORMAT || version != JOURNAL_VERSION {
            return Err(JournalError::Foreign { format, version });
        }
        Ok(serde_json::from_str(&message.data)?)
    }
}
