//! The response of a column to an impact, and what its assessment depends on.

use serde::{Deserialize, Serialize};

use super::{AssessmentInput, BaseDemand, ResidualCapacity};
use crate::column::{
    CapacityError, ColumnProperties, Impact, Model, Report, ShearProperties, SimulationError,
    State, follow_from, residual_without_bumper,
};
use crate::parameters::{POISSON_RATIO, Parameters};
use crate::standing::StandingColumn;

/// The hardening ratios between which real steel lies, for the band that reports show: half of the least and less than the
/// median of what 12 measured columns need (docs/theory.md). Steel with a long plateau has less than they.
pub const HARDENING_BAND: [f64; 2] = [0.003, 0.02];

/// The weakest column of the band, with the least hardening, the softening of the column and webs that bear without their flanges, and
/// the strongest one, with the most hardening and no softening. The hardening of the column itself lies within the band.
///
/// The flanges that bear `2 m_f / l` beside a sheared web have to bend by several millimetres first. Where the web just yields, it
/// bears alone.
#[must_use]
pub fn band_properties(properties: &ColumnProperties) -> [ColumnProperties; 2] {
    let [least, most] = HARDENING_BAND;
    let own = properties.hardening_ratio;
    let weakest = properties.with_hardening(least.min(own), POISSON_RATIO);
    let strongest = properties.with_hardening(most.max(own), POISSON_RATIO);
    [
        ColumnProperties {
            shear: weakest.shear.map(|shear| ShearProperties {
                flange_moment: 0.0,
                ..shear
            }),
            ..weakest
        },
        ColumnProperties {
            softening: None,
            ..strongest
        },
    ]
}

/// What earlier impacts have left to an impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlierImpacts {
    /// The column as the impact finds it, before the bumper of its vehicle.
    pub column: StandingColumn,
    /// What they have put into the base; `None` where it is not known.
    pub base: Option<BaseDemand>,
}

impl EarlierImpacts {
    /// Whether they have left damage.
    #[must_use]
    pub fn have_damaged(&self) -> bool {
        self.column.damage.is_some()
    }

    /// As [`respond_and_rest`], of the column that they have left. Its properties are those with which it is left, but for what its
    /// equilibrium does not depend on.
    ///
    /// # Errors
    /// As [`respond`](crate::column::respond).
    pub fn respond_and_rest(
        &self,
        properties: &ColumnProperties,
        impact: &Impact,
        max_duration: f64,
    ) -> Result<(Report, Option<State>), SimulationError> {
        let model = Model::new(&properties.before(impact))?;
        let before = self.column.settled(&model);
        observe_from(&model, before, impact, max_duration, |_, _| ())
    }
}

/// All that the assessment of an undamaged column after its response, and in the equilibrium `rest`, depends on, with its capacities.
/// The model is that of the column before the bumper of the vehicle.
///
/// # Errors
/// A push-down that cannot be computed.
pub fn input_of_response(
    parameters: &Parameters,
    model: &Model,
    impact: &Impact,
    report: &Report,
    rest: Option<&State>,
) -> Result<AssessmentInput, CapacityError> {
    let remaining = ResidualCapacity::compute(parameters, &model.without_bumper(), rest)?;
    Ok(AssessmentInput::of_response(
        parameters, model, impact, report, remaining,
    ))
}

/// The response of the undamaged column before the bumper of the vehicle, and the equilibrium in which it comes to rest once the
/// vehicle is gone; `None` if it has collapsed or is fractured.
///
/// # Errors
/// As [`respond`](crate::column::respond).
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
/// As [`respond`](crate::column::respond).
pub fn observe_and_rest(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
    observe: impl FnMut(&Model, &State),
) -> Result<(Report, Option<State>), SimulationError> {
    let model = Model::new(&properties.before(impact))?;
    let rest = State::at_rest(&model);
    observe_from(&model, rest, impact, max_duration, observe)
}

/// As [`observe_and_rest`], of the column of this model, which stands before the bumper of the vehicle and is at rest in the state
/// `before`.
///
/// # Errors
/// An impact that is out of range, or a step that does not converge.
pub fn observe_from(
    model: &Model,
    before: State,
    impact: &Impact,
    max_duration: f64,
    observe: impl FnMut(&Model, &State),
) -> Result<(Report, Option<State>), SimulationError> {
    let (report, state) = follow_from(model, before, impact, max_duration, observe)?;
    let stands = report.outcome.stands();
    let residual = || residual_without_bumper(model, &state, &model.without_bumper());
    Ok((report, stands.then(residual).flatten()))
}
