//! What a twin needs as one of many: it is made from an equal one, says when it has nothing to do, and keeps no more than it needs.

use std::sync::Arc;

use super::{SolverStatistics, Stopwatch, Twin};
use crate::time::Nanos;
use crate::twin::critical::CriticalVelocityTask;
use crate::twin::estimates::Estimates;
use crate::twin::forecast::SupersededForecasts;
use crate::twin::journal::JournalClock;
use crate::twin::parameter_set::ParameterSet;
use crate::twin::plant::Condition;
use crate::twin::registry::Registry;
use crate::twin::status::StatusClock;

impl Twin {
    /// The twin of another undamaged column that differs from this undamaged one by its names only, without computing its equilibrium
    /// and its capacity again. `None` if this one is not undamaged, or if the columns differ.
    #[must_use]
    pub fn sibling(
        &self,
        parameters: Arc<crate::parameters::Parameters>,
        stopwatch: Stopwatch,
        now: Nanos,
    ) -> Option<Self> {
        let is_undamaged = self.response.is_none()
            && self.journal.responses == 0
            && self.registry.life.impacts_since_reset == 0
            && self.at_rest.condition == Condition::Standing
            && !self.at_rest.is_damaged();
        if !is_undamaged || !self.parameters().differs_by_names_only(&parameters) {
            return None;
        }
        let mut twin = Self {
            estimates: Estimates::default(),
            registry: Registry::new(&parameters.settings().column_id),
            parameters: ParameterSet::new(parameters),
            at_rest: self.at_rest.clone(),
            assessed: self.assessed.clone(),
            undamaged: self.undamaged,
            critical: None,
            judged: None,
            response: None,
            is_completing: false,
            superseded: SupersededForecasts::new(),
            last: None,
            journal: JournalClock::new(now),
            status: StatusClock::new(now),
            solver: SolverStatistics::default(),
            stopwatch,
        };
        twin.parameters.share_fingerprint(&self.parameters);
        Some(twin)
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
        let timeline = &self.last.as_ref()?.response.timeline;
        let end = timeline.instant_of(timeline.step());
        let max_age = 1e9 * self.parameters().settings().event.max_age;
        Some(end.saturating_add(max_age as Nanos))
    }

    /// Frees the memory of the last response if no event that is accepted at `now` can belong to it any more.
    pub fn forget_what_is_too_old(&mut self, now: Nanos) {
        if !self.is_responding() && self.remembers_until().is_some_and(|it| it < now) {
            self.forget_last_response();
        }
    }

    /// Lets a column at rest give out a checkpoint before its next command. A recording of many columns may have begun since its
    /// last one, or may have left it out.
    pub fn demand_checkpoint(&mut self) {
        if !self.is_responding() {
            self.journal.set_checkpoint_due();
        }
    }

    /// Frees the memory of the last response, of which [`Twin::remembers_until`] tells how long events may need it. A change of
    /// `event.max_age` after that does not bring it back.
    pub fn forget_last_response(&mut self) {
        self.last = None;
    }
}

impl CriticalVelocityTask {
    /// Whether impacts have left damage on the column.
    #[must_use]
    pub fn is_damaged(&self) -> bool {
        self.at_rest.is_damaged()
    }

    /// Whether the result is that of another task: the columns differ by their names only.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        self.at_rest == other.at_rest
            && self.action == other.action
            && self.parameters.differs_by_names_only(&other.parameters)
    }
}
