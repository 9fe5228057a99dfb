//! A deformable vehicle: a chain of masses with crushable springs in front of them.
//!
//! Spring 1 lies between a massless contact face and the front mass, spring `i >= 2` between mass `i - 1` and mass `i`.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Most masses of a vehicle, each with the spring in front of it.
pub const MAX_MASSES: usize = 3;

/// Most points of a force-crush curve, the origin not counted.
pub const MAX_CURVE_POINTS: usize = 24;

/// Crush up to which a narrow object meets only half of the force that the full width of a front gives, and crush from
/// which it meets all of it, because it has reached the engine \[m\] (an assumption that the centre strip of the load-cell
/// wall of NHTSA test 10146 supports).
const NARROW_RAMP: [f64; 2] = [0.40, 0.55];

/// Share of the force of the full width that a narrow object meets at first.
const NARROW_SHARE: f64 = 0.5;

/// Pieces into which the ramp from [`NARROW_SHARE`] to 1 is divided, where the product of both is a parabola.
const NARROW_PIECES: usize = 6;

/// Least distance between a point of the ramp and one of the curve \[m\]: between closer ones a slope would be round-off.
pub(crate) const NARROW_APART: f64 = 1e-6;

/// Relative tolerance by which the unloading stiffness may fall short of the steepest slope: the round-off of a slope that
/// was computed from two points.
const SLOPE_TOLERANCE: f64 = 1e-9;

/// The envelope of the force of a spring over its crush: piecewise linear from (0, 0) through its points, the last slope
/// continued, but never below zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CurveParts")]
pub struct CrushCurve {
    /// Crush \[m\] and force \[N\]; the first `count` count.
    points: [[f64; 2]; MAX_CURVE_POINTS],
    count: usize,
}

/// One spring of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrushSpring {
    /// Envelope of the force over the crush.
    pub envelope: CrushCurve,
    /// `k_u`: stiffness of unloading and reloading \[N/m\], at least the steepest slope of the envelope.
    pub unloading_stiffness: f64,
    /// Distance that closes before the spring acts \[m\], >= 0; 0 for spring 1.
    pub slack: f64,
}

/// A chain of one to three masses, front first, with one spring in front of each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "VehicleParts")]
pub struct Vehicle {
    masses: [f64; MAX_MASSES],
    springs: [CrushSpring; MAX_MASSES],
    count: usize,
}

/// A number that may be anything, in an error: one of 300 digits with an exponent instead.
pub(crate) struct Readable(pub f64);

impl fmt::Display for Readable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(number) = *self;
        if number == 0.0 || (1e-6..1e12).contains(&number.abs()) {
            write!(f, "{number}")
        } else {
            write!(f, "{number:e}")
        }
    }
}

