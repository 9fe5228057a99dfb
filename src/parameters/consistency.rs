//! Consistency between parameters whose values are admissible one by one.
//!
//! Whether the column carries its load is checked by the mechanics.

mod base;
mod verdict;

use super::catalogue::CatalogueSection;
use super::inconsistency::Inconsistency;
use super::ranges::LENGTH_RANGE;
use super::settings::{
    GeometrySettings, RateLawKind, SectionShape, Settings, ShearModel, SofteningModel,
    SpringSettings, SupportKind,
};
use super::value::readable;
use super::vehicles::VehicleFault;
use crate::column::{
    CrushCurve, CrushSpring, ElasticLaw, MAX_BUMPER_SHARE, MAX_IMPERFECTION,
    MAX_TRANSVERSE_ACCELERATION, Vehicle, VehicleError,
};

/// All inconsistencies of otherwise admissible parameters.
pub(super) fn inconsistencies(settings: &Settings) -> Vec<Inconsistency> {
    let mut found = Vec::new();
    lengths_fit_the_height(settings, &mut found);
    section_is_complete(settings, &mut found);
    steel_is_complete(settings, &mut found);
    supports_have_their_stiffness(settings, &mut found);
    hinge_stiffness_has_its_law(settings, &mut found);
    rate_suits_the_step(settings, &mut found);
    free_top_carries_nothing(settings, &mut found);
    vehicle_is_complete(settings, &mut found);
    force_suits_the_mass(settings, &mut found);
    estimates_know_the_column(settings, &mut found);
    strain_rate_has_a_height(settings, &mut found);
    imperfection_suits_the_height(settings, &mut found);
    bumper_leaves_the_bars_clear(settings, &mut found);
    section_is_a_profile(settings, &mut found);
    base::base_is_complete(settings, &mut found);
    softening_has_its_rotations(settings, &mut found);
    verdict::redistribution_is_proven(settings, &mut found);
    verdict::weak_axis_is_known(settings, &mut found);
    found
}

/// Relative difference between a height and the sum of the lengths that is round-off of numbers in decimal digits.
const HEIGHT_TOLERANCE: f64 = 1e-6;

