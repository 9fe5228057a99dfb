//! One impact on the virgin column with all that an engineer needs to judge it.

use super::{Assessment, AssessmentInput, RemainingCapacity, assess};
use crate::column::{
    self, CapacityError, ColumnProperties, Impact, Model, Outcome, Progress, Report, Response,
    SimulationError, State, carried_load, plastic_plateau, residual_without_bumper, respond,
    with_half_the_step,
};
use crate::parameters::{NoShear, Parameters};

/// The hardening ratios between which real steel lies, for the band that reports show.
pub const HARDENING_BAND: [f64; 2] = [0.0, 0.01];

/// The response to one impact, without and with hardening: the band in which real steel lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardeningBand {
    /// Outcome for each of [`HARDENING_BAND`].
    pub outcome: [Outcome; 2],
    /// Largest `v1` for each of [`HARDENING_BAND`] \[m\].
    pub max_v1: [f64; 2],
    /// `v1` of the residual equilibrium for each of [`HARDENING_BAND`] \[m\]; `None` if there is none.
    pub residual_v1: [Option<f64>; 2],
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
    /// The band between no hardening and one per cent; `None` if one of its runs failed.
    pub band: Option<HardeningBand>,
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
    /// Three more responses are computed, one with half the step and the others for the band, and two push-downs.
    ///
    /// # Errors
    /// A column that is out of range, which the response has excluded.
    pub fn complete(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        (report, rest): (Report, Option<State>),
    ) -> Result<Self, SimulationError> {
        let properties = &properties.before(impact);
        let model = Model::new(properties)?;
        let whole = model.without_bumper();
        let (remaining, capacity_fault) =
            match RemainingCapacity::compute(parameters, &whole, rest.as_ref()) {
                Ok(remaining) => (Some(remaining), None),
                Err(fault) => (None, Some(fault)),
            };
        let assessment = remaining.map(|remaining| {
            let input =
                AssessmentInput::of_response(parameters, &model, impact, &report, remaining);
            assess(&input)
        });
        let carried = carried_load(&model, &State::at_rest(&model));
        let duration = parameters.response_duration();
        Ok(Self {
            no_shear: parameters.shear().err(),
            report,
            remaining,
            capacity_fault,
            assessment,
            step: 1e-9 * model.properties.step_nanos as f64,
            error_estimate: error_estimate(&model.properties, impact, duration, &report),
            band: band(properties, impact, duration, &report),
            plateau: plastic_plateau(&model, carried),
            front_force: impact.vehicle.and_then(|vehicle| {
                let envelope = vehicle.springs().first()?.envelope;
                let forces = envelope.points().iter().map(|point| point[1]);
                Some(forces.fold(0.0, f64::max))
            }),
        })
    }
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
    mut observe: impl FnMut(&Model, &State),
) -> Result<(Report, Option<State>), SimulationError> {
    let model = Model::new(&properties.before(impact))?;
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, *impact, max_duration)?;
    observe(&model, &state);
    loop {
        let progress = response.advance(&model, &mut state, u64::MAX)?;
        observe(&model, &state);
        if let Progress::Over(end) = progress {
            let report = response.report(&model, &state, end);
            let stands = matches!(report.outcome, Outcome::Elastic | Outcome::Plastic);
            let whole = model.without_bumper();
            let residual = || residual_without_bumper(&model, &state, &whole);
            let rest = stands.then(residual).flatten();
            return Ok((report, rest));
        }
    }
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

fn band(
    properties: &ColumnProperties,
    impact: &Impact,
    duration: f64,
    report: &Report,
) -> Option<HardeningBand> {
    let run = |hardening_ratio: f64| {
        // Without yielding, hardening changes nothing.
        if hardening_ratio == properties.hardening_ratio || report.outcome == Outcome::Elastic {
            return Some(*report);
        }
        let properties = ColumnProperties {
            hardening_ratio,
            ..*properties
        };
        respond(&properties, impact, duration).ok()
    };
    let [without, with] = HARDENING_BAND.map(run);
    let (without, with) = (without?, with?);
    Some(HardeningBand {
        outcome: [without.outcome, with.outcome],
        max_v1: [without.max_v1, with.max_v1],
        residual_v1: [without.residual_v1, with.residual_v1],
    })
}
