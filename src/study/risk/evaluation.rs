//! The action of a sample, by the response of the column.

use super::departure::Departure;
use super::scenario::Scenario;
use crate::assessment::Action;
use crate::column::{Impact, VehicleError};
use crate::parameters::{ParameterFaults, Parameters, Value};
use crate::second_opinion::{JointVerdict, is_out_of_plane};
use crate::study::{BeamSwitchedOff, Evaluation, StudyColumn, StudyError, VerdictModel};

/// Class of doubt of the predictions of hits in the plane of the two bars where the beam judges, unless they are more in doubt: one in
/// five is computed, because at the edge of yielding both models differ by more than the predictions do.
const DOUBT_OF_THE_BEAM: usize = 2;

/// What decides how severe a vehicle's impact is. A study asks it for every sample that it does not skip.
pub trait LimitState: Sync {
    /// The action of this vehicle's impact; `None` if it cannot be computed.
    fn action(&self, departure: &Departure) -> Option<Action>;

    /// How far a prediction of this vehicle's action is in doubt, an index of [`CONTROL_SHARES`](super::CONTROL_SHARES), if its critical
    /// speeds say this: less where they are those of another model.
    fn doubt(&self, _: &Departure, by_critical_speeds: usize) -> usize {
        by_critical_speeds
    }

    /// The action of the same impact at any speed \[m/s\], from which critical speeds follow.
    fn at_speeds<'a>(&'a self, departure: &'a Departure) -> ActionAtSpeed<'a> {
        Box::new(move |speed| {
            self.action(&Departure {
                velocity: speed,
                ..*departure
            })
        })
    }
}

/// The action of an impact as a function of its speed \[m/s\]; `None` where it cannot be computed.
pub type ActionAtSpeed<'a> = Box<dyn Fn(f64) -> Option<Action> + 'a>;

/// The column of a risk study: for every class of vehicles, struck where that class strikes.
#[derive(Debug, Clone)]
pub struct RiskColumn {
    classes: Vec<ClassColumn>,
    yield_strength: Option<f64>,
    top_load: f64,
    /// By which model the samples are judged; critical speeds are those of the two bars.
    model: VerdictModel,
}

#[derive(Debug, Clone)]
struct ClassColumn {
    vehicle: &'static str,
    nominal: StudyColumn,
}

/// Why a column and a scenario make no study.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RiskError {
    /// The column, an impact or a step.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Parameters, as a sample changes them.
    #[error(transparent)]
    Parameters(#[from] ParameterFaults),
    /// The vehicle of a sample.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// A model that the parameters switch off.
    #[error(transparent)]
    BeamSwitchedOff(#[from] BeamSwitchedOff),
    /// There is no second opinion.
    #[error("{0}")]
    NoSecondOpinion(String),
    /// A class of vehicles that strikes above the top of the column.
    #[error(
        "the vehicle {vehicle} strikes {height} m above the base; expected less than {total} m, the height of the column: \
         give classes[].height_m, or a taller column"
    )]
    Height {
        /// Its name.
        vehicle: &'static str,
        /// The height of the contact \[m\].
        height: f64,
        /// The height of the column \[m\].
        total: f64,
    },
}

impl RiskColumn {
    /// The column of the parameters, as the vehicles of the scenario strike it.
    ///
    /// # Errors
    /// Parameters that make no column, or a vehicle that strikes above its top.
    pub fn new(parameters: &Parameters, scenario: &Scenario) -> Result<Self, RiskError> {
        let properties = parameters.column_properties();
        let total = properties.length_below + properties.length_above;
        let classes: Result<Vec<_>, RiskError> = scenario
            .classes
            .iter()
            .map(|class| {
                let parameters = match class.height {
                    None => parameters.clone(),
                    Some(height) if height < total => parameters.with_changes([
                        ("geometry.length_below", Value::Double(height)),
                        ("geometry.length_above", Value::Double(total - height)),
                    ])?,
                    Some(height) => {
                        return Err(RiskError::Height {
                            vehicle: class.vehicle,
                            height,
                            total,
                        });
                    }
                };
                Ok(ClassColumn {
                    vehicle: class.vehicle,
                    nominal: StudyColumn::undamaged(&parameters)?,
                })
            })
            .collect();
        let settings = parameters.settings();
        let by_steel = settings.resistance.moment == 0.0 && settings.resistance.axial == 0.0;
        let strength = &scenario.yield_strength_factor.distribution;
        let nominal = strength.is_fixed() && strength.mean() == 1.0;
        Ok(Self {
            classes: classes?,
            yield_strength: (by_steel && !nominal).then(|| parameters.steel().yield_strength),
            top_load: settings.top.load,
            model: VerdictModel::Bars,
        })
    }

