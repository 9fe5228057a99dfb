//! What another thread computes for the twin: asked for, taken, and given out with the forecast or the report once more.

use std::sync::Arc;

use super::Twin;
use crate::second_opinion::SecondOpinion;
use crate::time::Nanos;
use crate::twin::background::BackgroundTask;
use crate::twin::command::Accepted;
use crate::twin::course::ActiveResponse;
use crate::twin::critical::CriticalVelocityTask;
use crate::twin::opinion::OpinionTask;
use crate::twin::opinion_state::{BeamResult, KnownBeamDamage, OpinionState};
use crate::twin::output::{NoticeLevel, Output, Outputs, SupplementedReport, Verdicts};
use crate::twin::range::RangeTask;

impl Twin {
    /// What is to be computed in the background, the most urgent first.
    pub fn background_tasks(&self) -> impl Iterator<Item = BackgroundTask> {
        let opinion = self.opinion_task().map(Box::new);
        let opinion = opinion.map(BackgroundTask::SecondOpinion);
        let range = self.range_task().map(Box::new).map(BackgroundTask::Range);
        let critical = || self.critical_velocity_task();
        let critical = std::iter::once_with(critical).flatten();
        opinion.into_iter().chain(range).chain(
            critical
                .map(Box::new)
                .map(BackgroundTask::CriticalVelocities),
        )
    }

    /// Whether this is still to be computed.
    #[must_use]
    pub fn awaits(&self, task: &BackgroundTask) -> bool {
        let response = self.course.responses();
        match task {
            // One response has one second opinion and one range.
            BackgroundTask::SecondOpinion(task) => {
                self.awaits_opinion() && response == task.response
            }
            BackgroundTask::Range(task) => self.awaits_range() && response == task.response,
            BackgroundTask::CriticalVelocities(task) => {
                self.critical_velocity_task().is_some_and(|it| it == **task)
            }
        }
    }

    /// What is to be computed before [`Command::CriticalVelocities`](super::Command::CriticalVelocities) can be given: the
    /// column is at rest, and its critical velocities are not known. `None` while the column responds to an impact, and if
    /// it is not assessed.
    #[must_use]
    pub fn critical_velocity_task(&self) -> Option<CriticalVelocityTask> {
        let is_known = self.is_responding() || self.column.critical_velocities().is_some();
        (!is_known).then(|| self.task_at_rest()).flatten()
    }

    /// All on which the critical velocities of the column at rest depend, whether they are known or not; `None` if it is not
    /// assessed.
    #[must_use]
    pub fn task_at_rest(&self) -> Option<CriticalVelocityTask> {
        self.column.critical_velocity_task()
    }

    /// Whether there is an [`opinion_task`](Self::opinion_task), without making it.
    #[must_use]
    pub fn awaits_opinion(&self) -> bool {
        let present = self.course.present();
        present.map_or_else(
            || self.column.awaits_opinion(),
            ActiveResponse::awaits_opinion,
        )
    }

    /// What is to be computed before [`Command::SecondOpinion`](super::Command::SecondOpinion) can be given: the second opinion on the
    /// present or the last impact is not known, and its forecast is complete.
    #[must_use]
    pub fn opinion_task(&self) -> Option<OpinionTask> {
        match self.course.present() {
            Some(it) => it.opinion_task(self.course.responses(), &self.column.life().beam),
            None => self
                .opinion_task_at_rest()
                .filter(|_| self.awaits_opinion()),
        }
    }

    /// The hit of the last impact for the beam, whether its answer is known or not; `None` where there is none.
    #[must_use]
    pub fn opinion_task_at_rest(&self) -> Option<OpinionTask> {
        self.column.opinion_task(self.course.responses())
    }

    /// What the twin keeps of the last impact by this result of its [`opinion_task_at_rest`](Self::opinion_task_at_rest): the opinion
    /// and the damage of the beam.
    #[must_use]
    pub fn kept_at_rest(
        &self,
        found: &BeamResult,
    ) -> Option<(Option<Arc<SecondOpinion>>, KnownBeamDamage)> {
        self.column.kept(found)
    }

    /// Whether there is a [`range_task`](Self::range_task), without making it.
    #[must_use]
    pub fn awaits_range(&self) -> bool {
        match self.course.present() {
            Some(response) => response.assessed_without_range().is_some(),
            None => self.column.awaits_range(),
        }
    }

    /// What is to be computed before [`Command::VerdictRange`](super::Command::VerdictRange) can be given: the range of the verdict
    /// on the present or the last impact is not known, and its forecast is complete.
    #[must_use]
    pub fn range_task(&self) -> Option<RangeTask> {
        match self.course.present() {
            Some(it) => it.range_task(self.course.responses(), &self.column.life().beam),
            None => self.range_task_at_rest().filter(|_| self.awaits_range()),
        }
    }

    /// All on which the range of the verdict on the last impact depends, whether it is known or not; `None` where it has none.
    #[must_use]
    pub fn range_task_at_rest(&self) -> Option<RangeTask> {
        self.column.range_task(self.course.responses())
    }

    /// After something was computed in the background: what is not awaited by now was left aside.
    pub(super) fn note_computed(&mut self, is_taken: bool) -> Accepted {
        if !is_taken {
            return Accepted::Unchanged;
        }
        self.status.set_changed();
        // A recording that begins at rest begins with the last checkpoint, and needs no command before it.
        self.demand_checkpoint();
        Accepted::Applied
    }

    /// The forecast or the report of the impact once more, with what was computed behind it.
    fn supplemented(&self) -> Option<SupplementedReport> {
        let present = self.course.present();
        Some(SupplementedReport {
            report: match present {
                Some(response) => response.supplemented_forecast()?,
                None => self.column.supplemented_report()?,
            },
            is_result: present.is_none(),
            movement: None,
        })
    }

    /// Gives out the forecast or the report of the impact once more, with the second opinion and with how the beam moves by it.
    pub(super) fn put_opinion(&self, found: &BeamResult, now: Nanos, out: &mut impl Outputs) {
        let Some(again) = self.supplemented() else {
            return;
        };
        let movement = found.movement();
        let again = SupplementedReport { movement, ..again };
        let event_id = &again.report.event_id;
        if let OpinionState::None(reason) = &again.report.opinion {
            out.notice(
                NoticeLevel::Warning,
                now,
                format!("impact \"{event_id}\": {reason}"),
            );
        }
        let assessed = again.report.assessed.as_deref();
        if let Some(opinion) = assessed.and_then(|it| it.second_opinion.as_ref()) {
            let text = format!("second opinion on impact \"{event_id}\": {opinion}");
            out.notice(NoticeLevel::Info, now, text);
            if opinion.decides {
                out.verdict("second opinion", event_id, assessed, now);
            }
        }
        if again.is_result {
            // The damage that the beam leaves, and its verdict.
            self.save(now, out);
        }
        out.put(Output::Supplemented(again));
    }

    /// Gives out the forecast or the report of the impact once more, with the range of its verdict.
    pub(super) fn put_ranged(&self, now: Nanos, out: &mut impl Outputs) {
        let Some(again) = self.supplemented() else {
            return;
        };
        if let Some(range) = &again.report.range {
            let text = format!(
                "range of the verdict on impact \"{}\": {range}",
                again.report.event_id
            );
            out.notice(NoticeLevel::Info, now, text);
        }
        out.put(Output::Supplemented(again));
    }
}
