//! The ends of the two bars.

use std::f64::consts::FRAC_PI_2;

use crate::column::{ColumnProperties, HINGES, Sample, Support};
use crate::observables::{BarEnd, HINGE_PLACES};
use crate::parameters::{Parameters, SupportKind};
use crate::twin::Lengths;

/// A point in the plane of bending \[m\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanePoint {
    /// Where the vehicle pushes the two bars: [`Heading::of_bars`](super::Heading::of_bars) tells its sense in space.
    pub x: f64,
    /// Up, from the base.
    pub z: f64,
}

impl PlanePoint {
    /// A point by its coordinates \[m\].
    #[must_use]
    pub const fn new(x: f64, z: f64) -> Self {
        Self { x, z }
    }

    /// `self + factor * other`.
    #[must_use]
    pub fn plus(self, factor: f64, other: Self) -> Self {
        Self::new(self.x + factor * other.x, self.z + factor * other.z)
    }

    /// Distance from the origin \[m\].
    #[must_use]
    pub fn norm(self) -> f64 {
        self.x.hypot(self.z)
    }

    /// The unit vector from here to `other`; upwards if the two coincide.
    #[must_use]
    pub fn direction_to(self, other: Self) -> Self {
        let between = other.plus(-1.0, self);
        let length = between.norm();
        if length > 0.0 {
            Self::new(between.x / length, between.z / length)
        } else {
            Self::new(0.0, 1.0)
        }
    }
}

impl Lengths {
    /// Height of the undeformed column \[m\].
    #[must_use]
    pub fn total(self) -> f64 {
        self.below + self.above
    }
}

impl From<&Parameters> for Lengths {
    fn from(parameters: &Parameters) -> Self {
        let settings = parameters.settings();
        Self {
            below: settings.geometry.length_below,
            above: settings.geometry.length_above,
            top_is_free: settings.support.top == SupportKind::Free,
        }
    }
}

impl From<&ColumnProperties> for Lengths {
    fn from(properties: &ColumnProperties) -> Self {
        Self {
            below: properties.length_below,
            above: properties.length_above,
            top_is_free: properties.top == Support::Free,
        }
    }
}

/// The ends of the bars of a deformed column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joints {
    /// The base, which does not move: hinge 3.
    pub base: PlanePoint,
    /// The impact point: hinges 1a and 1b.
    pub impact: PlanePoint,
    /// The top, which moves only along the column unless it is free: hinge 2.
    pub top: PlanePoint,
}

impl Joints {
    /// The joints of a column whose displacements are magnified by `magnification`.
    #[must_use]
    pub fn new(lengths: Lengths, sample: &Sample, magnification: f64) -> Self {
        let drawn = |displacement: f64| magnification * displacement;
        let impact = PlanePoint::new(drawn(sample.v1), lengths.below - drawn(sample.u1));
        let top = if lengths.top_is_free {
            // The bar above bears nothing and goes on as the column leans at the impact point.
            let lean = match drawn(sample.beta1) {
                lean if lean.is_nan() => 0.0,
                lean => lean.clamp(-FRAC_PI_2, FRAC_PI_2),
            };
            impact.plus(lengths.above, PlanePoint::new(lean.sin(), lean.cos()))
        } else {
            PlanePoint::new(0.0, lengths.total() - drawn(sample.u2))
        };
        Self {
            base: PlanePoint::default(),
            impact,
            top,
        }
    }

    /// The positions at which the hinges 1a, 1b, 2, 3 are shown. Hinges 1a and 1b, which are one point in the model, are
    /// `apart` \[m\] from the impact point along their bars.
    #[must_use]
    pub fn hinges(&self, apart: f64) -> [PlanePoint; HINGES] {
        let joints = [self.base, self.impact, self.top];
        HINGE_PLACES.map(|hinge| {
            let other = usize::from(hinge.bar) + usize::from(hinge.end == BarEnd::Lower);
            match joints[hinge.joint()] {
                impact if hinge.joint() == 1 => {
                    impact.plus(apart, impact.direction_to(joints[other]))
                }
                end => end,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Heading;

    const LENGTHS: Lengths = Lengths {
        below: 1.0,
        above: 3.0,
        top_is_free: false,
    };

    fn bent() -> Sample {
        Sample {
            v1: 0.25,
            u1: 0.125,
            u2: 0.5,
            gap: 0.75,
            ..Sample::default()
        }
    }

    #[test]
    fn the_joints_follow_the_sample() {
        let joints = Joints::new(LENGTHS, &bent(), 1.0);
        assert_eq!(joints.base, PlanePoint::default());
        assert_eq!(joints.impact, PlanePoint::new(0.25, 0.875));
        assert_eq!(joints.top, PlanePoint::new(0.0, 3.5));
    }

    #[test]
    fn magnified_displacements_leave_the_gap_as_it_is() {
        let joints = Joints::new(LENGTHS, &bent(), 2.0);
        assert_eq!(joints.impact, PlanePoint::new(0.5, 0.75));
        assert_eq!(joints.top, PlanePoint::new(0.0, 3.0));
        let front = Heading::default().front(&joints, &bent(), 0.0);
        assert_eq!(joints.impact.x - front, bent().gap);
    }

    #[test]
    fn hinges_1a_and_1b_lie_on_their_bars() {
        let joints = Joints::new(LENGTHS, &bent(), 1.0);
        let [below, above, top, base] = joints.hinges(0.125);
        for (hinge, end) in [(below, base), (above, top)] {
            let whole = joints.impact.direction_to(end);
            let part = joints.impact.direction_to(hinge);
            assert!(whole.plus(-1.0, part).norm() < 1e-15);
            assert!((hinge.plus(-1.0, joints.impact).norm() - 0.125).abs() < 1e-15);
        }
        assert_eq!((top, base), (joints.top, joints.base));
    }
}
