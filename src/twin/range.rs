//! The range of the verdict on an impact: between which actions it lies if what is not known exactly of the impact and the
//! column differs. The twin tells what is to be computed once the forecast is complete, and publishes forecast or report once
//! more with the result; another thread computes it.
//!
//! Only the impact on a column at rest without damage has a range, as everywhere else: how a damaged column has hardened
//! with another strength is not known. What would be computed for an impact that another one, a reset, a correction of the damage or a
//! change of parameters has overtaken is not awaited any more.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::active_response::{ActiveResponse, BegunImpact};
use super::assessed::Assessed;
use super::command::Accepted;
use super::lifecycle::Twin;
use super::output::{NoticeLevel, Output, Outputs, RangedReport, ReportOutput};
use super::plant::{Condition, Plant};
use super::what_if::Striking;
use crate::assessment::{Action, ActionRange, VerdictRange};
use crate::column::{ColumnProperties, Impact, Report};
use crate::parameters::Parameters;
use crate::time::Nanos;

/// All on which the range of a verdict depends, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeTask {
    /// Number of the response.
    pub(super) response: u64,
    parameters: Arc<Parameters>,
    properties: ColumnProperties,
    impact: Impact,
    /// The action of the verdict, and whether more than that may have to be done.
    verdict: (Action, bool),
}

impl RangeTask {
    /// Computes the range, see [`ActionRange::of_action`]; `go_on` is asked before each response, and `None` is the result once
    /// it returns false.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Arc<VerdictRange>> {
        let Self {
            parameters,
            properties,
            impact,
            verdict,
            ..
        } = self;
        let range = ActionRange::of_action(parameters, properties, impact, *verdict, go_on)?;
        Some(Arc::new(range.ends))
    }

    /// Whether the result is that of another task: the columns differ by their names only, and the same has hit them.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        self.properties == other.properties
            && self.impact == other.impact
            && self.verdict == other.verdict
            && self.parameters.differs_by_names_only(&other.parameters)
    }

    fn new(
        response: u64,
        parameters: &Arc<Parameters>,
        struck: &ColumnProperties,
        impact: Impact,
        assessed: &Assessed,
    ) -> Self {
        let assessment = &assessed.assessment;
        Self {
            response,
            parameters: Arc::clone(parameters),
            properties: ColumnProperties {
                length_below: struck.length_below,
                length_above: struck.length_above,
                ..parameters.column_properties()
            },
            impact,
            verdict: (assessment.action, assessment.at_least),
        }
    }
}

/// An impact whose report was given out and whose verdict has, or will have, a range: all that is needed to give the report
/// out once more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedImpact {
    /// Stamp of the event.
    pub stamp: Nanos,
    /// The impact.
    pub event_id: Arc<str>,
    /// Name of the vehicle.
    pub vehicle: Arc<str>,
    /// What hit the column.
    pub impact: Impact,
    /// Its outcome.
    pub report: Report,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// Length of a time step \[ns\].
    pub step_nanos: u64,
    /// The range of the verdict; `None` until it is known.
    pub range: Option<Arc<VerdictRange>>,
}

/// The last impact with the range of its verdict.
#[derive(Debug)]
pub(super) struct Judged {
    pub impact: JudgedImpact,
    /// What computing the response took \[s\].
    compute_time: f64,
}

impl Judged {
    /// Of a response that has ended with this report; `None` if its verdict has no range.
    pub fn new(response: &ActiveResponse, output: &ReportOutput) -> Option<Box<Self>> {
        if !has_range(&response.before) || output.assessed.is_none() {
            return None;
        }
        let ReportOutput {
            stamp,
            event_id,
            striking,
            report,
            error_estimate,
            step_nanos,
            compute_time,
            range,
            ..
        } = output.clone();
        Some(Box::new(Self {
            impact: JudgedImpact {
                stamp,
                event_id,
                vehicle: striking.vehicle,
                impact: striking.impact,
                report,
                error_estimate,
                step_nanos,
                range,
            },
            compute_time,
        }))
    }

    /// Continues from a checkpoint.
    pub fn restored(impact: &JudgedImpact) -> Box<Self> {
        Box::new(Self {
            impact: impact.clone(),
            compute_time: 0.0,
        })
    }

