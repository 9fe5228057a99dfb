//! Requests to the solver threads, and the answers. Their queue is bounded, and rejects requests when it is full.
//!
//! A sender must know whether its command was accepted, so the queue never drops one. Streamed data, of which the newest
//! matter most, need a separate queue that drops its oldest entries.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use crate::twin::{Accepted, ColumnSnapshot, Command, ImpactCommand, Rejection, Striking};

/// Maximum number of queued requests to a single twin; more are rejected.
pub const MAX_COMMANDS: usize = 64;

/// Maximum wait for an answer of the solver.
pub(super) const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// A request to the solver.
#[derive(Debug)]
pub(super) enum Request {
    /// Execute a command.
    Command {
        command: Command,
        reply: Reply<Result<Accepted, Rejection>>,
    },
    /// Whether the column would take this impact now.
    Check {
        command: Box<ImpactCommand>,
        reply: Reply<Result<Striking, Rejection>>,
    },
    /// Copy the current state of the column.
    Snapshot { reply: Reply<ColumnSnapshot> },
}

/// The sending end for an answer, if the sender of the request waits for one.
#[derive(Debug)]
pub(super) struct Reply<T>(Option<SyncSender<T>>);

/// The receiving end for an answer.
#[derive(Debug)]
pub(super) struct Answer<T>(Receiver<T>);

impl<T> Reply<T> {
    pub fn none() -> Self {
        Self(None)
    }

    pub fn channel() -> (Self, Answer<T>) {
        let (sender, receiver) = sync_channel(1);
        (Self(Some(sender)), Answer(receiver))
    }

    /// Never blocks; the answer is dropped if the receiver has stopped waiting.
    pub fn send(self, answer: T) {
        if let Some(sender) = self.0 {
            let _ = sender.try_send(answer);
        }
    }
}

impl<T> Answer<T> {
    pub fn wait(&self, timeout: Duration) -> Result<T, RecvTimeoutError> {
        self.0.recv_timeout(timeout)
    }
}
