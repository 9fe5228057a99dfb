//! The properties of a column as an engineer gives them: numbers in SI units, from which the model is derived.

use serde::{Deserialize, Serialize};

use super::base_resistance::BaseResistance;

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
    /// `k_s`: stiffness of the vertical spring at the top \[N/m\], >= 0; 0 if the top is free.
    pub top_spring_stiffness: f64,
    /// `m_2`: mass at the top \[kg\], >= 0; 0 makes `u2` an algebraic unknown, and so does a free top, with which it sways.
    pub top_mass: f64,
    /// `P`: constant compressive load on the top \[N\], >= 0; 0 if the top is free.
    pub top_load: f64,
    /// Fraction of critical damping of every elastic mode about the column at rest, >= 0; 0 in the paper.
    pub damping_ratio: f64,
    /// Increase of the yield surface with the strain rate; `None` in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<RateProperties>,
    /// `b`: slope of the stress-strain curve after yield over Young's modulus, 0 to 0.1; 0 in the paper.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub hardening_ratio: f64,
    /// How a hinge loses strength once its flanges and web buckle locally; `None` in the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub softening: Option<SofteningProperties>,
    /// What the plate and the anchors of the base bear, which caps the moment of hinge 3 and the shear of the lower bar: beyond it the
    /// foot slips. `None` in the paper: the base bears what the section does, and never slips.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_connection: Option<BaseResistance>,
    /// Absolute plastic rotation at which a hinge is fractured, of hinges 1a and 1b together \[rad\], >= 0; 0 for no limit.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ultimate_rotation: f64,
    /// Shear of the web of each bar; `None` in the paper: the web neither yields nor deforms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear: Option<ShearProperties>,
    /// Time-stepping scheme.
    pub scheme: Scheme,
    /// Length of a time step \[ns\]; with 0 the model chooses it from the column's own period.
    pub step_nanos: u64,
}

/// How the moment of a hinge falls with its accumulated plastic rotation, as the monotonic backbone of Lignos et al. (2019):
/// from the strength at the capping rotation along a line that would reach zero over the post-capping rotation, down to a
/// residual. Hardening ends at the capping rotation.
///
/// The rotations are those of a whole hinge, so that the law needs no length over which it is regularised: it has no mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SofteningProperties {
    /// `theta_p`: accumulated plastic rotation at which the strength begins to fall \[rad\], > 0.
    pub capping_rotation: f64,
    /// `theta_pc`: further plastic rotation over which it would fall to zero \[rad\], > 0.
    pub post_capping_rotation: f64,
    /// Strength that remains, relative to that at the capping rotation, 0 to 1.
    pub residual: f64,
}

/// How the web of each bar yields in shear: a plastic slider in series with the two hinges of the bar,
/// `|M_i + M_j| / l <= V_s` with `V_s = V_w + 2 m_f / l`. [`RolledSection::shear`](super::RolledSection::shear) computes
/// the numbers of a section.
///
/// `l`, the clear length, is the length of the bar less half the height of the bumper. It also replaces the length of the
/// bar in its elastic law, its hardening and the geometry of its chord: behind a bumper the column does not deform.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ShearProperties {
    /// `V_w = (f_y/sqrt 3) t_w (h - t_f)`: resistance of the web \[N\], > 0.
    pub web_resistance: f64,
    /// `m_f = b t_f^2 f_y / 4`: plastic moment of one flange about its own axis \[N m\], >= 0. Both flanges bend with the
    /// sheared web and bear `2 m_f / l`.
    pub flange_moment: f64,
    /// `G A_s`: elastic shear rigidity \[N\], >= 0, `A_s = t_w (h - t_f)`; 0 for a beam without elastic shear (Euler).
    pub rigidity: f64,
    /// `t_w (h - t_f) E_h / 3`: growth of the resistance of the web with its accumulated plastic shear angle \[N/rad\],
    /// >= 0; 0 for none.
    pub hardening: f64,
    /// Largest strength of the hardened web over its initial one, >= 1, or 0 for no cap. Once it is reached, the web is
    /// perfectly plastic.
    pub max_hardening: f64,
    /// Absolute plastic shear angle at which the web of a bar is fractured \[rad\], >= 0; 0 for no limit.
    pub ultimate_angle: f64,
    /// Height of the bumper, over which the column is held straight about the impact point \[m\], >= 0, and at most 1.8 times
    /// the length of the shorter bar; 0 for a force at a point.
    pub bumper_height: f64,
}

