//! A twin that continues from a checkpoint and follows a recorded one without a clock.

use std::sync::Arc;

use super::{Stopwatch, Twin};
use crate::column::{Model, ModelError};
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::MAX_STEPS_PER_CALL;
use crate::twin::journal::{Checkpoint, JournalClock, NotReached, Position};
use crate::twin::output::{Output, Outputs};
use crate::twin::plant::Plant;
use crate::twin::range::Judged;

impl Twin {
    /// The twin as it was at a checkpoint, without the course of the response before it.
    ///
    /// # Errors
    /// The column is impossible; a twin gives out no such checkpoint.
    pub fn from_checkpoint(from: &Checkpoint, stopwatch: Stopwatch) -> Result<Self, ModelError> {
        let parameters = Parameters::clone(&from.parameters);
        let mut properties = parameters.column_properties();
        properties.length_below = from.length_below;
        properties.length_above = from.length_above;
        let mut twin = Self::new(parameters, None, stopwatch, from.stamp)?;
        twin.at_rest = Plant {
            model: Model::new(&properties)?,
            state: from.state,
            condition: from.condition.clone(),
        };
        twin.registry.restore_seen_ids(&from.seen_ids);
        twin.registry.life = from.life.clone();
        twin.registry.counts = from.counts;
        twin.registry.last_rejection = from.last_rejection.clone();
        twin.estimates = from.estimates.clone();
        twin.journal = JournalClock::continuing(from);
        twin.assess();
        twin.restore_critical_velocities(from.critical_velocities.as_ref());
        twin.judged = from.judged.as_ref().map(Judged::restored);
        Ok(twin)
    }

    /// Everything on which the twin's future depends; `None` while a response runs.
    #[must_use]
    pub fn checkpoint(&self, stamp: Nanos) -> Option<Checkpoint> {
        if self.response.is_some() {
            return None;
        }
        let properties = &self.at_rest.model.properties;
        Some(Checkpoint {
            number: self.journal.next_number(),
            stamp,
            response: self.journal.responses,
            parameters: Arc::clone(self.parameters.current()),
            length_below: properties.length_below,
            length_above: properties.length_above,
            state: self.at_rest.state,
            condition: self.at_rest.condition.clone(),
            critical_velocities: self.critical_velocities().map(Arc::clone),
            judged: self.judged.as_ref().map(|it| it.impact.clone()),
            estimates: self.estimates.clone(),
            life: self.registry.life.clone(),
            counts: self.registry.counts,
            last_rejection: self.registry.last_rejection.clone(),
            seen_ids: self.registry.seen_ids(),
        })
    }

    /// Gives out a checkpoint where one is due.
    pub(super) fn report_checkpoint(&mut self, now: Nanos, out: &mut impl Outputs) {
        if !self.journal.is_checkpoint_due(now) {
            return;
        }
        if let Some(checkpoint) = self.checkpoint(now) {
            out.put(Output::Journal(self.journal.checkpoint(checkpoint)));
        }
    }

    /// How far the twin has come.
    #[must_use]
    pub fn position(&self) -> Position {
        Position {
            response: self.journal.responses,
            step: self
                .response
                .as_ref()
                .map(|response| response.timeline.step()),
        }
    }

    /// Whether the last response is known, so that it can be resumed for a late impact.
    #[must_use]
    pub fn knows_last_response(&self) -> bool {
        self.last.is_some()
    }

    /// Follows the column to a position without a clock. A forecast is given out as soon as its impact has begun, states
    /// and reports as they fall due.
    ///
    /// # Errors
    /// The position is never reached: the twin is beyond it already, or is at rest and was not given the command that
    /// leads there.
    pub fn advance_to_position(
        &mut self,
        wanted: Position,
        out: &mut impl Outputs,
    ) -> Result<(), NotReached> {
        loop {
            let found = self.position();
            let not_reached = NotReached { found, wanted };
            let now = self.instant_towards(wanted);
            if found == wanted {
                self.run_ahead(u64::MAX, now.unwrap_or_default(), out);
                return Ok(());
            }
            if !self.moves_towards(now.ok_or(not_reached)?, out) {
                return Err(not_reached);
            }
        }
    }

    /// Stamp of the next accepted impact that is still to come.
    #[must_use]
    pub fn next_impact(&self) -> Option<Nanos> {
        self.registry.next_pending()
    }

    /// Follows the column until all states up to an instant are given out, or the response is over.
    pub fn advance_to_instant(&mut self, now: Nanos, out: &mut impl Outputs) {
        while self.moves_towards(now, out) {}
    }

    /// Follows the column until the present response is over.
    pub fn advance_to_end(&mut self, out: &mut impl Outputs) {
        let next = Position {
            response: self.journal.responses.saturating_add(1),
            step: None,
        };
        while self.journal.responses < next.response
            && let Some(now) = self.instant_towards(next)
            && self.moves_towards(now, out)
        {}
    }

    /// Completes the forecasts, and follows the column towards an instant: whether its position has changed.
    fn moves_towards(&mut self, now: Nanos, out: &mut impl Outputs) -> bool {
        let before = self.position();
        self.run_ahead(u64::MAX, now, out);
        self.step_to(now, now, out);
        self.position() != before
    }

    /// Tries the next step of the column: a response whose next step cannot be computed ends there.
    pub fn try_next_step(&mut self, out: &mut impl Outputs) {
        let timeline = self.response.as_ref().map(|response| &response.timeline);
        if let Some(now) = timeline.map(|it| it.instant_of(it.step().saturating_add(1))) {
            self.step_to(now, now, out);
        }
    }

    /// An instant to step to on the way to a position, neither beyond it nor beyond the next impact; `None` where the
    /// position is not ahead.
    fn instant_towards(&self, wanted: Position) -> Option<Nanos> {
        let timeline = &self.response.as_ref()?.timeline;
        let here = timeline.step();
        let response = self.journal.responses;
        let step = match wanted.step {
            _ if wanted.response < response => return None,
            Some(step) if wanted.response == response => (step >= here).then_some(step)?,
            _ => here.saturating_add(u64::from(MAX_STEPS_PER_CALL)),
        };
        let next_impact = self.registry.next_pending().unwrap_or(Nanos::MAX);
        Some(timeline.instant_of(step).min(next_impact))
    }
}
