//! A twin that is made from a checkpoint or from an equal one, that follows a recorded one without a clock, and that keeps no more than
//! it needs.

use std::sync::Arc;

use super::Twin;
use crate::column::ModelError;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::MAX_STEPS_PER_CALL;
use crate::twin::column_at_rest::ColumnAtRest;
use crate::twin::course::{Course, Stopwatch};
use crate::twin::journal::{Checkpoint, JournalClock, NotReached, Position};
use crate::twin::output::{Output, Outputs};
use crate::twin::registry::{Counts, Registry};

impl Twin {
    /// The twin as it was at a checkpoint, without the course of the response before it.
    ///
    /// # Errors
    /// The column is impossible; a twin gives out no such checkpoint.
    pub fn from_checkpoint(from: &Checkpoint, stopwatch: Stopwatch) -> Result<Self, ModelError> {
        let column = ColumnAtRest::restored(from)?;
        let last_rejection = from.last_rejection.clone();
        let registry = Registry::new(&from.seen_ids, from.counts, last_rejection);
        let course = Course::new(from.response, stopwatch);
        Ok(Self {
            estimates: from.estimates.clone(),
            journal: JournalClock::continuing(from),
            ..Self::of(column, registry, course, from.stamp)
        })
    }

    /// Everything on which the twin's future depends; `None` while a response runs.
    #[must_use]
    pub fn checkpoint(&self, stamp: Nanos) -> Option<Checkpoint> {
        if self.is_responding() {
            return None;
        }
        let plant = self.column.plant();
        let properties = &plant.model.properties;
        Some(Checkpoint {
            number: self.journal.next_number(),
            stamp,
            response: self.course.responses(),
            parameters: Arc::clone(self.parameters()),
            length_below: properties.length_below,
            length_above: properties.length_above,
            state: plant.state,
            condition: plant.condition.clone(),
            critical_velocities: self.column.critical_velocities().map(Arc::clone),
            judged: self.column.judged().cloned(),
            estimates: self.estimates.clone(),
            life: self.column.life().clone(),
            counts: self.registry.counts(),
            last_rejection: self.registry.last_rejection().cloned(),
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
        self.course.position()
    }

    /// Whether the last response is known, so that it can be resumed for a late impact.
    #[must_use]
    pub fn knows_last_response(&self) -> bool {
        self.course.last().is_some()
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
            response: self.course.responses().saturating_add(1),
            step: None,
        };
        while self.course.responses() < next.response
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
        let timeline = self.course.present().map(|it| it.timeline());
        if let Some(now) = timeline.map(|it| it.instant_of(it.step().saturating_add(1))) {
            self.step_to(now, now, out);
        }
    }

    /// An instant to step to on the way to a position, neither beyond it nor beyond the next impact; `None` where the
    /// position is not ahead.
    fn instant_towards(&self, wanted: Position) -> Option<Nanos> {
        let timeline = self.course.present()?.timeline();
        let here = timeline.step();
        let response = self.course.responses();
        let step = match wanted.step {
            _ if wanted.response < response => return None,
            Some(step) if wanted.response == response => (step >= here).then_some(step)?,
            _ => here.saturating_add(u64::from(MAX_STEPS_PER_CALL)),
        };
        let next_impact = self.registry.next_pending().unwrap_or(Nanos::MAX);
        Some(timeline.instant_of(step).min(next_impact))
    }

    // One of many

    /// The twin of another undamaged column that differs from this undamaged one by its names only, without computing its equilibrium
    /// and its capacity again. `None` if this one is not undamaged, or if the columns differ.
    #[must_use]
    pub fn sibling(
        &self,
        parameters: Arc<Parameters>,
        stopwatch: Stopwatch,
        now: Nanos,
    ) -> Option<Self> {
        if self.course.responses() != 0 {
            return None;
        }
        let column = self.column.sibling(parameters)?;
        let course = Course::new(0, stopwatch);
        Some(Self::of(
            column,
            Registry::new(&[], Counts::default(), None),
            course,
            now,
        ))
    }

    /// Whether there is nothing to do for [`Twin::advance_to`] and [`Twin::run_ahead`] until the next command, apart from the
    /// status once per [`STATUS_PERIOD`](crate::twin::STATUS_PERIOD), which repeats what is known.
    #[must_use]
    pub fn is_quiet(&self, now: Nanos) -> bool {
        !self.is_responding() && !self.is_looking_ahead() && self.status.next_deadline(now) > now
    }

    /// The last instant at which an impact event may still belong into the last response: its end and `event.max_age` later.
    /// `None` if there is no such response.
    #[must_use]
    pub fn remembers_until(&self) -> Option<Nanos> {
        let end = self.course.last()?.reached();
        let max_age = 1e9 * self.parameters().settings().event.max_age;
        Some(end.saturating_add(max_age as Nanos))
    }

    /// Frees the memory of the last response if no event that is accepted at `now` can belong to it any more. A change of
    /// `event.max_age` after that does not bring it back.
    pub fn forget_what_is_too_old(&mut self, now: Nanos) {
        if !self.is_responding() && self.remembers_until().is_some_and(|it| it < now) {
            self.course.forget_last();
        }
    }

    /// Lets a column at rest give out a checkpoint before its next command. A recording of many columns may have begun since its
    /// last one, or may have left it out.
    pub fn demand_checkpoint(&mut self) {
        if !self.is_responding() {
            self.journal.set_checkpoint_due();
        }
    }
}
