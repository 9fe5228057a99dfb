//! Equilibrium without inertia: of the whole column with its plastic deformation frozen, and of its massless
//! unknowns.

use nalgebra::{Matrix4, Vector4};

use super::assembly::{self, PerBar};
use super::bar::{Bar, BarForces, PlasticFlow};
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::collapse_of;
use super::newton::{self, NonlinearSystem};
use super::properties::Scheme;
use super::state::State;

/// Bound of the iterations for a massless top.
const MAX_MASSLESS_ITERATIONS: u32 = 30;

/// Force that a massless top may be out of balance by at the end of a midpoint step, relative to `N^p + P`. Nothing
/// builds on it: the scheme's own equations hold at `n + 1/2`.
const MASSLESS_TOLERANCE: f64 = 1e-9;

/// How far around its last position a massless top is looked for, relative to the shorter bar: to go further within the
/// smallest part of a step is to leap.
const SUPPORT_REACH: f64 = 1e-3;

/// At how many positions there.
const SUPPORT_SAMPLES: u32 = 200;

/// Elastic equilibrium of the whole column under its load.
struct Frozen<'a> {
    model: &'a Model,
    plastic: &'a PerBar<PlasticFlow>,
}

impl NonlinearSystem for Frozen<'_> {
    type Point = (PerBar<Chord>, PerBar<BarForces>);

    fn evaluate(&self, u: &Displacement) -> (Self::Point, Vector4<f64>) {
        let chords = assembly::chords(self.model, u);
        let forces = assembly::elastic_forces(self.model, &chords, u, self.plastic);
        let gradients = assembly::gradients(&chords);
        let mut residual = assembly::internal_forces(self.model, &gradients, &forces, u.u2);
        residual[3] -= self.model.properties.top_load;
        ((chords, forces), residual)
    }

    fn jacobian(&self, (chords, forces): &Self::Point) -> Matrix4<f64> {
        assembly::elastic_stiffness(self.model, chords, forces)
    }

    fn scale(&self) -> Vector4<f64> {
        let p = &self.model.properties;
        let force = p.resistance_axial + p.top_load;
        Vector4::new(force, force, p.resistance_moment, force)
    }

    fn model(&self) -> &Model {
        self.model
    }

    fn tolerance(&self) -> f64 {
        1e-13
    }
}

/// Elastic stiffness of `beta1` \[N m/rad\] and `u2` \[N/m\].
pub(crate) fn elastic_scale(model: &Model) -> [f64; 2] {
    [
        model.below.rotational[0][0] + model.above.rotational[0][0],
        model.above.axial + model.properties.top_spring_stiffness,
    ]
}

