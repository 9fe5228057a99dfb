//! Both schemes against the time-continuous limit of the paper's example, computed by an unrelated program
//! (`docs/theory.md`, section 8).

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use std::fs;
use std::path::{Path, PathBuf};

use column_mechanics::{HINGES, Model, Phase, Report, Sample, State, simulate, step};
use example::example;
use serde::Deserialize;

/// `alpha = beta = 2`.
const ELLIPSE: [&str; 3] = [
    "yield_surface.alpha:=2.0",
    "yield_surface.beta:=2.0",
    "yield_surface.gamma:=2.0",
];

/// Duan and Chen's surface (Eq 29).
const DUAN_CHEN: [&str; 3] = [
    "yield_surface.alpha:=1.0",
    "yield_surface.beta:=1.3",
    "yield_surface.gamma:=1.0",
];

/// Two exponent sets and the names of their reference data.
const CASES: [(&str, [&str; 3]); 2] =
    [("heb220_ellipse", ELLIPSE), ("heb220_duan_chen", DUAN_CHEN)];

/// How long a response is followed, past the end of the reference histories at 50 ms \[s\].
const DURATION: f64 = 0.06;

/// `N^p` of the paper's example \[N\].
const SQUASH_LOAD: f64 = 3.23e6;

/// Maxima and totals of the reference.
#[derive(Deserialize)]
struct Summary {
    vmax: f64,
    tvmax: f64,
    tsep: f64,
    impulse: f64,
    peak_contact: f64,
    first_yield: FirstYield,
    dissipated: f64,
    impact_loss: f64,
    vc_end: f64,
}

#[derive(Deserialize)]
struct FirstYield {
    #[serde(rename = "1a")]
    below: f64,
    #[serde(rename = "1b")]
    above: f64,
    #[serde(rename = "2")]
    top: f64,
    #[serde(rename = "3")]
    base: f64,
}

/// One row of a reference history, every 0.1 ms.
#[derive(Deserialize)]
#[allow(non_snake_case, reason = "the names of the file's columns")]
struct Row {
    t_s: f64,
    v1_m: f64,
    u1_m: f64,
    beta1_rad: f64,
    u2_m: f64,
    vc_m: f64,
    v1dot_m_s: f64,
    vcdot_m_s: f64,
    Na_N: f64,
    Nb_N: f64,
    M1a_Nm: f64,
    M1b_Nm: f64,
    M2_Nm: f64,
    M3_Nm: f64,
    contact_force_N: f64,
    plastic_work_J: f64,
    kinetic_energy_J: f64,
    elastic_energy_J: f64,
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data")
        .join(name)
}

fn summary(case: &str) -> Summary {
    let text = fs::read_to_string(data("reference_summary.json")).expect("the summary");
    let mut all: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    serde_json::from_value(all[case].take()).expect("one case")
}

fn history(case: &str) -> Vec<Row> {
    csv::Reader::from_path(data(&format!("{case}.csv")))
        .expect("the history")
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect()
}

/// The paper's example with a scheme, a step and exponents; the report, and every step.
fn run(scheme: &str, dt: &str, exponents: &[&str]) -> (Report, Vec<Sample>) {
    let (scheme, dt) = (
        format!("solver.scheme:={scheme}"),
        format!("solver.dt:={dt}"),
    );
    let overrides = [&[scheme.as_str(), dt.as_str()], exponents].concat();
    let (properties, impact) = example(&overrides);
    let mut samples = Vec::new();
    let report = simulate(&properties, &impact, DURATION, &mut |sample| {
        samples.push(*sample);
    })
    .expect("a response");
    (report, samples)
}

fn relative(found: f64, expected: f64) -> f64 {
    found / expected - 1.0
}

#[test]
fn midpoint_has_the_papers_errors() {
    let reference = summary("heb220_ellipse");
    let published = [
        ("1.0e-4", -2.34e-4),
        ("5.0e-5", -5.8e-5),
        ("2.0e-5", -9.1e-6),
        ("1.0e-5", -2.3e-6),
    ];
    let errors = published.map(|(dt, expected)| {
        let error = relative(run("midpoint", dt, &ELLIPSE).0.max_v1, reference.vmax);
        println!("midpoint dt {dt}: peak v1 {error:+.3e}, published {expected:+.2e}");
        assert!(
            (error / expected - 1.0).abs() <= 0.2,
            "dt {dt}: {error:e} instead of {expected:e}"
        );
        error
    });
    let order = (errors[0] / errors[3]).log10();
    println!("order of peak v1 over a decade of dt: {order:.3}");
    assert!((1.9..=2.1).contains(&order), "order {order}");
}

