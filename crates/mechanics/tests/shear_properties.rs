//! Properties of random columns whose webs yield in shear, with strain rate, hardening, softening, bumpers and both schemes.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod random_columns;

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use column_mechanics::{
    BaseFailure, BaseResistance, ColumnProperties, CrushCurve, CrushSpring, ElasticLaw, Impact,
    MAX_PUSH_DOWN_EVALUATIONS, Model, Progress, PushDown, RateLaw, RateProperties, Response,
    Scheme, ShearProperties, SofteningProperties, State, StepError, Support, Vehicle, WebSample,
    YieldExponents, plastic_plateau, residual_state,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestRng, TestRunner};
use random_columns::{begin, check, check_drawn, check_in_parts};

/// Random columns per scheme.
const CASES: u32 = 5_000;

/// Random columns of the long run, half of them with each scheme.
const MANY: u32 = 1_000_000;

/// Steps for which one random response is followed.
const STEPS: u32 = 300;

/// Push-downs of random columns, undamaged and after an impact.
const PUSH_DOWNS: u32 = 600;

/// Most evaluations of one increment of a push-down.
const LAST_INCREMENT: u32 = 2_000;

fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn or_zero(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 2 => log_uniform(low, high)]
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => Just(1.0),
        3 => Just(1.3),
        2 => Just(2.0),
        1 => Just(50.0),
        2 => 1.0..3.0,
    ]
}

fn support() -> impl Strategy<Value = Support> {
    prop_oneof![
        Just(Support::BuiltIn),
        Just(Support::Pinned),
        log_uniform(1e3, 1e10).prop_map(|stiffness| Support::SemiRigid { stiffness }),
    ]
}

fn rate() -> impl Strategy<Value = RateProperties> {
    let law = prop_oneof![
        (log_uniform(1.0, 1e5), 1.0..10.0_f64).prop_map(|(d, q)| RateLaw::CowperSymonds { d, q }),
        (0.0..0.1_f64, log_uniform(1e-6, 1.0))
            .prop_map(|(c, reference)| RateLaw::Logarithmic { c, reference }),
    ];
    (law, log_uniform(1e-5, 1e-2), 1.0..3.0_f64).prop_map(|(law, time_constant, max_factor)| {
        RateProperties {
            law,
            time_constant,
            max_factor,
            hinge_length: 0.2,
            section_height: 0.2,
        }
    })
}

fn softening() -> impl Strategy<Value = SofteningProperties> {
    let rotations = (log_uniform(1e-4, 0.2), log_uniform(1e-3, 0.5));
    (rotations, 0.0..1.0_f64).prop_map(|((capping, post_capping), residual)| SofteningProperties {
        capping_rotation: capping,
        post_capping_rotation: post_capping,
        residual,
    })
}

/// Anchors and concrete from hardly any to more than the section bears; tension, compression and shear relative to the squash
/// load, levers to the radius of gyration; friction.
fn connection() -> impl Strategy<Value = [f64; 6]> {
    (
        log_uniform(0.003, 1.0),
        log_uniform(0.05, 3.0),
        0.5..2.5_f64,
        0.5..1.5_f64,
        log_uniform(0.001, 1.0),
        prop_oneof![Just(0.0), Just(0.2), 0.0..0.6_f64],
    )
        .prop_map(<[f64; 6]>::from)
}

