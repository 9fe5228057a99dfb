//! Impacts are found, and nothing else is.

use column_twin::senses::Detector;

use super::signals::{NAMES, Normal, Signal};

#[test]
fn every_impact_is_detected_within_a_millisecond_by_any_set_of_sensors_that_shows_it() {
    for name in NAMES {
        let signal = Signal::read(name);
        for chosen in [
            &[0, 1, 2, 3, 4, 5, 6, 7][..],
            &[1, 3],
            &[1, 4, 5],
            &[0, 1, 2],
        ] {
            for seed in 0..5 {
                let (sensors, readings) = signal.readings(chosen, seed);
                let mut detector = Detector::new(&sensors);
                let mut detections = readings.rows().flat_map(|(time, values)| {
                    let each = values.iter().enumerate();
                    each.filter_map(|(k, value)| detector.push(k, time, *value))
                        .collect::<Vec<_>>()
                });
                let detection = detections.next();
                let detection =
                    detection.unwrap_or_else(|| panic!("{name} {chosen:?} {seed}: not detected"));
                let error = detection.contact.time - signal.number("contact_instant");
                assert!(error.abs() < 1e-3, "{name} {chosen:?} {seed}: {error}");
            }
        }
    }
}

/// Half an hour at 10 kHz; the benchmark `senses` runs through a day.
#[test]
fn noise_slammed_doors_and_drift_are_no_impact() {
    const SECONDS: usize = 1800;
    let signal = Signal::read("s01_rigid_3");
    let sensors: Vec<_> = signal.industrial().into_iter().take(6).collect();
    let mut detector = Detector::new(&sensors);
    let mut normal = Normal::new(11);
    for sample in 0..SECONDS * 10_000 {
        let time = sample as f64 * 1e-4;
        // A door slams every ten seconds: a pulse of 5 ms at 150 Hz, which all sensors feel a little.
        let since = time % 10.0;
        let slam = if since < 5e-3 {
            (std::f64::consts::TAU * 150.0 * since).sin()
        } else {
            0.0
        };
        let drift = (std::f64::consts::TAU * time / 600.0).sin();
        for (k, sensor) in sensors.iter().enumerate() {
            let [slammed, drifted] = match k {
                0..3 => [20.0, 0.05],
                3 => [1e-4, 1e-3],
                _ => [1e-5, 2e-5],
            };
            let value = slammed * slam + drifted * drift + sensor.noise * normal.next();
            let detection = detector.push(k, time, value);
            assert!(
                detection.is_none(),
                "{time} s, {}: {detection:?}",
                sensor.name
            );
        }
    }
}