/// Why some numbers do not make a vehicle.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VehicleError {
    /// Too few or too many masses.
    #[error("the vehicle has {found} masses; expected 1 to {MAX_MASSES}, front first")]
    Masses {
        /// How many.
        found: usize,
    },
    /// A mass that is not a finite number > 0.
    #[error("mass {number} of the vehicle is {found} kg; expected a finite number > 0")]
    Mass {
        /// Its number, from 1 at the front.
        number: usize,
        /// Its value \[kg\].
        found: f64,
    },
    /// Not one spring for each mass.
    #[error(
        "the vehicle has {masses} masses and {springs} springs; expected one spring in front of each mass"
    )]
    Springs {
        /// How many masses.
        masses: usize,
        /// How many springs.
        springs: usize,
    },
    /// Too few or too many points.
    #[error(
        "a force-crush curve has {found} points; expected 1 to {MAX_CURVE_POINTS} after (0, 0)"
    )]
    Points {
        /// How many.
        found: usize,
    },
    /// Crush that does not increase.
    #[error(
        "point {number} of a force-crush curve has a crush of {found} m after {before} m; \
         expected finite values that increase from 0"
    )]
    CrushNotIncreasing {
        /// Its number, from 1.
        number: usize,
        /// Its crush \[m\].
        found: f64,
        /// The crush of the point before \[m\].
        before: f64,
    },
    /// A negative force.
    #[error(
        "point {number} of a force-crush curve has a force of {found} N; expected a finite number >= 0"
    )]
    ForceNegative {
        /// Its number, from 1.
        number: usize,
        /// Its force \[N\].
        found: f64,
    },
    /// A front that gives no force at all.
    #[error("a force-crush curve has no force > 0; a spring needs at least one")]
    NoForce,
    /// Unloading that is softer than loading.
    #[error(
        "the unloading stiffness of spring {spring} is {found:.6e} N/m; \
         expected at least the steepest slope of its force-crush curve, {steepest:.6e} N/m"
    )]
    UnloadingTooSoft {
        /// Number of the spring, from 1.
        spring: usize,
        /// Its unloading stiffness \[N/m\].
        found: f64,
        /// Steepest slope of its envelope \[N/m\].
        steepest: f64,
    },
    /// A slack that is negative, or in front of the first mass.
    #[error(
        "the slack of spring {spring} is {found} m; expected a finite number >= 0, and 0 for spring 1"
    )]
    Slack {
        /// Number of the spring, from 1.
        spring: usize,
        /// Its slack \[m\].
        found: f64,
    },
    /// A total mass that is not a finite number > 0.
    #[error("the vehicle weighs {} kg in total; expected a finite number > 0", Readable(*.found))]
    TotalMass {
        /// The total \[kg\].
        found: f64,
    },
    /// More crushes than springs.
    #[error(
        "{found} crushes are given, but the vehicle has {springs} springs; expected one for each at most"
    )]
    Crushes {
        /// How many are given.
        found: usize,
        /// How many springs there are.
        springs: usize,
    },
    /// A crush that is not a finite number >= 0.
    #[error("the earlier crush of spring {spring} is {found} m; expected a finite number >= 0")]
    Crush {
        /// Number of the spring, from 1.
        spring: usize,
        /// Its value \[m\].
        found: f64,
    },
    /// A factor of the force that is not a finite number > 0.
    #[error("the factor of the vehicle's crush force is {found}; expected a finite number > 0")]
    ForceFactor {
        /// Its value.
        found: f64,
    },
}

impl CrushCurve {
    /// The curve through `points`, crush \[m\] and force \[N\], after the origin.
    ///
    /// # Errors
    /// No points or more than [`MAX_CURVE_POINTS`], crush that does not increase from 0, a negative force, no force at all.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, VehicleError> {
        if points.is_empty() || points.len() > MAX_CURVE_POINTS {
            return Err(VehicleError::Points {
                found: points.len(),
            });
        }
        let mut before = 0.0;
        for (index, &[crush, force]) in points.iter().enumerate() {
            let number = index + 1;
            if !(crush.is_finite() && crush > before) {
                return Err(VehicleError::CrushNotIncreasing {
                    number,
                    found: crush,
                    before,
                });
            }
            if !(force.is_finite() && force >= 0.0) {
                return Err(VehicleError::ForceNegative {
                    number,
                    found: force,
                });
            }
            before = crush;
        }
        if points.iter().all(|point| point[1] == 0.0) {
            return Err(VehicleError::NoForce);
        }
        let mut curve = Self {
            points: [[0.0; 2]; MAX_CURVE_POINTS],
            count: points.len(),
        };
        curve.points[..points.len()].copy_from_slice(points);
        Ok(curve)
    }

    /// The points after the origin: crush \[m\], force \[N\].
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points[..self.count]
    }

    /// The straight pieces from the origin to infinity.
    pub(crate) fn pieces(&self) -> Pieces<'_> {
        Pieces {
            points: self.points(),
            next: 0,
            begin: [0.0; 2],
        }
    }

    /// The pieces from the one on along which the crush grows beyond `crush` \[m\].
    pub(crate) fn pieces_beyond(&self, crush: f64) -> Pieces<'_> {
        let points = self.points();
        let last = points.len() - 1;
        let before_last = points[..last].iter();
        let next = before_last.filter(|point| point[0] <= crush).count();
        let mut pieces = Pieces {
            points,
            next,
            begin: if next == 0 {
                [0.0; 2]
            } else {
                points[next - 1]
            },
        };
        if next == last && pieces.clone().next().is_some_and(|it| it.end <= crush) {
            // The continued last slope has fallen to zero.
            pieces.next();
        }
        pieces
    }

    /// The force at a crush \[N\]; 0 for a crush <= 0.
    #[must_use]
    pub fn force(&self, crush: f64) -> f64 {
        let piece = self.pieces().find(|piece| crush <= piece.end);
        piece.map_or(0.0, |piece| piece.force(crush).max(0.0))
    }

    /// The largest force up to a crush \[N\].
    #[must_use]
    pub fn largest_force_up_to(&self, crush: f64) -> f64 {
        let passed = self.points().iter().filter(|point| point[0] <= crush);
        passed
            .map(|point| point[1])
            .fold(self.force(crush), f64::max)
    }

    /// The steepest slope \[N/m\].
    #[must_use]
    pub fn steepest_slope(&self) -> f64 {
        self.pieces().map(|piece| piece.slope).fold(0.0, f64::max)
    }

    /// The curve with all forces times `factor`.
    fn scaled(mut self, factor: f64) -> Self {
        for point in &mut self.points[..self.count] {
            point[1] *= factor;
        }
        self
    }

    /// The curve that a narrow object meets: a share of the force until it reaches the engine.
    ///
    /// # Errors
    /// Too many points.
    fn against_narrow_object(&self) -> Result<Self, VehicleError> {
        let [begin, end] = NARROW_RAMP;
        let share = |crush: f64| {
            let along = ((crush - begin) / (end - begin)).clamp(0.0, 1.0);
            NARROW_SHARE + (1.0 - NARROW_SHARE) * along
        };
        let mut crushes = [0.0; MAX_CURVE_POINTS + NARROW_PIECES + 2];
        let mut count = 0;
        let ramp = (0..=NARROW_PIECES)
            .map(|k: usize| begin + (end - begin) * k as f64 / NARROW_PIECES as f64)
            .filter(|&crush| {
                let is_apart = |point: &[f64; 2]| (point[0] - crush).abs() > NARROW_APART;
                self.points().iter().all(is_apart)
            });
        // The last slope continues, so that the end of the curve must lie behind the ramp.
        let last = self.points()[self.count - 1][0];
        let behind = (last <= end).then_some(end + (end - begin));
        for crush in self
            .points()
            .iter()
            .map(|point| point[0])
            .chain(ramp)
            .chain(behind)
        {
            crushes[count] = crush;
            count += 1;
        }
        let crushes = &mut crushes[..count];
        crushes.sort_by(f64::total_cmp);
        let mut points = [[0.0; 2]; MAX_CURVE_POINTS + NARROW_PIECES + 2];
        for (point, &mut crush) in points.iter_mut().zip(crushes) {
            *point = [crush, share(crush) * self.force(crush)];
        }
        Self::new(&points[..count])
    }
}

