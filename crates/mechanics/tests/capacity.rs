//! The push-down against reference data of other authorship, closed forms, and random columns.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use std::fs;
use std::path::Path;

use column_mechanics::{
    CapacityEnd, ColumnProperties, Model, PerBar, PlasticFlow, State, capacity, residual_state,
};
use example::example;
use serde_json::Value;

fn cases() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/push_down_cases.json");
    let text = fs::read_to_string(path).expect("the reference");
    serde_json::from_str::<Value>(&text).expect("JSON")["pushdown"].take()
}

/// The column of a reference case.
fn column(case: &Value) -> ColumnProperties {
    let mut p = example(&[]).0;
    let set = |name: &str, value: &mut f64| {
        if let Some(given) = case["case"][name].as_f64() {
            *value = given;
        }
    };
    set("alpha", &mut p.yield_surface.alpha);
    set("beta", &mut p.yield_surface.beta);
    set("La", &mut p.length_below);
    set("Lb", &mut p.length_above);
    p
}

fn plastic(case: &Value) -> PerBar<PlasticFlow> {
    let strains: Vec<f64> = case["ref"]["plastic_strains"]
        .as_array()
        .expect("six strains")
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect();
    let [a, b, r1a, r1b, r2, r3] = strains[..] else {
        panic!("six strains")
    };
    PerBar {
        below: PlasticFlow {
            elongation: [0.5 * a, 0.5 * a],
            rotation: [r1a, r3],
        },
        above: PlasticFlow {
            elongation: [0.5 * b, 0.5 * b],
            rotation: [r1b, r2],
        },
    }
}

/// The static equilibrium under the load with these plastic strains.
fn at_rest(model: &Model, plastic: PerBar<PlasticFlow>) -> State {
    let moved = State::at_rest(model).displacement;
    residual_state(model, &State::settled(model, moved, plastic)).expect("an equilibrium")
}

#[test]
fn push_down_agrees_with_the_reference() {
    let cases = cases();
    for (name, case) in cases.as_object().expect("cases") {
        let model = Model::new(&column(case)).expect("a column");
        let e0 = case["e0"].as_f64().expect("e0");
        let number = |group: &str, name: &str| case[group][name].as_f64().expect("a number");
        let damaged = at_rest(&model, plastic(case));
        let error = damaged.displacement.v1 / number("ref", "v_residual") - 1.0;
        assert!(error.abs() < 1e-9, "{name}: v_residual {error:e}");
        for (which, state, at) in [
            ("Nu_virgin", State::at_rest(&model), "v_at_Nu_virgin"),
            ("Nu_damaged", damaged, "v_at_Nu_damaged"),
        ] {
            let found = capacity(&model, &state, e0).expect("a capacity");
            let error = found.force / number("ref", which) - 1.0;
            println!(
                "{name} {which}: {:.1} N, {error:+.2e}, v1 {:.6} for {:.6}, {} evaluations",
                found.force,
                found.v1,
                number("ref", at),
                found.evaluations
            );
            assert_eq!(found.end, CapacityEnd::ForceFell);
            assert!(error.abs() < number("tol", which), "{name} {which}");
        }
    }
}