    /// The same column, whose samples another model than the two bars judges.
    ///
    /// # Errors
    /// The model needs the fibre beam, and the parameters switch it off.
    pub fn judged_by(self, model: VerdictModel) -> Result<Self, RiskError> {
        for class in &self.classes {
            model.check_on(class.nominal.parameters())?;
        }
        Ok(Self { model, ..self })
    }

    /// Whether the yield strength of the samples enters: it does where the resistances follow from it, and not where they
    /// are given as numbers.
    #[must_use]
    pub fn varies_yield_strength(&self) -> bool {
        self.yield_strength.is_some()
    }

    /// The column and the impact of a sample.
    ///
    /// # Errors
    /// Numbers that are out of range.
    pub fn sample(&self, departure: &Departure) -> Result<(StudyColumn, Impact), RiskError> {
        let column = self.column(departure)?;
        let direction = departure.direction;
        let direction = direction.unwrap_or_else(|| column.parameters().direction());
        let impact = self.impact(&column, departure, direction)?;
        Ok((column, impact))
    }

    /// The column of a sample.
    fn column(&self, departure: &Departure) -> Result<StudyColumn, RiskError> {
        let class = &self.classes[departure.class];
        let mut changes = Vec::new();
        if let Some(nominal) = self.yield_strength {
            let strength = Value::Double(nominal * departure.yield_factor);
            changes.push(("steel.yield_strength", strength));
        }
        if departure.load_factor != 1.0 {
            changes.push((
                "top.load",
                Value::Double(self.top_load * departure.load_factor),
            ));
        }
        Ok(match changes.is_empty() {
            true => class.nominal.clone(),
            false => StudyColumn::undamaged(&class.nominal.parameters().with_changes(changes)?)?,
        })
    }

    /// The component of the impact of a sample in the plane of the two bars, if it has this direction \[rad\].
    fn impact(
        &self,
        column: &StudyColumn,
        departure: &Departure,
        direction: f64,
    ) -> Result<Impact, RiskError> {
        let impacts = column.impacts_of(Some(self.classes[departure.class].vehicle))?;
        let impacts = impacts.in_direction(direction);
        let mut impact = impacts.impact(Some(departure.mass), departure.velocity)?;
        if let Some(vehicle) = impact.vehicle {
            impact.vehicle = Some(vehicle.with_force_factor(departure.force_factor)?);
        }
        Ok(impact)
    }

    /// The verdict of both models on a sample, without long steps.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn joint(&self, departure: &Departure) -> Result<JointVerdict, RiskError> {
        let column = self.column(departure)?;
        let parameters = column.parameters();
        let direction = departure.direction;
        let direction = direction.unwrap_or_else(|| parameters.direction());
        let [in_plane, whole] =
            [direction, 0.0].map(|direction| self.impact(&column, departure, direction));
        let joint = JointVerdict::on(parameters, &in_plane?, whole?, direction);
        Ok(joint.map_err(StudyError::from)?)
    }

    /// What the impact of a sample leads to, by the model that judges.
    ///
    /// # Errors
    /// Numbers that are out of range, a response that does not converge, or no second opinion where the beam alone judges.
    pub fn evaluate(&self, departure: &Departure) -> Result<Evaluation, RiskError> {
        if self.model == VerdictModel::Bars {
            let (column, impact) = self.sample(departure)?;
            return Ok(column.evaluate(&impact)?);
        }
        let judged = self.model.evaluation(self.joint(departure)?);
        let (evaluation, _) =
            judged.map_err(|reason| RiskError::NoSecondOpinion(reason.to_string()))?;
        Ok(evaluation)
    }
}

impl LimitState for RiskColumn {
    fn action(&self, departure: &Departure) -> Option<Action> {
        if self.model != VerdictModel::Bars {
            return Some(self.evaluate(departure).ok()?.action);
        }
        let (column, impact) = self.sample(departure).ok()?;
        column.action(&impact).ok()
    }

    /// Where the beam judges, the critical speeds of the two bars say less, and out of their plane least.
    fn doubt(&self, departure: &Departure, by_critical_speeds: usize) -> usize {
        if self.model == VerdictModel::Bars {
            return by_critical_speeds;
        }
        let parameters = self.classes[departure.class].nominal.parameters();
        let direction = departure.direction;
        match is_out_of_plane(direction.unwrap_or_else(|| parameters.direction())) {
            true => 0,
            false => by_critical_speeds.min(DOUBT_OF_THE_BEAM),
        }
    }

    /// By the two bars, with one column for all speeds.
    fn at_speeds<'a>(&'a self, departure: &'a Departure) -> ActionAtSpeed<'a> {
        let sample = self.sample(&Departure {
            velocity: 1.0,
            ..*departure
        });
        Box::new(move |speed| {
            let (column, impact) = sample.as_ref().ok()?;
            // The impact at 1 m/s has the share of the velocity in the plane of the two bars.
            let impact = Impact {
                velocity: speed * impact.velocity,
                ..*impact
            };
            column.action(&impact).ok()
        })
    }
}
