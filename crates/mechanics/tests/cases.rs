//! Extreme columns and impacts that must never fail, and cases with an answer in closed form.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use std::f64::consts::{PI, TAU};

use column_mechanics::{
    ColumnProperties, End, Impact, Model, Outcome, Phase, Progress, Report, Response, Sample,
    Scheme, State, Support, simulate, step,
};
use example::example;

const SCHEMES: [&str; 2] = [
    "solver.scheme:=midpoint",
    "solver.scheme:=conserving_midpoint",
];

/// Longest response \[s\].
const DURATION: f64 = 0.5;

/// Every number of a sample.
fn numbers(sample: &Sample) -> Vec<f64> {
    let mut all = vec![
        sample.v1,
        sample.u1,
        sample.beta1,
        sample.u2,
        sample.v1_rate,
        sample.u1_rate,
        sample.u2_rate,
        sample.impactor_position,
        sample.impactor_velocity,
        sample.gap,
        sample.contact_force,
        sample.impact_impulse,
        sample.impulse,
        sample.kinetic_energy,
        sample.elastic_energy,
        sample.plastic_work,
        sample.impact_loss,
        sample.damping_work,
        sample.load_work,
        sample.ledger_residual,
    ];
    for hinge in sample.hinges {
        all.extend([
            hinge.moment,
            hinge.normal_force,
            hinge.rotation,
            hinge.elongation,
            hinge.plastic_rotation,
            hinge.plastic_elongation,
            hinge.utilisation,
        ]);
    }
    all
}

/// Checks a step from `before` to `now`.
fn check(p: &ColumnProperties, impact: &Impact, before: &Sample, now: &Sample) {
    assert!(
        numbers(now).iter().all(|number| number.is_finite()),
        "{now:?}"
    );
    assert!(
        now.contact_force >= 0.0 && now.impact_impulse >= 0.0,
        "{now:?}"
    );
    assert!(now.impulse >= before.impulse, "{before:?} {now:?}");
    // The round-off of the ledger is relative to the energies that it adds up.
    let energies = impact.energy() + now.elastic_energy + now.load_work.abs() + now.kinetic_energy;
    assert!(
        now.plastic_work >= before.plastic_work - 1e-12 * energies,
        "{before:?} {now:?}"
    );
    if p.scheme == Scheme::Midpoint {
        // The impactor pushes only where it touches.
        assert!(now.contact_force == 0.0 || before.gap.min(now.gap) <= 0.0);
        return;
    }
    assert!(now.impact_loss >= before.impact_loss);
    assert!(now.ledger_residual.abs() <= 1e-10 * energies, "{now:?}");
    for hinge in now.hinges {
        let excess = hinge.utilisation.powf(p.yield_surface.gamma) - 1.0;
        assert!(excess <= 1e-9, "{hinge:?}");
    }
    match now.phase {
        Phase::Contact => assert!(now.gap.abs() <= 1e-10, "{now:?}"),
        _ => assert!(now.gap >= -1e-10 && now.contact_force == 0.0, "{now:?}"),
    }
}

/// Follows a response to its end and checks every step.
fn follow(p: &ColumnProperties, impact: &Impact) -> (Report, Vec<Sample>) {
    let mut samples: Vec<Sample> = Vec::new();
    let report = simulate(p, impact, DURATION, &mut |now| {
        if let Some(before) = samples.last() {
            check(p, impact, before, now);
        }
        samples.push(*now);
    })
    .expect("a result");
    assert_eq!(
        report.outcome == Outcome::Collapsed,
        report.end == End::Collapsed
    );
    (report, samples)
}

/// The response of the changed example with both schemes.
fn run(name: &str, overrides: &[&str]) -> [(Report, Vec<Sample>); 2] {
    SCHEMES.map(|scheme| {
        let (p, impact) = example(&[&[scheme], overrides].concat());
        let (report, samples) = follow(&p, &impact);
        println!(
            "{name:<28} {:?}: {:?} {:?} at {:.4} s, peak v1 {:.4e} m, {} impact_impulses, {} steps",
            p.scheme,
            report.outcome,
            report.end,
            report.end_time,
            report.max_v1,
            report.impact_impulses,
            report.steps
        );
        (report, samples)
    })
}

