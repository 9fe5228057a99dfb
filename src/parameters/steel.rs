//! Structural steel grades.

/// A grade with its nominal values.
///
/// Yield strengths are those of EN 1993-1-1:2005, table 3.1, for thicknesses up to 40 mm, which is the maximum flange
/// thickness of the catalogue (S235 to S355: EN 10025-2; S420, S460: EN 10025-3 N/NL and 10025-4 M/ML).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteelGrade {
    /// Such as `S355`.
    pub name: &'static str,
    /// `E` \[Pa\] (EN 1993-1-1, 3.2.6).
    pub young_modulus: f64,
    /// `f_y` \[Pa\].
    pub yield_strength: f64,
    /// `f_u`: ultimate strength \[Pa\] (EN 1993-1-1:2005 with AC:2009, table 3.1,
    /// as the open-source library Blueprints states it in `chapter_3_materials/table_3_1.py`).
    pub ultimate_strength: f64,
}

/// Every grade known by name, weakest first.
pub const STEEL_GRADES: &[SteelGrade] = &[
    grade("S235", 235e6, 360e6),
    grade("S275", 275e6, 430e6),
    grade("S355", 355e6, 490e6),
    grade("S420", 420e6, 520e6),
    grade("S460", 460e6, 540e6),
];

/// Increase of the yield strength with the natural logarithm of the strain rate in the form of the CEB,
/// `f_y + 6 MPa ln(e / 5e-5)` \[Pa\] (recalled, not verified).
pub(super) const CEB_STRENGTH_PER_LOG_RATE: f64 = 6e6;

/// Largest dynamic increase factor by yield strength \[Pa\], an assumption of this project: the stronger a steel, the less
/// it gains with the strain rate.
const RATE_FACTOR_CAPS: [[f64; 2]; 3] = [[235e6, 1.35], [355e6, 1.25], [460e6, 1.15]];

/// The largest dynamic increase factor of a steel of this yield strength \[Pa\]: linear between the grades, constant beyond
/// the weakest and the strongest.
pub(super) fn rate_factor_cap(yield_strength: f64) -> f64 {
    let [weakest, .., strongest] = RATE_FACTOR_CAPS;
    if yield_strength <= weakest[0] {
        return weakest[1];
    }
    for pair in RATE_FACTOR_CAPS.windows(2) {
        let [[low, above], [high, below]] = [pair[0], pair[1]];
        if yield_strength <= high {
            return above + (below - above) * (yield_strength - low) / (high - low);
        }
    }
    strongest[1]
}

/// The least `f_u/f_y` of structural steel (EN 1993-1-1, 3.2.2; recalled, not verified), for steel without a named grade.
const LEAST_STRENGTH_RATIO: f64 = 1.1;

/// `f_u/f_y` of the steel of this grade with this yield strength \[Pa\], where 0 is that of the grade; 1 where the yield
/// strength exceeds the ultimate strength of the grade.
pub(super) fn strength_ratio(grade: &str, yield_strength: f64) -> f64 {
    let Some(grade) = SteelGrade::named(grade) else {
        return LEAST_STRENGTH_RATIO;
    };
    let yield_strength = match yield_strength > 0.0 {
        true => yield_strength,
        false => grade.yield_strength,
    };
    (grade.ultimate_strength / yield_strength).max(1.0)
}

const fn grade(name: &'static str, yield_strength: f64, ultimate_strength: f64) -> SteelGrade {
    SteelGrade {
        name,
        young_modulus: 210e9,
        yield_strength,
        ultimate_strength,
    }
}

impl SteelGrade {
    /// The grade of this name, in any case and with or without spaces.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        let wanted: String = name.split_whitespace().collect();
        STEEL_GRADES
            .iter()
            .find(|grade| grade.name.eq_ignore_ascii_case(&wanted))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_case() {
        assert_eq!(
            SteelGrade::named(" s 355").map(|grade| grade.yield_strength),
            Some(355e6)
        );
        assert_eq!(SteelGrade::named("S350"), None);
        assert_eq!(SteelGrade::named(""), None);
    }

    #[test]
    fn a_steel_hardens_up_to_its_ultimate_strength() {
        assert_eq!(strength_ratio("S355", 0.0), 490.0 / 355.0);
        assert_eq!(strength_ratio("s 235", 240e6), 1.5);
        assert_eq!(strength_ratio("S235", 400e6), 1.0);
        assert_eq!(strength_ratio("", 355e6), 1.1);
    }

    #[test]
    fn the_cap_of_the_rate_factor_falls_with_the_strength() {
        for (yield_strength, cap) in [
            (200e6, 1.35),
            (235e6, 1.35),
            (295e6, 1.30),
            (355e6, 1.25),
            (407.5e6, 1.20),
            (460e6, 1.15),
            (690e6, 1.15),
        ] {
            assert!((rate_factor_cap(yield_strength) - cap).abs() < 1e-12);
        }
    }

    #[test]
    fn a_grade_is_named_after_its_strength() {
        for grade in STEEL_GRADES {
            assert_eq!(format!("S{}", grade.yield_strength / 1e6), grade.name);
        }
    }
}
