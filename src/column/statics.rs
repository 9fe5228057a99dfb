//! Equilibrium without inertia: of the whole column with its plastic deformation frozen, and of its massless
//! unknowns.

use nalgebra::{Matrix4, Vector4};

use super::assembly::{self, PerBar};
use super::bar::{BarForces, PlasticFlow};
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::collapse_of;
use super::newton::{self, Stage};
use super::state::State;

/// Bound of the iterations for a massless top.
const MAX_MASSLESS_ITERATIONS: u32 = 30;

/// Force that a massless top may be out of balance by at the end of a midpoint step, relative to `N^p + P`. Nothing
/// builds on it: the scheme's own equations hold at `n + 1/2`.
const MASSLESS_TOLERANCE: f64 = 1e-11;

/// Elastic equilibrium of the whole column under its load.
struct Frozen<'a> {
    model: &'a Model,
    plastic: &'a PerBar<PlasticFlow>,
}

impl Stage for Frozen<'_> {
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

    fn rotational_scale(&self) -> f64 {
        rotational_scale(self.model)
    }
}

/// Elastic stiffness of `beta1` \[N m/rad\].
pub(crate) fn rotational_scale(model: &Model) -> f64 {
    model.below.rotational[0][0] + model.above.rotational[0][0]
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
    let joint = rotational_scale(model);
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
        let stiffness =
            properties.top_spring_stiffness + k[(0, 0)] - k[(0, 2)] * k[(2, 0)] / joint;
        if !(stiffness > 0.0) {
            return None;
        }
        u.u2 -= residual / stiffness;
    }
    None
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
