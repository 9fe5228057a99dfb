//! Elastic modes about a state: the slowest period, and the modal damping of the column at rest.

use nalgebra::Matrix4;

use super::bar::{PerBar, PlasticFlow};
use super::frame::Frame;
use super::geometry::Displacement;

/// Order in which the unknowns are eliminated, those that may be massless first: `beta1, u2, u1, v1`.
pub(crate) const ELIMINATION_ORDER: [usize; 4] = [2, 3, 1, 0];

/// Masses of the displacements `v1, u1, beta1, u2`; `beta1` has none, `u2` may have none \[kg\].
pub(crate) type Masses = [f64; 4];

/// Damping coefficients \[N s/m\]: of `v1`, and of `u1, u2` together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Damping {
    pub transverse: f64,
    pub axial: [[f64; 2]; 2],
}

/// Elastic stiffness about a state with its plastic deformation frozen.
fn stiffness(frame: &Frame, u: &Displacement, plastic: &PerBar<PlasticFlow>) -> Matrix4<f64> {
    let chords = frame.chords(u);
    let forces = frame.elastic_forces(&chords, u, plastic);
    frame.elastic_stiffness(&chords, &forces)
}

/// Elastic stiffness against `v1` of the undamaged column at rest, with `beta1` free \[N/m\]. The axial displacements do not
/// couple with it there.
pub(crate) fn transverse_stiffness(frame: &Frame, rest: &Displacement) -> f64 {
    let k = stiffness(frame, rest, &PerBar::default());
    k[(0, 0)] - k[(0, 2)] * k[(2, 0)] / k[(2, 2)]
}

/// Period of the slowest elastic mode about a state with its plastic deformation frozen \[s\]; `None` where the state is
/// not stable.
///
/// `K - omega^2 M` is positive definite below the smallest `omega^2` only, which bisection finds to the last bit.
pub(crate) fn slowest_period(
    frame: &Frame,
    masses: &Masses,
    u: &Displacement,
    plastic: &PerBar<PlasticFlow>,
) -> Option<f64> {
    let k = stiffness(frame, u, plastic);
    if !is_positive_definite(&k, masses, 0.0) {
        return None;
    }
    // With all other displacements held, a mass swings at least as fast as in the slowest mode.
    let (mut low, mut high) = (0.0, f64::INFINITY);
    for row in 0..4 {
        if masses[row] > 0.0 {
            high = high.min(k[(row, row)] / masses[row]);
        }
    }
    loop {
        let middle = 0.5 * (low + high);
        if !(middle > low && middle < high) {
            return Some(std::f64::consts::TAU / high.sqrt());
        }
        if is_positive_definite(&k, masses, middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Whether all pivots of `k - square * masses` are positive.
fn is_positive_definite(k: &Matrix4<f64>, masses: &Masses, square: f64) -> bool {
    let mut a = *k;
    for row in 0..4 {
        a[(row, row)] -= square * masses[row];
    }
    for (done, &pivot) in ELIMINATION_ORDER.iter().enumerate() {
        if a[(pivot, pivot)].is_nan() || a[(pivot, pivot)] <= 0.0 {
            return false;
        }
        for &row in &ELIMINATION_ORDER[done + 1..] {
            let factor = a[(row, pivot)] / a[(pivot, pivot)];
            for &column in &ELIMINATION_ORDER[done + 1..] {
                a[(row, column)] -= factor * a[(pivot, column)];
            }
        }
    }
    true
}

/// Damping coefficients that give every elastic mode of the column at rest the fraction `ratio` of critical damping, for
/// a column with the transverse stiffness `transverse` \[N/m\]. At rest the transverse and the axial motion do not couple.
pub(crate) fn modal_damping(
    frame: &Frame,
    masses: &Masses,
    transverse: f64,
    ratio: f64,
) -> Damping {
    let [mass, _, _, top_mass] = *masses;
    let transverse = 2.0 * ratio * (transverse * mass).sqrt();
    let (a, b, spring) = (
        frame.below.axial,
        frame.above.axial,
        frame.top_spring_stiffness,
    );
    let mut axial = [[0.0; 2]; 2];
    if top_mass == 0.0 {
        let condensed = a + b * (spring / (b + spring));
        axial[0][0] = 2.0 * ratio * (condensed * mass).sqrt();
        return Damping { transverse, axial };
    }
    // C = 2 zeta M^1/2 (M^-1/2 K M^-1/2)^1/2 M^1/2; the root of a positive 2x2 matrix A is
    // (A + sqrt(det A) I) / sqrt(tr A + 2 sqrt(det A)), and det K = K_a K_b + k_s (K_a + K_b) without cancellation.
    let k = [[a + b, -b], [-b, b + spring]];
    let root_mass = [mass.sqrt(), top_mass.sqrt()];
    let root = ((a * b + spring * (a + b)) / (mass * top_mass)).sqrt();
    let trace = k[0][0] / mass + k[1][1] / top_mass;
    for row in 0..2 {
        for column in 0..2 {
            let scale = root_mass[row] * root_mass[column];
            let diagonal = if row == column { root } else { 0.0 };
            let frequency = (k[row][column] / scale + diagonal) / (trace + 2.0 * root).sqrt();
            axial[row][column] = 2.0 * ratio * frequency * scale;
        }
    }
    Damping { transverse, axial }
}
