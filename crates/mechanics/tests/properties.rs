//! Properties of every column that validation accepts, checked on random ones.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod random_columns;

use column_mechanics::{
    Capacity, ColumnProperties, CrushCurve, CrushSpring, ElasticLaw, End, Impact,
    MAX_PUSH_DOWN_EVALUATIONS, MAX_PUSH_DOWN_INCREMENTS, Model, Phase, Progress, PushDown,
    Response, Sample, Scheme, State, StepError, Support, Vehicle, YieldExponents, residual_state,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestRng, TestRunner};
use random_columns::{begin, check};

/// Random columns per scheme; both schemes together must reach at least 10 000.
const CASES: u32 = 6_000;

/// Steps for which one random response is followed.
const STEPS: u32 = 300;

/// Push-downs of random columns, undamaged and after an impact.
const PUSH_DOWNS: u32 = 1_000;

/// Most evaluations of one increment of a push-down.
const LAST_INCREMENT: u32 = 2_000;

/// Minimum length of a bar in the parameter table \[m\].
const MIN_BAR: f64 = 0.02;

fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(1.0),
        Just(1.3),
        Just(2.0),
        Just(50.0),
        1.0..3.0,
        log_uniform(1.0, 50.0)
    ]
}

fn support() -> impl Strategy<Value = Support> {
    prop_oneof![
        Just(Support::BuiltIn),
        Just(Support::Pinned),
        log_uniform(1e3, 1e10).prop_map(|stiffness| Support::SemiRigid { stiffness }),
    ]
}

fn or_zero(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 2 => log_uniform(low, high)]
}

prop_compose! {
    /// A column of real proportions with a load between zero and its squash load.
    fn column(scheme: Scheme)(
        height in 0.5..12.0_f64,
        impact_at in prop_oneof![Just(0.02), Just(0.98), 0.02..0.98_f64],
        area in log_uniform(5e-4, 0.1),
        slenderness in log_uniform(0.02, 0.3),
        steel in 1e8..7e8_f64,
        plastic_modulus in 0.6..1.3_f64,
        exponents in (exponent(), exponent(), log_uniform(0.1, 10.0)),
        coupled in any::<bool>(),
        base in support(),
        top in support(),
        given in prop_oneof![3 => Just(None), 1 => log_uniform(1e4, 1e9).prop_map(Some)],
        spring in or_zero(1e3, 1e12),
        mass in or_zero(1.0, 1e7),
        load in prop_oneof![Just(0.0), 0.0..0.99_f64],
        damping in prop_oneof![Just(0.0), 0.0..0.3_f64],
        step_nanos in log_uniform(1e3, 2e5),
    ) -> ColumnProperties {
        // Radius of gyration from 2 % to 30 % of a half metre of depth.
        let radius = slenderness * 0.5;
        let resistance_axial = area * steel;
        ColumnProperties {
            length_below: (height * impact_at).max(MIN_BAR),
            length_above: (height * (1.0 - impact_at)).max(MIN_BAR),
            axial_rigidity: 2.1e11 * area,
            bending_stiffness: 2.1e11 * area * radius * radius,
            mass_per_length: 7850.0 * area,
            resistance_moment: resistance_axial * radius * plastic_modulus,
            resistance_axial,
            yield_surface: YieldExponents { alpha: exponents.0, beta: exponents.1, gamma: exponents.2 },
            elastic_law: if coupled { ElasticLaw::Coupled } else { ElasticLaw::Uncoupled },
            base,
            top,
            hinge_stiffness: [if coupled { None } else { given }, None, None, None],
            top_spring_stiffness: spring,
            top_mass: mass,
            top_load: load * resistance_axial,
            damping_ratio: damping,
            rate: None,
            hardening_ratio: 0.0,
            softening: None,
            base_connection: None,
            ultimate_rotation: 0.0,
            shear: None,
            scheme,
            step_nanos: step_nanos as u64,
        }
    }
}

