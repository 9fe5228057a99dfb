//! What a base plate bears, in the response: it caps the moment of hinge 3 and the shear of the lower bar, and its anchors fracture.

mod example;
#[allow(dead_code, reason = "the cases are for other tests")]
mod finite_elements;

use column_mechanics::{
    Anchors, BaseFactors, BaseFailure, BasePlate, BaseResistance, ColumnProperties, CrushCurve,
    CrushSpring, End, Impact, Model, Outcome, PushDown, Sample, Scheme, ShearProperties, State,
    StudyModel, Support, Vehicle, WebReport, follow, plastic_plateau, respond, simulate,
};
use finite_elements::{YIELD_STRENGTH, column, section};

const SCHEMES: [Scheme; 2] = [Scheme::ConservingMidpoint, Scheme::Midpoint];

/// The plate that an engineer has worked out by hand: 400 x 400 x 30 with four M24 8.8 at 140 mm from the axis, in C25/30.
fn plate() -> BaseResistance {
    let resistance = plate_of(0.024, 800e6, 640e6).resistance(&BaseFactors::CHARACTERISTIC);
    resistance.expect("a plate")
}

/// The same with other anchors.
fn plate_of(diameter: f64, ultimate_strength: f64, yield_strength: f64) -> BasePlate {
    BasePlate {
        section: section("HEB220"),
        thickness: 0.030,
        length: 0.400,
        width: 0.400,
        yield_strength: YIELD_STRENGTH,
        anchors: Anchors {
            count: 4,
            diameter,
            ultimate_strength,
            yield_strength,
            distance: 0.140,
        },
        concrete_strength: 25e6,
        concrete_modulus: 31e9,
        friction: 0.2,
    }
}

/// HEB 220 of 4 m under 490 kN, to be hit by a lorry at 1.25 m.
fn heb220(scheme: Scheme, base_connection: Option<BaseResistance>) -> ColumnProperties {
    ColumnProperties {
        top_load: 490e3,
        top_spring_stiffness: 0.0,
        base_connection,
        scheme,
        ..column("HEB220", [1.25, 2.75], 0.0, 0.0)
    }
}

/// A mass behind a front that gives a constant force once it is crushed by 50 mm.
fn front(force: f64, velocity: f64) -> Impact {
    let spring = CrushSpring {
        envelope: CrushCurve::new(&[[0.05, force], [2.0, force]]).expect("a curve"),
        unloading_stiffness: 2e7,
        slack: 0.0,
    };
    Impact {
        mass: 5000.0,
        velocity,
        vehicle: Some(Vehicle::new(&[5000.0], &[spring]).expect("a vehicle")),
        ..example::paper().1
    }
}

/// By hand: `M(N) = 293.6 (1 - 0.152^1.3) = 268 kNm` above and `M_j = 173 kNm` at the base, so that
/// `F0 = (268 + 173) / 1.25 + 2 x 268 / 2.75 = 548 kN`. Where the base bears what the column does, the web of the lower bar yields
/// first: `V_s + 2 x 268 / 2.75 = 405 + 195 = 600 kN`.
#[test]
fn the_mechanism_of_a_column_on_a_plate() {
    let of = |connection| {
        let model = Model::new(&heb220(SCHEMES[0], connection)).expect("a column");
        plastic_plateau(&model, 490e3) / 1e3
    };
    let (plate, built_in) = (of(Some(plate())), of(None));
    assert!((plate - 548.0).abs() < 2.0, "{plate}");
    assert!((built_in - 600.0).abs() < 2.0, "{built_in}");
}

