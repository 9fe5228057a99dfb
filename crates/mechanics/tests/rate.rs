//! Strain rate, hardening and fractured hinges: reference solutions of an unrelated program, closed forms, properties.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use column_mechanics::{
    ColumnProperties, End, Impact, Model, ModelError, Outcome, Progress, RateLaw, RateProperties,
    Report, Response, Sample, State, residual_state, simulate,
};
use example::{ceb, example};
use serde_json::Value;

const DUAN_CHEN: [&str; 3] = [
    "yield_surface.alpha:=1.0",
    "yield_surface.beta:=1.3",
    "yield_surface.gamma:=1.0",
];

const SCHEMES: [&str; 2] = [
    "solver.scheme:=midpoint",
    "solver.scheme:=conserving_midpoint",
];

/// Mild steel, without an upper limit that would be reached.
fn cowper_symonds(d: f64, q: f64, section_height: f64) -> RateProperties {
    RateProperties {
        law: RateLaw::CowperSymonds { d, q },
        time_constant: 1e-3,
        max_factor: 10.0,
        hinge_length: section_height,
        section_height,
    }
}

fn respond(properties: &ColumnProperties, impact: &Impact, duration: f64) -> (Report, Vec<Sample>) {
    let mut samples = Vec::new();
    let report = simulate(properties, impact, duration, &mut |sample| {
        samples.push(*sample);
    })
    .expect("a response");
    (report, samples)
}

fn reference(name: &str) -> Value {
    let all: Value =
        serde_json::from_str(include_str!("data/reality_cases.json")).expect("reference cases");
    all["dynamic"][name].clone()
}

/// The column and the impact of a reference case, whose numbers replace those of the paper's example.
fn case(reference: &Value) -> (ColumnProperties, Impact) {
    let (mut p, _) = example(&[]);
    let case = &reference["case"];
    let set = |into: &mut f64, name: &str, factor: f64| {
        if let Some(value) = case[name].as_f64() {
            *into = factor * value;
        }
    };
    set(&mut p.axial_rigidity, "A", 210e9);
    set(&mut p.bending_stiffness, "I", 210e9);
    set(&mut p.resistance_moment, "Mp", 1.0);
    set(&mut p.resistance_axial, "Np", 1.0);
    set(&mut p.mass_per_length, "mass_per_length", 1.0);
    set(&mut p.yield_surface.alpha, "alpha", 1.0);
    set(&mut p.yield_surface.beta, "beta", 1.0);
    set(&mut p.top_load, "P", 1.0);
    p.yield_surface.gamma = 1.0;
    let number = |value: &Value| value.as_f64().expect("a number");
    let rate = &case["rate"];
    p.rate = Some(RateProperties {
        time_constant: number(&rate["tau"]),
        ..cowper_symonds(number(&rate["D"]), number(&rate["q"]), number(&rate["h"]))
    });
    let vehicle = &case["vehicle"];
    assert_eq!(vehicle["rigid"], Value::Bool(true));
    let impact = Impact::rigid(number(&vehicle["masses"][0]), number(&vehicle["v0"]));
    (p, impact)
}

#[test]
fn reference_cases_with_strain_rate_are_met() {
    for name in ["rigid_rate_duan_chen"] {
        let reference = reference(name);
        let (properties, impact) = case(&reference);
        let duration = reference["T"].as_f64().expect("a duration");
        let (report, _) = respond(&properties, &impact, duration);
        let found = [
            ("vmax", report.max_v1),
            ("tvmax", report.max_v1_time),
            ("peak_contact", report.peak_contact_force),
            ("impulse", report.impulse),
            ("t_release", report.release_time.expect("release")),
            ("plastic_work", report.plastic_work),
            ("v_residual", report.residual_v1.expect("a residual state")),
            ("u2max", report.max_u2),
            ("impact_loss", report.impact_loss),
        ];
        let mut failures = Vec::new();
        let mut compare = |quantity: &str, error: f64| {
            let allowed = reference["tol"][quantity].as_f64().expect("a tolerance");
            println!("{name}: {quantity} {error:+.2e}, allowed {allowed:.0e}");
            if error.is_nan() || error.abs() > allowed {
                failures.push(format!("{name}: {quantity} {error:+e}"));
            }
        };
        for (quantity, value) in found {
            let expected = reference["ref"][quantity].as_f64().expect("a reference");
            compare(quantity, value / expected - 1.0);
        }
        let velocity = reference["ref"]["vehicle_velocity_end"][0]
            .as_f64()
            .expect("a velocity");
        compare(
            "vehicle_velocity_end",
            (report.impactor_velocity - velocity) / impact.velocity,
        );
        assert!(failures.is_empty(), "{failures:#?}");
        // 1a and 1b share a rate; the reference lists 1, 2 and 3.
        let [joint, above, top, base] = report.max_dynamic_factor;
        assert_eq!(joint, above);
        for (index, factor) in [joint, top, base].into_iter().enumerate() {
            let expected = reference["ref"]["max_DIF"][index]
                .as_f64()
                .expect("a factor");
            println!("{name}: largest factor {factor:.5}, reference {expected:.5}");
            assert!((factor - expected).abs() <= 1e-3);
        }
        assert!(report.ledger_residual <= 1e-10);
    }
}

