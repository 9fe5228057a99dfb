//! A cantilever: nothing holds the top.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use column_mechanics::{
    CapacityError, ColumnProperties, ElasticLaw, End, Impact, Model, Outcome, RateLaw,
    RateProperties, Scheme, ShearProperties, State, StudyModel, Support, YieldExponents, capacity,
    plastic_plateau, respond, simulate, step,
};
use example::{lorry, paper};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRng, TestRunner};

/// A bollard of HEB 220, 1.2 m high, struck at 0.5 m; stiffened elastically by a factor.
fn bollard(stiffening: f64) -> ColumnProperties {
    ColumnProperties {
        length_below: 0.5,
        length_above: 0.7,
        axial_rigidity: stiffening * 210e9 * 91.04e-4,
        bending_stiffness: stiffening * 210e9 * 8091e-8,
        mass_per_length: 71.5,
        resistance_moment: 293.6e3,
        resistance_axial: 3232e3,
        yield_surface: YieldExponents {
            alpha: 1.0,
            beta: 1.3,
            gamma: 1.0,
        },
        elastic_law: ElasticLaw::Coupled,
        base: Support::BuiltIn,
        top: Support::Free,
        top_spring_stiffness: 0.0,
        top_load: 0.0,
        step_nanos: 2_000,
        ..paper().0
    }
}

/// Moment of inertia about the base \[kg m²\].
fn inertia(column: &ColumnProperties) -> f64 {
    let height = column.length_below + column.length_above;
    column.mass_per_length * height.powi(3) / 3.0 + column.top_mass * height * height
}

/// The period of the model is that of the stiffness `3 EI / L_a^3`, with a spring at the base `1 / (L_a^3/3EI + L_a^2/k)`, and
/// of the moment of inertia about the base, with either elastic law.
#[test]
fn the_stiffness_is_that_of_a_cantilever() {
    for elastic_law in [ElasticLaw::Coupled, ElasticLaw::Uncoupled] {
        for (base, spring) in [
            (Support::BuiltIn, f64::INFINITY),
            (Support::SemiRigid { stiffness: 2e7 }, 2e7),
        ] {
            for top_mass in [0.0, 150.0] {
                let column = ColumnProperties {
                    elastic_law,
                    base,
                    top_mass,
                    ..bollard(1.0)
                };
                let model = Model::new(&column).expect("a column");
                let (a, ei) = (column.length_below, column.bending_stiffness);
                let stiffness = 1.0 / (a * a * a / (3.0 * ei) + a * a / spring);
                let mass = inertia(&column) / (a * a);
                let period = std::f64::consts::TAU * (mass / stiffness).sqrt();
                let error = model.slowest_period / period - 1.0;
                assert!(error.abs() < 1e-9, "{elastic_law:?} {base:?}: {error}");
                assert!((model.impact_point_mass / mass - 1.0).abs() < 1e-12);
            }
        }
    }
}

/// `F0 = M / L_a`, or what the web bears where that is less.
#[test]
fn the_plateau_is_that_of_the_hinge_at_the_base() {
    let column = bollard(1.0);
    let model = Model::new(&column).expect("a column");
    let plateau = plastic_plateau(&model, 0.0);
    assert!((plateau / (293.6e3 / 0.5) - 1.0).abs() < 1e-12, "{plateau}");
    let weak = ColumnProperties {
        shear: Some(web(300e3)),
        ..column
    };
    let plateau = plastic_plateau(&Model::new(&weak).expect("a column"), 0.0);
    assert!((plateau / 300e3 - 1.0).abs() < 1e-12, "{plateau}");
}

fn web(resistance: f64) -> ShearProperties {
    ShearProperties {
        web_resistance: resistance,
        flange_moment: 0.0,
        rigidity: 0.0,
        hardening: 0.0,
        max_hardening: 0.0,
        ultimate_angle: 0.0,
        bumper_height: 0.0,
    }
}