prop_compose! {
    fn impact()(
        mass in log_uniform(1.0, 1e5),
        velocity in log_uniform(1e-6, 60.0),
        gap in or_zero(1e-6, 5.0),
        restitution in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64],
    ) -> Impact {
        Impact { mass, velocity, gap, restitution, vehicle: None, bumper_height: 0.0, transverse_force: 0.0 }
    }
}

/// A force-crush curve, falling ones included, and an unloading stiffness that it admits.
fn spring() -> impl Strategy<Value = CrushSpring> {
    let point = (log_uniform(1e-3, 1.0), or_zero(1e2, 1e7));
    let curve = proptest::collection::vec(point, 1..8).prop_filter_map("no force", |points| {
        let mut crush = 0.0;
        let points: Vec<[f64; 2]> = points
            .into_iter()
            .map(|(length, force)| {
                crush += length;
                [crush, force]
            })
            .collect();
        CrushCurve::new(&points).ok()
    });
    let steeper = prop_oneof![Just(1.0), log_uniform(1.0, 100.0)];
    (curve, steeper, or_zero(1e-4, 1.0)).prop_map(|(envelope, steeper, slack)| CrushSpring {
        envelope,
        unloading_stiffness: steeper * envelope.steepest_slope().max(1.0),
        slack,
    })
}

fn vehicle() -> impl Strategy<Value = Vehicle> {
    let link = (log_uniform(1.0, 5e4), spring());
    proptest::collection::vec(link, 1..=3).prop_map(|links| {
        let (masses, mut springs): (Vec<f64>, Vec<CrushSpring>) = links.into_iter().unzip();
        springs[0].slack = 0.0;
        Vehicle::new(&masses, &springs).expect("a vehicle")
    })
}

fn vehicle_impact() -> impl Strategy<Value = Impact> {
    (impact(), vehicle()).prop_map(|(impact, vehicle)| Impact {
        mass: vehicle.total_mass(),
        vehicle: Some(vehicle),
        ..impact
    })
}

/// A constant force on what strikes, up to the largest admissible one.
fn pushed(impacts: impl Strategy<Value = Impact>) -> impl Strategy<Value = Impact> {
    let acceleration = prop_oneof![Just(9.81), log_uniform(1e-3, 99.9)];
    (impacts, acceleration).prop_map(|(impact, acceleration)| Impact {
        transverse_force: impact.mass * acceleration,
        ..impact
    })
}

/// What holds for a deformable vehicle in each step, whatever the scheme.
fn check_vehicle(impact: &Impact, before: &Sample, sample: &Sample) -> Result<(), TestCaseError> {
    let Some(vehicle) = &impact.vehicle else {
        return Ok(());
    };
    let chain = &sample.vehicle;
    prop_assert_eq!(chain.masses, vehicle.masses().len());
    for index in 0..chain.masses {
        let dissipated = chain.dissipated[index];
        prop_assert!(dissipated >= before.vehicle.dissipated[index], "{chain:?}");
        let permanent = chain.permanent_crush[index];
        prop_assert!(
            permanent >= before.vehicle.permanent_crush[index],
            "{chain:?}"
        );
        let (crush, force) = (chain.crush[index], chain.force[index]);
        prop_assert!(crush.is_finite() && chain.velocity[index].is_finite());
        // The force is on the envelope or below it.
        let envelope = vehicle.springs()[index].envelope.force(crush);
        let round_off = 1e-12 * vehicle.springs()[index].unloading_stiffness * crush.abs();
        prop_assert!(force >= 0.0 && force <= envelope + round_off, "{chain:?}");
    }
    prop_assert!(chain.elastic_energy >= 0.0);
    prop_assert_eq!(sample.impact_impulse, 0.0);
    // The vehicle has lost the momentum that the column has received.
    let momentum = impact.mass * impact.velocity + impact.transverse_force * sample.time;
    let lost = momentum - impact.mass * sample.impactor_velocity;
    let bound = 1e-12 * (momentum + sample.impulse.abs());
    prop_assert!(
        (lost - sample.impulse).abs() <= bound,
        "{lost} {}",
        sample.impulse
    );
    Ok(())
}

