//! The solution of the equations of a part of a step where Newton's method fails: Newton's method for the unknowns that
//! carry mass, and brackets for the massless ones at each of its iterations.
//!
//! A massless unknown has nothing but the tangent to hold it, which vanishes where hinges flow and leaps at a corner of the
//! yield surface. Its force never decreases with it while the column carries the load, so a bracket finds where it is in
//! balance; if there is no such place, the column does not carry the load. What remains are the unknowns with mass. The
//! shorter the part, the more their inertia outweighs the rest, until Newton's method cannot fail for them.

use nalgebra::Vector4;

use super::geometry::Displacement;
use super::motion::{Collapse, Rejected};
use super::newton::{
    self, BETA1, MAX_CORRECTION, MAX_NEWTON_ITERATIONS, NonlinearSystem, STAGNATED, Solved, U2,
};

/// Bound of the search for a massless unknown, for its bracket and within it: all bits of a double twice, because a secant
/// may be wasted before each bisection.
const MAX_BRACKETINGS: u32 = 120;

/// Bound of the line search.
const MAX_LINE_SEARCH: u32 = 30;

/// Bound of all evaluations for one part of a step, a few milliseconds. Among the slowest of 600 000 random columns, a search
/// that succeeded took at most 2 000, and one that failed up to six million.
const MAX_EVALUATIONS: u32 = 20_000;

/// A line search ends where the slope along the correction has fallen to this share.
const SLOPE_SHARE: f64 = 0.2;

/// Share of the tolerance of the system to which a massless unknown is balanced.
const BALANCE_SHARE: f64 = 0.05;

/// Range in which `beta1` is searched \[rad\].
const MAX_ROTATION: f64 = 1.0;

/// How the equations of a part of a step are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Solver {
    /// By Newton's method, and by brackets where it fails.
    NewtonFirst,
    /// By brackets alone, which find a massless top only where it can go without a leap: for the smallest part of a step, of
    /// which Newton's method finds a solution beyond a snap-through that is still to come.
    Brackets,
}

/// Solves the equations of a part of a step.
///
/// # Errors
/// A part that is too long, or a column that does not carry its load.
pub(crate) fn solve_part<S: NonlinearSystem>(
    system: &S,
    guess: Displacement,
    solver: Solver,
    point: &mut S::Point,
) -> Result<Solved, Rejected> {
    let solved = match solver {
        Solver::NewtonFirst => newton::solve(system, guess, point),
        Solver::Brackets => None,
    };
    match solved {
        Some(solved) => Ok(solved),
        None => solve(system, guess, point).map_err(|unsolved| match unsolved {
            Unsolved::NotConverged => Rejected::TooLong,
            Unsolved::NotCarried => Rejected::Collapsed(Collapse::LoadNotCarried),
        }),
    }
}

/// Why there is no solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unsolved {
    /// The iteration of the masses does not converge, or not soon enough; that of a shorter part may.
    NotConverged,
    /// The massless top has no position nearby in which the column carries the load.
    NotCarried,
}

/// Solves a system from a first guess and leaves its last evaluation in `point`.
fn solve<S: NonlinearSystem>(
    system: &S,
    guess: Displacement,
    point: &mut S::Point,
) -> Result<Solved, Unsolved> {
    let mut search = Search {
        system,
        scale: system.scale(),
        point,
        evaluations_left: MAX_EVALUATIONS,
    };
    let (mut at, mut residual) = search.balanced(guess)?;
    let mut size = search.size(&residual);
    for iterations in 0..MAX_NEWTON_ITERATIONS {
        if size <= system.tolerance() {
            return Ok(Solved {
                increment: at,
                iterations,
            });
        }
        let correction = search.correction(&residual).ok_or(Unsolved::NotConverged)?;
        let (full, full_residual) = search.balanced(at.minus(correction))?;
        let full_size = search.size(&full_residual);
        if full_size > 0.5 * size {
            if size.min(full_size) <= STAGNATED {
                // Round-off of a stiff column: further iterations do not help.
                let increment = if full_size < size { full } else { at };
                system.evaluate(&increment, search.point);
                return Ok(Solved {
                    increment,
                    iterations: iterations + 1,
                });
            }
            (at, residual) = search.along(at, correction, &residual, (full, full_residual))?;
        } else {
            (at, residual) = (full, full_residual);
        }
        size = search.size(&residual);
        if !size.is_finite() {
            return Err(Unsolved::NotConverged);
        }
    }
    Err(Unsolved::NotConverged)
}