/// Before the first hinge yields at 0.29 ms the response is smooth. The impact impulse is spread over the first step there,
/// half of which the column loses (`docs/theory.md`, section 5), so that `n` steps are compared with `n - 1/2` of the
/// continuous motion; the step lengths are chosen such that this is the reference's row at 0.2 ms.
#[test]
fn midpoint_is_of_second_order_in_the_elastic_stretch() {
    let rows = history("heb220_ellipse");
    let row = rows
        .iter()
        .find(|row| (row.t_s - 2e-4).abs() < 1e-9)
        .expect("0.2 ms");
    let steps = [
        ("8.0e-5", 80_000e-9, 3),
        ("1.6e-5", 16_000e-9, 13),
        ("3.2e-6", 3_200e-9, 63),
    ];
    let errors = steps.map(|(dt, secs, count)| {
        assert!(((f64::from(count) - 0.5) * secs - 2e-4).abs() < 1e-12);
        let (_, samples) = run("midpoint", dt, &ELLIPSE);
        let sample = &samples[count as usize];
        let error = sample.v1 - row.v1_m;
        println!("midpoint dt {dt}: v1 at 0.2 ms {error:+.3e} m");
        error
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).ln() / 5.0_f64.ln();
        println!("order {order:.3}");
        assert!((1.9..=2.1).contains(&order), "order {order}");
    }
}

/// Free vibration within the elastic range: the differences between runs with ever halved steps.
#[test]
fn both_schemes_converge_with_second_order_on_smooth_stretches() {
    for scheme in ["midpoint", "conserving_midpoint"] {
        let displacement = |halvings: u32| {
            let dt = format!("solver.dt:={:e}", 1.6e-4 / f64::from(1 << halvings));
            let scheme = format!("solver.scheme:={scheme}");
            let (properties, _) = example(&[&scheme, &dt]);
            let model = Model::new(&properties).expect("a column");
            let mut state = State::at_rest(&model);
            state.velocity.v1 = 0.5;
            for _ in 0..(10 << halvings) {
                step(&model, &mut state).expect("a step");
                assert!(!state.is_flowing());
            }
            state.displacement.v1
        };
        let found: Vec<f64> = (0..5).map(displacement).collect();
        for three in found.windows(3) {
            let order = ((three[0] - three[1]) / (three[1] - three[2])).log2();
            println!("{scheme}: order of v1 {order:.3}");
            assert!((1.9..=2.1).contains(&order), "{scheme}: order {order}");
        }
    }
}

#[test]
fn conserving_midpoint_reaches_the_reference() {
    for (case, exponents) in CASES {
        let reference = summary(case);
        let (report, _) = run("conserving_midpoint", "2.0e-5", &exponents);
        let max_v1 = relative(report.max_v1, reference.vmax);
        let release = report.release_time.expect("release") - reference.tsep;
        let work = relative(report.plastic_work, reference.dissipated);
        println!("{case}: peak v1 {max_v1:+.2e}, release {release:+.2e} s, work {work:+.2e}");
        assert!(max_v1.abs() <= 3e-5 && work.abs() <= 3e-5);
        assert!(release.abs() <= 2e-5);

        let when = report.max_v1_time - reference.tvmax;
        let peak = relative(report.peak_contact_force, reference.peak_contact);
        let rebound = relative(report.impactor_velocity, reference.vc_end);
        let impulse = relative(report.impulse, reference.impulse);
        println!(
            "  crest {when:+.2e} s, peak force {peak:+.2e}, rebound {rebound:+.2e}, impulse {impulse:+.2e}"
        );
        assert!(when.abs() <= 2e-6 && peak.abs() <= 2e-4);
        assert!(rebound.abs() <= 3e-5 && impulse.abs() <= 1e-5);
        for (index, expected) in [
            reference.first_yield.below,
            reference.first_yield.above,
            reference.first_yield.top,
            reference.first_yield.base,
        ]
        .into_iter()
        .enumerate()
        {
            let found = report.hinges[index].first_yield.expect("yield");
            println!("  first yield {index}: {:+.2e} s", found - expected);
            // The reference has steps of 0.5 us.
            assert!((found - expected).abs() <= 2e-5, "{found} {expected}");
        }
    }
}

#[test]
fn the_first_impact_impulse_is_the_closed_form() {
    for (case, exponents) in CASES {
        let (report, samples) = run("conserving_midpoint", "2.0e-5", &exponents);
        assert!((samples[0].impact_impulse - 879.842_691).abs() < 1e-6);
        assert!((samples[0].impact_loss - 4_399.213_455).abs() < 1e-6);
        assert!((samples[0].impact_loss / summary(case).impact_loss - 1.0).abs() < 1e-12);
        assert_eq!(report.impact_impulses, 1);
        assert_eq!(report.total_impact_impulse, samples[0].impact_impulse);
        assert_eq!(report.first_contact_time, Some(0.0));
    }
}