/// The errors of the peak displacement fall with the square of the step; between the schemes nothing but the step
/// differs.
#[test]
fn responses_with_rate_and_hardening_converge_with_the_step() {
    for scheme in SCHEMES {
        for exponents in [&DUAN_CHEN[..], &[]] {
            for hardening in [0.0, 0.01] {
                let at = |dt: &str| {
                    let dt = format!("solver.dt:={dt}");
                    let (mut properties, impact) =
                        example(&[&[scheme, dt.as_str()], exponents].concat());
                    properties.rate = Some(ceb());
                    properties.hardening_ratio = hardening;
                    respond(&properties, &impact, 0.05).0
                };
                let finest = at("1.0e-6");
                let errors = ["1.0e-4", "2.0e-5", "4.0e-6"].map(|dt| {
                    let report = at(dt);
                    let of = |found: f64, limit: f64| (found / limit - 1.0).abs();
                    let error = of(report.max_v1, finest.max_v1);
                    println!(
                        "{scheme} {exponents:?} b {hardening} dt {dt}: peak v1 {error:.1e}, work {:.1e}",
                        of(report.plastic_work, finest.plastic_work)
                    );
                    error
                });
                assert!(
                    errors[0] <= 5e-4 && errors[1] <= 3e-5 && errors[2] <= 2e-6,
                    "{errors:?}"
                );
            }
        }
    }
}

/// Both schemes solve the same equations.
#[test]
fn both_schemes_agree_in_the_limit() {
    let at = |scheme: &str| {
        let (mut properties, impact) =
            example(&[&[scheme, "solver.dt:=2.0e-6"], &DUAN_CHEN[..]].concat());
        properties.rate = Some(ceb());
        properties.hardening_ratio = 0.01;
        respond(&properties, &impact, 0.03).0
    };
    let [one, other] = SCHEMES.map(at);
    for (one, other) in [
        (one.max_v1, other.max_v1),
        (one.plastic_work, other.plastic_work),
        (one.max_dynamic_factor[0], other.max_dynamic_factor[0]),
        (one.max_dynamic_factor[2], other.max_dynamic_factor[2]),
    ] {
        println!("{one:.6} {other:.6}: {:+.1e}", one / other - 1.0);
        assert!((one / other - 1.0).abs() <= 2e-4);
    }
}

#[test]
fn the_laws_have_their_values() {
    let law = RateLaw::CowperSymonds { d: 40.4, q: 5.0 };
    assert_eq!(law.factor(0.0), 1.0);
    assert!((law.factor(40.4) - 2.0).abs() < 1e-15);
    assert!((law.factor(1.0) - (1.0 + (1.0_f64 / 40.4).powf(0.2))).abs() < 1e-15);
    let law = ceb().law;
    assert_eq!([law.factor(0.0), law.factor(5e-5)], [1.0; 2]);
    let stress = 355.0 + 6.0 * (2.0_f64 / 5e-5).ln();
    assert!((law.factor(2.0) - stress / 355.0).abs() < 1e-15);
}

/// A column whose hinge at the base turns at a constant speed has the filtered rate of the closed form.
#[test]
fn the_filter_follows_a_constant_rate_exactly() {
    // A large mass on a column that hardly resists keeps its speed.
    let (mut properties, mut impact) = example(&["top.spring_stiffness:=0.0", "top.load:=0.0"]);
    properties.resistance_moment = 1.0;
    properties.resistance_axial = 1e2;
    impact.mass = 1e9;
    impact.velocity = 1.0;
    let d = 40.4;
    properties.rate = Some(cowper_symonds(d, 5.0, 0.2));
    let model = Model::new(&properties).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, 1.0).expect("an impact");
    for _ in 0..200 {
        response.advance(&model, &mut state, 1).expect("a step");
    }
    let time = model.time_of_step(state.step);
    // theta_3' = v / (1 + (v t)^2): falls by 2e-5 over 4 ms; theta_2' is a third of it.
    let followed = 1.0 - (-time / 1e-3_f64).exp();
    for (found, rate) in [
        (state.strength.below[1], 0.5),
        (state.strength.above[1], 0.5 / 3.0),
        (state.strength.below[0], 0.25 * (1.0 + 1.0 / 3.0)),
        (state.strength.above[0], 0.25 * (1.0 + 1.0 / 3.0)),
    ] {
        let expected = rate * followed;
        println!("{:.8} {expected:.8}", found.strain_rate);
        assert!((found.strain_rate / expected - 1.0).abs() < 5e-5);
        let factor = 1.0 + (expected / d).powf(0.2);
        assert!((found.factors.dynamic - factor).abs() < 1e-4);
    }
}

