//! The push-down against reference data of other authorship, closed forms, and random columns.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use std::fs;
use std::path::Path;

use column_mechanics::{
    CapacityEnd, ColumnProperties, ElasticLaw, Impact, Model, PerBar, PlasticFlow, Progress,
    PushDown, Response, State, Support, capacity, carried_load, push_down, residual_state,
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
            ..PlasticFlow::default()
        },
        above: PlasticFlow {
            elongation: [0.5 * b, 0.5 * b],
            rotation: [r1b, r2],
            ..PlasticFlow::default()
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

/// The mechanism limit `N w = 2 M(N)`: solved for HEB 220 in S355, and met by the push-down of damaged columns.
#[test]
fn the_force_of_a_damaged_column_is_that_of_its_mechanism() {
    let (mut p, _) = example(&["yield_surface.alpha:=1.0", "yield_surface.beta:=1.3"]);
    p.resistance_moment = 293.6e3;
    p.resistance_axial = 3232e3;
    let surface = Model::new(&p).expect("a column").frame.below.surface;
    for (w, expected) in [(0.05, 2654e3), (0.1, 2236e3), (0.2, 1681e3)] {
        let (mut low, mut high) = (0.0, p.resistance_axial);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle * w < 2.0 * surface.moment_resistance(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        assert!((low - expected).abs() < 1e3, "w {w}: {low}");
    }
    for (name, case) in cases().as_object().expect("cases") {
        let model = Model::new(&column(case)).expect("a column");
        let state = at_rest(&model, plastic(case));
        let found = capacity(&model, &state, case["e0"].as_f64().expect("e0")).expect("N_u");
        let limit = 2.0 * model.frame.below.surface.moment_resistance(found.force);
        let ratio = found.force * found.v1 / limit;
        println!("{name}: N w / 2 M(N) = {ratio:.4}");
        assert!((0.9..1.02).contains(&ratio), "{name}: {ratio}");
    }
}

/// An elastic column with a bow: `N = N_cr (1 - e0 / v1)`, with the critical load of two rigid bars and elastic springs.
#[test]
fn an_elastic_column_follows_its_critical_load() {
    let (mut p, _) = example(&["hinge.elastic_law:=coupled"]);
    p.length_below = 4.0;
    p.length_above = 4.0;
    p.base = Support::Pinned;
    p.top = Support::Pinned;
    p.resistance_moment *= 100.0;
    p.resistance_axial *= 100.0;
    p.top_load = 0.0;
    let model = Model::new(&p).expect("a column");
    let critical = 12.0 * p.bending_stiffness / 64.0;
    let mut checked = 0;
    let bow = 0.002;
    push_down(&model, &State::at_rest(&model), bow, &mut |point| {
        if (2.0 * bow..50.0 * bow).contains(&point.v1) {
            let expected = critical * (1.0 - bow / point.v1);
            assert!(
                (point.force / expected - 1.0).abs() < 5e-3,
                "{point:?} {expected}"
            );
            checked += 1;
        }
    })
    .expect("a capacity");
    assert!(checked > 20, "{checked}");
}

/// Slices change nothing, and nothing is allocated.
#[test]
fn a_push_down_in_slices_is_the_same_bit_for_bit() {
    let (p, _) = example(&[]);
    let model = Model::new(&p).expect("a column");
    let state = State::at_rest(&model);
    let mut whole = None;
    let allocated = allocation_counter::measure(|| {
        whole = Some(capacity(&model, &state, 0.016).expect("a capacity"));
    });
    assert_eq!(allocated.count_total, 0);
    let mut sliced = PushDown::new(&model, &state, 0.016).expect("a push-down");
    let found = loop {
        if let Some(found) = sliced.advance(7) {
            break found;
        }
    };
    assert_eq!(Some(found), whole);
    let carried = carried_load(&model, &state);
    assert!((carried / -model.rest.normal_force - 1.0).abs() < 1e-12);
}

#[test]
fn an_imperfection_out_of_range_is_rejected() {
    let (p, _) = example(&[]);
    let model = Model::new(&p).expect("a column");
    for bow in [0.0, -0.01, f64::NAN, 0.41, f64::INFINITY] {
        let error = capacity(&model, &State::at_rest(&model), bow).expect_err("out of range");
        assert!(error.to_string().contains("at most 0.4 m"), "{error}");
    }
}

/// A little damage takes a little of the capacity. Where both hinges of the joint began to flow in one increment, the push-down
/// once leapt to an equilibrium far away, or gave up, and lost up to 6 %.
#[test]
fn the_capacity_falls_steadily_with_the_first_damage() {
    let model = Model::new(&example(&[]).0).expect("a column");
    let mut before = capacity(&model, &State::at_rest(&model), 0.016).expect("a bow");
    for tenths in 10..=30 {
        let mut state = State::at_rest(&model);
        let impact = Impact::rigid(1500.0, 0.1 * f64::from(tenths));
        let mut response = Response::begin(&model, &mut state, impact, 2.0).expect("an impact");
        while response
            .advance(&model, &mut state, u64::MAX)
            .expect("converges")
            == Progress::Running
        {}
        let rest = residual_state(&model, &state).expect("stands");
        let now = capacity(&model, &rest, 0.016).expect("a bow");
        assert_eq!(now.end, CapacityEnd::ForceFell, "at {tenths} dm/s");
        let change = now.force / before.force - 1.0;
        assert!(
            (-5e-4..=1e-6).contains(&change),
            "{change:e} at {tenths} dm/s"
        );
        before = now;
    }
}

/// A car bends the base of a column in S355 and leaves it 2.4 % short of its capacity. Where the bent base yielded first, the column
/// straightened while it was shortened; the push-down then gave up, and lost up to a quarter.
#[test]
fn a_push_down_that_straightens_the_column_first_is_followed() {
    let (mut p, _) = example(&["yield_surface.alpha:=1.0", "yield_surface.beta:=1.3"]);
    p.resistance_moment = 293.6e3;
    p.elastic_law = ElasticLaw::Coupled;
    let model = Model::new(&p).expect("a column");
    let e0 = 0.0117;
    let undamaged = capacity(&model, &State::at_rest(&model), e0).expect("a bow");
    let mut before = undamaged;
    for step in 1..=30 {
        let rotation = 2.5e-4 * f64::from(step);
        let state = at_rest(
            &model,
            PerBar {
                below: PlasticFlow {
                    elongation: [0.0, -0.065 * rotation],
                    rotation: [0.0, rotation],
                    ..PlasticFlow::default()
                },
                above: PlasticFlow::default(),
            },
        );
        let now = capacity(&model, &state, e0).expect("a bow");
        assert_eq!(now.end, CapacityEnd::ForceFell, "at {rotation} rad");
        let change = now.force / before.force - 1.0;
        assert!(
            (-3e-3..=3e-4).contains(&change),
            "{change:e} at {rotation} rad"
        );
        before = now;
    }
    let ratio = before.force / undamaged.force;
    assert!((0.97..0.98).contains(&ratio), "{ratio}");
}