#[test]
fn conserving_midpoint_follows_the_whole_histories() {
    let mut failures = Vec::new();
    for (which, (case, exponents)) in CASES.into_iter().enumerate() {
        let (_, samples) = run("conserving_midpoint", "2.0e-5", &exponents);
        let rows = history(case);
        assert_eq!(rows.len(), 501);
        let mut worst = [(0.0_f64, 0.0); 17];
        for (index, row) in rows.iter().enumerate() {
            let s = &samples[5 * index];
            assert!((s.time - row.t_s).abs() < 1e-12);
            let [below, above, top, base] = s.hinges;
            let pairs = [
                (s.v1, row.v1_m),
                (s.u1, row.u1_m),
                (s.u2, row.u2_m),
                (s.beta1, row.beta1_rad),
                (s.impactor_position, row.vc_m),
                (s.v1_rate, row.v1dot_m_s),
                (s.impactor_velocity, row.vcdot_m_s),
                (below.normal_force, row.Na_N),
                (above.normal_force, row.Nb_N),
                (below.moment, row.M1a_Nm),
                (above.moment, row.M1b_Nm),
                (top.moment, row.M2_Nm),
                (base.moment, row.M3_Nm),
                (s.contact_force, row.contact_force_N),
                (s.plastic_work, row.plastic_work_J),
                (s.kinetic_energy, row.kinetic_energy_J),
                (s.elastic_energy, row.elastic_energy_J),
            ];
            for (worst, (found, expected)) in worst.iter_mut().zip(pairs) {
                let error = (found - expected).abs();
                if error > worst.0 {
                    *worst = (error, row.t_s);
                }
            }
        }
        for ((name, tolerances), (error, when)) in TOLERANCES.into_iter().zip(worst) {
            let tolerance = tolerances[which];
            println!("{case}: {name} {error:.2e} at {when:.4} s, allowed {tolerance:.1e}");
            if error > tolerance {
                failures.push(format!("{case}: {name} {error:e} at {when} s"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Largest deviations from the reference over 50 ms at dt = 2e-5, of both sets of exponents, SI units: about twice what
/// was measured. The rotation of the impact point is the least determined, because hinges 1a and 1b share it between them.
const TOLERANCES: [(&str, [f64; 2]); 17] = [
    ("v1", [5.0e-6, 5.0e-6]),
    ("u1", [1.3e-6, 9.0e-6]),
    ("u2", [1.8e-6, 6.0e-6]),
    ("beta1", [4.0e-5, 1.0e-4]),
    ("v_c", [1.0e-6, 4.0e-6]),
    ("v1'", [5.0e-3, 5.0e-3]),
    ("v_c'", [6.0e-5, 1.2e-4]),
    ("N_a", [1.5e3, 6.0e3]),
    ("N_b", [2.0e1, 6.0e1]),
    ("M_1a", [1.3e2, 1.3e2]),
    ("M_1b", [1.3e2, 1.3e2]),
    ("M_2", [4.5e1, 4.5e1]),
    ("M_3", [4.0e2, 4.0e2]),
    ("contact force", [1.3e3, 1.3e3]),
    ("plastic work", [7.0e-1, 2.3e0]),
    ("kinetic energy", [6.0e-1, 1.2e0]),
    ("elastic energy", [8.0e-1, 2.0e0]),
];

#[test]
fn ledger_closes_and_contact_holds_at_every_step() {
    for (case, exponents) in CASES {
        for dt in ["1.0e-4", "2.0e-5", "1.0e-5"] {
            let (report, samples) = run("conserving_midpoint", dt, &exponents);
            let mut worst = 0.0_f64;
            for sample in &samples {
                worst = worst.max(sample.ledger_residual.abs() / report.input_energy);
                match sample.phase {
                    Phase::Contact => assert!(sample.gap.abs() <= 1e-10, "{sample:?}"),
                    _ => assert!(sample.gap >= -1e-10 && sample.contact_force == 0.0),
                }
                assert!(sample.hinges.iter().all(|h| h.utilisation - 1.0 <= 1e-9));
            }
            println!("{case} dt {dt}: ledger {worst:.1e} of the input");
            assert!(worst <= 1e-10);
            assert_eq!(worst, report.ledger_residual);
        }
    }
}

#[test]
fn normal_forces_do_not_zigzag() {
    for (case, exponents) in CASES {
        let zigzags = ["5.0e-5", "2.0e-5", "1.0e-5"].map(|dt| {
            let (_, samples) = run("conserving_midpoint", dt, &exponents);
            let worst = (0..HINGES)
                .flat_map(|hinge| {
                    samples.windows(3).map(move |three| {
                        let [before, now, after] =
                            [0, 1, 2].map(|i| three[i].hinges[hinge].normal_force);
                        (before - 2.0 * now + after).abs() / 4.0 / SQUASH_LOAD
                    })
                })
                .fold(0.0, f64::max);
            println!("{case} dt {dt}: zigzag {worst:.2e} N^p");
            worst
        });
        assert!(zigzags[1] <= 1.5e-3);
        assert!(zigzags[0] > zigzags[1] && zigzags[1] > zigzags[2]);
    }
}
