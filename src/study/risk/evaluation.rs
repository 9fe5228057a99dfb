//! The action of a sample, by the response of the column.

use super::departure::Departure;
use super::scenario::Scenario;
use crate::assessment::Action;
use crate::column::{Impact, VehicleError};
use crate::parameters::{ParameterFaults, Parameters, Value};
use crate::study::{Evaluation, StudyColumn, StudyError};

/// What decides how severe a vehicle's impact is. A study asks it for every sample that it does not skip.
pub trait LimitState: Sync {
    /// The action of this vehicle's impact; `None` if it cannot be computed.
    fn action(&self, departure: &Departure) -> Option<Action>;

    /// The action of the same impact at any speed \[m/s\].
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
        })
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
        let column = match changes.is_empty() {
            true => class.nominal.clone(),
            false => StudyColumn::undamaged(&class.nominal.parameters().with_changes(changes)?)?,
        };
        let mut impact = column.impact(
            Some(class.vehicle),
            Some(departure.mass),
            departure.velocity,
        )?;
        if let Some(vehicle) = impact.vehicle {
            impact.vehicle = Some(vehicle.with_force_factor(departure.force_factor)?);
        }
        Ok((column, impact))
    }

    /// What the impact of a sample leads to.
    ///
    /// # Errors
    /// Numbers that are out of range, or a response that does not converge.
    pub fn evaluate(&self, departure: &Departure) -> Result<Evaluation, RiskError> {
        let (column, impact) = self.sample(departure)?;
        Ok(column.evaluate(&impact)?)
    }
}

impl LimitState for RiskColumn {
    fn action(&self, departure: &Departure) -> Option<Action> {
        let (column, impact) = self.sample(departure).ok()?;
        column.action(&impact).ok()
    }

    /// With one column for all speeds.
    fn at_speeds<'a>(&'a self, departure: &'a Departure) -> ActionAtSpeed<'a> {
        let sample = self.sample(&Departure {
            velocity: 1.0,
            ..*departure
        });
        Box::new(move |speed| {
            let (column, impact) = sample.as_ref().ok()?;
            let impact = Impact {
                velocity: speed,
                ..*impact
            };
            column.action(&impact).ok()
        })
    }
}
