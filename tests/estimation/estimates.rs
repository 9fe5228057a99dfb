//! Estimates of the fibre-beam signals with the errors of industrial sensors.

use column_twin::assessment::Action;
use column_twin::estimation::{
    CredibleInterval, ImpactEstimate, Readings, RecordedImpact, SensorComparison, estimate_recorded,
};

use super::signals::{NAMES, Signal};

/// All sensors; an accelerometer, a displacement sensor and a strain gauge; a displacement sensor alone.
const SETS: [&[usize]; 3] = [&[0, 1, 2, 3, 4, 5, 6, 7], &[1, 3, 4], &[3]];

fn estimated(signal: &Signal, chosen: &[usize], seed: u64) -> RecordedImpact {
    let (sensors, readings) = signal.readings(chosen, seed);
    estimate_recorded(&signal.parameters(), &sensors, &readings, 1, &mut |_| {})
        .expect("sensors")
        .unwrap_or_else(|| panic!("{} with {chosen:?} is not detected", signal.name))
}

fn is_within(interval: &CredibleInterval, truth: f64) -> bool {
    (interval.low..=interval.high).contains(&truth)
}

/// Whether the 90 % intervals of mass, speed, momentum, peak and residual hold the truth.
fn holds(signal: &Signal, estimate: &ImpactEstimate) -> [bool; 5] {
    let number = |name| signal.number(name);
    [
        is_within(&estimate.mass, number("mass")),
        is_within(&estimate.velocity, number("speed")),
        is_within(&estimate.momentum, number("mass") * number("speed")),
        is_within(&estimate.peak_v1, number("peak_v1")),
        is_within(&estimate.residual_v1, number("residual_v1")),
    ]
}

#[test]
#[ignore = "slow: estimates of many impacts take minutes"]
fn intervals_hold_the_truth_of_a_model_of_other_authorship() {
    let (mut held, mut total) = (0, 0);
    for name in NAMES {
        let signal = Signal::read(name);
        for chosen in SETS {
            let contact = signal.number("contact_instant");
            for estimate in estimated(&signal, chosen, 7).estimates {
                // A tenth of a millisecond for the instant that was detected.
                if estimate.data_until >= contact + 9.9e-3 {
                    let holds = holds(&signal, &estimate);
                    held += holds.iter().filter(|it| **it).count();
                    total += holds.len();
                }
            }
        }
    }
    let share = f64::from(held as u32) / f64::from(total as u32);
    println!("{held} of {total} intervals hold the truth");
    assert!(share >= 0.8, "{held} of {total}");
}

#[test]
fn the_last_estimate_with_all_sensors_is_close_to_the_truth() {
    for name in NAMES {
        let signal = Signal::read(name);
        let impact = estimated(&signal, SETS[0], 3);
        let last = impact.estimates.last().expect("an estimate");
        let number = |name| signal.number(name);
        let (mass, speed) = (number("mass"), number("speed"));
        println!(
            "{name}: errors of mass, speed, momentum, peak, residual [%] by data after contact [ms]"
        );
        for estimate in &impact.estimates {
            let since = 1e3 * (estimate.data_until - number("contact_instant"));
            let error = |of: &CredibleInterval, truth: f64| 100.0 * (of.mean / truth - 1.0);
            println!(
                "{since:>8.1} {:>7.1} {:>7.1} {:>7.1} {:>7.1} {:>7.1}",
                error(&estimate.mass, mass),
                error(&estimate.velocity, speed),
                error(&estimate.momentum, mass * speed),
                error(&estimate.peak_v1, number("peak_v1")),
                error(&estimate.residual_v1, number("residual_v1"))
            );
        }
        let relative =
            |interval: &CredibleInterval, truth: f64| (interval.mean / truth - 1.0).abs();
        let report = format!("{name}: {last:#?}");
        assert!(relative(&last.momentum, mass * speed) < 0.15, "{report}");
        let peak = number("peak_v1");
        let error = (last.peak_v1.mean - peak).abs();
        assert!(error < (0.1 * peak).max(1e-3), "{report}");
        let residual = number("residual_v1");
        let error = (last.residual_v1.mean - residual).abs();
        assert!(error < (0.1 * residual).max(2e-3), "{report}");
        if signal.truth["vehicle"] == "rigid" {
            assert_eq!(last.vehicle_probabilities[0].0, "rigid", "{report}");
        }
        let elastic = signal.truth["outcome"] == "elastic";
        assert!(
            if elastic {
                last.yielded < 0.05
            } else {
                last.yielded > 0.95
            },
            "{report}"
        );
        let none = last.action.iter().find(|it| it.0 == Action::None);
        assert!(none.is_some_and(|it| (it.1 > 0.9) == elastic), "{report}");
    }
}

/// The data that are compared have weighed the responses, so that fewer than 90 % inside would show a band that is too narrow.
#[test]
fn most_readings_are_within_the_predicted_band_and_those_of_a_wrong_sensor_are_not() {
    let signal = Signal::read("s02_rigid_10");
    let (sensors, mut readings) = signal.readings(SETS[0], 11);
    let laser = sensors
        .iter()
        .position(|it| it.name == "v1")
        .expect("a laser");
    let estimate = |readings: &Readings| {
        estimate_recorded(&signal.parameters(), &sensors, readings, 1, &mut |_| {})
            .expect("sensors")
            .expect("an impact")
    };
    // Without it, the others do not tell after 30 ms whether the column stands.
    let share_of_first = |comparison: &SensorComparison| {
        let first = comparison
            .means
            .iter()
            .filter(|it| (0.0..0.03).contains(&it.time));
        let inside = first
            .clone()
            .filter(|it| is_within(&it.predicted, it.measured));
        inside.count() as f64 / first.count() as f64
    };
    let right = estimate(&readings);
    assert_eq!(right.comparisons.len(), sensors.len());
    for comparison in &right.comparisons {
        let name = &sensors[comparison.sensor].name;
        assert!(comparison.counts && !comparison.means.is_empty(), "{name}");
        // One in ten, and one of the few that a gauge has before it is lost.
        let means = comparison.means.iter();
        let outside = means.filter(|it| !is_within(&it.predicted, it.measured));
        let outside = outside.count();
        let most = comparison.means.len().div_ceil(10);
        assert!(outside <= most, "{name}: {outside}");
    }
    // The largest mean of the laser is that of the displacement at its peak, which the truth knows.
    let means = right.comparisons[laser].means.iter();
    let largest = means.map(|it| it.measured).fold(0.0, f64::max);
    let peak = signal.number("peak_v1");
    assert!((largest / peak - 1.0).abs() < 0.05, "{largest} {peak}");

    for row in readings.values.chunks_exact_mut(sensors.len()) {
        row[laser] *= -3.0;
    }
    let wrong = estimate(&readings);
    let comparison = &wrong.comparisons[laser];
    assert!(!comparison.counts);
    let share = share_of_first(comparison);
    assert!(share < 0.1, "{share}");
}

#[test]
fn the_same_readings_give_the_same_bits_on_any_number_of_threads() {
    let signal = Signal::read("s02_rigid_10");
    let estimate = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| estimated(&signal, SETS[1], 5))
    };
    assert_eq!(format!("{:?}", estimate(1)), format!("{:?}", estimate(3)));
}
