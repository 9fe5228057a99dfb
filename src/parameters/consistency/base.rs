//! Consistency of the parameters of the base plate.

use crate::column::{BaseFactors, BasePlateError};
use crate::parameters::base::given_plate;
use crate::parameters::inconsistency::Inconsistency;
use crate::parameters::section::dimensions_of;
use crate::parameters::settings::{BaseConnection, Settings, SupportKind};

/// The numbers of a base plate: all of them with a plate, none without.
pub(super) fn base_is_complete(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let base = &settings.base;
    let given = [
        (
            "base.plate_thickness",
            base.plate_thickness > 0.0,
            "it in m",
        ),
        ("base.plate_length", base.plate_length > 0.0, "it in m"),
        ("base.plate_width", base.plate_width > 0.0, "it in m"),
        ("base.anchor_count", base.anchor_count > 0, "an even number"),
        (
            "base.anchor_diameter",
            base.anchor_diameter > 0.0,
            "it in m",
        ),
        (
            "base.anchor_grade",
            base.anchor_grade != "none",
            "a grade such as \"8.8\", in quotes",
        ),
        (
            "base.anchor_distance",
            base.anchor_distance > 0.0,
            "it in m",
        ),
        (
            "base.concrete",
            base.concrete != "none",
            "a class such as C25/30",
        ),
    ];
    let mut reject = |name, others: &[&'static str], message: String| {
        let others = others.iter().copied();
        found.push(Inconsistency {
            names: std::iter::once(name).chain(others).collect(),
            message,
        });
    };
    if base.connection == BaseConnection::None {
        for (name, ..) in given.into_iter().filter(|(_, is_given, _)| *is_given) {
            reject(
                name,
                &["base.connection"],
                "describes a base plate, but base.connection is none; write base.connection: plate, or omit it".to_owned(),
            );
        }
        return;
    }
    if settings.support.base == SupportKind::SemiRigid {
        reject(
            "base.connection",
            &["support.base"],
            "plate and support.base: semi_rigid both describe the base; omit one of the two"
                .to_owned(),
        );
    }
    let mut is_complete = true;
    for (name, is_given, what) in given {
        if !is_given {
            is_complete = false;
            reject(
                name,
                &["base.connection"],
                format!("is required, because base.connection is plate; give {what}"),
            );
        }
    }
    let Some(section) = dimensions_of(&settings.section) else {
        reject(
            "base.connection",
            &["section.name", "section.area", "section.second_moment"],
            "plate needs the dimensions of the section; give section.name without section.area and section.second_moment, \
             or write base.connection: none, with which the base is not evaluated"
                .to_owned(),
        );
        return;
    };
    // The strength of the steel decides nothing here.
    let plate = given_plate(base, section, 235e6).filter(|_| is_complete);
    let checked = plate.map(|plate| plate.resistance(&BaseFactors::CHARACTERISTIC));
    if let Some(Err(error)) = checked {
        let (name, others): (_, &[&'static str]) = match &error {
            BasePlateError::PlateTooSmall { .. } => {
                ("base.plate_length", &["base.plate_width", "section.name"])
            }
            BasePlateError::AnchorsOutsideThePlate { .. } => (
                "base.anchor_distance",
                &["base.plate_length", "base.anchor_diameter"],
            ),
            BasePlateError::AnchorsInTheFlange { .. } => (
                "base.anchor_distance",
                &["section.name", "base.anchor_diameter"],
            ),
            BasePlateError::OutOfRange { name, .. } => match *name {
                "number of anchors" => ("base.anchor_count", &[]),
                _ => ("base.anchor_diameter", &[]),
            },
        };
        reject(name, others, format!("makes no base: {error}"));
    }
}
