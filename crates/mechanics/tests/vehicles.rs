//! Compliant vehicles against reference solutions by an unrelated program, closed forms and a measured wall test.

mod example;

use std::fs;
use std::path::Path;

use column_mechanics::{
    ColumnProperties, CrushCurve, CrushSpring, Impact, Model, Report, Response, Scheme, State,
    Vehicle, residual_state,
};
use example::paper;
use serde_json::Value;

fn spring(points: &[[f64; 2]], unloading_stiffness: f64, slack: f64) -> CrushSpring {
    CrushSpring {
        envelope: CrushCurve::new(points).expect("a curve"),
        unloading_stiffness,
        slack,
    }
}

fn impact(vehicle: Vehicle, velocity: f64) -> Impact {
    Impact {
        vehicle: Some(vehicle),
        ..Impact::rigid(vehicle.total_mass(), velocity)
    }
}

/// One reference case.
struct Case {
    name: String,
    column: ColumnProperties,
    impact: Impact,
    duration: f64,
    reference: Value,
    tolerance: Value,
}

/// All reference cases with a compliant vehicle and without a strain rate.
fn cases() -> Vec<Case> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reality_cases.json");
    let text = fs::read_to_string(path).expect("the reference");
    let all: Value = serde_json::from_str(&text).expect("JSON");
    let cases = all["dynamic"].as_object().expect("cases").iter();
    cases
        .filter(|(_, it)| it["case"]["rate"].is_null() && it["case"]["vehicle"]["rigid"].is_null())
        .map(|(name, it)| Case {
            name: name.clone(),
            column: column(&it["case"]),
            impact: struck(&it["case"]["vehicle"]),
            duration: it["T"].as_f64().expect("a duration"),
            reference: it["ref"].clone(),
            tolerance: it["tol"].clone(),
        })
        .collect()
}

/// The paper's column with the values that a case changes.
fn column(case: &Value) -> ColumnProperties {
    const YOUNG_MODULUS: f64 = 210e9;
    let (mut column, _) = paper();
    for (key, value) in case.as_object().expect("a case") {
        let number = || value.as_f64().expect("a number");
        match key.as_str() {
            "A" => column.axial_rigidity = YOUNG_MODULUS * number(),
            "I" => column.bending_stiffness = YOUNG_MODULUS * number(),
            "Mp" => column.resistance_moment = number(),
            "Np" => column.resistance_axial = number(),
            "mass_per_length" => column.mass_per_length = number(),
            "La" => column.length_below = number(),
            "Lb" => column.length_above = number(),
            "P" => column.top_load = number(),
            "alpha" => column.yield_surface.alpha = number(),
            "beta" => column.yield_surface.beta = number(),
            "vehicle" => {}
            other => panic!("unknown key {other}"),
        }
    }
    column
}

fn struck(vehicle: &Value) -> Impact {
    let numbers = |value: &Value| -> Vec<f64> {
        let values = value.as_array().expect("numbers").iter();
        values.map(|it| it.as_f64().expect("a number")).collect()
    };
    let springs: Vec<_> = vehicle["springs"]
        .as_array()
        .expect("springs")
        .iter()
        .map(|it| {
            let points = it["points"].as_array().expect("points").iter();
            let points: Vec<[f64; 2]> = points
                .map(|point| numbers(point).try_into().expect("a pair"))
                .collect();
            let stiffness = it["ku"].as_f64().expect("a stiffness");
            spring(&points, stiffness, it["slack"].as_f64().unwrap_or(0.0))
        })
        .collect();
    let made = Vehicle::new(&numbers(&vehicle["masses"]), &springs).expect("a vehicle");
    Impact {
        gap: vehicle["gap"].as_f64().expect("a gap"),
        ..impact(made, vehicle["v0"].as_f64().expect("a speed"))
    }
}

