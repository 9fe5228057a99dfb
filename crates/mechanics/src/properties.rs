//! The properties of a column as an engineer gives them: numbers in SI units, from which the model is derived.

use serde::{Deserialize, Serialize};

/// A column, its supports, the mass and the load on it, and its time stepping. SI units throughout.
///
/// Plain data; [`Model::new`](super::Model::new) checks it and derives the constants of the column.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ColumnProperties {
    /// `L_a`: height of the impact point above the base \[m\].
    pub length_below: f64,
    /// `L_b`: from the impact point to the top \[m\].
    pub length_above: f64,
    /// `EA`: axial rigidity of the section \[N\].
    pub axial_rigidity: f64,
    /// `EI`: bending stiffness of the section about the axis of bending \[N m²\].
    pub bending_stiffness: f64,
    /// `m_l`: mass per length \[kg/m\].
    pub mass_per_length: f64,
    /// `M^p`: plastic moment without normal force \[N m\].
    pub resistance_moment: f64,
    /// `N^p`: squash load \[N\].
    pub resistance_axial: f64,
    /// Shape of the yield surface of all four hinges (Eq 28).
    pub yield_surface: YieldExponents,
    /// Relation between the moments of a bar's two hinges and their rotations.
    pub elastic_law: ElasticLaw,
    /// Rotational support of the foot (hinge 3).
    pub base: Support,
    /// Rotational support of the head (hinge 2).
    pub top: Support,
    /// Rotational stiffness of the hinges 1a, 1b, 2, 3 given directly \[N m/rad\]; `None` follows from the
    /// supports. Only with [`ElasticLaw::Uncoupled`].
    pub hinge_stiffness: [Option<f64>; 4],
    /// `k_s`: stiffness of the vertical spring at the top \[N/m\], >= 0.
    pub top_spring_stiffness: f64,
    /// `m_2`: mass at the top \[kg\], >= 0; 0 makes `u2` an algebraic unknown.
    pub top_mass: f64,
    /// `P`: constant compressive load on the top \[N\], >= 0.
    pub top_load: f64,
    /// Fraction of critical damping of every elastic mode about the column at rest, >= 0; 0 in the paper.
    pub damping_ratio: f64,
    /// Increase of the yield surface with the strain rate; `None` in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<RateProperties>,
    /// `b`: slope of the stress-strain curve after yield over Young's modulus, 0 to 0.1; 0 in the paper.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub hardening_ratio: f64,
    /// Absolute plastic rotation at which a hinge is severed \[rad\], >= 0; 0 for no limit.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ultimate_rotation: f64,
    /// Time-stepping scheme.
    pub scheme: Scheme,
    /// Length of a time step \[ns\]; with 0 the model chooses it from the column's own period.
    pub step_nanos: u64,
}

/// Exponents of the generalised superellipse `(|M/M^p|^alpha + |N/N^p|^beta)^(1/gamma) - 1` (Eq 28).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct YieldExponents {
    /// Of the moment, >= 1.
    pub alpha: f64,
    /// Of the normal force, >= 1.
    pub beta: f64,
    /// Of the sum, > 0; scales the plastic multiplier only, not the surface.
    pub gamma: f64,
}

/// What is switched off is not written, so that a column without it is written as before it existed.
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// How the resistances of a hinge grow with the strain rate of its outer fibre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RateProperties {
    /// Dynamic increase factor as a function of the filtered strain rate.
    pub law: RateLaw,
    /// `tau`: time constant of the low-pass filter through which the strain rate passes \[s\], > 0. Without a filter the
    /// equations of motion are ill-posed, because the laws are infinitely or very steep at zero rate.
    pub time_constant: f64,
    /// Largest dynamic increase factor, >= 1.
    pub max_factor: f64,
    /// `L_h`: length over which the rotation of a hinge is spread \[m\], > 0.
    pub hinge_length: f64,
    /// `h`: height of the section in the plane of bending \[m\], > 0.
    pub section_height: f64,
}

/// Dynamic increase factor of the yield strength as a function of the strain rate `e` \[1/s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RateLaw {
    /// Cowper and Symonds: `1 + (e/D)^(1/q)`.
    CowperSymonds {
        /// `D` \[1/s\], > 0.
        d: f64,
        /// `q`, >= 1.
        q: f64,
    },
    /// `1 + C ln(e/e0)`, not below 1. The form of the CEB, `f_y + 6 MPa ln(e / 5e-5)`, has `C = 6 MPa / f_y`.
    Logarithmic {
        /// `C`, >= 0.
        c: f64,
        /// `e0` \[1/s\], > 0.
        reference: f64,
    },
}

/// Elastic law of a bar's two hinges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElasticLaw {
    /// Independent rotational springs, exact for a rotation of the chord (Eqs 47-48).
    Uncoupled,
    /// The elastic beam, exact for any rotations: `M = EI/L [[4, 2], [2, 4]] theta`.
    Coupled,
}

/// Rotational support of one end of the column.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Support {
    /// No rotation.
    BuiltIn,
    /// No moment.
    Pinned,
    /// A rotational spring in series with the bar's end.
    SemiRigid {
        /// \[N m/rad\], > 0.
        stiffness: f64,
    },
}

/// Time-stepping scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// The paper's midpoint rule as printed (Eqs 40, 44-46).
    Midpoint,
    /// The energy-conserving midpoint rule: discrete gradient, mean stresses, impacts as events. Called `energy` in
    /// version 0.1.
    #[serde(alias = "energy")]
    ConservingMidpoint,
}

/// A column for tests of single parts: without load, damping, hardening and spring at the top.
#[cfg(test)]
pub(crate) const PLAIN_COLUMN: ColumnProperties = ColumnProperties {
    length_below: 1.0,
    length_above: 3.0,
    axial_rigidity: 2e9,
    bending_stiffness: 2e7,
    mass_per_length: 70.0,
    resistance_moment: 3e5,
    resistance_axial: 3e6,
    yield_surface: YieldExponents {
        alpha: 2.0,
        beta: 2.0,
        gamma: 2.0,
    },
    elastic_law: ElasticLaw::Uncoupled,
    base: Support::BuiltIn,
    top: Support::BuiltIn,
    hinge_stiffness: [None; 4],
    top_spring_stiffness: 0.0,
    top_mass: 0.0,
    top_load: 0.0,
    damping_ratio: 0.0,
    rate: None,
    hardening_ratio: 0.0,
    ultimate_rotation: 0.0,
    scheme: Scheme::Midpoint,
    step_nanos: 10_000,
};
