//! What strikes the column: the specification of an impact, with its open values and completed.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::properties::{ColumnProperties, ShearProperties, is_zero};
use super::vehicle::{Readable, Vehicle, VehicleError};

/// The specification of an impact, as an event, a command line or a what-if gives it.
///
/// The velocity is always given, and the mass unless a deformable vehicle has one of its own.
/// [`ImpactSpecification::complete`] takes the gap and the restitution that are left open from the defaults of the column,
/// with them the transverse force, and the vehicle that strikes. The height belongs to the column model, because it divides the column into
/// the two bars; `None` keeps the height of the model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactSpecification {
    /// `m_c`: total mass of the vehicle \[kg\], > 0; 0 or NaN is the own mass of a deformable vehicle.
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
    /// Direction of travel \[rad\], in (-pi, pi]: 0 bends the column about its strong axis, positive turns towards the positive
    /// weak-axis direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<f64>,
}

/// Whether a vehicle can travel in this direction \[rad\]: a number in (-pi, pi].
#[must_use]
pub fn is_direction(direction: f64) -> bool {
    direction > -PI && direction <= PI
}

/// The share of a motion in this direction \[rad\] that lies in the plane of the two bars, 0 to 1. A number that is no direction
/// turns nothing: its share is 1.
#[must_use]
pub fn share_in_plane(direction: f64) -> f64 {
    match is_direction(direction) {
        true => libm::cos(direction).abs(),
        false => 1.0,
    }
}

/// Least share of a motion in the plane of the two bars from which they tell anything of it.
const LEAST_SHARE: f64 = 1e-3;

/// Whether the two bars see a hit in this direction \[rad\] at all: at right angles to their plane it has no component in it.
#[must_use]
pub fn is_seen_by_the_bars(direction: f64) -> bool {
    share_in_plane(direction) > LEAST_SHARE
}

/// The two bars need a velocity above 0 also where the vehicle travels at right angles to their plane \[m/s\].
const LEAST_VELOCITY_IN_PLANE: f64 = 1e-6;

impl ImpactSpecification {
    /// The impact of `vehicle` (`None`: a rigid mass), whose bumper is `bumper_height` \[m\] high, with the open gap and
    /// restitution, and the transverse force, taken from `defaults`, of which nothing else counts. The height of the impact
    /// point does not enter: it belongs to the column model.
    ///
    /// Of a motion out of the plane of the two bars only its component in that plane remains, at least 1e-6 m/s: velocity, gap and
    /// transverse force are multiplied by [`share_in_plane`]. An open direction is 0.
    ///
    /// # Errors
    /// A vehicle whose mass is not a finite number > 0.
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
        let share = share_in_plane(self.direction.unwrap_or(0.0));
        let velocity = match share < 1.0 && self.velocity > 0.0 {
            true => (share * self.velocity).max(LEAST_VELOCITY_IN_PLANE.min(self.velocity)),
            false => self.velocity,
        };
        Ok(Impact {
            mass,
            velocity,
            gap: share * self.gap.unwrap_or(defaults.gap),
            restitution: self.restitution.unwrap_or(defaults.restitution),
            vehicle: vehicle.map(|it| it.with_total_mass(mass)).transpose()?,
            bumper_height,
            transverse_force: share * defaults.transverse_force,
        })
    }
}

impl From<Impact> for ImpactSpecification {
    /// A specification that leaves nothing open but height and direction; the vehicle is no part of it.
    fn from(impact: Impact) -> Self {
        Self {
            mass: impact.mass,
            velocity: impact.velocity,
            gap: Some(impact.gap),
            restitution: Some(impact.restitution),
            height: None,
            direction: None,
        }
    }
}

/// A completed impact: a rigid mass `m_c` or a deformable vehicle that moves towards the impact point.
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
    /// `epsilon` of Newton's law (Eq 36), from 0 (perfectly inelastic) to 1 (elastic); without effect for a deformable
    /// vehicle, which strikes without an impact impulse.
    pub restitution: f64,
    /// The deformable vehicle, whose masses add up to `mass`; `None` is the paper's rigid mass.
    #[serde(default)]
    pub vehicle: Option<Vehicle>,
    /// Height of the bumper, over which the vehicle holds the column straight \[m\], >= 0; 0 is a force at a point. It has an
    /// effect only on a column whose web yields in shear, by
    /// [`ColumnProperties::before`](super::ColumnProperties::before).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bumper_height: f64,
    /// Constant force on the vehicle in its direction of travel \[N\], >= 0, on each of its masses by its share of the total
    /// mass; 0 in the paper. It acts for as long as the vehicle exists, thus before, during and after contact: the weight
    /// `m g` of a mass that falls on a horizontal member. At most 100 m/s² times the mass.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub transverse_force: f64,
}

