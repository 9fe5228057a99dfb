//! The verdict of both models on one hit without its range, for studies of many hits.

use thiserror::Error;

use super::answer::BeamTask;
use super::beam::NoSecondOpinion;
use super::opinion::SecondOpinion;
use crate::assessment::{Assessment, AssessmentInput, assess, input_of_response, respond_and_rest};
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
        let properties = parameters.column_properties();
        let (report, rest) =
            respond_and_rest(&properties, in_plane, parameters.response_duration())?;
        let model = Model::new(&properties.before(in_plane)).map_err(SimulationError::from)?;
        let input = input_of_response(parameters, &model, in_plane, &report, rest.as_ref())?;
        let mut assessment = assess(&input);
        let lengths = [properties.length_below, properties.length_above];
        let answer = BeamTask::new(parameters, lengths, whole, direction, None)
            .and_then(|task| task.compute());
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
