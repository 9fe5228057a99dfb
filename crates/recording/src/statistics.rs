//! The state of a recorder.

use std::path::PathBuf;
use std::sync::Arc;

/// The queue in front of the recorder's thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueStatistics {
    /// Maximum number of messages.
    pub capacity: usize,
    /// Messages in the queue.
    pub len: usize,
    /// Messages that were offered since the start.
    pub pushed: u64,
    /// Messages that were dropped since the start, because the queue was full.
    pub dropped: u64,
}

/// The state of a recorder.
#[derive(Debug, Clone, PartialEq)]
pub struct RecorderStatistics {
    /// The queue in front of the recorder's thread.
    pub queue: QueueStatistics,
    /// Size of the messages in the queue \[bytes\].
    pub waiting_bytes: usize,
    /// Maximum size of the messages in the queue \[bytes\].
    pub capacity_bytes: usize,
    /// Messages written so far.
    pub written: u64,
    /// Size of the written messages \[bytes\].
    pub written_bytes: u64,
    /// Messages lost so far: the queue was full, or they could not be written.
    pub lost: u64,
    /// Number of failed writes.
    pub write_errors: u64,
    /// Why recording is not possible at the moment, and what to do.
    pub failing: Option<Arc<str>>,
    /// The current recording.
    pub current: Option<PathBuf>,
    /// Number of finished recordings.
    pub finished: u64,
}