prop_compose! {
    /// A column of real proportions whose web bears from a thousandth to half of what all of its steel could in shear, or never yields.
    fn column(scheme: Scheme)(
        height in 0.5..12.0_f64,
        impact_at in prop_oneof![Just(0.02), Just(0.98), 0.02..0.98_f64, 0.05..0.3_f64],
        area in log_uniform(5e-4, 0.1),
        slenderness in log_uniform(0.02, 0.3),
        steel in 1e8..7e8_f64,
        exponents in (exponent(), exponent()),
        coupled in any::<bool>(),
        supports in (support(), support()),
        spring in or_zero(1e3, 1e12),
        mass in or_zero(1.0, 1e7),
        load in prop_oneof![Just(0.0), 0.0..0.99_f64],
        damping in prop_oneof![2 => Just(0.0), 1 => 0.0..0.3_f64],
        rate in prop_oneof![Just(None), rate().prop_map(Some)],
        hardening_ratio in or_zero(1e-5, 0.1),
        softening in prop_oneof![1 => Just(None), 1 => softening().prop_map(Some)],
        web in (log_uniform(0.001, 0.5), or_zero(1e-4, 0.1), or_zero(1e-3, 1.0)),
        hardening in (or_zero(1e-3, 100.0), prop_oneof![Just(0.0), 1.0..3.0_f64]),
        bumper in prop_oneof![Just(0.0), 0.0..0.9_f64],
        connection in prop_oneof![Just(None), connection().prop_map(Some)],
        web_yields in prop_oneof![4 => Just(true), 1 => Just(false)],
        step_nanos in log_uniform(1e3, 2e5),
    ) -> ColumnProperties {
        let radius = slenderness * 0.5;
        let resistance_axial = area * steel;
        let resistance_moment = resistance_axial * radius;
        let lengths = [height * impact_at, height * (1.0 - impact_at)].map(|it| it.max(0.02));
        let web_resistance = web.0 * resistance_axial / 3.0_f64.sqrt();
        ColumnProperties {
            length_below: lengths[0],
            length_above: lengths[1],
            axial_rigidity: 2.1e11 * area,
            bending_stiffness: 2.1e11 * area * radius * radius,
            mass_per_length: 7850.0 * area,
            resistance_moment,
            resistance_axial,
            yield_surface: YieldExponents { alpha: exponents.0, beta: exponents.1, gamma: 1.0 },
            elastic_law: if coupled { ElasticLaw::Coupled } else { ElasticLaw::Uncoupled },
            base: supports.0,
            top: supports.1,
            hinge_stiffness: [None; 4],
            top_spring_stiffness: spring,
            top_mass: mass,
            top_load: load * resistance_axial,
            damping_ratio: damping,
            rate,
            hardening_ratio,
            softening,
            base_connection: connection.map(|numbers| {
                let [tension, compression, anchors, flange, anchor_shear, friction] = numbers;
                BaseResistance {
                    tension: tension * resistance_axial,
                    tension_limit: BaseFailure::AnchorsInTension,
                    compression: compression * resistance_axial,
                    lever: [anchors * radius, flange * radius],
                    anchor_shear: anchor_shear * resistance_axial,
                    friction,
                    stiffness: 1e7,
                    ultimate_slip: 0.0,
                    ultimate_elongation: 0.0,
                }
            }),
            ultimate_rotation: 0.0,
            shear: web_yields.then_some(ShearProperties {
                web_resistance,
                flange_moment: web.1 * resistance_moment,
                rigidity: web.2 * 8e10 * area,
                hardening: hardening.0 * web_resistance,
                max_hardening: hardening.1,
                ultimate_angle: 0.0,
                // As without a bumper, no bar is shorter than the least length in the parameter table.
                bumper_height: bumper * 2.0 * (lengths[0].min(lengths[1]) - 0.02),
            }),
            scheme,
            step_nanos: step_nanos as u64,
        }
    }
}

/// Rigid impactors, and fronts that give a constant force, which is what brings a web to its limit slowly.
fn impact() -> impl Strategy<Value = Impact> {
    let rigid = || {
        (
            log_uniform(1.0, 1e5),
            prop_oneof![1 => log_uniform(1e-6, 60.0), 2 => log_uniform(0.1, 60.0)],
            or_zero(1e-6, 0.1),
            prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64],
        )
            .prop_map(|(mass, velocity, gap, restitution)| Impact {
                mass,
                velocity,
                gap,
                restitution,
                vehicle: None,
                bumper_height: 0.0,
                transverse_force: 0.0,
            })
    };
    let front =
        (rigid(), log_uniform(1e3, 1e7), 0.02..0.5_f64).prop_map(|(impact, force, crush)| {
            let spring = CrushSpring {
                envelope: CrushCurve::new(&[[crush, force], [2.0, force]]).expect("a curve"),
                unloading_stiffness: 10.0 * force / crush,
                slack: 0.0,
            };
            Impact {
                vehicle: Some(Vehicle::new(&[impact.mass], &[spring]).expect("a vehicle")),
                ..impact
            }
        });
    prop_oneof![rigid(), front]
}

/// What has happened in all responses together.
#[derive(Default)]
struct Seen {
    sheared: Cell<u32>,
    both_ways: Cell<u32>,
    slipped: Cell<u32>,
    steps: Cell<u64>,
}

