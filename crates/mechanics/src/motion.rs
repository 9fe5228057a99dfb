//! What both schemes share: inertia, damping and load of a part of a step, the failure of a step, and the shape that a
//! column must keep.

use nalgebra::{Matrix4, Vector4};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::chain::{ChainPart, ChainPoint};
use super::contact::Coupling;
use super::frame::Frame;
use super::geometry::Displacement;
use super::model::Model;
use super::modes::Damping;
use super::state::{State, Velocity};

/// A bar whose extent along the column has shrunk to this fraction of its length has lost its shape.
pub const MIN_EXTENT: f64 = 0.01;

/// A bar compressed or stretched beyond these fractions of its length has lost its shape.
pub const LENGTH_RANGE: [f64; 2] = [0.2, 5.0];

/// A top that has descended by this fraction of the column's height does so without bound.
pub const MAX_SHORTENING: f64 = 0.5;

/// A remainder of a step below this fraction of it is round-off.
pub(crate) const NEGLIGIBLE_PART: f64 = 1e-9;

/// Most by which a bar may turn in one part of a step, as the sine of the angle.
pub(crate) const MAX_TURN: f64 = 0.3;

/// Floor of the size of forces, relative to `N^p`.
const FORCE_FLOOR: f64 = 1e-9;

/// Floor of the size of moments, relative to `M^p`.
const MOMENT_FLOOR: f64 = 1e-6;

/// Share of stiffness times displacement that counts as a force. Its round-off is 1e-16 of it, and a residual of 1e-13 of
/// the forces is converged.
const ROUND_OFF_SHARE: f64 = 1e-2;

/// How a column loses its shape or its equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Collapse {
    /// A bar lies across the column and snaps through.
    SnapThrough,
    /// A bar has lost its length.
    BarLength,
    /// The top descends without bound.
    Shortening,
    /// The massless top has no position in which the column carries the load.
    LoadNotCarried,
}

/// Why a step failed; the state is then as it was before the step, or after its last accepted part.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum StepError {
    /// The column has collapsed: a result.
    #[error("the column has collapsed: {0:?}")]
    Collapsed(Collapse),
    /// The equations did not converge, however small the part of the step.
    #[error(
        "step {step} did not converge at {part_secs:.3e} s, the smallest part tried; \
         please report the parameters, which should have been rejected"
    )]
    NotConverged {
        /// Number of the step.
        step: u64,
        /// Length of the smallest part tried \[s\].
        part_secs: f64,
    },
}

/// Why a part of a step is rejected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rejected {
    /// Its equations did not converge, or a bar turned so far that it leapt to another equilibrium.
    TooLong,
    /// The column lost its shape.
    Collapsed(Collapse),
}

/// Inertia, damping, load and contact in one part of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion<'a> {
    /// `1/h` \[1/s\].
    per_sec: f64,
    secs: f64,
    velocity: Vector4<f64>,
    /// `2 m / h` of every displacement \[kg/s\].
    inertia: Vector4<f64>,
    damping: Option<&'a Damping>,
    /// A deformable vehicle.
    chain: Option<&'a ChainPart<'a>>,
    /// Forces besides those of the column: the load and the force of contact \[N\].
    applied: Vector4<f64>,
    scale: Vector4<f64>,
}

impl<'a> Motion<'a> {
    /// The motion over `secs` of a column that starts from `from`, with the share `coupling` of a rigid impactor or with the
    /// deformable vehicle `chain`.
    // Inlined, as `residual`, measured: a step takes 3 % less.
    #[inline(always)]
    pub fn new(
        model: &'a Model,
        from: &State,
        coupling: Coupling,
        chain: Option<&'a ChainPart<'a>>,
        secs: f64,
    ) -> Self {
        let p = &model.properties;
        // The rate of a massless u2 is not part of the state and must not enter.
        let top = if model.top_is_massless() {
            0.0
        } else {
            from.velocity.u2
        };
        let velocity = Vector4::new(from.velocity.v1, from.velocity.u1, 0.0, top);
        let per_sec = 1.0 / secs;
        let mut masses = Vector4::from(model.masses());
        masses[0] += coupling.mass;
        let inertia = masses * (2.0 * per_sec);
        let [force, moment] = force_scale(model, from);
        let momentum = inertia.component_mul(&velocity.abs());
        let crush = chain.map_or(0.0, |chain| chain.force_scale(velocity[0]));
        Self {
            per_sec,
            secs,
            velocity,
            inertia,
            damping: model.damping.as_ref(),
            chain,
            applied: Vector4::new(coupling.force, 0.0, 0.0, p.top_load),
            scale: Vector4::new(
                momentum[0] + force + (coupling.force.abs() + crush),
                momentum[1] + force,
                moment,
                momentum[3] + force,
            ),
        }
    }

    /// `M Delta v / h + C v_m - f` for an increment, `v_m` its mean rate; the vehicle's share is solved into `contact`.
    #[inline(always)]
    pub fn residual(&self, increment: &Displacement, contact: &mut ChainPoint) -> Vector4<f64> {
        let rate = self.mean_rate(increment);
        let mut undamped = (rate - self.velocity).component_mul(&self.inertia) - self.applied;
        if let Some(chain) = self.chain {
            chain.solve(increment.v1, contact);
            undamped[0] -= contact.force();
        }
        match self.damping {
            Some(damping) => undamped + damping_forces(damping, &rate),
            None => undamped,
        }
    }

