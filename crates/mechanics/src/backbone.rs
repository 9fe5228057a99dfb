//! The strength of a hinge over its accumulated plastic rotation.
//!
//! Yielding that spreads along a bar of length `L` with a linear moment and the slope `b E` after yield lets the strength grow
//! by `H = 1 + sqrt(4 b EI theta_p / (L M^p))`. Steel that hardens does so in tension, compression and bending alike: `H`
//! enlarges the whole yield surface, as the strain rate does.
//!
//! From the capping rotation on the flanges and the web buckle locally. The strength then falls by the factor `S` of the moment
//! alone, because the backbones that were measured are moments at a held normal force:
//! `S = max(1 - (theta_p - theta_cap) / theta_pc, residual)`. The rotation is the accumulated one, whatever its direction: a
//! buckle does not straighten when the hinge turns back.
//!
//! `S` is held over one part of a step, at the rotation that is expected at its end if the hinge goes on to flow as it did, so
//! that each part stays convex. A stress of the beginning that lies outside of the smaller surface is returned to it, and the
//! elastic energy that this sets free is plastic work like any other.
//!
//! Over one part of a step `H` is that of its beginning, and the moments alone grow with the rotation of the part: along the
//! secant of the whole surface at the normal force of the beginning. That keeps the return of a stress convex in one scalar, and
//! settles in what proportion two hinges in series (1a and 1b) share a rotation; the rest is an error of the first order of the
//! length of the part.

use serde::{Deserialize, Serialize};

use super::bar::{Bar, BarForces};
use super::bar_strength::BarStrength;
use super::properties::{ColumnProperties, SofteningProperties, is_one, one};
use super::shear::SliderStrength;
use super::yield_surface::YieldSurface;

/// Least factor of the moment that softening leaves: a hinge without any strength at all would have no yield surface.
const LEAST_STRENGTH: f64 = 0.01;

/// Factors of the resistances of one hinge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HingeFactors {
    /// `D`: dynamic increase factor of `M^p` and `N^p`, >= 1.
    pub dynamic: f64,
    /// `H`: hardening factor of `M^p` and `N^p`, >= 1.
    pub hardening: f64,
    /// Factor of `M^p` alone, > 0: what softening has left, and what hardening has added over the last part of a step.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub moment: f64,
}

impl Default for HingeFactors {
    fn default() -> Self {
        Self {
            dynamic: 1.0,
            hardening: 1.0,
            moment: 1.0,
        }
    }
}

impl HingeFactors {
    /// Moment \[N m\] and normal force \[N\] that use the undamaged surface as much as the given ones use the enlarged one.
    pub(crate) fn reduced(&self, moment: f64, normal_force: f64) -> (f64, f64) {
        let whole = self.whole();
        (moment / (whole * self.moment), normal_force / whole)
    }

    /// Factor of the whole yield surface.
    pub(crate) fn whole(&self) -> f64 {
        self.dynamic * self.hardening
    }

    /// With no more moment than `most` \[N m\] at a held normal force \[N\]; `surface` is the undamaged one.
    pub(crate) fn capped(self, surface: &YieldSurface, normal_force: f64, most: f64) -> Self {
        let whole = self.whole();
        let of_section = whole * surface.moment_resistance(normal_force / whole);
        if self.moment * of_section <= most {
            return self;
        }
        Self {
            moment: (most / of_section).max(LEAST_STRENGTH),
            ..self
        }
    }

    /// What softening has left of the moment of either of two hinges, at most 1.
    pub(crate) fn softest(hinges: [&Self; 2]) -> f64 {
        hinges[0].moment.min(hinges[1].moment).min(1.0)
    }

    /// Factor of the whole yield surface of the weaker of two hinges.
    pub(crate) fn weakest(hinges: [&Self; 2]) -> f64 {
        hinges[0].whole().min(hinges[1].whole())
    }

    pub(crate) fn largest(&self, other: &Self) -> Self {
        Self {
            dynamic: self.dynamic.max(other.dynamic),
            hardening: self.hardening.max(other.hardening),
            moment: self.moment.max(other.moment),
        }
    }
}

/// How the strength of the hinges of one bar depends on their accumulated plastic rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Backbone {
    /// `4 b EI / (L M^p)` \[1/rad\].
    hardening: f64,
    softening: Option<SofteningProperties>,
}

/// The strength of both hinges of a bar without strain rate, over one increment of a push-down.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StaticStrength {
    /// At its beginning.
    pub factors: [HingeFactors; 2],
    /// Growth of the moments, relative to them, with the plastic rotation \[1/rad\].
    pub growth: [f64; 2],
}

