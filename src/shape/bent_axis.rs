//! The axis of the deformed column: two straight bars with a short smooth bend at each joint.

use std::f64::consts::FRAC_PI_2;

use super::joints::{Joints, PlanePoint};
use crate::column::WEBS;

/// Length of a bend next to a joint, as a fraction of the shorter bar; at most 0.25 m.
pub const BEND_LENGTH: f64 = 0.2;

/// Maximum length of a bend next to a joint \[m\].
const MAX_BEND: f64 = 0.25;

/// Number of pieces of a bend on one side of a joint.
const BEND_PIECES: usize = 4;

/// A point on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Position \[m\].
    pub place: PlanePoint,
    /// Unit tangent of the axis, upwards.
    pub direction: PlanePoint,
    /// Unit normal of the section, upwards: the tangent, but for a web that is sheared, whose sections stay behind.
    pub section: PlanePoint,
}

/// The axis of the deformed column from the base to the top.
#[derive(Debug, Clone, PartialEq)]
pub struct BentAxis {
    stations: Vec<Station>,
}

impl BentAxis {
    /// Number of stations of every axis.
    pub const STATIONS: usize = 4 * BEND_PIECES + 3;

    /// The axis through the joints. `rotation` \[rad\] is that of the impact point, positive if the axis leans towards
    /// positive `x` on its way up; ends that are not fixed turn with their bar. `shear` are the shear angles of the webs below
    /// and above the impact point \[rad\], by which their sections do not follow the axis.
    #[must_use]
    pub fn new(
        joints: &Joints,
        rotation: f64,
        shear: [f64; WEBS],
        base_is_fixed: bool,
        top_is_fixed: bool,
    ) -> Self {
        let Joints { base, impact, top } = *joints;
        let (below, above) = (base.direction_to(impact), impact.direction_to(top));
        let up = PlanePoint::new(0.0, 1.0);
        let at_base = if base_is_fixed { up } else { below };
        let at_top = if top_is_fixed { up } else { above };
        let at_impact = between(rotation, below, above);
        let bend = bend_length(joints);
        let mut stations = Vec::with_capacity(Self::STATIONS);
        // The lean of the axis grows with the shear angle of the bar below, and falls with that of the bar above.
        let [lag_below, lag_above] = [shear[0], -shear[1]].map(bounded_angle);
        let mut add = |from: (PlanePoint, PlanePoint),
                       to: (PlanePoint, PlanePoint),
                       first: usize,
                       lag: [f64; 2]| {
            let pieces = first..=BEND_PIECES;
            stations.extend(pieces.map(|piece| {
                let t = piece as f64 / BEND_PIECES as f64;
                hermite(from, to, t).sheared(lag[0] + t * (lag[1] - lag[0]))
            }));
        };
        let bend_of = |place: PlanePoint, factor: f64, direction: PlanePoint| {
            (place.plus(factor * bend, direction), direction)
        };
        // A free end turns with the sections of its bar.
        let at_end = |is_fixed: bool, lag: f64| if is_fixed { 0.0 } else { lag };
        let (base_lag, top_lag) = (
            at_end(base_is_fixed, lag_below),
            at_end(top_is_fixed, lag_above),
        );
        add(
            (base, at_base),
            bend_of(base, 1.0, below),
            0,
            [base_lag, lag_below],
        );
        add(
            bend_of(impact, -1.0, below),
            (impact, at_impact),
            0,
            [lag_below, 0.0],
        );
        add(
            (impact, at_impact),
            bend_of(impact, 1.0, above),
            1,
            [0.0, lag_above],
        );
        add(
            bend_of(top, -1.0, above),
            (top, at_top),
            0,
            [lag_above, top_lag],
        );
        Self { stations }
    }

    /// The stations from the base to the top.
    #[must_use]
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }
}

impl Station {
    /// The same with its section behind the axis by this angle \[rad\].
    fn sheared(self, lag: f64) -> Self {
        if lag == 0.0 {
            return self;
        }
        let (sin, cos) = lag.sin_cos();
        let PlanePoint { x, z } = self.direction;
        Self {
            section: PlanePoint::new(x * cos - z * sin, z * cos + x * sin),
            ..self
        }
    }
}