/// A straight piece of a force-crush curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Piece {
    /// Crush \[m\] and force \[N\] at its beginning.
    pub begin: [f64; 2],
    /// \[N/m\].
    pub slope: f64,
    /// Crush at its end \[m\].
    pub end: f64,
}

impl Piece {
    /// Force at a crush on the piece \[N\].
    pub(crate) fn force(&self, crush: f64) -> f64 {
        self.begin[1] + self.slope * (crush - self.begin[0])
    }

    /// Work from one crush on the piece to another \[J\].
    pub(crate) fn work(&self, from: f64, to: f64) -> f64 {
        0.5 * (self.force(from) + self.force(to)) * (to - from)
    }
}

/// The pieces of a force-crush curve from the origin to infinity.
#[derive(Clone)]
pub(crate) struct Pieces<'a> {
    points: &'a [[f64; 2]],
    next: usize,
    begin: [f64; 2],
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let begin = self.begin;
        let Some(&point) = self.points.get(self.next) else {
            // Behind the crush at which the continued last slope has fallen to zero.
            self.begin = [f64::INFINITY, 0.0];
            return begin[0].is_finite().then_some(Piece {
                begin,
                slope: 0.0,
                end: f64::INFINITY,
            });
        };
        let slope = (point[1] - begin[1]) / (point[0] - begin[0]);
        self.next += 1;
        let end = if self.next < self.points.len() {
            point
        } else if slope < 0.0 {
            [begin[0] - begin[1] / slope, 0.0]
        } else {
            [f64::INFINITY, 0.0]
        };
        self.begin = end;
        Some(Piece {
            begin,
            slope,
            end: end[0],
        })
    }
}

