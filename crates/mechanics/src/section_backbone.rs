//! The monotonic backbone of a hinge in a wide-flange section, from regressions over tests.
//!
//! The regressions are those of Lignos, Hartloper, Elkady, Deierlein and Hamburger (2019), "Proposed Updates to the ASCE 41 Nonlinear Modeling Parameters for Wide-Flange Steel Columns in Support of
//! Performance-Based Seismic Engineering", J. Struct. Eng. 145(9), doi 10.1061/(ASCE)ST.1943-541X.0002353.
//!
//! The coefficients are those of two published programs, one of them by an author of the paper: `src/Spring_IMK.tcl` of FM-2D
//! (A. Elkady) and `steelColumnHinge` of ModelerWSMF, which agree \[T\]. The paper itself was not read.

use super::properties::SofteningProperties;
use super::section::RolledSection;

/// Largest `theta_p` \[rad\].
const MAX_CAPPING_ROTATION: f64 = 0.20;

/// Largest `theta_pc` \[rad\].
const MAX_POST_CAPPING_ROTATION: f64 = 0.30;

/// Bounds of `M_max / M_y`.
const CAPPING_STRENGTH: [f64; 2] = [1.0, 1.3];

/// Least rotations of a backbone \[rad\]: where the load comes close to the squash load, the regressions leave none at all.
const LEAST_ROTATION: f64 = 1e-3;

/// What the backbone of a section depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionBackbone {
    /// `n = P / P_ye`: compressive force over squash load, 0 to 1.
    pub axial_ratio: f64,
    /// `L_b / r_y`: unbraced length over the radius of gyration about the weak axis.
    pub member: f64,
    /// `h / t_w`: clear depth of the web over its thickness.
    pub web: f64,
}

impl SectionBackbone {
    /// Of a column of length `length` \[m\] that carries the share `axial_ratio` of its squash load.
    #[must_use]
    pub fn of(section: &RolledSection, length: f64, axial_ratio: f64) -> Self {
        let radius = (section.weak_second_moment() / section.properties().area).sqrt();
        Self {
            axial_ratio: axial_ratio.clamp(0.0, 1.0),
            member: length / radius,
            web: section.clear_web_depth() / section.web_thickness,
        }
    }

    /// `factor (h/t_w)^web (L_b/r_y)^member (1 - n)^rest`.
    fn regression(&self, factor: f64, [web, member, rest]: [f64; 3]) -> f64 {
        factor
            * libm::pow(self.web, web)
            * libm::pow(self.member, member)
            * libm::pow(1.0 - self.axial_ratio, rest)
    }

    /// `theta_p`: plastic rotation at which local buckling begins to lower the moment \[rad\], at most 0.20.
    #[must_use]
    pub fn capping_rotation(&self) -> f64 {
        self.regression(294.0, [-1.7, -0.7, 1.6])
            .min(MAX_CAPPING_ROTATION)
    }

    /// `theta_pc`: plastic rotation from the capping point to zero strength \[rad\], at most 0.30.
    #[must_use]
    pub fn post_capping_rotation(&self) -> f64 {
        self.regression(90.0, [-0.8, -0.8, 2.5])
            .min(MAX_POST_CAPPING_ROTATION)
    }

    /// `M_max / M_y`: moment at the capping point over that at yield, 1 to 1.3.
    #[must_use]
    pub fn capping_strength(&self) -> f64 {
        let [least, most] = CAPPING_STRENGTH;
        self.regression(12.5, [-0.2, -0.4, 0.4]).clamp(least, most)
    }

    /// `M_r / M_y = 0.5 - 0.4 n`: residual moment over that at yield.
    #[must_use]
    pub fn residual_strength(&self) -> f64 {
        0.5 - 0.4 * self.axial_ratio
    }

    /// The softening of a hinge, whose residual counts in the strength at the capping point; of rotations that the load leaves
    /// at least 0.001 rad.
    #[must_use]
    pub fn softening(&self) -> SofteningProperties {
        SofteningProperties {
            capping_rotation: self.capping_rotation().max(LEAST_ROTATION),
            post_capping_rotation: self.post_capping_rotation().max(LEAST_ROTATION),
            residual: self.residual_strength() / self.capping_strength(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed by hand for HEB 220, 4 m, 500 kN on a squash load of 3232 kN.
    #[test]
    fn the_backbone_of_heb_220() {
        let heb220 = RolledSection {
            depth: 0.220,
            width: 0.220,
            web_thickness: 0.0095,
            flange_thickness: 0.016,
            root_radius: 0.018,
        };
        let backbone = SectionBackbone::of(&heb220, 4.0, 500.0 / 3232.0);
        assert!((backbone.web - 16.0).abs() < 1e-9);
        assert!((backbone.member - 71.6).abs() < 0.1, "{}", backbone.member);
        for (found, expected) in [
            (backbone.capping_rotation(), 0.1013),
            (backbone.post_capping_rotation(), 0.2108),
            (backbone.capping_strength(), 1.214),
            (backbone.residual_strength(), 0.4381),
            (backbone.softening().residual, 0.3609),
        ] {
            assert!((found / expected - 1.0).abs() < 5e-3, "{found} {expected}");
        }
    }

    #[test]
    fn a_section_at_its_squash_load_has_next_to_no_backbone() {
        let backbone = SectionBackbone {
            axial_ratio: 1.0,
            member: 70.0,
            web: 20.0,
        };
        let softening = backbone.softening();
        assert_eq!(softening.capping_rotation, LEAST_ROTATION);
        assert_eq!(softening.post_capping_rotation, LEAST_ROTATION);
        assert!((softening.residual - 0.1).abs() < 1e-12);
    }
}
