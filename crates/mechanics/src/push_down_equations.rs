//! The equations of one increment of a push-down: static equilibrium with plastic flow, under a prescribed force or along
//! a path that may lead through limit points.

use std::cell::Cell;

use nalgebra::{Matrix4, RowVector4, Vector4};

use super::backbone::StaticStrength;
use super::bar::{Bar, BarForces, BarStrain, PerBar, PlasticFlow};
use super::frame;
use super::geometry::{Chord, ChordGradient, Displacement};
use super::model::Model;
use super::shear::SliderStrength;
use super::strength::BarStress;

/// Bound of the Newton iterations of one increment; two to four are usual.
const MAX_ITERATIONS: u32 = 30;

/// Residual at which the iteration ends, relative to `N^p` and `M^p`. It does not add up: every increment begins from the stress
/// that the last one returned to the yield surface.
const TOLERANCE: f64 = 1e-9;

/// By how much the sum of the yield function of a held hinge may exceed 1: the residual of its equilibrium.
const HELD_TOLERANCE: f64 = 1e-8;

/// By how much stronger a hinge is that is held: more than any stress of an increment.
const HELD_STRENGTH: f64 = 4.0;

/// Floor of the stiffness of the joint, relative to its elastic stiffness.
const PIVOT_FLOOR: f64 = 1e-9;

/// Largest correction of `beta1` \[rad\], and of the displacements relative to the shorter bar.
const MAX_CORRECTION: f64 = 0.05;

/// Number of halvings of a correction that does not lower the residual.
const MAX_HALVED_CORRECTIONS: u32 = 4;

/// Largest motion in an increment, relative to its size; at most 3 are usual, and other equilibria were found from 1000 on.
const MAX_DETOUR: f64 = 50.0;

/// Row of `beta1`.
const BETA1: usize = 2;

/// Range in which `beta1` is searched \[rad\].
pub(crate) const MAX_ROTATION: f64 = 1.0;

/// Plastic rotation that is expected of a hinge at least, over which its strength grows along a secant \[rad\]: that of the
/// first increment in which it flows.
const FIRST_ROTATION: f64 = 1e-4;

/// How the hinges have rotated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HingeCourse {
    /// Accumulated plastic rotations \[rad\].
    accumulated: PerBar<[f64; 2]>,
    /// By how much they grew over the last increment, relative to its size.
    rate: PerBar<[f64; 2]>,
}

impl HingeCourse {
    pub fn new(accumulated: PerBar<[f64; 2]>) -> Self {
        Self {
            accumulated,
            rate: PerBar::default(),
        }
    }

    /// Adds the flow of an increment of size `size`.
    pub fn add(&mut self, below: &PlasticFlow, above: &PlasticFlow, size: f64) {
        for (accumulated, rate, flow) in [
            (&mut self.accumulated.below, &mut self.rate.below, below),
            (&mut self.accumulated.above, &mut self.rate.above, above),
        ] {
            for k in 0..2 {
                let rotation = flow.rotation[k].abs();
                accumulated[k] += rotation;
                rate[k] = rotation / size;
            }
        }
    }

    /// The strength of the hinges over an increment of size `size` that begins with the forces `forces`.
    pub fn strength(
        &self,
        model: &Model,
        size: f64,
        forces: &PerBar<BarForces>,
    ) -> PerBar<StaticStrength> {
        let expected = |rate: [f64; 2]| rate.map(|rate| (size * rate).max(FIRST_ROTATION));
        let expected = PerBar {
            below: expected(self.rate.below),
            above: expected(self.rate.above),
        };
        let law = model.strength.as_ref();
        law.and_then(|law| law.at_rest(&self.accumulated, &expected, forces))
            .unwrap_or_default()
    }
}

/// The fourth equation, beside the equilibrium of `v1`, `u1` and `beta1`.
#[derive(Clone, Copy)]
pub(crate) enum LastRow {
    /// The force at the top has this value \[N\].
    Force(f64),
    /// The increment has this size.
    Path(PathStep),
}

/// Size of an increment: `u2` relative to the shortening at the squash load, plus `v1` relative to half of its value where that
/// is prescribed, too.
#[derive(Clone, Copy)]
pub(crate) struct PathStep {
    from: Displacement,
    scale_v1: f64,
    per_v1: f64,
    per_u2: f64,
    size: f64,
}

/// What is prescribed along a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Control {
    /// `u2` and `v1`, which leads through a snap-back.
    Both,
    /// `u2` alone, where the path leads back from the side to which the column bends: a hinge at an end yields.
    Shortening,
}

impl Control {
    /// The one to try where this one fails.
    pub fn other(self) -> Self {
        match self {
            Self::Both => Self::Shortening,
            Self::Shortening => Self::Both,
        }
    }
}

impl PathStep {
    pub fn new(model: &Model, control: Control, sign: f64, from: Displacement, size: f64) -> Self {
        let frame = &model.frame;
        let flexibility = 1.0 / frame.below.axial + 1.0 / frame.above.axial;
        let squashed = model.properties.resistance_axial * flexibility;
        let height = frame.below.length + frame.above.length;
        // A column that its plastic strains hold straight without load has a bow of nearly 0.
        let bow = from.v1.abs().max(1e-4 * height);
        let scale_v1 = 2.0 * sign / bow;
        Self {
            from,
            scale_v1,
            per_v1: match control {
                Control::Both => scale_v1,
                Control::Shortening => 0.0,
            },
            per_u2: 1.0 / squashed,
            size,
        }
    }

