//! The recorded form of a journal entry: one line of JSON, with numbers that read back bit for bit.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::about::About;
use crate::estimation::IntakeState;
use crate::messages::cdr::{self, CdrError};
use crate::messages::std_msgs;
use crate::sensors::Sensor;
use crate::time::Nanos;
use crate::twin::{Journal, RejectionCode};
use printable::Hexadecimal;

/// Format name in every line.
pub const JOURNAL_FORMAT: &str = "column_twin journal";

/// The format version that this program writes, and the only one that it reads.
pub const JOURNAL_VERSION: u32 = 8;

/// One line of a recorded journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JournalLine {
    format: String,
    version: u32,
    /// Consecutive number of the line since the start of the recorder: a gap is a loss.
    pub number: u64,
    /// When the line was recorded \[ns since 1970\]: the log time of its message.
    pub recorded: Nanos,
    /// The messages that were recorded since the previous line.
    pub since: Tally,
    /// The column of a fleet that the entry is about; `None` in the recording of a single twin, and for entries about the fleet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column_id: Option<String>,
    /// The recording program. Present with every checkpoint of a single twin, and with every list of the columns of a fleet, so that every recording identifies its origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<About>,
    /// Present with every checkpoint of a column with sensors, and with every [`JournalEntry::Sensors`]: the intake of their measurements, after those that were recorded
    /// before this line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intake: Option<IntakeState>,
    /// The entry.
    pub entry: JournalEntry,
}

/// The messages that a recorder took between two lines of the journal.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tally {
    /// Number of messages on all topics.
    pub messages: u64,
    /// Number of those that cannot be recomputed.
    pub others: u64,
    /// Digest of their topics and log times, in their order; empty without messages.
    pub times: String,
    /// Digest of the measurements among them, with their publish times; empty without measurements. There are too many of them for
    /// a line about each.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub measurements: String,
    /// Measurements that the node took in the same time and that could not be recorded.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lost_measurements: u64,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Counts messages between two lines of the journal.
#[derive(Debug, Clone, Default)]
pub(super) struct Counting {
    messages: u64,
    others: u64,
    times: Sha256,
    has_measurements: bool,
    measurements: Sha256,
    lost_measurements: u64,
}

impl Counting {
    /// Adds a message on the topic with this recorded name.
    pub fn add(&mut self, topic: &str, log_time: Nanos, is_recomputed: bool) {
        self.messages += 1;
        self.others += u64::from(!is_recomputed);
        // The zero byte ends the name.
        self.times.update(topic.as_bytes());
        self.times.update([0]);
        self.times.update(log_time.to_le_bytes());
    }

    /// Adds the content of measurements.
    pub fn add_measurement(&mut self, publish_time: Nanos, bytes: &[u8]) {
        self.has_measurements = true;
        self.measurements.update(publish_time.to_le_bytes());
        self.measurements.update((bytes.len() as u64).to_le_bytes());
        self.measurements.update(bytes);
    }

    /// Adds measurements that could not be recorded.
    pub fn add_lost_measurement(&mut self) {
        self.lost_measurements += 1;
    }

    /// The messages so far.
    pub fn tally(&self) -> Tally {
        const DIGITS: usize = 32;
        let digest = |is_needed: bool, hash: &Sha256| {
            let mut digits = String::new();
            if is_needed {
                digits = Hexadecimal(&hash.clone().finalize()).to_string();
                digits.truncate(DIGITS);
            }
            digits
        };
        Tally {
            messages: self.messages,
            others: self.others,
            times: digest(self.messages > 0, &self.times),
            measurements: digest(self.has_measurements, &self.measurements),
            lost_measurements: self.lost_measurements,
        }
    }
}

