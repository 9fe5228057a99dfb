//! The verdict of both models on one hit without its range, for studies of many hits.

use thiserror::Error;

use super::answer::{BeamDamageBefore, BeamTask};
use super::beam::NoSecondOpinion;
use super::opinion::SecondOpinion;
use crate::assessment::{
    Assessment, AssessmentInput, EarlierImpacts, assess, input_of_response, respond_and_rest,
};
use crate::column::{CapacityError, Impact, Model, Report, SimulationError};
use crate::parameters::Parameters;

/// The verdict of both models on one hit.
#[derive(Debug, Clone, PartialEq)]
pub struct JointVerdict {
    /// The response of the two bars.
    pub report: Report,
    /// All on which their verdict depends.
    pub input: AssessmentInput,
    /// The more severe verdict of both models where that of the beam counts, otherwise that of the two bars.
    pub assessment: Assessment,
    /// The beam, or why there is none; the verdict is then that of the two bars.
    pub second_opinion: Result<SecondOpinion, NoSecondOpinion>,
}

/// Why there is no verdict.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JudgeError {
    /// The two bars do not take the column or the impact, or a step does not converge.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A push-down of the two bars.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
}

impl JointVerdict {
    /// On the impact of these parameters on the undamaged column, bit for bit that of [`evaluate`](super::evaluate).
    ///
    /// # Errors
    /// What the two bars do not compute.
    pub fn of_parameters(parameters: &Parameters) -> Result<Self, JudgeError> {
        let whole = parameters.whole_impact();
        Self::on(
            parameters,
            &parameters.impact(),
            whole,
            parameters.direction(),
        )
    }

    /// On an impact that the parameters do not name: `in_plane` is its component in the plane of the two bars, `whole` has the whole
    /// speed of the vehicle, which travels in this direction \[rad\].
    ///
    /// # Errors
    /// As [`of_parameters`](Self::of_parameters).
    pub fn on(
        parameters: &Parameters,
        in_plane: &Impact,
        whole: Impact,
        direction: f64,
    ) -> Result<Self, JudgeError> {
        Self::after(parameters, in_plane, whole, direction, (None, None))
    }

    /// As [`on`](Self::on), after earlier impacts: what they have left, as the two bars and as the beam know it.
    ///
    /// # Errors
    /// As [`of_parameters`](Self::of_parameters).
    pub fn after(
        parameters: &Parameters,
        in_plane: &Impact,
        whole: Impact,
        direction: f64,
        (earlier, beam_before): (Option<&EarlierImpacts>, Option<BeamDamageBefore>),
    ) -> Result<Self, JudgeError> {
        let properties = parameters.column_properties();
        let duration = parameters.response_duration();
        let (report, rest) = match earlier {
            Some(earlier) => earlier.respond_and_rest(&properties, in_plane, duration),
            None => respond_and_rest(&properties, in_plane, duration),
        }?;
        let model = Model::new(&properties.before(in_plane)).map_err(SimulationError::from)?;
        let mut input = input_of_response(parameters, &model, in_plane, &report, rest.as_ref())?;
        if let Some(impact) = &mut input.impact {
            impact.direction = direction;
        }
        let base_before = earlier.and_then(|it| it.base.as_ref());
        input.base_demand = input.base_demand.map(|demand| demand.after(base_before));
        let mut assessment = assess(&input);
        let lengths = [properties.length_below, properties.length_above];
        let answer = BeamTask::new(parameters, lengths, whole, direction, beam_before)
            .and_then(|task| task.compute_in_turn());
        let second_opinion = answer.map(|answer| {
            SecondOpinion::new(&answer, direction, parameters, &report).weighed(
                &input,
                &mut assessment,
                None,
            )
        });
        Ok(Self {
            report,
            input,
            assessment,
            second_opinion,
        })
    }
}
