//! The class of a section: whether its plates buckle before it can rotate (EN 1993-1-1:2005, 5.5 and table 5.2, as
//! the open-source library metku of Tampere University states it in `eurocodes/en1993/en1993_1_1.py`).

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::column::RolledSection;

/// What a hinge in a section can do before its plates buckle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SectionClass {
    /// It rotates plastically as far as plastic analysis asks for.
    One,
    /// It reaches its plastic moment and rotates little beyond.
    Two,
    /// It reaches its yield stress and buckles before its plastic moment.
    Three,
    /// It buckles before its yield stress.
    Four,
}

/// The class of a section under a normal force, and the plate that decides it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionClassification {
    /// The class: that of the weaker plate.
    pub class: SectionClass,
    /// The plate that decides: `flange` or `web`.
    pub plate: &'static str,
    /// Its `c / t`, over `epsilon`.
    pub slenderness: f64,
    /// The largest `c / t` over `epsilon` of the class before, which it exceeds; that of class 1 for class 1.
    pub limit: f64,
}

/// Yield strength for which `epsilon` is 1 \[Pa\].
const REFERENCE_STRENGTH: f64 = 235e6;

/// Limits of `c / t` over `epsilon` of classes 1, 2 and 3 for the outstand of a flange in compression.
const FLANGE_LIMITS: [f64; 3] = [9.0, 10.0, 14.0];

impl SectionClass {
    const ALL: [Self; 4] = [Self::One, Self::Two, Self::Three, Self::Four];
}

/// Classifies a section of yield strength `yield_strength` \[Pa\] that is bent about its strong axis and carries the share
/// `axial_ratio` of its squash load `A f_y` in compression; tension counts as none, on the safe side.
#[must_use]
pub fn section_class(
    section: &RolledSection,
    yield_strength: f64,
    axial_ratio: f64,
) -> SectionClassification {
    let epsilon = (REFERENCE_STRENGTH / yield_strength).sqrt();
    let outstand = 0.5 * (section.width - section.web_thickness) - section.root_radius;
    let flange = classify(
        "flange",
        outstand / section.flange_thickness / epsilon,
        FLANGE_LIMITS,
    );
    let depth = section.clear_web_depth();
    let web_share = depth * section.web_thickness / section.properties().area;
    let web = classify(
        "web",
        depth / section.web_thickness / epsilon,
        web_limits(axial_ratio.clamp(0.0, 1.0), web_share),
    );
    match web.class > flange.class {
        true => web,
        false => flange,
    }
}

/// Limits of `c / t` over `epsilon` of classes 1, 2 and 3 for a web in bending and compression, whose area is the share
/// `web_share` of that of the section.
fn web_limits(axial_ratio: f64, web_share: f64) -> [f64; 3] {
    // The compressed share of the web with plastic stresses, and the ratio of the stresses at its edges with elastic ones.
    let compressed = (0.5 * (1.0 + axial_ratio / web_share)).min(1.0);
    let edges = 2.0 * axial_ratio - 1.0;
    let plastic = |over_half: f64, below_half: f64| match compressed > 0.5 {
        true => over_half / (13.0 * compressed - 1.0),
        false => below_half / compressed,
    };
    let elastic = match edges > -1.0 {
        true => 42.0 / (0.67 + 0.33 * edges),
        false => 62.0 * (1.0 - edges) * (-edges).sqrt(),
    };
    [plastic(396.0, 36.0), plastic(456.0, 41.5), elastic]
}

fn classify(plate: &'static str, slenderness: f64, limits: [f64; 3]) -> SectionClassification {
    let exceeded = limits.iter().filter(|limit| slenderness > **limit).count();
    SectionClassification {
        class: SectionClass::ALL[exceeded],
        plate,
        slenderness,
        limit: limits[exceeded.saturating_sub(1)],
    }
}

impl Display for SectionClass {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::One => "1",
            Self::Two => "2",
            Self::Three => "3",
            Self::Four => "4",
        })
    }
}

/// Such as `class 3 [T]: c/t of its flange is 12.3 epsilon, above the 10 epsilon of the class before`.
impl Display for SectionClassification {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            class,
            plate,
            slenderness,
            limit,
        } = self;
        let side = match class {
            SectionClass::One => "within the",
            _ => "above the",
        };
        let of = match class {
            SectionClass::One => "of that class",
            _ => "of the class before",
        };
        write!(
            f,
            "class {class} [T]: c/t of its {plate} is {slenderness:.1} epsilon, {side} {limit:.1} epsilon {of}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{CatalogueSection, catalogue};

    fn section(name: &str) -> RolledSection {
        CatalogueSection::named(name).expect("a section").dimensions
    }

    fn class(name: &str, strength: f64, axial_ratio: f64) -> SectionClass {
        section_class(&section(name), 1e6 * strength, axial_ratio).class
    }

    /// Classes that tables of sections print: pure bending and pure compression.
    #[test]
    fn classes_of_published_tables() {
        for (name, strength, bending, compression) in [
            ("HEB220", 355.0, SectionClass::One, SectionClass::One),
            ("HEA280", 235.0, SectionClass::One, SectionClass::One),
            ("HEA280", 355.0, SectionClass::Three, SectionClass::Three),
            ("HEA200", 355.0, SectionClass::Two, SectionClass::Two),
            ("IPE300", 235.0, SectionClass::One, SectionClass::Two),
            ("IPE300", 355.0, SectionClass::One, SectionClass::Four),
            ("IPE600", 355.0, SectionClass::One, SectionClass::Four),
            ("HEA300", 355.0, SectionClass::Three, SectionClass::Three),
        ] {
            let found = [0.0, 1.0].map(|n| class(name, strength, n));
            assert_eq!(found, [bending, compression], "{name} {strength}");
        }
    }

    #[test]
    fn more_compression_and_more_strength_never_lower_the_class() {
        for it in catalogue() {
            for strength in [235.0, 275.0, 355.0, 420.0, 460.0] {
                let mut before = SectionClass::One;
                for k in 0..=20 {
                    let ratio = 0.05 * f64::from(k);
                    let here = class(&it.name, strength, ratio);
                    assert!(here >= before, "{} {strength} {ratio}", it.name);
                    assert!(class(&it.name, 1.1 * strength, ratio) >= here);
                    before = here;
                }
            }
        }
        // Tension counts as none.
        assert_eq!(class("IPE600", 355.0, -0.5), class("IPE600", 355.0, 0.0));
    }
}
