//! What both schemes share: inertia, damping and load of a step, its failure, and the shape that a column must keep.

use nalgebra::{Matrix4, Vector4};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::geometry::Displacement;
use super::model::Model;
use super::state::{State, Velocity};

/// A bar whose extent along the column has shrunk to this fraction of its length has lost its shape.
pub const MIN_EXTENT: f64 = 0.01;

/// A bar compressed or stretched beyond these fractions of its length has lost its shape.
pub const LENGTH_RANGE: [f64; 2] = [0.2, 5.0];

/// A top that has come down by this fraction of the column's height does so without bound.
pub const MAX_SHORTENING: f64 = 0.5;

/// Floor of the size of forces, relative to `N^p`.
const FORCE_FLOOR: f64 = 1e-9;

/// Floor of the size of moments, relative to `M^p`.
const MOMENT_FLOOR: f64 = 1e-6;

/// Share of (stiffness x displacement) that counts as a force: its round-off is 1e-16 of it, a residual 1e-13 of the
/// forces is converged.
const ROUND_OFF_SHARE: f64 = 1e-2;

/// How a column loses its shape or its equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Collapse {
    /// A bar lies across the column: it snaps through.
    SnapThrough,
    /// A bar has lost its length.
    BarLength,
    /// The top comes down without bound.
    Shortening,
    /// No position of the massless top carries the load.
    LoadNotCarried,
}

/// Why a step could not be made; the state is then as it was before the step, or after its last good part.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StepError {
    /// The column has collapsed: a result.
    #[error("the column has collapsed: {0:?}")]
    Collapsed(Collapse),
    /// The equations of a part of the step did not converge however small the part was made.
    #[error(
        "step {step} did not converge at {part_secs:.3e} s, the smallest part tried; \
         please report the parameters, they should have been refused"
    )]
    NotConverged {
        /// Number of the step.
        step: u64,
        /// Length of the smallest part tried \[s\].
        part_secs: f64,
    },
}

/// Inertia, damping, load and push of one stage.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub secs: f64,
    velocity: Vector4<f64>,
    /// `2 m / h` of every displacement \[kg/s\].
    inertia: Vector4<f64>,
    /// `None` for a column without damping.
    damping: Option<Matrix4<f64>>,
    /// Forces besides those of the column: the load, the push of contact \[N\].
    applied: Vector4<f64>,
    scale: Vector4<f64>,
}

impl Motion {
    /// The motion of a column that starts from `from`, with `added_mass` \[kg\] moving along at the impact point
    /// and a constant force `push` \[N\] on it, over `secs`.
    pub fn new(model: &Model, from: &State, added_mass: f64, push: f64, secs: f64) -> Self {
        let velocity = &from.velocity;
        let p = &model.properties;
        let masses = Vector4::new(
            model.impact_point_mass + added_mass,
            model.impact_point_mass,
            0.0,
            p.top_mass,
        );
        // The rate of a massless u2 is no state: it must not enter.
        let top = if model.top_is_massless() {
            0.0
        } else {
            velocity.u2
        };
        let velocity = Vector4::new(velocity.v1, velocity.u1, 0.0, top);
        let inertia = masses * (2.0 / secs);
        let mut scale = inertia.component_mul(&velocity.abs());
        let [force, moment] = force_scale(model, from);
        for row in [0, 1, 3] {
            scale[row] += force;
        }
        scale[0] += push.abs();
        scale[2] = moment;
        Self {
            secs,
            velocity,
            inertia,
            damping: (p.damping_ratio > 0.0).then(|| damping(model)),
            applied: Vector4::new(push, 0.0, 0.0, p.top_load),
            scale,
        }
    }

    /// `M Delta v / h + C v_m - f` for an increment, `v_m` its mean rate.
    pub fn residual(&self, increment: &Displacement) -> Vector4<f64> {
        let rate = mean_rate(increment, self.secs);
        let inertial = (rate - self.velocity).component_mul(&self.inertia);
        let undamped = inertial - self.applied;
        match &self.damping {
            Some(damping) => undamped + damping * rate,
            None => undamped,
        }
    }