struct Search<'a, S: NonlinearSystem> {
    system: &'a S,
    scale: Vector4<f64>,
    point: &'a mut S::Point,
    evaluations_left: u32,
}

impl<S: NonlinearSystem> Search<'_, S> {
    /// The residual; not a number once there have been [`MAX_EVALUATIONS`].
    fn evaluate(&mut self, at: &Displacement) -> Vector4<f64> {
        if self.evaluations_left == 0 {
            return Vector4::repeat(f64::NAN);
        }
        self.evaluations_left -= 1;
        self.system.evaluate(at, self.point)
    }

    fn size(&self, residual: &Vector4<f64>) -> f64 {
        newton::size_of(residual, &self.scale.map(|s| 1.0 / s))
    }

    /// The correction of Newton's method at the last evaluation.
    fn correction(&mut self, residual: &Vector4<f64>) -> Option<Displacement> {
        let frame = &self.system.model().frame;
        let jacobian = self.system.jacobian(self.point);
        newton::condensed_solve(&jacobian, residual, frame.massless_stiffness())
            .map(|correction| newton::limited(correction, frame.shorter_bar()))
    }

    /// The minimum of the potential along a correction of the masses, with the massless unknowns in balance.
    fn along(
        &mut self,
        from: Displacement,
        correction: Displacement,
        residual: &Vector4<f64>,
        full: (Displacement, Vector4<f64>),
    ) -> Result<(Displacement, Vector4<f64>), Unsolved> {
        let slope = |r: &Vector4<f64>| newton::slope(r, &correction);
        if slope(&full.1).is_nan() || slope(&full.1) <= 0.0 {
            return self.again(full);
        }
        let start = slope(residual);
        let (mut low, mut high) = (0.0, 1.0);
        let mut best = full;
        for _ in 0..MAX_LINE_SEARCH {
            let share = 0.5 * (low + high);
            best = self.balanced(from.plus(-share, correction))?;
            let here = slope(&best.1);
            if here.abs() <= SLOPE_SHARE * start.abs() {
                break;
            }
            if here > 0.0 || here.is_nan() {
                high = share;
            } else {
                low = share;
            }
        }
        self.again(best)
    }

    /// Evaluates a place that is known once more, so that the tangent is taken there.
    fn again(
        &mut self,
        (at, _): (Displacement, Vector4<f64>),
    ) -> Result<(Displacement, Vector4<f64>), Unsolved> {
        Ok((at, self.evaluate(&at)))
    }

    /// The massless unknowns in balance, the others held, and the residual there.
    fn balanced(&mut self, from: Displacement) -> Result<(Displacement, Vector4<f64>), Unsolved> {
        let model = self.system.model();
        let at = if model.top_is_massless() {
            let [_, stiffness] = model.frame.massless_stiffness();
            let enough = BALANCE_SHARE * self.system.tolerance() * self.scale[U2];
            let reach = MAX_CORRECTION * model.frame.shorter_bar();
            let mut turned = 0.0;
            let fallen = |fall: f64, turned: f64| Displacement {
                u2: from.u2 + fall,
                beta1: from.beta1 + turned,
                ..from
            };
            let force = |fall: f64| {
                let joint = self.joint_balanced(fallen(fall, turned));
                // The next balance of the joint starts from this one.
                turned = joint.beta1 - from.beta1;
                self.evaluate(&joint)[U2]
            };
            let fall = root(force, stiffness, reach, enough);
            if self.evaluations_left == 0 {
                return Err(Unsolved::NotConverged);
            }
            let fall = fall.ok_or(Unsolved::NotCarried)?;
            let start = fallen(fall, turned);
            self.joint_balanced(start)
        } else {
            self.joint_balanced(from)
        };
        Ok((at, self.evaluate(&at)))
    }

    /// `beta1` in balance; its moment saturates on both sides, so that there is always a place.
    fn joint_balanced(&mut self, from: Displacement) -> Displacement {
        let [stiffness, _] = self.system.model().frame.massless_stiffness();
        let enough = BALANCE_SHARE * self.system.tolerance() * self.scale[BETA1];
        let turned = |turn: f64| Displacement {
            beta1: from.beta1 + turn,
            ..from
        };
        let moment = |turn: f64| self.evaluate(&turned(turn))[BETA1];
        turned(root(moment, stiffness, MAX_ROTATION, enough).unwrap_or(0.0))
    }
}