/// Plastic curvature `(M - M_p) / (b EI)` beyond the yield moment, along a bar whose moment falls with the slope
/// `2 M_p / L` from its end, added up numerically.
#[test]
fn hardening_is_that_of_yielding_which_spreads_along_a_bar() {
    let (mut properties, impact) = example(&DUAN_CHEN);
    let b = 0.01;
    properties.hardening_ratio = b;
    let model = Model::new(&properties).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, 0.015).expect("an impact");
    while response.advance(&model, &mut state, 1).expect("a step") == Progress::Running {}
    for (length, hinges) in [
        (properties.length_below, state.strength.below),
        (properties.length_above, state.strength.above),
    ] {
        for hinge in hinges {
            let factor = hinge.factors.hardening;
            let (yield_moment, stiffness) =
                (properties.resistance_moment, properties.bending_stiffness);
            let slope = 2.0 * yield_moment / length;
            let zone = (factor - 1.0) * yield_moment / slope;
            let pieces = 1_000;
            let piece = zone / f64::from(pieces);
            let rotation: f64 = (0..pieces)
                .map(|k| {
                    let excess = slope * (zone - (f64::from(k) + 0.5) * piece);
                    excess / (b * stiffness) * piece
                })
                .sum();
            let error = rotation / hinge.accumulated_rotation - 1.0;
            println!("L {length}: H {factor:.4}, rotation {rotation:.6} {error:+.1e}");
            assert!(factor > 1.1);
            // The factor is predicted, so that it lags by the change of the flow in one step.
            assert!(error.abs() < 2e-3);
        }
    }
}

#[test]
fn strength_without_effect_changes_no_bit() {
    for scheme in SCHEMES {
        let (plain, impact) = example(&[&[scheme], &DUAN_CHEN[..]].concat());
        let mut rate = ceb();
        rate.max_factor = 1.0;
        let without_effect = ColumnProperties {
            rate: Some(rate),
            ultimate_rotation: 10.0,
            ..plain
        };
        let (expected, expected_samples) = respond(&plain, &impact, 0.03);
        let (found, samples) = respond(&without_effect, &impact, 0.03);
        assert_eq!(found, expected);
        assert_eq!(samples, expected_samples);
    }
}

/// Factors just above 1 take the return to two surfaces instead of the return to one, with the same result.
#[test]
fn responses_are_continuous_where_factors_leave_one() {
    for scheme in SCHEMES {
        for exponents in [&DUAN_CHEN[..], &["hinge.elastic_law:=coupled"]] {
            let (plain, impact) = example(&[&[scheme], exponents].concat());
            let (expected, _) = respond(&plain, &impact, 0.03);
            for max_factor in [1.0 + 1e-15, 1.0 + 1e-12, 1.0 + 1e-9] {
                let mut rate = ceb();
                rate.max_factor = max_factor;
                let slightly = ColumnProperties {
                    rate: Some(rate),
                    ..plain
                };
                let (found, _) = respond(&slightly, &impact, 0.03);
                let error = (found.max_v1 / expected.max_v1 - 1.0).abs();
                println!("{scheme} {exponents:?} D {max_factor:e}: {error:.1e}");
                assert!(error <= 1e-9 + 10.0 * (max_factor - 1.0));
            }
        }
    }
}

#[test]
fn runs_with_rate_and_hardening_are_equal_bit_for_bit_and_continue_from_a_copy() {
    for scheme in SCHEMES {
        let (mut properties, impact) = example(&[&[scheme], &DUAN_CHEN[..]].concat());
        properties.rate = Some(ceb());
        properties.hardening_ratio = 0.01;
        let model = Model::new(&properties).expect("a column");
        let begin = || {
            let mut state = State::at_rest(&model);
            let response = Response::begin(&model, &mut state, impact, 0.05).expect("an impact");
            (state, response)
        };
        let advance = |(state, response): &mut (State, Response), steps: u32| {
            for _ in 0..steps {
                response.advance(&model, state, 1).expect("a step");
            }
        };
        let mut one = begin();
        advance(&mut one, 1500);
        let mut other = begin();
        advance(&mut other, 700);
        let saved = serde_json::to_string(&other).expect("plain data");
        let mut other: (State, Response) = serde_json::from_str(&saved).expect("a saved run");
        advance(&mut other, 800);
        assert_eq!(one, other);
        assert!(one.0.strength.below[0].factors.dynamic > 1.1);
        assert!(one.0.strength.below[0].factors.hardening > 1.1);
        let rest = residual_state(&model, &one.0).expect("an equilibrium");
        assert_eq!(rest.accumulated_rotation(), one.0.accumulated_rotation());
        assert_eq!(rest.strength.below[1].factors.dynamic, 1.0);
        assert_eq!(rest.strength.below[1].strain_rate, 0.0);
        assert!(rest.strength.below[1].factors.hardening > 1.1);
    }
}

