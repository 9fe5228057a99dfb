//! The reference cases as columns and hits of the beam.

use column_beam::{BeamColumn, BowAxes, Hit, Shape, Steel, Torsion};
use column_mechanics::{CrushCurve, CrushSpring, Impact, RolledSection, Support, Vehicle};
use rustix::time::{ClockId, clock_gettime};

/// The sections of `config/sections.csv`.
pub fn section_names() -> impl Iterator<Item = &'static str> {
    let table = include_str!("../../../../config/sections.csv");
    let lines = table.lines().filter(|line| !line.starts_with('#'));
    lines.skip(1).filter_map(|line| line.split(',').next())
}

pub fn section(name: &str) -> RolledSection {
    let table = include_str!("../../../../config/sections.csv");
    let line = table
        .lines()
        .find(|line| line.split(',').next() == Some(name))
        .unwrap_or_else(|| panic!("{name} is not in config/sections.csv"));
    let mm: Vec<f64> = line
        .split(',')
        .skip(1)
        .take(5)
        .map(|x| x.parse::<f64>().unwrap() * 1e-3)
        .collect();
    RolledSection {
        depth: mm[0],
        width: mm[1],
        web_thickness: mm[2],
        flange_thickness: mm[3],
        root_radius: mm[4],
    }
}

pub fn support(name: &str) -> Support {
    if name.starts_with("pinned") {
        Support::Pinned
    } else {
        Support::BuiltIn
    }
}

/// Makes a column one that a car hits 0.5 m above its base, with everything that the program computes by default.
pub fn hit_by_a_car(column: &mut BeamColumn) {
    column.shear = true;
    column.torsion = Torsion::Warping;
    column.residual_stress = true;
    column.bow = -1.0;
    column.bumper_height = 0.2;
    (column.length_below, column.length_above) = (0.5, 3.5);
}

/// A column as the program computes it by default, and three hits on it, one after the other: in the plane of its web, out of it, and
/// by a soft vehicle.
pub fn column_hit_three_times() -> (BeamColumn, [Hit; 3]) {
    let mut it = column("HEB220", 355e6, 1e-3);
    it.top_load = 0.5e6;
    it.top_spring_stiffness = 1e7;
    hit_by_a_car(&mut it);
    let soft = Some(vehicle(1500.0, 1.5e6, Some(6e5)));
    let hits = [
        hit(1500.0, 6.0, None, 0.0),
        hit(1500.0, 6.0, None, 20.0),
        hit(1500.0, 15.0, soft, 45.0),
    ];
    (it, hits)
}

/// As the references know a column: straight, without shear, residual stress and rate.
pub fn column(name: &str, yield_strength: f64, hardening_ratio: f64) -> BeamColumn {
    BeamColumn {
        shape: Shape::Rolled(section(name)),
        steel: Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength,
            hardening_ratio,
            density: 7850.0,
            tensile_strength: None,
        },
        length_below: 1.0,
        length_above: 3.0,
        base: Support::BuiltIn,
        top: Support::BuiltIn,
        top_spring_stiffness: 0.0,
        top_mass: 0.0,
        top_load: 0.0,
        rate: None,
        shear: false,
        max_shear_hardening: 0.0,
        torsion: Torsion::SaintVenant,
        torsion_constant: None,
        residual_stress: false,
        bow: 0.0,
        bow_axes: BowAxes::Both,
        bumper_height: 0.0,
        elements: 0,
        fibres: 0,
        step_nanos: 0,
    }
}

/// A vehicle with one spring: elastic, or elastic up to a force that then stays.
pub fn vehicle(mass: f64, stiffness: f64, crush_force: Option<f64>) -> Vehicle {
    let points = match crush_force {
        None => vec![[1.0, stiffness]],
        Some(force) => vec![[force / stiffness, force], [10.0, force]],
    };
    let spring = CrushSpring {
        envelope: CrushCurve::new(&points).unwrap(),
        unloading_stiffness: stiffness,
        slack: 0.0,
    };
    Vehicle::new(&[mass], &[spring]).unwrap()
}

pub fn hit(mass: f64, velocity: f64, vehicle: Option<Vehicle>, degrees: f64) -> Hit {
    let impact = Impact {
        vehicle,
        ..Impact::rigid(mass, velocity)
    };
    Hit {
        impact,
        direction: degrees.to_radians(),
    }
}

/// Processor time of this thread \[ms\].
pub fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}