impl ShearProperties {
    /// `V_s` of a bar of clear length `length` \[m\], new and at rest \[N\].
    #[must_use]
    pub fn resistance(&self, length: f64) -> f64 {
        self.web_resistance + 2.0 * self.flange_moment / length
    }
}

impl ColumnProperties {
    /// The same column of a steel that hardens otherwise: its hinges, and its webs, whose elastic rigidity tells their area; a
    /// web that is rigid until it yields does not harden. `poisson_ratio` is that of the steel.
    #[must_use]
    pub fn with_hardening(&self, hardening_ratio: f64, poisson_ratio: f64) -> Self {
        let shear = self.shear.map(|shear| ShearProperties {
            hardening: shear.rigidity * 2.0 * (1.0 + poisson_ratio) * hardening_ratio / 3.0,
            ..shear
        });
        Self {
            hardening_ratio,
            shear,
            ..*self
        }
    }

    /// The same column upon a base plate: its foot turns with the initial stiffness of the plate where it was built in, and bears no
    /// more moment than the plate does.
    #[must_use]
    pub fn on_plate(&self, plate: BaseResistance) -> Self {
        let base = match self.base {
            Support::BuiltIn => Support::SemiRigid {
                stiffness: plate.stiffness,
            },
            given => given,
        };
        Self {
            base,
            base_connection: Some(plate),
            ..*self
        }
    }

    /// Lengths over which the bars below and above the impact point deform \[m\]: without the half of the bumper that lies
    /// before each of them. Without [`shear`](Self::shear) they are the whole lengths.
    ///
    /// Nothing turns a cantilever back behind a bumper, so that it deforms over the whole length below the impact point.
    #[must_use]
    pub fn clear_lengths(&self) -> [f64; 2] {
        let covered = match self.top {
            Support::Free => 0.0,
            _ => self.shear.map_or(0.0, |shear| 0.5 * shear.bumper_height),
        };
        [self.length_below - covered, self.length_above - covered]
    }
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

/// What is as at the beginning is not written, so that a column without it is written as before it existed.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// What is switched off is not written, so that a column without it is written as before it existed.
pub(crate) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// The factor that changes nothing.
pub(crate) fn one() -> f64 {
    1.0
}

/// As [`is_zero`], for factors.
pub(crate) fn is_one(number: &f64) -> bool {
    *number == 1.0
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

impl RateLaw {
    /// Dynamic increase factor at a strain rate \[1/s\], >= 1 and without an upper limit.
    #[must_use]
    pub fn factor(&self, rate: f64) -> f64 {
        match *self {
            Self::CowperSymonds { d, q } if rate > 0.0 => 1.0 + libm::exp(libm::log(rate / d) / q),
            Self::Logarithmic { c, reference } if rate > reference => {
                1.0 + c * libm::log(rate / reference)
            }
            Self::CowperSymonds { .. } | Self::Logarithmic { .. } => 1.0,
        }
    }
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
    /// Of the top only: nothing holds it, across the column either. The column is a cantilever, as a bollard is; above the
    /// impact point it follows straight and carries nothing.
    Free,
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
    softening: None,
    base_connection: None,
    ultimate_rotation: 0.0,
    shear: None,
    scheme: Scheme::Midpoint,
    step_nanos: 10_000,
};
