//! The strength of a hinge over its rotation: hardening of the whole surface, and softening after the capping rotation.

#![allow(
    clippy::disallowed_methods,
    reason = "tests may compare with the system's functions"
)]

mod example;

use column_mechanics::{
    ColumnProperties, ElasticLaw, End, Impact, Model, ModelError, Outcome, Progress, Report,
    Response, Sample, SofteningProperties, State, StudyModel, Support, YieldExponents, capacity,
    residual_state, respond, simulate,
};
use example::{ceb, example};

const DUAN_CHEN: [&str; 3] = [
    "yield_surface.alpha:=1.0",
    "yield_surface.beta:=1.3",
    "yield_surface.gamma:=1.0",
];

const SCHEMES: [&str; 2] = [
    "solver.scheme:=midpoint",
    "solver.scheme:=conserving_midpoint",
];

/// A section that buckles locally early.
const SOFTENING: SofteningProperties = SofteningProperties {
    capping_rotation: 0.02,
    post_capping_rotation: 0.15,
    residual: 0.3,
};

/// The paper's column, softening, with these changes.
fn softening(changes: &[&str]) -> (ColumnProperties, Impact) {
    let (mut properties, impact) = example(&[changes, &DUAN_CHEN[..]].concat());
    properties.softening = Some(SOFTENING);
    (properties, impact)
}

fn follow(properties: &ColumnProperties, impact: &Impact) -> (Report, Vec<Sample>) {
    let mut samples = Vec::new();
    let report =
        simulate(properties, impact, 0.1, &mut |sample| samples.push(*sample)).expect("a response");
    (report, samples)
}

/// A column that is pushed at its middle by a huge slow mass, so that each of its bars sways as a column that is built in at
/// both ends. `observe` sees every step; it ends when the mass is no longer needed, or after 1 s.
fn push(properties: &ColumnProperties, mut observe: impl FnMut(&Model, &State) -> bool) {
    let model = Model::new(properties).expect("a column");
    let mut state = State::at_rest(&model);
    let impact = Impact::rigid(1e9, 0.3);
    let mut response = Response::begin(&model, &mut state, impact, 1.0).expect("an impact");
    while response.advance(&model, &mut state, u64::MAX) == Ok(Progress::Running)
        && observe(&model, &state)
    {}
}

/// The moment of a hinge without normal force, at every rotation of a slow push, against the closed form of the backbone.
#[test]
fn a_pushed_hinge_follows_its_backbone() {
    let (mut properties, _) = softening(&["geometry.length_above:=1.0", "top.load:=0.0"]);
    properties.top_spring_stiffness = 0.0;
    properties.hardening_ratio = 0.01;
    properties.mass_per_length = 1.0;
    properties.elastic_law = ElasticLaw::Coupled;
    let per_rotation = 4.0 * 0.01 * properties.bending_stiffness
        / (properties.length_below * properties.resistance_moment);
    let hardened = |rotation: f64| 1.0 + (per_rotation * rotation).sqrt();
    let mut seen = [0; 3];
    push(&properties, |model, state| {
        let sample = state.sample(model);
        let hinge = &sample.hinges[3];
        let rotation = hinge.plastic_rotation.abs();
        let left = 1.0 - (rotation - 0.02) / 0.15;
        let (part, expected) = match rotation {
            r if r < 2e-3 => return true,
            r if r < 0.02 => (0, hardened(r)),
            _ if left > 0.3 => (1, hardened(0.02) * left),
            _ => (2, hardened(0.02) * 0.3),
        };
        // The normal force that a straight bar gets when it is pushed aside is small, but not 0.
        let n = (hinge.normal_force / properties.resistance_axial).abs();
        assert!(n < 0.02, "{hinge:?}");
        let moment = hinge.moment.abs() / properties.resistance_moment;
        let error = moment / expected - 1.0;
        assert!(error.abs() < 2e-2, "{rotation} rad: {moment} {expected}");
        seen[part] += 1;
        rotation < 0.2
    });
    assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
}

/// The law is one of rotations and needs no length: a finer step changes nothing but the error of the step, which falls.
#[test]
fn responses_with_softening_converge_with_the_step() {
    for scheme in SCHEMES {
        for hardening in [0.0, 0.01] {
            let at = |dt: &str| {
                let dt = format!("solver.dt:={dt}");
                let (mut properties, impact) = softening(&[scheme, dt.as_str()]);
                properties.hardening_ratio = hardening;
                follow(&properties, &impact).0
            };
            let finest = at("1.0e-6");
            let hinges = finest.hinges.map(|hinge| hinge.plastic_rotation.abs());
            assert!(hinges.iter().any(|rotation| *rotation > 0.1), "{hinges:?}");
            let errors = ["1.0e-4", "2.0e-5", "4.0e-6"].map(|dt| {
                let report = at(dt);
                let error = (report.max_v1 / finest.max_v1 - 1.0).abs();
                println!("{scheme} b {hardening} dt {dt}: {error:.1e}");
                error
            });
            assert!(
                errors[0] <= 5e-3 && errors[1] <= 3e-4 && errors[2] <= 4e-5,
                "{errors:?}"
            );
        }
    }
}

