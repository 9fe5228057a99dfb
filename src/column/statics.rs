//! Equilibrium without inertia: of the whole column with its plastic deformation frozen, and of its massless
//! unknowns.

use nalgebra::{Matrix4, Vector4};

use super::assembly::{self, PerBar, Tangents};
use super::bar::{BarForces, PlasticFlow};
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::collapse_of;
use super::newton::{self, Stage};
use super::state::State;

/// Elastic equilibrium under the load: of all displacements, or of `beta1` and a massless `u2` alone.
struct Frozen<'a> {
    model: &'a Model,
    plastic: &'a PerBar<PlasticFlow>,
    /// Whether `v1`, `u1`, `beta1`, `u2` are unknown.
    unknown: [bool; 4],
}

impl Stage for Frozen<'_> {
    type Point = (PerBar<Chord>, PerBar<BarForces>);

    fn evaluate(&self, u: &Displacement) -> (Self::Point, Vector4<f64>) {
        let chords = assembly::chords(self.model, u);
        let forces = assembly::elastic_forces(self.model, &chords, u, self.plastic);
        let gradients = PerBar {
            below: chords.below.gradient(),
            above: chords.above.gradient(),
        };
        let mut residual = assembly::internal_forces(self.model, &gradients, &forces, u.u2);
        residual[3] -= self.model.properties.top_load;
        for (row, unknown) in self.unknown.into_iter().enumerate() {
            if !unknown {
                residual[row] = 0.0;
            }
        }
        ((chords, forces), residual)
    }

    fn jacobian(&self, (chords, forces): &Self::Point) -> Matrix4<f64> {
        let tangents = Tangents {
            below: self.model.below.elastic_tangent(),
            above: self.model.above.elastic_tangent(),
        };
        let mut k = assembly::stiffness(self.model, chords, chords, forces, &tangents);
        for (row, unknown) in self.unknown.into_iter().enumerate() {
            if !unknown {
                k.row_mut(row).fill(0.0);
                k[(row, row)] = 1.0;
            }
        }
        k
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

/// `beta1` and a massless `u2` in elastic equilibrium at the other displacements of `u`; `None` if there is none near.
pub(crate) fn settle_massless(
    model: &Model,
    u: Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Option<Displacement> {
    let stage = Frozen {
        model,
        plastic,
        unknown: [false, false, true, model.top_is_massless()],
    };
    Some(newton::solve(&stage, u)?.increment)
}

/// The residual state: static equilibrium under the load with the plastic deformation of `state` frozen, at rest and
/// without an impactor. `None` if no equilibrium is found near, or only one that has lost its shape.
pub fn residual_state(model: &Model, state: &State) -> Option<State> {
    let stage = Frozen {
        model,
        plastic: &state.plastic,
        unknown: [true; 4],
    };
    let displacement = newton::solve(&stage, state.displacement)?.increment;
    collapse_of(model, &displacement)
        .is_none()
        .then(|| State::settled(model, displacement, state.plastic))
}