/// An entry of a recorded journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JournalEntry {
    /// An entry of the twin's journal.
    Twin(Journal),
    /// The sensors of a column of a fleet, as of this line: measurements that follow can be taken as the node did.
    Sensors {
        /// The sensors, in the order of the parameters.
        sensors: Vec<Sensor>,
    },
    /// The node rejected a message before it reached the twin. Recomputation does not need this entry.
    RejectedByNode {
        /// When the message was rejected.
        stamp: Nanos,
        /// Topic name in the table of endpoints.
        topic: String,
        /// Identifier of the event, or a description of the message.
        what: String,
        /// Stable code of the rejection; `None` if the message could not be recorded.
        code: Option<RejectionCode>,
        /// The reason, for people.
        reason: String,
    },
    /// The node received a message, which is recorded immediately before.
    Received {
        /// Topic name in the table of endpoints.
        topic: String,
        /// Its publish time in the recording \[ns since 1970\].
        published: Nanos,
        /// The SHA-256 of its bytes in hexadecimal digits.
        sha256: String,
    },
    /// The node runs a fleet of these columns, none of which responds to an impact or has received one that it has not taken. Each
    /// column gives out a checkpoint before its next command, so that a recording can begin here.
    Fleet {
        /// The identifiers of all columns.
        columns: Arc<[Arc<str>]>,
    },
    /// The recorder was stopped; nothing follows.
    End {},
}

/// Why a message cannot be read or written as a line of the journal.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The message is not a valid `std_msgs/msg/String`.
    #[error(transparent)]
    Message(#[from] CdrError),
    /// The text is not JSON of the expected form.
    #[error("a line of the journal is not valid: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The line has another format or version.
    #[error(
        "the journal has format {format:?}, version {version}, recorded by {}; this program reads {JOURNAL_FORMAT:?}, \
         version {JOURNAL_VERSION}, only: use the program that made the recording",
        program.as_ref().map_or_else(|| "an unknown program".to_owned(), |it| format!("{it:?}"))
    )]
    OtherVersion {
        /// The format found.
        format: String,
        /// The version found.
        version: u32,
        /// Name and version of the recording program, if the line contains them.
        program: Option<String>,
    },
}

/// The part of a line that every version has.
#[derive(Deserialize)]
struct Header {
    format: String,
    version: u32,
    /// Checkpoints name the recording program in all versions, beside fields that may differ.
    #[serde(default)]
    about: serde_json::Value,
}

impl JournalLine {
    /// A line with an entry, recorded at this time; a checkpoint also has `about`, and with sensors their intake.
    #[must_use]
    pub fn new(
        entry: JournalEntry,
        about: Option<About>,
        number: u64,
        recorded: Nanos,
        since: Tally,
        intake: Option<IntakeState>,
    ) -> Self {
        Self {
            format: JOURNAL_FORMAT.to_owned(),
            version: JOURNAL_VERSION,
            number,
            recorded,
            since,
            column_id: None,
            about,
            intake,
            entry,
        }
    }

    /// The line about this column of a fleet.
    #[must_use]
    pub fn of_column(mut self, column_id: Option<&str>) -> Self {
        self.column_id = column_id.map(str::to_owned);
        self
    }

    /// Whether a recording can begin with this line.
    #[must_use]
    pub fn is_checkpoint(&self) -> bool {
        match &self.entry {
            JournalEntry::Twin(Journal::Checkpoint(_)) => self.column_id.is_none(),
            JournalEntry::Fleet { .. } => true,
            _ => false,
        }
    }

    /// Encodes the line as a `std_msgs/msg/String`.
    ///
    /// # Errors
    /// The line is too long for a message.
    pub fn encode(&self) -> Result<Vec<u8>, JournalError> {
        let data = serde_json::to_string(self)?;
        Ok(cdr::encode(&std_msgs::String { data })?)
    }

    /// Decodes a line from a `std_msgs/msg/String`.
    ///
    /// # Errors
    /// The message is not a line of the journal, or has another format version.
    pub fn decode(bytes: &[u8]) -> Result<Self, JournalError> {
        let message: std_msgs::String = cdr::decode(bytes)?;
        let Header {
            format,
            version,
            about,
        } = serde_json::from_str(&message.data)?;
        if format != JOURNAL_FORMAT || version != JOURNAL_VERSION {
            let program = about["program"].as_str().map(str::to_owned);
            return Err(JournalError::OtherVersion {
                format,
                version,
                program,
            });
        }
        Ok(serde_json::from_str(&message.data)?)
    }
}