/// The drop of the stress onto the smaller surface is plastic work: the balance closes, and the work never decreases.
#[test]
fn the_drop_of_a_softening_hinge_is_in_the_energy_balance() {
    for (hardening, rate) in [(0.0, None), (0.01, None), (0.01, Some(ceb()))] {
        let (mut properties, impact) = softening(&[]);
        properties.hardening_ratio = hardening;
        properties.rate = rate;
        let (report, samples) = follow(&properties, &impact);
        println!("b {hardening}: {:.1e}", report.ledger_residual);
        assert!(report.ledger_residual <= 1e-10);
        let works = samples.windows(2);
        assert!(
            works
                .map(|pair| pair[1].plastic_work - pair[0].plastic_work)
                .all(|work| work >= 0.0)
        );
        // Softening is seen: the column goes further than without.
        let plain = ColumnProperties {
            softening: None,
            ..properties
        };
        assert!(report.max_v1 > 1.05 * follow(&plain, &impact).0.max_v1);
    }
}

#[test]
fn softening_that_is_not_reached_changes_no_bit() {
    for scheme in SCHEMES {
        let (plain, impact) = example(&[&[scheme], &DUAN_CHEN[..]].concat());
        let far = ColumnProperties {
            softening: Some(SofteningProperties {
                capping_rotation: 10.0,
                ..SOFTENING
            }),
            ..plain
        };
        assert_eq!(follow(&far, &impact), follow(&plain, &impact));
    }
}

/// 1a and 1b are in series with one moment: as soon as one of them softens it takes the rotation alone.
#[test]
fn of_two_hinges_in_series_the_weaker_one_localises() {
    let (mut properties, impact) = softening(&[]);
    properties.hardening_ratio = 0.01;
    let (_, samples) = follow(&properties, &impact);
    let rotations = |sample: &Sample| {
        let [below, above, ..] = &sample.hinges;
        [below, above].map(|hinge| hinge.plastic_rotation.abs())
    };
    let softened = |sample: &&Sample| rotations(sample).iter().any(|it| *it > 0.03);
    let first = rotations(samples.iter().find(softened).expect("a softened hinge"));
    let last = rotations(samples.last().expect("samples"));
    let grown = [last[0] - first[0], last[1] - first[1]];
    println!("{first:?} {last:?}");
    let (most, least) = (grown[0].max(grown[1]), grown[0].min(grown[1]));
    assert!(most > 0.03 && least < 0.05 * most, "{grown:?}");
}

/// A column that has lost nearly all of its moment falls under its load: a collapse, as without softening.
#[test]
fn a_column_that_softens_to_nothing_collapses() {
    for scheme in SCHEMES {
        let (mut properties, impact) = softening(&[scheme, "top.spring_stiffness:=0.0"]);
        properties.softening = Some(SofteningProperties {
            residual: 0.0,
            ..SOFTENING
        });
        let report = respond(&properties, &impact, 2.0).expect("a response");
        assert_eq!(
            (report.outcome, report.end),
            (Outcome::Collapsed, End::Collapsed)
        );
    }
}

#[test]
fn studies_follow_softening_hinges() {
    for velocity in [4.0, 6.0, 8.0, 10.0] {
        for vehicle in ["", "vehicle.name:=lorry"] {
            let changes: Vec<_> = ["hinge.elastic_law:=coupled", vehicle]
                .into_iter()
                .filter(|it| !it.is_empty())
                .collect();
            let (mut properties, mut impact) = softening(&changes);
            properties.hardening_ratio = 0.005;
            impact.velocity = velocity;
            let report = respond(&properties, &impact, 2.0).expect("a response");
            let study = StudyModel::new(&properties, 1.0).expect("a column");
            let rest = State::at_rest(study.model());
            let found = study.respond(&rest, &impact, 2.0).expect("a response");
            assert_eq!(found.outcome, report.outcome, "{velocity} {vehicle}");
            if report.outcome == Outcome::Plastic {
                let error = found.max_v1 / report.max_v1 - 1.0;
                println!(
                    "{velocity} m/s {vehicle}: {:.2} mm {error:+.1e}",
                    1e3 * report.max_v1
                );
                assert!(error.abs() < 5e-3, "{velocity} {vehicle}: {error}");
            }
        }
    }
}