    /// Adds the derivative of [`Motion::residual`], whose last evaluation left `contact`, to `jacobian`.
    pub fn add_jacobian(&self, jacobian: &mut Matrix4<f64>, contact: &ChainPoint) {
        if self.chain.is_some() {
            jacobian[(0, 0)] += contact.stiffness();
        }
        for row in 0..4 {
            jacobian[(row, row)] += self.inertia[row] * self.per_sec;
        }
        if let Some(damping) = self.damping {
            jacobian[(0, 0)] += damping.transverse * self.per_sec;
            for (row, coefficients) in [1, 3].into_iter().zip(damping.axial) {
                jacobian[(row, 1)] += coefficients[0] * self.per_sec;
                jacobian[(row, 3)] += coefficients[1] * self.per_sec;
            }
        }
    }

    /// Whether a deformable vehicle takes part.
    pub fn has_vehicle(&self) -> bool {
        self.chain.is_some()
    }

    /// Size of the terms of which the residual is the sum.
    pub fn scale(&self) -> Vector4<f64> {
        self.scale
    }

    /// Velocity at the end of an increment: that at the start mirrored about the mean; a massless top gets the mean.
    pub fn end_velocity(&self, model: &Model, increment: &Displacement) -> Velocity {
        let rate = self.mean_rate(increment);
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
        self.damping.map_or(0.0, |damping| {
            let rate = self.mean_rate(increment);
            rate.dot(&damping_forces(damping, &rate)) * self.secs
        })
    }

    fn mean_rate(&self, increment: &Displacement) -> Vector4<f64> {
        let Displacement { v1, u1, beta1, u2 } = *increment;
        Vector4::new(v1, u1, beta1, u2) * self.per_sec
    }
}

fn damping_forces(damping: &Damping, rate: &Vector4<f64>) -> Vector4<f64> {
    let axial = damping.axial.map(|c| c[0] * rate[1] + c[1] * rate[3]);
    Vector4::new(damping.transverse * rate[0], axial[0], 0.0, axial[1])
}

/// Size of the forces \[N\] and moments \[N m\] whose balance is sought: those at work, the stress that corresponds to the
/// round-off of the displacements, and a floor for a column that has no forces yet.
fn force_scale(model: &Model, from: &State) -> [f64; 2] {
    let p = &model.properties;
    let Displacement { v1, u1, beta1, u2 } = from.displacement;
    let moved = v1.abs() + u1.abs() + u2.abs();
    let mut force = p.top_load + FORCE_FLOOR * p.resistance_axial;
    let mut moment = MOMENT_FLOOR * p.resistance_moment;
    for (bar, forces) in [
        (&model.frame.below, &from.forces.below),
        (&model.frame.above, &from.forces.above),
    ] {
        let bending = forces.moment[0].abs() + forces.moment[1].abs();
        let turned = v1.abs() / bar.length + beta1.abs();
        moment += bending + ROUND_OFF_SHARE * bar.rotational[0][0] * turned;
        force += forces.normal.abs() + bending / bar.length + ROUND_OFF_SHARE * bar.axial * moved;
    }
    [force, moment]
}

/// Checks where a part of a step has led.
///
/// # Errors
/// A bar that turned further than [`MAX_TURN`], or a column that has lost its shape.
pub(crate) fn check_part(
    model: &Model,
    from: &Displacement,
    to: &Displacement,
) -> Result<(), Rejected> {
    if !turns_little(model, from, to) {
        return Err(Rejected::TooLong);
    }
    match collapse_of(model, to) {
        Some(collapse) => Err(Rejected::Collapsed(collapse)),
        None => Ok(()),
    }
}

/// Whether both bars turn by less than [`MAX_TURN`].
fn turns_little(model: &Model, from: &Displacement, to: &Displacement) -> bool {
    let moved = to.minus(*from);
    let [min_length, _] = LENGTH_RANGE;
    if moved.v1.abs() + moved.u1.abs() + moved.u2.abs()
        < MAX_TURN * min_length * model.frame.shorter_bar()
    {
        // No bar that has kept its shape is short enough to turn far by this.
        return true;
    }
    let (before, after) = (model.frame.chords(from), model.frame.chords(to));
    before.below.turns_less(&after.below, MAX_TURN)
        && before.above.turns_less(&after.above, MAX_TURN)
}

/// Whether a state has lost its shape.
pub(crate) fn collapse_of(model: &Model, u: &Displacement) -> Option<Collapse> {
    let Frame { below, above, .. } = &model.frame;
    let across = model.frame.across_above(u.v1);
    for (bar, shortening, v) in [(below, u.u1, u.v1), (above, u.u2 - u.u1, across)] {
        let x = bar.length - shortening;
        if x.is_nan() || x < MIN_EXTENT * bar.length {
            return Some(Collapse::SnapThrough);
        }
        let [min, max] = LENGTH_RANGE.map(|fraction| fraction * bar.length);
        if !(min * min..=max * max).contains(&(x * x + v * v)) {
            return Some(Collapse::BarLength);
        }
    }
    let height = below.length + above.length;
    (u.u2 > MAX_SHORTENING * height).then_some(Collapse::Shortening)
}
