//! The connection of the column's base, as given and as assumed.

use super::settings::{BaseConnection, BaseSettings, Settings};
use crate::column::{
    Anchors, BaseFactors, BasePlate, BasePlateError, BaseResistance, RolledSection,
};

/// Grades of anchors: name, `f_ub` and `f_yb` \[Pa\] (EN 1993-1-8, table 3.1). Stronger ones may not bear shear (6.2.2).
const GRADES: [(&str, f64, f64); 4] = [
    ("4.6", 400e6, 240e6),
    ("5.6", 500e6, 300e6),
    ("6.8", 600e6, 480e6),
    ("8.8", 800e6, 640e6),
];

/// Concretes: name, `f_ck` and `E_cm` \[Pa\] (EN 1992-1-1, table 3.1).
const CONCRETES: [(&str, f64, f64); 9] = [
    ("C12/15", 12e6, 27e9),
    ("C16/20", 16e6, 29e9),
    ("C20/25", 20e6, 30e9),
    ("C25/30", 25e6, 31e9),
    ("C30/37", 30e6, 33e9),
    ("C35/45", 35e6, 34e9),
    ("C40/50", 40e6, 35e9),
    ("C45/55", 45e6, 36e9),
    ("C50/60", 50e6, 37e9),
];

/// The words of `base.anchor_grade`.
pub(super) const GRADE_WORDS: &[&str] = &["none", "4.6", "5.6", "6.8", "8.8"];

/// The words of `base.concrete`.
pub(super) const CONCRETE_WORDS: &[&str] = &[
    "none", "C12/15", "C16/20", "C20/25", "C25/30", "C30/37", "C35/45", "C40/50", "C45/55",
    "C50/60",
];

/// Coefficient of friction between plate and grout of sand and cement (EN 1993-1-8, 6.2.2).
pub(super) const FRICTION: f64 = 0.2;

/// The concrete and the grade of an assumed plate.
const ASSUMED: (&str, &str) = ("C25/30", "8.8");

fn named(table: &[(&str, f64, f64)], name: &str) -> Option<(f64, f64)> {
    let found = table.iter().find(|(word, ..)| *word == name);
    found.map(|(_, strength, other)| (*strength, *other))
}

/// The plate that `base.*` describe under a section of a steel of this yield strength \[Pa\]; `None` without one, or with
/// a word that names nothing.
pub(super) fn given_plate(
    given: &BaseSettings,
    section: RolledSection,
    yield_strength: f64,
) -> Option<BasePlate> {
    if given.connection == BaseConnection::None {
        return None;
    }
    let (ultimate_strength, anchor_yield) = named(&GRADES, &given.anchor_grade)?;
    let (concrete_strength, concrete_modulus) = named(&CONCRETES, &given.concrete)?;
    Some(BasePlate {
        section,
        thickness: given.plate_thickness,
        length: given.plate_length,
        width: given.plate_width,
        yield_strength,
        anchors: Anchors {
            count: given.anchor_count,
            diameter: given.anchor_diameter,
            ultimate_strength,
            yield_strength: anchor_yield,
            distance: given.anchor_distance,
        },
        concrete_strength,
        concrete_modulus,
        friction: given.friction,
    })
}

/// The base plate that is assumed under a built-in column whose base nobody has described, an assumption of this project by
/// the practice of engineers: four anchors 8.8 outside of the flanges, M20 under a section of less than 205 mm, M24 under one
/// of less than 270 mm, M30 under a deeper one, 30 mm from the flange (40 mm for M30) and twice that from the edge of a plate
/// of 30 mm (40 mm), in C25/30, so that the anchors govern.
#[must_use]
pub fn assumed_plate(section: &RolledSection, yield_strength: f64) -> BasePlate {
    let (diameter, clearance, thickness) = match section.depth {
        depth if depth < 0.205 => (0.020, 0.03, 0.03),
        depth if depth < 0.270 => (0.024, 0.03, 0.03),
        _ => (0.030, 0.04, 0.04),
    };
    let distance = 0.5 * section.depth + clearance;
    let length = 2.0 * (distance + 2.0 * clearance);
    let (concrete, grade) = ASSUMED;
    let (ultimate_strength, anchor_yield) = named(&GRADES, grade).expect("a grade of the table");
    let (concrete_strength, concrete_modulus) =
        named(&CONCRETES, concrete).expect("a concrete of the table");
    BasePlate {
        section: *section,
        thickness,
        length,
        width: length.max(section.width + 2.0 * clearance),
        yield_strength,
        anchors: Anchors {
            count: 4,
            diameter,
            ultimate_strength,
            yield_strength: anchor_yield,
            distance,
        },
        concrete_strength,
        concrete_modulus,
        friction: FRICTION,
    }
}

