//! What the sensors of a simulated impact read, and tables of readings.

use column_twin::column::{
    BarForces, ColumnProperties, Impact, Model, Outcome, Response, State, simulate,
};
use column_twin::estimation::{Probe, Readings, predicted_means, simulate_sensors};
use column_twin::parameters::Parameters;
use column_twin::sensors::{Quantity, Sensor};
use column_twin::standing::StandingColumn;

use super::signals::with_sensors;

fn sensor(name: &str, quantity: Quantity, height: f64) -> Sensor {
    Sensor {
        name: name.to_owned(),
        quantity,
        height,
        range: 0.0,
        noise: 0.0,
        bias: 0.0,
        gain_error: 0.0,
        rate: 1e4,
        bandwidth: 5e3,
        reversed: false,
        fibre: 0.11,
    }
}

/// A column while it bends elastically.
fn soon_after_an_impact(model: &Model) -> State {
    let mut state = State::at_rest(model);
    let impact = Impact::rigid(500.0, 0.5);
    let mut response = Response::begin(model, &mut state, impact, 1.0).expect("an impact");
    for _ in 0..150 {
        let _ = response.advance(model, &mut state, 1).expect("a step");
    }
    assert!(state.displacement.v1 > 1e-4);
    state
}

/// The cubic between the ends meets the boundary conditions of the elastic beam.
#[test]
fn readings_along_the_bars_join_at_the_impact_point_and_meet_the_supports() {
    // A web that deforms turns the axis where the shear force changes.
    let properties = ColumnProperties {
        shear: None,
        ..Parameters::default().column_properties()
    };
    let model = Model::new(&properties).expect("a column");
    let state = soon_after_an_impact(&model);
    let height = properties.length_below + properties.length_above;
    let read = |quantity, at: f64| Probe::new(&model, &sensor("s", quantity, at)).read(&state);
    let below = properties.length_below;
    for quantity in [
        Quantity::Displacement,
        Quantity::Rotation,
        Quantity::BendingStrain,
    ] {
        let (left, right) = (read(quantity, below), read(quantity, below * (1.0 + 1e-12)));
        // The impact point of the model has no rotational mass: its moments balance. The chords are those of large
        // rotations.
        assert!(
            (left - right).abs() <= 1e-3 * left.abs().max(1e-9),
            "{quantity:?} {left} {right}"
        );
    }
    assert_eq!(read(Quantity::Displacement, 0.0), 0.0);
    assert!(read(Quantity::Displacement, height).abs() < 1e-15);
    // Built in: no rotation at the ends.
    let scale = state.displacement.v1 / below;
    assert!(read(Quantity::Rotation, 0.0).abs() < 1e-3 * scale);
    assert!(read(Quantity::Rotation, height).abs() < 1e-3 * scale);
    // The rotation is the derivative of the displacement.
    let at = 0.3 * below;
    let step = 1e-5;
    let difference =
        read(Quantity::Displacement, at + step) - read(Quantity::Displacement, at - step);
    assert!((difference / (2.0 * step) - read(Quantity::Rotation, at)).abs() < 1e-6 * scale);
}

/// The axis of a bar leans by the shear angle of its web where the section is built in, and kinks by both at the impact point.
#[test]
fn the_axis_of_a_sheared_bar_leans_by_the_angle_of_its_web() {
    let properties = Parameters::default().column_properties();
    let rigidity = properties.shear.expect("a web").rigidity;
    let model = Model::new(&properties).expect("a column");
    let state = soon_after_an_impact(&model);
    let [below, above] = properties.clear_lengths();
    let height = properties.length_below + properties.length_above;
    let angle = |forces: &BarForces, length: f64| {
        (forces.moment[0] + forces.moment[1]) / (length * rigidity)
    };
    let angle_below = angle(&state.forces.below, below);
    let angle_above = angle(&state.forces.above, above);
    assert!(angle_below > 1e-5 && angle_above > 1e-5);
    let rotation = |at: f64| Probe::new(&model, &sensor("s", Quantity::Rotation, at)).read(&state);
    // The chords are those of large rotations.
    let scale = state.displacement.v1 / below;
    let close = |found: f64, expected: f64| {
        assert!(
            (found - expected).abs() < 1e-3 * scale,
            "{found} {expected}"
        );
    };
    close(rotation(0.0), angle_below);
    close(rotation(height), -angle_above);
    let struck = properties.length_below;
    close(
        rotation(struck) - rotation(struck * (1.0 + 1e-12)),
        angle_below + angle_above,
    );
}

