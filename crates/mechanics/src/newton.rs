//! The nonlinear equations of a part of a step or of a static equilibrium: Newton's method with the massless rotation
//! condensed.

use nalgebra::{Matrix4, Vector4};

use super::geometry::Displacement;
use super::model::Model;
use super::modes::ELIMINATION_ORDER;

/// Bound of the iterations; one or two are usual.
pub(crate) const MAX_NEWTON_ITERATIONS: u32 = 40;

/// Relative residual that needs no iteration at all: round-off of forces in balance, so that a column at rest stays
/// at rest bit for bit.
const BALANCED: f64 = 1e-15;

/// Relative residual or relative increment that is accepted once iterations no longer lower the residual: round-off of
/// a stiff column.
pub(crate) const STAGNATED: f64 = 2e-12;

/// Round-off of the angle by which the chord of a bar turns, relative to that angle: a few units in the last place.
const ROUND_OFF_OF_CHORD: f64 = 8.0 * f64::EPSILON;

/// Floor of the pivots of `beta1` and `u2`, relative to their elastic stiffness. With both hinges of the joint flowing,
/// or with the normal force held at a corner of the yield surface, the tangent of a massless unknown vanishes: its value
/// is not determined, but the force that belongs to it is.
const PIVOT_FLOOR: f64 = 1e-9;

/// Bound of the line search; bisection alone narrows a correction to the inverse of the floor in 20 iterations.
const MAX_LINE_SEARCH: u32 = 40;

/// A line search ends where the slope along the correction has fallen to this share.
const SLOPE_SHARE: f64 = 0.1;

/// Bound of the search for `beta1`, for its bracket and within it: all bits of a double.
const MAX_BISECTIONS: u32 = 60;

/// Of so many stagnations the last ends the iteration: brackets find the solution sooner.
const MAX_STAGNATIONS: u32 = 6;

/// Range in which `beta1` is searched \[rad\].
const MAX_ROTATION: f64 = 1.0;

/// Row of `beta1`.
pub(crate) const BETA1: usize = 2;

/// Row of `u2`.
pub(crate) const U2: usize = 3;

/// Largest correction of `beta1` \[rad\], and of the displacements relative to the shorter bar: a massless unknown that
/// has lost its stiffness would leap to an equilibrium with the column turned inside out.
pub(crate) const MAX_CORRECTION: f64 = 0.05;

/// Equations that are solved for the increment of `U`.
pub(crate) trait NonlinearSystem {
    /// What an evaluation leaves behind for the tangent and for the end of the step.
    type Point: Default;

    /// Moves `point` from the last evaluation to the increment `to` by a small correction, which is subtracted, along the last
    /// derivative. `false` if that is not certain; `point` must then be evaluated.
    fn follow(
        &self,
        _to: &Displacement,
        _correction: &Displacement,
        _point: &mut Self::Point,
    ) -> bool {
        false
    }

    /// The residual of the equations of motion at an increment \[N, N, N m, N\]; overwrites `point`.
    fn evaluate(&self, increment: &Displacement, point: &mut Self::Point) -> Vector4<f64>;

    /// Its derivative at the last evaluation.
    fn jacobian(&self, point: &mut Self::Point) -> Matrix4<f64>;

    /// Size of the terms of which the residual is the sum, row by row.
    fn scale(&self) -> Vector4<f64>;

    /// The column.
    fn model(&self) -> &Model;

    /// Relative residual at which the iteration ends.
    fn tolerance(&self) -> f64;
}

/// A solution.
pub(crate) struct Solved {
    pub increment: Displacement,
    pub iterations: u32,
}

