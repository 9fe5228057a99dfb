//! What strikes the column: the specification of an impact, with its open values and completed.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::properties::{ColumnProperties, ShearProperties, is_zero};
use super::vehicle::{Readable, Vehicle, VehicleError};

/// The specification of an impact, as an event, a command line or a what-if gives it.
///
/// The velocity is always given, and the mass unless a compliant vehicle has one of its own.
/// [`ImpactSpecification::complete`] takes the gap and the restitution that are left open from the defaults of the column,
/// and the vehicle that strikes. The height belongs to the column model, because it divides the column into
/// the two bars; `None` keeps the height of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactSpecification {
    /// `m_c`: total mass of the vehicle \[kg\], > 0; 0 or NaN is the own mass of a compliant vehicle.
    pub mass: f64,
    /// Speed of the vehicle towards the column, over the ground \[m/s\], > 0.
    pub velocity: f64,
    /// Distance to the impact point at time 0 \[m\], >= 0.
    #[serde(default)]
    pub gap: Option<f64>,
    /// Newton's coefficient of restitution (Eq 36), from 0 (perfectly inelastic) to 1 (elastic).
    #[serde(default)]
    pub restitution: Option<f64>,
    /// Height of the impact point above the base \[m\].
    #[serde(default)]
    pub height: Option<f64>,
}

impl ImpactSpecification {
    /// The impact of `vehicle` (`None`: a rigid mass), whose bumper is `bumper_height` \[m\] high, with the open gap and
    /// restitution taken from `defaults`, of which nothing else counts. The height of the impact point does not enter: it
    /// belongs to the column model.
    ///
    /// # Errors
    /// A mass that leaves nothing for the rearmost mass of the vehicle.
    pub fn complete(
        &self,
        defaults: &Impact,
        vehicle: Option<Vehicle>,
        bumper_height: f64,
    ) -> Result<Impact, VehicleError> {
        let is_open = self.mass == 0.0 || self.mass.is_nan();
        let mass = match vehicle {
            Some(vehicle) if is_open => vehicle.total_mass(),
            _ => self.mass,
        };
        Ok(Impact {
            mass,
            velocity: self.velocity,
            gap: self.gap.unwrap_or(defaults.gap),
            restitution: self.restitution.unwrap_or(defaults.restitution),
            vehicle: vehicle.map(|it| it.with_total_mass(mass)).transpose()?,
            bumper_height,
        })
    }
}

impl From<Impact> for ImpactSpecification {
    /// A specification that leaves nothing open but the height; the vehicle is no part of it.
    fn from(impact: Impact) -> Self {
        Self {
            mass: impact.mass,
            velocity: impact.velocity,
            gap: Some(impact.gap),
            restitution: Some(impact.restitution),
            height: None,
        }
    }
}

/// A completed impact: a rigid mass `m_c` or a compliant vehicle that moves towards the impact point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Impact {
    /// `m_c`: total mass of the vehicle \[kg\], > 0.
    pub mass: f64,
    /// Speed of the vehicle towards the column, over the ground; the closing speed on a column at rest
    /// \[m/s\], > 0.
    pub velocity: f64,
    /// Distance to the impact point at time 0 \[m\], >= 0.
    pub gap: f64,
    /// `epsilon` of Newton's law (Eq 36), from 0 (perfectly inelastic) to 1 (elastic); without effect for a compliant
    /// vehicle, which strikes without a percussion.
    pub restitution: f64,
    /// The compliant vehicle, whose masses add up to `mass`; `None` is the paper's rigid mass.
    #[serde(default)]
    pub vehicle: Option<Vehicle>,
    /// Height of the bumper, over which the vehicle holds the column straight \[m\], >= 0; 0 is a force at a point. It has an
    /// effect only on a column whose web yields in shear, by
    /// [`ColumnProperties::before`](super::ColumnProperties::before).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bumper_height: f64,
}

/// Relative difference by which the mass of an impact may differ from the sum of the masses of its vehicle: round-off.
const MASS_TOLERANCE: f64 = 1e-12;

/// Why an impact is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the impact's {name} is {}; expected {expected}", Readable(*.found))]
pub struct ImpactError {
    /// Which number.
    pub name: &'static str,
    /// Its value.
    pub found: f64,
    /// What is expected instead.
    pub expected: &'static str,
}

impl Impact {
    /// The impact of a rigid mass \[kg\] with this velocity \[m/s\], without a gap and perfectly inelastic.
    #[must_use]
    pub fn rigid(mass: f64, velocity: f64) -> Self {
        Self {
            mass,
            velocity,
            gap: 0.0,
            restitution: 0.0,
            vehicle: None,
            bumper_height: 0.0,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number that is NaN, infinite or out of range.
    pub fn check(&self) -> Result<(), ImpactError> {
        let checks = [
            (
                "mass [kg]",
                self.mass,
                self.mass > 0.0,
                "a finite number > 0",
            ),
            (
                "velocity [m/s]",
                self.velocity,
                self.velocity > 0.0,
                "a finite number > 0: towards the column",
            ),
            ("gap [m]", self.gap, self.gap >= 0.0, "a finite number >= 0"),
            (
                "restitution",
                self.restitution,
                (0.0..=1.0).contains(&self.restitution),
                "a number from 0 to 1",
            ),
            (
                "bumper height [m]",
                self.bumper_height,
                self.bumper_height >= 0.0,
                "a finite number >= 0",
            ),
        ];
        for (name, found, right, expected) in checks {
            if !(found.is_finite() && right) {
                return Err(ImpactError {
                    name,
                    found,
                    expected,
                });
            }
        }
        if let Some(vehicle) = &self.vehicle
            && (self.mass - vehicle.total_mass()).abs() > MASS_TOLERANCE * self.mass
        {
            return Err(ImpactError {
                name: "mass [kg]",
                found: self.mass,
                expected: "the sum of the masses of its vehicle",
            });
        }
        Ok(())
    }

    /// Kinetic energy \[J\].
    pub fn energy(&self) -> f64 {
        0.5 * self.mass * self.velocity * self.velocity
    }
}

impl ColumnProperties {
    /// The column as it is before the bumper of this impact. Without [`shear`](Self::shear) it is the same.
    #[must_use]
    pub fn before(&self, impact: &Impact) -> Self {
        let shear = self.shear.map(|shear| ShearProperties {
            bumper_height: impact.bumper_height,
            ..shear
        });
        Self { shear, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_values_come_from_the_defaults_and_given_ones_stay() {
        let defaults = Impact {
            mass: 1.0,
            velocity: 2.0,
            gap: 0.3,
            restitution: 0.4,
            vehicle: None,
            bumper_height: 0.0,
        };
        let open = ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: None,
            height: Some(1.2),
        };
        let completed = open.complete(&defaults, None, 0.0);
        let expected = Impact {
            mass: 1500.0,
            velocity: 10.0,
            ..defaults
        };
        assert_eq!(completed, Ok(expected));
        let given = ImpactSpecification {
            gap: Some(0.0),
            restitution: Some(0.0),
            ..open
        };
        let expected = Impact {
            gap: 0.0,
            restitution: 0.0,
            ..expected
        };
        assert_eq!(given.complete(&defaults, None, 0.0), Ok(expected));
        assert_eq!(
            ImpactSpecification::from(expected).complete(&defaults, None, 0.0),
            Ok(expected)
        );
    }
}