/// The push-down has the hinges as the response has left them, and goes on with the same law.
#[test]
fn the_capacity_is_that_of_the_hardened_and_softened_hinges() {
    let (plain, impact) = example(&[&["hinge.elastic_law:=coupled"], &DUAN_CHEN[..]].concat());
    let hardening = ColumnProperties {
        hardening_ratio: 0.01,
        ..plain
    };
    let softened = ColumnProperties {
        softening: Some(SOFTENING),
        ..plain
    };
    let bow = 0.016;
    // The same damage, with different strengths.
    let model = Model::new(&plain).expect("a column");
    let mut state = State::at_rest(&model);
    let mut response = Response::begin(&model, &mut state, impact, 0.1).expect("an impact");
    while response.advance(&model, &mut state, u64::MAX) == Ok(Progress::Running) {}
    let [plain, hardening, softened] = [plain, hardening, softened].map(|properties| {
        let model = Model::new(&properties).expect("a column");
        let undamaged = capacity(&model, &State::at_rest(&model), bow).expect("a bow");
        let rest = residual_state(&model, &state).expect("an equilibrium");
        let damaged = capacity(&model, &rest, bow).expect("a bow");
        assert!(!undamaged.is_lower_bound() && !damaged.is_lower_bound());
        println!(
            "{:.1} kN, {:.1} kN",
            1e-3 * undamaged.force,
            1e-3 * damaged.force
        );
        [undamaged.force, damaged.force]
    });
    // The undamaged column yields so little before its largest force that neither matters much.
    assert!(hardening[0] > plain[0] && hardening[0] < 1.15 * plain[0]);
    assert!((softened[0] / plain[0] - 1.0).abs() < 1e-3);
    // H of a hinge at 0.1 rad is 1.3 to 1.5.
    assert!(hardening[1] > 1.1 * plain[1] && hardening[1] < 1.5 * plain[1]);
    // S of the same hinge is 0.4.
    assert!(softened[1] < 0.9 * plain[1] && softened[1] > 0.3 * plain[1]);
}

/// Whatever a column between two pins gains by hardening, its section bears no more than its squash load.
#[test]
fn a_pinned_column_pushes_down_with_hardening_and_softening() {
    for (b, softening) in [
        (0.02, None),
        (0.02, Some(SOFTENING)),
        (0.0, Some(SOFTENING)),
    ] {
        for load in [0.0, 0.5e6] {
            let (mut properties, _) = example(&DUAN_CHEN);
            properties.elastic_law = ElasticLaw::Coupled;
            (properties.base, properties.top) = (Support::Pinned, Support::Pinned);
            properties.top_load = load;
            properties.hardening_ratio = b;
            properties.softening = softening;
            let model = Model::new(&properties).expect("a column");
            let undamaged = State::at_rest(&model);
            for bow in [1e-3, 0.016, 0.2] {
                let found = capacity(&model, &undamaged, bow).expect("a bow");
                assert!(!found.is_lower_bound(), "{b} {bow}: {found:?}");
                assert!(found.force > 0.0 && found.force <= properties.resistance_axial);
            }
        }
    }
}

#[test]
fn softening_over_no_rotation_is_rejected() {
    let (plain, _) = example(&[]);
    let wrong = [
        (
            SofteningProperties {
                post_capping_rotation: 0.0,
                ..SOFTENING
            },
            "post-capping rotation",
        ),
        (
            SofteningProperties {
                capping_rotation: 0.0,
                ..SOFTENING
            },
            "capping rotation",
        ),
        (
            SofteningProperties {
                residual: 1.1,
                ..SOFTENING
            },
            "residual strength",
        ),
        (
            SofteningProperties {
                post_capping_rotation: f64::NAN,
                ..SOFTENING
            },
            "post-capping rotation",
        ),
    ];
    for (softening, named) in wrong {
        let properties = ColumnProperties {
            softening: Some(softening),
            ..plain
        };
        let error = Model::new(&properties).expect_err(named);
        assert!(matches!(error, ModelError::OutOfRange { .. }), "{error}");
        assert!(error.to_string().contains(named), "{error}");
    }
}

/// Under any normal force the whole surface is larger by `H`: `M = H M_p (1 - (n / H)^1.3)`.
#[test]
fn hardening_enlarges_the_whole_surface() {
    let (mut properties, _) = example(&DUAN_CHEN);
    (properties.length_below, properties.length_above) = (1.0, 1.0);
    properties.yield_surface = YieldExponents {
        alpha: 1.0,
        beta: 1.3,
        gamma: 1.0,
    };
    properties.elastic_law = ElasticLaw::Coupled;
    properties.top_spring_stiffness = 0.0;
    properties.top_load = 0.6 * properties.resistance_axial;
    properties.mass_per_length = 1.0;
    properties.hardening_ratio = 0.01;
    let per_rotation = 0.04 * properties.bending_stiffness
        / (properties.length_below * properties.resistance_moment);
    let mut seen = 0;
    push(&properties, |model, state| {
        let hinge = &state.sample(model).hinges[3];
        let rotation = hinge.plastic_rotation.abs();
        if rotation < 5e-3 {
            return true;
        }
        let h = 1.0 + (per_rotation * rotation).sqrt();
        let n = hinge.normal_force.abs() / properties.resistance_axial;
        let expected = h * (1.0 - (n / h).powf(1.3));
        let moment = hinge.moment.abs() / properties.resistance_moment;
        assert!(
            (moment / expected - 1.0).abs() < 5e-3,
            "{moment} {expected}"
        );
        seen += 1;
        rotation < 0.04
    });
    assert!(seen > 100, "{seen}");
}