/// Checks that both schemes solve the same problem.
fn agree([(midpoint, _), (conserving, _)]: &[(Report, Vec<Sample>); 2], tolerance: f64) {
    assert_eq!(midpoint.outcome, conserving.outcome);
    let difference = (midpoint.max_v1 / conserving.max_v1 - 1.0).abs();
    assert!(difference <= tolerance, "peak v1 differs by {difference:e}");
}

#[test]
fn without_load() {
    agree(&run("P = 0", &["top.load:=0.0"]), 1e-3);
    let unloaded_and_free = ["top.load:=0.0", "top.spring_stiffness:=0.0"];
    agree(&run("P = 0, k_s = 0", &unloaded_and_free), 1e-3);
}

#[test]
fn top_spring_absent_or_rigid() {
    agree(&run("k_s = 0", &["top.spring_stiffness:=0.0"]), 1e-2);
    let runs = run("k_s = 1e12", &["top.spring_stiffness:=1.0e+12"]);
    agree(&runs, 1e-3);
    for (_, samples) in runs {
        assert!(samples.iter().all(|sample| sample.u2.abs() < 1e-5));
    }
}

/// The chords' catenary turns compression into tension; with `1 < beta < 2` the surface has infinite curvature there.
#[test]
fn normal_force_that_crosses_zero() {
    for exponents in ["1.0", "1.3", "1.7", "2.0"] {
        let beta = format!("yield_surface.beta:={exponents}");
        let overrides = [
            "top.load:=0.05e+6",
            "yield_surface.alpha:=1.0",
            &beta,
            "yield_surface.gamma:=1.0",
        ];
        let runs = run(&format!("N through 0, beta = {exponents}"), &overrides);
        for (_, samples) in &runs {
            let crossings = samples.windows(2).filter(|pair| {
                let [before, now] = [0, 1].map(|k| pair[k].hinges[0].normal_force);
                before * now < 0.0
            });
            assert!(crossings.count() >= 1);
        }
        agree(&runs, 1e-3);
    }
}

#[test]
fn yield_surface_as_a_diamond_or_a_box() {
    for exponent in ["1.0", "50.0"] {
        let overrides = ["alpha", "beta", "gamma"].map(|name| {
            let value = if name == "gamma" { "1.0" } else { exponent };
            format!("yield_surface.{name}:={value}")
        });
        let runs = run(
            &format!("alpha = beta = {exponent}"),
            &overrides.each_ref().map(String::as_str),
        );
        agree(&runs, 1e-3);
        assert!(runs.iter().all(|(report, _)| report.plastic_work > 0.0));
    }
}

#[test]
fn impact_near_an_end() {
    for (name, below, above) in [("2 %", "0.08", "3.92"), ("98 %", "3.92", "0.08")] {
        let below = format!("geometry.length_below:={below}");
        let above = format!("geometry.length_above:={above}");
        for velocity in ["1.0", "10.0"] {
            let velocity = format!("impact.velocity:={velocity}");
            run(&format!("{name}, {velocity}"), &[&below, &above, &velocity]);
        }
    }
}

#[test]
fn top_mass_absent_or_huge() {
    agree(&run("m_2 = 0", &["top.mass:=0.0"]), 1e-3);
    let [_, (_, samples)] = run("m_2 = 1e7", &["top.mass:=1.0e+7"]);
    // Ten thousand tonnes hardly move in the time of contact.
    let early = samples.iter().take_while(|sample| sample.time < 0.02);
    let start = samples[0].u2;
    assert!(early.into_iter().all(|s| (s.u2 - start).abs() < 1e-4));
}