fn add<T: Copy + std::ops::Add<Output = T>>(cell: &Cell<T>, more: T) {
    cell.set(cell.get() + more);
}

fn follow(
    properties: &ColumnProperties,
    impact: &Impact,
    seen: &Seen,
) -> Result<(), TestCaseError> {
    let (model, mut state, mut response) = begin(properties, impact)?;
    let start = state.sample(&model);
    // The round-off of the ledger is relative to the energies that it adds up.
    let input = impact.mass * impact.velocity * impact.velocity / 2.0
        + start.elastic_energy
        + start.load_work;
    let conserving = properties.scheme == Scheme::ConservingMidpoint;
    let mut before = start;
    let mut directions = [false; 2];
    for _ in 0..STEPS {
        let progress = match response.advance(&model, &mut state, u64::MAX) {
            Ok(progress) => progress,
            Err(error @ StepError::NotConverged { .. }) => {
                return Err(TestCaseError::fail(error.to_string()));
            }
            Err(StepError::Collapsed(_)) => unreachable!("a collapse ends the response"),
        };
        add(&seen.steps, 1);
        let sample = state.sample(&model);
        let scale = input + sample.elastic_energy + sample.load_work.abs() + sample.kinetic_energy;
        for number in [
            sample.v1,
            sample.u1,
            sample.beta1,
            sample.u2,
            sample.v1_rate,
            sample.contact_force,
            sample.elastic_energy,
            sample.plastic_work,
            sample.ledger_residual,
            sample.webs[0].shear_force,
            sample.webs[1].shear_force,
        ] {
            prop_assert!(number.is_finite(), "{sample:?}");
        }
        let more = sample.plastic_work - before.plastic_work;
        // With either scheme the stress that does the work is admissible, and the flow is normal to the surface.
        prop_assert!(more >= -1e-12 * scale, "plastic work {more}");
        for (web, last) in sample.webs.iter().zip(&before.webs) {
            let more = web.work - last.work;
            prop_assert!(more >= -1e-12 * scale, "work of a web {more}");
            if web.plastic_angle != last.plastic_angle {
                directions[usize::from(web.plastic_angle < last.plastic_angle)] = true;
            }
        }
        let webs = sample.webs[0].work + sample.webs[1].work;
        prop_assert!(webs <= sample.plastic_work + 1e-12 * scale);
        before = sample;
        if conserving {
            // Relative to a moment of which a connection leaves as little as a hundredth.
            let tolerance = match properties.base_connection {
                Some(_) => 1e-7,
                None => 1e-9,
            };
            for hinge in &sample.hinges {
                prop_assert!(hinge.utilisation <= 1.0 + tolerance, "{hinge:?}");
            }
            for (web, shear) in sample.webs.iter().zip([properties.shear; 2]) {
                let Some(shear) = shear else {
                    prop_assert!(*web == WebSample::default(), "{web:?}");
                    continue;
                };
                // Next to the squash load, where a web bears hardly anything, the round-off of the normal force decides.
                let excess = web.shear_force.abs() * (1.0 - 1.0 / web.utilisation.max(1.0));
                let resistance = shear.web_resistance;
                // A bar of 20 mm is so stiff that the round-off of its trial moments is a billionth of that (seen: 1.2e-9).
                prop_assert!(excess <= 1e-8 * resistance, "{web:?}");
            }
            prop_assert!(
                sample.ledger_residual.abs() <= 1e-10 * scale,
                "ledger {} of {scale}",
                sample.ledger_residual
            );
        }
        if let Progress::Over(end) = progress {
            let report = response.report(&model, &state, end);
            prop_assert!(report.max_v1.is_finite() && report.ledger_residual.is_finite());
            break;
        }
    }
    add(&seen.sheared, u32::from(directions != [false; 2]));
    add(&seen.both_ways, u32::from(directions == [true; 2]));
    add(&seen.slipped, u32::from(state.webs.below.slip != 0.0));
    Ok(())
}

fn run(scheme: Scheme) {
    let seen = Seen::default();
    let cases = check(CASES, (column(scheme), impact()), |properties, impact| {
        follow(properties, impact, &seen)
    });
    println!(
        "{scheme:?}: {cases} columns, {} sheared, {} both ways, {} slipped on their base, {} steps",
        seen.sheared.get(),
        seen.both_ways.get(),
        seen.slipped.get(),
        seen.steps.get()
    );
    assert!(seen.sheared.get() > cases / 6 && seen.both_ways.get() > cases / 50);
}

