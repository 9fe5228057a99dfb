//! What a base plate bears, in the response: it caps the moment of hinge 3.

mod example;
#[allow(dead_code, reason = "the cases are for other tests")]
mod finite_elements;

use column_mechanics::{
    Anchors, BaseFactors, BasePlate, BaseResistance, ColumnProperties, CrushCurve, CrushSpring,
    Impact, Model, PushDown, Scheme, State, Vehicle, plastic_plateau, respond, simulate,
};
use finite_elements::{YIELD_STRENGTH, column, section};

const SCHEMES: [Scheme; 2] = [Scheme::ConservingMidpoint, Scheme::Midpoint];

/// The plate that an engineer has worked out by hand: 400 x 400 x 30 with four M24 8.8 at 140 mm from the axis, in C25/30.
fn plate() -> BaseResistance {
    let plate = BasePlate {
        section: section("HEB220"),
        thickness: 0.030,
        length: 0.400,
        width: 0.400,
        yield_strength: YIELD_STRENGTH,
        anchors: Anchors {
            count: 4,
            diameter: 0.024,
            ultimate_strength: 800e6,
            yield_strength: 640e6,
            distance: 0.140,
        },
        concrete_strength: 25e6,
        concrete_modulus: 31e9,
        friction: 0.2,
    };
    let resistance = plate.resistance(&BaseFactors::CHARACTERISTIC);
    resistance.expect("a plate")
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
            &heb220(scheme, Some(plate)),
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