/// The moment of the base stays below `M_j(N)` and reaches it; the normal force is that of the beginning of each step.
#[test]
fn hinge_3_bears_no_more_than_the_plate() {
    let plate = plate();
    for scheme in SCHEMES {
        let mut most = 0.0_f64;
        let on_plate = simulate(
            &heb220(scheme, Some(plate.without_limits())),
            &front(600e3, 6.0),
            2.0,
            &mut |sample| {
                let hinge = &sample.hinges[3];
                most = most.max(hinge.moment.abs() / plate.moment(hinge.normal_force));
            },
        )
        .expect("a response");
        assert!((0.999..1.01).contains(&most), "{scheme:?}: {most}");
        assert!(on_plate.ledger_residual < 1e-10 || scheme == Scheme::Midpoint);
        let built_in = respond(&heb220(scheme, None), &front(600e3, 6.0), 2.0).expect("a response");
        let [plate, built_in] = [on_plate, built_in].map(|it| it.residual_v1.expect("it stands"));
        println!("{scheme:?}: residual bow {plate:.4} m on the plate, {built_in:.4} m built in");
        assert!(plate > 1.2 * built_in, "{plate} {built_in}");
    }
}

/// A plate that bears more than the column changes nothing.
#[test]
fn a_strong_plate_changes_nothing() {
    let strong = BaseResistance {
        tension: 1e8,
        compression: 1e8,
        anchor_shear: 1e8,
        ..plate()
    };
    for scheme in SCHEMES {
        for impact in [example::paper().1, front(600e3, 6.0)] {
            let [with, without] = [Some(strong), None].map(|connection| {
                respond(&heb220(scheme, connection), &impact, 2.0).expect("a response")
            });
            let off = (with.max_v1 - without.max_v1).abs();
            assert!(off < 1e-9 * without.max_v1, "{with:?} {without:?}");
        }
    }
}

/// The capacity of a column on a plate is at most that of the column that is built in.
#[test]
fn a_plate_adds_no_capacity() {
    let of = |connection| {
        let model = Model::new(&heb220(SCHEMES[0], connection)).expect("a column");
        let state = State::at_rest(&model);
        let mut push_down = PushDown::new(&model, &state, 4e-3).expect("a push-down");
        push_down.advance(u32::MAX).expect("it ends").force
    };
    let (plate, built_in) = (of(Some(plate())), of(None));
    println!("{plate:.4e} N on the plate, {built_in:.4e} N built in");
    assert!(plate <= 1.000_001 * built_in && plate > 0.7 * built_in);
}

/// The column hit at the height of a car.
fn low(scheme: Scheme, plate: BaseResistance) -> ColumnProperties {
    ColumnProperties {
        top_load: 490e3,
        top_spring_stiffness: 0.0,
        base_connection: Some(plate),
        scheme,
        ..column("HEB220", [0.5, 3.5], 0.0, 0.2)
    }
}

/// By hand: the web of the lower bar bears `397 + 2 x 5 / 0.4 = 422 kN`, its base `280 + 0.2 x 490 = 378 kN`, so that the base slips
/// first, and `F0 = 378 + 2 x 268 / 3.4 = 536 kN`.
#[test]
fn a_base_that_bears_less_than_the_web_limits_the_plateau() {
    let model = Model::new(&low(SCHEMES[0], plate())).expect("a column");
    let found = plastic_plateau(&model, 490e3) / 1e3;
    assert!((found - 536.0).abs() < 2.0, "{found}");
}

/// While the foot slips, its shear force is what anchors and friction bear at the normal force of that instant, but for the inertia
/// of the lower bar; without a limit of the slip the response goes on.
#[test]
fn a_slipping_base_bears_its_shear_resistance() {
    let plate = plate();
    for scheme in SCHEMES {
        let (mut last, mut slipped, mut compared) = (Sample::default(), 0.0, 0);
        let mut began = None;
        let observe = |model: &Model, state: &State| {
            let sample = state.sample(model);
            let slip = state.webs.below.slip;
            let step = sample.time - last.time;
            if slip > slipped && step > 0.0 {
                began = began.or(Some(sample.time));
                let acceleration = (sample.v1_rate - last.v1_rate) / step;
                let inertia = model.properties.mass_per_length * 0.5 * acceleration / 6.0;
                let expected = plate.shear(sample.base.normal_force) - inertia;
                let off = (sample.base.shear / expected - 1.0).abs();
                // The step in which contact closes has no acceleration.
                if sample.impact_impulse == 0.0 && last.impact_impulse == 0.0 {
                    assert!(off < 0.03, "{scheme:?} {off} at {sample:?}");
                    compared += 1;
                }
                assert_eq!(sample.webs[0].plastic_angle, last.webs[0].plastic_angle);
            }
            (last, slipped) = (sample, slip);
        };
        let column = low(scheme, plate.without_limits());
        let (report, ..) = follow(&column, &front(600e3, 4.0), 2.0, observe).expect("a response");
        assert!(compared > 50, "{compared}");
        assert_eq!(report.outcome, Outcome::Plastic);
        assert!(report.base.slip > 2.0 * plate.ultimate_slip);
        assert_eq!(report.base.fractured, None);
        // The more the bar leans, the more of the shear its load takes off the base, until the web is the weaker one.
        let first_yield = report.webs[0].first_yield;
        assert!(first_yield.is_none_or(|it| it > began.expect("it slips")));
        assert!(report.ledger_residual < 1e-10 || scheme == Scheme::Midpoint);
        println!("{scheme:?}: slip {:.1} mm", 1e3 * report.base.slip);
    }
}

