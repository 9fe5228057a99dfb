//! Flexural buckling resistance and equivalent imperfections of EN 1993-1-1.
//!
//! The two-bar model is too stiff against elastic buckling (its critical load is up to 22 % above Euler's with the impact
//! point at mid-height, and more elsewhere), and it is plane. The resistance of the code stands beside its push-down for
//! both reasons: about the strong axis it holds the slenderness, about the weak axis it is the only one.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::properties::Support;
use super::section::RolledSection;

/// Slenderness up to which no reduction applies (EN 1993-1-1:2005, 6.3.1.2).
const PLATEAU: f64 = 0.2;

/// Yield strength from which Table 6.2 of EN 1993-1-1:2005 has a column of its own \[Pa\]: S460.
const HIGH_STRENGTH: f64 = 460e6;

/// Buckling curve of EN 1993-1-1:2005, Table 6.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BucklingCurve {
    /// `a0`.
    A0,
    /// `a`.
    A,
    /// `b`.
    B,
    /// `c`.
    C,
    /// `d`.
    D,
}

/// Principal axis of a section about which a column bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BendingAxis {
    /// `y-y`: the column moves in the plane of the web.
    Strong,
    /// `z-z`: across it.
    Weak,
}

/// Flexural buckling resistance of EN 1993-1-1:2005, 6.3.1, with a partial factor of 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BucklingResistance {
    /// `N_b,R = chi A f_y` \[N\].
    pub force: f64,
    /// `chi`.
    pub reduction: f64,
    /// `lambda`: `sqrt(A f_y / N_cr)`.
    pub slenderness: f64,
    /// `N_cr`: Euler's load for the buckling length \[N\].
    pub critical_force: f64,
    /// `K L` \[m\].
    pub buckling_length: f64,
    /// The curve.
    pub curve: BucklingCurve,
}

impl BucklingCurve {
    /// The imperfection factor `alpha` (EN 1993-1-1:2005, Table 6.1).
    #[must_use]
    pub fn imperfection_factor(self) -> f64 {
        match self {
            Self::A0 => 0.13,
            Self::A => 0.21,
            Self::B => 0.34,
            Self::C => 0.49,
            Self::D => 0.76,
        }
    }

    /// `e0 / L` of the equivalent bow for elastic analysis (EN 1993-1-1:2005, Table 5.1; recalled, not verified).
    #[must_use]
    pub fn relative_bow(self) -> f64 {
        1.0 / match self {
            Self::A0 => 350.0,
            Self::A => 300.0,
            Self::B => 250.0,
            Self::C => 200.0,
            Self::D => 150.0,
        }
    }

    /// The curve of a rolled I or H section with yield strength `yield_strength` \[Pa\] about an axis
    /// (EN 1993-1-1:2005, Table 6.2, as the open-source package civilR states it for grades up to S420; S460 recalled, not verified). A section outside of the table gets the curve `d`.
    #[must_use]
    pub fn of_rolled(section: &RolledSection, yield_strength: f64, axis: BendingAxis) -> Self {
        let slim = section.depth > 1.2 * section.width;
        let flange = section.flange_thickness;
        let high = yield_strength >= HIGH_STRENGTH;
        match (slim, flange, axis) {
            (true, ..=0.040, _) if high => Self::A0,
            (true, ..=0.040, BendingAxis::Strong) => Self::A,
            (true, ..=0.040, BendingAxis::Weak) => Self::B,
            (_, ..=0.100, _) if high => Self::A,
            (_, ..=0.100, BendingAxis::Strong) => Self::B,
            (_, ..=0.100, BendingAxis::Weak) => Self::C,
            (false, _, _) if high => Self::C,
            _ => Self::D,
        }
    }

    /// `chi` for a slenderness `lambda >= 0`.
    #[must_use]
    pub fn reduction(self, slenderness: f64) -> f64 {
        if slenderness <= PLATEAU {
            return 1.0;
        }
        let square = slenderness * slenderness;
        let phi = 0.5 * (1.0 + self.imperfection_factor() * (slenderness - PLATEAU) + square);
        (1.0 / (phi + (phi * phi - square).sqrt())).min(1.0)
    }
}