/// The response up to `duration`, at rest or not.
fn follow(column: &ColumnProperties, impact: Impact, duration: f64) -> (Model, State, Report) {
    let model = Model::new(column).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, duration).expect("an impact");
    let steps = (duration * 1e9 / column.step_nanos as f64).round() as u64;
    let mut end = None;
    while state.step < steps {
        if let column_mechanics::Progress::Over(over) =
            response.advance(&model, &mut state, 1).expect("a step")
        {
            end = Some(over);
        }
    }
    let report = response.report(&model, &state, end.expect("the duration has passed"));
    (model, state, report)
}

/// The quantities of a reference, by their names there.
fn found(model: &Model, state: &State, report: &Report, name: &str) -> Vec<f64> {
    let vehicle = &report.vehicle;
    let some = |values: [f64; 3]| values[..vehicle.masses].to_vec();
    match name {
        "vmax" => vec![report.max_v1],
        "tvmax" => vec![report.max_v1_time],
        "peak_contact" => vec![report.peak_contact_force],
        "impulse" => vec![report.impulse],
        "t_release" => vec![report.release_time.expect("released")],
        "plastic_work" => vec![report.plastic_work],
        "v_residual" => {
            let rest = residual_state(model, state).expect("an equilibrium");
            vec![rest.displacement.v1]
        }
        "u2max" => vec![report.max_u2],
        "crush_max" => some(vehicle.max_crush),
        "crush_permanent" => some(vehicle.permanent_crush),
        "spring_dissipated" => some(vehicle.dissipated),
        "vehicle_velocity_end" => some(vehicle.velocity),
        "impact_loss" => vec![report.impact_loss],
        other => panic!("unknown quantity {other}"),
    }
}

/// The relative errors of all quantities that a case bounds, each with its tolerance.
fn errors(case: &Case, column: &ColumnProperties) -> Vec<(String, f64, f64)> {
    let (model, state, report) = follow(column, case.impact, case.duration);
    let bounds = case.tolerance.as_object().expect("tolerances").iter();
    let mut errors = Vec::new();
    for (name, tolerance) in bounds {
        let reference = &case.reference[name];
        let reference: Vec<f64> = match reference.as_array() {
            Some(values) => values.iter().filter_map(Value::as_f64).collect(),
            None => vec![reference.as_f64().expect("a number")],
        };
        let found = found(&model, &state, &report, name);
        assert_eq!(found.len(), reference.len(), "{name}");
        for (index, (found, expected)) in found.into_iter().zip(reference).enumerate() {
            // Velocities relative to that of the event, small numbers to the size of their kind.
            let scale = match name.as_str() {
                "vehicle_velocity_end" => case.impact.velocity,
                "spring_dissipated" | "impact_loss" => {
                    expected.abs().max(1e-3 * report.input_energy)
                }
                "crush_permanent" => expected.abs().max(1e-3),
                _ => expected.abs(),
            };
            let error = (found - expected) / scale;
            let tolerance = tolerance.as_f64().expect("a tolerance");
            errors.push((format!("{} {name}[{index}]", case.name), error, tolerance));
        }
    }
    if column.scheme == Scheme::ConservingMidpoint {
        errors.push((
            format!("{} ledger", case.name),
            report.ledger_residual,
            1e-10,
        ));
    }
    errors
}

fn check(scheme: Scheme, step_nanos: u64, factor: f64) {
    let mut failures = Vec::new();
    for case in cases() {
        let column = ColumnProperties {
            scheme,
            step_nanos,
            ..case.column
        };
        for (name, error, tolerance) in errors(&case, &column) {
            println!("{name:<40}{error:>12.2e}{tolerance:>10.1e}");
            if error.abs() > factor * tolerance {
                failures.push(format!("{name}: {error:e} exceeds {tolerance:e}"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn the_conserving_scheme_meets_the_reference() {
    assert_eq!(cases().len(), 5);
    check(Scheme::ConservingMidpoint, 20_000, 1.0);
}

#[test]
fn the_papers_scheme_meets_the_reference() {
    check(Scheme::Midpoint, 20_000, 1.0);
}