/// A rigid-plastic cantilever turns by the kinetic energy after the impact impulse over its plastic moment, however far that is.
#[test]
fn a_rigid_plastic_cantilever_turns_by_its_energy_over_its_moment() {
    for (mass, velocity, top_mass) in [(1500.0, 4.0, 0.0), (1500.0, 8.0, 0.0), (800.0, 6.0, 100.0)]
    {
        let column = ColumnProperties {
            top_mass,
            ..bollard(1e3)
        };
        let (a, own) = (column.length_below, inertia(&column));
        let with = own + mass * a * a;
        let rate = mass * velocity * a / with;
        let energy = 0.5 * with * rate * rate;
        let angle = energy / column.resistance_moment;
        let report = respond(&column, &Impact::rigid(mass, velocity), 1.0).expect("a response");
        let found = report.hinges[3].plastic_rotation;
        let tolerance = 2e-3 + angle * angle;
        assert!((found / angle - 1.0).abs() < tolerance, "{found} {angle}");
        assert_eq!(report.outcome, Outcome::Plastic);
        assert_eq!(report.end, End::AtRest);
        let loss = 0.5 * mass * velocity * velocity - energy;
        assert!((report.impact_loss / loss - 1.0).abs() < 1e-9);
        assert!(report.ledger_residual < 1e-10);
        for hinge in &report.hinges[..3] {
            assert_eq!(hinge.plastic_rotation, 0.0);
            assert_eq!(hinge.first_yield, None);
        }
        let residual = report.residual_v1.expect("an equilibrium");
        // The force across the column pulls at a bar that leans, so that the hinge also lengthens.
        let length = a + report.hinges[3].plastic_elongation;
        assert!(
            (residual - length * found.sin()).abs() < 1e-3 * residual,
            "{residual}"
        );
    }
}

/// Only the base resists: all other hinges and the bar above bear nothing, in every step.
#[test]
fn nothing_above_the_base_bears_a_moment() {
    for scheme in [Scheme::ConservingMidpoint, Scheme::Midpoint] {
        let column = ColumnProperties {
            scheme,
            ..bollard(1.0)
        };
        let mut largest = [0.0_f64; 4];
        let mut normal = 0.0_f64;
        simulate(&column, &Impact::rigid(1500.0, 5.0), 0.2, &mut |sample| {
            for (largest, hinge) in largest.iter_mut().zip(&sample.hinges) {
                *largest = largest.max(hinge.moment.abs());
            }
            normal = normal.max(sample.hinges[2].normal_force.abs());
            assert!((sample.u2 - sample.u1).abs() < 1e-6 * (1e-3 + sample.u1.abs()));
        })
        .expect("a response");
        assert!(largest[3] > 0.9 * column.resistance_moment);
        let error = 1e-6 * column.resistance_moment;
        assert!(largest[..3].iter().all(|it| *it < error), "{largest:?}");
        assert!(normal < 1e-6 * column.resistance_axial, "{normal}");
    }
}

/// A web that is weaker than the bending mechanism flows alone: the base stays elastic.
#[test]
fn a_weak_web_flows_instead_of_the_base() {
    let column = ColumnProperties {
        shear: Some(web(300e3)),
        ..bollard(1.0)
    };
    let report = respond(&column, &Impact::rigid(1500.0, 5.0), 1.0).expect("a response");
    assert!(report.webs[0].plastic_angle > 0.01);
    assert_eq!(report.webs[1].plastic_angle, 0.0);
    assert_eq!(report.hinges[3].plastic_rotation, 0.0);
    assert!(report.ledger_residual < 1e-10);
}

/// Both schemes agree, a vehicle and rate and damping included.
#[test]
fn both_schemes_agree() {
    for vehicle in [None, Some(lorry())] {
        let impact = Impact {
            vehicle,
            mass: vehicle.map_or(1500.0, |it| it.total_mass()),
            ..Impact::rigid(1500.0, 4.0)
        };
        let [conserving, midpoint] = [Scheme::ConservingMidpoint, Scheme::Midpoint].map(|scheme| {
            let column = ColumnProperties {
                scheme,
                damping_ratio: 0.01,
                rate: Some(RateProperties {
                    law: RateLaw::Logarithmic {
                        c: 0.0169,
                        reference: 5e-5,
                    },
                    time_constant: 1e-3,
                    max_factor: 1.25,
                    hinge_length: 0.22,
                    section_height: 0.22,
                }),
                ..bollard(1.0)
            };
            respond(&column, &impact, 1.0).expect("a response").max_v1
        });
        assert!(
            (midpoint / conserving - 1.0).abs() < 2e-3,
            "{midpoint} {conserving}"
        );
    }
}

