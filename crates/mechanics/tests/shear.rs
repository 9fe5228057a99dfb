//! Shear of the web against finite elements: impacts, limit loads.

mod example;

use column_mechanics::{
    ColumnProperties, CrushCurve, CrushSpring, ElasticLaw, Impact, Model, Report, RolledSection,
    Scheme, Vehicle, YieldExponents, plastic_plateau, respond,
};
use example::paper;
use serde_json::Value;

const SCHEMES: [Scheme; 2] = [Scheme::ConservingMidpoint, Scheme::Midpoint];

const YOUNG_MODULUS: f64 = 210e9;

const YIELD_STRENGTH: f64 = 355e6;

const POISSON_RATIO: f64 = 0.3;

/// Longest response \[s\].
const DURATION: f64 = 2.0;

/// Impacts in which 2 % of strength change the displacement by tens of per cent: the front gives just what the web bears.
const AT_THE_THRESHOLD: [&str; 4] = [
    "heb220_0.5_car500_20",
    "heb300_0.5_car900_20",
    "heb220_0.5_elastic300_20",
    "heb220_0.5_elastic300_30_b1e-2",
];

fn lines(data: &str) -> Vec<Value> {
    data.lines()
        .map(|line| serde_json::from_str(line).expect("a case"))
        .collect()
}

fn number(case: &Value, name: &str) -> f64 {
    case[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {case}"))
}

fn text<'a>(case: &'a Value, name: &str) -> &'a str {
    case[name].as_str().expect("a text")
}

fn section(name: &str) -> RolledSection {
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
fn column(
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

fn vehicle(case: &Value) -> Option<Vehicle> {
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
fn case(case: &Value, scheme: Scheme) -> (ColumnProperties, Impact) {
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
    };
    (properties, impact)
}

fn response(properties: &ColumnProperties, impact: &Impact) -> Report {
    respond(properties, impact, DURATION).expect("a response")
}

/// 44 impacts that an explicit finite-element code in plane stress computed, without a cap of the hardening.
#[test]
fn impacts_of_finite_elements() {
    let mut failures = Vec::new();
    for scheme in SCHEMES {
        let (mut soft, mut rigid) = (Vec::new(), Vec::new());
        for reference in lines(include_str!("data/shear_cases.jsonl")) {
            let id = text(&reference, "id");
            let (properties, impact) = case(&reference, scheme);
            let report = response(&properties, &impact);
            let expected = number(&reference, "max_v1");
            let expected_residual = number(&reference, "residual_v1");
            let residual = report.residual_v1.unwrap_or(f64::NAN);
            let ratio = report.max_v1 / expected;
            println!(
                "{scheme:?} {id:<34} v1 {:7.2} mm, reference {:7.2}, ratio {ratio:.3}, two bars {:.3}; \
                 residual {:7.2}, reference {:7.2}; angle {:.3} {:?} {:?}",
                1e3 * report.max_v1,
                1e3 * expected,
                number(&reference, "two_bar_v1") / report.max_v1,
                1e3 * residual,
                1e3 * expected_residual,
                report.webs[0].plastic_angle,
                report.outcome,
                report.end,
            );
            if AT_THE_THRESHOLD.contains(&id) {
                continue;
            }
            let tolerance = if impact.vehicle.is_some() {
                soft.push(ratio);
                0.20
            } else {
                rigid.push(ratio);
                0.10
            };
            for (found, expected) in [(report.max_v1, expected), (residual, expected_residual)] {
                let error = (found - expected).abs();
                // A residual is as uncertain as the displacement of which it is the rest.
                if !(error <= (tolerance * expected).max(2e-3)) {
                    failures.push(format!(
                        "{scheme:?} {id}: {found} m instead of {expected} m"
                    ));
                }
            }
        }
        for (name, ratios) in [("rigid", &rigid), ("soft", &soft)] {
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            println!("{scheme:?} {name}: mean {mean:.3} of {}", ratios.len());
            if !((mean - 1.0).abs() <= 0.08) {
                failures.push(format!("{scheme:?} {name}: mean {mean}"));
            }
        }
        assert_eq!(rigid.len() + soft.len(), 40);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// 287 limit loads, each between rigorous bounds of a limit analysis with finite elements. A pressure over the bumper's height
/// (U) and a point (P) leave the bars their whole length, a rigid bumper (B) does not.
#[test]
fn limit_loads_of_finite_elements() {
    let cases = lines(include_str!("data/limit_loads.jsonl"));
    assert_eq!(cases.len(), 287);
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for case in &cases {
        let below = number(case, "length_below");
        let bumper = if text(case, "contact") == "B" {
            0.2
        } else {
            0.0
        };
        let properties = column(text(case, "section"), [below, 4.0 - below], 0.0, bumper);
        let model = Model::new(&ColumnProperties {
            top_load: 0.0,
            ..properties
        })
        .expect("a column");
        let found = plastic_plateau(&model, number(case, "n") * properties.resistance_axial);
        let middle = 0.5 * (number(case, "lower") + number(case, "upper"));
        let error = found / middle - 1.0;
        assert!(error.abs() <= 0.13, "{error:.3}: {case}");
        sum += error;
        least = error.min(least);
        most = error.max(most);
    }
    let mean = sum / cases.len() as f64;
    println!("mean {mean:.4}, {least:.4} to {most:.4}");
    assert!(mean.abs() <= 0.02, "{mean}");
}
