//! How a recorder does.

use std::path::PathBuf;
use std::sync::Arc;

/// The queue in front of the recorder's thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueStatistics {
    /// Maximum number of messages.
    pub capacity: usize,
    /// Messages that wait now.
    pub len: usize,
    /// Messages that were offered since the start.
    pub pushed: u64,
    /// Messages that were dropped since the start, because the queue was full.
    pub dropped: u64,
}

/// A recorder as it is now.
#[derive(Debug, Clone, PartialEq)]
pub struct RecorderStatistics {
    /// The queue in front of its thread.
    pub queue: QueueStatistics,
    /// Bytes of messages that wait in the queue.
    pub waiting_bytes: usize,
    /// Most bytes that may wait.
    pub capacity_bytes: usize,
    /// Messages that were written.
    pub written: u64,
    /// Bytes of these messages.
    pub written_bytes: u64,
    /// Messages that are in no file: the queue was full, or they could not be written.
    pub lost: u64,
    /// Times that writing failed.
    pub write_errors: u64,
    /// Why nothing can be written now, and what to do.
    pub failing: Option<Arc<str>>,
    /// The recording that is being written.
    pub current: Option<PathBuf>,
    /// Recordings that were finished.
    pub finished: u64,
}
