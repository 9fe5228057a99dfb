//! Impacts are found, and nothing else is.

use column_twin::estimation::{Detection, Detector};
use column_twin::sensors::{Quantity, Sensor};

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

/// The sensor that usually shows the contact most sharply may have lost just the batch that holds it, as others may. The instant is
/// then that of a sensor that has measured it, not the middle of what is missing.
#[test]
fn a_lost_batch_does_not_move_the_contact() {
    const BATCH: f64 = 0.010;
    for name in ["s01_rigid_3", "s02_rigid_10"] {
        let signal = Signal::read(name);
        let contact = signal.number("contact_instant");
        for chosen in [&[1, 3, 4][..], &[0, 3, 5], &[1, 4, 5]] {
            for lost in 0..chosen.len() {
                for before in [0.0005, 0.005, 0.009] {
                    let (sensors, readings) = signal.readings(chosen, 7);
                    let mut detector = Detector::new(&sensors);
                    let gap = contact - before..contact - before + BATCH;
                    let mut found = None;
                    for (time, values) in readings.rows() {
                        for (k, value) in values.iter().enumerate() {
                            if k != lost || !gap.contains(&time) {
                                found = found.or(detector.push(k, time, *value));
                            }
                        }
                    }
                    let case = format!("{name} {chosen:?} lost {lost} from {before} s before");
                    let found = found.unwrap_or_else(|| panic!("{case}: not detected"));
                    let error = found.contact.time - contact;
                    assert!(error.abs() < 1e-3, "{case}: {error}");
                }
            }
        }
    }
}

/// A soft front takes 15 to 35 ms to rise out of the noise of a laser, and the axial strain may never.
#[test]
fn a_laser_beside_a_gauge_of_axial_strain_detects_alone() {
    for name in NAMES {
        let (sensors, readings) = Signal::read(name).readings(&[3, 6], 0);
        let mut detector = Detector::new(&sensors);
        let found = readings.rows().any(|(time, values)| {
            let mut each = values.iter().enumerate();
            each.any(|(k, value)| detector.push(k, time, *value).is_some())
        });
        assert!(found, "{name}");
    }
}

/// The sensors of `config/sensors_industrial.yaml`.
fn industrial() -> Vec<Sensor> {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let files = ["heb220_s355.yaml", "sensors_industrial.yaml"].map(|name| file.join(name));
    let parameters = column_twin::parameters::Parameters::load(&files, &[]);
    parameters.expect("the shipped files").sensors()
}

/// What disturbs the sensors without an impact: slams of random shape, size and duration, and drift.
struct Disturbances {
    random: Normal,
    next: f64,
    slam: Slam,
    pub slams: u64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Slam {
    at: f64,
    shape: u32,
    duration: f64,
    frequency: f64,
    size: f64,
}

impl Slam {
    /// Between -1 and 1.
    fn at(&self, time: f64) -> f64 {
        use std::f64::consts::{PI, TAU};
        let since = time - self.at;
        let phase = since / self.duration;
        if since < 0.0 || (self.shape < 3 && phase >= 1.0) {
            return 0.0;
        }
        match self.shape {
            0 => (PI * phase).sin(),
            1 => 1.0 - (2.0 * phase - 1.0).abs(),
            2 => (TAU * self.frequency * since).sin(),
            // It rings.
            _ => (-since / (0.3 * self.duration)).exp() * (TAU * self.frequency * since).sin(),
        }
    }
}

impl Disturbances {
    fn new(seed: u64) -> Self {
        Self {
            random: Normal::new(seed),
            next: 2.0,
            slam: Slam::default(),
            slams: 0,
        }
    }

    /// Uniform from 0 to 1.
    fn uniform(&mut self) -> f64 {
        let (a, b) = (self.random.next(), self.random.next());
        a.atan2(b) / std::f64::consts::TAU + 0.5
    }

