//! The direction in which a vehicle travels, seen from the column.

use super::joints::Joints;
use crate::column::{Sample, is_direction, is_seen_by_the_bars, share_in_plane};

/// The direction in which a vehicle travels.
///
/// The two bars bend in the plane of `x` and `z`, and count their displacements positive in the vehicle's direction of travel,
/// whichever side it comes from: a vehicle that travels towards `-x` bends them there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    direction: f64,
    /// Sine and cosine of the direction.
    turn: [f64; 2],
}

impl Default for Heading {
    fn default() -> Self {
        Self::new(0.0)
    }
}

impl Heading {
    /// Of a vehicle that travels in this direction \[rad\]; a number that is none turns nothing.
    #[must_use]
    pub fn new(direction: f64) -> Self {
        let direction = if is_direction(direction) {
            direction
        } else {
            0.0
        };
        Self {
            direction,
            turn: [libm::sin(direction), libm::cos(direction)],
        }
    }

    /// The direction of travel \[rad\], in (-pi, pi\].
    #[must_use]
    pub fn direction(self) -> f64 {
        self.direction
    }

    /// The unit vector in the direction of travel, in `x` and `y`.
    #[must_use]
    pub fn travel(self) -> [f64; 2] {
        let [sin, cos] = self.turn;
        [cos, sin]
    }

    /// The sense of `x` in which the two bars bend: 1 or -1.
    #[must_use]
    pub fn of_bars(self) -> f64 {
        1.0_f64.copysign(self.turn[1])
    }

    /// What is so far along the path of the vehicle, at right angles to it and up \[m\], in space.
    #[must_use]
    pub fn in_space(self, [along, across, up]: [f64; 3]) -> [f64; 3] {
        let [sin, cos] = self.turn;
        [cos * along - sin * across, sin * along + cos * across, up]
    }

    /// Where the front of the vehicle is on its path, which leads through the axis of the straight column \[m\]. The face of the
    /// column is `reach` in front of its axis.
    ///
    /// The front, which is plane and at right angles to the path, touches the two bars where they are drawn; a gap between both is
    /// the true one, whatever the magnification. Of a vehicle whose motion has no component in the plane of the two bars they know
    /// no gap: it is at the column.
    #[must_use]
    pub fn front(self, joints: &Joints, sample: &Sample, reach: f64) -> f64 {
        let share = share_in_plane(self.direction);
        let gap = match is_seen_by_the_bars(self.direction) {
            true => sample.gap / share,
            false => 0.0,
        };
        share * joints.impact.x - gap - reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::PlanePoint;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn joints(x: f64) -> Joints {
        Joints {
            base: PlanePoint::default(),
            impact: PlanePoint::new(x, 1.0),
            top: PlanePoint::new(0.0, 4.0),
        }
    }

    fn at_gap(gap: f64) -> Sample {
        Sample {
            gap,
            ..Sample::default()
        }
    }

    #[test]
    fn what_lies_on_the_path_lies_in_the_direction_of_travel() {
        for degrees in [0.0_f64, 10.0, 45.0, 90.0, 135.0, 180.0, -45.0, -90.0] {
            let heading = Heading::new(degrees.to_radians());
            let (sin, cos) = degrees.to_radians().sin_cos();
            let near = |found: [f64; 3], expected: [f64; 3]| {
                let far = |k: usize| (found[k] - expected[k]).abs() > 1e-15;
                assert!(!(0..3).any(far), "{degrees}: {found:?} {expected:?}");
            };
            near(
                heading.in_space([2.0, 0.0, 5.0]),
                [2.0 * cos, 2.0 * sin, 5.0],
            );
            // What is on the left of a traveller has been turned by a quarter.
            near(heading.in_space([0.0, 1.0, 0.0]), [-sin, cos, 0.0]);
            let [x, y] = heading.travel();
            near([x, y, 0.0], [cos, sin, 0.0]);
        }
        // A number that is no direction turns nothing.
        for none in [f64::NAN, 4.0, -PI] {
            assert_eq!(Heading::new(none), Heading::default());
        }
    }

    /// A vehicle from the other side bends the two bars away from itself.
    #[test]
    fn the_bars_bend_away_from_the_vehicle() {
        for (direction, sense) in [(0.0, 1.0), (1.5, 1.0), (-1.5, 1.0), (1.6, -1.0), (PI, -1.0)] {
            let heading = Heading::new(direction);
            assert_eq!(heading.of_bars(), sense);
            let [along, _] = heading.travel();
            assert!(along * sense > 0.0, "{direction}");
        }
    }

    #[test]
    fn the_front_keeps_its_distance_along_the_path() {
        let half = 0.5_f64.sqrt();
        let front = |direction: f64, gap: f64| {
            Heading::new(direction).front(&joints(0.2), &at_gap(gap), 0.1)
        };
        assert_eq!(front(0.0, 0.75), 0.2 - 0.75 - 0.1);
        // The two bars take the component of the gap, as of everything.
        let oblique = front(FRAC_PI_4, half * 0.75);
        assert!((oblique - (half * 0.2 - 0.75 - 0.1)).abs() < 1e-15);
        assert_eq!(front(PI, 0.75), 0.2 - 0.75 - 0.1);
        // They see nothing of it.
        let across = front(FRAC_PI_2, 1e-9);
        assert!((across + 0.1).abs() < 1e-15, "{across}");
    }
}
