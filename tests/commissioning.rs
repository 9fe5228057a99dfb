//! The check of sensors at commissioning, against taps on a fibre beam that knows neither modes nor the check.
#![cfg(feature = "cli")]

#[allow(dead_code)] // other tests use more of it
mod program;

use std::fs::{self, File};
use std::sync::OnceLock;

use column_beam::{BeamColumn, BowAxes, Instrument, Sampling, Shape, Steel, Torsion, history};
use column_twin::column::{CrushCurve, CrushSpring, Impact, RolledSection, Support, Vehicle};
use column_twin::commissioning::{
    CheckError, CheckedSensor, Explanation, SensorCheck, SensorFault, check_sensors,
};
use column_twin::estimation::{Readings, with_sensor_errors};
use column_twin::sensors::{Quantity, Sensor};

/// Time between two readings \[s\], readings before the tap and after it.
const PERIOD: f64 = 2.5e-4;
const BEFORE: usize = 200;
const AFTER: usize = 2000;

/// Number of honest recordings of each column.
const SEEDS: u64 = 20;

/// A column that was tapped: with its sensors and what they read without errors.
struct Tapped {
    column: BeamColumn,
    sensors: Vec<Sensor>,
    exact: Readings,
}

/// A column of a section \[m\], with the heights of the tap and of the sensors beside it \[m\].
fn column(
    [depth, width, web_thickness, flange_thickness, root_radius]: [f64; 5],
    [base, top]: [Support; 2],
    [length, tapped, beside]: [f64; 3],
    top_load: f64,
) -> BeamColumn {
    BeamColumn {
        shape: Shape::Rolled(RolledSection {
            depth,
            width,
            web_thickness,
            flange_thickness,
            root_radius,
        }),
        steel: Steel {
            young_modulus: 210e9,
            poisson_ratio: 0.3,
            yield_strength: 355e6,
            hardening_ratio: 1e-3,
            density: 7850.0,
            tensile_strength: None,
        },
        length_below: tapped,
        length_above: length - tapped,
        base,
        top,
        top_spring_stiffness: 0.0,
        top_mass: 0.0,
        top_load,
        rate: None,
        shear: false,
        max_shear_hardening: 0.0,
        torsion: Torsion::SaintVenant,
        torsion_constant: None,
        residual_stress: false,
        bow: 0.0,
        bow_axes: BowAxes::Strong,
        // The ends of what strikes are nodes of the beam, where sensors read exactly.
        bumper_height: 2.0 * beside,
        elements: 40,
        fibres: 0,
        step_nanos: 0,
    }
}

fn sensors(column: &BeamColumn, fibre: f64) -> Vec<Sensor> {
    let sensor = |name: &str, quantity, height, noise| Sensor {
        name: name.to_owned(),
        quantity,
        height,
        range: 0.0,
        noise,
        bias: 0.0,
        gain_error: 0.01,
        rate: 1.0 / PERIOD,
        bandwidth: 0.5 / PERIOD,
        reversed: false,
        fibre,
    };
    let (at, beside) = (column.length_below, 0.5 * column.bumper_height);
    let length = column.length();
    vec![
        sensor("a_low", Quantity::Acceleration, at - beside, 0.02),
        sensor("a_high", Quantity::Acceleration, at + beside, 0.02),
        sensor("laser", Quantity::Displacement, at, 2e-6),
        sensor("strain_low", Quantity::BendingStrain, 0.1 * length, 1e-7),
        sensor("strain_high", Quantity::BendingStrain, 0.6 * length, 1e-7),
    ]
}

/// A hammer with a soft head: 2 kg at 3 m/s, in contact for some milliseconds.
fn tap() -> Impact {
    let spring = CrushSpring {
        envelope: CrushCurve::new(&[[1.0, 2e6]]).expect("a curve"),
        unloading_stiffness: 2e6,
        slack: 0.0,
    };
    Impact {
        vehicle: Some(Vehicle::new(&[2.0], &[spring]).expect("a hammer")),
        ..Impact::rigid(2.0, 3.0)
    }
}