impl Vehicle {
    /// A vehicle of `masses` \[kg\], front first, with one spring in front of each.
    ///
    /// # Errors
    /// Numbers that do not make a vehicle; see [`VehicleError`].
    pub fn new(masses: &[f64], springs: &[CrushSpring]) -> Result<Self, VehicleError> {
        let count = masses.len();
        if count == 0 || count > MAX_MASSES {
            return Err(VehicleError::Masses { found: count });
        }
        if springs.len() != count {
            return Err(VehicleError::Springs {
                masses: count,
                springs: springs.len(),
            });
        }
        for (index, &mass) in masses.iter().enumerate() {
            if !(mass.is_finite() && mass > 0.0) {
                return Err(VehicleError::Mass {
                    number: index + 1,
                    found: mass,
                });
            }
        }
        let mut vehicle = Self {
            masses: [0.0; MAX_MASSES],
            springs: [springs[0]; MAX_MASSES],
            count,
        };
        vehicle.masses[..count].copy_from_slice(masses);
        for (index, spring) in springs.iter().enumerate() {
            vehicle.springs[index] = spring.checked(index + 1)?;
        }
        Ok(vehicle)
    }

    /// The masses, front first \[kg\].
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.masses[..self.count]
    }

    /// The springs, each in front of the mass of the same index.
    #[must_use]
    pub fn springs(&self) -> &[CrushSpring] {
        &self.springs[..self.count]
    }

    /// The total mass \[kg\].
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        self.masses().iter().sum()
    }

    /// The vehicle with another total mass \[kg\], as another one of its kind: every mass keeps its share of the total, and the
    /// springs between the masses scale with them, so that a load gives way at the same deceleration. The spring in front of
    /// the first mass stays as it is; [`with_force_factor`](Self::with_force_factor) scales that one.
    ///
    /// # Errors
    /// A total that is not a finite number > 0.
    pub fn with_total_mass(mut self, total: f64) -> Result<Self, VehicleError> {
        if !(total.is_finite() && total > 0.0) {
            return Err(VehicleError::TotalMass { found: total });
        }
        let own = self.total_mass();
        // A total that is the vehicle's own leaves it as it is, to the last bit.
        if total == own {
            return Ok(self);
        }
        let Some((rear, front)) = self.masses[..self.count].split_last_mut() else {
            return Ok(self);
        };
        let factor = total / own;
        front.iter_mut().for_each(|mass| *mass *= factor);
        // The rearmost mass is what is left, so that the masses add up to the total.
        *rear = total - front.iter().sum::<f64>();
        for spring in &mut self.springs[1..self.count] {
            spring.envelope = spring.envelope.scaled(factor);
            spring.unloading_stiffness *= factor;
        }
        Self::new(self.masses(), self.springs())
    }

    /// The vehicle with all forces of its front spring times `factor`; its unloading stiffness scales with them.
    ///
    /// # Errors
    /// A factor that is not a finite number > 0.
    pub fn with_force_factor(mut self, factor: f64) -> Result<Self, VehicleError> {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(VehicleError::ForceFactor { found: factor });
        }
        if factor != 1.0 {
            let front = &mut self.springs[0];
            front.envelope = front.envelope.scaled(factor);
            front.unloading_stiffness *= factor;
            *front = front.checked(1)?;
        }
        // Through `new`, so that equal vehicles are equal in their unused places too, as one that is read back is.
        Self::new(self.masses(), self.springs())
    }

    /// The vehicle whose front meets an object that is narrow beside it, as a column is.
    ///
    /// # Errors
    /// A curve with too many points, or one that becomes steeper than its unloading.
    pub fn against_narrow_object(mut self) -> Result<Self, VehicleError> {
        let front = &mut self.springs[0];
        front.envelope = front.envelope.against_narrow_object()?;
        *front = front.checked(1)?;
        Self::new(self.masses(), self.springs())
    }
}

impl CrushSpring {
    /// Checks the spring of this number, from 1 at the front, and raises an unloading stiffness that falls short of the
    /// steepest slope by round-off to that slope: no crush may give back more energy than it took.
    fn checked(mut self, spring: usize) -> Result<Self, VehicleError> {
        let found = self.unloading_stiffness;
        let steepest = self.envelope.steepest_slope();
        if !(found.is_finite() && found >= steepest * (1.0 - SLOPE_TOLERANCE)) {
            return Err(VehicleError::UnloadingTooSoft {
                spring,
                found,
                steepest,
            });
        }
        self.unloading_stiffness = found.max(steepest);
        let found = self.slack;
        let right = if spring == 1 {
            found == 0.0
        } else {
            found >= 0.0
        };
        if !(found.is_finite() && right) {
            return Err(VehicleError::Slack { spring, found });
        }
        Ok(self)
    }
}

