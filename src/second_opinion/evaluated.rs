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
    let second_opinion =
        SecondOpinion::beside(parameters, &evaluation.report, evaluation.remaining)
            .map(|opinion| opinion.taken_into(parameters, &mut evaluation));
    Ok(Evaluated {
        evaluation,
        second_opinion,
    })
}

impl SecondOpinion {
    /// Makes the assessment and the range of `evaluation` those of both models where the verdict of this opinion counts and is more
    /// severe; nothing else changes. The impact is that of these parameters on the undamaged column.
    #[must_use]
    pub fn taken_into(
        mut self,
        parameters: &Parameters,
        evaluation: &mut ImpactEvaluation,
    ) -> Self {
        if let Some(assessment) = &mut evaluation.assessment {
            self.weigh(assessment, evaluation.range.as_mut());
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
            oblique.complete(&mut evaluation.range, &verdict, self.has_yielded());
        }
        self
    }
}