/// Solves a system from a first guess and leaves its last evaluation in `point`; `None` if the iteration does not
/// converge.
///
/// But for terms of the order of the step, the residual is the gradient of a convex potential with kinks in its
/// second derivative. Where a full correction does not halve the residual, the potential is minimised along it: the
/// rows of the masses would hide a massless unknown that is thrown to and fro between two kinks.
pub(crate) fn solve<S: NonlinearSystem>(
    system: &S,
    guess: Displacement,
    point: &mut S::Point,
) -> Option<Solved> {
    let inverse_scale = system.scale().map(|s| 1.0 / s);
    let size_of = |residual: &Vector4<f64>| size_of(residual, &inverse_scale);
    let mut increment = guess;
    let mut residual = system.evaluate(&increment, point);
    let mut size = size_of(&residual);
    let mut enough = BALANCED;
    let mut stagnations = 0;
    for iterations in 0..MAX_NEWTON_ITERATIONS {
        if size <= enough {
            return Some(Solved {
                increment,
                iterations,
            });
        }
        enough = system.tolerance();
        let frame = &system.model().frame;
        let correction = condensed_solve(
            &system.jacobian(point),
            &residual,
            frame.massless_stiffness(),
        )?;
        let correction = limited(correction, frame.shorter_bar());
        let full = increment.minus(correction);
        if size <= system.model().linear_residual && system.follow(&full, &correction, point) {
            return Some(Solved {
                increment: full,
                iterations: iterations + 1,
            });
        }
        let full_residual = system.evaluate(&full, point);
        let full_size = size_of(&full_residual);
        let stagnates = full_size > 0.5 * size;
        if stagnates
            && (size.min(full_size) <= STAGNATED
                || is_round_off(&correction, &increment, frame.shorter_bar()))
        {
            // Round-off of a stiff column: further iterations do not help.
            if full_size < size {
                increment = full;
            } else {
                system.evaluate(&increment, point);
            }
            return Some(Solved {
                increment,
                iterations: iterations + 1,
            });
        }
        (increment, residual) = if stagnates {
            let searched = search_line(
                system,
                increment,
                correction,
                &residual,
                &full_residual,
                point,
            );
            stagnations += 1;
            if stagnations == MAX_STAGNATIONS {
                return None;
            }
            balance_joint(system, searched, point)
        } else {
            (full, full_residual)
        };
        size = size_of(&residual);
        if !size.is_finite() {
            return None;
        }
    }
    None
}

/// Largest entry of a residual, relative to the scale of its row.
#[inline(always)]
pub(crate) fn size_of(residual: &Vector4<f64>, inverse_scale: &Vector4<f64>) -> f64 {
    let mut size = 0.0;
    for row in 0..4 {
        let relative = (residual[row] * inverse_scale[row]).abs();
        if relative > size || relative.is_nan() {
            size = relative;
        }
    }
    size
}

/// Derivative of the potential along a correction, which is subtracted: below zero at its start.
pub(crate) fn slope(residual: &Vector4<f64>, correction: &Displacement) -> f64 {
    -(residual[0] * correction.v1
        + residual[1] * correction.u1
        + residual[2] * correction.beta1
        + residual[3] * correction.u2)
}

/// Whether a correction is round-off of the increment. A hinge turns by `beta1` and by the chord of its bar, whose round-off may
/// be far more than that of a small `beta1`.
fn is_round_off(correction: &Displacement, increment: &Displacement, length: f64) -> bool {
    let moved = |u: &Displacement| u.v1.abs().max(u.u1.abs()).max(u.u2.abs());
    let chord = ROUND_OFF_OF_CHORD * moved(increment) / length;
    moved(correction) <= STAGNATED * moved(increment)
        && correction.beta1.abs() <= chord.max(STAGNATED * increment.beta1.abs())
}

/// A correction scaled down to [`MAX_CORRECTION`].
pub(crate) fn limited(correction: Displacement, length: f64) -> Displacement {
    let Displacement { v1, u1, beta1, u2 } = correction;
    let largest = (v1.abs().max(u1.abs()).max(u2.abs()) / length).max(beta1.abs());
    if largest > MAX_CORRECTION {
        correction.times(MAX_CORRECTION / largest)
    } else {
        correction
    }
}