fn tapped(column: BeamColumn, fibre: f64) -> Tapped {
    let sensors = sensors(&column, fibre);
    let instruments: Vec<Instrument> = sensors
        .iter()
        .map(|it| match it.quantity {
            Quantity::Acceleration => Instrument::Acceleration(it.height),
            Quantity::Displacement => Instrument::Displacement(it.height),
            _ => Instrument::BendingStrain(it.height),
        })
        .collect();
    let sampling = Sampling {
        period: PERIOD,
        steps: 5,
        samples: AFTER,
    };
    let truth = history(&column, &tap(), &instruments, &sampling).expect("a tap");
    assert!(!truth.yielded);
    let mut exact = Readings {
        sensors: sensors.len(),
        ..Readings::default()
    };
    for row in 0..BEFORE + AFTER {
        exact.times.push(row as f64 * PERIOD);
        match row.checked_sub(BEFORE) {
            Some(row) => exact.values.extend(&truth.rows[row]),
            None => exact.values.extend([0.0; 5]),
        }
    }
    Tapped {
        column,
        sensors,
        exact,
    }
}

fn all() -> &'static [Tapped; 3] {
    static ALL: OnceLock<[Tapped; 3]> = OnceLock::new();
    ALL.get_or_init(|| {
        let heb220 = [0.22, 0.22, 9.5e-3, 16e-3, 18e-3];
        let heb300 = [0.30, 0.30, 11e-3, 19e-3, 27e-3];
        let hea200 = [0.19, 0.20, 6.5e-3, 10e-3, 18e-3];
        let soft = Support::SemiRigid { stiffness: 2e7 };
        [
            tapped(
                column(heb220, [Support::BuiltIn; 2], [4.0, 1.5, 0.5], 0.5e6),
                0.11,
            ),
            tapped(
                column(heb300, [Support::Pinned; 2], [6.0, 2.5, 0.7], 1e6),
                0.15,
            ),
            tapped(
                column(hea200, [soft, Support::Pinned], [3.5, 1.2, 0.4], 0.2e6),
                0.095,
            ),
        ]
    })
}

impl Tapped {
    fn honest(&self, seed: u64) -> Readings {
        with_sensor_errors(&self.exact, &self.sensors, seed)
    }

    fn check(&self, sensors: &[Sensor], readings: &Readings) -> SensorCheck {
        check_sensors(&self.column, sensors, readings).expect("enough motion")
    }

    /// The check of readings of which those of one sensor were changed.
    fn changed(&self, sensor: usize, seed: u64, change: impl Fn(f64) -> f64) -> SensorCheck {
        let mut readings = self.honest(seed);
        for row in readings.values.chunks_exact_mut(self.sensors.len()) {
            row[sensor] = change(row[sensor]);
        }
        self.check(&self.sensors, &readings)
    }
}

/// Asserts that these sensors have a fault like this, and that others are wrong at most in their place.
fn assert_found(check: &SensorCheck, wrong: &[usize], is_it: impl Fn(&SensorFault) -> bool) {
    let names: Vec<&str> = wrong
        .iter()
        .map(|it| check.sensors[*it].name.as_str())
        .collect();
    for (index, sensor) in check.sensors.iter().enumerate() {
        let CheckedSensor { faults, or, .. } = sensor;
        if wrong.contains(&index) {
            assert!(faults.iter().any(&is_it), "{}: {check:#?}", sensor.name);
        } else {
            let in_place = or.iter().any(|it| names.contains(&it.as_str()));
            assert!(faults.is_empty() || in_place, "{}: {check:#?}", sensor.name);
        }
    }
}

fn explained(fault: &SensorFault, is_it: impl Fn(&Explanation) -> bool) -> bool {
    matches!(fault, SensorFault::Explained(it) if is_it(it))
}

#[test]
fn honest_sensors_are_consistent() {
    for tapped in all() {
        for seed in 0..SEEDS {
            let check = tapped.check(&tapped.sensors, &tapped.honest(seed));
            assert!(check.is_consistent(), "{seed} {check:#?}");
            for mode in &check.modes {
                let found = mode.found.expect("a vibration");
                let off = found / mode.declared - 1.0;
                assert!(off.abs() < 0.01, "{seed} {check:#?}");
            }
            for support in &check.supports {
                assert!(support.is_as_declared(), "{seed} {check:#?}");
            }
        }
    }
}

