//! The nonlinear equations of one stage: Newton's method with the massless rotation condensed.

use nalgebra::{Matrix4, Vector4};

use super::geometry::Displacement;
use super::model::Model;
use super::statics;

/// Bound of the iterations; two are the rule.
pub(crate) const MAX_NEWTON_ITERATIONS: u32 = 40;

/// Relative residual that needs no correction at all: round-off of forces in balance, so that a column at rest stays
/// at rest bit for bit.
const BALANCED: f64 = 1e-15;

/// Relative residual or relative correction that is accepted once corrections no longer lower the residual: round-off of
/// a stiff column.
const STAGNATED: f64 = 2e-12;

/// Floor of the pivots of `beta1` and `u2`, relative to their elastic stiffness: with both hinges of the joint flowing,
/// or with the normal force held at a corner of the yield surface, a massless unknown's tangent vanishes and its value
/// is not determined; the force that belongs to it is.
const PIVOT_FLOOR: f64 = 1e-9;

/// Bound of the line search; bisection alone narrows a correction to the floor's inverse in 20.
const MAX_LINE_SEARCH: u32 = 40;

/// A line search ends where the slope along the correction has fallen to this share.
const SLOPE_SHARE: f64 = 0.1;

/// Bound of the search for a massless unknown, for its bracket and within it: all the bits of a double.
const MAX_BISECTIONS: u32 = 60;

/// Of so many stagnations all but the last solve for `beta1` alone: a search for `u2` around it costs tens of times more.
const JOINT_BALANCES: u32 = 8;

/// How far `beta1` is looked for \[rad\].
const MAX_ROTATION: f64 = 1.0;

/// Row of `beta1`.
const BETA1: usize = 2;

/// Row of `u2`.
const U2: usize = 3;

/// Largest correction of `beta1` \[rad\], and of the displacements relative to the shorter bar: a massless unknown that
/// has lost its stiffness would leap to an equilibrium with the column turned inside out.
const MAX_CORRECTION: f64 = 0.05;

/// A stage whose equations are solved for the increment of `U`.
pub(crate) trait NonlinearSystem {
    /// What an evaluation leaves for the tangent and for the end of the step.
    type Point;

    /// The residual of the equations of motion at an increment \[N, N, N m, N\].
    fn evaluate(&self, increment: &Displacement) -> (Self::Point, Vector4<f64>);

    /// Its derivative.
    fn jacobian(&self, point: &Self::Point) -> Matrix4<f64>;

    /// Size of the terms that the residual is the sum of, row by row.
    fn scale(&self) -> Vector4<f64>;

    /// The column.
    fn model(&self) -> &Model;

    /// Relative residual at which the iteration ends.
    fn tolerance(&self) -> f64;
}

/// A solved stage.
pub(crate) struct Solved<P> {
    pub increment: Displacement,
    pub point: P,
    pub corrections: u32,
}

/// Solves a stage from a first guess; `None` if the iteration does not converge.
///
/// The residual is, but for terms of the order of the step, the gradient of a convex potential with kinks in its
/// second derivative. Where a full correction does not halve the residual, the potential is minimised along it: the
/// masses' rows would hide a massless unknown that is thrown to and fro between two kinks.
pub(crate) fn solve<S: NonlinearSystem>(
    stage: &S,
    guess: Displacement,
) -> Option<Solved<S::Point>> {
    let inverse_scale = stage.scale().map(|s| 1.0 / s);
    let size_of = |residual: &Vector4<f64>| residual.component_mul(&inverse_scale).amax();
    let mut increment = guess;
    let (mut point, mut residual) = stage.evaluate(&increment);
    let mut size = size_of(&residual);
    let mut enough = BALANCED;
    let mut stagnations = 0;
    for corrections in 0..MAX_NEWTON_ITERATIONS {
        if size <= enough {
            return Some(Solved {
                increment,
                point,
                corrections,
            });
        }
        enough = stage.tolerance();
        let correction = condensed_solve(
            &stage.jacobian(&point),
            &residual,
            statics::elastic_scale(stage.model()),
        )?;
        let correction = limited(correction, stage.model().shorter_bar());
        let full = increment.minus(correction);
        let (full_point, full_residual) = stage.evaluate(&full);
        let full_size = size_of(&full_residual);
        let stagnates = full_size > 0.5 * size;
        if stagnates && (size.min(full_size) <= STAGNATED || is_round_off(&correction, &increment))
        {
            // Round-off of a stiff column: corrections no longer help.
            return Some(if full_size < size {
                Solved {
                    increment: full,
                    point: full_point,
                    corrections: corrections + 1,
                }
            } else {
                Solved {
                    increment,
                    point,
                    corrections,
                }
            });
        }
        (increment, point, residual) = if !stagnates {
            (full, full_point, full_residual)
        } else {
            let searched = search_line(stage, increment, correction, &residual, &full_residual);
            stagnations += 1;
            let with_top = stagnations % JOINT_BALANCES == 0;
            balance_massless(stage, searched.0, with_top)
        };
        size = size_of(&residual);
        if !size.is_finite() {
            return None;
        }
    }
    None
}

