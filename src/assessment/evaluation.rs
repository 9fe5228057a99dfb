//! One impact on the virgin column with all that an engineer needs to judge it.

use super::action_range::ActionRange;
use super::{Assessment, AssessmentInput, RemainingCapacity, assess};
use crate::column::{
    self, CapacityError, ColumnProperties, Impact, Model, Outcome, Report, SimulationError, State,
    carried_load, follow, plastic_plateau, residual_without_bumper, respond, with_half_the_step,
};
use crate::parameters::{NoShear, POISSON_RATIO, Parameters};

/// The hardening ratios between which real steel lies, for the band that reports show: half of the least and less than the
/// median of what 12 measured columns need (docs/theory.md). Steel with a long plateau has less than they.
pub const HARDENING_BAND: [f64; 2] = [0.003, 0.02];

/// The weakest column of the band, with the least hardening and the softening of the column, and the strongest one, with the
/// most hardening and no softening. The hardening of the column itself lies within the band.
#[must_use]
pub fn band_properties(properties: &ColumnProperties) -> [ColumnProperties; 2] {
    let [least, most] = HARDENING_BAND;
    let own = properties.hardening_ratio;
    [
        (least.min(own), properties.softening),
        (most.max(own), None),
    ]
    .map(|(hardening_ratio, softening)| ColumnProperties {
        softening,
        ..properties.with_hardening(hardening_ratio, POISSON_RATIO)
    })
}

/// What an impact on the virgin column leads to.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactEvaluation {
    /// The response.
    pub report: Report,
    /// Capacity of the virgin column and of the column that the impact leaves; `None` if it could not be computed.
    pub remaining: Option<RemainingCapacity>,
    /// Why there are no capacities, if there are none.
    pub capacity_fault: Option<CapacityError>,
    /// Criteria and severity; `None` without the capacities.
    pub assessment: Option<Assessment>,
    /// Length of a time step \[s\].
    pub step: f64,
    /// Estimated relative error of the largest `v1`, from a run with half the step; `None` if that run failed.
    pub error_estimate: Option<f64>,
    /// Between which actions the verdict lies; `None` without the capacities.
    pub range: Option<ActionRange>,
    /// `F0`: plastic plateau of the virgin column under the load that it carries \[N\].
    pub plateau: f64,
    /// Largest force of the vehicle's front within its crush curve \[N\]; `None` for a rigid vehicle.
    pub front_force: Option<f64>,
    /// Why the webs of the column do not yield in shear; `None` where they do.
    pub no_shear: Option<NoShear>,
}

impl ImpactEvaluation {
    /// Completes the evaluation of a response that was computed with [`respond_and_rest`].
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
            .map(|it| ActionRange::of(parameters, properties, impact, it));
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

/// The capacities and the assessment of the virgin column with this `model`, which stood before the bumper of the vehicle, after
/// its response and in the equilibrium `rest`, see [`respond_and_rest`].
fn judged(
    parameters: &Parameters,
    model: &Model,
    impact: &Impact,
    report: &Report,
    rest: Option<&State>,
) -> Result<(RemainingCapacity, Assessment), CapacityError> {
    let input = input_of(parameters, model, impact, report, rest)?;
    Ok((input.remaining, assess(&input)))
}

/// All that the assessment of such a column depends on, with its capacities.
pub(super) fn input_of(
    parameters: &Parameters,
    model: &Model,
    impact: &Impact,
    report: &Report,
    rest: Option<&State>,
) -> Result<AssessmentInput, CapacityError> {
    let remaining = RemainingCapacity::compute(parameters, &model.without_bumper(), rest)?;
    Ok(AssessmentInput::of_response(
        parameters, model, impact, report, remaining,
    ))
}

/// The response of the virgin column before the bumper of the vehicle, and the equilibrium in which it comes to rest once the
/// vehicle is gone; `None` if it has collapsed or is severed.
///
/// # Errors
/// As [`respond`].
pub fn respond_and_rest(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
) -> Result<(Report, Option<State>), SimulationError> {
    observe_and_rest(properties, impact, max_duration, |_, _| ())
}

/// As [`respond_and_rest`]; `observe` sees the state at the event and after every step, from which it may take a sample.
///
/// # Errors
/// As [`respond`].
pub fn observe_and_rest(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
    observe: impl FnMut(&Model, &State),
) -> Result<(Report, Option<State>), SimulationError> {
    let properties = properties.before(impact);
    let (report, model, state) = follow(&properties, impact, max_duration, observe)?;
    let stands = matches!(report.outcome, Outcome::Elastic | Outcome::Plastic);
    let residual = || residual_without_bumper(&model, &state, &model.without_bumper());
    Ok((report, stands.then(residual).flatten()))
}

/// The error of the largest `v1`, estimated from a run with half the step; `None` if that has another outcome.
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