#[test]
fn a_wrong_sign_is_found() {
    for tapped in all() {
        for sensor in 0..5 {
            let check = tapped.changed(sensor, 3, |it| -it);
            assert_found(&check, &[sensor], |it| {
                explained(it, |it| *it == Explanation::WrongSign)
            });
            // The same lie, told by the parameters.
            let mut sensors = tapped.sensors.clone();
            sensors[sensor].reversed = true;
            let check = tapped.check(&sensors, &tapped.honest(4));
            assert_found(&check, &[sensor], |it| {
                explained(it, |it| *it == Explanation::WrongSign)
            });
        }
    }
}

/// One error of the gain counted in both modes as if it were two independent ones, so that honest sensors were accused.
#[test]
fn honest_sensors_of_a_coarse_gain_are_rarely_accused() {
    let mut accused = 0;
    for tapped in all() {
        let mut sensors = tapped.sensors.clone();
        for sensor in &mut sensors {
            sensor.gain_error = 0.05;
        }
        for seed in 0..SEEDS {
            let readings = with_sensor_errors(&tapped.exact, &sensors, seed);
            accused += usize::from(!tapped.check(&sensors, &readings).is_consistent());
        }
    }
    assert!(accused <= 1, "{accused} of {} recordings", 3 * SEEDS);
}

#[test]
fn a_wrong_gain_is_found() {
    for tapped in all() {
        for sensor in 0..5 {
            for gain in [0.5, 0.85, 1.2, 2.0] {
                let check = tapped.changed(sensor, 5, |it| gain * it);
                assert_found(&check, &[sensor], |it| {
                    explained(
                        it,
                        |it| matches!(it, Explanation::Gain(found) if (found / gain - 1.0).abs() < 0.08),
                    )
                });
            }
        }
    }
}

#[test]
fn a_wrong_height_is_found() {
    for tapped in all() {
        // Sensors whose readings depend on the height.
        for sensor in [0, 3] {
            let mut sensors = tapped.sensors.clone();
            let length = tapped.column.length();
            let right = sensors[sensor].height;
            sensors[sensor].height = right + 0.2 * length;
            let check = tapped.check(&sensors, &tapped.honest(6));
            assert_found(&check, &[sensor], |it| {
                explained(
                    it,
                    |it| matches!(it, Explanation::Height(found) if (found - right).abs() < 0.06 * length),
                )
            });
        }
    }
}

#[test]
fn sensors_that_are_exchanged_are_found() {
    for tapped in all() {
        for [one, two] in [[0, 1], [3, 4], [0, 2]] {
            let mut readings = tapped.honest(7);
            for row in readings.values.chunks_exact_mut(5) {
                row.swap(one, two);
            }
            let check = tapped.check(&tapped.sensors, &readings);
            assert_found(&check, &[one, two], |it| {
                explained(it, |it| matches!(it, Explanation::Swapped(_)))
            });
        }
    }
}

#[test]
fn a_sensor_that_is_dead_stuck_or_saturated_is_found() {
    for tapped in all() {
        for sensor in 0..5 {
            let honest = tapped.honest(8);
            let values = honest.values.chunks_exact(5);
            let most = values.fold(0.0, |most: f64, row| most.max(row[sensor].abs()));
            // Noise alone.
            let still = Readings {
                values: vec![0.0; tapped.exact.values.len()],
                ..tapped.exact.clone()
            };
            let noise = with_sensor_errors(&still, &tapped.sensors, 9);
            let mut readings = honest.clone();
            for (row, noise) in readings
                .values
                .chunks_exact_mut(5)
                .zip(noise.values.chunks_exact(5))
            {
                row[sensor] = noise[sensor];
            }
            let check = tapped.check(&tapped.sensors, &readings);
            assert_found(&check, &[sensor], |it| {
                explained(it, |it| *it == Explanation::Dead)
            });
            // Not also at a height where the mode is zero.
            assert_eq!(check.sensors[sensor].faults.len(), 1, "{check:#?}");
            let check = tapped.changed(sensor, 8, |_| 0.3);
            assert_found(&check, &[sensor], |it| *it == SensorFault::Stuck(0.3, 1.0));
            let end = 0.4 * most;
            let check = tapped.changed(sensor, 8, |it| it.clamp(-end, end));
            assert_found(
                &check,
                &[sensor],
                |it| matches!(it, SensorFault::Saturated(found, _) if *found == end),
            );
        }
    }
}

