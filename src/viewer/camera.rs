//! Where the scene is looked at from, so that the column, the whole vehicle and all labels are in the picture.

use std::f64::consts::PI;

use super::point::Point3;
use crate::shape::{Heading, PlanePoint};

/// Vertical angle of view of Rerun's camera \[rad\].
const ANGLE_OF_VIEW: f64 = 55.0 * PI / 180.0;

/// Width and height of the view of the scene in a window of 1600 times 1000 points, for which labels are placed \[points\].
pub const VIEW: [f64; 2] = [716.0, 560.0];

/// Position of the eye beside and above what it looks at, relative to the distance from it.
const OBLIQUE: [f64; 2] = [0.08, 0.09];

/// Largest sine of the angle by which a vehicle may come from the side of the viewer, whose picture then is as that of a vehicle in
/// the plane of bending. With more, it would hide the column.
const LARGEST_LEAN: f64 = 0.1;

/// Whether a vehicle comes so clearly from one side of the plane of bending that it would hide the column.
pub fn comes_from_a_side(heading: Heading) -> bool {
    heading.travel()[1].abs() > LARGEST_LEAN
}

/// The sides of a picture in space: the two bars bend towards its `x`, and its `y` leads away from the viewer, who stands where the
/// vehicle does not come from, so that it never hides the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlook {
    /// Senses of `x` and `y` in space, each 1 or -1.
    senses: [f64; 2],
    heading: Heading,
}

impl Outlook {
    /// For a vehicle that travels so.
    #[must_use]
    pub fn of(heading: Heading) -> Self {
        let [_, across] = heading.travel();
        let away = if across > LARGEST_LEAN { -1.0 } else { 1.0 };
        Self {
            senses: [heading.of_bars(), away],
            heading,
        }
    }

    /// A point of the plane of bending, shifted by `y` \[m\] away from the viewer, in space.
    #[must_use]
    pub fn in_space(self, PlanePoint { x, z }: PlanePoint, y: f64) -> Point3 {
        let [right, away] = self.senses;
        [right * x, away * y, z].map(|it| it as f32)
    }

    /// Turns `y` in space into the distance away from the viewer, beyond the plane of bending, and such a distance into `y` \[m\].
    #[must_use]
    pub fn away(self, y: f64) -> f64 {
        self.senses[1] * y
    }

    /// The unit vector in the direction of travel along `x` and `y` of the picture.
    #[must_use]
    pub fn travel(self) -> [f64; 2] {
        let [right, away] = self.senses;
        let [along, across] = self.heading.travel();
        [right * along, away * across]
    }
}

/// Eye and target \[m\], with `z` up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The eye.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub target: [f64; 3],
}

impl Camera {
    /// The camera that has everything between `left` and `right`, `bottom` and `top` in the picture, at the distance `near`
    /// in front of the plane of bending \[m\]. It looks along the flanges, from slightly above and in front of the vehicle,
    /// so that the column bends in the plane of the picture.
    #[must_use]
    pub fn around([left, right]: [f64; 2], [bottom, top]: [f64; 2], near: f64) -> Self {
        let slope = (0.5 * ANGLE_OF_VIEW).tan();
        let upright = 0.5 * (top - bottom) / slope;
        let across = 0.5 * (right - left) / (slope * VIEW[0] / VIEW[1]);
        let distance = upright.max(across) + near;
        let target = [0.5 * (left + right), 0.0, 0.5 * (bottom + top)];
        let eye = [
            target[0] + OBLIQUE[0] * distance,
            -distance,
            target[2] + OBLIQUE[1] * distance,
        ];
        Self { eye, target }
    }

    /// The same in space, for a camera that was placed in a picture with these sides.
    #[must_use]
    pub fn turned(self, Outlook { senses, .. }: Outlook) -> Self {
        let [right, away] = senses;
        let turned = |[x, y, z]: [f64; 3]| [right * x, away * y, z];
        Self {
            eye: turned(self.eye),
            target: turned(self.target),
        }
    }

    /// Size of a point of the screen in the plane `y = 0` \[m\].
    #[must_use]
    pub fn metres_per_point(&self) -> f64 {
        2.0 * self.eye[1].abs() * (0.5 * ANGLE_OF_VIEW).tan() / VIEW[1]
    }

    /// Where a point in space appears, from the upper left corner of the view \[points\].
    #[must_use]
    pub fn project(&self, place: Point3) -> [f64; 2] {
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let unit = |a: [f64; 3]| a.map(|it| it / dot(a, a).sqrt());
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let ahead = unit(minus(self.target, self.eye));
        let right = unit(cross(ahead, [0.0, 0.0, 1.0]));
        let up = cross(right, ahead);
        let seen = minus(place.map(f64::from), self.eye);
        let scale = 0.5 * VIEW[1] / ((0.5 * ANGLE_OF_VIEW).tan() * dot(seen, ahead));
        [
            0.5 * VIEW[0] + scale * dot(seen, right),
            0.5 * VIEW[1] - scale * dot(seen, up),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_in_the_picture() {
        for (across, upright) in [([-5.5, 2.0], [-0.8, 5.0]), ([-2.0, 1.5], [-1.0, 12.0])] {
            let camera = Camera::around(across, upright, 0.9);
            for x in across {
                for z in upright {
                    for y in [-0.9_f32, 0.0] {
                        let [left, down] = camera.project([x as f32, y, z as f32]);
                        // The oblique view turns the plane a little.
                        assert!((-40.0..=VIEW[0] + 40.0).contains(&left), "{left}");
                        assert!((-40.0..=VIEW[1] + 40.0).contains(&down), "{down}");
                    }
                }
            }
            let [left, down] = camera.project(camera.target.map(|it| it as f32));
            assert!((left - 0.5 * VIEW[0]).abs() < 0.01 && (down - 0.5 * VIEW[1]).abs() < 0.01);
        }
    }

    #[test]
    fn a_point_of_the_screen_has_the_size_that_the_projection_gives_it() {
        let camera = Camera::around([-4.0, 4.0], [-1.0, 5.0], 0.5);
        let size = camera.metres_per_point();
        let [target_x, _, target_z] = camera.target.map(|it| it as f32);
        let [one, _] = camera.project([target_x, 0.0, target_z]);
        let [other, _] = camera.project([target_x + 100.0 * size as f32, 0.0, target_z]);
        assert!((other - one - 100.0).abs() < 3.0, "{one} {other}");
    }
}
