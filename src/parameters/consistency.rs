//! Consistency between parameters whose values are admissible one by one.
//!
//! Whether the column carries its load is checked by the mechanics.

use super::settings::{Settings, SupportKind};
use super::value::readable;
use crate::column::{ElasticLaw, MAX_IMPERFECTION};

/// Parameters that are not compatible.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inconsistency {
    /// The parameter that the message is about, then the others that it depends on.
    pub names: Vec<&'static str>,
    pub message: String,
}

/// All inconsistencies of otherwise admissible parameters.
pub(super) fn inconsistencies(settings: &Settings) -> Vec<Inconsistency> {
    let mut found = Vec::new();
    section_is_complete(settings, &mut found);
    steel_is_complete(settings, &mut found);
    supports_have_their_stiffness(settings, &mut found);
    hinge_stiffness_has_its_law(settings, &mut found);
    rate_suits_the_step(settings, &mut found);
    imperfection_suits_the_height(settings, &mut found);
    found
}

fn section_is_complete(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let section = &settings.section;
    if !section.name.is_empty() {
        return;
    }
    for (name, value) in [
        ("section.area", section.area),
        ("section.second_moment", section.second_moment),
        ("section.mass_per_length", section.mass_per_length),
    ] {
        if value == 0.0 {
            found.push(Inconsistency {
                names: vec![
                    name,
                    "section.name",
                    "section.area",
                    "section.second_moment",
                    "section.mass_per_length",
                ],
                message:
                    "is required, because section.name is not given; give it, or name the section"
                        .to_owned(),
            });
        }
    }
    if settings.resistance.moment == 0.0 {
        found.push(Inconsistency {
            names: vec!["resistance.moment", "section.name", "section.area", "section.second_moment", "section.mass_per_length"],
            message: "is required, because a section given by numbers has no plastic modulus; give it, or section.name"
                .to_owned(),
        });
    }
}

fn steel_is_complete(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let steel = &settings.steel;
    if !steel.grade.is_empty() {
        return;
    }
    for (name, value) in [
        ("steel.young_modulus", steel.young_modulus),
        ("steel.yield_strength", steel.yield_strength),
    ] {
        if value == 0.0 {
            found.push(Inconsistency {
                names: vec![
                    name,
                    "steel.grade",
                    "steel.young_modulus",
                    "steel.yield_strength",
                ],
                message:
                    "is required, because steel.grade is not given; give it, or name the grade"
                        .to_owned(),
            });
        }
    }
}

fn supports_have_their_stiffness(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let support = &settings.support;
    for (kind_name, kind, stiffness_name, stiffness) in [
        (
            "support.base",
            support.base,
            "support.base_stiffness",
            support.base_stiffness,
        ),
        (
            "support.top",
            support.top,
            "support.top_stiffness",
            support.top_stiffness,
        ),
    ] {
        let message = match (kind == SupportKind::SemiRigid, stiffness > 0.0) {
            (true, false) => {
                format!("is required, because {kind_name} is semi_rigid; give it in N m/rad")
            }
            (false, true) => {
                format!(
                    "applies only to semi-rigid supports; write {kind_name}: semi_rigid, or omit the stiffness"
                )
            }
            _ => continue,
        };
        found.push(Inconsistency {
            names: vec![stiffness_name, kind_name],
            message,
        });
    }
}

fn hinge_stiffness_has_its_law(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let (hinge, support) = (&settings.hinge, &settings.support);
    for (name, stiffness, end) in [
        ("hinge.stiffness_1a", hinge.stiffness_1a, None),
        ("hinge.stiffness_1b", hinge.stiffness_1b, None),
        (
            "hinge.stiffness_2",
            hinge.stiffness_2,
            Some(("support.top", support.top)),
        ),
        (
            "hinge.stiffness_3",
            hinge.stiffness_3,
            Some(("support.base", support.base)),
        ),
    ] {
        if stiffness == 0.0 {
            continue;
        }
        if hinge.elastic_law == ElasticLaw::Coupled {
            found.push(Inconsistency {
                names: vec![name, "hinge.elastic_law"],
                message: "is not compatible with the coupled law; write hinge.elastic_law: uncoupled, or omit the stiffness"
                    .to_owned(),
            });
        }
        if let Some((support, _)) = end.filter(|(_, kind)| *kind != SupportKind::BuiltIn) {
            found.push(Inconsistency {
                names: vec![name, support],
                message: format!(
                    "and {support} both define the stiffness of this end; omit one of the two"
                ),
            });
        }
    }
}