#[test]
fn the_filter_starts_from_zero_at_every_impact_and_hardening_does_not() {
    let (mut properties, impact) = example(&DUAN_CHEN);
    properties.rate = Some(ceb());
    properties.hardening_ratio = 0.01;
    let model = Model::new(&properties).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, 0.01).expect("an impact");
    while response.advance(&model, &mut state, 1).expect("a step") == Progress::Running {}
    let before = state;
    Response::begin(&model, &mut state, impact, 0.01).expect("a second impact");
    assert!(before.strength.below[1].strain_rate > 0.1);
    assert_eq!(state.strength.below[1].strain_rate, 0.0);
    assert_eq!(state.accumulated_rotation(), before.accumulated_rotation());
}

/// Version 0.2 printed rotations of 68 degrees and "remains standing".
#[test]
fn a_hinge_beyond_its_ultimate_rotation_is_fractured() {
    for scheme in SCHEMES {
        let (mut properties, impact) = example(&[scheme]);
        properties.ultimate_rotation = 0.08;
        let (report, samples) = respond(&properties, &impact, 0.1);
        assert_eq!(
            (report.outcome, report.end),
            (Outcome::Fractured, End::Fractured)
        );
        assert_eq!((report.residual_v1, report.residual_u2), (None, None));
        let fractured = |sample: &Sample| {
            let [a, b, top, base] = sample.hinges.map(|hinge| hinge.plastic_rotation);
            [a + b, top, base].iter().any(|turn| turn.abs() > 0.08)
        };
        // It ends with the step in which the limit is passed.
        let (last, before) = samples.split_last().expect("samples");
        assert!(fractured(last) && !before.iter().any(fractured));
        assert_eq!(report.end_time, last.time);
        println!("{scheme}: fractured at {:.3} ms", 1e3 * report.end_time);
        // Hinge 1a reaches 0.108 rad and 0.111 rad with these exponents.
        properties.ultimate_rotation = 0.12;
        let (report, _) = respond(&properties, &impact, 0.1);
        assert_eq!(report.outcome, Outcome::Plastic);
        assert!(report.residual_v1.is_some());
    }
}

#[test]
fn properties_out_of_range_are_rejected_with_what_is_expected() {
    let (plain, _) = example(&[]);
    let rate = ceb();
    let with = |rate: RateProperties| ColumnProperties {
        rate: Some(rate),
        ..plain
    };
    let logarithmic = |c, reference| RateProperties {
        law: RateLaw::Logarithmic { c, reference },
        ..rate
    };
    let wrong = [
        (
            with(RateProperties {
                time_constant: 0.0,
                ..rate
            }),
            "time constant",
        ),
        (
            with(RateProperties {
                time_constant: f64::NAN,
                ..rate
            }),
            "time constant",
        ),
        (
            with(RateProperties {
                max_factor: 0.99,
                ..rate
            }),
            "largest dynamic",
        ),
        (
            with(RateProperties {
                max_factor: f64::INFINITY,
                ..rate
            }),
            "largest dynamic",
        ),
        (
            with(RateProperties {
                hinge_length: 0.0,
                ..rate
            }),
            "length of a hinge",
        ),
        (
            with(RateProperties {
                section_height: -0.1,
                ..rate
            }),
            "height",
        ),
        (with(cowper_symonds(0.0, 5.0, 0.2)), "strain rate D"),
        (with(cowper_symonds(40.4, 0.5, 0.2)), "exponent q"),
        (with(logarithmic(-0.1, 5e-5)), "coefficient C"),
        (with(logarithmic(0.1, 0.0)), "reference strain rate"),
        (
            ColumnProperties {
                hardening_ratio: 0.2,
                ..plain
            },
            "hardening ratio",
        ),
        (
            ColumnProperties {
                hardening_ratio: -0.01,
                ..plain
            },
            "hardening ratio",
        ),
        (
            ColumnProperties {
                ultimate_rotation: -1.0,
                ..plain
            },
            "ultimate plastic rotation",
        ),
        (
            ColumnProperties {
                ultimate_rotation: f64::NAN,
                ..plain
            },
            "ultimate plastic rotation",
        ),
    ];
    for (properties, named) in wrong {
        let error = Model::new(&properties).expect_err(named);
        assert!(matches!(error, ModelError::OutOfRange { .. }), "{error}");
        assert!(error.to_string().contains(named), "{error}");
    }
}