    fn output(&self, assessed: Option<Arc<Assessed>>) -> ReportOutput {
        let it = &self.impact;
        ReportOutput {
            stamp: it.stamp,
            event_id: Arc::clone(&it.event_id),
            striking: Striking {
                vehicle: Arc::clone(&it.vehicle),
                impact: it.impact,
            },
            report: it.report,
            assessed,
            error_estimate: it.error_estimate,
            step_nanos: it.step_nanos,
            compute_time: self.compute_time,
            is_superseded: false,
            range: it.range.clone(),
        }
    }
}

/// Whether the verdict on an impact on this column has a range.
fn has_range(before: &Plant) -> bool {
    before.condition == Condition::Standing
        && !before.is_damaged()
        && before.state.impactor.is_none()
}

impl ActiveResponse {
    /// The assessment in the complete forecast, if the range of that is not known yet.
    fn assessed_without_range(&self) -> Option<&Arc<Assessed>> {
        if self.range.is_some() || self.forecast.is_running() || !has_range(&self.before) {
            return None;
        }
        self.forecast.predicted()?.assessed.as_ref()
    }

    fn range_task(&self, response: u64) -> Option<RangeTask> {
        let assessed = self.assessed_without_range()?;
        let BegunImpact {
            parameters,
            striking,
            ..
        } = &self.impact;
        let struck = &self.timeline.plant().model.properties;
        Some(RangeTask::new(
            response,
            parameters,
            struck,
            striking.impact,
            assessed,
        ))
    }

    /// The forecast with the range of its verdict.
    fn ranged_forecast(&self) -> Option<ReportOutput> {
        let predicted = self.forecast.predicted()?;
        Some(ReportOutput {
            range: self.range.clone(),
            ..self.impact.report_output(
                predicted.report,
                predicted.assessed.clone(),
                predicted.error_estimate,
                predicted.compute_nanos,
            )
        })
    }
}

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
        judged.is_some_and(|it| it.impact.range.is_none())
    }

    /// What is to be computed before [`Command::VerdictRange`](super::Command::VerdictRange) can be given: the range of the verdict
    /// on the present or the last impact is not known, and its forecast is complete.
    #[must_use]
    pub fn range_task(&self) -> Option<RangeTask> {
        if let Some(response) = &self.response {
            return response.range_task(self.journal.responses);
        }
        self.range_task_at_rest()
            .filter(|_| self.has_unknown_range())
    }

    /// All on which the range of the verdict on the last impact depends, whether it is known or not; `None` where it has none.
    #[must_use]
    pub fn range_task_at_rest(&self) -> Option<RangeTask> {
        Some(RangeTask::new(
            self.journal.responses,
            self.parameters.current(),
            &self.at_rest.model.properties,
            self.judged.as_ref()?.impact.impact,
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

    /// Gives out the forecast or the report of the impact once more, with the range of its verdict.
    pub(super) fn put_ranged(&self, now: Nanos, out: &mut impl Outputs) {
        let (report, is_result) = match (&self.response, &self.judged) {
            (Some(response), _) => (response.ranged_forecast(), false),
            (None, Some(judged)) => (Some(judged.output(self.assessed.clone())), true),
            (None, None) => (None, true),
        };
        let Some(report) = report else { return };
        if let Some(range) = &report.range {
            let text = format!(
                "range of the verdict on impact \"{}\": {range}",
                report.event_id
            );
            out.notice(NoticeLevel::Info, now, text);
        }
        out.put(Output::Ranged(RangedReport { report, is_result }));
    }

    /// Forgets the range of the verdict on the last impact, which no longer is that of the column.
    pub(super) fn forget_range(&mut self) {
        self.judged = None;
    }

    /// Another impact begins: a range of the verdict on the last one that is not known yet is not awaited any more.
    pub(super) fn withdraw_unknown_range(&mut self) {
        if self.has_unknown_range() {
            self.forget_range();
        }
    }

    /// The range of the verdict on the last impact, if it is known.
    pub(super) fn known_range(&self) -> Option<&Arc<VerdictRange>> {
        self.judged.as_ref()?.impact.range.as_ref()
    }
}