#[test]
fn a_gap_of_metres_is_crossed_in_gap_over_velocity() {
    let gapless = run("gap 0", &[]);
    for (name, gap, expected) in [("gap 7.3 m", "7.3", 0.73), ("gap 100 m", "100.0", 10.0)] {
        let gap = format!("impact.gap:={gap}");
        let runs = run(name, &[&gap]);
        for ((report, _), tolerance) in runs.iter().zip([2.1e-5, 1e-11]) {
            let touched = report.first_contact_time.expect("contact");
            assert!((touched - expected).abs() <= tolerance, "{touched}");
        }
        // Then everything is as without the gap, except for the instant within a step at which contact begins.
        for ((report, _), (plain, _)) in runs.iter().zip(&gapless) {
            assert!((report.max_v1 / plain.max_v1 - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn creeping_and_flying_impactors() {
    let [_, (creeping, _)] = run("1e-6 m/s", &["impact.velocity:=1.0e-6"]);
    assert_eq!(creeping.outcome, Outcome::Elastic);
    run("60 m/s", &["impact.velocity:=60.0"]);
    let light = ["impact.velocity:=60.0", "impact.mass:=20.0"];
    agree(&run("60 m/s, 20 kg", &light), 1e-2);
}

#[test]
fn restitutions() {
    for restitution in ["0.0", "0.5", "1.0"] {
        let restitution = format!("impact.restitution:={restitution}");
        let [_, (report, _)] = run(&restitution, &[&restitution]);
        assert_eq!(report.outcome, Outcome::Plastic);
        assert!(report.release_time.is_some());
    }
}

/// A light impactor rebounds once and for good: Newton's law alone says how fast.
#[test]
fn rebound_of_a_light_impactor_is_newtons() {
    let (mc, m1) = (10.0, 70.1 * 4.0 / 3.0);
    for (text, restitution) in [("0.5", 0.5), ("1.0", 1.0)] {
        let restitution_text = format!("impact.restitution:={text}");
        let overrides = ["impact.mass:=10.0", restitution_text.as_str()];
        // The paper's rule spreads the impact impulse over a step, in which the column's resistance is detected.
        let tolerances = [6e-5, 1e-12];
        for ((report, _), tolerance) in run(&restitution_text, &overrides)
            .into_iter()
            .zip(tolerances)
        {
            let expected = 10.0 * (mc - restitution * m1) / (mc + m1);
            let velocity = report.impactor_velocity - expected;
            let reduced = mc * m1 / (mc + m1);
            let loss =
                report.impact_loss - 0.5 * (1.0 - restitution * restitution) * reduced * 100.0;
            println!("rebound {velocity:+.1e} m/s, loss {loss:+.1e} J");
            assert!((velocity / 10.0).abs() <= tolerance);
            assert!((loss / (0.5 * mc * 100.0)).abs() <= tolerance);
            assert_eq!(report.impact_impulses, 1);
        }
    }
}

/// Restitution 1 and an elastic column: at the end the energy of the impactor is in the motion and the springs.
#[test]
fn elastic_rebound_loses_no_energy() {
    let [_, (report, samples)] = run(
        "elastic, restitution 1",
        &["impact.restitution:=1.0", "impact.velocity:=0.1"],
    );
    assert_eq!(report.outcome, Outcome::Elastic);
    assert_eq!((report.impact_loss, report.plastic_work), (0.0, 0.0));
    assert!(
        report.impact_impulses >= 2,
        "the heavy impactor strikes again"
    );
    let left = report.column_kinetic_energy
        + report.impactor_kinetic_energy
        + report.elastic_energy_change
        - report.load_work;
    assert!((left / report.input_energy - 1.0).abs() < 1e-10);
    assert!(samples.iter().all(|sample| sample.gap >= -1e-10));
}

#[test]
fn collapse_is_a_result_with_a_time() {
    let overrides = [
        "top.spring_stiffness:=0.0",
        "top.load:=2.9e+6",
        "impact.mass:=20000.0",
        "impact.velocity:=15.0",
    ];
    for (report, samples) in run("collapse", &overrides) {
        assert_eq!(report.outcome, Outcome::Collapsed);
        assert_eq!(report.end, End::Collapsed);
        assert_eq!(report.residual_v1, None);
        assert!(report.end_time > 0.0 && report.end_time < DURATION);
        assert_eq!(samples.last().expect("samples").time, report.end_time);
    }
    // As printed, the column stands.
    for (report, _) in run("as printed", &[]) {
        assert_eq!(report.outcome, Outcome::Plastic);
        assert_eq!(report.end, End::AtRest);
    }
}

#[test]
fn column_at_rest_is_in_its_closed_form_and_stays_there() {
    for scheme in SCHEMES {
        let (p, _) = example(&[scheme]);
        let model = Model::new(&p).expect("a column");
        let mut state = State::at_rest(&model);
        let start = state.sample(&model);
        for hinge in start.hinges {
            assert!((hinge.normal_force + 489_748.8).abs() < 0.1);
            assert_eq!(hinge.moment, 0.0);
        }
        for _ in 0..1_000 {
            step(&model, &mut state).expect("a step");
        }
        let end = state.sample(&model);
        for (before, now) in numbers(&start).into_iter().zip(numbers(&end)) {
            assert!((now - before).abs() <= 1e-9 * before.abs().max(1e-6));
        }
    }
}

/// Transverse stiffness of the impact point of the column at rest with independent springs `6EI/L`, `beta1` condensed
/// and the normal force acting on the chords as shortened by the load \[N/m\].
fn transverse_stiffness(p: &ColumnProperties) -> f64 {
    let flexibility = (p.length_below + p.length_above) / p.axial_rigidity;
    let normal_force = -p.top_load / (1.0 + p.top_spring_stiffness * flexibility);
    let shortened = 1.0 + normal_force / p.axial_rigidity;
    let (la, lb) = (p.length_below * shortened, p.length_above * shortened);
    let (a, b) = (
        6.0 * p.bending_stiffness / p.length_below,
        6.0 * p.bending_stiffness / p.length_above,
    );
    let coupling = b / lb - a / la;
    2.0 * a / (la * la) + 2.0 * b / (lb * lb) - coupling * coupling / (a + b)
        + normal_force * (1.0 / la + 1.0 / lb)
}

#[test]
fn small_free_vibration_has_the_period_of_the_transverse_mode() {
    for scheme in SCHEMES {
        let (p, _) = example(&[scheme, "solver.dt:=2.0e-6"]);
        let model = Model::new(&p).expect("a column");
        let stiffness = transverse_stiffness(&p);
        let expected = TAU * (model.impact_point_mass / stiffness).sqrt();
        assert!((model.slowest_period / expected - 1.0).abs() < 1e-12);

        let mut state = State::at_rest(&model);
        state.velocity.v1 = 1e-3;
        let mut upward_crossings = Vec::new();
        while upward_crossings.len() < 11 {
            let before = state;
            step(&model, &mut state).expect("a step");
            let (low, high) = (before.displacement.v1, state.displacement.v1);
            if low < 0.0 && high >= 0.0 {
                let share = low / (low - high);
                upward_crossings.push(model.time_of_step(before.step) + share * model.step_secs);
            }
        }
        let observed = (upward_crossings[10] - upward_crossings[0]) / 10.0;
        println!("{scheme}: period {observed:.8} s, expected {expected:.8} s");
        assert!((observed / expected - 1.0).abs() < 2e-6);
    }
}

/// A slow inelastic impact: both masses swing half a period as one and separate with the common speed reversed.
#[test]
fn slow_impact_is_half_a_swing_of_both_masses() {
    let (p, impact) = example(&["impact.velocity:=1.0e-3"]);
    let model = Model::new(&p).expect("a column");
    let (report, _) = follow(&p, &impact);
    let moving = model.impact_point_mass + impact.mass;
    let stiffness = transverse_stiffness(&p);
    let (frequency, speed) = (
        (stiffness / moving).sqrt(),
        impact.mass / moving * impact.velocity,
    );
    let release = report.release_time.expect("release");
    for (name, found, expected) in [
        ("release", release, PI / frequency),
        ("peak v1", report.max_v1, speed / frequency),
        ("time of it", report.max_v1_time, PI / 2.0 / frequency),
        ("rebound", report.impactor_velocity, -speed),
        (
            "peak force",
            report.peak_contact_force,
            impact.mass * frequency * speed,
        ),
    ] {
        let error = found / expected - 1.0;
        println!("slow impact: {name} {error:+.1e}");
        assert!(error.abs() < 2e-5, "{name}: {error:e}");
    }
    assert_eq!(report.outcome, Outcome::Elastic);
}

#[test]
fn semi_rigid_supports_tend_to_built_in_and_pinned_ones() {
    let (p, impact) = example(&[]);
    for law in [
        column_mechanics::ElasticLaw::Uncoupled,
        column_mechanics::ElasticLaw::Coupled,
    ] {
        let with = |support: Support| {
            let properties = ColumnProperties {
                base: support,
                top: support,
                elastic_law: law,
                ..p
            };
            follow(&properties, &impact).0
        };
        for (limit, stiffness) in [(Support::BuiltIn, 1e20), (Support::Pinned, 1e-6)] {
            let (exact, near) = (with(limit), with(Support::SemiRigid { stiffness }));
            for (one, other) in [
                (exact.max_v1, near.max_v1),
                (exact.plastic_work, near.plastic_work),
            ] {
                assert!((one / other - 1.0).abs() < 1e-9, "{limit:?} {one} {other}");
            }
            assert_eq!(exact.outcome, near.outcome);
            if limit == Support::Pinned {
                assert!(exact.hinges[2].max_utilisation < 1.0 || exact.outcome == Outcome::Plastic);
            }
        }
        assert!(with(Support::Pinned).max_v1 > with(Support::BuiltIn).max_v1);
    }
}

/// Impact at mid-height of a column without load turns the chords only (`beta1 = 0`): both laws are the same there,
/// `EI/L (4 + 2) theta = 6 EI/L theta`. Anywhere else they differ.
#[test]
fn coupled_law_equals_the_uncoupled_one_where_only_the_chords_turn() {
    let crest = |law: &str, below: &str, above: &str| {
        let law = format!("hinge.elastic_law:={law}");
        let below = format!("geometry.length_below:={below}");
        let above = format!("geometry.length_above:={above}");
        let (p, impact) = example(&[
            &law,
            &below,
            &above,
            "top.load:=0.0",
            "top.spring_stiffness:=0.0",
            "impact.velocity:=1.0e-3",
        ]);
        follow(&p, &impact).0.max_v1
    };
    let symmetric = crest("coupled", "2.0", "2.0") / crest("uncoupled", "2.0", "2.0") - 1.0;
    let other = crest("coupled", "1.0", "3.0") / crest("uncoupled", "1.0", "3.0") - 1.0;
    println!("coupled / uncoupled - 1: mid-height {symmetric:.1e}, at a quarter {other:.2e}");
    assert!(symmetric.abs() < 1e-9);
    assert!(other > 0.01);
}

/// With eps > 0 rebounds accumulate: after a bounded number they end in persistent contact.
#[test]
fn accumulating_rebounds_end_in_contact() {
    for scheme in SCHEMES {
        let (p, impact) = example(&[scheme, "impact.restitution:=0.3", "impact.velocity:=2.0"]);
        let model = Model::new(&p).expect("a column");
        let mut state = State::at_rest(&model);
        let mut response = Response::begin(&model, &mut state, impact, 0.03).expect("an impact");
        let mut persistent = 0;
        while let Progress::Running = response.advance(&model, &mut state, 1).expect("a step") {
            let closed = state.impactor.is_some_and(|i| i.closed);
            persistent += u32::from(closed && state.impact_impulse == 0.0);
        }
        println!(
            "{scheme}: {} impact_impulses, {persistent} steps of contact",
            state.impact_impulses
        );
        assert!(state.impact_impulses >= 2 && persistent > 50);
    }
}