#[test]
fn a_displacement_at_the_impact_point_and_the_integrated_acceleration_are_those_of_the_response() {
    let parameters = Parameters::default();
    let properties = parameters.column_properties();
    // A front without an impact impulse: the sampling resolves its accelerations.
    let vehicle = parameters
        .vehicle_named("en1991_elastic")
        .expect("a vehicle");
    let impact = Impact {
        vehicle,
        ..Impact::rigid(1500.0, 10.0)
    };
    let below = properties.length_below;
    let sensors = [
        sensor("v", Quantity::Displacement, below),
        sensor("a", Quantity::Acceleration, below),
        sensor("f", Quantity::ContactForce, below),
    ];
    let readings =
        simulate_sensors(&properties, &impact, 1.0, &sensors, 1).expect("a simulated impact");
    let mut history = Vec::new();
    simulate(&properties, &impact, 1.0, &mut |sample| {
        history.push((sample.time, sample.v1))
    })
    .expect("a response");
    let largest = history
        .iter()
        .fold(0.0, |largest: f64, (_, v1)| largest.max(*v1));
    let read = readings
        .rows()
        .fold(0.0, |largest: f64, (_, row)| largest.max(row[0]));
    // The filter at half the rate delays by a fraction of a sample.
    assert!((read / largest - 1.0).abs() < 2e-3, "{read} {largest}");
    let mut velocity = 0.0;
    let mut displacement = 0.0;
    for (time, row) in readings.rows().filter(|(time, _)| *time <= 0.01) {
        velocity += row[1] * 1e-4;
        displacement += velocity * 1e-4;
        if time >= 0.0099 {
            assert!(
                (displacement / row[0] - 1.0).abs() < 0.03,
                "{displacement} {}",
                row[0]
            );
        }
    }
    assert!(
        readings
            .rows()
            .take(900)
            .all(|(time, row)| time < 0.0 && row == [0.0; 3])
    );
}

/// They used to stay where the response ended, in the middle of a vibration.
#[test]
fn readings_after_the_end_of_a_response_are_those_of_the_column_at_rest() {
    let parameters = Parameters::default();
    let properties = parameters.column_properties();
    let below = properties.length_below;
    let sensors = [
        sensor("v", Quantity::Displacement, below),
        sensor("e", Quantity::BendingStrain, 0.1),
        sensor("a", Quantity::Acceleration, below),
    ];
    for (impact, is_elastic) in [
        (Impact::rigid(300.0, 1.0), true),
        (Impact::rigid(1500.0, 5.0), false),
    ] {
        let report = simulate(&properties, &impact, 1.0, &mut |_| {}).expect("a response");
        let residual = report.residual_v1.expect("it stands");
        assert_eq!(residual.abs() < 1e-9, is_elastic, "{residual}");
        let readings = simulate_sensors(&properties, &impact, 1.0, &sensors, 1).expect("readings");
        let rows: Vec<_> = readings.rows().collect();
        let [displacement, strain, acceleration] = rows[rows.len() - 1].1 else {
            panic!("three readings");
        };
        let tolerance = 1e-6 * report.max_v1;
        assert!(
            (displacement - residual).abs() < tolerance,
            "{displacement} {residual}"
        );
        assert!(acceleration.abs() < 1e-3, "{acceleration}");
        assert!(!is_elastic || strain.abs() < 1e-9, "{strain}");
        // What the estimator predicts is the same.
        let column = StandingColumn::undamaged(&parameters);
        let with_sensors = with_sensors(&parameters, &sensors);
        let means = predicted_means(&column, &with_sensors, &impact).expect("a response");
        let last = means[0][means[0].len() - 1];
        // Its steps are longer.
        let error = (last - residual).abs();
        assert!(error < 1e-4 * report.max_v1, "{last} {residual}");
    }
}

