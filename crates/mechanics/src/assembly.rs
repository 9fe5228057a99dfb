//! From the forces of the bars to the forces on the displacements, `f_int = B^T S` (Eqs 10, 15-16), and the tangent
//! `B^T D B` with its geometric part.
//!
//! Rows and columns are in the order of `U`: `v1, u1, beta1, u2`.

use nalgebra::{Matrix3, Matrix4, Vector4};

use super::bar::{BarForces, BarStrain, PlasticFlow};
use super::geometry::{Chord, ChordGradient, Displacement};
use super::model::Model;

/// A thing that each of the two bars has one of.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PerBar<T> {
    /// Bar a, below the impact point.
    pub below: T,
    /// Bar b, above it.
    pub above: T,
}

/// Tangents of both bars.
pub(crate) type Tangents = PerBar<Matrix3<f64>>;

/// Chords of both bars (Eqs 3-4, 7-8).
pub(crate) fn chords(model: &Model, u: &Displacement) -> PerBar<Chord> {
    PerBar {
        below: Chord::new(model.below.length, u.u1, u.v1),
        above: Chord::new(model.above.length, u.u2 - u.u1, u.v1),
    }
}

/// Total deformation of a bar whose hinge at the impact point turns by `turn` besides its chord.
pub(crate) fn strain(chord: &Chord, turn: f64) -> BarStrain {
    let angle = chord.angle();
    BarStrain {
        elongation: chord.elongation,
        rotation: [angle + turn, angle],
    }
}

/// Total deformations (Eqs 3-8): `theta_1a = theta_3 - beta1`, `theta_1b = theta_2 + beta1`.
pub(crate) fn strains(chords: &PerBar<Chord>, beta1: f64) -> PerBar<BarStrain> {
    PerBar {
        below: strain(&chords.below, -beta1),
        above: strain(&chords.above, beta1),
    }
}

/// Elastic part of a total deformation.
pub(crate) fn elastic_part(total: &BarStrain, plastic: &PlasticFlow) -> BarStrain {
    BarStrain {
        elongation: total.elongation - (plastic.elongation[0] + plastic.elongation[1]),
        rotation: [
            total.rotation[0] - plastic.rotation[0],
            total.rotation[1] - plastic.rotation[1],
        ],
    }
}

/// Elastic part of both bars' deformation.
pub(crate) fn elastic_strains(
    chords: &PerBar<Chord>,
    u: &Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> PerBar<BarStrain> {
    let total = strains(chords, u.beta1);
    PerBar {
        below: elastic_part(&total.below, &plastic.below),
        above: elastic_part(&total.above, &plastic.above),
    }
}

/// Forces of both bars with the plastic deformation frozen.
pub(crate) fn elastic_forces(
    model: &Model,
    chords: &PerBar<Chord>,
    u: &Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> PerBar<BarForces> {
    let strains = elastic_strains(chords, u, plastic);
    PerBar {
        below: model.below.elastic(&strains.below),
        above: model.above.elastic(&strains.above),
    }
}

/// Internal forces on `v1, u1, beta1, u2` (Eq 16) \[N, N, N m, N\]; `spring_u2` is the `u2` that the top spring sees.
pub(crate) fn internal_forces(
    model: &Model,
    gradients: &PerBar<ChordGradient>,
    forces: &PerBar<BarForces>,
    spring_u2: f64,
) -> Vector4<f64> {
    let on_chord = |g: &ChordGradient, s: &BarForces| {
        let bending = s.moment[0] + s.moment[1];
        (
            s.normal * g.length_x + bending * g.angle_x,
            s.normal * g.length_v + bending * g.angle_v,
        )
    };
    let (below_x, below_v) = on_chord(&gradients.below, &forces.below);
    let (above_x, above_v) = on_chord(&gradients.above, &forces.above);
    Vector4::new(
        below_v + above_v,
        above_x - below_x,
        forces.above.moment[0] - forces.below.moment[0],
        model.properties.top_spring_stiffness * spring_u2 - above_x,
    )
}

/// Gradients at both chords (Eq 10).
pub(crate) fn gradients(chords: &PerBar<Chord>) -> PerBar<ChordGradient> {
    PerBar {
        below: chords.below.gradient(),
        above: chords.above.gradient(),
    }
}

/// Derivative of the internal forces with the elastic law.
pub(crate) fn elastic_stiffness(
    model: &Model,
    chords: &PerBar<Chord>,
    forces: &PerBar<BarForces>,
) -> Matrix4<f64> {
    let tangents = Tangents {
        below: model.below.elastic_tangent(),
        above: model.above.elastic_tangent(),
    };
    stiffness(model, &gradients(chords), chords, forces, &tangents)
}

/// Derivative of the internal forces: `B^T D B` with `left` for the gradients that weigh the forces, at the chords
/// where the tangents hold, plus the geometric part of `forces` there.
pub(crate) fn stiffness(
    model: &Model,
    left: &PerBar<ChordGradient>,
    right: &PerBar<Chord>,
    forces: &PerBar<BarForces>,
    tangents: &Tangents,
) -> Matrix4<f64> {
    let below = bar_stiffness(
        &left.below,
        &right.below,
        &forces.below,
        &tangents.below,
        -1.0,
    );
    let above = bar_stiffness(
        &left.above,
        &right.above,
        &forces.above,
        &tangents.above,
        1.0,
    );
    // x_a = L_a - u1, x_b = L_b + u1 - u2.
    let mut k = Matrix4::zeros();
    k[(0, 0)] = below[(1, 1)] + above[(1, 1)];
    k[(0, 1)] = above[(1, 0)] - below[(1, 0)];
    k[(0, 2)] = below[(1, 2)] + above[(1, 2)];
    k[(0, 3)] = -above[(1, 0)];
    k[(1, 0)] = above[(0, 1)] - below[(0, 1)];
    k[(1, 1)] = below[(0, 0)] + above[(0, 0)];
    k[(1, 2)] = above[(0, 2)] - below[(0, 2)];
    k[(1, 3)] = -above[(0, 0)];
    k[(2, 0)] = below[(2, 1)] + above[(2, 1)];
    k[(2, 1)] = above[(2, 0)] - below[(2, 0)];
    k[(2, 2)] = below[(2, 2)] + above[(2, 2)];
    k[(2, 3)] = -above[(2, 0)];
    k[(3, 0)] = -above[(0, 1)];
    k[(3, 1)] = -above[(0, 0)];
    k[(3, 2)] = -above[(0, 2)];
    k[(3, 3)] = above[(0, 0)] + model.properties.top_spring_stiffness;
    k
}

/// Stiffness of one bar against `x`, `v`, `beta1`; `turn` is the sign of `beta1` in its rotation at the impact point.
pub(crate) fn bar_stiffness(
    left: &ChordGradient,
    right: &Chord,
    forces: &BarForces,
    tangent: &Matrix3<f64>,
    turn: f64,
) -> Matrix3<f64> {
    let rows = |g: &ChordGradient| {
        Matrix3::new(
            g.length_x, g.length_v, 0.0, //
            g.angle_x, g.angle_v, turn, //
            g.angle_x, g.angle_v, 0.0,
        )
    };
    let mut k = rows(left).transpose() * tangent * rows(&right.gradient());
    let [xx, xv, vv] = right.hessian(forces.normal, forces.moment[0] + forces.moment[1]);
    k[(0, 0)] += xx;
    k[(0, 1)] += xv;
    k[(1, 0)] += xv;
    k[(1, 1)] += vv;
    k
}
