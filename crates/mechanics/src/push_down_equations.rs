//! The equations of one increment of a push-down: static equilibrium with plastic flow, under a prescribed force or along
//! a path that may lead through limit points.

use std::cell::Cell;

use nalgebra::{Matrix4, RowVector4, Vector4};

use super::bar::{BarForces, BarStrain, PerBar, PlasticFlow};
use super::bracketing;
use super::frame;
use super::geometry::{Chord, ChordGradient, Displacement};
use super::model::Model;
use super::strength::BarStress;

/// Bound of the Newton iterations of one increment; two to four are usual.
const MAX_ITERATIONS: u32 = 30;

/// Residual at which the iteration ends, relative to `N^p` and `M^p`.
const TOLERANCE: f64 = 1e-11;

/// Residual that is accepted where further iterations do not lower it: round-off of a stiff column.
const STAGNATED: f64 = 1e-9;

/// Floor of the stiffness of the joint, relative to its elastic stiffness.
const PIVOT_FLOOR: f64 = 1e-9;

/// Largest correction of `beta1` \[rad\], and of the displacements relative to the shorter bar.
const MAX_CORRECTION: f64 = 0.05;

/// Number of halvings of a correction that does not lower the residual.
const MAX_HALVED_CORRECTIONS: u32 = 4;

/// Bound of the searches for `beta1` alone in one increment.
const MAX_JOINT_BALANCES: u32 = 6;

/// Share of [`TOLERANCE`] to which the joint is balanced.
const BALANCE_SHARE: f64 = 0.05;

/// Largest motion in an increment, relative to its size; at most 3 are usual, and other equilibria were found from 1000 on.
const MAX_DETOUR: f64 = 50.0;

/// Row of `beta1`.
const BETA1: usize = 2;

/// Range in which `beta1` is searched \[rad\].
pub(crate) const MAX_ROTATION: f64 = 1.0;

/// The fourth equation, beside the equilibrium of `v1`, `u1` and `beta1`.
#[derive(Clone, Copy)]
pub(crate) enum LastRow {
    /// The force at the top has this value \[N\].
    Force(f64),
    /// The increment has this size.
    Path(PathStep),
}

/// Size of an increment: `u2` relative to the shortening at the squash load, plus `v1` relative to half of its value.
#[derive(Clone, Copy)]
pub(crate) struct PathStep {
    from: Displacement,
    per_v1: f64,
    per_u2: f64,
    size: f64,
}

impl PathStep {
    pub fn new(model: &Model, sign: f64, from: Displacement, size: f64) -> Self {
        let frame = &model.frame;
        let flexibility = 1.0 / frame.below.axial + 1.0 / frame.above.axial;
        let squashed = model.properties.resistance_axial * flexibility;
        let height = frame.below.length + frame.above.length;
        // A column that its plastic strains hold straight without load has a bow of nearly 0.
        let bow = from.v1.abs().max(1e-4 * height);
        Self {
            from,
            per_v1: 2.0 * sign / bow,
            per_u2: 1.0 / squashed,
            size,
        }
    }

    /// Whether these displacements may be the end of the increment. Both parts of its size stay of its order: `v1` grows along
    /// the path, and `u2` falls by at most half as much on this scale. What is much further away is another equilibrium.
    pub fn reaches(&self, u: &Displacement) -> bool {
        let moved = (self.per_v1 * (u.v1 - self.from.v1)).abs()
            + (self.per_u2 * (u.u2 - self.from.u2)).abs();
        moved <= MAX_DETOUR * self.size
    }

    fn missing(&self, u: &Displacement) -> f64 {
        self.per_v1 * (u.v1 - self.from.v1) + self.per_u2 * (u.u2 - self.from.u2) - self.size
    }
}

/// Equilibrium of the column in one increment.
pub(crate) struct Equations<'a> {
    pub model: &'a Model,
    /// Plastic strains and bow at its start.
    pub offset: &'a PerBar<PlasticFlow>,
    /// Whether no hinge flows.
    pub elastic: bool,
    pub last: LastRow,
    /// Counts the evaluations.
    pub evaluations: &'a Cell<u32>,
}

/// An equilibrium.
pub(crate) struct Solved {
    pub displacement: Displacement,
    pub stress: PerBar<BarStress>,
    pub force: f64,
}

impl Solved {
    pub fn flows(&self) -> bool {
        let flow = |stress: &BarStress| stress.returned.flow != PlasticFlow::default();
        flow(&self.stress.below) || flow(&self.stress.above)
    }