impl Backbone {
    /// Of a bar of length `length` \[m\].
    pub fn new(p: &ColumnProperties, length: f64) -> Self {
        let b = p.hardening_ratio;
        Self {
            hardening: 4.0 * b * p.bending_stiffness / (length * p.resistance_moment),
            softening: p.softening,
        }
    }

    /// Whether no rotation changes the strength.
    pub fn is_constant(&self) -> bool {
        self.hardening == 0.0 && self.softening.is_none()
    }

    /// The factors of a hinge with the dynamic increase factor `dynamic` after an accumulated plastic rotation \[rad\], softened
    /// as after the rotation `expected` \[rad\] more.
    pub fn factors(&self, dynamic: f64, accumulated: f64, expected: f64) -> HingeFactors {
        HingeFactors {
            dynamic,
            hardening: self.hardened(accumulated),
            moment: self.softened(accumulated + expected),
        }
    }

    /// `S` after an accumulated plastic rotation \[rad\]: factor of the moment, <= 1.
    fn softened(&self, accumulated: f64) -> f64 {
        let Some(softening) = &self.softening else {
            return 1.0;
        };
        let beyond = (accumulated - softening.capping_rotation).max(0.0);
        let left = 1.0 - beyond / softening.post_capping_rotation;
        left.max(softening.residual).max(LEAST_STRENGTH)
    }

    /// The accumulated rotation up to which a hinge hardens \[rad\].
    fn capping_rotation(&self) -> f64 {
        self.softening
            .map_or(f64::INFINITY, |softening| softening.capping_rotation)
    }

    /// The strength of both hinges without strain rate; see [`StrengthLaw::at_rest`](super::rate::StrengthLaw::at_rest).
    pub fn at_rest(
        &self,
        accumulated: [f64; 2],
        expected: [f64; 2],
        (surface, normal): (&YieldSurface, f64),
    ) -> StaticStrength {
        let factors = accumulated.map(|accumulated| self.factors(1.0, accumulated, 0.0));
        StaticStrength {
            growth: [0, 1]
                .map(|k| self.growth(accumulated[k], expected[k], (surface, normal), &factors[k])),
            factors,
        }
    }

    /// `H` after an accumulated plastic rotation \[rad\]: factor of the whole surface, >= 1.
    fn hardened(&self, accumulated: f64) -> f64 {
        if self.hardening == 0.0 {
            return 1.0;
        }
        1.0 + (self.hardening * accumulated.min(self.capping_rotation())).sqrt()
    }

    /// How the moment of a hinge grows, relative to it, over the next plastic rotations \[1/rad\]: along the secant of its
    /// hardening over the rotation `expected` \[rad\], while it bears the normal force `normal` \[N\] with the factors `factors` of the undamaged
    /// surface `surface`.
    /// 0 where no rotation is expected.
    pub fn growth(
        &self,
        accumulated: f64,
        expected: f64,
        (surface, normal): (&YieldSurface, f64),
        factors: &HingeFactors,
    ) -> f64 {
        if self.hardening == 0.0 {
            return 0.0;
        }
        // (sqrt(h (a + e)) - sqrt(h a)) / e without cancellation.
        let before = (self.hardening * accumulated).sqrt();
        let (whole, capping) = (accumulated + expected, self.capping_rotation());
        let (end, share) = match whole <= capping {
            true => (whole, 1.0),
            false => (capping, (capping - accumulated).max(0.0) / expected),
        };
        let sum = (self.hardening * end).sqrt() + before;
        if sum > 0.0 && expected > 0.0 {
            let slope = self.hardening / sum * share;
            slope / (1.0 + before) * surface.moment_gain(normal / factors.whole())
        } else {
            0.0
        }
    }
}

impl StaticStrength {
    /// Factor of the whole yield surface of the weaker hinge.
    pub fn weakest(&self) -> f64 {
        let [first, second] = &self.factors;
        HingeFactors::weakest([first, second])
    }

    /// Largest utilisation of a hinge under these forces.
    pub fn utilisation(&self, bar: &Bar, forces: &BarForces) -> f64 {
        let of = |k: usize| {
            let (moment, normal) = self.factors[k].reduced(forces.moment[k], forces.normal);
            bar.surface.utilisation(moment, normal)
        };
        of(0).max(of(1))
    }

    /// That of the bar, of whose hinges those in `held` bear `factor` times as much as they do.
    pub fn with_held(&self, held: [bool; 2], factor: f64) -> Option<BarStrength> {
        let whole = [0, 1].map(|k| self.factors[k].whole() * if held[k] { factor } else { 1.0 });
        let moment = self.factors.map(|factors| factors.moment);
        BarStrength::new(whole, moment, self.growth, SliderStrength::UNDAMAGED)
    }
}
