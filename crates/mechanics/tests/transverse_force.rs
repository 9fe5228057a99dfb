//! A constant force on the vehicle, as the weight of a falling mass.

mod example;

use column_mechanics::{
    ColumnProperties, ElasticLaw, End, Impact, Model, Outcome, Progress, Response, Scheme, State,
    StudyModel, Support, YieldExponents, begin_impact, respond, step,
};
use example::{example, lorry, paper};

/// Acceleration of free fall \[m/s²\].
const GRAVITY: f64 = 9.81;

/// A horizontal beam of 2 m on two supports, which slides freely, of elastic stiffness `48 EI/L^3`.
fn beam(stiffening: f64) -> ColumnProperties {
    ColumnProperties {
        length_below: 1.0,
        length_above: 1.0,
        axial_rigidity: stiffening * 4e9,
        bending_stiffness: stiffening * 2e6,
        mass_per_length: 88.0,
        resistance_moment: 25e3,
        resistance_axial: 1.2e6,
        yield_surface: YieldExponents {
            alpha: 1.0,
            beta: 1.3,
            gamma: 1.0,
        },
        elastic_law: ElasticLaw::Coupled,
        base: Support::Pinned,
        top: Support::Pinned,
        top_spring_stiffness: 0.0,
        top_load: 0.0,
        step_nanos: 2_000,
        ..paper().0
    }
}

fn falling(mass: f64, velocity: f64) -> Impact {
    Impact {
        transverse_force: mass * GRAVITY,
        ..Impact::rigid(mass, velocity)
    }
}

/// The energy balance closes with the work of the force: before, in and after contact, with impact impulses, and with vehicles.
#[test]
fn the_energy_balance_closes_with_the_work_of_the_force() {
    for (changes, tolerance) in [
        (&["impact.transverse_force:=15000"][..], 1e-10),
        (&["impact.transverse_force:=140000"], 1e-10),
        (
            &["impact.transverse_force:=15000", "impact.gap:=0.3"],
            1e-10,
        ),
        (
            &[
                "impact.transverse_force:=15000",
                "impact.restitution:=0.4",
                "impact.velocity:=2",
            ],
            1e-10,
        ),
        (
            &[
                "impact.transverse_force:=80000",
                "vehicle.name:=lorry",
                "impact.gap:=0.2",
                "impact.velocity:=5",
            ],
            1e-10,
        ),
        (
            &[
                "impact.transverse_force:=15000",
                "damping.ratio:=0.02",
                "rate.law:=logarithmic",
                "top.mass:=300",
            ],
            1e-10,
        ),
        // The paper's scheme loses energy in itself: 4e-9 of the input without the force.
        (
            &["impact.transverse_force:=15000", "solver.scheme:=midpoint"],
            1e-7,
        ),
        (
            &[
                "impact.transverse_force:=80000",
                "vehicle.name:=lorry",
                "impact.velocity:=5",
                "solver.scheme:=midpoint",
            ],
            1e-4,
        ),
    ] {
        let (column, impact) = example(changes);
        let report = respond(&column, &impact, 1.0).expect("a response");
        assert!(
            report.ledger_residual < tolerance,
            "{changes:?}: {:e}",
            report.ledger_residual
        );
        let input = report.input_energy + report.load_work;
        let found = report.column_kinetic_energy
            + report.impactor_kinetic_energy
            + report.elastic_energy_change
            + report.plastic_work
            + report.impact_loss
            + report.damping_work
            + report.vehicle.elastic_energy
            + report.vehicle.dissipated.iter().sum::<f64>();
        assert!(
            (found - input).abs() < 10.0 * tolerance * input,
            "{changes:?}: {found} of {input}"
        );
    }
}

