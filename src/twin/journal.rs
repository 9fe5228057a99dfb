//! What a recording needs so that everything can be computed anew: where the twin starts from, what it was given, and
//! how far it had come by then.
//!
//! A twin that is made from a [`Checkpoint`] and given the same inputs at the same [`Position`]s gives out the same
//! states, reports and status, bit for bit. Stamps of refusals and notices, and what computing took, are not among them.
//!
//! A checkpoint lacks the course of the last response. Where a late impact is taken back into it
//! ([`CommandRecord::taken_back`]), a twin that began there cannot follow.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::input::{ImpactEvent, Input, Nanos};
use super::output::{Output, Outputs};
use super::parameter_change::AtRest;
use super::present::Condition;
use super::saved_state::SavedCondition;
use super::seen_ids::SeenIds;
use super::status::Counts;
use super::{Life, MAX_STEPS_PER_CALL, Stopwatch, Twin, exact_number};
use crate::column::{ModelError, State};
use crate::parameters::{Parameters, Value};

/// A twin at rest gives out a checkpoint at least this often \[ns\].
pub const CHECKPOINT_PERIOD: Nanos = 60_000_000_000;

/// One entry of the journal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Journal {
    /// The column is at rest: what is needed to go on from here.
    Checkpoint(Arc<Checkpoint>),
    /// The twin was given something.
    CommandRecord(Arc<CommandRecord>),
    /// A status was taken.
    Status(StatusTaken),
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

/// Everything that what comes after depends on, of a twin at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// Consecutive number among checkpoints and inputs: a gap is a loss.
    pub number: u64,
    /// When.
    pub stamp: Nanos,
    /// Which response came last.
    pub response: u64,
    /// All parameters.
    pub parameters: Arc<Parameters>,
    /// Length of the lower bar of the column as it stands: an impact at another height has moved hinges 1a and 1b
    /// \[m\].
    pub length_below: f64,
    /// Length of the upper bar \[m\].
    pub length_above: f64,
    /// The column.
    pub state: State,
    /// Whether it stands.
    pub condition: SavedCondition,
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// Refused impacts since the last reset.
    pub refused_since_reset: u64,
    /// Work dissipated in the hinges since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// The last accepted impact; empty if there was none.
    pub last_event_id: Arc<str>,
    /// Counts since the start of the program.
    pub counts: Counts,
    /// Why the last input was refused; empty if none was.
    pub last_refusal_reason: Arc<str>,
    /// Identifier of the last refused impact; empty if it was another input.
    pub last_refusal_event_id: Arc<str>,
    /// Identifiers of accepted impacts, the oldest first.
    pub seen_ids: Vec<Arc<str>>,
}

/// Something that the twin was given, and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandRecord {
    /// Consecutive number among checkpoints and inputs: a gap is a loss.
    pub number: u64,
    /// The instant that the twin took it for.
    pub now: Nanos,
    /// How far the twin had come.
    pub position: Position,
    /// What it was given.
    pub given: Command,
    /// Why it was refused; `None`: it was not.
    pub refused: Option<Arc<str>>,
    /// It was taken back into a response that was over.
    pub taken_back: bool,
}

/// What a twin can be given that changes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Something hits the column.
    Impact(ImpactEvent),
    /// Changes of parameters, all or none.
    Parameters {
        /// Names and values.
        #[serde(with = "exact_number::changes")]
        changes: Vec<(String, Value)>,
        /// Who asked.
        source: Arc<str>,
    },
    /// A change of parameters that was found wrong before it came to the twin.
    RefusedChange {
        /// Why.
        reason: Arc<str>,
        /// Who asked.
        source: Arc<str>,
    },
    /// Back to the virgin column.
    Reset {
        /// Who asked.
        source: Arc<str>,
    },
}

impl Command {
    /// The same input, of somebody who waits for no reply.
    #[must_use]
    pub fn input(&self) -> Input {
        match self.clone() {
            Self::Impact(event) => Input::Impact(event),
            Self::Parameters { changes, source } => Input::Parameters {
                changes,
                source,
                reply: None,
            },
            Self::RefusedChange { reason, source } => Input::RefusedChange { reason, source },
            Self::Reset { source } => Input::Reset {
                source,
                reply: None,
            },
        }
    }
}

/// When a status was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatusTaken {
    /// Number of the next checkpoint or input.
    pub next_number: u64,
    /// Stamp of the status.
    pub stamp: Nanos,
    /// How far the twin had come.
    pub position: Position,
}

/// A twin cannot come to a position: it has another past.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the twin is at {found:?} and does not come to {wanted:?}")]
pub struct NotReached {
    /// Where it is.
    pub found: Position,
    /// Where it should come to.
    pub wanted: Position,
}

/// What the twin keeps for its journal.
#[derive(Debug)]
pub(super) struct Bookkeeping {
    /// Of the next entry.
    next_number: u64,
    /// Responses that have begun.
    pub responses: u64,
    /// Of the last checkpoint.
    last_checkpoint: Nanos,
    /// The column at rest is another one since.
    pub due: bool,
    /// The present input is taken back into a response that was over.
    pub taken_back: bool,
}

impl Bookkeeping {
    pub fn new(now: Nanos) -> Self {
        Self {
            next_number: 0,
            responses: 0,
            last_checkpoint: now,
            due: true,
            taken_back: false,
        }
    }

    /// Of the next checkpoint or input.
    pub fn next_number(&self) -> u64 {
        self.next_number
    }

    fn number(&mut self) -> u64 {
        let number = self.next_number;
        self.next_number += 1;
        number
    }
}

