//! Random columns whose hinges change their strength: strain rate, hardening, softening.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod random_columns;

use column_mechanics::{
    BarForces, ColumnProperties, ElasticLaw, End, Impact, Outcome, PlasticFlow, Progress, RateLaw,
    RateProperties, Scheme, SofteningProperties, Support, YieldExponents,
};
use proptest::prelude::*;
use random_columns::{begin, check};

/// Random columns per scheme.
const CASES: u32 = 3_000;

/// Steps for which one random response is followed.
const STEPS: u32 = 200;

fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(1.0),
        Just(1.3),
        Just(2.0),
        1.05..3.0,
        log_uniform(1.05, 50.0)
    ]
}

fn rate_law() -> impl Strategy<Value = RateLaw> {
    prop_oneof![
        (log_uniform(1.0, 1e4), 1.0..8.0_f64).prop_map(|(d, q)| RateLaw::CowperSymonds { d, q }),
        (0.0..0.1_f64, log_uniform(1e-6, 1.0))
            .prop_map(|(c, reference)| RateLaw::Logarithmic { c, reference }),
    ]
}

prop_compose! {
    fn rate()(
        law in rate_law(),
        time_constant in log_uniform(1e-6, 1e-1),
        max_factor in prop_oneof![Just(1.0), 1.0..4.0_f64],
        hinge_length in log_uniform(0.02, 1.0),
        section_height in 0.05..0.8_f64,
    ) -> RateProperties {
        RateProperties { law, time_constant, max_factor, hinge_length, section_height }
    }
}

prop_compose! {
    fn softening()(
        capping_rotation in log_uniform(1e-4, 0.2),
        post_capping_rotation in log_uniform(1e-3, 0.5),
        residual in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0_f64],
    ) -> SofteningProperties {
        SofteningProperties { capping_rotation, post_capping_rotation, residual }
    }
}

prop_compose! {
    fn column(scheme: Scheme)(
        height in 2.0..8.0_f64,
        impact_at in 0.1..0.9_f64,
        area in log_uniform(2e-3, 0.05),
        radius in 0.03..0.15_f64,
        steel in 2e8..5e8_f64,
        exponents in (exponent(), exponent()),
        coupled in any::<bool>(),
        pinned in any::<bool>(),
        spring in prop_oneof![Just(0.0), log_uniform(1e4, 1e10)],
        top_mass in prop_oneof![Just(0.0), log_uniform(1.0, 1e5)],
        load in prop_oneof![Just(0.0), 0.0..0.8_f64],
        rate in prop_oneof![1 => Just(None), 3 => rate().prop_map(Some)],
        hardening_ratio in prop_oneof![Just(0.0), 0.0..0.1_f64],
        softening in prop_oneof![1 => Just(None), 2 => softening().prop_map(Some)],
        ultimate_rotation in prop_oneof![Just(0.0), 0.01..0.3_f64],
        step_nanos in log_uniform(1e3, 2e5),
    ) -> ColumnProperties {
        let resistance_axial = area * steel;
        ColumnProperties {
            length_below: height * impact_at,
            length_above: height * (1.0 - impact_at),
            axial_rigidity: 2.1e11 * area,
            bending_stiffness: 2.1e11 * area * radius * radius,
            mass_per_length: 7850.0 * area,
            resistance_moment: resistance_axial * radius,
            resistance_axial,
            yield_surface: YieldExponents { alpha: exponents.0, beta: exponents.1, gamma: 1.0 },
            elastic_law: if coupled { ElasticLaw::Coupled } else { ElasticLaw::Uncoupled },
            base: Support::BuiltIn,
            top: if pinned { Support::Pinned } else { Support::BuiltIn },
            hinge_stiffness: [None; 4],
            top_spring_stiffness: spring,
            top_mass,
            top_load: load * resistance_axial,
            damping_ratio: 0.0,
            rate,
            hardening_ratio,
            softening,
            base_connection: None,
            ultimate_rotation,
            shear: None,
            scheme,
            step_nanos: step_nanos as u64,
        }
    }
}