/// An angle that can be drawn, whatever the numbers of the model and the magnification.
fn bounded_angle(angle: f64) -> f64 {
    const STEEPEST: f64 = 1.2;
    if angle.is_finite() {
        angle.clamp(-STEEPEST, STEEPEST)
    } else {
        0.0
    }
}

/// Length of the bends next to the joints \[m\].
fn bend_length(joints: &Joints) -> f64 {
    let below = joints.impact.plus(-1.0, joints.base).norm();
    let above = joints.top.plus(-1.0, joints.impact).norm();
    (BEND_LENGTH * below.min(above)).min(MAX_BEND)
}

/// The direction at the impact point: turned by `rotation`, but limited to the directions of the two bars, so that a
/// magnified rotation does not fold the solid.
fn between(rotation: f64, below: PlanePoint, above: PlanePoint) -> PlanePoint {
    let lean = |direction: PlanePoint| direction.x.atan2(direction.z);
    let (one, other) = (lean(below), lean(above));
    let angle = if rotation.is_finite() {
        rotation.clamp(one.min(other), one.max(other))
    } else {
        0.5 * (one + other)
    };
    let angle = angle.clamp(-FRAC_PI_2, FRAC_PI_2);
    PlanePoint::new(angle.sin(), angle.cos())
}

/// Position and direction at `t`, 0 to 1, on the cubic curve from one position and direction to another.
fn hermite(
    (from, start): (PlanePoint, PlanePoint),
    (to, end): (PlanePoint, PlanePoint),
    t: f64,
) -> Station {
    let length = to.plus(-1.0, from).norm();
    let sum = |[a, b, c, d]: [f64; 4]| {
        let places = PlanePoint::new(a * from.x + b * to.x, a * from.z + b * to.z);
        places.plus(length * c, start).plus(length * d, end)
    };
    let (square, cube) = (t * t, t * t * t);
    let slope = sum([
        6.0 * square - 6.0 * t,
        6.0 * t - 6.0 * square,
        3.0 * square - 4.0 * t + 1.0,
        3.0 * square - 2.0 * t,
    ]);
    let direction = PlanePoint::default().direction_to(slope);
    Station {
        place: sum([
            2.0 * cube - 3.0 * square + 1.0,
            3.0 * square - 2.0 * cube,
            cube - 2.0 * square + t,
            cube - square,
        ]),
        direction,
        section: direction,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::Sample;
    use crate::shape::Lengths;

    fn joints() -> Joints {
        let lengths = Lengths {
            below: 1.0,
            above: 3.0,
            top_is_free: false,
        };
        let sample = Sample {
            v1: 0.1,
            u1: 0.006,
            u2: 0.009,
            ..Sample::default()
        };
        Joints::new(lengths, &sample, 1.0)
    }

    fn close(one: PlanePoint, other: PlanePoint) -> bool {
        one.plus(-1.0, other).norm() < 1e-12
    }

    #[test]
    fn the_axis_passes_through_the_joints() {
        let joints = joints();
        let axis = BentAxis::new(&joints, 0.03, [0.0; WEBS], true, true);
        let stations = axis.stations();
        assert_eq!(stations.len(), BentAxis::STATIONS);
        assert!(close(stations[0].place, joints.base));
        assert!(close(stations[2 * BEND_PIECES + 1].place, joints.impact));
        assert!(close(stations[BentAxis::STATIONS - 1].place, joints.top));
        // The impact point has turned by beta1.
        let turned = stations[2 * BEND_PIECES + 1].direction;
        assert!((turned.x.atan2(turned.z) - 0.03).abs() < 1e-12);
    }

    #[test]
    fn fixed_ends_stay_level_and_free_ends_turn_with_their_bar() {
        let joints = joints();
        let up = PlanePoint::new(0.0, 1.0);
        let fixed = BentAxis::new(&joints, 0.0, [0.0; WEBS], true, true);
        let free = BentAxis::new(&joints, 0.0, [0.0; WEBS], false, false);
        let last = BentAxis::STATIONS - 1;
        assert!(close(fixed.stations()[0].direction, up));
        assert!(close(fixed.stations()[last].direction, up));
        let below = joints.base.direction_to(joints.impact);
        let above = joints.impact.direction_to(joints.top);
        assert!(close(free.stations()[0].direction, below));
        assert!(close(free.stations()[last].direction, above));
    }

    /// The bars are straight between the bends, and the direction changes gradually along the bends.
    #[test]
    fn bars_are_straight_and_bends_are_smooth() {
        let joints = joints();
        let stations = BentAxis::new(&joints, 0.03, [0.0; WEBS], true, true)
            .stations()
            .to_vec();
        for (first, bar) in [
            (BEND_PIECES, joints.base.direction_to(joints.impact)),
            (3 * BEND_PIECES + 1, joints.impact.direction_to(joints.top)),
        ] {
            assert!(close(stations[first].direction, bar));
            let chord = stations[first]
                .place
                .direction_to(stations[first + 1].place);
            assert!(close(chord, bar));
        }
        let kink = joints
            .base
            .direction_to(joints.impact)
            .plus(-1.0, joints.impact.direction_to(joints.top))
            .norm();
        for pair in stations.windows(2) {
            let jump = pair[0].direction.plus(-1.0, pair[1].direction).norm();
            assert!(jump < 0.7 * kink, "{jump} of {kink}");
        }
    }

    /// The sections of a bar whose web is sheared stay upright while its axis leans, and those of the other bar follow theirs.
    #[test]
    fn the_sections_of_a_sheared_bar_stay_behind() {
        let joints = joints();
        let below = joints.base.direction_to(joints.impact);
        let lean = below.x.atan2(below.z);
        let axis = BentAxis::new(&joints, 0.0, [lean, 0.0], true, true);
        let up = PlanePoint::new(0.0, 1.0);
        let bar = axis.stations()[BEND_PIECES];
        assert!(close(bar.direction, below));
        assert!(close(bar.section, up), "{bar:?}");
        assert!(close(axis.stations()[0].section, up));
        let above = axis.stations()[3 * BEND_PIECES + 1];
        assert!(close(above.section, above.direction));
        // A positive shear angle of the upper bar belongs to its lean in the other direction.
        let back = joints.impact.direction_to(joints.top);
        let lean = -back.x.atan2(back.z);
        let axis = BentAxis::new(&joints, 0.0, [0.0, lean], true, true);
        assert!(close(axis.stations()[3 * BEND_PIECES + 1].section, up));
    }

    /// The bar above the impact point of a cantilever goes on straight, as the column leans there.
    #[test]
    fn the_bar_below_a_free_top_goes_on_straight() {
        let lengths = Lengths {
            below: 1.0,
            above: 3.0,
            top_is_free: true,
        };
        let sample = Sample {
            v1: 0.1,
            u1: 0.005,
            beta1: 0.15,
            ..Sample::default()
        };
        let joints = Joints::new(lengths, &sample, 1.0);
        let axis = BentAxis::new(&joints, sample.beta1, [0.0; WEBS], true, false);
        let lean = PlanePoint::new(0.15_f64.sin(), 0.15_f64.cos());
        let stations = axis.stations();
        for station in &stations[2 * BEND_PIECES + 1..] {
            assert!(close(station.direction, lean), "{station:?}");
        }
        assert!(close(stations[BentAxis::STATIONS - 1].place, joints.top));
        assert!((joints.top.plus(-1.0, joints.impact).norm() - 3.0).abs() < 1e-12);
    }

    /// Nothing folds or becomes NaN if the numbers of the model do, or if the magnification is absurd.
    #[test]
    fn absurd_columns_can_be_drawn() {
        let lengths = Lengths {
            below: 0.1,
            above: 3.0,
            top_is_free: false,
        };
        for v1 in [0.0, 1e-300, 5.0, -5.0] {
            for rotation in [0.0, 30.0, f64::NAN, f64::INFINITY] {
                let sample = Sample {
                    v1,
                    u1: 0.1,
                    ..Sample::default()
                };
                let axis = BentAxis::new(
                    &Joints::new(lengths, &sample, 1.0),
                    rotation,
                    [rotation; WEBS],
                    true,
                    false,
                );
                for station in axis.stations() {
                    assert!(
                        (station.direction.norm() - 1.0).abs() < 1e-12,
                        "{station:?}"
                    );
                    assert!(station.place.norm() < 10.0);
                }
            }
        }
    }
}
