//! Hits and limit loads in which the web yields in shear, against finite elements in plane stress.

use crate::found;
use crate::reference;
use crate::reference::{column, hit, section};
use column_beam::BeamModel;
use column_mechanics::{CrushCurve, CrushSpring, Vehicle};
use serde_json::Value;

/// Impacts in which 2 % of strength change the displacement by tens of per cent: the front gives just what the web bears.
const AT_THE_THRESHOLD: [&str; 4] = [
    "heb220_0.5_car500_20",
    "heb300_0.5_car900_20",
    "heb220_0.5_elastic300_20",
    "heb220_0.5_elastic300_30_b1e-2",
];

fn lines(text: &str) -> Vec<Value> {
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn number(case: &Value, name: &str) -> f64 {
    case[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {case}"))
}

fn numbers(case: &Value, name: &str) -> Vec<f64> {
    case[name]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

#[test]
fn hits_that_shear_the_web_agree_with_finite_elements() {
    let cases = lines(include_str!(
        "../../../mechanics/tests/data/shear_cases.jsonl"
    ));
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    const MEANS: [f64; 2] = [0.05; 2];
    let mut means = [(0.0, 0), (0.0, 0)];
    for case in &cases {
        let id = case["id"].as_str().unwrap();
        let name = case["section"].as_str().unwrap();
        let mut it = column(name, 355e6, number(case, "hardening_ratio"));
        it.shear = true;
        it.length_below = number(case, "length_below");
        it.length_above = number(case, "length_above");
        it.top_load = number(case, "load");
        it.top_spring_stiffness = 1e7;
        it.bumper_height = number(case, "bumper_height");
        let mass = number(case, "mass");
        let front = &case["front"];
        let vehicle = (!front.is_null()).then(|| {
            let points: Vec<[f64; 2]> = numbers(front, "crush")
                .into_iter()
                .zip(numbers(front, "force"))
                .filter(|(crush, _)| *crush > 0.0)
                .map(|(crush, force)| [crush, force])
                .collect();
            let spring = CrushSpring {
                envelope: CrushCurve::new(&points).unwrap(),
                unloading_stiffness: number(front, "ku"),
                slack: 0.0,
            };
            Vehicle::new(&[mass], &[spring]).unwrap()
        });
        let rigid = vehicle.is_none();
        let hit = hit(mass, number(case, "velocity"), vehicle, 0.0);
        let model = BeamModel::new(&it).unwrap();
        let began = reference::cpu();
        let found = model.respond(&hit).unwrap();
        let took = reference::cpu() - began;
        let (ratio, remains) = (
            found[0] / number(case, "max_v1"),
            found[1] / number(case, "residual_v1"),
        );
        let threshold = AT_THE_THRESHOLD.contains(&id);
        println!(
            "{id:34} v1 {ratio:.3} res {remains:.3} | {took:.1} ms {}",
            if threshold { "threshold" } else { "" }
        );
        rows.push(format!(
            "{id},{},{threshold},{:.5},{ratio:.4},{remains:.4}",
            if rigid { "rigid" } else { "deformable" },
            number(case, "max_v1"),
        ));
        if threshold {
            continue;
        }
        let mean = &mut means[usize::from(!rigid)];
        mean.0 += ratio;
        mean.1 += 1;
        let allowed = if rigid { 0.1 } else { 0.2 };
        if (ratio - 1.0).abs() > allowed {
            wrong.push(format!("{id} {ratio}"));
        }
    }
    for ((sum, count), allowed) in means.into_iter().zip(MEANS) {
        let mean = sum / f64::from(count);
        println!("mean of {count}: {mean:.4}");
        if (mean - 1.0_f64).abs() > allowed {
            wrong.push(format!("mean {mean}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "case,vehicle,threshold,peak_m,ratio,residual_ratio";
    found::keep("shear", header, &rows);
}

#[test]
fn limit_loads_agree_with_the_bounds_of_limit_analysis() {
    let cases = lines(include_str!(
        "../../../mechanics/tests/data/limit_loads.jsonl"
    ));
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    let mut extreme = [f64::INFINITY, 0.0_f64];
    for case in &cases {
        let name = case["section"].as_str().unwrap();
        let mut it = column(name, 355e6, 1e-5);
        // A hundred times stiffer steel reaches its limit load before the geometry changes, as limit analysis has it.
        it.steel.young_modulus *= 100.0;
        it.shear = true;
        it.length_below = number(case, "length_below");
        it.length_above = 4.0 - it.length_below;
        let properties = section(name).properties();
        it.top_load = number(case, "n") * properties.area * 355e6;
        it.bumper_height = if case["contact"] == "P" { 0.0 } else { 0.2 };
        let Ok(model) = BeamModel::new(&it) else {
            wrong.push(format!("{case} no model"));
            continue;
        };
        let found = model.lateral_resistance(1e-3).unwrap_or(f64::NAN);
        let middle = 0.5 * (number(case, "lower") + number(case, "upper"));
        let ratio = found / middle;
        rows.push(format!(
            "{name},{},{},{},{ratio:.4}",
            it.length_below,
            number(case, "n"),
            it.bumper_height
        ));
        sum += ratio;
        squares += ratio * ratio;
        count += 1.0;
        extreme = [extreme[0].min(ratio), extreme[1].max(ratio)];
        if (ratio - 1.0).abs() > 0.13 || ratio.is_nan() {
            wrong.push(format!("{case} {ratio}"));
        }
    }
    let mean: f64 = sum / count;
    println!(
        "{count}: mean {mean:.4} sd {:.4} {extreme:?}",
        (squares / count - mean * mean).sqrt()
    );
    assert!((mean - 1.0).abs() <= 0.03, "{mean}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    let header = "section,length_below_m,axial_ratio,bumper_m,ratio";
    found::keep("limit_loads", header, &rows);
}