/// Follows a response and checks every step of it.
/// What the ledger loses to round-off in the springs of a vehicle: the crush `d` has a relative error, the force `k` times
/// its absolute one, and acts over the distance of a step; the errors of the steps add up like a random walk \[J\]. It matters
/// for fronts that become as stiff as solid steel after they were crushed by metres.
fn round_off(properties: &ColumnProperties, impact: &Impact) -> f64 {
    let springs = impact.vehicle.iter().flat_map(|vehicle| vehicle.springs());
    let force: f64 = springs
        .map(|spring| {
            let longest = spring.envelope.points().last().map_or(0.0, |it| it[0]);
            spring.unloading_stiffness * f64::EPSILON * longest.max(1.0)
        })
        .sum();
    let distance = impact.velocity * 1e-9 * properties.step_nanos as f64;
    // The instant of an event is located to 1e-14 m of the gap, and a step has up to 64 events.
    let located = impact.transverse_force * 64.0 * 1e-14;
    force * distance * f64::from(STEPS).sqrt() + located
}

fn follow(properties: &ColumnProperties, impact: &Impact) -> Result<(), TestCaseError> {
    let (model, mut state, mut response) = begin(properties, impact)?;
    let start = state.sample(&model);
    // The round-off of the ledger is relative to the energies that it adds up.
    let scale = impact.mass * impact.velocity * impact.velocity / 2.0
        + start.elastic_energy
        + start.load_work.abs();
    let conserving = properties.scheme == Scheme::ConservingMidpoint;
    let secs = 1e-9 * properties.step_nanos as f64;
    let mut dissipated = 0.0;
    let mut before = start;
    for _ in 0..STEPS {
        let progress = match response.advance(&model, &mut state, u64::MAX) {
            Ok(progress) => progress,
            Err(error @ StepError::NotConverged { .. }) => {
                return Err(TestCaseError::fail(error.to_string()));
            }
            Err(StepError::Collapsed(_)) => unreachable!("a collapse ends the response"),
        };
        let sample = state.sample(&model);
        // A step in which the column collapses is not made to its end.
        let is_whole = progress != Progress::Over(End::Collapsed);
        if is_whole || impact.transverse_force == 0.0 {
            check_vehicle(impact, &before, &sample)?;
        }
        before = sample;
        let scale = scale + sample.elastic_energy + sample.load_work.abs() + sample.kinetic_energy;
        for number in [
            sample.v1,
            sample.u1,
            sample.beta1,
            sample.u2,
            sample.v1_rate,
            sample.u1_rate,
            sample.u2_rate,
            sample.impactor_position,
            sample.impactor_velocity,
            sample.contact_force,
            sample.impulse,
            sample.kinetic_energy,
            sample.elastic_energy,
            sample.plastic_work,
            sample.ledger_residual,
        ] {
            prop_assert!(number.is_finite(), "{sample:?}");
        }
        prop_assert!(
            sample.plastic_work >= dissipated - 1e-12 * scale,
            "{} {}",
            sample.plastic_work,
            dissipated
        );
        dissipated = sample.plastic_work;
        prop_assert!(sample.contact_force >= 0.0 && sample.impact_impulse >= 0.0);
        prop_assert!(sample.damping_work >= 0.0);
        if conserving {
            prop_assert!(sample.impact_loss >= 0.0);
            for hinge in &sample.hinges {
                // The surface itself: gamma would only rescale the excess.
                let excess = hinge.utilisation.powf(properties.yield_surface.gamma) - 1.0;
                prop_assert!(excess <= 1e-9, "{hinge:?}");
            }
            prop_assert!(
                sample.ledger_residual.abs() <= 1e-10 * scale + round_off(properties, impact),
                "ledger {} of {scale}",
                sample.ledger_residual
            );
            match sample.phase {
                Phase::Contact => prop_assert!(sample.gap.abs() <= 1e-10, "gap {}", sample.gap),
                _ => {
                    // After the last event of a step the force may push the vehicle on until its end.
                    let pushed = 0.5 * impact.transverse_force / impact.mass * secs * secs;
                    prop_assert!(sample.gap >= -1e-10 - pushed, "gap {}", sample.gap);
                    prop_assert_eq!(sample.contact_force, 0.0);
                }
            }
        }
        if let Progress::Over(end) = progress {
            let report = response.report(&model, &state, end);
            prop_assert!(report.max_v1.is_finite() && report.ledger_residual.is_finite());
            break;
        }
    }
    Ok(())
}