/// The increment that minimises the potential along a correction: bisection on the slope `residual . direction`, which
/// grows from below zero.
fn search_line<S: NonlinearSystem>(
    system: &S,
    from: Displacement,
    correction: Displacement,
    residual: &Vector4<f64>,
    full_residual: &Vector4<f64>,
    point: &mut S::Point,
) -> Displacement {
    let slope = |residual: &Vector4<f64>| slope(residual, &correction);
    let full = slope(full_residual);
    if full.is_nan() || full <= 0.0 {
        // The minimum lies beyond the full correction, which is then the best on offer.
        return from.minus(correction);
    }
    let start = slope(residual);
    let (mut low, mut high) = (0.0, 1.0);
    let mut share = 0.5;
    for _ in 0..MAX_LINE_SEARCH {
        let here = slope(&system.evaluate(&from.plus(-share, correction), point));
        if here.abs() <= SLOPE_SHARE * start.abs() || high - low <= f64::EPSILON {
            break;
        }
        if here > 0.0 || here.is_nan() {
            high = share;
        } else {
            low = share;
        }
        share = 0.5 * (low + high);
    }
    from.plus(-share, correction)
}

/// Solves the equation of `beta1` with the other unknowns held, and returns the increment and its residual. `M_1b - M_1a`
/// never decreases with `beta1`: brackets find where it vanishes. Where both hinges of the joint flow and their moments
/// differ, one has to unload, and no tangent tells how far that is.
fn balance_joint<S: NonlinearSystem>(
    system: &S,
    from: Displacement,
    point: &mut S::Point,
) -> (Displacement, Vector4<f64>) {
    let [stiffness, _] = system.model().frame.massless_stiffness();
    let turned = |turn: f64| Displacement {
        beta1: from.beta1 + turn,
        ..from
    };
    let unbalanced = |turn: f64| system.evaluate(&turned(turn), point)[BETA1];
    let increment = turned(zero_near(unbalanced, stiffness, MAX_ROTATION));
    (increment, system.evaluate(&increment, point))
}

/// Where a force that does not decrease with `x` vanishes, searched from 0 with a first step for its elastic stiffness, up
/// to `reach`; 0 if it does not vanish there. Bisection, because next to a corner of the yield surface the force is a
/// staircase.
pub(crate) fn zero_near(mut force: impl FnMut(f64) -> f64, stiffness: f64, reach: f64) -> f64 {
    let start = force(0.0);
    let (mut near, mut far) = (0.0, -start / stiffness);
    if far == 0.0 || !far.is_finite() {
        return 0.0;
    }
    let mut doublings = 0;
    while force(far) * start > 0.0 {
        near = far;
        far *= 2.0;
        doublings += 1;
        if far.abs() > reach || doublings > MAX_BISECTIONS {
            return 0.0;
        }
    }
    for _ in 0..MAX_BISECTIONS {
        let middle = 0.5 * (near + far);
        let here = force(middle);
        if here == 0.0 || middle == near || middle == far {
            return middle;
        }
        if here * start > 0.0 {
            near = middle;
        } else {
            far = middle;
        }
    }
    0.5 * (near + far)
}

/// Solves `jacobian * x = residual` by elimination, the unknowns that may be massless first: at a stable state every
/// pivot is positive. `None` where `u2` or the masses have lost their stiffness.
// Inlined, measured: a step takes 5 % less.
#[inline(always)]
pub(crate) fn condensed_solve(
    jacobian: &Matrix4<f64>,
    residual: &Vector4<f64>,
    massless_stiffness: [f64; 2],
) -> Option<Displacement> {
    const ORDER: [usize; 4] = ELIMINATION_ORDER;
    let (mut a, mut r) = (*jacobian, *residual);
    let mut inverse = [0.0; 4];
    for (done, &pivot) in ORDER.iter().enumerate() {
        let mut value = a[(pivot, pivot)];
        if done < 2 {
            value = value.max(PIVOT_FLOOR * massless_stiffness[done]);
        }
        if value.is_nan() || value <= 0.0 {
            return None;
        }
        inverse[pivot] = 1.0 / value;
        for &row in &ORDER[done + 1..] {
            let factor = a[(row, pivot)] * inverse[pivot];
            for &column in &ORDER[done + 1..] {
                a[(row, column)] -= factor * a[(pivot, column)];
            }
            r[row] -= factor * r[pivot];
        }
    }
    let mut x = [0.0; 4];
    for (done, &row) in ORDER.iter().enumerate().rev() {
        let mut sum = r[row];
        for &column in &ORDER[done + 1..] {
            sum -= a[(row, column)] * x[column];
        }
        x[row] = sum * inverse[row];
    }
    let [v1, u1, beta1, u2] = x;
    Some(Displacement { v1, u1, beta1, u2 })
}
