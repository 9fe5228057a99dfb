//! How far the fibre beam may be from the column, beside the noise of the sensors, where a hard front strikes it.

use crate::estimation::inference::blocks::ELASTIC_LIMIT;
use crate::estimation::inference::model_error::YIELDED_STRAIN;
use crate::estimation::inference::short_means::SHORT;
use crate::sensors::{Quantity, Sensor};

/// Error of the shape \[A\]: at once, after 30 ms in addition, at contact in addition, the time in which the last one fades \[s\], and for
/// how many means it is the same; relative to the largest reading so far.
const MOTION: [f64; 5] = [0.025, 0.05, 0.1, 1e-3, 4.0];
const STRAIN: [f64; 5] = [0.04, 0.05, 0.3, 1e-3, 4.0];
const ACCELERATION: [f64; 5] = [1.0, 0.0, 1.0, 1e-3, 1.0];

/// See [`MOTION`] \[s\].
const GROWTH: f64 = 30e-3;

/// Standard deviation of the scale of a sensor beside its gain error \[A\]: by its place, and of an accelerometer by the waves, most of
/// which are shorter than its means.
const SCALE: f64 = 0.04;
const SCALE_IN_WAVES: f64 = 0.2;

/// A sensor has at least one reading in each mean.
const LEAST_RATE: f64 = 1.0 / SHORT;

/// A mean over [`SHORT`], over the standard deviation of its error, and the inverse of this.
pub(crate) type Scaled = Option<(f64, f64)>;

/// What one sensor has read.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    pub sensor: Sensor,
    pub means: Vec<Scaled>,
    /// Variance of its scale.
    pub scale: f64,
}

/// What the sensors have read of an impact.
pub(crate) struct Read<'a> {
    pub sensors: &'a [Sensor],
    /// Of each its means over [`SHORT`], with their numbers of readings.
    pub means: &'a [Vec<Option<(f64, u32)>>],
    /// Of each whether it has failed.
    pub failed: &'a [bool],
    pub yield_strain: f64,
    /// Standard deviation of the instant of contact \[s\].
    pub contact_deviation: f64,
}

/// What a sensor has read, with the errors of model and sensor. `lost` is the first mean from which on a gauge no longer reads the elastic
/// column, if there is one.
pub(crate) fn channel(read: &Read, lost: Option<usize>, index: usize) -> Channel {
    let sensor = read.sensors[index].clone();
    let lost = lost.unwrap_or(usize::MAX);
    let [shape, grown, waves, fading, alike] = match sensor.quantity {
        Quantity::Acceleration => ACCELERATION,
        Quantity::BendingStrain => STRAIN,
        _ => MOTION,
    };
    let limit = ELASTIC_LIMIT * read.yield_strain;
    let (mut largest, mut is_lost) = (0.0_f64, false);
    let counts = sensor.rate >= LEAST_RATE && read.failed.get(index) != Some(&true);
    let means = read.means[index].iter().enumerate().map(|(k, mean)| {
        let (mean, count) = (*mean)?;
        largest = largest.max(mean.abs());
        let time = (k as f64 + 0.5) * SHORT;
        let mut share = shape + grown * time / GROWTH + waves * libm::exp(-time / fading);
        if sensor.quantity.is_strain() && k >= lost {
            share = YIELDED_STRAIN;
            is_lost |= mean.abs() > limit;
        }
        let error = share * largest;
        let variance = sensor.noise * sensor.noise / f64::from(count) + alike * error * error;
        let precision = 1.0 / variance.sqrt();
        (counts && !is_lost && precision.is_finite()).then_some((mean * precision, precision))
    });
    let means = means.collect();
    let scale = match sensor.quantity {
        Quantity::Acceleration => SCALE_IN_WAVES,
        _ => SCALE,
    };
    Channel {
        scale: scale * scale + sensor.gain_error * sensor.gain_error,
        means,
        sensor,
    }
}

/// The first mean from which on a gauge no longer reads the elastic column.
pub(crate) fn first_lost(read: &Read) -> Option<usize> {
    let limit = ELASTIC_LIMIT * read.yield_strain;
    let gauges = read.sensors.iter().zip(read.means);
    let gauges = gauges.filter(|(sensor, _)| sensor.quantity.is_strain());
    let lost = gauges.filter_map(|(_, means)| {
        means.windows(2).position(|pair| match pair {
            [Some((a, _)), Some((b, _))] => 0.5 * (a + b).abs() > limit,
            _ => false,
        })
    });
    lost.min()
}