/// They used to stay where the hinge fractured, as if the column had come to rest there.
#[test]
fn a_column_with_a_fractured_hinge_does_not_read_as_one_at_rest() {
    let parameters = Parameters::default();
    let properties = parameters.column_properties();
    let below = properties.length_below;
    let sensors = [
        sensor("v", Quantity::Displacement, below),
        sensor("r", Quantity::Rotation, below + 0.5),
        sensor("a", Quantity::Acceleration, below),
    ];
    let impact = Impact::rigid(1500.0, 15.0);
    let mut history = Vec::new();
    let report = simulate(&properties, &impact, 1.0, &mut |sample| {
        history.push((sample.time, sample.v1))
    })
    .expect("a response");
    assert_eq!(report.outcome, Outcome::Fractured);
    let [.., before, last] = history[..] else {
        panic!("a response");
    };
    let speed = (last.1 - before.1) / (last.0 - before.0);
    let readings = simulate_sensors(&properties, &impact, 1.0, &sensors, 1).expect("readings");
    let rows: Vec<_> = readings.rows().collect();
    let [before, last] = [&rows[rows.len() - 101], &rows[rows.len() - 1]];
    assert!(before.0 > report.end_time);
    let rates: [f64; 3] = std::array::from_fn(|k| (last.1[k] - before.1[k]) / (last.0 - before.0));
    assert!((rates[0] / speed - 1.0).abs() < 0.02, "{rates:?} {speed}");
    // The bar above turns back.
    let above = properties.length_above;
    assert!(
        (-rates[1] * above / speed - 1.0).abs() < 0.02,
        "{rates:?} {speed}"
    );
    assert!(last.1[2].abs() < 1e-3, "{:?}", last.1);
}

#[test]
fn a_table_that_was_written_is_read_back_bit_for_bit_and_missing_samples_stay_missing() {
    let sensors = [
        Sensor {
            noise: 1e-4,
            ..sensor("v", Quantity::Displacement, 0.8)
        },
        Sensor {
            rate: 2e3,
            bandwidth: 1e3,
            ..sensor("e", Quantity::BendingStrain, 0.1)
        },
    ];
    let properties = Parameters::default().column_properties();
    let readings = simulate_sensors(&properties, &Impact::rigid(1500.0, 3.0), 0.1, &sensors, 4)
        .expect("a simulated impact");
    assert!(readings.values.iter().any(|value| value.is_nan()));
    let mut bytes = Vec::new();
    readings.write_csv(&mut bytes, &sensors).expect("memory");
    let read = Readings::from_csv(bytes.as_slice(), &sensors).expect("our own table");
    let bits = |it: &Readings| it.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(read.times, readings.times);
    assert_eq!(bits(&read), bits(&readings));
}

#[test]
fn a_table_with_a_fault_is_rejected_with_its_place() {
    let sensors = [
        sensor("v", Quantity::Displacement, 0.8),
        sensor("e", Quantity::BendingStrain, 0.1),
    ];
    for (text, expected) in [
        ("", "expected a column `time`; found "),
        ("time\n0\n", "expected a column `v`; found time"),
        ("t,v\n0,0\n", "expected a column `time`; found t, v"),
        (
            "time,w\n0,0\n",
            "the column `w` belongs to no sensor of sensors.names; expected time and v, e",
        ),
        (
            "time,v,v\n0,0,0\n",
            "the column `v` appears twice; expected one for each sensor",
        ),
        (
            "time,v\n0,x\n",
            "line 2, column `v`: expected a number or nothing, found `x`",
        ),
        (
            "time,v\nnan,1\n",
            "line 2, column `time`: expected a number or nothing, found `nan`",
        ),
        (
            "time,v\n1,0\n1,0\n",
            "line 3: the time 1 s does not follow 1 s; sort the rows by time",
        ),
        ("time,v\n", "the table has no rows"),
        (
            "time,v\n0,1,2\n",
            "expected a table of comma-separated values",
        ),
        (
            "time,\u{1b}[31m\n0,1\n",
            "the column `\\u{1b}[31m` belongs to no sensor",
        ),
    ] {
        let fault = Readings::from_csv(text.as_bytes(), &sensors)
            .expect_err(text)
            .to_string();
        assert!(fault.starts_with(expected), "{text:?}: {fault}");
    }
}

/// Such as a link to a device. Each took gigabytes and a minute.
#[test]
fn a_table_without_an_end_is_rejected_in_its_first_row_that_is_too_long() {
    let sensors = [sensor("v", Quantity::Displacement, 0.8)];
    for (begin, endless) in [
        ("", 0),
        ("", b'\n'),
        ("", b'#'),
        ("time,v\n0,1\n", b'9'),
        ("time,v\n\"", b'\n'),
    ] {
        let text = std::io::Read::chain(begin.as_bytes(), std::io::repeat(endless));
        let fault = Readings::from_csv(text, &sensors).expect_err("endless");
        let said = fault.to_string();
        assert!(
            said.contains("a row is longer than 1048576 bytes"),
            "{said}"
        );
    }
    let long = format!("time,{}\n0,1\n", "x".repeat(100_000));
    let fault = Readings::from_csv(long.as_bytes(), &sensors).expect_err("no sensor");
    assert!(fault.to_string().len() < 500);
}
