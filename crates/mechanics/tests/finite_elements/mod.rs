//! Columns and impacts of the finite-element references for shear.

use column_mechanics::{
    ColumnProperties, CrushCurve, CrushSpring, ElasticLaw, Impact, RolledSection, Scheme, Vehicle,
    YieldExponents,
};
use serde_json::Value;

use crate::example::paper;

pub const YOUNG_MODULUS: f64 = 210e9;

pub const YIELD_STRENGTH: f64 = 355e6;

pub const POISSON_RATIO: f64 = 0.3;

/// Impacts in which 2 % of strength change the displacement by tens of per cent: the front gives just what the web bears.
pub const AT_THE_THRESHOLD: [&str; 4] = [
    "heb220_0.5_car500_20",
    "heb300_0.5_car900_20",
    "heb220_0.5_elastic300_20",
    "heb220_0.5_elastic300_30_b1e-2",
];

pub fn lines(data: &str) -> Vec<Value> {
    data.lines()
        .map(|line| serde_json::from_str(line).expect("a case"))
        .collect()
}

pub fn number(case: &Value, name: &str) -> f64 {
    case[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {case}"))
}

pub fn text<'a>(case: &'a Value, name: &str) -> &'a str {
    case[name].as_str().expect("a text")
}

pub fn section(name: &str) -> RolledSection {
    let [h, b, tw, tf, r] = match name {
        "HEA300" => [290.0, 300.0, 8.5, 14.0, 27.0],
        "HEB140" => [140.0, 140.0, 7.0, 12.0, 12.0],
        "HEB220" => [220.0, 220.0, 9.5, 16.0, 18.0],
        "HEB300" => [300.0, 300.0, 11.0, 19.0, 27.0],
        "IPE300" => [300.0, 150.0, 7.1, 10.7, 15.0],
        other => panic!("unknown section {other}"),
    };
    RolledSection {
        depth: h * 1e-3,
        width: b * 1e-3,
        web_thickness: tw * 1e-3,
        flange_thickness: tf * 1e-3,
        root_radius: r * 1e-3,
    }
}

/// A column of 4 m of a section in S355, built in at both ends, with shear.
pub fn column(
    name: &str,
    [length_below, length_above]: [f64; 2],
    hardening_ratio: f64,
    bumper_height: f64,
) -> ColumnProperties {
    let section = section(name);
    let made = section.properties();
    let mut shear = section.shear(
        YIELD_STRENGTH,
        YOUNG_MODULUS,
        POISSON_RATIO,
        hardening_ratio,
    );
    shear.bumper_height = bumper_height;
    ColumnProperties {
        length_below,
        length_above,
        axial_rigidity: YOUNG_MODULUS * made.area,
        bending_stiffness: YOUNG_MODULUS * made.second_moment,
        mass_per_length: made.mass_per_length,
        resistance_moment: YIELD_STRENGTH * made.plastic_modulus,
        resistance_axial: YIELD_STRENGTH * made.area,
        yield_surface: YieldExponents {
            alpha: 1.0,
            beta: 1.3,
            gamma: 1.0,
        },
        elastic_law: ElasticLaw::Coupled,
        hardening_ratio,
        shear: Some(shear),
        step_nanos: 0,
        ..paper().0
    }
}

pub fn vehicle(case: &Value) -> Option<Vehicle> {
    let front = case["front"].as_object()?;
    let numbers = |name: &str| front[name].as_array().expect("numbers").clone();
    let points: Vec<[f64; 2]> = numbers("crush")
        .iter()
        .zip(numbers("force"))
        .map(|(crush, force)| [crush, &force].map(|it| it.as_f64().expect("a number")))
        .collect();
    let spring = CrushSpring {
        envelope: CrushCurve::new(&points).expect("a curve"),
        unloading_stiffness: front["ku"].as_f64().expect("a stiffness"),
        slack: 0.0,
    };
    Some(Vehicle::new(&[number(case, "mass")], &[spring]).expect("a vehicle"))
}

/// The column and the impact of a case.
pub fn case(case: &Value, scheme: Scheme) -> (ColumnProperties, Impact) {
    let lengths = ["length_below", "length_above"].map(|name| number(case, name));
    let properties = ColumnProperties {
        top_load: number(case, "load"),
        scheme,
        ..column(
            text(case, "section"),
            lengths,
            number(case, "hardening_ratio"),
            number(case, "bumper_height"),
        )
    };
    let impact = Impact {
        mass: number(case, "mass"),
        velocity: number(case, "velocity"),
        gap: 0.0,
        restitution: 0.0,
        vehicle: vehicle(case),
        bumper_height: 0.0,
        transverse_force: 0.0,
    };
    (properties, impact)
}