    /// Whether these displacements may be the end of the increment: `v1` and `u2` change by the order of its size. What is much
    /// further away is another equilibrium.
    pub fn reaches(&self, u: &Displacement) -> bool {
        let moved = (self.scale_v1 * (u.v1 - self.from.v1)).abs()
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
    /// Of the hinges.
    pub strength: &'a PerBar<StaticStrength>,
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

/// Which hinges may flow in an increment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flowing {
    /// Hinges that are held while the others may flow, per bar: at the impact point, at the other end.
    held: PerBar<[bool; 2]>,
    /// Whether both hinges of the joint may flow.
    both_of_joint: bool,
}

impl Flowing {
    /// Any hinge, but only one of the joint.
    pub const ANY: Self = Self::held(false, false, false, false);

    /// In what order they are tried.
    const ALL: [Self; 15] = [
        Self::ANY,
        Self::held(false, false, true, false),
        Self::held(true, false, false, false),
        Self {
            both_of_joint: true,
            ..Self::ANY
        },
        Self::held(false, true, true, false),
        Self::held(true, true, false, false),
        Self::held(false, false, true, true),
        Self::held(true, false, false, true),
        Self::held(true, false, true, false),
        Self::held(true, true, true, false),
        Self::held(true, false, true, true),
        Self::held(false, true, true, true),
        Self::held(true, true, false, true),
        Self::held(false, true, false, false),
        Self::held(false, false, false, true),
    ];

    const fn held(hinge_1a: bool, hinge_3: bool, hinge_1b: bool, hinge_2: bool) -> Self {
        Self {
            held: PerBar {
                below: [hinge_1a, hinge_3],
                above: [hinge_1b, hinge_2],
            },
            both_of_joint: false,
        }
    }

    /// Whether the held hinges bear their stress without flowing, and the web that of its bar, which is weaker than it is
    /// beside two held hinges.
    fn is_admissible(
        &self,
        model: &Model,
        solved: &Solved,
        strength: &PerBar<StaticStrength>,
    ) -> bool {
        let bears = |bar: &Bar, stress: &BarStress, held: [bool; 2], own: &StaticStrength| {
            let forces = &stress.returned.forces;
            (0..2).all(|k| {
                let (moment, normal) = own.factors[k].reduced(forces.moment[k], forces.normal);
                !held[k] || bar.surface.sum(moment, normal) <= 1.0 + HELD_TOLERANCE
            }) && (held == [false; 2]
                || bar.web_utilisation(forces, &SliderStrength::UNDAMAGED, own.weakest())
                    <= 1.0 + HELD_TOLERANCE)
        };
        let (frame, held, stress) = (&model.frame, &self.held, &solved.stress);
        bears(&frame.below, &stress.below, held.below, &strength.below)
            && bears(&frame.above, &stress.above, held.above, &strength.above)
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
    /// Solves them from a first guess and the forces `near` the solution.
    ///
    /// Newton's method finds by itself which hinges flow unless several of them begin or end to flow in one increment. Then it is
    /// prescribed which ones may, and the first solution is taken in which no other one has to. Of the joint usually one hinge
    /// flows: both bear the same moment, but not quite the same normal force. Only where their normal forces are equal, as in
    /// a symmetric column, both do.
    ///
    /// `last` is what led to the last solution; returned is what led to this one.
    pub fn solve(
        &self,
        guess: Displacement,
        near: &PerBar<BarForces>,
        last: Flowing,
    ) -> Option<(Solved, Flowing)> {
        // Held hinges were an event, after which the others flow by themselves; both of the joint go on together.
        let first = if last.both_of_joint {
            last
        } else {
            Flowing::ANY
        };
        let count = if self.elastic { 0 } else { Flowing::ALL.len() };
        let others = Flowing::ALL
            .into_iter()
            .filter(|&it| it != first)
            .take(count);
        std::iter::once(first).chain(others).find_map(|flowing| {
            let solved = self.iterate(guess, near, &flowing)?;
            flowing
                .is_admissible(self.model, &solved, self.strength)
                .then_some((solved, flowing))
        })
    }

    /// Newton's method, given up where other hinges flow than may.
    fn iterate(
        &self,
        guess: Displacement,
        near: &PerBar<BarForces>,
        flowing: &Flowing,
    ) -> Option<Solved> {
        let mut point = Point::default();
        point.stress.below.expect(near.below.normal);
        point.stress.above.expect(near.above.normal);
        let held = &flowing.held;
        let strength = |own: &StaticStrength, held| own.with_held(held, HELD_STRENGTH);
        let below = strength(&self.strength.below, held.below);
        let above = strength(&self.strength.above, held.above);
        point.stress.below.set_strength(below);
        point.stress.above.set_strength(above);
        let mut u = guess;
        let mut residual = self.evaluate(&u, &mut point);
        let mut size = self.size_of(&residual);
        for _ in 0..MAX_ITERATIONS {
            if size <= TOLERANCE {
                return Some(self.solved(u, &point));
            }
            if !flowing.both_of_joint && self.is_joint_loose(&point) {
                return None;
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
            if size.is_nan() || size > 0.5 * before {
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

    /// Whether both hinges of the joint flow at the last evaluation.
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
        let correction = solve_condensed(jacobian, *residual)?;
        Some(limited(correction, frame.shorter_bar()))
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
