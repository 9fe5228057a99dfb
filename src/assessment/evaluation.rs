//! One impact on the virgin column with all that an engineer needs to judge it.

use super::{Assessment, AssessmentInput, RemainingCapacity, Severity, assess};
use crate::column::{
    self, CapacityError, ColumnProperties, Impact, Model, Outcome, Report, SimulationError, State,
    carried_load, follow, plastic_plateau, residual_without_bumper, respond, with_half_the_step,
};
use crate::parameters::{NoShear, Parameters, Value};

/// The hardening ratios between which real steel lies, for the band that reports show: half of the least and less than the
/// median of what 12 measured columns need (docs/theory.md). Steel with a long plateau has less than they.
pub const HARDENING_BAND: [f64; 2] = [0.003, 0.02];

/// The response to one impact of the weakest and of the strongest real column with this yield strength: the band in which its
/// result lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardeningBand {
    /// Hardening ratio of each of [`band_properties`].
    pub hardening: [f64; 2],
    /// Outcome for each of [`band_properties`].
    pub outcome: [Outcome; 2],
    /// Largest `v1` for each of [`band_properties`] \[m\].
    pub max_v1: [f64; 2],
    /// `v1` of the residual equilibrium for each of [`band_properties`] \[m\]; `None` if there is none.
    pub residual_v1: [Option<f64>; 2],
    /// Whether the weakest column softens.
    pub softens: bool,
}

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
        hardening_ratio,
        softening,
        ..*properties
    })
}

/// The same impact with the whole force of the vehicle's front: without the assumption that a column meets less of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WholeFront {
    /// Outcome of the response.
    pub outcome: Outcome,
    /// Largest `v1` \[m\].
    pub max_v1: f64,
    /// What would have to be done; `None` if the capacities could not be computed.
    pub severity: Option<Severity>,
}

impl WholeFront {
    /// Computes another response of the virgin column. `None` if the impact is not that of the parameters, its vehicle meets the
    /// column with its whole front anyway, or the response cannot be computed.
    #[must_use]
    pub fn of(parameters: &Parameters, impact: &Impact) -> Option<Self> {
        let is_narrow = parameters.settings().vehicle.narrow_object && impact.vehicle.is_some();
        if !is_narrow || parameters.impact() != *impact {
            return None;
        }
        let changes = [("vehicle.narrow_object", Value::from(false))];
        let impact = parameters.with_changes(changes).ok()?.impact();
        let properties = parameters.column_properties();
        let duration = parameters.response_duration();
        let (report, rest) = respond_and_rest(&properties, &impact, duration).ok()?;
        let model = Model::new(&properties).ok()?;
        let remaining = RemainingCapacity::compute(parameters, &model, rest.as_ref()).ok();
        Some(Self {
            outcome: report.outcome,
            max_v1: report.max_v1,
            severity: remaining.map(|remaining| {
                let input =
                    AssessmentInput::of_response(parameters, &model, &impact, &report, remaining);
                assess(&input).severity
            }),
        })
    }
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
    /// The band of hardening and softening; `None` if one of its runs failed.
    pub band: Option<HardeningBand>,
    /// What the factor for narrow objects, an assumption, has changed; `None` where it takes no part.
    pub whole_front: Option<WholeFront>,
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
    /// Three or four more responses are computed, one with half the step, two for the band and one with the whole front of the
    /// vehicle, and the push-downs of the virgin and of the damaged column.
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
            band: band(properties, impact, duration, &report),
            whole_front: WholeFront::of(parameters, impact),
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

fn band(
    properties: &ColumnProperties,
    impact: &Impact,
    duration: f64,
    report: &Report,
) -> Option<HardeningBand> {
    let run = |changed: ColumnProperties| {
        // Without yielding, neither hardening nor softening changes anything.
        if changed == *properties || report.outcome == Outcome::Elastic {
            return Some(*report);
        }
        respond(&changed, impact, duration).ok()
    };
    let ends = band_properties(properties);
    let [weakest, strongest] = ends.map(run);
    let (weakest, strongest) = (weakest?, strongest?);
    Some(HardeningBand {
        hardening: ends.map(|end| end.hardening_ratio),
        outcome: [weakest.outcome, strongest.outcome],
        max_v1: [weakest.max_v1, strongest.max_v1],
        residual_v1: [weakest.residual_v1, strongest.residual_v1],
        softens: properties.softening.is_some(),
    })
}
