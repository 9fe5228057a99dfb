//! Limits of the plastic rotation of a hinge in an I or H section.

use crate::column::{RolledSection, SectionBackbone};

/// `theta_u`: plastic rotation at which a section tears \[rad\] (Lignos et al. 2019).
pub const ULTIMATE_ROTATION: f64 = 0.15;

/// What the limits depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeSlenderness {
    /// `n = P / P_ye`: compressive force over squash load, 0 to 1.
    pub axial_ratio: f64,
    /// `q = L / r_y`: length over the radius of gyration about the weak axis.
    pub member: f64,
    /// `w = h / t_w`: clear depth of the web over its thickness.
    pub web: f64,
}

/// Plastic rotations of a hinge \[rad\]: `a` at which its strength begins to fall, `b` at which it has lost it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationLimits {
    /// `a`.
    pub a: f64,
    /// `b`.
    pub b: f64,
}

impl HingeSlenderness {
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

    /// The monotonic backbone of Lignos et al. (2019), of which [`capping_rotation`](Self::capping_rotation) is a part.
    #[must_use]
    pub fn backbone(&self) -> SectionBackbone {
        SectionBackbone {
            axial_ratio: self.axial_ratio,
            member: self.member,
            web: self.web,
        }
    }

    fn rest(&self) -> f64 {
        1.0 - self.axial_ratio
    }

    /// ASCE/SEI 41-17, table 9-6, for compact sections; not below 0.
    #[must_use]
    pub fn asce41(&self) -> RotationLimits {
        let Self { member, web, .. } = *self;
        let rest = self.rest();
        RotationLimits {
            a: (0.8 * libm::pow(rest, 2.2) / (0.1 * member + 0.8 * web) - 0.0035).max(0.0),
            b: (7.4 * libm::pow(rest, 2.3) / (0.5 * member + 2.9 * web) - 0.006).max(0.0),
        }
    }

    /// ANSI/AISC 342-21, table C3.6; at most 0.07 rad.
    #[must_use]
    pub fn aisc342(&self) -> RotationLimits {
        let Self { member, web, .. } = *self;
        let (rest, root) = (self.rest(), member.sqrt());
        RotationLimits {
            a: (5.5 * libm::pow(web, -0.95) / root * libm::pow(rest, 2.4)).min(0.07),
            b: (20.0 * libm::pow(web, -0.9) / root * libm::pow(rest, 3.4)).min(0.07),
        }
    }

    /// `theta_p` of a monotonic push (Lignos et al. 2019) \[rad\], at most 0.20: the plastic rotation at which local buckling
    /// begins to lower the moment.
    #[must_use]
    pub fn capping_rotation(&self) -> f64 {
        self.backbone().capping_rotation()
    }
}

/// Why the limits do not apply to a section with yield strength `yield_strength` \[Pa\]: it is not of class 1 or 2 in
/// compression (EN 1993-1-1:2005, table 5.2; recalled, not verified). `None` if they apply.
#[must_use]
pub fn not_compact(section: &RolledSection, yield_strength: f64) -> Option<String> {
    const FLANGE: f64 = 10.0;
    const WEB: f64 = 38.0;
    let epsilon = (235e6 / yield_strength).sqrt();
    let outstand = 0.5 * (section.width - section.web_thickness) - section.root_radius;
    let flange = outstand / section.flange_thickness / epsilon;
    let web = section.clear_web_depth() / section.web_thickness / epsilon;
    let (part, found, limit) = match (flange > FLANGE, web > WEB) {
        (true, _) => ("flange", flange, FLANGE),
        (_, true) => ("web", web, WEB),
        _ => return None,
    };
    Some(format!(
        "the section is not compact: c/t of its {part} is {found:.1} epsilon, above the {limit:.0} epsilon of class 2 [M]; it \
         buckles locally before it can rotate"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::CatalogueSection;

    fn section(name: &str) -> RolledSection {
        CatalogueSection::named(name).expect("a section").dimensions
    }

    /// Computed independently for HEB 220, 4 m, 500 kN on a squash load of 3232 kN.
    #[test]
    fn limits_of_heb_220() {
        let hinge = HingeSlenderness::of(&section("HEB220"), 4.0, 500.0 / 3232.0);
        for (found, expected, digit) in [
            (hinge.asce41().a, 0.0242, 5e-5),
            (hinge.asce41().b, 0.0552, 5e-5),
            (hinge.aisc342().a, 0.031, 5e-4),
            (hinge.aisc342().b, 0.070, 1e-12),
            (hinge.capping_rotation(), 0.101, 5e-4),
        ] {
            assert!((found - expected).abs() <= digit, "{found} {expected}");
        }
    }

    #[test]
    fn limits_fall_with_the_axial_force_down_to_zero() {
        let limits = |n| {
            let hinge = HingeSlenderness::of(&section("HEB220"), 4.0, n);
            let (asce, aisc) = (hinge.asce41(), hinge.aisc342());
            [asce.a, asce.b, aisc.a, aisc.b, hinge.capping_rotation()]
        };
        let mut before = limits(0.0);
        for k in 1..=10 {
            let here = limits(0.1 * f64::from(k));
            for (here, before) in here.iter().zip(before) {
                assert!(*here >= 0.0 && *here <= before);
            }
            before = here;
        }
        assert_eq!(before, [0.0; 5]);
        assert_eq!(limits(1.7), limits(1.0));
    }

    #[test]
    fn slender_sections_have_no_limits() {
        assert_eq!(not_compact(&section("HEB220"), 355e6), None);
        let reason = not_compact(&section("HEA280"), 460e6).expect("class 3");
        assert!(reason.contains("flange"), "{reason}");
        let reason = not_compact(&section("IPE600"), 355e6).expect("a slender web");
        assert!(reason.contains("web"), "{reason}");
    }
}