    pub fn forces(&self) -> PerBar<BarForces> {
        PerBar {
            below: self.stress.below.returned.forces,
            above: self.stress.above.returned.forces,
        }
    }
}

/// What an evaluation leaves behind for the tangent.
#[derive(Default)]
struct Point {
    chords: PerBar<Chord>,
    gradients: PerBar<ChordGradient>,
    stress: PerBar<BarStress>,
    force: f64,
}

impl Equations<'_> {
    pub fn solve(&self, guess: Displacement, near: &PerBar<BarForces>) -> Option<Solved> {
        let mut point = Point::default();
        point.stress.below.expect(near.below.normal);
        point.stress.above.expect(near.above.normal);
        let mut u = guess;
        let mut residual = self.evaluate(&u, &mut point);
        let mut size = self.size_of(&residual);
        let mut balances = 0;
        for _ in 0..MAX_ITERATIONS {
            if size <= TOLERANCE {
                return Some(self.solved(u, &point));
            }
            if balances < MAX_JOINT_BALANCES && self.is_joint_loose(&point) {
                balances += 1;
                u = self.balance_joint(u, &mut point);
                residual = self.evaluate(&u, &mut point);
                size = self.size_of(&residual);
            }
            let (from, before) = (u, size);
            let correction = self.correction(&residual, &mut point)?;
            let mut share = 1.0;
            for _ in 0..MAX_HALVED_CORRECTIONS {
                u = from.plus(-share, correction);
                residual = self.evaluate(&u, &mut point);
                size = self.size_of(&residual);
                if size <= 0.5 * before {
                    break;
                }
                share *= 0.5;
            }
            if size > 0.5 * before {
                if before.min(size) <= STAGNATED {
                    if before < size {
                        u = from;
                        self.evaluate(&u, &mut point);
                    }
                    return Some(self.solved(u, &point));
                }
                balances += 1;
                if balances > MAX_JOINT_BALANCES {
                    return None;
                }
                u = self.balance_joint(from.minus(correction), &mut point);
                residual = self.evaluate(&u, &mut point);
                size = self.size_of(&residual);
            }
            if !size.is_finite() {
                return None;
            }
        }
        None
    }

    fn solved(&self, displacement: Displacement, point: &Point) -> Solved {
        Solved {
            displacement,
            stress: point.stress,
            force: point.force,
        }
    }

    /// The residual: forces on `v1` and `u1` \[N\], the moment on `beta1` \[N m\], and the last row as a force \[N\].
    fn evaluate(&self, u: &Displacement, point: &mut Point) -> Vector4<f64> {
        self.evaluations.set(self.evaluations.get() + 1);
        let frame = &self.model.frame;
        point.chords = frame.chords(u);
        point.gradients = frame::gradients(&point.chords);
        let total = frame::strains(&point.chords, &frame::angles(&point.chords), u.beta1);
        for (bar, stress, total, offset) in [
            (
                &frame.below,
                &mut point.stress.below,
                total.below,
                &self.offset.below,
            ),
            (
                &frame.above,
                &mut point.stress.above,
                total.above,
                &self.offset.above,
            ),
        ] {
            let strain: BarStrain = total.minus(offset);
            if self.elastic {
                stress.returned.forces = bar.elastic(&strain);
            } else {
                stress.update(bar, strain);
            }
        }
        let forces = PerBar {
            below: point.stress.below.returned.forces,
            above: point.stress.above.returned.forces,
        };
        let mut residual = frame.internal_forces(&point.gradients, &forces, 0.0);
        point.force = residual[3];
        residual[3] = match &self.last {
            LastRow::Force(target) => point.force - target,
            LastRow::Path(step) => step.missing(u) * self.model.properties.resistance_axial,
        };
        residual
    }

    fn size_of(&self, residual: &Vector4<f64>) -> f64 {
        let p = &self.model.properties;
        let force = 1.0 / p.resistance_axial;
        let scale = [force, force, 1.0 / p.resistance_moment, force];
        let mut size = 0.0;
        for row in 0..4 {
            let relative = (residual[row] * scale[row]).abs();
            if relative > size || relative.is_nan() {
                size = relative;
            }
        }
        size
    }

    /// Whether both hinges of the joint flow at the last evaluation: one of them has to unload, and no tangent tells how far that
    /// is.
    fn is_joint_loose(&self, point: &Point) -> bool {
        let flows = |stress: &BarStress| stress.returned.flow.has_flowed(0);
        !self.elastic && flows(&point.stress.below) && flows(&point.stress.above)
    }

    /// The Newton correction at the last evaluation, limited in size: `beta1` is eliminated with a floor of its pivot, the
    /// rest with a search for pivots, because the path leads through states that are not stable.
    fn correction(&self, residual: &Vector4<f64>, point: &mut Point) -> Option<Displacement> {
        let frame = &self.model.frame;
        let tangents = if self.elastic {
            PerBar {
                below: frame.below.elastic_tangent(),
                above: frame.above.elastic_tangent(),
            }
        } else {
            PerBar {
                below: point.stress.below.linearise(&frame.below),
                above: point.stress.above.linearise(&frame.above),
            }
        };
        let forces = PerBar {
            below: point.stress.below.returned.forces,
            above: point.stress.above.returned.forces,
        };
        let mut jacobian = frame.stiffness(&point.gradients, &point.chords, &forces, &tangents);
        match &self.last {
            LastRow::Force(_) => jacobian[(3, 3)] -= frame.top_spring_stiffness,
            LastRow::Path(step) => {
                let scale = self.model.properties.resistance_axial;
                jacobian.set_row(
                    3,
                    &RowVector4::new(step.per_v1 * scale, 0.0, 0.0, step.per_u2 * scale),
                );
            }
        }
        let [joint, _] = frame.massless_stiffness();
        let floor = PIVOT_FLOOR * joint;
        jacobian[(BETA1, BETA1)] = jacobian[(BETA1, BETA1)].max(floor);
        let mut residual = *residual;
        if self.is_joint_loose(point) {
            // The joint is balanced for a range of `beta1`: it is held while the others are corrected.
            jacobian.set_row(BETA1, &RowVector4::new(0.0, 0.0, joint, 0.0));
            residual[BETA1] = 0.0;
        }
        let correction = solve_condensed(jacobian, residual)?;
        Some(limited(correction, frame.shorter_bar()))
    }

    /// `beta1` in equilibrium with the other displacements held: `M_1b - M_1a` never decreases with it.
    fn balance_joint(&self, from: Displacement, point: &mut Point) -> Displacement {
        let turned = |turn: f64| Displacement {
            beta1: from.beta1 + turn,
            ..from
        };
        let [joint, _] = self.model.frame.massless_stiffness();
        let unbalanced = |turn: f64| self.evaluate(&turned(turn), point)[BETA1];
        let enough = BALANCE_SHARE * TOLERANCE * self.model.properties.resistance_moment;
        turned(bracketing::root(unbalanced, joint, MAX_ROTATION, enough).unwrap_or(0.0))
    }
}