/// The shear and the uplift of the anchors once only restricted the use of a column, whatever they were.
#[test]
fn a_base_whose_anchors_are_sheared_off_ends_the_response() {
    let plate = plate();
    for scheme in SCHEMES {
        let column = low(scheme, plate);
        let hit = front(600e3, 10.0);
        let mut slips = Vec::new();
        let observe = |_: &Model, state: &State| slips.push(state.webs.below.slip);
        let (report, model, _) = follow(&column, &hit, 2.0, observe).expect("a response");
        assert_eq!(
            (report.outcome, report.end),
            (Outcome::Fractured, End::Fractured)
        );
        assert_eq!(report.base.fractured, Some(BaseFailure::AnchorsInShear));
        assert_eq!(report.residual_v1, None);
        let [before @ .., last] = slips.as_slice() else {
            panic!("no samples")
        };
        assert!(*last > plate.ultimate_slip && report.base.slip == *last);
        assert!(before.iter().all(|slip| *slip <= plate.ultimate_slip));
        assert!(report.ledger_residual < 1e-10 || scheme == Scheme::Midpoint);
        // One of thousands of responses of a study ends there, too.
        let study = StudyModel::of_model(model, 1.0);
        let quick = study
            .respond(&State::at_rest(&model), &hit, 2.0)
            .expect("a response");
        assert_eq!(quick.outcome, Outcome::Fractured);
        assert_eq!(quick.base.fractured, Some(BaseFailure::AnchorsInShear));
        let slow = respond(&column, &front(600e3, 1.0), 2.0).expect("a response");
        assert_ne!(slow.outcome, Outcome::Fractured);
    }
}

/// Thin anchors of a column that is hit high up are stretched by the rotation of its base: `delta = theta (z_T + z_C)`.
#[test]
fn a_base_whose_anchors_are_stretched_too_far_ends_the_response() {
    let thin = plate_of(0.016, 800e6, 640e6).resistance(&BaseFactors::CHARACTERISTIC);
    let plate = BaseResistance {
        // Held by a shear key.
        anchor_shear: 1e7,
        ..thin.expect("a plate")
    };
    assert_eq!(plate.tension_limit, BaseFailure::AnchorsInTension);
    for scheme in SCHEMES {
        let column = heb220(scheme, Some(plate));
        let report = respond(&column, &front(600e3, 8.0), 2.0).expect("a response");
        assert_eq!(report.outcome, Outcome::Fractured);
        assert_eq!(report.base.fractured, Some(BaseFailure::AnchorsInTension));
        let stretched = report.hinges[3].plastic_rotation.abs() * (plate.lever[0] + plate.lever[1]);
        assert!((report.base.anchor_elongation / stretched - 1.0).abs() < 1e-12);
        assert!(stretched > plate.ultimate_elongation);
        assert!(stretched < 1.2 * plate.ultimate_elongation, "{stretched}");
        let lifted = heb220(scheme, Some(plate.without_limits()));
        let lifted = respond(&lifted, &front(600e3, 8.0), 2.0).expect("a response");
        assert_eq!(lifted.outcome, Outcome::Plastic);
    }
}

