//! The signals in `tests/data/signals/`, with the errors of sensors.

use std::fs::File;
use std::path::Path;

use column_twin::estimation::{Batch, Readings};
use column_twin::parameters::{Parameters, parse_override};
use column_twin::sensors::{Quantity, Sensor};
use flate2::read::GzDecoder;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde_json::Value as Json;

/// Standard gravity \[m/s^2\].
const GRAVITY: f64 = 9.806_65;

/// Time between two samples \[s\].
pub const PERIOD: f64 = 1e-4;

/// A signal with its truth.
pub struct Signal {
    pub name: &'static str,
    pub truth: Json,
    /// Rows of eight values.
    rows: Vec<[f64; 8]>,
}

pub const NAMES: [&str; 5] = [
    "s01_rigid_3",
    "s02_rigid_10",
    "s04_car_soft_14",
    "s06_truck8_8",
    "s13_van_soft_5",
];

/// A standard normal number.
pub struct Normal(ChaCha8Rng);

impl Normal {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f64 {
        let mut uniform = || (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let radius = (-2.0 * (1.0 - uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * uniform()).cos()
    }
}

impl Signal {
    pub fn read(name: &'static str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/signals");
        let file = File::open(folder.join(format!("{name}.csv.gz"))).expect("a signal");
        let mut reader = csv::Reader::from_reader(GzDecoder::new(file));
        let rows = reader.records().map(|row| {
            let row = row.expect("a row");
            std::array::from_fn(|k| row[k + 1].parse().expect("a number"))
        });
        let rows = rows.collect();
        let truth = std::fs::read_to_string(folder.join("truth.json")).expect("the truth");
        let truth: Json = serde_json::from_str(&truth).expect("JSON");
        Self {
            name,
            truth: truth[name].clone(),
            rows,
        }
    }

    pub fn number(&self, name: &str) -> f64 {
        self.truth[name].as_f64().expect(name)
    }

    /// The column with the spring of the fibre beam, and without shear, hardening and softening, which it does not have.
    pub fn parameters(&self) -> Parameters {
        let length = |name: &str| self.truth["column"][name].as_f64().expect(name);
        let overrides = [
            format!("geometry.length_below:={:?}", length("La")),
            format!("geometry.length_above:={:?}", length("Lb")),
            format!(
                "top.spring_stiffness:={:?}",
                self.truth["column"]["ks"].as_f64().expect("ks")
            ),
            "shear.model:=none".to_owned(),
            "hardening.ratio:=0.0".to_owned(),
            "softening.model:=none".to_owned(),
        ];
        let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
        Parameters::load(&[file], &overrides).expect("parameters")
    }

    /// The sensors with the preset `industrial`, in the order of the columns.
    pub fn industrial(&self) -> Vec<Sensor> {
        let length = |name: &str| self.truth["column"][name].as_f64().expect(name);
        industrial(length("La"), length("La") + length("Lb"))
    }

    /// What the chosen sensors read, with their errors by this seed.
    pub fn readings(&self, chosen: &[usize], seed: u64) -> (Vec<Sensor>, Readings) {
        let all = self.industrial();
        let sensors: Vec<Sensor> = chosen.iter().map(|&k| all[k].clone()).collect();
        let mut normal = Normal::new(seed);
        let errors: Vec<[f64; 2]> = sensors
            .iter()
            .map(|it| [1.0 + it.gain_error * normal.next(), it.bias * normal.next()])
            .collect();
        let mut readings = Readings {
            sensors: sensors.len(),
            ..Readings::default()
        };
        for (index, row) in self.rows.iter().enumerate() {
            readings.times.push(index as f64 * PERIOD);
            for ((&column, sensor), [gain, bias]) in chosen.iter().zip(&sensors).zip(&errors) {
                let value = gain * row[column] + bias + sensor.noise * normal.next();
                let range = if sensor.range > 0.0 {
                    sensor.range
                } else {
                    f64::INFINITY
                };
                readings.values.push(value.clamp(-range, range));
            }
        }
        (sensors, readings)
    }
}

/// The sensors of the signals with the preset `industrial`, on a column of any length \[m\] with the impact point at a height
/// \[m\].
pub fn industrial(height: f64, length: f64) -> Vec<Sensor> {
    let sensor = |name: &str, quantity, height, range, noise| Sensor {
        name: name.to_owned(),
        quantity,
        height,
        range,
        noise,
        bias: 0.0,
        gain_error: 0.01,
        rate: 1.0 / PERIOD,
        bandwidth: 0.5 / PERIOD,
        reversed: false,
        fibre: 0.11,
    };
    let accelerometer = |name, height| Sensor {
        bias: 0.05 * GRAVITY,
        ..sensor(
            name,
            Quantity::Acceleration,
            height,
            50.0 * GRAVITY,
            0.0022 * GRAVITY,
        )
    };
    vec![
        accelerometer("a_025L", 0.25 * length),
        accelerometer("a_impact", height),
        accelerometer("a_075L", 0.75 * length),
        sensor("v1", Quantity::Displacement, height, 0.0, 1e-4),
        sensor("bend_base", Quantity::BendingStrain, 0.022, 0.0, 1e-6),
        sensor("bend_mid", Quantity::BendingStrain, 0.5 * length, 0.0, 1e-6),
        sensor("axial_base", Quantity::AxialStrain, 0.1, 0.0, 1e-6),
        sensor("axial_mid", Quantity::AxialStrain, 0.5 * length, 0.0, 1e-6),
    ]
}

/// The clock of the twin at the first sample \[ns\].
pub const START: i64 = 1_700_000_000_000_000_000;

/// Parameters with these sensors.
pub fn with_sensors(parameters: &Parameters, sensors: &[Sensor]) -> Parameters {
    let names = sensors.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
    let mut changes = vec![("sensors.names".to_owned(), names.into())];
    for sensor in sensors {
        let name = |field: &str| format!("sensors.{}.{field}", sensor.name);
        changes.push((name("quantity"), sensor.quantity.word().into()));
        for (field, value) in [
            ("height", sensor.height),
            ("range", sensor.range),
            ("noise", sensor.noise),
            ("bias", sensor.bias),
            ("gain_error", sensor.gain_error),
            ("rate", sensor.rate),
            ("fibre", sensor.fibre),
        ] {
            if field != "fibre" || sensor.quantity == Quantity::BendingStrain {
                changes.push((name(field), value.into()));
            }
        }
    }
    parameters.with_changes(changes).expect("parameters")
}

/// The readings of each sensor in batches, in the order of time and then of sensors, numbered.
pub fn batches(readings: &Readings, samples: usize) -> Vec<(u64, Batch)> {
    let rows: Vec<(f64, &[f64])> = readings.rows().collect();
    let mut batches = Vec::new();
    for rows in rows.chunks(samples) {
        for sensor in 0..readings.sensors {
            batches.push(batch(sensor, rows));
        }
    }
    (0..).zip(batches).collect()
}

pub fn batch(sensor: usize, rows: &[(f64, &[f64])]) -> Batch {
    Batch {
        sensor: sensor as u16,
        first: START + (1e9 * rows[0].0).round() as i64,
        period: 100_000,
        values: rows
            .iter()
            .map(|(_, values)| values[sensor] as f32)
            .collect(),
    }
}