#[test]
fn conserving_midpoint_holds_on_random_columns_with_shear() {
    run(Scheme::ConservingMidpoint);
}

#[test]
fn midpoint_holds_on_random_columns_with_shear() {
    run(Scheme::Midpoint);
}

/// The issue that asked for shear, softening and a base asked for this number; `COLUMN_TWIN_EXPLORE` draws another number of new ones.
#[test]
#[ignore = "takes minutes"]
fn a_million_random_columns_of_both_schemes_converge() {
    let (begun, slipped, steps) = (Instant::now(), AtomicU64::new(0), AtomicU64::new(0));
    let cases = check_in_parts(MANY, |index, cases, random| {
        let scheme = match index % 2 {
            0 => Scheme::ConservingMidpoint,
            _ => Scheme::Midpoint,
        };
        let seen = Seen::default();
        check_drawn(
            cases,
            random,
            (column(scheme), impact()),
            |properties, impact| follow(properties, impact, &seen),
        )?;
        slipped.fetch_add(seen.slipped.get().into(), Ordering::Relaxed);
        let steps = steps.fetch_add(seen.steps.get(), Ordering::Relaxed) + seen.steps.get();
        println!(
            "part {index}: {steps} steps so far, {:.0?}",
            begun.elapsed()
        );
        Ok(())
    });
    let slipped = slipped.into_inner();
    let secs = begun.elapsed().as_secs_f64();
    println!(
        "{cases} columns, {:.0} a second, {slipped} slipped on their base, {} steps",
        f64::from(cases) / secs,
        steps.into_inner()
    );
    assert!(slipped > u64::from(cases) / 50);
}

/// Push-downs end, undamaged and after an impact, and a plateau with a web is none above that without one.
#[test]
fn every_push_down_with_shear_ends_with_a_capacity() {
    let seed = TestRng::deterministic_rng(Config::default().rng_algorithm);
    let mut runner = TestRunner::new_with_rng(Config::default(), seed);
    let strategy = (
        column(Scheme::ConservingMidpoint),
        impact(),
        log_uniform(1e-4, 0.02),
    );
    let (mut done, mut found, mut sheared) = (0, 0, 0);
    while done < PUSH_DOWNS {
        let (properties, impact, bow) = strategy.new_tree(&mut runner).expect("a case").current();
        let Ok(model) = Model::new(&properties) else {
            continue;
        };
        let [below, above] = properties.clear_lengths();
        let imperfection = bow * (below + above);
        let mut state = State::at_rest(&model);
        let undamaged = state;
        let mut response = Response::begin(&model, &mut state, impact, 1e3).expect("a response");
        for _ in 0..STEPS {
            match response.advance(&model, &mut state, u64::MAX) {
                Ok(Progress::Over(_)) | Err(_) => break,
                Ok(_) => (),
            }
        }
        let rest = residual_state(&model, &state);
        sheared += u32::from(rest.is_some_and(|it| it.plastic.below.shear_angle != 0.0));
        for state in [Some(undamaged), rest].into_iter().flatten() {
            let mut push_down = PushDown::new(&model, &state, imperfection).expect("a bow");
            let capacity = loop {
                if let Some(capacity) = push_down.advance(100) {
                    break capacity;
                }
            };
            let case = serde_json::json!({ "column": properties, "impact": impact, "bow": bow });
            assert!(
                capacity.force.is_finite()
                    && capacity.force >= 0.0
                    && capacity.v1.is_finite()
                    && capacity.evaluations <= MAX_PUSH_DOWN_EVALUATIONS + LAST_INCREMENT,
                "{capacity:?}\n{case}"
            );
            done += 1;
            found += u32::from(!capacity.is_lower_bound());
        }
        let bending = Model::new(&ColumnProperties {
            shear: None,
            length_below: below,
            length_above: above,
            ..properties
        });
        if let Ok(bending) = bending {
            for n in [0.0, 0.3, 0.7, 1.0] {
                let [with, without] = [&model, &bending]
                    .map(|it| plastic_plateau(it, n * properties.resistance_axial));
                assert!(with <= without && with >= 0.0, "{with} {without}");
            }
        }
    }
    println!("{found} of {done} push-downs found N_u, {sheared} webs had sheared");
    assert!(found * 10 > done * 9);
}