/// Solves `a x = r`: the row of `beta1` first, then the largest pivot of each column.
fn solve_condensed(mut a: Matrix4<f64>, mut r: Vector4<f64>) -> Option<Displacement> {
    a.swap_rows(0, BETA1);
    r.swap_rows(0, BETA1);
    a.swap_columns(0, BETA1);
    for column in 0..4 {
        if column > 0 {
            let mut pivot = column;
            for row in column + 1..4 {
                if a[(row, column)].abs() > a[(pivot, column)].abs() {
                    pivot = row;
                }
            }
            a.swap_rows(column, pivot);
            r.swap_rows(column, pivot);
        }
        let value = a[(column, column)];
        if value == 0.0 || !value.is_finite() {
            return None;
        }
        for row in column + 1..4 {
            let factor = a[(row, column)] / value;
            for k in column..4 {
                a[(row, k)] -= factor * a[(column, k)];
            }
            r[row] -= factor * r[column];
        }
    }
    let mut x = [0.0; 4];
    for row in (0..4).rev() {
        let mut sum = r[row];
        for k in row + 1..4 {
            sum -= a[(row, k)] * x[k];
        }
        x[row] = sum / a[(row, row)];
    }
    let [beta1, u1, v1, u2] = x;
    Some(Displacement { v1, u1, beta1, u2 })
}

fn limited(correction: Displacement, length: f64) -> Displacement {
    let Displacement { v1, u1, beta1, u2 } = correction;
    let largest = (v1.abs().max(u1.abs()).max(u2.abs()) / length).max(beta1.abs());
    if largest > MAX_CORRECTION {
        correction.times(MAX_CORRECTION / largest)
    } else {
        correction
    }
}