#[test]
fn a_rate_that_differs_from_the_declared_one_is_found() {
    for tapped in all() {
        let mut sensors = tapped.sensors.clone();
        sensors[1].rate = 1000.0;
        sensors[1].bandwidth = 500.0;
        let check = tapped.check(&sensors, &tapped.honest(10));
        let found = |it: &SensorFault| matches!(it, SensorFault::Rate(found) if (found * PERIOD - 1.0).abs() < 0.01);
        assert!(check.sensors[1].faults.iter().any(found), "{check:#?}");
    }
}

#[test]
fn a_clock_that_is_behind_is_found() {
    for tapped in all() {
        let frequency = tapped.check(&tapped.sensors, &tapped.honest(1)).modes[0].found;
        let rows = (0.2 / frequency.expect("a vibration") / PERIOD).round() as usize;
        let honest = tapped.honest(11);
        let mut readings = honest.clone();
        for row in rows..honest.times.len() {
            readings.values[5 * row + 1] = honest.values[5 * (row - rows) + 1];
        }
        let check = tapped.check(&tapped.sensors, &readings);
        let delay = rows as f64 * PERIOD;
        assert_found(
            &check,
            &[1],
            |it| matches!(it, SensorFault::OutOfPhase(_, found) if (found - delay).abs() < 0.2 * delay),
        );
    }
}

/// These sensors, of which some are late by some rows.
fn late(readings: &Readings, sensors: &[usize], late: &[usize], rows: usize) -> Readings {
    let mut chosen = Readings {
        times: readings.times.clone(),
        sensors: sensors.len(),
        ..Readings::default()
    };
    for row in 0..readings.times.len() {
        chosen.values.extend(sensors.iter().map(|sensor| {
            let delay = if late.contains(sensor) { rows } else { 0 };
            readings.values[readings.sensors * row.saturating_sub(delay) + sensor]
        }));
    }
    chosen
}

/// The real part of an amplitude in the second mode was half of it, although the delay passed in the first mode.
#[test]
fn a_small_delay_is_no_wrong_gain_and_shows_in_the_second_mode() {
    for tapped in all() {
        let modes = tapped.check(&tapped.sensors, &tapped.honest(1)).modes;
        let [first, second] = [0, 1].map(|mode| modes[mode].found.expect("a vibration"));
        let mut is_seen = false;
        for rows in 1..8 {
            let delay = rows as f64 * PERIOD;
            if 360.0 * first * delay > 20.0 {
                break;
            }
            let readings = late(&tapped.honest(13), &[0, 1, 2, 3, 4], &[0], rows);
            let check = tapped.check(&tapped.sensors, &readings);
            let is_late = |it: &SensorFault| matches!(it, SensorFault::OutOfPhase(_, found) if (found - delay).abs() < 0.2 * delay);
            for (index, sensor) in check.sensors.iter().enumerate() {
                let mut faults = sensor.faults.iter();
                assert!(
                    faults.all(|it| index == 0 && is_late(it)),
                    "{rows} {check:#?}"
                );
            }
            if (30.0..150.0).contains(&(360.0 * second * delay)) {
                assert!(!check.sensors[0].faults.is_empty(), "{rows} {check:#?}");
                is_seen = true;
            }
        }
        assert!(is_seen, "{first} {second}");
    }
}

/// The first one was right, and the others were wrong for certain.
#[test]
fn clocks_without_a_majority_are_named_together() {
    let tapped = &all()[0];
    let frequency = tapped.check(&tapped.sensors, &tapped.honest(1)).modes[0].found;
    let rows = (0.2 / frequency.expect("a vibration") / PERIOD).round() as usize;
    for (one, other) in [(&[0][..], &[2][..]), (&[0, 2][..], &[3, 4][..])] {
        let chosen = [one, other].concat();
        let sensors: Vec<Sensor> = chosen
            .iter()
            .map(|it| tapped.sensors[*it].clone())
            .collect();
        let readings = late(&tapped.honest(14), &chosen, other, rows);
        let check = tapped.check(&sensors, &readings);
        for (at, found) in check.sensors.iter().enumerate() {
            let contradicting = if at < one.len() { other } else { one };
            let names = contradicting
                .iter()
                .map(|it| tapped.sensors[*it].name.clone());
            assert!(
                matches!(found.faults[..], [SensorFault::OutOfPhase(..)]),
                "{check:#?}"
            );
            assert_eq!(found.or, names.collect::<Vec<_>>(), "{check:#?}");
        }
    }
}

