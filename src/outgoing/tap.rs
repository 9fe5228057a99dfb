//! The interface through which the node passes messages to a recording.

use std::sync::{Arc, Mutex};

use crate::endpoints::Endpoint;
use crate::estimation::Intake;
use crate::live::QueueStats;
use crate::time::Nanos;
use crate::twin::{Journal, RejectionCode};

/// Receives a copy of everything that the node receives and sends. Called from the node's threads; must not block.
///
/// `column` is the identifier of the column that something is about, in the node of a fleet; `None` in that of a single twin.
pub trait RecordingTap: Send + Sync + 'static {
    /// The node sent a message; `bytes` include the encapsulation header.
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>);

    /// The node received a message; `source_stamp` is the time of sending \[ns since 1970\], if known.
    fn received(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        bytes: Vec<u8>,
        source_stamp: Option<i64>,
    );

    /// The measurements of the column come through this intake. It is locked from when it takes a batch until
    /// [`measured`](Self::measured) has returned.
    fn sensors(&self, column: Option<&str>, intake: &Arc<Mutex<Intake>>);

    /// The node received measurements at `received` \[ns\], by the clock that drives the twin. The recording contains this time as
    /// the publish time of the message: with it, the intake of measurements can be repeated, which is `intake` after that.
    fn measured(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        bytes: Vec<u8>,
        received: Nanos,
        intake: &Intake,
    );

    /// The node rejected a received message, so that it did not reach the twin. `what` identifies the message; `code` is
    /// `None` if only its recording failed.
    fn rejected(
        &self,
        column: Option<&str>,
        endpoint: &Endpoint,
        what: &str,
        code: Option<RejectionCode>,
        reason: &str,
    );

    /// The twin produced an entry of its journal.
    fn journal(&self, column: Option<&str>, entry: &Journal);

    /// The state of the recording.
    fn health(&self) -> RecordingHealth;
}

/// The state of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingHealth {
    /// The queue of the recorder.
    pub queue: QueueStats,
    /// Messages that were not written to any file.
    pub lost: u64,
    /// Why the recorder cannot write; `None` while it can.
    pub problem: Option<String>,
    /// Further values, for people.
    pub values: Vec<(String, String)>,
}
