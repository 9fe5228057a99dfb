//! One impact on the undamaged column with all that an engineer needs to judge it.

use super::action_range::ActionRange;
use super::response::input_of_response;
use super::{Assessment, ResidualCapacity, assess};
use crate::column::{
    self, CapacityError, ColumnProperties, Impact, Model, Report, SimulationError, State,
    carried_load, plastic_plateau, respond, with_half_the_step,
};
use crate::parameters::{NoShear, Parameters};

/// What an impact on the undamaged column leads to.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactEvaluation {
    /// The response.
    pub report: Report,
    /// Capacity of the undamaged column and of the column that the impact leaves; `None` if it could not be computed.
    pub remaining: Option<ResidualCapacity>,
    /// Why there are no capacities, if there are none.
    pub capacity_fault: Option<CapacityError>,
    /// Criteria and action; `None` without the capacities.
    pub assessment: Option<Assessment>,
    /// Length of a time step \[s\].
    pub step: f64,
    /// Estimated relative error of the peak `v1`, from a run with half the step; `None` if that run failed.
    pub error_estimate: Option<f64>,
    /// Between which actions the verdict lies; `None` without the capacities.
    pub range: Option<ActionRange>,
    /// `F0`: plastic plateau of the undamaged column under the load that it carries \[N\].
    pub plateau: f64,
    /// Largest force of the vehicle's front within its crush curve \[N\]; `None` for a rigid vehicle.
    pub front_force: Option<f64>,
    /// Why the webs of the column do not yield in shear; `None` where they do.
    pub no_shear: Option<NoShear>,
}

impl ImpactEvaluation {
    /// Completes the evaluation of a response that was computed with [`respond_and_rest`](super::respond_and_rest).
    ///
    /// More responses are computed, one with half the step and those of [`ActionRange::of`], with the push-downs of the column
    /// that each of them leaves.
    ///
    /// # Errors
    /// A column that is out of range, which the response has excluded.
    pub fn complete(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        (report, rest): (Report, Option<State>),
    ) -> Result<Self, SimulationError> {
        let before = &properties.before(impact);
        let model = Model::new(before)?;
        let (remaining, assessment, capacity_fault) =
            match judged(parameters, &model, impact, &report, rest.as_ref()) {
                Ok((remaining, assessment)) => (Some(remaining), Some(assessment), None),
                Err(fault) => (None, None, Some(fault)),
            };
        let range = assessment
            .as_ref()
            .map(|it| ActionRange::of(parameters, properties, impact, None, it));
        // The same load as in the criteria.
        let carried = match &remaining {
            Some(remaining) => remaining.carried_load,
            None => carried_load(&model, &State::at_rest(&model)),
        };
        let duration = parameters.response_duration();
        Ok(Self {
            no_shear: parameters.shear().err(),
            report,
            remaining,
            capacity_fault,
            assessment,
            step: 1e-9 * model.properties.step_nanos as f64,
            error_estimate: error_estimate(&model.properties, impact, duration, &report),
            range,
            plateau: plastic_plateau(&model, carried),
            front_force: impact.vehicle.and_then(|vehicle| {
                let envelope = vehicle.springs().first()?.envelope;
                let forces = envelope.points().iter().map(|point| point[1]);
                Some(forces.fold(0.0, f64::max))
            }),
        })
    }
}

/// The capacities and the assessment of the undamaged column with this `model`, which stood before the bumper of the vehicle, after
/// its response and in the equilibrium `rest`, see [`respond_and_rest`](super::respond_and_rest).
fn judged(
    parameters: &Parameters,
    model: &Model,
    impact: &Impact,
    report: &Report,
    rest: Option<&State>,
) -> Result<(ResidualCapacity, Assessment), CapacityError> {
    let input = input_of_response(parameters, model, impact, report, rest)?;
    Ok((input.remaining, assess(&input)))
}

/// The error of the peak `v1`, estimated from a run with half the step; `None` if that has another outcome.
fn error_estimate(
    properties: &ColumnProperties,
    impact: &Impact,
    duration: f64,
    report: &Report,
) -> Option<f64> {
    let halved = with_half_the_step(properties)?;
    let finer = respond(&halved, impact, duration).ok()?;
    column::error_estimate(report, &finer)
}