/// `beta1` and a massless `u2` in elastic equilibrium at the other displacements of `u`, with the forces there; `None`
/// if there is none near.
///
/// `beta1` follows in closed form from `M_1b = M_1a`; what remains is one equation for `u2`.
pub(crate) fn settle_massless(
    model: &Model,
    mut u: Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Option<(Displacement, PerBar<BarForces>)> {
    let [joint, _] = elastic_scale(model);
    let properties = &model.properties;
    let tolerance = MASSLESS_TOLERANCE * (properties.resistance_axial + properties.top_load);
    let below_chord = Chord::new(model.below.length, u.u1, u.v1);
    let below_total = assembly::strain(&below_chord, 0.0);
    let below_free = assembly::elastic_part(&below_total, &plastic.below);
    let moment_1a = model.below.elastic(&below_free).moment[0];
    let tangent = model.above.elastic_tangent();
    for _ in 0..MAX_MASSLESS_ITERATIONS {
        let chord = Chord::new(model.above.length, u.u2 - u.u1, u.v1);
        let total = assembly::strain(&chord, 0.0);
        let mut elastic = assembly::elastic_part(&total, &plastic.above);
        u.beta1 = (moment_1a - model.above.elastic(&elastic).moment[0]) / joint;
        elastic.rotation[0] += u.beta1;
        let above = model.above.elastic(&elastic);
        let gradient = chord.gradient();
        let along = above.normal * gradient.length_x
            + (above.moment[0] + above.moment[1]) * gradient.angle_x;
        let residual = properties.top_spring_stiffness * u.u2 - along - properties.top_load;
        if !model.top_is_massless() || residual.abs() <= tolerance {
            let mut turned = below_free;
            turned.rotation[0] -= u.beta1;
            let below = model.below.elastic(&turned);
            return Some((u, PerBar { below, above }));
        }
        let k = assembly::bar_stiffness(&gradient, &chord, &above, &tangent, 1.0);
        let stiffness = properties.top_spring_stiffness + k[(0, 0)] - k[(0, 2)] * k[(2, 0)] / joint;
        if stiffness.is_nan() || stiffness <= 0.0 {
            return None;
        }
        u.u2 -= residual / stiffness;
    }
    None
}

/// Whether a massless top finds a position near that of `state` in which the column, flowing if it must, carries the
/// load, once `v1` and `u1` have moved on by `secs` \[s\].
///
/// Only asked for a step that did not converge: with the masses hardly moving in its smallest part, what failed are the
/// equations of the massless unknowns. `beta1`'s is monotone and always has a solution; `u2`'s has none past the limit
/// point at which the top loses its support.
pub(crate) fn top_is_carried(model: &Model, state: &State, secs: f64) -> bool {
    let mut u = state.displacement;
    u.v1 += secs * state.velocity.v1;
    u.u1 += secs * state.velocity.u1;
    let reach = SUPPORT_REACH * model.shorter_bar();
    let load = model.properties.top_load;
    // The energy scheme balances the mean of both ends of the part, so what the start lacks the end must make up for.
    let target = match model.scheme() {
        Scheme::Midpoint => load,
        Scheme::Energy => 2.0 * load - force_on_top(model, &state.displacement, &state.forces),
    };
    let unbalanced = |share: f64| {
        let u2 = state.displacement.u2 + share * reach;
        carried_by_top(model, Displacement { u2, ..u }, &state.plastic) - target
    };
    let mut before = unbalanced(-1.0);
    for sample in 1..=SUPPORT_SAMPLES {
        let here = unbalanced(2.0 * f64::from(sample) / f64::from(SUPPORT_SAMPLES) - 1.0);
        if before <= 0.0 && here >= 0.0 {
            return true;
        }
        before = here;
    }
    false
}

/// `f_int(4)` of given forces \[N\].
fn force_on_top(model: &Model, u: &Displacement, forces: &PerBar<BarForces>) -> f64 {
    let gradients = assembly::gradients(&assembly::chords(model, u));
    assembly::internal_forces(model, &gradients, forces, u.u2)[3]
}

/// `f_int(4)` \[N\] at given `v1`, `u1`, `u2`, with `beta1` in equilibrium and the stress on or within the yield surface.
fn carried_by_top(model: &Model, mut u: Displacement, plastic: &PerBar<PlasticFlow>) -> f64 {
    let chords = assembly::chords(model, &u);
    let gradients = assembly::gradients(&chords);
    let internal = |u: &Displacement| {
        let elastic = assembly::elastic_strains(&chords, u, plastic);
        let back = |bar: &Bar, strain| bar.return_stress(bar.elastic(strain), 0.0).forces;
        let forces = PerBar {
            below: back(&model.below, &elastic.below),
            above: back(&model.above, &elastic.above),
        };
        assembly::internal_forces(model, &gradients, &forces, u.u2)
    };
    let (mut low, mut high) = (u.beta1 - 1.0, u.beta1 + 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        u.beta1 = 0.5 * (low + high);
        if internal(&u)[2] > 0.0 {
            high = u.beta1;
        } else {
            low = u.beta1;
        }
    }
    internal(&u)[3]
}

/// The residual state: static equilibrium under the load with the plastic deformation of `state` frozen, at rest and
/// without an impactor. `None` if no equilibrium is found near, or only one that has lost its shape.
pub fn residual_state(model: &Model, state: &State) -> Option<State> {
    let stage = Frozen {
        model,
        plastic: &state.plastic,
    };
    let displacement = newton::solve(&stage, state.displacement)?.increment;
    collapse_of(model, &displacement)
        .is_none()
        .then(|| State::settled(model, displacement, state.plastic))
}
