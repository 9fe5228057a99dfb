//! Steel: its stress over the plastic strain, in straight pieces.
//!
//! The stress at which a fibre yields again follows from its plastic strain alone, so that a fibre that was pulled beyond the
//! plateau yields earlier when it is pushed (Bauschinger's effect), and what hardening stores is the integral of a rising curve:
//! the return of a fibre remains the minimum of a convex function, whatever the length of a step.

use serde::{Deserialize, Serialize};

/// Steel of the column, bilinear or with a yield plateau, with kinematic hardening: a fibre that has hardened one way yields
/// earlier the other way (Bauschinger's effect).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Steel {
    /// `E`: Young's modulus \[Pa\].
    pub young_modulus: f64,
    /// `nu`: Poisson's ratio.
    pub poisson_ratio: f64,
    /// `f_y`: yield strength \[Pa\].
    pub yield_strength: f64,
    /// `b`: slope after yield over Young's modulus, above 0: without hardening the length that yields depends on the mesh.
    pub hardening_ratio: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// `f_u`: tensile strength \[Pa\] of a steel with a yield plateau, whose slope is then the hardening ratio, and with the
    /// hardening after Yun and Gardner (2017), as in EN 1993-1-14; `None` for a bilinear steel.
    #[serde(default)]
    pub tensile_strength: Option<f64>,
}

impl Steel {
    /// `G` \[Pa\].
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.young_modulus / (1.0 + self.poisson_ratio)
    }

    /// `H`: slope of the stress over the plastic strain \[Pa\].
    pub(crate) fn plastic_modulus(&self) -> f64 {
        self.hardening_ratio * self.young_modulus / (1.0 - self.hardening_ratio)
    }
}

/// Bounds of the strain at which hardening begins, and least strain at the tensile strength, after Yun and Gardner (2017).
const PLATEAU: [f64; 2] = [0.015, 0.03];
const LEAST_ULTIMATE: f64 = 0.06;

/// Where, on the way from the end of the plateau to the tensile strength, the slope changes, and where the first slope would reach
/// that strength.
const BEND: f64 = 0.25;
const SECANT: f64 = 0.4;

/// The back stress of a fibre over its plastic strain, the same in both directions.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    /// Stress per elastic strain \[Pa\].
    modulus: f64,
    /// Plastic strain and back stress \[Pa\] at which a piece begins, and its slope \[Pa\].
    pieces: Vec<[f64; 3]>,
}

impl Curve {
    /// A yield plateau and hardening up to the tensile strength \[Pa\] after Yun and Gardner (2017), as in EN 1993-1-14.
    ///
    /// The plateau and what follows the tensile strength rise with the hardening ratio of the steel.
    pub fn plateau(steel: &Steel, tensile: f64) -> Self {
        let (e, first) = (steel.young_modulus, steel.yield_strength);
        let ratio = first / tensile;
        let ultimate = (0.6 * (1.0 - ratio)).max(LEAST_ULTIMATE);
        let begin = (0.1 * ratio - 0.055).clamp(PLATEAU[0], PLATEAU[1]);
        let risen = first + steel.hardening_ratio * e * (begin - first / e);
        let bend = begin + BEND * (ultimate - begin);
        let points = [
            [first / e, first],
            [begin, risen],
            [bend, first + BEND / SECANT * (tensile - first)],
            [ultimate, tensile],
        ];
        let plastic = points.map(|[strain, stress]| [strain - stress / e, stress - first]);
        let mut pieces: Vec<[f64; 3]> = plastic
            .windows(2)
            .map(|pair| {
                let [from, to] = [pair[0], pair[1]];
                [from[0], from[1], (to[1] - from[1]) / (to[0] - from[0])]
            })
            .collect();
        let [strain, stress] = plastic[3];
        pieces.push([strain, stress, steel.plastic_modulus()]);
        Self { modulus: e, pieces }
    }

    /// The same for a shear stress over a plastic shear angle, where the normal stress is the root of three times the shear stress.
    pub fn in_shear(&self, shear_modulus: f64) -> Self {
        let root = 3.0_f64.sqrt();
        let piece =
            |[strain, stress, slope]: &[f64; 3]| [root * strain, stress / root, slope / 3.0];
        Self {
            modulus: shear_modulus,
            pieces: self.pieces.iter().map(piece).collect(),
        }
    }