/// Relative difference by which the mass of an impact may differ from the sum of the masses of its vehicle: round-off.
const MASS_TOLERANCE: f64 = 1e-12;

/// Largest acceleration by the transverse force \[m/s²\], ten times that of free fall, with which no brake, motor or weight
/// pushes a vehicle. A much larger one would move it by more than its contact resolves within a step.
pub const MAX_TRANSVERSE_ACCELERATION: f64 = 100.0;

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
            transverse_force: 0.0,
        }
    }

    /// Acceleration that the transverse force gives the vehicle in free flight \[m/s²\], >= 0.
    pub(crate) fn acceleration(&self) -> f64 {
        self.transverse_force / self.mass
    }

    /// Velocity with which the vehicle arrives at a column at rest \[m/s\].
    pub(crate) fn arrival_velocity(&self) -> f64 {
        if self.transverse_force == 0.0 {
            return self.velocity;
        }
        (self.velocity * self.velocity + 2.0 * self.acceleration() * self.gap).sqrt()
    }

    /// Time that the vehicle needs for its gap, towards a column at rest \[s\].
    #[must_use]
    pub fn approach_secs(&self) -> f64 {
        time_of_travel(self.gap, self.velocity, self.acceleration())
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
            (
                "transverse force [N]",
                self.transverse_force,
                (0.0..=MAX_TRANSVERSE_ACCELERATION * self.mass).contains(&self.transverse_force),
                "a number from 0 to 100 m/s^2 times the mass: in the direction of travel",
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

/// Time for a `distance` \[m\], >= 0, that begins with `velocity` \[m/s\], > 0, under a constant `acceleration` \[m/s²\], >= 0.
/// The form of the root does not cancel.
pub(crate) fn time_of_travel(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    if acceleration == 0.0 {
        return distance / velocity;
    }
    let arrival = (velocity * velocity + 2.0 * acceleration * distance).sqrt();
    2.0 * distance / (velocity + arrival)
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
            transverse_force: 50.0,
        };
        let open = ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: None,
            height: Some(1.2),
            direction: None,
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

    #[test]
    fn the_bars_take_the_component_in_their_plane_of_the_whole_motion() {
        let defaults = Impact {
            gap: 0.4,
            transverse_force: 100.0,
            ..Impact::rigid(1500.0, 10.0)
        };
        let towards = |degrees: f64| {
            let specification = ImpactSpecification {
                gap: None,
                direction: Some(degrees.to_radians()),
                ..ImpactSpecification::from(defaults)
            };
            specification.complete(&defaults, None, 0.0).expect("right")
        };
        assert_eq!(towards(0.0), defaults);
        let oblique = towards(60.0);
        let ratios = [
            oblique.velocity / defaults.velocity,
            oblique.gap / defaults.gap,
            oblique.transverse_force / defaults.transverse_force,
        ];
        assert!(
            ratios.iter().all(|it| (it - 0.5).abs() < 1e-15),
            "{ratios:?}"
        );
        // The vehicle touches the column when it would without its other component.
        assert_eq!(oblique.mass, defaults.mass);
        // From the other side the column is the same.
        assert_eq!(towards(180.0), defaults);
        assert_eq!(towards(-60.0), oblique);
        assert!((towards(120.0).velocity - oblique.velocity).abs() < 1e-14);
        let across = towards(90.0);
        assert_eq!((across.check(), across.velocity), (Ok(()), 1e-6));
        // What is no direction turns nothing.
        for none in [180.1, -180.0, 1e4, f64::NAN, f64::INFINITY] {
            assert_eq!(towards(none), defaults, "{none}");
        }
    }

    #[test]
    fn a_falling_mass_needs_the_time_of_its_fall() {
        let (gap, gravity) = (3.26, 9.81);
        let falls = Impact {
            gap,
            transverse_force: 600.0 * gravity,
            ..Impact::rigid(600.0, 1e-9)
        };
        let expected = (2.0 * gap / gravity).sqrt();
        assert!((falls.approach_secs() - expected).abs() < 1e-9 * expected);
        let flies = Impact {
            transverse_force: 0.0,
            ..falls
        };
        assert_eq!(flies.approach_secs(), gap / 1e-9);
        let pulled_back = Impact {
            transverse_force: -1.0,
            ..falls
        };
        let error = pulled_back.check().expect_err("a force backwards");
        assert!(
            error.to_string().contains("transverse force [N] is -1"),
            "{error}"
        );
    }
}