fn run(scheme: Scheme, impacts: impl Strategy<Value = Impact>) {
    check(CASES, (column(scheme), impacts), follow);
}

#[test]
fn conserving_midpoint_holds_on_random_columns() {
    run(Scheme::ConservingMidpoint, impact());
}

#[test]
fn midpoint_holds_on_random_columns() {
    run(Scheme::Midpoint, impact());
}

#[test]
fn conserving_midpoint_holds_with_random_vehicles() {
    run(Scheme::ConservingMidpoint, vehicle_impact());
}

#[test]
fn midpoint_holds_with_random_vehicles() {
    run(Scheme::Midpoint, vehicle_impact());
}

#[test]
fn conserving_midpoint_holds_under_a_transverse_force() {
    run(Scheme::ConservingMidpoint, pushed(impact()));
    run(Scheme::ConservingMidpoint, pushed(vehicle_impact()));
}

#[test]
fn midpoint_holds_under_a_transverse_force() {
    run(Scheme::Midpoint, pushed(impact()));
    run(Scheme::Midpoint, pushed(vehicle_impact()));
}

/// The push-down of a column at rest, in slices; it must end, and its numbers must make sense.
fn push_down(model: &Model, state: &State, imperfection: f64) -> Result<Capacity, TestCaseError> {
    let mut push_down = PushDown::new(model, state, imperfection)
        .map_err(|e| TestCaseError::fail(e.to_string()))?;
    let mut slices = 0;
    let capacity = loop {
        slices += 1;
        if let Some(capacity) = push_down.advance(100) {
            break capacity;
        }
        prop_assert!(slices <= MAX_PUSH_DOWN_INCREMENTS / 100, "it does not end");
    };
    prop_assert!(capacity.force.is_finite() && capacity.force >= 0.0);
    // Some columns once took 1.2 s.
    prop_assert!(
        capacity.evaluations <= MAX_PUSH_DOWN_EVALUATIONS + LAST_INCREMENT,
        "{capacity:?}"
    );
    prop_assert!(capacity.v1.is_finite() && capacity.shortening.is_finite());
    Ok(capacity)
}

#[test]
fn every_push_down_ends_with_a_capacity() {
    let seed = TestRng::deterministic_rng(Config::default().rng_algorithm);
    let mut runner = TestRunner::new_with_rng(Config::default(), seed);
    let strategy = (
        column(Scheme::ConservingMidpoint),
        impact(),
        log_uniform(1e-4, 0.02),
    );
    let mut done = 0;
    let mut found = 0;
    while done < PUSH_DOWNS {
        let (properties, impact, bow) = strategy.new_tree(&mut runner).expect("a case").current();
        let Ok(model) = Model::new(&properties) else {
            continue;
        };
        let imperfection = bow * (properties.length_below + properties.length_above);
        let mut state = State::at_rest(&model);
        let undamaged = push_down(&model, &state, imperfection);
        let mut response = Response::begin(&model, &mut state, impact, 1e3).expect("a response");
        for _ in 0..STEPS {
            match response.advance(&model, &mut state, u64::MAX) {
                Ok(Progress::Over(_)) | Err(_) => break,
                Ok(_) => (),
            }
        }
        let now = residual_state(&model, &state).map(|rest| push_down(&model, &rest, imperfection));
        for capacity in [Some(undamaged), now].into_iter().flatten() {
            let capacity = capacity.unwrap_or_else(|failure| {
                let case =
                    serde_json::json!({ "column": properties, "impact": impact, "bow": bow });
                panic!("{failure}\n{case}")
            });
            done += 1;
            found += u32::from(!capacity.is_lower_bound());
        }
    }
    println!("{found} of {done} push-downs found N_u");
}
