//! What a recording needs so that everything can be recomputed: the state from which the twin starts, the commands that
//! it was given, and how far it had come by then.
//!
//! A twin that is made from a [`Checkpoint`] and given the same commands at the same [`Position`]s gives out the same
//! states, reports and status, bit for bit. Stamps of rejections and notices, and compute times, are not among them.
//!
//! A checkpoint does not contain the course of the last response. Where a late impact belongs into that response
//! ([`CommandRecord::taken_back`]), a twin that began at the checkpoint cannot follow.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::command::Command;
use super::estimates::Estimates;
use super::judged_impact::JudgedImpact;
use super::life::Life;
use super::plant::Condition;
use super::registry::{Counts, LastRejection};
use super::rejection::Rejection;
use crate::column::{Impact, State};
use crate::parameters::Parameters;
use crate::study::VehicleLimits;
use crate::time::Nanos;

/// A twin at rest gives out a checkpoint at least this often \[ns\].
pub const CHECKPOINT_PERIOD: Nanos = 60_000_000_000;

/// One entry of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Journal {
    /// The column is at rest: all that is needed to continue from here.
    Checkpoint(Arc<Checkpoint>),
    /// The twin was given a command.
    Command(Arc<CommandRecord>),
    /// A status was reported.
    Status(StatusRecord),
}

/// How far a twin has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// Number of the last response that has begun, counted from the start of the program.
    pub response: u64,
    /// Its step; `None`: it is over, the column is at rest.
    pub step: Option<u64>,
}

/// Everything about a twin at rest on which its future depends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Consecutive number among checkpoints and commands: a gap is a loss.
    pub number: u64,
    /// When.
    pub stamp: Nanos,
    /// The last response that has begun.
    pub response: u64,
    /// All parameters.
    pub parameters: Arc<Parameters>,
    /// Length of the lower bar of the column: an impact at another height has moved hinges 1a and 1b \[m\].
    pub length_below: f64,
    /// Length of the upper bar \[m\].
    pub length_above: f64,
    /// The column.
    pub state: State,
    /// Whether it stands.
    pub condition: Condition,
    /// Its critical velocities; `None` if they are not known yet.
    pub critical_velocities: Option<Arc<[VehicleLimits]>>,
    /// The last impact with the range of its verdict; `None` without one, and in recordings of programs that know no range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judged: Option<JudgedImpact>,
    /// What the sensors have detected.
    pub estimates: Estimates,
    /// What it has been through since the last reset.
    pub life: Life,
    /// Counts since the start of the program.
    pub counts: Counts,
    /// The last rejection since the start of the program.
    pub last_rejection: Option<LastRejection>,
    /// Identifiers of accepted impacts, the oldest first.
    pub seen_ids: Vec<Arc<str>>,
}

/// A command that the twin was given, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandRecord {
    /// Consecutive number among checkpoints and commands: a gap is a loss.
    pub number: u64,
    /// The time of the twin's clock.
    pub now: Nanos,
    /// How far the twin had come.
    pub position: Position,
    /// The command.
    pub command: Command,
    /// Why it was rejected; `None`: it was accepted.
    pub rejection: Option<Rejection>,
    /// An accepted impact, of an event or of an estimate, with what the parameters and the catalogue of vehicles have added, so that a program with another
    /// catalogue notices.
    pub impact: Option<Impact>,
    /// It belongs into a response that was over, which was taken up again.
    pub taken_back: bool,
}

/// When a status was reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatusRecord {
    /// Number of the next checkpoint or command.
    pub next_number: u64,
    /// Stamp of the status.
    pub stamp: Nanos,
    /// How far the twin had come.
    pub position: Position,
}

/// A twin cannot reach a position: it has another past.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the twin is at {found:?} and cannot reach {wanted:?}")]
pub struct NotReached {
    /// Where it is.
    pub found: Position,
    /// Where it should be.
    pub wanted: Position,
}

/// Numbers the entries of a journal and tells when a checkpoint is due.
#[derive(Debug)]
pub(super) struct JournalClock {
    next_number: u64,
    last_checkpoint: Nanos,
    checkpoint_due: bool,
    /// The present command belongs into a response that was over.
    taken_back: bool,
    /// The impact of the present command, once it is accepted.
    impact: Option<Impact>,
}

impl JournalClock {
    pub fn new(now: Nanos) -> Self {
        Self {
            next_number: 0,
            last_checkpoint: now,
            checkpoint_due: true,
            taken_back: false,
            impact: None,
        }
    }

    /// The journal of a twin that continues from a checkpoint.
    pub fn continuing(from: &Checkpoint) -> Self {
        Self {
            next_number: from.number,
            ..Self::new(from.stamp)
        }
    }

    /// Of the next checkpoint or command.
    pub fn next_number(&self) -> u64 {
        self.next_number
    }

    fn number(&mut self) -> u64 {
        let number = self.next_number;
        self.next_number += 1;
        number
    }

    /// The column at rest has changed since the last checkpoint.
    pub fn set_checkpoint_due(&mut self) {
        self.checkpoint_due = true;
    }

    /// The present command belongs into a response that was over.
    pub fn note_taken_back(&mut self) {
        self.taken_back = true;
    }

    /// The present command has led to this impact.
    pub fn note_impact(&mut self, impact: Impact) {
        self.impact = Some(impact);
    }

    pub fn is_checkpoint_due(&self, now: Nanos) -> bool {
        let since = now.saturating_sub(self.last_checkpoint);
        self.checkpoint_due || !(0..CHECKPOINT_PERIOD).contains(&since)
    }

    /// The entry of a checkpoint that has this journal's next number.
    pub fn checkpoint(&mut self, checkpoint: Checkpoint) -> Journal {
        self.number();
        self.checkpoint_due = false;
        self.last_checkpoint = checkpoint.stamp;
        Journal::Checkpoint(Arc::new(checkpoint))
    }

    /// The entry of a command that the twin was given at `position`.
    pub fn command(
        &mut self,
        command: Command,
        rejection: Option<Rejection>,
        position: Position,
        now: Nanos,
    ) -> Journal {
        Journal::Command(Arc::new(CommandRecord {
            number: self.number(),
            now,
            position,
            command,
            rejection,
            impact: self.impact.take(),
            taken_back: std::mem::take(&mut self.taken_back),
        }))
    }
}