/// Readings in steps larger than the noise are equal while the column rests, and often at their largest value while it vibrates.
#[test]
fn honest_sensors_that_read_in_steps_are_neither_stuck_nor_saturated() {
    for tapped in all() {
        let mut exact = tapped.exact.clone();
        let rest = exact.times.len();
        let begin = exact.times[rest - 1] + PERIOD;
        exact
            .times
            .extend((0..rest).map(|row| begin + row as f64 * PERIOD));
        // At rest before the taps, then a steady sine.
        let waves = (0..rest).map(|row| (300.0 * row as f64 * PERIOD).sin());
        let steady =
            waves.flat_map(|wave| tapped.sensors.iter().map(move |it| 600.0 * it.noise * wave));
        for mut values in [
            [vec![0.0; exact.values.len()], exact.values.clone()].concat(),
            [exact.values.clone(), steady.collect()].concat(),
        ] {
            for row in values.chunks_exact_mut(5) {
                for (value, sensor) in row.iter_mut().zip(&tapped.sensors) {
                    let step = 10.0 * sensor.noise;
                    *value = (*value / step).round() * step;
                }
            }
            let readings = Readings {
                values,
                ..exact.clone()
            };
            let check = tapped.check(&tapped.sensors, &readings);
            for sensor in &check.sensors {
                let mut faults = sensor.faults.iter();
                let is_limit = |it: &SensorFault| {
                    matches!(it, SensorFault::Stuck(..) | SensorFault::Saturated(..))
                };
                assert!(!faults.any(is_limit), "{check:#?}");
            }
        }
    }
}

#[test]
fn too_few_readings_are_not_called_too_short() {
    let tapped = &all()[0];
    let mut readings = tapped.honest(15);
    readings.times.truncate(30);
    readings.values.truncate(30 * 5);
    // After a long gap.
    readings.times[29] = 0.5;
    let fault = check_sensors(&tapped.column, &tapped.sensors, &readings);
    let fault = fault.expect_err("too few");
    assert!(matches!(fault, CheckError::Sparse { .. }), "{fault}");
}

#[test]
fn two_sensors_that_contradict_each_other_are_named_together() {
    let tapped = &all()[0];
    let chosen = [0, 1];
    let sensors = chosen.map(|it| tapped.sensors[it].clone());
    let mut readings = Readings {
        times: tapped.exact.times.clone(),
        sensors: 2,
        ..Readings::default()
    };
    for row in tapped.honest(12).values.chunks_exact(5) {
        readings.values.extend([row[0], 3.0 * row[1]]);
    }
    let check = tapped.check(&sensors, &readings);
    for (sensor, other) in [(0, 1), (1, 0)] {
        let CheckedSensor { faults, or, .. } = &check.sensors[sensor];
        assert!(!faults.is_empty(), "{check:#?}");
        assert_eq!(*or, [sensors[other].name.clone()], "{check:#?}");
    }
}

#[test]
fn too_little_motion_is_told_with_what_was_expected() {
    for tapped in all() {
        let still = Readings {
            values: vec![0.0; tapped.exact.values.len()],
            ..tapped.exact.clone()
        };
        for seed in 0..SEEDS {
            let noise = with_sensor_errors(&still, &tapped.sensors, seed);
            let fault = check_sensors(&tapped.column, &tapped.sensors, &noise);
            let fault = fault.expect_err("noise alone");
            let CheckError::NotEnoughMotion {
                expected, found, ..
            } = &fault
            else {
                panic!("{fault}");
            };
            assert!(expected > found, "{fault}");
            let said = fault.to_string();
            assert!(said.starts_with("not enough motion"), "{said}");
        }
    }
}

#[test]
fn the_stiffness_of_a_support_is_learnt_from_the_frequencies() {
    let tapped = &all()[2];
    let mut declared = tapped.column;
    declared.base = Support::SemiRigid { stiffness: 8e6 };
    let check = check_sensors(&declared, &tapped.sensors, &tapped.honest(2)).expect("motion");
    let base = &check.supports[0];
    assert_eq!(base.end, "base");
    let [_, low, high] = base.stiffness;
    assert!(low <= 2e7 && 2e7 <= high, "{check:#?}");
    assert!(base.is_known(), "{check:#?}");
    assert!(check.is_consistent(), "{check:#?}");
}

