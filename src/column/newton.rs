//! The nonlinear equations of one stage: Newton's method with the massless rotation condensed.

use nalgebra::{Matrix4, Vector4};

use super::geometry::Displacement;

/// Bound of the iterations; two are the rule.
pub(crate) const MAX_NEWTON_ITERATIONS: u32 = 40;

/// Relative residual that needs no correction at all: round-off of forces in balance, so that a column at rest stays
/// at rest bit for bit.
const BALANCED: f64 = 1e-15;

/// Relative residual at which the iteration ends.
const CONVERGED: f64 = 1e-13;

/// Relative residual that is accepted once corrections no longer lower it: round-off of a stiff column.
const STAGNATED: f64 = 1e-10;

/// Floor of the pivot of `beta1`, relative to its elastic stiffness: with both hinges of the joint flowing its tangent
/// vanishes, and the split of their rotation is not determined.
const PIVOT_FLOOR: f64 = 1e-9;

/// A stage whose equations are solved for the increment of `U`.
pub(crate) trait Stage {
    /// What an evaluation leaves for the tangent and for the end of the step.
    type Point;

    /// The residual of the equations of motion at an increment \[N, N, N m, N\].
    fn evaluate(&self, increment: &Displacement) -> (Self::Point, Vector4<f64>);

    /// Its derivative.
    fn jacobian(&self, point: &Self::Point) -> Matrix4<f64>;

    /// Size of the terms that the residual is the sum of, row by row.
    fn scale(&self) -> Vector4<f64>;

    /// Elastic stiffness of `beta1` \[N m/rad\].
    fn rotational_scale(&self) -> f64;
}

/// A solved stage.
pub(crate) struct Solved<P> {
    pub increment: Displacement,
    pub point: P,
    pub corrections: u32,
}

/// Solves a stage from a first guess; `None` if the iteration does not converge.
pub(crate) fn solve<S: Stage>(stage: &S, guess: Displacement) -> Option<Solved<S::Point>> {
    let inverse_scale = stage.scale().map(|s| 1.0 / s);
    let mut increment = guess;
    let mut last = f64::INFINITY;
    for corrections in 0..MAX_NEWTON_ITERATIONS {
        let (point, residual) = stage.evaluate(&increment);
        let size = residual.component_mul(&inverse_scale).amax();
        if !size.is_finite() {
            return None;
        }
        let enough = if corrections == 0 { BALANCED } else { CONVERGED };
        if size <= enough || (size <= STAGNATED && size > 0.5 * last) {
            return Some(Solved {
                increment,
                point,
                corrections,
            });
        }
        last = size;
        let correction = condensed_solve(
            &stage.jacobian(&point),
            &residual,
            PIVOT_FLOOR * stage.rotational_scale(),
        )?;
        increment = increment.minus(correction);
    }
    None
}

/// Solves `jacobian * x = residual` by elimination, the unknowns that may be massless first: at a stable state every
/// pivot is positive. `None` where `u2` or the masses have lost their stiffness.
fn condensed_solve(
    jacobian: &Matrix4<f64>,
    residual: &Vector4<f64>,
    pivot_floor: f64,
) -> Option<Displacement> {
    const BETA1: usize = 2;
    const ORDER: [usize; 4] = [BETA1, 3, 1, 0];
    let (mut a, mut r) = (*jacobian, *residual);
    a[(BETA1, BETA1)] = a[(BETA1, BETA1)].max(pivot_floor);
    for (done, &pivot) in ORDER.iter().enumerate() {
        if !(a[(pivot, pivot)] > 0.0) {
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