/// A mass that falls from a gap arrives with the velocity and at the time of free fall, in one macro-step or step by step, and with
/// either kind of vehicle.
#[test]
fn a_falling_mass_arrives_as_in_free_fall() {
    let (gap, start) = (0.5, 0.7);
    let arrival = (start * start + 2.0 * GRAVITY * gap).sqrt();
    let fall = 2.0 * gap / (start + arrival);
    let column = beam(1.0);
    let vehicle = lorry();
    for impact in [
        falling(300.0, start),
        Impact {
            vehicle: Some(vehicle),
            ..falling(vehicle.total_mass(), start)
        },
    ] {
        let impact = Impact { gap, ..impact };
        for macro_step in [u64::MAX, 1, 700] {
            let model = Model::new(&column).expect("a column");
            let mut state = State::at_rest(&model);
            let mut response = Response::begin(&model, &mut state, impact, 0.2).expect("an impact");
            let mut last = None;
            while state.impact_impulses == 0 && state.contact_force == 0.0 {
                last = state.impactor.map(|it| (it.position, it.velocity));
                let progress = response
                    .advance(&model, &mut state, macro_step)
                    .expect("a step");
                assert_eq!(progress, Progress::Running);
            }
            let touched = state
                .impactor
                .and_then(|it| it.touched_at)
                .expect("a touch");
            assert!((touched / fall - 1.0).abs() < 1e-6, "{touched} {fall}");
            let (position, velocity) = last.expect("an approach");
            let energy = velocity * velocity - 2.0 * GRAVITY * (position + gap);
            assert!((energy / (start * start) - 1.0).abs() < 1e-9, "{energy}");
        }
    }
}

/// Dropped from the height `h` on an elastic beam, a heavy mass deflects it by `d (1 + sqrt(1 + 2 h / d))`, with the static
/// deflection `d = m g / k` under it.
#[test]
fn the_peak_on_an_elastic_beam_is_that_of_the_textbook() {
    let column = ColumnProperties {
        resistance_moment: 1e9,
        resistance_axial: 1e12,
        mass_per_length: 1e-3,
        ..beam(1.0)
    };
    let stiffness = 48.0 * column.bending_stiffness / 8.0;
    for height in [0.01, 0.1] {
        let impact = falling(300.0, (2.0 * GRAVITY * height).sqrt());
        let at_rest = impact.transverse_force / stiffness;
        let expected = at_rest * (1.0 + (1.0 + 2.0 * height / at_rest).sqrt());
        let report = respond(&column, &impact, 1.0).expect("a response");
        let error = report.max_v1 / expected - 1.0;
        assert!(error.abs() < 1e-3, "{error}");
        assert_eq!(report.outcome, Outcome::Elastic);
    }
}

/// `F0 w = E + m g w` with the kinetic energy `E` after the impact impulse, for a rigid-plastic beam.
#[test]
fn the_peak_on_a_rigid_plastic_beam_is_that_of_the_energy_balance() {
    let column = beam(1e3);
    let (mass, own) = (300.0, 88.0 * 2.0 / 3.0);
    let impact = falling(mass, 4.0);
    let after = mass * impact.velocity / (mass + own);
    let energy = 0.5 * (mass + own) * after * after;
    let force = 4.0 * column.resistance_moment / 2.0;
    let expected = energy / (force - impact.transverse_force);
    let without = energy / force;
    let report = respond(&column, &impact, 1.0).expect("a response");
    let error = report.max_v1 / expected - 1.0;
    assert!(error.abs() < 3e-3, "{error}");
    assert!(report.max_v1 > 1.05 * without);
    let residual = report.residual_v1.expect("an equilibrium");
    assert!((residual / expected - 1.0).abs() < 1e-2, "{residual}");
}

/// With damping a mass that stays on the beam presses on it with its weight at the end, and the residual is that of the beam
/// from which it has been taken.
#[test]
fn a_mass_that_stays_rests_with_its_weight() {
    let column = ColumnProperties {
        damping_ratio: 0.3,
        ..beam(1.0)
    };
    let impact = falling(300.0, 2.0);
    let report = respond(&column, &impact, 5.0).expect("a response");
    assert_eq!(report.end, End::AtRest);
    assert_eq!(report.release_time, None);
    let model = Model::new(&column).expect("a column");
    let mut state = State::at_rest(&model);
    begin_impact(&model, &mut state, impact).expect("an impact");
    for _ in 0..500_000 {
        step(&model, &mut state).expect("a step");
    }
    let stiffness = 48.0 * column.bending_stiffness / 8.0;
    let under = impact.transverse_force / stiffness;
    let residual = report.residual_v1.expect("an equilibrium");
    let (force, v1) = (state.contact_force, state.displacement.v1);
    assert!(
        (force / impact.transverse_force - 1.0).abs() < 1e-6,
        "{force}"
    );
    assert!((v1 - residual - under).abs() < 1e-3 * under, "{v1}");
}