/// A plate in words, such as `400 x 400 x 30 mm with 4 anchors M24 8.8 at 140 mm from the axis, C25/30`.
#[must_use]
pub fn plate_in_words(plate: &BasePlate) -> String {
    let anchors = &plate.anchors;
    let name = |table: &[(&'static str, f64, f64)], strength: f64| {
        let found = table.iter().find(|row| row.1 == strength);
        found.map_or("?", |row| row.0)
    };
    format!(
        "{:.0} x {:.0} x {:.0} mm with {} anchors M{:.0} {} at {:.0} mm from the axis, {}",
        plate.length * 1e3,
        plate.width * 1e3,
        plate.thickness * 1e3,
        anchors.count,
        anchors.diameter * 1e3,
        name(&GRADES, anchors.ultimate_strength),
        anchors.distance * 1e3,
        name(&CONCRETES, plate.concrete_strength),
    )
}

/// What a base plate bears, without partial factors. A column without a limit of its rotations has none of its base either.
///
/// # Errors
/// As [`BasePlate::resistance`].
pub fn resistance_of_base(
    plate: &BasePlate,
    settings: &Settings,
) -> Result<BaseResistance, BasePlateError> {
    let resistance = plate.resistance(&BaseFactors::CHARACTERISTIC)?;
    Ok(match settings.assessment.ultimate_rotation > 0.0 {
        true => resistance,
        false => resistance.without_limits(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::CatalogueSection;

    /// The plates that an engineer assumed for 12 sections: depth, diameter, distance and plate in mm.
    #[test]
    fn the_assumed_plates_are_those_of_an_engineer() {
        const PLATES: [(&str, f64, f64, f64, f64); 12] = [
            ("HEB220", 24.0, 140.0, 400.0, 30.0),
            ("HEB300", 30.0, 190.0, 540.0, 40.0),
            ("HEA200", 20.0, 125.0, 370.0, 30.0),
            ("HEA160", 20.0, 106.0, 332.0, 30.0),
            ("IPE300", 30.0, 190.0, 540.0, 40.0),
            ("IPE360", 30.0, 220.0, 600.0, 40.0),
            ("HEA240", 24.0, 145.0, 410.0, 30.0),
            ("HEB160", 20.0, 110.0, 340.0, 30.0),
            ("HEB140", 20.0, 100.0, 320.0, 30.0),
            ("HEB200", 20.0, 130.0, 380.0, 30.0),
            ("HEB260", 24.0, 160.0, 440.0, 30.0),
            ("HEA300", 30.0, 185.0, 530.0, 40.0),
        ];
        for (name, diameter, distance, size, thickness) in PLATES {
            let section = CatalogueSection::named(name).expect(name).dimensions;
            let plate = assumed_plate(&section, 355e6);
            let anchors = &plate.anchors;
            for (found, expected) in [
                (anchors.diameter, diameter),
                (anchors.distance, distance),
                (plate.length, size),
                (plate.width, size),
                (plate.thickness, thickness),
            ] {
                assert!((1e3 * found - expected).abs() < 1e-9, "{name}: {found}");
            }
        }
    }

    /// Every section of the catalogue gets a plate that is one.
    #[test]
    fn every_section_has_an_assumed_plate() {
        for section in crate::parameters::catalogue() {
            let plate = assumed_plate(&section.dimensions, 235e6);
            let found = plate.resistance(&BaseFactors::CHARACTERISTIC);
            assert!(found.is_ok(), "{}: {found:?}", section.name);
        }
    }
}
