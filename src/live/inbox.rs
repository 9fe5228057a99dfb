//! The queue of requests to the solver: bounded, and rejects requests when it is full.
//!
//! A sender must know whether its command was accepted, so this queue never drops one. Streamed data, of which the newest
//! matter most, need a separate queue that drops its oldest entries.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use super::notifier::Notifier;
use super::queue::{Queue, QueueStats, WhenFull};
use crate::twin::{
    Accepted, ColumnSnapshot, Command, ImpactCommand, Refusal, RefusalCode, Striking,
};

/// Maximum number of queued requests; more are rejected.
pub const MAX_COMMANDS: usize = 64;

/// Maximum wait for an answer of the solver.
pub(super) const ANSWER_TIMEOUT: Duration = Duration::from_secs(2);

/// A request to the solver.
#[derive(Debug)]
pub(super) enum Request {
    /// Execute a command.
    Command {
        command: Command,
        reply: Reply<Result<Accepted, Refusal>>,
    },
    /// Whether the column would take this impact now.
    Check {
        command: Box<ImpactCommand>,
        reply: Reply<Result<Striking, Refusal>>,
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

/// The queued requests, and the notifier that wakes the solver.
#[derive(Debug)]
pub(super) struct Inbox {
    requests: Queue<Request>,
    notifier: Arc<Notifier>,
}

impl Inbox {
    pub fn new() -> Self {
        Self {
            requests: Queue::new("inputs".to_owned(), MAX_COMMANDS, WhenFull::Reject),
            notifier: Arc::default(),
        }
    }

    /// Wakes the solver when a request is submitted.
    pub fn notifier(&self) -> &Arc<Notifier> {
        &self.notifier
    }

    /// # Errors
    /// The queue is full.
    pub fn submit(&self, request: Request) -> Result<(), Refusal> {
        let accepted = self.requests.push(request);
        self.notifier.notify();
        if accepted {
            return Ok(());
        }
        let reason = format!(
            "the queue of the solver is full ({MAX_COMMANDS} commands); try again, or send fewer events and parameter changes"
        );
        Err(Refusal::new(RefusalCode::QueueFull, reason))
    }

    /// Submits a request and waits for its answer.
    ///
    /// # Errors
    /// The queue is full, or the solver does not answer in time.
    pub fn ask<T>(&self, request: impl FnOnce(Reply<T>) -> Request) -> Result<T, Refusal> {
        let (reply, answer) = Reply::channel();
        self.submit(request(reply))?;
        answer
            .wait(ANSWER_TIMEOUT)
            .map_err(|_| Refusal::no_answer(ANSWER_TIMEOUT.as_secs()))
    }

    pub fn take(&self) -> Option<Request> {
        self.requests.pop()
    }

    pub fn is_empty(&self) -> bool {
        self.requests.is_empty()
    }

    pub fn stats(&self) -> QueueStats {
        self.requests.stats()
    }
}