/// The foot of a column whose web never yields once did not slip, whatever its anchors bore. It slips as that of a column with a web
/// that is too strong to yield: the same equations, with another slider.
#[test]
fn a_foot_slips_whether_or_not_the_web_may_yield() {
    for scheme in SCHEMES {
        let with = low(scheme, plate().without_limits());
        let strong = ShearProperties {
            web_resistance: 1e7,
            flange_moment: 0.0,
            // As stiff as a web without shear, over the whole length of its bar.
            rigidity: 0.0,
            bumper_height: 0.0,
            ..with.shear.expect("a web")
        };
        let [none, strong] = [None, Some(strong)].map(|shear| {
            let column = ColumnProperties { shear, ..with };
            respond(&column, &front(600e3, 4.0), 2.0).expect("a response")
        });
        println!("{scheme:?}: slip {:.1} mm", 1e3 * none.base.slip);
        assert!(none.base.slip > 2.0 * plate().ultimate_slip);
        for (found, expected) in [
            (none.base.slip, strong.base.slip),
            (none.max_v1, strong.max_v1),
            (none.plastic_work, strong.plastic_work),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
        assert_eq!(none.webs, [WebReport::default(); 2]);
        assert_eq!(none.outcome, Outcome::Plastic);
        assert!(none.ledger_residual < 1e-10 || scheme == Scheme::Midpoint);
        // Its anchors are sheared off, too.
        let column = ColumnProperties {
            shear: None,
            ..low(scheme, plate())
        };
        let report = respond(&column, &front(600e3, 4.0), 2.0).expect("a response");
        assert_eq!(report.base.fractured, Some(BaseFailure::AnchorsInShear));
        assert!(report.base.slip > plate().ultimate_slip);
        let study = StudyModel::of_model(Model::new(&column).expect("a column"), 1.0);
        let quick = study
            .respond(&State::at_rest(study.model()), &front(600e3, 4.0), 2.0)
            .expect("a response");
        assert_eq!(quick.base.fractured, Some(BaseFailure::AnchorsInShear));
    }
}

/// By hand, as with a web, over the whole lengths of the bars: `min(2 x 268 / 0.5, (268 + 173) / 0.5, 378) + 2 x 268 / 3.5 = 531 kN`. The
/// push-down knows no slip: it presses on a column that stands.
#[test]
fn the_foot_of_a_column_that_only_bends_limits_the_plateau() {
    let of = |plate| {
        let column = ColumnProperties {
            shear: None,
            ..low(SCHEMES[0], plate)
        };
        Model::new(&column).expect("a column")
    };
    let found = plastic_plateau(&of(plate()), 490e3) / 1e3;
    assert!((found - 531.0).abs() < 2.0, "{found}");
    let [weak, strong] = [1e3, 1e8].map(|anchor_shear| {
        let model = of(BaseResistance {
            anchor_shear,
            friction: 0.0,
            ..plate()
        });
        let mut push_down =
            PushDown::new(&model, &State::at_rest(&model), 4e-3).expect("a push-down");
        push_down.advance(u32::MAX).expect("it ends").force
    });
    assert_eq!(weak.to_bits(), strong.to_bits());
}

/// A pinned base bears no moment, but it slips, and the catenary lifts it.
#[test]
fn a_pinned_base_slips_and_is_torn_off() {
    for scheme in SCHEMES {
        let pinned = |plate| ColumnProperties {
            base: Support::Pinned,
            top_load: 0.0,
            top_spring_stiffness: 1e9,
            ..low(scheme, plate)
        };
        let sheared = respond(&pinned(plate()), &front(800e3, 10.0), 2.0).expect("a response");
        assert_eq!(sheared.base.fractured, Some(BaseFailure::AnchorsInShear));
        let weak = BaseResistance {
            tension: 100e3,
            anchor_shear: 1e7,
            ..plate()
        };
        let lifted = respond(&pinned(weak), &front(800e3, 10.0), 2.0).expect("a response");
        assert_eq!(lifted.outcome, Outcome::Fractured);
        assert_eq!(lifted.base.fractured, Some(BaseFailure::AnchorsInTension));
        assert!(lifted.base.least_compressed.normal_force > weak.uplift());
    }
}
