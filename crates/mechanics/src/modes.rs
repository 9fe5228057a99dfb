//! Elastic modes about a state: the slowest period, and the modal damping of the column at rest.

use nalgebra::{Matrix2, Matrix3, Matrix4, Vector3};

use super::assembly::{self, PerBar};
use super::bar::PlasticFlow;
use super::geometry::Displacement;
use super::model::Model;

/// Elastic stiffness of the displacements that carry mass, `v1, u1, u2`, about a state: `beta1` follows and, where it
/// is massless, `u2` too, whose row and column are then zero.
pub(crate) fn condensed_stiffness(
    model: &Model,
    u: &Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Matrix3<f64> {
    let chords = assembly::chords(model, u);
    let forces = assembly::elastic_forces(model, &chords, u, plastic);
    let mut k: Matrix4<f64> = assembly::elastic_stiffness(model, &chords, &forces);
    condense(&mut k, 2);
    if model.top_is_massless() {
        condense(&mut k, 3);
    }
    k.fixed_view::<4, 4>(0, 0)
        .into_owned()
        .remove_fixed_rows::<1>(2)
        .remove_fixed_columns::<1>(2)
}

fn condense(k: &mut Matrix4<f64>, eliminated: usize) {
    let pivot = k[(eliminated, eliminated)];
    let (column, row) = (
        k.column(eliminated).into_owned(),
        k.row(eliminated).into_owned(),
    );
    *k -= column * row / pivot;
    k.row_mut(eliminated).fill(0.0);
    k.column_mut(eliminated).fill(0.0);
}

/// Period of the slowest elastic mode about a state with its plastic deformation frozen \[s\]; `None` where it is not
/// stable.
pub(crate) fn slowest_period(
    model: &Model,
    u: &Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Option<f64> {
    let mut scaled = condensed_stiffness(model, u, plastic);
    let top_mass = if model.top_is_massless() {
        // Its row is zero: any mass will do, and the mode is left out below.
        1.0
    } else {
        model.properties.top_mass
    };
    let root_mass =
        Vector3::new(model.impact_point_mass, model.impact_point_mass, top_mass).map(f64::sqrt);
    for row in 0..3 {
        for column in 0..3 {
            scaled[(row, column)] /= root_mass[row] * root_mass[column];
        }
    }
    let slowest = if model.top_is_massless() {
        let moving: Matrix2<f64> = scaled.fixed_view::<2, 2>(0, 0).into_owned();
        moving.symmetric_eigenvalues().min()
    } else {
        scaled.symmetric_eigenvalues().min()
    };
    (slowest > 0.0).then(|| std::f64::consts::TAU / slowest.sqrt())
}

/// Damping coefficients that give every elastic mode of the column at rest the fraction `ratio` of critical damping:
/// of `v1`, and of `u1, u2` together \[N s/m\]. At rest the transverse motion and the axial one do not couple.
pub(crate) fn modal_damping(model: &Model, ratio: f64) -> (f64, Matrix2<f64>) {
    let k = condensed_stiffness(model, &model.rest_displacement(), &PerBar::default());
    let (mass, top_mass) = (model.impact_point_mass, model.properties.top_mass);
    let transverse = 2.0 * ratio * (k[(0, 0)] * mass).sqrt();
    let mut axial = Matrix2::zeros();
    if model.top_is_massless() {
        axial[(0, 0)] = 2.0 * ratio * (k[(1, 1)] * mass).sqrt();
        return (transverse, axial);
    }
    // C = 2 zeta M^1/2 (M^-1/2 K M^-1/2)^1/2 M^1/2; the root of a positive 2x2 matrix A is
    // (A + sqrt(det A) I) / sqrt(tr A + 2 sqrt(det A)), and det K = K_a K_b + k_s (K_a + K_b) without cancellation.
    let root_mass = [mass.sqrt(), top_mass.sqrt()];
    let (a, b) = (model.below.axial, model.above.axial);
    let determinant = a * b + model.properties.top_spring_stiffness * (a + b);
    let root = (determinant / (mass * top_mass)).sqrt();
    let trace = k[(1, 1)] / mass + k[(2, 2)] / top_mass;
    for row in 0..2 {
        for column in 0..2 {
            let scale = root_mass[row] * root_mass[column];
            let diagonal = if row == column { root } else { 0.0 };
            let frequency =
                (k[(1 + row, 1 + column)] / scale + diagonal) / (trace + 2.0 * root).sqrt();
            axial[(row, column)] = 2.0 * ratio * frequency * scale;
        }
    }
    (transverse, axial)
}