/// `K`: the buckling length of a column held against sway at its base, and at its top unless that is free, relative to its
/// length `length` \[m\]; exact for elastic rotational springs at the ends, 0.5 for two built-in ends, 0.699 for one, 1 for
/// none, 2 for a free top above a built-in base. `bending_stiffness` is
/// `EI` \[N m²\] about the axis of bending.
#[must_use]
pub fn effective_length_factor(
    base: Support,
    top: Support,
    bending_stiffness: f64,
    length: f64,
) -> f64 {
    // Fixity k / (k + EI/L): 0 pinned, 1 built in.
    let fixity = |support| match support {
        Support::BuiltIn => 1.0,
        Support::Pinned | Support::Free => 0.0,
        Support::SemiRigid { stiffness } => stiffness / (stiffness + bending_stiffness / length),
    };
    if top == Support::Free {
        return cantilever_length_factor(fixity(base));
    }
    let (a, b) = (fixity(base), fixity(top));
    let (free, mixed, held) = ((1.0 - a) * (1.0 - b), a * (1.0 - b) + b * (1.0 - a), a * b);
    // The determinant of the beam-column's stiffness with its end springs, freed of its poles; x = pi / K.
    let determinant = |x: f64| {
        let (sin, cos) = (libm::sin(x), libm::cos(x));
        free * x * x * x * sin + mixed * x * (sin - x * cos) + held * (2.0 - 2.0 * cos - x * sin)
    };
    let (mut low, mut high) = (PI, TAU);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if determinant(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    PI / high
}

/// `K` of a column that is held at its base alone, with the fixity `a` of its rotational spring `k`, so that
/// `x tan x = k L / EI`, `x = pi / K`: 2 if it is built in, and without bound as the spring becomes soft.
fn cantilever_length_factor(a: f64) -> f64 {
    let determinant = |x: f64| (1.0 - a) * x * libm::sin(x) - a * libm::cos(x);
    let (mut low, mut high) = (0.0, 0.5 * PI);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if determinant(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    PI / high
}

/// The resistance of a column with squash load `A f_y` \[N\], `EI` \[N m²\] about the axis of bending and buckling length
/// `K L` \[m\].
#[must_use]
pub fn buckling_resistance(
    curve: BucklingCurve,
    squash_load: f64,
    bending_stiffness: f64,
    buckling_length: f64,
) -> BucklingResistance {
    let critical_force = PI * PI * bending_stiffness / (buckling_length * buckling_length);
    let slenderness = (squash_load / critical_force).sqrt();
    let reduction = curve.reduction(slenderness);
    BucklingResistance {
        force: reduction * squash_load,
        reduction,
        slenderness,
        critical_force,
        buckling_length,
        curve,
    }
}

#[cfg(test)]
#[allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]
mod tests {
    use super::*;

    const YOUNG_MODULUS: f64 = 210e9;

    fn heb220() -> RolledSection {
        RolledSection {
            depth: 0.220,
            width: 0.220,
            web_thickness: 0.0095,
            flange_thickness: 0.016,
            root_radius: 0.018,
        }
    }

    /// HEB 220, S355, 4 m, computed independently.
    #[test]
    fn resistances_of_heb_220() {
        let section = heb220();
        let squash = section.properties().area * 355e6;
        for (axis, second_moment, expected) in [
            (
                BendingAxis::Strong,
                section.properties().second_moment,
                [2776e3, 3007e3, 3142e3],
            ),
            (
                BendingAxis::Weak,
                section.weak_second_moment(),
                [1866e3, 2430e3, 2781e3],
            ),
        ] {
            let curve = BucklingCurve::of_rolled(&section, 355e6, axis);
            for (factor, expected) in [1.0, 0.7, 0.5].into_iter().zip(expected) {
                let found =
                    buckling_resistance(curve, squash, YOUNG_MODULUS * second_moment, 4.0 * factor);
                assert!(
                    (found.force - expected).abs() < 1.0e3,
                    "{axis:?} K {factor}: {found:?}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn reduction_has_its_plateau_and_eulers_limit() {
        for curve in [
            BucklingCurve::A0,
            BucklingCurve::A,
            BucklingCurve::B,
            BucklingCurve::C,
            BucklingCurve::D,
        ] {
            assert_eq!(curve.reduction(0.0), 1.0);
            assert_eq!(curve.reduction(0.2), 1.0);
            let slender = 60.0_f64;
            let euler = 1.0 / (slender * slender);
            assert!((curve.reduction(slender) / euler - 1.0).abs() < 0.02);
            let mut before = 1.0;
            for k in 1..300 {
                let here = curve.reduction(0.2 + 0.01 * f64::from(k));
                assert!(here < before, "{curve:?}");
                before = here;
            }
        }
    }

    #[test]
    fn effective_lengths_of_springs_lie_between_those_of_ideal_ends() {
        let factor = |base, top| effective_length_factor(base, top, 17e6, 4.0);
        assert!((factor(Support::Pinned, Support::Pinned) - 1.0).abs() < 1e-12);
        assert!((factor(Support::BuiltIn, Support::BuiltIn) - 0.5).abs() < 1e-12);
        assert!((factor(Support::BuiltIn, Support::Free) - 2.0).abs() < 1e-12);
        // x tan x = 1 at x = 0.8603.
        let as_stiff = Support::SemiRigid { stiffness: 1.0 };
        let soft = effective_length_factor(as_stiff, Support::Free, 4.0, 4.0);
        assert!((soft - PI / 0.860_333_589).abs() < 1e-8);
        // tan x = x.
        let one = PI / 4.493_409_457_909_064;
        assert!((factor(Support::BuiltIn, Support::Pinned) - one).abs() < 1e-12);
        assert!((factor(Support::Pinned, Support::BuiltIn) - one).abs() < 1e-12);
        let spring = |stiffness| Support::SemiRigid { stiffness };
        // k = EI/L at both ends; the symmetric mode satisfies (x/2) / tan(x/2) = -k L / (2 EI).
        let x = PI / factor(spring(17e6 / 4.0), spring(17e6 / 4.0));
        assert!((x / 2.0 / (x / 2.0).tan() + 0.5).abs() < 1e-9, "{x}");
        assert!((factor(spring(1e20), spring(1e20)) - 0.5).abs() < 1e-9);
        assert!((factor(spring(1e-9), spring(1e-9)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn curves_of_rolled_sections() {
        use BendingAxis::{Strong, Weak};
        use BucklingCurve::{A, A0, B, C, D};
        let with = |depth, flange_thickness| RolledSection {
            depth,
            flange_thickness,
            ..heb220()
        };
        for (section, strength, axis, expected) in [
            (with(0.220, 0.016), 355e6, Strong, B),
            (with(0.220, 0.016), 355e6, Weak, C),
            (with(0.220, 0.016), 460e6, Weak, A),
            (with(0.300, 0.016), 355e6, Strong, A),
            (with(0.300, 0.016), 355e6, Weak, B),
            (with(0.300, 0.016), 460e6, Strong, A0),
            (with(0.300, 0.060), 355e6, Strong, B),
            (with(0.300, 0.060), 355e6, Weak, C),
            (with(0.300, 0.060), 460e6, Weak, A),
            (with(0.220, 0.120), 355e6, Strong, D),
            (with(0.220, 0.120), 460e6, Strong, C),
            (with(0.300, 0.120), 460e6, Strong, D),
        ] {
            assert_eq!(
                BucklingCurve::of_rolled(&section, strength, axis),
                expected,
                "{section:?} {strength} {axis:?}"
            );
        }
    }
}