/// Work of the mean of two forces on the change of plastic deformation of hinge `k` \[J\].
fn hinge_work(from: &BarForces, to: &BarForces, plastic: [&PlasticFlow; 2], k: usize) -> f64 {
    let [before, after] = plastic;
    0.5 * (from.normal + to.normal) * (after.elongation[k] - before.elongation[k])
        + 0.5 * (from.moment[k] + to.moment[k]) * (after.rotation[k] - before.rotation[k])
}

/// Follows a response and checks every step of it.
fn follow(properties: &ColumnProperties, impact: &Impact) -> Result<(), TestCaseError> {
    let (model, mut state, mut response) = begin(properties, impact)?;
    let start = state.sample(&model);
    let scale = impact.energy() + start.elastic_energy + start.load_work;
    let conserving = properties.scheme == Scheme::ConservingMidpoint;
    let max_factor = properties.rate.map_or(1.0, |rate| rate.max_factor);
    let mut dissipated = 0.0;
    for _ in 0..STEPS {
        let before = state;
        let progress = response
            .advance(&model, &mut state, u64::MAX)
            .map_err(|error| TestCaseError::fail(error.to_string()))?;
        let sample = state.sample(&model);
        let scale = scale + sample.elastic_energy + sample.load_work.abs() + sample.kinetic_energy;
        for number in [sample.v1, sample.u2, sample.v1_rate, sample.plastic_work] {
            prop_assert!(number.is_finite(), "{sample:?}");
        }
        prop_assert!(sample.plastic_work >= dissipated - 1e-12 * scale);
        dissipated = sample.plastic_work;
        for hinge in &sample.hinges {
            prop_assert!(
                (1.0..=max_factor).contains(&hinge.dynamic_factor),
                "{hinge:?}"
            );
        }
        if conserving {
            prop_assert!(
                sample.ledger_residual.abs() <= 1e-10 * scale,
                "ledger {} of {scale}",
                sample.ledger_residual
            );
            for hinge in &sample.hinges {
                prop_assert!(hinge.utilisation <= 1.0 + 1e-9, "{hinge:?}");
            }
            // The mean forces of a step do its work exactly where it has one part, over which the velocity is linear.
            let mean_rate = 0.5 * (before.velocity.v1 + state.velocity.v1);
            let moved = state.displacement.v1 - before.displacement.v1;
            let off = moved - model.step_secs * mean_rate;
            let has_one_part = off.abs() <= 1e-12 * moved.abs();
            for k in 0..2 {
                let below = [&before.plastic.below, &state.plastic.below];
                let above = [&before.plastic.above, &state.plastic.above];
                let works = [
                    hinge_work(&before.forces.below, &state.forces.below, below, k),
                    hinge_work(&before.forces.above, &state.forces.above, above, k),
                ];
                for work in works {
                    prop_assert!(
                        !has_one_part || work >= -1e-12 * scale,
                        "hinge {k}: {work} J"
                    );
                }
            }
        }
        if let Progress::Over(end) = progress {
            let report = response.report(&model, &state, end);
            prop_assert!(report.max_v1.is_finite());
            prop_assert_eq!(report.outcome == Outcome::Fractured, end == End::Fractured);
            break;
        }
    }
    Ok(())
}

fn run(scheme: Scheme) {
    let impacts = (log_uniform(10.0, 1e5), log_uniform(0.1, 60.0))
        .prop_map(|(mass, velocity)| Impact::rigid(mass, velocity));
    check(CASES, (column(scheme), impacts), follow);
}

#[test]
fn no_hinge_gains_energy_with_the_conserving_midpoint() {
    run(Scheme::ConservingMidpoint);
}

#[test]
fn no_hinge_gains_energy_with_the_midpoint() {
    run(Scheme::Midpoint);
}
