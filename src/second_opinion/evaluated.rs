//! One impact by both models, with the range of its verdict.

use super::beam::NoSecondOpinion;
use super::oblique_range::ObliqueHit;
use super::opinion::SecondOpinion;
use crate::assessment::{ImpactEvaluation, OpenVerdict, respond_and_rest};
use crate::column::SimulationError;
use crate::parameters::Parameters;

/// An impact by both models.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluated {
    /// The two bars, with the verdict of both models.
    pub evaluation: ImpactEvaluation,
    /// The beam, or why there is none.
    pub second_opinion: Result<SecondOpinion, NoSecondOpinion>,
}

/// The impact that the parameters describe on the undamaged column, by both models. The verdict is the more severe one of both, where
/// that of the beam counts.
///
/// # Errors
/// What the two bars do not compute. Where the beam has no result, the evaluation is that of the two bars alone.
pub fn evaluate(parameters: &Parameters) -> Result<Evaluated, SimulationError> {
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let ended = respond_and_rest(&properties, &impact, parameters.response_duration())?;
    let mut evaluation = ImpactEvaluation::complete(parameters, &properties, &impact, ended)?;
    let second_opinion = SecondOpinion::on(parameters, &mut evaluation);
    Ok(Evaluated {
        evaluation,
        second_opinion,
    })
}

impl SecondOpinion {
    /// The beam's opinion on the impact of these parameters, which the two bars have evaluated. Where its verdict counts and is more
    /// severe, the assessment and the range of `evaluation` become those of both models; nothing else changes.
    ///
    /// # Errors
    /// Why there is no second opinion; nothing changes then.
    pub fn on(
        parameters: &Parameters,
        evaluation: &mut ImpactEvaluation,
    ) -> Result<Self, NoSecondOpinion> {
        let mut opinion = Self::beside(parameters, &evaluation.report, evaluation.remaining)?;
        if let Some(assessment) = &mut evaluation.assessment {
            opinion.weigh(assessment, evaluation.range.as_mut());
            let verdict = OpenVerdict::from(&*assessment);
            let oblique = ObliqueHit {
                parameters,
                struck: &parameters.column_properties(),
                in_plane: parameters.impact(),
                whole: parameters.whole_impact(),
                direction: parameters.direction(),
                earlier: None,
                beam_before: None,
            };
            match (oblique.range(&verdict, &mut || true), &mut evaluation.range) {
                (Some(by_both), range) => *range = Some(by_both),
                (None, Some(range)) => {
                    oblique.include_hardening(range, &verdict, opinion.has_yielded());
                }
                (None, None) => {}
            }
        }
        Ok(opinion)
    }
}
