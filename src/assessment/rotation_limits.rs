//! Limits of the plastic rotation of a hinge in an I or H section.

use super::section_class::{SectionClass, section_class};
use crate::column::{RolledSection, SectionBackbone};

/// `theta_u`: plastic rotation at which a section fractures \[rad\] (Lignos et al. 2019).
pub const ULTIMATE_ROTATION: f64 = 0.15;

/// Plastic shear angle at which a web is fractured unless the user gives another \[rad\]: the rotation `b` at which a link of an
/// eccentrically braced frame that yields in shear has lost its strength (ASCE/SEI 41-17; recalled, not verified: an assumption on the safe side).
pub const ULTIMATE_SHEAR_ANGLE: f64 = 0.17;

/// Plastic rotation that a hinge in a section of class 3 is granted before its plates buckle, without a normal force \[rad\]: an
/// assumption. The code grants none. Measured columns do rotate: ASCE 41-06, table 5-6, lets the columns of its middle class
/// turn once more by the rotation at which they yield \[M\], which is 0.01 rad for stocky columns of ordinary steel and more
/// for the others.
pub const CLASS_3_ROTATION: f64 = 0.01;

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
        let SectionBackbone {
            axial_ratio,
            member,
            web,
        } = SectionBackbone::of(section, length, axial_ratio);
        Self {
            axial_ratio,
            member,
            web,
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

/// The plastic rotation at which local buckling begins to lower the moment of a hinge \[rad\], whatever the class of the
/// section: [`HingeSlenderness::capping_rotation`] for classes 1 and 2, at most [`CLASS_3_ROTATION`] for class 3, none for
/// class 4.
///
/// `length` is that of the column \[m\], `axial_ratio` the share of the squash load that it carries in compression.
#[must_use]
pub fn rotation_before_buckling(
    section: &RolledSection,
    yield_strength: f64,
    length: f64,
    axial_ratio: f64,
) -> f64 {
    let hinge = HingeSlenderness::of(section, length, axial_ratio);
    let capping = hinge.capping_rotation();
    match section_class(section, yield_strength, axial_ratio).class {
        SectionClass::One | SectionClass::Two => capping,
        SectionClass::Three => capping.min(CLASS_3_ROTATION * hinge.rest()),
        SectionClass::Four => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{CatalogueSection, catalogue};

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

    /// A section of a higher grade buckles sooner, and so does one with thinner plates.
    #[test]
    fn a_section_that_buckles_sooner_rotates_less() {
        const GRADES: [f64; 5] = [235e6, 275e6, 355e6, 420e6, 460e6];
        for it in catalogue() {
            for (length, ratio) in [(3.0, 0.0), (4.0, 0.2), (4.0, 0.5), (6.0, 0.8)] {
                let limit = |section: &RolledSection, strength: f64| {
                    rotation_before_buckling(section, strength, length, ratio)
                };
                let mut before = f64::INFINITY;
                for strength in GRADES {
                    let here = limit(&it.dimensions, strength);
                    assert!((0.0..=before).contains(&here), "{} {strength}", it.name);
                    before = here;
                    let (mut web, mut flange) = (it.dimensions, it.dimensions);
                    web.web_thickness *= 0.9;
                    flange.flange_thickness *= 0.9;
                    assert!(limit(&web, strength) <= here, "{}", it.name);
                    // Under the same force: less of the area is that of the flanges.
                    let area = |section: &RolledSection| section.properties().area;
                    let ratio = ratio * area(&it.dimensions) / area(&flange);
                    let thinner = rotation_before_buckling(&flange, strength, length, ratio);
                    assert!(thinner <= here, "{}", it.name);
                }
            }
        }
    }

    #[test]
    fn the_classes_have_their_limits() {
        let limit =
            |name, strength, ratio| rotation_before_buckling(&section(name), strength, 4.0, ratio);
        let compact = HingeSlenderness::of(&section("HEB220"), 4.0, 0.2).capping_rotation();
        assert_eq!(limit("HEB220", 355e6, 0.2), compact);
        // Class 3 by its flange, class 4 by its web in nearly pure compression.
        assert!((limit("HEA280", 355e6, 0.2) - 0.008).abs() < 1e-15);
        assert_eq!(limit("IPE300", 355e6, 1.0), 0.0);
    }
}