/// The long steps and the early end of studies hold for cantilevers.
#[test]
fn a_study_agrees_with_the_plain_response() {
    for (velocity, vehicle) in [
        (1.0, None),
        (5.0, None),
        (2.0, Some(lorry())),
        (0.3, Some(lorry())),
    ] {
        let column = ColumnProperties {
            step_nanos: 0,
            ..bollard(1.0)
        };
        let impact = Impact {
            vehicle,
            ..Impact::rigid(vehicle.map_or(1500.0, |it| it.total_mass()), velocity)
        };
        let study = StudyModel::new(&column, 1.0).expect("a column");
        let rest = State::at_rest(study.model());
        let found = study.respond(&rest, &impact, 2.0).expect("a response");
        let plain = respond(&study.model().properties, &impact, 2.0).expect("a response");
        assert_eq!(found.outcome, plain.outcome);
        assert!(
            (found.max_v1 / plain.max_v1 - 1.0).abs() < 5e-3,
            "{velocity}"
        );
        if found.ended_early {
            let mut state = found.last;
            for _ in 0..(0.05 / study.model().step_secs) as u64 {
                step(study.model(), &mut state).expect("a step");
                assert!(!state.is_flowing() && state.contact_force == 0.0);
            }
        }
    }
}

/// What does not belong together is rejected with what to do.
#[test]
fn a_free_top_that_cannot_be_is_rejected() {
    let good = bollard(1.0);
    for (column, text) in [
        (
            ColumnProperties {
                top_load: 1e3,
                ..good
            },
            "set the load on the top to 0",
        ),
        (
            ColumnProperties {
                top_spring_stiffness: 1e7,
                ..good
            },
            "set the stiffness of the top spring to 0",
        ),
        (
            ColumnProperties {
                base: Support::Pinned,
                ..good
            },
            "nothing holds the column",
        ),
        (
            ColumnProperties {
                base: Support::Free,
                ..good
            },
            "only the top may be",
        ),
        (
            ColumnProperties {
                elastic_law: ElasticLaw::Uncoupled,
                hinge_stiffness: [None, Some(1e7), None, None],
                ..good
            },
            "hinges 1b and 2 bear no moment",
        ),
    ] {
        let error = Model::new(&column).expect_err(text).to_string();
        assert!(error.contains(text), "{error}");
    }
    let model = Model::new(&good).expect("a column");
    let error = capacity(&model, &State::at_rest(&model), 0.005).expect_err("no capacity");
    assert_eq!(error, CapacityError::FreeTop);
    assert!(error.to_string().contains("not evaluated: the top is free"));
}

/// Random cantilevers neither panic nor lose energy.
#[test]
fn random_cantilevers_keep_their_energy() {
    let config = Config {
        cases: 1_500,
        failure_persistence: None,
        ..Config::default()
    };
    let seed = TestRng::deterministic_rng(config.rng_algorithm);
    let mut runner = TestRunner::new_with_rng(config, seed);
    let strategy = (
        (0.02_f64..3.0, 0.02_f64..3.0, 0.05_f64..5.0),
        (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>()),
        (10.0_f64..1e4, 0.1_f64..30.0, 0.0_f64..2e4),
    );
    runner
        .run(
            &strategy,
            |((a, b, size), (coupled, heavy, sheared, deformable), (mass, v, push))| {
                let column = ColumnProperties {
                    length_below: a,
                    length_above: b,
                    bending_stiffness: 1.7e7 * size,
                    elastic_law: if coupled {
                        ElasticLaw::Coupled
                    } else {
                        ElasticLaw::Uncoupled
                    },
                    top_mass: if heavy { 200.0 } else { 0.0 },
                    shear: sheared.then(|| web(400e3)),
                    step_nanos: 20_000,
                    ..bollard(1.0)
                };
                let vehicle = deformable.then(lorry);
                let mass = vehicle.map_or(mass, |it| it.total_mass());
                let impact = Impact {
                    vehicle,
                    transverse_force: push.min(50.0 * mass),
                    ..Impact::rigid(mass, v)
                };
                let report = respond(&column, &impact, 0.03);
                let report = report.map_err(|fault| TestCaseError::fail(fault.to_string()))?;
                prop_assert!(report.max_v1.is_finite());
                prop_assert!(
                    report.ledger_residual < 1e-9,
                    "{:e}",
                    report.ledger_residual
                );
                Ok(())
            },
        )
        .unwrap_or_else(|failure| panic!("{failure}"));
}