/// Where a force that does not decrease with `x` falls to `enough`, searched from 0 with a first step for its elastic
/// stiffness, up to `reach`; `None` if it keeps its sign up to there. Secants that halve the bracket in two evaluations, and
/// bisections, because next to a corner of the yield surface the force is a staircase.
pub(crate) fn root(
    mut force: impl FnMut(f64) -> f64,
    stiffness: f64,
    reach: f64,
    enough: f64,
) -> Option<f64> {
    let start = force(0.0);
    if start.abs() <= enough {
        return Some(0.0);
    }
    let (mut near, mut near_force) = (0.0, start);
    let mut far = (-start / stiffness).clamp(-reach, reach);
    if far == 0.0 || far.is_nan() {
        return None;
    }
    let mut far_force = force(far);
    while far_force * start > 0.0 {
        if far.abs() >= reach {
            return None;
        }
        (near, near_force) = (far, far_force);
        far = (2.0 * far).clamp(-reach, reach);
        far_force = force(far);
    }
    let mut bisect = false;
    for _ in 0..MAX_BRACKETINGS {
        if far_force.abs() <= enough {
            return Some(far);
        }
        let width = (far - near).abs();
        let secant = near - near_force * (far - near) / (far_force - near_force);
        let inside = (secant - near) * (secant - far) < 0.0;
        let middle = if bisect || !inside {
            0.5 * (near + far)
        } else {
            secant
        };
        if middle == near || middle == far {
            break;
        }
        let here = force(middle);
        if here.is_nan() {
            return None;
        }
        if here.abs() <= enough {
            return Some(middle);
        }
        if here * start > 0.0 {
            (near, near_force) = (middle, here);
        } else {
            (far, far_force) = (middle, here);
        }
        bisect = (far - near).abs() > 0.5 * width;
    }
    // The last place that is known to lie on either side of the balance.
    Some(if near_force.abs() < far_force.abs() {
        near
    } else {
        far
    })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use nalgebra::Matrix4;

    use super::*;
    use crate::model::Model;
    use crate::properties::PLAIN_COLUMN;

    /// Forces of the massless unknowns that leap and vanish nowhere, and one of the mass that no correction lowers.
    struct Unsolvable {
        model: Model,
        evaluations: Cell<u32>,
    }

    impl NonlinearSystem for Unsolvable {
        type Point = ();

        fn evaluate(&self, at: &Displacement, (): &mut ()) -> Vector4<f64> {
            self.evaluations.set(self.evaluations.get() + 1);
            let leap = |x: f64| if x > 1e-3 { 1.0 } else { -1.0 };
            Vector4::new(leap(at.v1), 0.0, leap(at.beta1), leap(at.u2))
        }

        fn jacobian(&self, (): &mut ()) -> Matrix4<f64> {
            Matrix4::identity()
        }

        fn scale(&self) -> Vector4<f64> {
            Vector4::repeat(1.0)
        }

        fn model(&self) -> &Model {
            &self.model
        }

        fn tolerance(&self) -> f64 {
            1e-11
        }
    }

    /// With a massless top on a bar of 91 mm, 51 m/s and steps of 146 microseconds, one step of the midpoint rule searched in
    /// six million evaluations, which took 1.9 s, for what only shorter parts could solve.
    #[test]
    fn a_search_that_cannot_succeed_ends_soon() {
        let system = Unsolvable {
            model: Model::new(&PLAIN_COLUMN).expect("a column"),
            evaluations: Cell::new(0),
        };
        let unsolved = solve(&system, Displacement::default(), &mut ()).err();
        assert_eq!(unsolved, Some(Unsolved::NotConverged));
        assert_eq!(system.evaluations.get(), MAX_EVALUATIONS);
    }
}
