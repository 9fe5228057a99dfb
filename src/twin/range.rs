//! The range of the verdict on an impact: between which actions it lies if what is not known exactly of the impact and the
//! column differs. The twin tells what is to be computed once the forecast is complete, and publishes forecast or report once
//! more with the result; another thread computes it.
//!
//! Only the impact on a column at rest has a range; on a damaged one, it varies the assumptions about this impact alone. What would be computed for an impact that another one, a reset, a correction of the damage or a
//! change of parameters has overtaken is not awaited any more.

use std::sync::Arc;

use super::assessed::Assessed;
use super::judged_impact::JudgedImpact;
use super::opinion_state::{KnownBeamDamage, OpinionState};
use super::output::ReportOutput;
use super::plant::{Condition, Plant};
use super::striking::Striking;
use crate::assessment::{ActionRange, EarlierImpacts, OpenVerdict, VerdictRange};
use crate::column::{ColumnProperties, Impact};
use crate::parameters::Parameters;
use crate::second_opinion::ObliqueHit;

/// All on which the range of a verdict depends, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeTask {
    /// Number of the response.
    pub(super) response: u64,
    parameters: Arc<Parameters>,
    properties: ColumnProperties,
    impact: Impact,
    /// The whole speed of the vehicle \[m/s\], and the direction in which it travels \[rad\].
    travel: (f64, f64),
    /// What the impacts before it have left.
    earlier: Option<Arc<EarlierImpacts>>,
    /// The damage of the beam before it, where the verdict has the beam's opinion.
    beam: Option<KnownBeamDamage>,
    /// Whether the beam yields by that opinion.
    yields: bool,
    /// The verdict.
    verdict: OpenVerdict,
}

impl RangeTask {
    /// Computes the range, see [`ActionRange::of_action`]; `go_on` is asked before each response, and `None` is the result once
    /// it returns false.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Arc<VerdictRange>> {
        let Self {
            parameters,
            properties,
            impact,
            travel: (velocity, direction),
            earlier,
            beam,
            yields,
            verdict,
            ..
        } = self;
        let earlier = earlier.as_deref();
        let before = beam.as_ref().and_then(|beam| beam.before().ok());
        let by_both = before.as_ref().map(|before| ObliqueHit {
            parameters,
            struck: properties,
            in_plane: *impact,
            whole: parameters.whole_impact_of(*impact, *velocity),
            direction: *direction,
            earlier,
            beam_before: before.as_ref(),
        });
        if let Some(range) = by_both.and_then(|hit| hit.range(verdict, go_on)) {
            return Some(Arc::new(range.ends));
        }
        let mut range = ActionRange::of_action(
            parameters, properties, impact, *direction, earlier, verdict, go_on,
        )?;
        if let Some(hit) = by_both {
            if !go_on() {
                return None;
            }
            hit.include_hardening(&mut range, verdict, *yields);
        }
        Some(Arc::new(range.ends))
    }

    /// Whether the result is that of another task: the columns differ by their names only, and the same has hit them.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        self.properties == other.properties
            && self.impact == other.impact
            && self.travel == other.travel
            && self.earlier == other.earlier
            && self.beam == other.beam
            && self.yields == other.yields
            && self.verdict == other.verdict
            && self.parameters.differs_by_names_only(&other.parameters)
    }

    pub(super) fn new(
        response: u64,
        parameters: &Arc<Parameters>,
        struck: &ColumnProperties,
        striking: &Striking,
        earlier: Option<&Arc<EarlierImpacts>>,
        (opinion, beam): (&OpinionState, &KnownBeamDamage),
        assessed: &Assessed,
    ) -> Self {
        let is_by_both = *opinion == OpinionState::Known;
        Self {
            response,
            parameters: Arc::clone(parameters),
            properties: ColumnProperties {
                length_below: struck.length_below,
                length_above: struck.length_above,
                ..parameters.column_properties()
            },
            impact: striking.impact,
            travel: (striking.velocity(), striking.direction()),
            earlier: earlier.cloned(),
            beam: is_by_both.then(|| beam.clone()),
            yields: is_by_both
                && assessed
                    .second_opinion
                    .as_ref()
                    .is_some_and(|it| it.has_yielded()),
            verdict: OpenVerdict::from(&assessed.assessment),
        }
    }
}

/// The last impact with what was computed behind its verdict.
#[derive(Debug)]
pub(super) struct Judged {
    pub impact: JudgedImpact,
    /// What computing the response took \[s\].
    compute_time: f64,
}

impl Judged {
    /// Of a response that has ended with this report, after impacts that have left this; `None` if its verdict has neither a range
    /// nor a second opinion.
    pub fn new(
        output: &ReportOutput,
        has_range: bool,
        earlier: Option<Arc<EarlierImpacts>>,
        beam_before: &KnownBeamDamage,
    ) -> Option<Box<Self>> {
        let has_opinion = !matches!(output.opinion, OpinionState::None(_));
        if !(has_range || has_opinion) || output.assessed.is_none() {
            return None;
        }
        let striking = &output.striking;
        Some(Box::new(Self {
            impact: JudgedImpact {
                stamp: output.stamp,
                event_id: Arc::clone(&output.event_id),
                vehicle: Arc::clone(&striking.vehicle),
                impact: striking.impact,
                travel: striking.travel,
                report: output.report,
                error_estimate: output.error_estimate,
                step_nanos: output.step_nanos,
                has_range,
                earlier,
                range: output.range.clone(),
                opinion: output.opinion.clone(),
                beam_before: match has_opinion {
                    true => beam_before.clone(),
                    false => KnownBeamDamage::Undamaged,
                },
            },
            compute_time: output.compute_time,
        }))
    }

    /// Continues from a checkpoint.
    pub fn restored(impact: &JudgedImpact) -> Box<Self> {
        Box::new(Self {
            impact: impact.clone(),
            compute_time: 0.0,
        })
    }

    pub(super) fn output(&self, assessed: Option<Arc<Assessed>>) -> ReportOutput {
        let it = &self.impact;
        ReportOutput {
            stamp: it.stamp,
            event_id: Arc::clone(&it.event_id),
            striking: it.striking(),
            report: it.report,
            assessed,
            error_estimate: it.error_estimate,
            step_nanos: it.step_nanos,
            compute_time: self.compute_time,
            is_superseded: false,
            range: it.range.clone(),
            opinion: it.opinion.clone(),
        }
    }
}

/// Whether the verdict on an impact on this column has a range.
pub(super) fn has_range(before: &Plant) -> bool {
    before.condition == Condition::Standing && before.state.impactor.is_none()
}
