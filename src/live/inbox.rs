//! What waits for the solver: commands, in a bounded queue that refuses when it is full.
//!
//! A sender must know whether its command was taken, so this queue never drops one. Data that come in streams, where the
//! newest matter most, belong into a queue of their own beside it that drops its oldest entries.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use super::notifier::Notifier;
use super::queue::{Queue, QueueStats, WhenFull};
use crate::twin::{Accepted, ColumnSnapshot, Command, Refusal, RefusalCode};

/// Most commands that wait for the solver; more are refused.
pub const MAX_COMMANDS: usize = 64;

/// One thing that the solver is asked.
#[derive(Debug)]
pub(super) enum Request {
    /// Give the twin a command.
    Command {
        command: Command,
        reply: Reply<Result<Accepted, Refusal>>,
    },
    /// Copy the column as it is.
    Look { reply: Reply<ColumnSnapshot> },
}

/// Where an answer goes, if anyone waits for it.
#[derive(Debug)]
pub(super) struct Reply<T>(Option<SyncSender<T>>);

/// Where an answer arrives.
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

    /// Never blocks; an answer for which nobody waits any more is dropped.
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

/// What waits for the solver, and what wakes it.
#[derive(Debug)]
pub(super) struct Inbox {
    commands: Queue<Request>,
    notifier: Arc<Notifier>,
}

impl Inbox {
    pub fn new() -> Self {
        Self {
            commands: Queue::new("inputs".to_owned(), MAX_COMMANDS, WhenFull::Refuse),
            notifier: Arc::default(),
        }
    }

    /// Wakes the solver when something is submitted.
    pub fn notifier(&self) -> &Arc<Notifier> {
        &self.notifier
    }

    /// # Errors
    /// Too many wait already.
    pub fn submit(&self, request: Request) -> Result<(), Refusal> {
        let taken = self.commands.push(request);
        self.notifier.notify();
        if taken {
            return Ok(());
        }
        let reason = format!(
            "{MAX_COMMANDS} commands wait already for the solver; send fewer events and changes, or try again"
        );
        Err(Refusal::new(RefusalCode::QueueFull, reason))
    }

    pub fn take(&self) -> Option<Request> {
        self.commands.pop()
    }

    pub fn is_empty(&self) -> bool {
        self.commands.is_empty()
    }

    pub fn stats(&self) -> QueueStats {
        self.commands.stats()
    }
}
