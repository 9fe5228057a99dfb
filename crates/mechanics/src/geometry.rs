//! From displacements to deformations, and the gradients that map forces back (Eqs 1-10).
//!
//! A bar is described by its chord, the vector `r = (x, v)` from one end to the other: `x` along the undeformed
//! column, `v` across it. Bar a has `x = L_a - u1`, bar b has `x = L_b + u1 - u2`, both have `v = v1`.

use serde::{Deserialize, Serialize};

/// Generalised displacements `U` (Eq 1).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Displacement {
    /// `v1`: transverse displacement of the impact point \[m\].
    pub v1: f64,
    /// `u1`: axial displacement of the impact point, down \[m\].
    pub u1: f64,
    /// `beta1`: rotation of the impact point \[rad\].
    pub beta1: f64,
    /// `u2`: axial displacement of the top, down \[m\].
    pub u2: f64,
}

impl Displacement {
    /// `self + factor * other`.
    pub(crate) fn plus(self, factor: f64, other: Self) -> Self {
        Self {
            v1: self.v1 + factor * other.v1,
            u1: self.u1 + factor * other.u1,
            beta1: self.beta1 + factor * other.beta1,
            u2: self.u2 + factor * other.u2,
        }
    }

    /// `self - other`.
    pub(crate) fn minus(self, other: Self) -> Self {
        self.plus(-1.0, other)
    }

    /// `factor * self`.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self::default().plus(factor, self)
    }
}

/// The chord of a deformed bar.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Chord {
    /// Extent along the undeformed column \[m\].
    pub x: f64,
    /// Extent across it \[m\].
    pub v: f64,
    /// Length \[m\].
    pub length: f64,
    /// Elongation, `delta_a` or `delta_b` (Eqs 7-8) \[m\].
    pub elongation: f64,
}

/// Derivatives of a chord's length and angle with respect to `x` and `v`, from which Eq 10 assembles `B`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ChordGradient {
    pub length_x: f64,
    pub length_v: f64,
    pub angle_x: f64,
    pub angle_v: f64,
}

impl Chord {
    /// The chord of a bar of undeformed length `length` \[m\] whose ends have come closer by `shortening` \[m\]
    /// along the column and lie `v` \[m\] apart across it.
    ///
    /// The elongation is computed without the cancellation of `sqrt(x² + v²) - L`.
    pub fn new(length: f64, shortening: f64, v: f64) -> Self {
        let x = length - shortening;
        let deformed = (x * x + v * v).sqrt();
        let elongation = (v * v + shortening * (shortening - 2.0 * length)) / (deformed + length);
        Self {
            x,
            v,
            length: deformed,
            elongation,
        }
    }

    /// Angle to the undeformed column, `theta_3` or `theta_2` (Eqs 3-4) \[rad\].
    pub fn angle(&self) -> f64 {
        if self.x > 0.0 {
            libm::atan(self.v / self.x)
        } else {
            libm::atan2(self.v, self.x)
        }
    }

    /// The gradient at this chord (Eq 10).
    pub fn gradient(&self) -> ChordGradient {
        let per_length = 1.0 / self.length;
        let (cos, sin) = (self.x * per_length, self.v * per_length);
        ChordGradient {
            length_x: cos,
            length_v: sin,
            angle_x: -sin * per_length,
            angle_v: cos * per_length,
        }
    }

    /// The discrete gradient from `self` to `next`, and the angle \[rad\] by which the chord turns: the product of the
    /// gradient with the difference of the two chords is the difference of their lengths and angles exactly.
    ///
    /// `Delta l = 2 r_m . Delta r / (l_n + l_{n+1})` and
    /// `Delta theta = (Delta theta / sin Delta theta) (r_m x Delta r) / (l_n l_{n+1})`, with `r_m` the mean chord, for
    /// turns of less than a right angle. `sin Delta theta` is the cross product of the chords over the product of their
    /// lengths, so that a small turn needs no inverse trigonometric function.
    // Inlined, measured: a step of the conserving scheme takes 4 % less.
    #[inline(always)]
    pub fn discrete_gradient(&self, next: &Self) -> (ChordGradient, f64) {
        let (x, v) = (0.5 * (self.x + next.x), 0.5 * (self.v + next.v));
        let per_length = 2.0 / (self.length + next.length);
        let per_area = 1.0 / (self.length * next.length);
        let sine = (self.x * next.v - self.v * next.x) * per_area;
        let ratio = angle_over_sine(sine);
        let turns_back = self.x * next.x + self.v * next.v <= 0.0;
        let turn = if turns_back {
            next.angle() - self.angle()
        } else {
            sine * ratio
        };
        let per_area = ratio * per_area;
        let gradient = ChordGradient {
            length_x: x * per_length,
            length_v: v * per_length,
            angle_x: -v * per_area,
            angle_v: x * per_area,
        };
        (gradient, turn)
    }

    /// The angle \[rad\] by which the chord turns where its extents change by `dx` and `dv` \[m\], to first order.
    pub fn turn_for(&self, dx: f64, dv: f64) -> f64 {
        (self.x * dv - self.v * dx) / (self.length * self.length)
    }