/// Without damping a beam vibrates for ever under the mass: the response is over nevertheless, and nothing flows afterwards.
#[test]
fn a_response_under_a_resting_mass_ends_and_nothing_flows_afterwards() {
    for (velocity, vehicle) in [(2.0, None), (5.0, None), (1.0, Some(lorry()))] {
        let column = ColumnProperties {
            step_nanos: 10_000,
            ..beam(1.0)
        };
        let mass = vehicle.map_or(300.0, |it| it.total_mass());
        let impact = Impact {
            vehicle,
            ..falling(mass, velocity)
        };
        if vehicle.is_some() && mass * GRAVITY > 4.0 * column.resistance_moment / 2.0 {
            // It is heavier than what the beam bears.
            let report = respond(&column, &impact, 5.0).expect("a response");
            assert_eq!(report.outcome, Outcome::Collapsed);
            continue;
        }
        let model = Model::new(&column).expect("a column");
        let mut state = State::at_rest(&model);
        let mut response = Response::begin(&model, &mut state, impact, 20.0).expect("an impact");
        let end = loop {
            match response
                .advance(&model, &mut state, u64::MAX)
                .expect("a step")
            {
                Progress::Running => {}
                Progress::Over(end) => break end,
            }
        };
        assert_eq!(end, End::AtRest, "{velocity}");
        let at_end = response.report(&model, &state, end);
        for _ in 0..200_000 {
            let _ = response.advance(&model, &mut state, 1).expect("a step");
        }
        let later = response.report(&model, &state, end);
        assert_eq!(later.max_v1, at_end.max_v1);
        let more = later.plastic_work - at_end.plastic_work;
        assert!(more.abs() < 1e-4 * at_end.plastic_work, "{more}");
    }
}

/// Both schemes converge to one solution.
#[test]
fn both_schemes_agree() {
    for vehicle in [None, Some(lorry())] {
        let (column, impact) = paper();
        let impact = Impact {
            vehicle,
            mass: vehicle.map_or(impact.mass, |it| it.total_mass()),
            transverse_force: 60e3,
            gap: 0.05,
            velocity: 6.0,
            ..impact
        };
        let [conserving, midpoint] = [Scheme::ConservingMidpoint, Scheme::Midpoint].map(|scheme| {
            let column = ColumnProperties {
                scheme,
                step_nanos: 5_000,
                ..column
            };
            respond(&column, &impact, 1.0).expect("a response").max_v1
        });
        assert!(
            (midpoint / conserving - 1.0).abs() < 1e-3,
            "{midpoint} {conserving}"
        );
    }
}

/// A study follows such an impact with the steps of the model: its numbers are those of the plain response, to the last bit.
#[test]
fn a_study_falls_back_to_the_plain_response() {
    for vehicle in [None, Some(lorry())] {
        let (column, impact) = paper();
        let impact = Impact {
            vehicle,
            mass: vehicle.map_or(impact.mass, |it| it.total_mass()),
            transverse_force: 30e3,
            velocity: 5.0,
            ..impact
        };
        let study = StudyModel::new(&column, 1.0).expect("a column");
        let rest = State::at_rest(study.model());
        let found = study.respond(&rest, &impact, 0.3).expect("a response");
        let plain = respond(&column, &impact, 0.3).expect("a response");
        assert_eq!(found.outcome, plain.outcome);
        assert_eq!(found.max_v1, plain.max_v1);
        assert_eq!(found.end, plain.end);
        assert!(!found.ended_early);
        let residual = found.rest.map(|it| it.displacement.v1);
        assert_eq!(residual, plain.residual_v1);
    }
}

/// Infinitely small, the force changes nothing but round-off.
#[test]
fn a_tiny_force_changes_nothing() {
    for name in ["impact.gap:=0.1", "vehicle.name:=lorry", "impact.gap:=0"] {
        let (column, impact) = example(&[name]);
        let without = respond(&column, &impact, 0.1).expect("a response");
        let with = Impact {
            transverse_force: 1e-9,
            ..impact
        };
        let with = respond(&column, &with, 0.1).expect("a response");
        assert!((with.max_v1 / without.max_v1 - 1.0).abs() < 1e-9, "{name}");
        assert!(
            (with.plastic_work / without.plastic_work - 1.0).abs() < 1e-6,
            "{name}"
        );
    }
}