    /// Ends the hardening at this back stress \[Pa\].
    pub fn end_at(&mut self, most: f64) {
        let Some(beyond) = self.pieces.iter().rposition(|piece| piece[1] <= most) else {
            return;
        };
        let [strain, stress, slope] = self.pieces[beyond];
        self.pieces.truncate(beyond + 1);
        self.pieces
            .push([strain + (most - stress) / slope, most, 0.0]);
    }

    /// The back stress at a plastic strain \[Pa\].
    pub fn back_stress(&self, plastic: f64) -> f64 {
        let size = plastic.abs();
        let at = self.pieces.iter().rev().find(|piece| piece[0] <= size);
        let stress = at.map_or(0.0, |[from, stress, slope]| stress + slope * (size - from));
        stress.copysign(plastic)
    }

    /// The plastic strain `p` with `per_strain p + share X(p) = sum`, where `X` is the back stress, and the slope there \[Pa\].
    pub fn solve(&self, per_strain: f64, share: f64, sum: f64) -> [f64; 2] {
        let size = sum.abs();
        let begin = |piece: &[f64; 3]| per_strain * piece[0] + share * piece[1];
        let pieces = self.pieces.iter().rev();
        let (piece, from) = pieces
            .map(|piece| (piece, begin(piece)))
            .find(|(_, from)| *from <= size)
            .unwrap_or((&self.pieces[0], 0.0));
        let plastic = piece[0] + (size - from) / (per_strain + share * piece[2]);
        [plastic.copysign(sum), piece[2]]
    }

    /// The stress in the middle of the elastic range of a fibre with this plastic strain and no other one \[Pa\].
    pub fn middle(&self, plastic: f64) -> f64 {
        self.modulus * plastic + self.back_stress(plastic)
    }

    /// The plastic strain of a fibre whose elastic range has this middle.
    pub fn plastic(&self, middle: f64) -> f64 {
        self.solve(self.modulus, 1.0, middle)[0]
    }

    /// By how much the stress falls short of the elastic one where the middle moves from one place by `by`, and the share of the
    /// stiffness that is lost at its end.
    pub fn relieved(&self, middle: f64, by: f64) -> [f64; 2] {
        let [after, slope] = self.solve(self.modulus, 1.0, middle + by);
        [
            self.modulus * (after - self.plastic(middle)),
            self.modulus / (self.modulus + slope),
        ]
    }

    /// Stress per elastic strain \[Pa\].
    pub fn modulus(&self) -> f64 {
        self.modulus
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S355: Steel = Steel {
        young_modulus: 210e9,
        poisson_ratio: 0.3,
        yield_strength: 355e6,
        hardening_ratio: 1e-4,
        density: 7850.0,
        tensile_strength: Some(490e6),
    };

    /// By hand: `eps_u = 0.6 (1 - 355/490)`, `eps_sh = 0.1 (355/490) - 0.055`.
    #[test]
    fn the_curve_of_yun_and_gardner_by_hand() {
        let curve = Curve::plateau(&S355, 490e6);
        for (strain, stress) in [
            (0.01, 355e6),
            (0.017_44, 355e6),
            (0.054_406, 355e6 + 0.625 * 135e6),
            (0.165_306, 490e6),
        ] {
            let plastic = strain - stress / 210e9;
            let found = 355e6 + curve.back_stress(plastic);
            assert!((found / stress - 1.0).abs() < 2e-3, "{strain}: {found:e}");
            assert_eq!(curve.back_stress(-plastic), -curve.back_stress(plastic));
        }
    }

    #[test]
    fn the_middle_of_the_elastic_range_gives_the_plastic_strain_back() {
        let normal = Curve::plateau(&S355, 490e6);
        let mut sheared = normal.in_shear(S355.shear_modulus());
        sheared.end_at(50e6);
        assert!((sheared.back_stress(1.0) - 50e6).abs() < 1.0);
        for curve in [normal, sheared] {
            for plastic in [-0.5, -0.12, -0.03, -0.01, 0.0, 1e-4, 0.014, 0.05, 0.2] {
                let found = curve.plastic(curve.middle(plastic));
                assert!((found - plastic).abs() < 1e-14, "{plastic} {found}");
            }
        }
    }
}