fn rate_suits_the_step(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let per_step = settings.publish_rate * settings.solver.dt;
    if per_step > 1.0 + 1e-9 {
        found.push(Inconsistency {
            names: vec!["publish_rate", "solver.dt"],
            message: format!(
                "exceeds one sample per step of {} s; give at most {} Hz, or a shorter solver.dt",
                readable(settings.solver.dt),
                readable((1.0 / settings.solver.dt).floor())
            ),
        });
    }
}

fn imperfection_suits_the_height(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let geometry = &settings.geometry;
    let largest = MAX_IMPERFECTION * (geometry.length_below + geometry.length_above);
    if settings.capacity.imperfection > largest {
        found.push(Inconsistency {
            names: vec![
                "capacity.imperfection",
                "geometry.length_below",
                "geometry.length_above",
            ],
            message: format!(
                "exceeds a tenth of the column's height; give at most {} m, or 0 for the value of the buckling curve",
                readable(largest)
            ),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Parameters, Value};

    /// Names of the faults that these changes to the defaults cause.
    fn faults(changes: &[(&str, Value)]) -> Vec<String> {
        match Parameters::from_values(changes.iter().cloned()) {
            Ok(_) => Vec::new(),
            Err(faults) => faults
                .faults()
                .iter()
                .map(|fault| fault.name.clone().unwrap_or_default())
                .collect(),
        }
    }

    #[test]
    fn a_section_by_numbers_is_complete() {
        assert_eq!(
            faults(&[("section.name", "".into())]),
            [
                "section.area",
                "section.second_moment",
                "section.mass_per_length",
                "resistance.moment"
            ]
        );
        assert_eq!(
            faults(&[("section.area", 0.01.into())]),
            [
                "section.second_moment",
                "section.mass_per_length",
                "resistance.moment"
            ]
        );
        let complete = [
            ("section.area", 0.01.into()),
            ("section.second_moment", 1e-4.into()),
            ("section.mass_per_length", 78.5.into()),
            ("resistance.moment", 3e5.into()),
        ];
        assert!(faults(&complete).is_empty());
        assert!(
            faults(&[
                ("section.name", "IPE 300".into()),
                ("section.area", 0.01.into())
            ])
            .is_empty()
        );
    }

    #[test]
    fn steel_by_numbers_is_complete() {
        assert_eq!(
            faults(&[("steel.yield_strength", 3e8.into())]),
            ["steel.young_modulus"]
        );
        assert_eq!(
            faults(&[("steel.grade", "".into())]),
            ["steel.young_modulus", "steel.yield_strength"]
        );
        assert!(
            faults(&[
                ("steel.grade", "S235".into()),
                ("steel.yield_strength", 3e8.into())
            ])
            .is_empty()
        );
    }

    #[test]
    fn supports_and_stiffnesses_are_compatible() {
        assert_eq!(
            faults(&[("support.base", "semi_rigid".into())]),
            ["support.base_stiffness"]
        );
        assert_eq!(
            faults(&[("support.top_stiffness", 1e6.into())]),
            ["support.top_stiffness"]
        );
        assert!(
            faults(&[
                ("support.top", "semi_rigid".into()),
                ("support.top_stiffness", 1e6.into())
            ])
            .is_empty()
        );
        assert_eq!(
            faults(&[("hinge.stiffness_1a", 1e6.into())]),
            ["hinge.stiffness_1a"]
        );
        let uncoupled = ("hinge.elastic_law", Value::from("uncoupled"));
        assert!(faults(&[uncoupled.clone(), ("hinge.stiffness_3", 1e6.into())]).is_empty());
        assert_eq!(
            faults(&[
                uncoupled,
                ("hinge.stiffness_3", 1e6.into()),
                ("support.base", "pinned".into())
            ]),
            ["hinge.stiffness_3"]
        );
    }

    #[test]
    fn states_are_published_at_most_once_per_step() {
        assert!(faults(&[("solver.dt", 1e-3.into())]).is_empty());
        assert_eq!(
            faults(&[("solver.dt", 1e-3.into()), ("publish_rate", 1001.0.into())]),
            ["publish_rate"]
        );
    }

    #[test]
    fn an_imperfection_is_at_most_a_tenth_of_the_height() {
        assert!(faults(&[("capacity.imperfection", 0.4.into())]).is_empty());
        assert_eq!(
            faults(&[("capacity.imperfection", 0.41.into())]),
            ["capacity.imperfection"]
        );
    }

    /// A wrong value is a single fault, without an inconsistency of the default that is used in its place.
    #[test]
    fn a_wrong_value_has_no_consequences() {
        assert_eq!(
            faults(&[
                ("support.base", "semirigid".into()),
                ("support.base_stiffness", 1e6.into())
            ]),
            ["support.base"]
        );
        assert_eq!(
            faults(&[
                ("section.name", "HEX220".into()),
                ("section.area", 0.01.into())
            ]),
            ["section.name"]
        );
    }
}