impl Twin {
    /// The twin as it was at a checkpoint, without the course of the response before it.
    ///
    /// # Errors
    /// The column is impossible; none that a twin gave out is.
    pub fn from_checkpoint(from: &Checkpoint, stopwatch: Stopwatch) -> Result<Self, ModelError> {
        let parameters = Parameters::clone(&from.parameters);
        let mut properties = parameters.column_properties();
        properties.length_below = from.length_below;
        properties.length_above = from.length_above;
        let model = crate::column::Model::new(&properties)?;
        let mut twin = Self::new(parameters, None, stopwatch, from.stamp)?;
        twin.at_rest = AtRest {
            model,
            state: from.state,
        };
        twin.condition = Condition::from(&from.condition);
        twin.seen = SeenIds::of(&from.seen_ids);
        twin.life = Life {
            impacts: from.impacts_since_reset,
            refused: from.refused_since_reset,
            plastic_work: from.plastic_work_since_reset,
            last_event_id: Arc::clone(&from.last_event_id),
        };
        twin.counts = from.counts;
        twin.last_refusal_reason = Arc::clone(&from.last_refusal_reason);
        twin.last_refusal_event_id = Arc::clone(&from.last_refusal_event_id);
        twin.journal = Bookkeeping {
            next_number: from.number,
            responses: from.response,
            ..Bookkeeping::new(from.stamp)
        };
        Ok(twin)
    }

    /// How far the twin has come.
    #[must_use]
    pub fn position(&self) -> Position {
        Position {
            response: self.journal.responses,
            step: self.run.as_ref().map(|run| run.state.step),
        }
    }

    /// Whether an impact that comes late can still be taken back into the last response.
    #[must_use]
    pub fn knows_last_response(&self) -> bool {
        self.last.is_some()
    }

    /// Everything that what comes after depends on; `None` while a response runs.
    #[must_use]
    pub fn checkpoint(&self, stamp: Nanos) -> Option<Checkpoint> {
        if self.run.is_some() {
            return None;
        }
        Some(Checkpoint {
            number: self.journal.next_number,
            stamp,
            response: self.journal.responses,
            parameters: Arc::clone(&self.parameters),
            length_below: self.at_rest.model.properties.length_below,
            length_above: self.at_rest.model.properties.length_above,
            state: self.at_rest.state,
            condition: SavedCondition::from(&self.condition),
            impacts_since_reset: self.life.impacts,
            refused_since_reset: self.life.refused,
            plastic_work_since_reset: self.life.plastic_work,
            last_event_id: Arc::clone(&self.life.last_event_id),
            counts: self.counts,
            last_refusal_reason: Arc::clone(&self.last_refusal_reason),
            last_refusal_event_id: Arc::clone(&self.last_refusal_event_id),
            seen_ids: self.seen.to_vec(),
        })
    }

    /// Follows the column to a position without a clock. Forecasts come as soon as their impact has begun, states and
    /// reports as they fall due.
    ///
    /// # Errors
    /// It never comes there: it is beyond it already, or is at rest and was not given what leads there.
    pub fn advance_to_position(
        &mut self,
        wanted: Position,
        out: &mut impl Outputs,
    ) -> Result<(), NotReached> {
        loop {
            let found = self.position();
            let not_reached = NotReached { found, wanted };
            let now = found.stamp_towards(wanted, self);
            if found == wanted {
                self.run_ahead(u64::MAX, now.unwrap_or_default(), out);
                return Ok(());
            }
            let now = now.ok_or(not_reached)?;
            self.run_ahead(u64::MAX, now, out);
            self.step_to(now, out);
            if self.position() == found {
                return Err(not_reached);
            }
        }
    }

    /// Follows the column until all states up to an instant are out, or the response is over.
    pub fn advance_to_instant(&mut self, now: Nanos, out: &mut impl Outputs) {
        loop {
            let found = self.position();
            self.run_ahead(u64::MAX, now, out);
            self.step_to(now, out);
            if self.position() == found {
                return;
            }
        }
    }

    /// Gives a checkpoint out where one is due.
    pub(super) fn report_checkpoint(&mut self, now: Nanos, out: &mut impl Outputs) {
        let since = now.saturating_sub(self.journal.last_checkpoint);
        let long_ago = !(0..CHECKPOINT_PERIOD).contains(&since);
        if !(self.journal.due || long_ago) {
            return;
        }
        if let Some(point) = self.checkpoint(now) {
            self.journal.number();
            self.journal.due = false;
            self.journal.last_checkpoint = now;
            out.put(Output::Journal(Journal::Checkpoint(Arc::new(point))));
        }
    }

    /// Notes what the twin was given at `position`.
    pub(super) fn note(
        &mut self,
        given: Command,
        refused: Option<Arc<str>>,
        position: Position,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let handled = CommandRecord {
            number: self.journal.number(),
            now,
            position,
            given,
            refused,
            taken_back: std::mem::take(&mut self.journal.taken_back),
        };
        out.put(Output::Journal(Journal::CommandRecord(Arc::new(handled))));
    }
}

impl Position {
    /// An instant to step a twin that is here to, on its way to `wanted`, not beyond it nor beyond the next impact;
    /// `None` where that does not lie ahead.
    fn stamp_towards(self, wanted: Self, twin: &Twin) -> Option<Nanos> {
        let run = twin.run.as_ref()?;
        let here = run.state.step;
        let step = match wanted.step {
            _ if wanted.response < self.response => return None,
            Some(step) if wanted.response == self.response => (step >= here).then_some(step)?,
            _ => here.saturating_add(u64::from(MAX_STEPS_PER_CALL)),
        };
        let next_impact = twin.impacts_ahead.first().map(|next| next.stamp);
        Some(run.instant_of(step).min(next_impact.unwrap_or(Nanos::MAX)))
    }
}