/// The parameters of the first column as a file.
fn parameter_file(tapped: &Tapped) -> String {
    let names: Vec<&str> = tapped.sensors.iter().map(|it| it.name.as_str()).collect();
    let mut text = format!(
        "/**:\n  ros__parameters:\n    geometry:\n      length_below: 1.5\n      length_above: 2.5\n    section:\n      name: HEB220\n    \
         steel:\n      grade: S355\n    support:\n      base: built_in\n      top: built_in\n    top:\n      spring_stiffness: 0.0\n      \
         mass: 0.0\n      load: 0.5e+6\n    beam:\n      shear: false\n    sensors:\n      names: [{}]\n",
        names.join(", ")
    );
    for sensor in &tapped.sensors {
        text += &format!(
            "      {}:\n        quantity: {}\n        height: {:?}\n        gain_error: 0.01\n        rate: {:?}\n        fibre: {:?}\n",
            sensor.name,
            sensor.quantity.word(),
            sensor.height,
            sensor.rate,
            sensor.fibre
        );
    }
    text
}

#[test]
fn the_command_prints_a_verdict_for_each_sensor_and_ends_with_its_code() {
    let tapped = &all()[0];
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, readings: &Readings| {
        let file = File::create(folder.path().join(name)).expect("a file");
        readings.write_csv(file, &tapped.sensors).expect("written");
    };
    let honest = tapped.honest(1);
    let mut reversed = honest.clone();
    for row in reversed.values.chunks_exact_mut(5) {
        row[2] = -row[2];
    }
    let still = Readings {
        values: vec![0.0; honest.values.len()],
        ..honest.clone()
    };
    write("honest.csv", &honest);
    write("reversed.csv", &reversed);
    let still = with_sensor_errors(&still, &tapped.sensors, 1);
    write("still.csv", &still);
    fs::write(folder.path().join("column.yaml"), parameter_file(tapped)).expect("written");
    let check = |readings: &str, more: &[&str]| {
        let mut arguments = vec!["sensors", "check", "--config", "column.yaml"];
        arguments.extend(["--readings", readings]);
        arguments.extend(more);
        let output = program::program(folder.path(), &arguments).output();
        let output = output.expect("runs");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        let (out, err) = (text(output.stdout), text(output.stderr));
        (output.status.code(), out, err)
    };
    let (code, out, err) = check("honest.csv", &["--write", "supports.yaml"]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert_eq!(out.matches("consistent").count(), 5, "{out}");
    assert!(err.contains("supports.yaml is not written"), "{err}");
    assert!(!folder.path().join("supports.yaml").exists());
    let (code, out, err) = check("reversed.csv", &[]);
    assert_eq!(code, Some(1), "{out}{err}");
    let line = out.lines().find(|it| it.starts_with("laser"));
    assert!(line.expect("a line").contains("wrong sign"), "{out}");
    assert!(err.contains("the check doubts laser"), "{err}");
    let (code, out, _) = check("reversed.csv", &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(code, Some(1));
    assert_eq!(json["consistent"], false);
    assert_eq!(json["sensors"][2]["faults"][0]["kind"], "wrong_sign");
    let (code, out, err) = check("still.csv", &[]);
    assert_eq!((code, out.as_str()), (Some(3), ""), "{err}");
    assert!(err.contains("not enough motion"), "{err}");
    assert!(err.contains("tap the column harder"), "{err}");
    let mut short = honest.clone();
    short.times.truncate(30);
    short.values.truncate(30 * 5);
    write("short.csv", &short);
    let (code, _, err) = check("short.csv", &[]);
    assert_eq!(code, Some(2), "{err}");
    for word in ["short.csv", "expected", "record for longer"] {
        assert!(err.contains(word), "{err}");
    }
    // A column that is declared with hinges gets lines that fit, as parameters that can be read.
    let hinges = [
        "-p",
        "support.base:=semi_rigid",
        "-p",
        "support.base_stiffness:=8.0e+6",
    ];
    let (code, out, err) = check(
        "honest.csv",
        &[&hinges[..], &["--write", "supports.yaml"]].concat(),
    );
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("the parameters differ"), "{out}{err}");
    let (code, out, err) = check("honest.csv", &["--config", "supports.yaml"]);
    assert_eq!(code, Some(0), "{out}{err}");
}
