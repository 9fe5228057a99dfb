//! What the node lets a recording see.

use std::sync::Arc;

use crate::endpoints::Endpoint;
use crate::live::QueueStats;
use crate::twin::Journal;

/// Takes a copy of everything that the node receives and sends. Called from the node's threads; nothing here blocks.
pub trait RecordingTap: Send + Sync + 'static {
    /// These bytes were sent, encapsulation header included.
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>);

    /// These bytes were received; `source_stamp` is the sender's, nanoseconds since the epoch.
    fn received(&self, endpoint: &Endpoint, bytes: Vec<u8>, source_stamp: Option<i64>);

    /// A message that was received did not reach the twin. `what` names it, `reason` says why.
    fn not_taken(&self, endpoint: &Endpoint, what: &str, reason: &str);

    /// An entry of the twin's journal.
    fn journal(&self, entry: &Journal);

    /// The state of the recording.
    fn health(&self) -> RecordingHealth;
}

/// The state of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingHealth {
    /// Its queue.
    pub queue: QueueStats,
    /// Messages that are in no file.
    pub lost: u64,
    /// What keeps it from writing; `None`: nothing does.
    pub problem: Option<String>,
    /// Further facts, for people.
    pub values: Vec<(String, String)>,
}