fn lengths_fit_the_height(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let GeometrySettings {
        height,
        length_below: below,
        length_above: above,
    } = settings.geometry;
    if height == 0.0 {
        return;
    }
    let names = vec![
        "geometry.height",
        "geometry.length_above",
        "geometry.length_below",
    ];
    let [height_text, below_text, above_text] = [height, below, above].map(readable);
    let message = if ![below, above].iter().all(|it| LENGTH_RANGE.contains(it)) {
        format!(
            "of {height_text} m leaves bars of {below_text} m below and {above_text} m above the impact point, which are not \
             lengths of bars; give a larger height, or the height of the impact point as geometry.length_below"
        )
    } else if (below + above - height).abs() > HEIGHT_TOLERANCE * height {
        format!(
            "is {height_text} m, but geometry.length_below of {below_text} m and geometry.length_above of {above_text} m are \
             {} m together; omit one of the three",
            readable(below + above)
        )
    } else {
        return;
    };
    found.push(Inconsistency { names, message });
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
            message: "is required, because a user-defined section has no plastic modulus; give it, or section.name"
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
    for (name, stiffness) in hinge.stiffnesses() {
        if stiffness == 0.0 {
            continue;
        }
        let end = match name {
            "hinge.stiffness_2" => Some(("support.top", support.top)),
            "hinge.stiffness_3" => Some(("support.base", support.base)),
            _ => None,
        };
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

/// What the mechanics rejects of a column with a free top, by the names of the parameters.
fn free_top_carries_nothing(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let (support, top, hinge) = (&settings.support, &settings.top, &settings.hinge);
    if support.top != SupportKind::Free {
        return;
    }
    for (name, value, why) in [
        (
            "top.load",
            top.load,
            "a load on it would sway with it, which the model does not follow",
        ),
        (
            "top.spring_stiffness",
            top.spring_stiffness,
            "there is nothing above it to which the spring could be fixed",
        ),
        (
            "hinge.stiffness_1b",
            hinge.stiffness_1b,
            "hinge 1b bears no moment",
        ),
    ] {
        if value > 0.0 {
            found.push(Inconsistency {
                names: vec![name, "support.top"],
                message: format!(
                    "is {}, but support.top is free: {why}; give 0, or hold the top",
                    readable(value)
                ),
            });
        }
    }
    if support.base == SupportKind::Pinned {
        found.push(Inconsistency {
            names: vec!["support.base", "support.top"],
            message: "is pinned, but support.top is free, so that nothing holds the column; write support.base: built_in or \
                      semi_rigid, or hold the top"
                .to_owned(),
        });
    }
}

/// The estimation of impacts knows neither a free top nor a force on the vehicle.
fn estimates_know_the_column(settings: &Settings, found: &mut Vec<Inconsistency>) {
    if settings.sensors.names.is_empty() {
        return;
    }
    for (name, is_unknown, what) in [
        (
            "support.top",
            settings.support.top == SupportKind::Free,
            "is free",
        ),
        (
            "impact.transverse_force",
            settings.impact.transverse_force > 0.0,
            "is given",
        ),
    ] {
        if is_unknown {
            found.push(Inconsistency {
                names: vec![name, "sensors.names"],
                message: format!(
                    "{what}, which the estimation of impacts from sensors does not include; give no sensors.names, or change it"
                ),
            });
        }
    }
}

fn force_suits_the_mass(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let (force, mut mass) = (settings.impact.transverse_force, settings.impact.mass);
    if mass == 0.0
        && let Ok(Some(vehicle)) = settings.vehicle.vehicle()
    {
        mass = vehicle.total_mass();
    }
    let largest = MAX_TRANSVERSE_ACCELERATION * mass;
    // A mass that is missing is a fault of its own.
    if mass > 0.0 && force > largest {
        found.push(Inconsistency {
            names: vec!["impact.transverse_force", "impact.mass", "vehicle.name"],
            message: format!(
                "is {} N, which is more than 100 m/s^2 times the mass of the vehicle; give at most {} N",
                readable(force),
                readable(largest)
            ),
        });
    }
}

fn rate_suits_the_step(settings: &Settings, found: &mut Vec<Inconsistency>) {
    // The longest step that the mechanics chooses is shorter than the shortest period of publishing.
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

fn bumper_leaves_the_bars_clear(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let (geometry, bumper) = (&settings.geometry, settings.vehicle.bumper_height);
    let shorter = geometry.length_below.min(geometry.length_above);
    let highest = MAX_BUMPER_SHARE * shorter;
    if settings.shear.model == ShearModel::Web && bumper > highest {
        found.push(Inconsistency {
            names: vec![
                "vehicle.bumper_height",
                "vehicle.name",
                "geometry.length_below",
                "geometry.length_above",
            ],
            message: format!(
                "is {} m, and half of it leaves less than a tenth of the shorter part of the column clear, which is {} m long; \
                 give at most {} m, or an impact point farther from the support",
                readable(bumper),
                readable(shorter),
                // Rounded down, without the round-off of the product.
                readable((1e6 * highest).floor() / 1e6)
            ),
        });
    }
}

/// The flanges and the web fit into the height and the width.
fn section_is_a_profile(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let given = &settings.section;
    let named = CatalogueSection::named(&given.name).map(|section| section.dimensions);
    let known = |number: f64, of_name: Option<f64>| match number > 0.0 {
        true => Some(number),
        false => of_name,
    };
    let height = known(given.height, named.map(|it| it.depth));
    let width = known(given.width, named.map(|it| it.width));
    let web = known(given.web_thickness, named.map(|it| it.web_thickness));
    let flange = known(given.flange_thickness, named.map(|it| it.flange_thickness));
    let is_hollow = given.shape != SectionShape::IOrH;
    if is_hollow && named.is_some() {
        found.push(Inconsistency {
            names: vec!["section.shape", "section.name"],
            message: format!(
                "is that of a hollow section, but {} is a rolled I or H section; give section.name: \"\" and the numbers of the \
                 hollow section, or omit section.shape",
                given.name
            ),
        });
        return;
    }
    let (webs, too_thick) = match is_hollow {
        true => (2.0, "two walls are as thick as the section is wide"),
        false => (1.0, "the web is as thick as the flanges are wide"),
    };
    let pairs = [
        (
            ["section.web_thickness", "section.height"],
            web.filter(|_| is_hollow).map(|it| 2.0 * it),
            height,
            "two walls are as thick as the section is high",
        ),
        (
            ["section.flange_thickness", "section.height"],
            flange.map(|it| 2.0 * it),
            height,
            "two flanges are as thick as the section is high",
        ),
        (
            ["section.web_thickness", "section.width"],
            web.map(|it| webs * it),
            width,
            too_thick,
        ),
    ];
    for ([name, other], thickness, size, what) in pairs {
        if let (Some(thickness), Some(size)) = (thickness, size)
            && thickness >= size
        {
            found.push(Inconsistency {
                names: vec![name, other, "section.name"],
                message: format!(
                    "does not suit {other} of {} m: {what}; give a thinner one, or omit it",
                    readable(size)
                ),
            });
        }
    }
}

/// Crush, force and unloading stiffness of each spring.
pub(super) const SPRINGS: [[&str; 3]; 3] = [
    [
        "vehicle.spring_1.crush",
        "vehicle.spring_1.force",
        "vehicle.spring_1.unloading_stiffness",
    ],
    [
        "vehicle.spring_2.crush",
        "vehicle.spring_2.force",
        "vehicle.spring_2.unloading_stiffness",
    ],
    [
        "vehicle.spring_3.crush",
        "vehicle.spring_3.force",
        "vehicle.spring_3.unloading_stiffness",
    ],
];

fn vehicle_is_complete(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let vehicle = &settings.vehicle;
    let before = found.len();
    if vehicle.name.is_empty() {
        numbers_are_a_vehicle(settings, found);
    } else if let Some(name) = first_number(settings) {
        found.push(Inconsistency {
            names: vec![name, "vehicle.name"],
            message: format!(
                "describes a user-defined vehicle, but vehicle.name is {}; write vehicle.name: \"\", or omit the numbers",
                vehicle.name
            ),
        });
    }
    if found.len() == before {
        mass_suits_the_vehicle(settings, found);
    }
}

/// The first parameter of a vehicle by numbers that is given.
fn first_number(settings: &Settings) -> Option<&'static str> {
    let vehicle = &settings.vehicle;
    let springs = vehicle.springs().into_iter().zip(SPRINGS);
    let of_springs = springs.flat_map(|(spring, [crush, force, stiffness])| {
        [
            (crush, spring.crush.is_empty()),
            (force, spring.force.is_empty()),
            (stiffness, spring.unloading_stiffness == 0.0),
        ]
    });
    [
        ("vehicle.masses", vehicle.masses.is_empty()),
        ("vehicle.slack", vehicle.slack.is_empty()),
    ]
    .into_iter()
    .chain(of_springs)
    .find(|(_, is_open)| !is_open)
    .map(|(name, _)| name)
}

fn numbers_are_a_vehicle(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let vehicle = &settings.vehicle;
    let masses = vehicle.masses.len();
    if masses == 0 {
        found.push(Inconsistency {
            names: vec!["vehicle.masses", "vehicle.name"],
            message: "is required, because vehicle.name is empty; give the masses in kg, front first, or name the vehicle"
                .to_owned(),
        });
    }
    for (index, (spring, names)) in vehicle.springs().into_iter().zip(SPRINGS).enumerate() {
        let number = index + 1;
        if number <= masses {
            spring_is_complete(number, spring, names, found);
        } else if masses > 0 && !spring.is_open() {
            found.push(Inconsistency {
                names: vec![names[0], "vehicle.masses", names[1], names[2]],
                message: format!(
                    "belongs to a spring in front of mass {number}, but vehicle.masses has {masses}; add the mass, or omit the spring"
                ),
            });
        }
    }
    let slack = vehicle.slack.len();
    if slack > 0 && slack + 1 != masses && masses > 0 {
        found.push(Inconsistency {
            names: vec!["vehicle.slack", "vehicle.masses"],
            message: format!(
                "has {slack} elements for {masses} masses; give one for each spring from the second on, which is {}, or omit it",
                masses - 1
            ),
        });
    }
}

fn spring_is_complete(
    number: usize,
    spring: &SpringSettings,
    [crush, force, stiffness]: [&'static str; 3],
    found: &mut Vec<Inconsistency>,
) {
    let names = |first: &'static str| {
        let others = [crush, force, stiffness, "vehicle.masses", "vehicle.name"];
        std::iter::once(first)
            .chain(others.into_iter().filter(|it| *it != first))
            .collect()
    };
    let mut reject = |first, message| {
        found.push(Inconsistency {
            names: names(first),
            message,
        });
    };
    for (name, is_open, what) in [
        (crush, spring.crush.is_empty(), "crush [m] of its points"),
        (force, spring.force.is_empty(), "force [N] at its points"),
        (
            stiffness,
            spring.unloading_stiffness == 0.0,
            "stiffness [N/m] of its unloading",
        ),
    ] {
        if is_open {
            reject(
                name,
                format!(
                    "is required, because a spring is in front of mass {number}; give the {what}"
                ),
            );
        }
    }
    let (crushes, forces) = (spring.crush.len(), spring.force.len());
    if crushes == 0 || forces == 0 {
        return;
    }
    if crushes != forces {
        reject(
            force,
            format!(
                "has {forces} elements and {crush} has {crushes}; give one force for each crush"
            ),
        );
        return;
    }
    match CrushCurve::new(&spring.points()) {
        Ok(curve) => {
            let given = spring.unloading_stiffness;
            let alone = CrushSpring {
                envelope: curve,
                unloading_stiffness: given,
                slack: 0.0,
            };
            if let Err(VehicleError::UnloadingTooSoft { steepest, .. }) =
                Vehicle::new(&[1.0], &[alone])
                && given > 0.0
            {
                reject(
                    stiffness,
                    format!(
                        "is {} N/m, but the curve of the spring has slopes up to {} N/m; give at least that",
                        readable(given),
                        readable(steepest)
                    ),
                );
            }
        }
        Err(VehicleError::CrushNotIncreasing {
            number,
            found,
            before,
        }) => reject(
            crush,
            format!(
                "has {} m (element {number}) after {} m; give values that increase from 0",
                readable(found),
                readable(before)
            ),
        ),
        Err(other) => reject(force, format!("is not a curve: {other}")),
    }
}

fn mass_suits_the_vehicle(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let mass = settings.impact.mass;
    match settings.vehicle.vehicle() {
        Ok(None) if mass == 0.0 => found.push(Inconsistency {
            names: vec!["impact.mass", "vehicle.name"],
            message: "is required, because a rigid vehicle has no mass of its own; give it in kg".to_owned(),
        }),
        Ok(_) => {}
        // The curve itself was checked, so that it is the ramp from half of the force to all of it that is too steep.
        Err(VehicleFault::Numbers(VehicleError::UnloadingTooSoft {
            found: given,
            steepest,
            ..
        })) => found.push(Inconsistency {
            names: vec![SPRINGS[0][2], "vehicle.narrow_object", "vehicle.name"],
            message: format!(
                "is {} N/m, but with vehicle.narrow_object the curve has slopes up to {} N/m; give at least that",
                readable(given),
                readable(steepest)
            ),
        }),
        Err(fault) => found.push(Inconsistency {
            names: vec!["vehicle.name", "vehicle.narrow_object"],
            message: format!("gives no vehicle: {fault}"),
        }),
    }
}

fn softening_has_its_rotations(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let softening = &settings.softening;
    if softening.model == SofteningModel::None || !settings.section.name.is_empty() {
        return;
    }
    for (name, rotation) in [
        ("softening.capping_rotation", softening.capping_rotation),
        (
            "softening.post_capping_rotation",
            softening.post_capping_rotation,
        ),
    ] {
        if rotation == 0.0 {
            found.push(Inconsistency {
                names: vec![name, "softening.model", "section.name"],
                message: "is required for the softening of a user-defined section; give it in rad, name the section, or write \
                          softening.model: none"
                    .to_owned(),
            });
        }
    }
}

fn strain_rate_has_a_height(settings: &Settings, found: &mut Vec<Inconsistency>) {
    let section = &settings.section;
    if settings.rate.law != RateLawKind::None && section.name.is_empty() && section.height == 0.0 {
        found.push(Inconsistency {
            names: vec!["section.height", "section.name", "rate.law"],
            message: "is required for the strain rate, because a user-defined section has no height; give it in m, \
                      name the section, or write rate.law: none"
                .to_owned(),
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
    fn a_free_top_carries_nothing_and_needs_a_base() {
        let bollard = [
            ("support.top", "free".into()),
            ("top.load", 0.0.into()),
            ("top.spring_stiffness", 0.0.into()),
        ];
        assert!(faults(&bollard).is_empty());
        let [free, load, spring] = bollard;
        // The defaults hold the top and load it.
        assert_eq!(faults(std::slice::from_ref(&free)), ["top.load"]);
        assert_eq!(
            faults(&[
                free.clone(),
                load.clone(),
                ("top.spring_stiffness", 1e7.into())
            ]),
            ["top.spring_stiffness"]
        );
        assert_eq!(
            faults(&[free, load, spring, ("support.base", "pinned".into())]),
            ["support.base"]
        );
        assert_eq!(faults(&[("support.base", "free".into())]), ["support.base"]);
    }

    #[test]
    fn a_transverse_force_suits_the_mass() {
        let force = |newton: f64| ("impact.transverse_force", newton.into());
        assert!(faults(&[force(1500.0 * 9.81)]).is_empty());
        assert_eq!(faults(&[force(151e3)]), ["impact.transverse_force"]);
        let own_mass = [
            ("impact.mass", 0.0.into()),
            ("vehicle.name", "mid_car".into()),
        ];
        let [mass, vehicle] = own_mass;
        assert!(faults(&[force(150e3), mass.clone(), vehicle.clone()]).is_empty());
        assert_eq!(
            faults(&[force(200e3), mass, vehicle]),
            ["impact.transverse_force"]
        );
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
    fn a_base_plate_is_complete_and_holds_its_anchors() {
        let plate: [(&str, Value); 9] = [
            ("base.connection", "plate".into()),
            ("base.plate_thickness", 0.03.into()),
            ("base.plate_length", 0.4.into()),
            ("base.plate_width", 0.4.into()),
            ("base.anchor_count", Value::Integer(4)),
            ("base.anchor_diameter", 0.024.into()),
            ("base.anchor_grade", "8.8".into()),
            ("base.anchor_distance", 0.14.into()),
            ("base.concrete", "C25/30".into()),
        ];
        assert!(faults(&plate).is_empty());
        for missing in 1..plate.len() {
            let mut incomplete = plate.to_vec();
            let (name, _) = incomplete.remove(missing);
            assert_eq!(faults(&incomplete), [name]);
            // Without the connection the numbers have no effect.
            assert_eq!(faults(&plate[missing..=missing]), [name]);
        }
        let with = |name, value: Value| {
            let changed = [&plate[..], &[(name, value)]].concat();
            faults(&changed)
        };
        assert_eq!(
            with("base.anchor_distance", 0.19.into()),
            ["base.anchor_distance"]
        );
        assert_eq!(
            with("base.anchor_distance", 0.105.into()),
            ["base.anchor_distance"]
        );
        assert_eq!(with("base.plate_width", 0.2.into()), ["base.plate_length"]);
        assert_eq!(
            with("base.anchor_count", Value::Integer(5)),
            ["base.anchor_count"]
        );
        assert_eq!(
            with("base.anchor_diameter", 0.025.into()),
            ["base.anchor_diameter"]
        );
        let overridden = [
            ("section.name", Value::from("HEB220")),
            ("section.area", 0.0091.into()),
        ];
        let without_dimensions = [&plate[..], &overridden].concat();
        assert_eq!(faults(&without_dimensions), ["base.connection"]);
        let semi_rigid = [
            ("support.base", Value::from("semi_rigid")),
            ("support.base_stiffness", 1e7.into()),
        ];
        let both = [&plate[..], &semi_rigid].concat();
        assert_eq!(faults(&both), ["base.connection"]);
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

    /// The faults that these changes to the defaults cause, in one text.
    fn text(changes: &[(&str, Value)]) -> String {
        Parameters::from_values(changes.iter().cloned())
            .expect_err("inconsistent")
            .to_string()
    }

    /// A vehicle of one mass by numbers, with some of them replaced.
    fn one_mass(replaced: &[(&'static str, Value)]) -> Vec<(&'static str, Value)> {
        let mut numbers = vec![
            ("vehicle.masses", Value::from(vec![1500.0])),
            ("vehicle.spring_1.crush", vec![0.2, 0.5].into()),
            ("vehicle.spring_1.force", vec![1e5, 4e5].into()),
            ("vehicle.spring_1.unloading_stiffness", 1e7.into()),
        ];
        numbers.extend(replaced.iter().cloned());
        numbers
    }

    #[test]
    fn a_vehicle_by_numbers_is_complete() {
        let parameters = Parameters::from_values(one_mass(&[])).expect("complete");
        assert_eq!(parameters.settings().vehicle.name, "");
        let impact = parameters.impact();
        assert_eq!(impact.mass, 1500.0);
        assert_eq!(impact.vehicle.map(|it| it.total_mass()), Some(1500.0));
        assert_eq!(faults(&[("vehicle.name", "".into())]), ["vehicle.masses"]);
        assert_eq!(
            faults(&[("vehicle.masses", vec![1.0, 2.0].into())]),
            [
                "vehicle.spring_1.crush",
                "vehicle.spring_1.force",
                "vehicle.spring_1.unloading_stiffness",
                "vehicle.spring_2.crush",
                "vehicle.spring_2.force",
                "vehicle.spring_2.unloading_stiffness"
            ]
        );
        let two = [
            ("vehicle.masses", Value::from(vec![500.0, 1000.0])),
            ("vehicle.spring_2.crush", vec![0.1].into()),
            ("vehicle.spring_2.force", vec![1e5].into()),
            ("vehicle.spring_2.unloading_stiffness", 1e6.into()),
        ];
        assert!(faults(&one_mass(&two)).is_empty());
        let slack = ("vehicle.slack", Value::from(vec![0.3, 0.4]));
        assert_eq!(
            faults(&one_mass(&[two.as_slice(), &[slack]].concat())),
            ["vehicle.slack"]
        );
        assert_eq!(
            faults(&one_mass(&two[1..])),
            ["vehicle.spring_2.crush"],
            "a spring without a mass"
        );
    }

    /// Each wrong curve is rejected with the reason and what would be right, and all of them at once.
    #[test]
    fn wrong_curves_are_rejected_with_the_reason() {
        for (name, value, expected) in [
            (
                "vehicle.spring_1.crush",
                Value::from(vec![0.2, 0.2]),
                "vehicle.spring_1.crush has 0.2 m (element 2) after 0.2 m; give values that increase from 0",
            ),
            (
                "vehicle.spring_1.force",
                vec![0.0, 0.0].into(),
                "vehicle.spring_1.force is not a curve: a force-crush curve has no force > 0",
            ),
            (
                "vehicle.spring_1.force",
                vec![1e5, -4e5].into(),
                "vehicle.spring_1.force: `-400000.0` (element 2) is out of range; allowed: 0 to 1e9 N",
            ),
            (
                "vehicle.spring_1.force",
                vec![1e5].into(),
                "vehicle.spring_1.force has 1 elements and vehicle.spring_1.crush has 2; give one force for each crush",
            ),
            (
                "vehicle.spring_1.unloading_stiffness",
                9e5.into(),
                "vehicle.spring_1.unloading_stiffness is 9e5 N/m, but the curve of the spring has slopes up to 1e6 N/m; give at least that",
            ),
            (
                "impact.mass",
                (-1.0).into(),
                "impact.mass: `-1.0` is out of range; allowed: 0.001 to 1e6 kg, or 0 or NaN (the vehicle's own mass",
            ),
        ] {
            let text = text(&one_mass(&[(name, value)]));
            assert!(text.contains(expected), "{text}");
            assert_eq!(text.lines().count(), 2, "{text}");
        }
        let all = text(&one_mass(&[
            ("vehicle.spring_1.crush", vec![0.2, 0.1].into()),
            ("vehicle.spring_2.force", vec![1e5].into()),
            ("vehicle.slack", vec![0.1].into()),
        ]));
        assert_eq!(all.lines().count(), 4, "{all}");
        // The ramp of a narrow object is steeper than this curve.
        let narrow = text(&one_mass(&[
            ("vehicle.spring_1.crush", vec![1.0].into()),
            ("vehicle.spring_1.force", vec![4e5].into()),
            ("vehicle.spring_1.unloading_stiffness", 4e5.into()),
            ("vehicle.narrow_object", true.into()),
        ]));
        let expected = "vehicle.spring_1.unloading_stiffness is 4e5 N/m, but with vehicle.narrow_object the curve has slopes up to";
        assert!(narrow.contains(expected), "{narrow}");
    }

    #[test]
    fn the_mass_suits_the_vehicle() {
        let named = |name: &str, mass: f64| {
            [
                ("vehicle.name", Value::from(name)),
                ("impact.mass", mass.into()),
            ]
        };
        assert!(faults(&named("lorry_8t", 6000.0)).is_empty());
        assert!(faults(&named("lorry_8t", 0.0)).is_empty());
        assert!(faults(&named("lorry_8t", 4000.0)).is_empty());
        for open in [0.0, f64::NAN] {
            assert!(text(&named("rigid", open)).contains(
                "impact.mass is required, because a rigid vehicle has no mass of its own"
            ));
            let parameters = Parameters::from_values(named("mid_car", open)).expect("right");
            assert_eq!(parameters.impact().mass, 1719.0);
        }
        let alone = [("vehicle.name", Value::from("mid_car"))];
        let parameters = Parameters::from_values(alone).expect("right");
        assert_eq!(parameters.impact().mass, 1719.0);
        assert_eq!(Parameters::default().impact().mass, 1500.0);
    }

    #[test]
    fn numbers_and_a_name_exclude_each_other() {
        assert!(
            text(&one_mass(&[("vehicle.name", "suv".into())])).contains(
                "vehicle.masses describes a user-defined vehicle, but vehicle.name is suv; write vehicle.name: \"\", or omit the \
                 numbers"
            )
        );
        assert_eq!(
            faults(&[
                ("vehicle.name", "suvv".into()),
                ("vehicle.masses", vec![1.0].into())
            ]),
            ["vehicle.name"]
        );
    }

    #[test]
    fn strain_rates_need_a_section_height() {
        let rate = ("rate.law", Value::from("logarithmic"));
        assert!(faults(std::slice::from_ref(&rate)).is_empty());
        let by_numbers = [
            rate,
            ("section.area", 0.01.into()),
            ("section.second_moment", 1e-4.into()),
            ("section.mass_per_length", 78.5.into()),
            ("resistance.moment", 3e5.into()),
        ];
        assert_eq!(faults(&by_numbers), ["section.height"]);
        let height = ("section.height", Value::from(0.22));
        assert!(faults(&[by_numbers.as_slice(), &[height]].concat()).is_empty());
    }

    #[test]
    fn hardening_and_softening_follow_the_section() {
        let properties = |changes: &[(&str, Value)]| {
            let parameters = Parameters::from_values(changes.iter().cloned()).expect("right");
            parameters.column_properties()
        };
        let by_numbers = [
            ("section.area", Value::from(0.01)),
            ("section.second_moment", 1e-4.into()),
            ("section.mass_per_length", 78.5.into()),
            ("resistance.moment", 3e5.into()),
        ];
        let named = properties(&[]);
        assert_eq!(named.hardening_ratio, 0.01);
        let with_rate = properties(&[("rate.law", "logarithmic".into())]);
        assert_eq!(with_rate.hardening_ratio, 0.005);
        let softening = named.softening.expect("softening");
        assert!((softening.capping_rotation - 0.101).abs() < 5e-4);
        let numbers = properties(&by_numbers);
        assert_eq!((numbers.hardening_ratio, numbers.softening), (0.0, None));
        // What is given stays, a zero too.
        let given = properties(&[
            ("hardening.ratio", 0.0.into()),
            ("softening.model", "none".into()),
        ]);
        assert_eq!((given.hardening_ratio, given.softening), (0.0, None));
        let given = [
            ("hardening.ratio", Value::from(0.02)),
            ("softening.model", "backbone".into()),
            ("softening.capping_rotation", 0.03.into()),
            ("softening.post_capping_rotation", 0.2.into()),
        ];
        let given = properties(&[by_numbers.as_slice(), &given].concat());
        let softening = given.softening.expect("softening");
        assert_eq!(
            (
                given.hardening_ratio,
                softening.capping_rotation,
                softening.residual
            ),
            (0.02, 0.03, 0.0)
        );
        // A change of the section changes what follows from it, and nothing else.
        let named = Parameters::default();
        let changes = by_numbers
            .iter()
            .cloned()
            .chain([("section.name", Value::from(""))]);
        let numbers = named
            .with_changes(changes)
            .expect("right")
            .column_properties();
        assert_eq!((numbers.hardening_ratio, numbers.softening), (0.0, None));
        // Without a limit of deformation there is no softening either.
        let lifted = properties(&[("assessment.ultimate_rotation", 0.0.into())]);
        assert_eq!((lifted.ultimate_rotation, lifted.softening), (0.0, None));
    }

    /// A spring that nobody had asked for took load off every real column, so that damaged ones had more reserve than new ones.
    #[test]
    fn nothing_takes_the_load_off_a_named_section_unless_it_is_given() {
        let spring = |parameters: &Parameters| parameters.settings().top.spring_stiffness;
        let by_numbers = [
            ("section.name", Value::from("")),
            ("section.area", 0.01.into()),
            ("section.second_moment", 1e-4.into()),
            ("section.mass_per_length", 78.5.into()),
            ("resistance.moment", 3e5.into()),
        ];
        let named = Parameters::default();
        assert_eq!(spring(&named), 0.0);
        let numbers = named.with_changes(by_numbers.clone()).expect("right");
        assert_eq!(spring(&numbers), 1e7);
        let given = [("top.spring_stiffness", Value::from(2e6))];
        let given = named.with_changes(given).expect("right");
        assert_eq!(spring(&given), 2e6);
        assert_eq!(spring(&given.with_changes(by_numbers).expect("right")), 2e6);
    }

    #[test]
    fn redistribution_counts_with_a_limit_a_proof_and_a_spring_only() {
        let all = [
            ("top.redistribution_limit", Value::from(1e5)),
            ("top.redistribution_proof", "calculation 17".into()),
            ("top.spring_stiffness", 1e7.into()),
        ];
        assert!(faults(&all).is_empty());
        let [limit, proof, spring] = all;
        assert_eq!(
            faults(&[limit.clone(), spring.clone()]),
            ["top.redistribution_proof"]
        );
        assert_eq!(
            faults(&[
                limit.clone(),
                spring.clone(),
                ("top.redistribution_proof", " ".into())
            ]),
            ["top.redistribution_proof"]
        );
        assert_eq!(
            faults(&[proof.clone(), spring]),
            ["top.redistribution_limit"]
        );
        assert_eq!(faults(&[limit, proof]), ["top.spring_stiffness"]);
    }

    #[test]
    fn a_weak_axis_that_is_not_known_has_no_buckling_length() {
        let factor = ("capacity.buckling_factor_weak", Value::from(1.0));
        assert!(faults(std::slice::from_ref(&factor)).is_empty());
        let changed = [
            factor,
            ("section.name", "HEB220".into()),
            ("section.area", 0.0092.into()),
            ("section.second_moment", 8e-5.into()),
        ];
        assert_eq!(faults(&changed), ["capacity.buckling_factor_weak"]);
    }

    #[test]
    fn softening_of_a_section_by_numbers_needs_its_rotations() {
        let mut changes = vec![
            ("section.area", Value::from(0.01)),
            ("section.second_moment", 1e-4.into()),
            ("section.mass_per_length", 78.5.into()),
            ("resistance.moment", 3e5.into()),
            ("softening.model", "backbone".into()),
        ];
        assert_eq!(
            faults(&changes),
            [
                "softening.capping_rotation",
                "softening.post_capping_rotation"
            ]
        );
        changes.push(("softening.capping_rotation", 0.03.into()));
        assert_eq!(faults(&changes), ["softening.post_capping_rotation"]);
        changes.push(("softening.post_capping_rotation", 0.0.into()));
        let text = text(&changes);
        assert!(
            text.contains("softening.post_capping_rotation is required"),
            "{text}"
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