/// Whether a correction is round-off of the increment.
fn is_round_off(correction: &Displacement, increment: &Displacement) -> bool {
    let moved = |u: &Displacement| u.v1.abs().max(u.u1.abs()).max(u.u2.abs());
    moved(correction) <= STAGNATED * moved(increment)
        && correction.beta1.abs() <= STAGNATED * increment.beta1.abs()
}

/// A correction scaled down to [`MAX_CORRECTION`].
fn limited(correction: Displacement, length: f64) -> Displacement {
    let Displacement { v1, u1, beta1, u2 } = correction;
    let largest = (v1.abs().max(u1.abs()).max(u2.abs()) / length).max(beta1.abs());
    if largest > MAX_CORRECTION {
        correction.times(MAX_CORRECTION / largest)
    } else {
        correction
    }
}

/// Minimises the potential along a correction: bisection on the slope `residual . direction`, which grows from below
/// zero.
fn search_line<S: NonlinearSystem>(
    stage: &S,
    from: Displacement,
    correction: Displacement,
    residual: &Vector4<f64>,
    full_residual: &Vector4<f64>,
) -> (Displacement, S::Point, Vector4<f64>) {
    let slope = |r: &Vector4<f64>| {
        -(r[0] * correction.v1
            + r[1] * correction.u1
            + r[2] * correction.beta1
            + r[3] * correction.u2)
    };
    let start = slope(residual);
    // Past the minimum at the full correction: it lies before; else the full correction is the best on offer.
    let (mut low, mut high) = (0.0, 1.0);
    let mut share = if slope(full_residual) > 0.0 { 0.5 } else { 1.0 };
    for _ in 0..MAX_LINE_SEARCH {
        let increment = from.plus(-share, correction);
        let (point, residual) = stage.evaluate(&increment);
        let here = slope(&residual);
        if share == 1.0 || here.abs() <= SLOPE_SHARE * start.abs() || high - low <= f64::EPSILON {
            return (increment, point, residual);
        }
        if here > 0.0 || here.is_nan() {
            high = share;
        } else {
            low = share;
        }
        share = 0.5 * (low + high);
    }
    let increment = from.plus(-share, correction);
    let (point, residual) = stage.evaluate(&increment);
    (increment, point, residual)
}

/// Solves the equations of the massless unknowns, the others held. `M_1b - M_1a` never falls with `beta1`, nor does the
/// force on the top with `u2` while the column carries the load: brackets find where they vanish. Where both hinges of
/// the joint flow and their moments differ, one has to unload, and no tangent tells how far that is.
fn balance_massless<S: NonlinearSystem>(
    stage: &S,
    from: Displacement,
    with_top: bool,
) -> (Displacement, S::Point, Vector4<f64>) {
    let [joint, top] = statics::elastic_scale(stage.model());
    let joint_balanced = |u: Displacement| {
        let turned = |turn: f64| Displacement {
            beta1: u.beta1 + turn,
            ..u
        };
        let unbalanced = |turn: f64| stage.evaluate(&turned(turn)).1[BETA1];
        turned(zero_near(unbalanced, joint, MAX_ROTATION))
    };
    let increment = if with_top && stage.model().top_is_massless() {
        let lowered = |fall: f64| {
            joint_balanced(Displacement {
                u2: from.u2 + fall,
                ..from
            })
        };
        let unbalanced = |fall: f64| stage.evaluate(&lowered(fall)).1[U2];
        let reach = MAX_CORRECTION * stage.model().shorter_bar();
        lowered(zero_near(unbalanced, top, reach))
    } else {
        joint_balanced(from)
    };
    let (point, residual) = stage.evaluate(&increment);
    (increment, point, residual)
}

/// Where a force that does not fall with `x` vanishes, looked for from 0 with a first step for its elastic stiffness, up
/// to `reach`; 0 if it does not vanish there. Bisection: next to a corner of the yield surface the force is a staircase.
fn zero_near(force: impl Fn(f64) -> f64, stiffness: f64, reach: f64) -> f64 {
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
fn condensed_solve(
    jacobian: &Matrix4<f64>,
    residual: &Vector4<f64>,
    elastic_scale: [f64; 2],
) -> Option<Displacement> {
    const ORDER: [usize; 4] = [BETA1, U2, 1, 0];
    let (mut a, mut r) = (*jacobian, *residual);
    for (done, &pivot) in ORDER.iter().enumerate() {
        if done < 2 {
            a[(pivot, pivot)] = a[(pivot, pivot)].max(PIVOT_FLOOR * elastic_scale[done]);
        }
        if a[(pivot, pivot)].is_nan() || a[(pivot, pivot)] <= 0.0 {
            return None;
        }
        for &row in &ORDER[done + 1..] {
            let factor = a[(row, pivot)] / a[(pivot, pivot)];
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
        x[row] = sum / a[(row, row)];
    }
    Some(Displacement {
        v1: x[0],
        u1: x[1],
        beta1: x[2],
        u2: x[3],
    })
}