    /// Derivative of [`Motion::residual`].
    pub fn jacobian(&self) -> Matrix4<f64> {
        let mut j = self
            .damping
            .map_or_else(Matrix4::zeros, |damping| damping / self.secs);
        for row in 0..4 {
            j[(row, row)] += self.inertia[row] / self.secs;
        }
        j
    }

    /// Size of the terms that the residual is the sum of.
    pub fn scale(&self) -> Vector4<f64> {
        self.scale
    }

    /// Velocity at the end of an increment: that at the start mirrored about the mean; a massless top gets the mean.
    pub fn end_velocity(&self, model: &Model, increment: &Displacement) -> Velocity {
        let rate = mean_rate(increment, self.secs);
        let end = rate * 2.0 - self.velocity;
        Velocity {
            v1: end[0],
            u1: end[1],
            u2: if model.top_is_massless() {
                rate[3]
            } else {
                end[3]
            },
        }
    }

    /// Work of the damping over an increment \[J\], >= 0.
    pub fn damping_work(&self, increment: &Displacement) -> f64 {
        let rate = mean_rate(increment, self.secs);
        self.damping
            .map_or(0.0, |damping| rate.dot(&(damping * rate)) * self.secs)
    }
}

/// Size of the forces \[N\] and moments \[N m\] whose balance is sought: those at work, what the round-off of the
/// displacements is worth in stress, and a floor for a column that has no forces yet.
fn force_scale(model: &Model, from: &State) -> [f64; 2] {
    let p = &model.properties;
    let Displacement { v1, u1, beta1, u2 } = from.displacement;
    let moved = v1.abs() + u1.abs() + u2.abs();
    let mut force = p.top_load + FORCE_FLOOR * p.resistance_axial;
    let mut moment = MOMENT_FLOOR * p.resistance_moment;
    for (bar, forces) in [
        (&model.below, &from.forces.below),
        (&model.above, &from.forces.above),
    ] {
        let bending = forces.moment[0].abs() + forces.moment[1].abs();
        let turned = v1.abs() / bar.length + beta1.abs();
        moment += bending + ROUND_OFF_SHARE * bar.rotational[0][0] * turned;
        force += forces.normal.abs() + bending / bar.length + ROUND_OFF_SHARE * bar.axial * moved;
    }
    [force, moment]
}

fn mean_rate(increment: &Displacement, secs: f64) -> Vector4<f64> {
    Vector4::new(increment.v1, increment.u1, increment.beta1, increment.u2) / secs
}

fn damping(model: &Model) -> Matrix4<f64> {
    let axial = &model.damping_axial;
    let mut c = Matrix4::zeros();
    c[(0, 0)] = model.damping_transverse;
    c[(1, 1)] = axial[(0, 0)];
    c[(1, 3)] = axial[(0, 1)];
    c[(3, 1)] = axial[(1, 0)];
    c[(3, 3)] = axial[(1, 1)];
    c
}

/// Whether a state has lost its shape.
pub(crate) fn collapse_of(model: &Model, u: &Displacement) -> Option<Collapse> {
    for (bar, shortening) in [(&model.below, u.u1), (&model.above, u.u2 - u.u1)] {
        let x = bar.length - shortening;
        if x.is_nan() || x < MIN_EXTENT * bar.length {
            return Some(Collapse::SnapThrough);
        }
        let relative = (x * x + u.v1 * u.v1) / (bar.length * bar.length);
        let [least, most] = LENGTH_RANGE;
        if !(least * least..=most * most).contains(&relative) {
            return Some(Collapse::BarLength);
        }
    }
    let height = model.below.length + model.above.length;
    (u.u2 > MAX_SHORTENING * height).then_some(Collapse::Shortening)
}