    /// Whether the turn from `self` to `next` is less than a right angle and its sine less than `sine`.
    pub fn turns_less(&self, next: &Self, sine: f64) -> bool {
        let area = self.length * next.length;
        let across = self.x * next.v - self.v * next.x;
        let along = self.x * next.x + self.v * next.v;
        along > 0.0 && across.abs() < sine * area
    }

    /// Second derivatives `(xx, xv, vv)` of `axial * length + bending * angle`: the geometric stiffness of a bar
    /// with normal force `axial` \[N\] and sum of end moments `bending` \[N m\].
    pub fn hessian(&self, axial: f64, bending: f64) -> [f64; 3] {
        let per_length = 1.0 / self.length;
        let (cos, sin) = (self.x * per_length, self.v * per_length);
        let stretch = axial * per_length;
        let turn = bending * per_length * per_length;
        [
            stretch * sin * sin + 2.0 * turn * sin * cos,
            -stretch * sin * cos + turn * (sin * sin - cos * cos),
            stretch * cos * cos - 2.0 * turn * sin * cos,
        ]
    }
}

/// `asin(s) / s`, accurate at 0.
fn angle_over_sine(sine: f64) -> f64 {
    let square = sine * sine;
    if square < 1e-4 {
        // Taylor series; the first omitted term is below 4e-18.
        1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * (15.0 / 336.0)))
    } else {
        libm::asin(sine) / sine
    }
}

#[cfg(test)]
#[allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]
mod tests {
    use super::*;

    #[test]
    fn elongation_and_angle_are_those_of_the_paper() {
        let (length, u, v) = (3.0_f64, 0.02, 0.31);
        let chord = Chord::new(length, u, v);
        assert!(
            (chord.elongation - ((v * v + (length - u).powi(2)).sqrt() - length)).abs() < 1e-15
        );
        assert!((chord.angle() - (v / (length - u)).atan()).abs() < 1e-16);
    }

    #[test]
    fn a_tiny_elongation_keeps_its_digits() {
        let v = 1e-9;
        let chord = Chord::new(2.0, 0.0, v);
        assert!((chord.elongation / (v * v / 4.0) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn gradient_and_hessian_agree_with_differences() {
        let at = |x: f64, v: f64| Chord::new(2.0, 2.0 - x, v);
        let (x, v, h) = (1.9, 0.4, 1e-6);
        let gradient = at(x, v).gradient();
        let difference = |f: fn(&Chord) -> f64| {
            [
                (f(&at(x + h, v)) - f(&at(x - h, v))) / (2.0 * h),
                (f(&at(x, v + h)) - f(&at(x, v - h))) / (2.0 * h),
            ]
        };
        let [length_x, length_v] = difference(|c| c.elongation);
        let [angle_x, angle_v] = difference(Chord::angle);
        for (exact, numeric) in [
            (gradient.length_x, length_x),
            (gradient.length_v, length_v),
            (gradient.angle_x, angle_x),
            (gradient.angle_v, angle_v),
        ] {
            assert!((exact - numeric).abs() < 1e-9, "{exact} {numeric}");
        }
        let (axial, bending) = (3.0, -0.7);
        let force = |x: f64, v: f64| {
            let g = at(x, v).gradient();
            [
                axial * g.length_x + bending * g.angle_x,
                axial * g.length_v + bending * g.angle_v,
            ]
        };
        let [xx, xv, vv] = at(x, v).hessian(axial, bending);
        let (fx, fv) = (force(x + h, v), force(x, v + h));
        let (bx, bv) = (force(x - h, v), force(x, v - h));
        for (exact, numeric) in [
            (xx, (fx[0] - bx[0]) / (2.0 * h)),
            (xv, (fx[1] - bx[1]) / (2.0 * h)),
            (vv, (fv[1] - bv[1]) / (2.0 * h)),
        ] {
            assert!((exact - numeric).abs() < 1e-8, "{exact} {numeric}");
        }
    }

    #[test]
    fn discrete_gradient_reproduces_the_difference_of_any_two_chords() {
        for (x0, v0, x1, v1) in [
            (2.0, 0.0, 1.99, 0.3),
            (1.5, -0.4, 1.2, 0.9),
            (2.0, 0.1, 2.0, 0.1 + 1e-7),
            (0.3, 1.0, 0.31, 0.95),
        ] {
            let (a, b) = (Chord::new(2.0, 2.0 - x0, v0), Chord::new(2.0, 2.0 - x1, v1));
            let (g, turn) = a.discrete_gradient(&b);
            assert!((turn - (b.angle() - a.angle())).abs() < 1e-15);
            let (dx, dv) = (b.x - a.x, b.v - a.v);
            assert!(
                (g.length_x * dx + g.length_v * dv - (b.elongation - a.elongation)).abs() < 1e-15
            );
            assert!((g.angle_x * dx + g.angle_v * dv - (b.angle() - a.angle())).abs() < 1e-15);
        }
    }
}