/// A curve that is read and not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveParts {
    points: [[f64; 2]; MAX_CURVE_POINTS],
    count: usize,
}

impl TryFrom<CurveParts> for CrushCurve {
    type Error = VehicleError;

    fn try_from(parts: CurveParts) -> Result<Self, VehicleError> {
        let CurveParts { points, count } = parts;
        let given = points.get(..count);
        Self::new(given.ok_or(VehicleError::Points { found: count })?)
    }
}

/// A vehicle that is read and not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VehicleParts {
    masses: [f64; MAX_MASSES],
    springs: [CrushSpring; MAX_MASSES],
    count: usize,
}

impl TryFrom<VehicleParts> for Vehicle {
    type Error = VehicleError;

    fn try_from(parts: VehicleParts) -> Result<Self, VehicleError> {
        let count = parts.count;
        match (parts.masses.get(..count), parts.springs.get(..count)) {
            (Some(masses), Some(springs)) => Self::new(masses, springs),
            _ => Err(VehicleError::Masses { found: count }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mid_car() -> Vehicle {
        let envelope = CrushCurve::new(&[
            [0.10, 30e3],
            [0.20, 275e3],
            [0.33, 285e3],
            [0.40, 550e3],
            [0.50, 635e3],
            [0.56, 330e3],
            [0.68, 450e3],
            [1.0, 600e3],
        ])
        .expect("a curve");
        let spring = CrushSpring {
            envelope,
            unloading_stiffness: 15e6,
            slack: 0.0,
        };
        Vehicle::new(&[1719.0], &[spring]).expect("a vehicle")
    }

    #[test]
    fn a_curve_is_linear_between_its_points_and_continues_its_last_slope() {
        let curve = mid_car().springs()[0].envelope;
        assert_eq!(curve.force(-0.1), 0.0);
        assert!((curve.force(0.15) - 152.5e3).abs() < 1e-9);
        assert!((curve.force(0.53) - 482.5e3).abs() < 1e-6);
        assert!((curve.force(1.32) - 750e3).abs() < 1e-6);
        assert!((curve.steepest_slope() - 265e3 / 0.07).abs() < 1.0);
        assert_eq!(curve.largest_force_up_to(0.6), 635e3);
    }

    #[test]
    fn a_narrow_object_meets_half_of_the_force_until_it_reaches_the_engine() {
        let full = mid_car();
        let narrow = full.against_narrow_object().expect("a vehicle");
        let (full, narrow) = (full.springs()[0].envelope, narrow.springs()[0].envelope);
        for (crush, share) in [(0.2, 0.5), (0.40, 0.5), (0.55, 1.0), (0.9, 1.0)] {
            let expected = share * full.force(crush);
            let found = narrow.force(crush);
            assert!(
                (found - expected).abs() < 1e-9 * expected,
                "{crush} {found}"
            );
        }
        // On the ramp the product of two lines is a parabola, of which the curve is an inscribed polygon.
        for k in 0..=100 {
            let crush = 0.40 + 0.0015 * f64::from(k);
            let share = 0.5 + 0.5 * (crush - 0.40) / 0.15;
            let error = narrow.force(crush) - share * full.force(crush);
            assert!(error.abs() < 0.012 * full.force(crush), "{crush} {error}");
        }
    }

    #[test]
    fn a_curve_that_ends_on_the_ramp_continues_its_own_slope_behind_it() {
        let envelope = CrushCurve::new(&[[0.45, 300e3]]).expect("a curve");
        let spring = CrushSpring {
            envelope,
            unloading_stiffness: 5e6,
            slack: 0.0,
        };
        let vehicle = Vehicle::new(&[1000.0], &[spring]).expect("a vehicle");
        let narrow = vehicle.against_narrow_object().expect("a vehicle");
        let found = narrow.springs()[0].envelope.force(1.5);
        assert!((found - envelope.force(1.5)).abs() < 1e-6, "{found}");
    }

    /// Of 16 t, a lorry of 8 t with 2.5 t behind a lashing of 400 kN has 5 t behind 800 kN, which is 16 g either way.
    #[test]
    fn load_and_lashing_scale_with_the_total_mass() {
        let front = mid_car().springs()[0];
        let lashing = CrushSpring {
            envelope: CrushCurve::new(&[[0.4 / 3.0, 400e3], [1.0, 400e3]]).expect("a curve"),
            unloading_stiffness: 3e6,
            slack: 0.02,
        };
        let lorry = Vehicle::new(&[5500.0, 2500.0], &[front, lashing]).expect("a vehicle");
        assert_eq!(lorry.with_total_mass(8000.0), Ok(lorry));
        let heavier = lorry.with_total_mass(16_000.0).expect("a vehicle");
        assert_eq!(heavier.masses(), [11_000.0, 5000.0]);
        let [same_front, stronger] = heavier.springs() else {
            panic!("{heavier:?}");
        };
        assert_eq!(*same_front, front);
        assert_eq!(stronger.envelope.force(0.5), 800e3);
        assert_eq!(stronger.unloading_stiffness, 6e6);
        assert_eq!(stronger.slack, 0.02);
        // Lighter than the cab and frame of the lorry of 8 t.
        let lighter = lorry.with_total_mass(4000.0).expect("a vehicle");
        assert_eq!(lighter.masses(), [2750.0, 1250.0]);
        assert_eq!(lighter.springs()[1].envelope.force(0.5), 200e3);
        for total in [0.3, 7999.0, 8000.1, 36_300.7] {
            let other = lorry.with_total_mass(total).expect("a vehicle");
            assert!((other.total_mass() / total - 1.0).abs() < 1e-15);
            let deceleration = other.springs()[1].envelope.force(0.5) / other.masses()[1];
            assert!((deceleration / 160.0 - 1.0).abs() < 1e-12, "{total}");
        }
        let error = lorry.with_total_mass(0.0).expect_err("no mass");
        assert_eq!(
            error.to_string(),
            "the vehicle weighs 0 kg in total; expected a finite number > 0"
        );
    }

    #[test]
    fn impossible_vehicles_are_rejected_with_the_reason() {
        let spring = mid_car().springs()[0];
        let says = |found: Result<Vehicle, VehicleError>, text: &str| {
            let found = found.expect_err(text).to_string();
            assert!(found.contains(text), "{found}");
        };
        says(Vehicle::new(&[], &[]), "0 masses; expected 1 to 3");
        says(Vehicle::new(&[1.0; 4], &[spring; 4]), "4 masses");
        says(
            Vehicle::new(&[1.0, 2.0], &[spring]),
            "2 masses and 1 springs",
        );
        says(
            Vehicle::new(&[-1.0], &[spring]),
            "mass 1 of the vehicle is -1 kg",
        );
        let soft = CrushSpring {
            unloading_stiffness: 1e6,
            ..spring
        };
        says(
            Vehicle::new(&[1.0], &[soft]),
            "the unloading stiffness of spring 1 is 1.000000e6 N/m; expected at least the steepest slope",
        );
        let slack = CrushSpring {
            slack: 0.1,
            ..spring
        };
        says(
            Vehicle::new(&[1.0], &[slack]),
            "the slack of spring 1 is 0.1 m",
        );
        let curve = |points: &[[f64; 2]], text: &str| {
            let found = CrushCurve::new(points).expect_err(text).to_string();
            assert!(found.contains(text), "{found}");
        };
        curve(&[], "0 points");
        curve(&[[0.1, 1.0], [0.1, 2.0]], "a crush of 0.1 m after 0.1 m");
        curve(&[[0.0, 1.0]], "a crush of 0 m after 0 m");
        curve(&[[0.1, -1.0]], "a force of -1 N");
        curve(&[[f64::NAN, 1.0]], "a crush of NaN m");
        curve(&[[0.1, 0.0]], "no force > 0");
    }

    #[test]
    fn a_vehicle_is_read_back_in_every_bit_of_its_text() {
        let narrow = mid_car().against_narrow_object().expect("a vehicle");
        let vehicle = narrow.with_force_factor(1.2).expect("a vehicle");
        let text = serde_json::to_string(&vehicle).expect("JSON");
        let read: Vehicle = serde_json::from_str(&text).expect("a vehicle");
        assert_eq!(serde_json::to_string(&read).expect("JSON"), text);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let vehicle = mid_car();
        let text = serde_json::to_string(&vehicle).expect("JSON");
        assert_eq!(
            serde_json::from_str::<Vehicle>(&text).expect("a vehicle"),
            vehicle
        );
    }
}
