//! A column that sways, as in an earthquake or a storm, is not struck.

use std::f64::consts::TAU;

use column_twin::estimation::{EventEvidence, Readings, Sensing, Work, estimate_recorded};
use column_twin::parameters::Parameters;
use column_twin::sensors::{Quantity, Sensor};
use column_twin::standing::StandingColumn;

use super::signals::{Normal, PERIOD, Signal, batches, with_sensors};

/// Displacement of the impact point \[m\], and strains that belong to it, roughly.
const SIZE: f64 = 5e-3;
const STRAIN: f64 = 2e-4;

/// When it starts to sway \[s\].
const START: f64 = 0.3;

/// An accelerometer, a sensor of displacement, and gauges at the base and at half of the height, whose strains have opposite signs.
const CHOSEN: [usize; 4] = [2, 3, 4, 5];

fn sensors(chosen: &[usize]) -> (Parameters, Vec<Sensor>) {
    let signal = Signal::read("s01_rigid_3");
    let all = signal.industrial();
    let sensors: Vec<_> = chosen.iter().map(|&k| all[k].clone()).collect();
    (with_sensors(&signal.parameters(), &sensors), sensors)
}

/// Readings at rest, and of a sway with a frequency \[Hz\] that suddenly has its full velocity.
fn sway(sensors: &[Sensor], frequency: f64, duration: f64) -> Readings {
    let mut normal = Normal::new(9);
    let circular = TAU * frequency;
    let mut readings = Readings {
        sensors: sensors.len(),
        ..Readings::default()
    };
    for sample in 0..(duration / PERIOD) as u32 {
        let time = PERIOD * f64::from(sample);
        let swing = (circular * (time - START).max(0.0)).sin();
        readings.times.push(time);
        for sensor in sensors {
            let size = match sensor.quantity {
                Quantity::Acceleration => -SIZE * circular * circular,
                Quantity::Displacement => SIZE,
                _ if sensor.name == "bend_base" => -STRAIN,
                _ => STRAIN,
            };
            let value = size * swing + sensor.noise * normal.next();
            readings.values.push(value);
        }
    }
    readings
}

/// It was estimated as an impact, some of them with a probability of evacuation.
#[test]
fn a_sway_that_starts_suddenly_is_no_impact_of_a_recording() {
    for chosen in [&CHOSEN[..], &[3], &[2, 3], &[3, 4]] {
        let (parameters, sensors) = sensors(chosen);
        for frequency in [2.0, 3.0, 5.0, 8.0] {
            let readings = sway(&sensors, frequency, 1.5);
            let found = estimate_recorded(&parameters, &sensors, &readings, 1, &mut |_| {});
            let found = found.expect("sensors");
            assert!(found.is_none(), "{chosen:?}, {frequency} Hz");
        }
    }
}

/// Why the impact that a sway looks like is given up, live; an event may report one, too.
fn reasons_to_give_up(is_reported: bool) -> Vec<&'static str> {
    let (parameters, sensors) = sensors(&CHOSEN);
    let column = StandingColumn::undamaged(&parameters);
    let mut sensing = Sensing::new(&parameters, column).expect("sensors");
    let mut reasons = Vec::new();
    for (number, batch) in batches(&sway(&sensors, 5.0, 0.8), 100) {
        sensing.push(number, batch);
        loop {
            match sensing.step() {
                Work::More { is_urgent: true } => {}
                Work::Estimate(record) if is_reported && record.update == 0 => {
                    let event = EventEvidence {
                        event_id: "gate 17".into(),
                        mass: 1500.0,
                        mass_deviation: 0.3,
                        velocity: 5.0,
                        velocity_deviation: 0.15,
                    };
                    assert!(sensing.note_event(&record.event_id, event));
                }
                Work::Estimate(record) => assert!(is_reported || !record.is_final),
                Work::Missed(reason) => reasons.push(reason),
                Work::More { .. } | Work::Idle => break,
            }
        }
    }
    reasons
}

/// Live, the first estimates come before the column swings back.
#[test]
fn a_sway_that_was_taken_for_an_impact_live_is_given_up() {
    let reasons = reasons_to_give_up(false);
    assert_eq!(reasons.len(), 1, "{reasons:?}");
    assert!(reasons[0].contains("it sways"), "{reasons:?}");
}

/// A vehicle was there, whatever the readings look like.
#[test]
fn an_impact_that_an_event_reports_is_not_given_up_as_a_sway() {
    let reasons = reasons_to_give_up(true);
    assert!(
        !reasons.iter().any(|it| it.contains("it sways")),
        "{reasons:?}"
    );
}