    /// The slam at this time.
    fn slam(&mut self, time: f64) -> f64 {
        if time >= self.next {
            let shape = (4.0 * self.uniform()) as u32;
            self.slam = Slam {
                at: time,
                shape: shape.min(3),
                duration: 1e-3 + 6e-3 * self.uniform(),
                frequency: 150.0 + 650.0 * self.uniform(),
                size: (0.8 * self.random.next()).exp()
                    * if self.uniform() < 0.5 { -1.0 } else { 1.0 },
            };
            self.slams += 1;
            self.next = time + 1.0 + 10.0 * self.uniform();
        }
        self.slam.size * self.slam.at(time)
    }
}

/// Runs through undisturbed and disturbed operation for so long \[s\]: the first false impact, and the number of slams.
fn false_impact(sensors: &[Sensor], duration: f64, seed: u64) -> (Option<(f64, Detection)>, u64) {
    let rate = 10_000.0;
    let mut detector = Detector::new(sensors);
    let mut disturbances = Disturbances::new(seed);
    // Normal numbers drawn one by one would take most of the time: blocks are taken from a long list at random places.
    let mut normal = Normal::new(seed + 1);
    let list: Vec<f64> = (0..(1 << 20)).map(|_| normal.next()).collect();
    const BLOCK: usize = 4096;
    let mut places = vec![0; sensors.len()];
    let sizes: Vec<_> = sensors
        .iter()
        .map(|it| match it.quantity {
            Quantity::Acceleration => [20.0, 0.05],
            Quantity::Displacement => [5e-5, 2e-3],
            _ => [1e-5, 5e-5],
        })
        .collect();
    for sample in 0..(duration * rate) as usize {
        let time = sample as f64 / rate;
        if sample % BLOCK == 0 {
            for place in &mut places {
                *place = (disturbances.uniform() * (list.len() - BLOCK - 1) as f64) as usize;
            }
        }
        let slam = disturbances.slam(time);
        // Over an hour, and faster over ten minutes.
        let drift = (time / 573.0).sin() + 0.2 * (time / 95.0).sin();
        for (k, sensor) in sensors.iter().enumerate() {
            let [slammed, drifted] = sizes[k];
            let noise = list[places[k] + sample % BLOCK];
            let value = slammed * slam + drifted * drift + sensor.noise * noise;
            if let Some(detection) = detector.push(k, time, sensor.clipped(value)) {
                println!("after {:?}", disturbances.slam);
                return (Some((time, detection)), disturbances.slams);
            }
        }
    }
    (None, disturbances.slams)
}

#[test]
fn noise_slammed_doors_and_drift_are_no_impact() {
    let (found, slams) = false_impact(&industrial(), 600.0, 11);
    assert!(slams > 50, "{slams}");
    assert_eq!(found, None);
}

/// A day of the preset `industrial`, and of accelerometers or of strain gauges alone.
#[test]
#[ignore = "a day of samples takes minutes"]
fn a_day_of_noise_slammed_doors_and_drift_is_no_impact() {
    const DAY: f64 = 86_400.0;
    let all = industrial();
    let runs = [all.clone(), vec![all[0].clone()], vec![all[2].clone()]];
    // All at once: each takes minutes.
    let found = std::thread::scope(|threads| {
        let started = runs
            .each_ref()
            .map(|sensors| threads.spawn(|| false_impact(sensors, DAY, 5)));
        started.map(|run| run.join().expect("no panic"))
    });
    for (sensors, (found, slams)) in runs.iter().zip(found) {
        println!(
            "{} sensors, {DAY} s, {} samples, {slams} slams: {found:?}",
            sensors.len(),
            DAY * 1e4 * sensors.len() as f64,
        );
        assert!(slams > 10_000, "{slams}");
        assert_eq!(found, None);
    }
}

/// Two impacts in one stream: the second begins where the first has left the column.
#[test]
fn the_next_impact_is_detected_when_the_column_is_quiet_again() {
    let signal = Signal::read("s02_rigid_10");
    let (sensors, readings) = signal.readings(&[1, 3, 4], 1);
    let rows: Vec<_> = readings.rows().collect();
    let (_, last) = rows[rows.len() - 1];
    let mut detector = Detector::new(&sensors);
    let mut normal = Normal::new(2);
    let mut detections = Vec::new();
    let mut time = 0.0;
    let mut start = vec![0.0; sensors.len()];
    let mut contacts = Vec::new();
    for _ in 0..3 {
        contacts.push(time + signal.number("contact_instant"));
        for (_, values) in &rows {
            for (k, value) in values.iter().enumerate() {
                detections.extend(detector.push(k, time, start[k] + value));
            }
            time += 1e-4;
        }
        // It vibrates for a while, and comes to rest where the impact has left it.
        for (k, value) in last.iter().enumerate() {
            if sensors[k].quantity != Quantity::Acceleration {
                start[k] += value;
            }
        }
        for sample in 0..40_000 {
            let since = f64::from(sample) * 1e-4;
            let swing = (-since / 0.4).exp() * (157.0 * since).sin();
            for (k, sensor) in sensors.iter().enumerate() {
                let size = if sensor.quantity == Quantity::Acceleration {
                    20.0
                } else {
                    1e3 * sensor.noise / 5.0
                };
                let value = start[k] + size * swing + sensor.noise * normal.next();
                detections.extend(detector.push(k, time, value));
            }
            time += 1e-4;
        }
    }
    let found: Vec<_> = detections.iter().map(|it| it.contact.time).collect();
    assert_eq!(found.len(), contacts.len(), "{found:?} {contacts:?}");
    for (found, contact) in found.iter().zip(&contacts) {
        assert!((found - contact).abs() < 1e-3, "{found} {contact}");
    }
    let zero = detections[2].zeros[1].0;
    let expected = 2.0 * last[1];
    assert!((zero - expected).abs() < 1e-3, "{zero} {expected}");
}

/// A laser whose beam is interrupted, a gauge that comes off: the other sensors detect nothing.
#[test]
fn a_step_of_one_sensor_alone_is_no_impact() {
    let sensors = industrial();
    let mut detector = Detector::new(&sensors);
    let mut normal = Normal::new(3);
    for sample in 0..80_000_usize {
        let time = sample as f64 * 1e-4;
        for (k, sensor) in sensors.iter().enumerate() {
            let step = if k > 0 && sample > 20_000 * k {
                0.01
            } else {
                0.0
            };
            let detection = detector.push(k, time, step + sensor.noise * normal.next());
            assert_eq!(detection, None, "{time}");
        }
    }
    // By now the steps are their zeros, and what all of them detect is an impact.
    let mut detections = Vec::new();
    for sample in 80_000..81_000_usize {
        let time = sample as f64 * 1e-4;
        let since = time - 8.0;
        for (k, size) in [20.0, 0.5 * since, 0.02 * since].into_iter().enumerate() {
            let step = if k > 0 { 0.01 } else { 0.0 };
            let value = step + size + sensors[k].noise * normal.next();
            detections.extend(detector.push(k, time, value));
        }
    }
    assert_eq!(detections.len(), 1);
    assert!((detections[0].contact.time - 8.0).abs() < 1e-3);
}

/// The silence of a sensor that is stuck, or has stopped, does not outvote the others.
#[test]
fn a_sensor_that_is_stuck_or_dead_does_not_veto_an_impact() {
    let sensors = industrial();
    for dead in [false, true] {
        let mut detector = Detector::new(&sensors);
        let mut normal = Normal::new(4);
        let mut detections = Vec::new();
        for sample in 0..51_000_usize {
            let time = sample as f64 * 1e-4;
            let since = (time - 5.0).max(0.0);
            for (k, size) in [20.0 * since.signum(), 0.5 * since, 0.02 * since]
                .into_iter()
                .enumerate()
            {
                // Only the laser works from 1 s on.
                let is_broken = k != 1 && time > 1.0;
                if is_broken && dead {
                    continue;
                }
                let works = sensors[k].noise * normal.next() + if time > 5.0 { size } else { 0.0 };
                let value = if is_broken { 0.0 } else { works };
                detections.extend(detector.push(k, time, value));
            }
        }
        assert_eq!(detections.len(), 1, "{dead}");
        assert_eq!(detections[0].sensor, 1);
        assert!((detections[0].contact.time - 5.0).abs() < 1e-3);
    }
}
