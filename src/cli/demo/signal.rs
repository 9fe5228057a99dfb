//! The signal that the demonstration with sensors plays: `tests/data/signals/README.md` says where it comes from.

use std::io::Read;

use flate2::read::GzDecoder;
use serde_json::Value as Json;

use crate::cli::failure::{Exit, Failure};
use column_twin::estimation::{Readings, with_sensor_errors};
use column_twin::sensors::Sensor;

/// Its name in the table of truths.
const NAME: &str = "s02_rigid_10";

/// The signal: 0.4 s at 10 kHz, without noise.
const SIGNAL: &[u8] = include_bytes!("../../../tests/data/signals/s02_rigid_10.csv.gz");

/// What was computed with it.
const TRUTHS: &str = include_str!("../../../tests/data/signals/truth.json");

/// Sensors of `config/sensors_industrial.yaml`, and the column of the signal that each of them detects.
const COLUMNS: [(&str, &str); 3] = [
    ("accelerometer", "a_impact_m_s2"),
    ("laser", "v1_m"),
    ("base_strain", "bend_base"),
];

/// Samples per second.
const RATE: f64 = 1e4;

/// Samples before the contact over which the column is at rest.
const REST: usize = 400;

/// Samples at the end whose mean is what remains.
const TAIL: usize = 1_000;

/// Rest before the signal, in samples: 4 s, in which the node learns noise and zero of its sensors and prepares responses.
const BEFORE: usize = 40_000;

/// What remains after the signal, in samples: 3 s, in which the final estimate comes.
const AFTER: usize = 30_000;

/// The errors of the sensors follow from it.
const SEED: u64 = 4;

/// Column and sensors of the signal, after `config/heb220_s355.yaml` and `config/sensors_industrial.yaml`.
pub(super) const PARAMETERS: &str = "\
# The column of the signal: struck 0.8 m above its base, held by a spring at its top, and made of a steel that neither hardens
# nor buckles and whose web does not shear, as in the fibre-beam model that has computed the signal. The sensors are where the
# signal was taken.
/**:
  ros__parameters:
    geometry:
      length_below: 0.8
      length_above: 3.2
    top:
      spring_stiffness: 10.0e+6
    hardening:
      ratio: 0.0
    softening:
      model: none
    shear:
      model: none
    sensors:
      accelerometer:
        height: 0.8
      laser:
        height: 0.8
      base_strain:
        height: 0.022
    estimation:
      accept: automatic # an impact that was detected becomes one of the twin once its estimate is sure enough
";

/// What struck in the signal, and what it did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Truth {
    /// \[kg\]
    pub mass: f64,
    /// \[m/s\]
    pub velocity: f64,
    /// \[m\]
    pub peak_v1: f64,
    /// \[m\]
    pub residual_v1: f64,
}

/// The truth of the signal.
pub(super) fn truth() -> Result<Truth, Failure> {
    let truths: Json = serde_json::from_str(TRUTHS).map_err(unusable)?;
    let number = |name: &str| {
        let found = truths[NAME][name].as_f64();
        found.ok_or_else(|| unusable(format!("{name} of {NAME} is missing")))
    };
    Ok(Truth {
        mass: number("mass")?,
        velocity: number("speed")?,
        peak_v1: number("peak_v1")?,
        residual_v1: number("residual_v1")?,
    })
}

/// What the sensors read: the column at rest, the signal, and what remains of it, with their errors.
pub(super) fn readings(sensors: &[Sensor]) -> Result<Readings, Failure> {
    let rows = rows(sensors)?;
    if rows.len() < REST + TAIL {
        return Err(unusable(format!("it has {} rows only", rows.len())));
    }
    let before = mean(&rows[..REST], sensors.len());
    let after = mean(&rows[rows.len() - TAIL..], sensors.len());
    let all = [vec![before; BEFORE], rows, vec![after; AFTER]].concat();
    let exact = Readings {
        times: (0..all.len()).map(|index| index as f64 / RATE).collect(),
        values: all.concat(),
        sensors: sensors.len(),
    };
    Ok(with_sensor_errors(&exact, sensors, SEED))
}

/// The rows of the signal, with one value for each sensor.
fn rows(sensors: &[Sensor]) -> Result<Vec<Vec<f64>>, Failure> {
    let mut text = String::new();
    let mut packed = GzDecoder::new(SIGNAL);
    packed.read_to_string(&mut text).map_err(unusable)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(unusable)?.clone();
    let column_of = |sensor: &Sensor| {
        let known = COLUMNS.iter().find(|(name, _)| *name == sensor.name);
        let place = known.and_then(|(_, column)| header.iter().position(|it| it == *column));
        place.ok_or_else(|| unusable(format!("it has nothing for the sensor {}", sensor.name)))
    };
    let columns: Vec<usize> = sensors.iter().map(column_of).collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    for row in reader.records() {
        let row = row.map_err(unusable)?;
        let value = |&column: &usize| {
            let cell = row.get(column).unwrap_or_default();
            cell.parse::<f64>()
                .map_err(|error| unusable(format!("{cell:?}: {error}")))
        };
        rows.push(columns.iter().map(value).collect::<Result<Vec<_>, _>>()?);
    }
    Ok(rows)
}

fn mean(rows: &[Vec<f64>], sensors: usize) -> Vec<f64> {
    let sum = |sensor: usize| rows.iter().map(|row| row[sensor]).sum::<f64>();
    (0..sensors)
        .map(|sensor| sum(sensor) / rows.len() as f64)
        .collect()
}

/// The program contains a signal that it cannot use.
fn unusable(reason: impl std::fmt::Display) -> Failure {
    Failure::plain(
        Exit::Failed,
        format!("the signal {NAME} in this program cannot be used: {reason}; please report this"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use column_twin::parameters::Parameters;

    /// The peak displacement in the table is that of the truth, within gain error and noise.
    #[test]
    fn the_signal_has_the_peak_and_the_rest_of_its_truth() {
        let files = ["config/heb220_s355.yaml", "config/sensors_industrial.yaml"];
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut files = files.map(|it| root.join(it)).to_vec();
        let folder = tempfile::tempdir().expect("a folder");
        files.push(folder.path().join("signal.yaml"));
        std::fs::write(&files[2], PARAMETERS).expect("written");
        let sensors = Parameters::load(&files, &[]).expect("parameters").sensors();
        let (Ok(readings), Ok(truth)) = (readings(&sensors), truth()) else {
            panic!("not usable");
        };
        let laser = sensors.iter().position(|it| it.name == "laser");
        let laser = laser.expect("a laser");
        let v1: Vec<f64> = readings.rows().map(|(_, row)| row[laser]).collect();
        let largest = v1.iter().copied().fold(0.0, f64::max);
        let last = v1[v1.len() - AFTER..].iter().sum::<f64>() / AFTER as f64;
        let is_near = |found: f64, truth: f64| (found / truth - 1.0).abs() < 0.04;
        assert!(is_near(largest, truth.peak_v1), "{largest}");
        assert!(is_near(last, truth.residual_v1), "{last}");
        // The column is at rest before.
        let noise = sensors[laser].noise;
        assert!(v1[..BEFORE].iter().all(|it| it.abs() < 6.0 * noise));
    }
}
