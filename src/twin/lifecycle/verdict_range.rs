//! The range of the verdict on the present or the last impact: asked for, taken, given out, and forgotten.

use std::sync::Arc;

use super::Twin;
use crate::assessment::VerdictRange;
use crate::time::Nanos;
use crate::twin::command::Accepted;
use crate::twin::opinion_state::OpinionState;
use crate::twin::output::{NoticeLevel, Output, Outputs, SupplementedReport};
use crate::twin::range::RangeTask;

impl Twin {
    /// Whether there is a [`range_task`](Self::range_task), without making it.
    #[must_use]
    pub fn awaits_range(&self) -> bool {
        match &self.response {
            Some(response) => response.assessed_without_range().is_some(),
            None => self.has_unknown_range() && self.assessed.is_some(),
        }
    }

    fn has_unknown_range(&self) -> bool {
        let judged = self.judged.as_ref();
        judged.is_some_and(|it| {
            let it = &it.impact;
            it.has_range && it.range.is_none() && it.opinion != OpinionState::Awaited
        })
    }

    /// What is to be computed before [`Command::VerdictRange`](super::Command::VerdictRange) can be given: the range of the verdict
    /// on the present or the last impact is not known, and its forecast is complete.
    #[must_use]
    pub fn range_task(&self) -> Option<RangeTask> {
        if let Some(response) = &self.response {
            return response.range_task(self.journal.responses, &self.registry.life.beam);
        }
        self.range_task_at_rest()
            .filter(|_| self.has_unknown_range())
    }

    /// All on which the range of the verdict on the last impact depends, whether it is known or not; `None` where it has none.
    #[must_use]
    pub fn range_task_at_rest(&self) -> Option<RangeTask> {
        let judged = &self.judged.as_ref()?.impact;
        if !judged.has_range {
            return None;
        }
        Some(RangeTask::new(
            self.journal.responses,
            self.parameters.current(),
            &self.at_rest.model.properties,
            &judged.striking(),
            judged.earlier.as_ref(),
            (&judged.opinion, &judged.beam_before),
            self.assessed.as_ref()?,
        ))
    }

    /// Takes the range of the verdict on the present or the last impact. If none is awaited by now, it is left aside.
    pub(super) fn take_range(&mut self, range: &Arc<VerdictRange>) -> Accepted {
        if !self.awaits_range() {
            return Accepted::Unchanged;
        }
        let range = Some(Arc::clone(range));
        if let Some(response) = &mut self.response {
            response.range = range;
        } else if let Some(judged) = &mut self.judged {
            judged.impact.range = range;
            // A recording that begins at rest begins with the last checkpoint, and needs no command before it.
            self.journal.set_checkpoint_due();
        }
        self.status.set_changed();
        Accepted::Applied
    }

    /// The forecast or the report of the impact once more, with what was computed behind it.
    pub(super) fn supplemented(&self) -> Option<SupplementedReport> {
        Some(match (&self.response, &self.judged) {
            (Some(response), _) => SupplementedReport {
                report: response.supplemented_forecast()?,
                is_result: false,
                movement: None,
            },
            (None, judged) => SupplementedReport {
                report: judged.as_ref()?.output(self.assessed.clone()),
                is_result: true,
                movement: None,
            },
        })
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

    /// Forgets the range of the verdict on the last impact, which no longer is that of the column.
    pub(super) fn forget_range(&mut self) {
        self.judged = None;
    }

    /// Another impact begins: a second opinion on the last one, or a range of its verdict, that is not known yet is not awaited any more.
    pub(super) fn withdraw_unknown_range(&mut self) {
        if self.has_unknown_range() || self.awaits_opinion() {
            self.forget_range();
        }
    }

    /// The range of the verdict on the last impact, if it is known.
    pub(super) fn known_range(&self) -> Option<&Arc<VerdictRange>> {
        self.judged.as_ref()?.impact.range.as_ref()
    }
}
