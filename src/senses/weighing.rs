//! What the likelihood of every response needs of the data: block means with their precisions, and where the blocks are in the
//! predictions.

use super::blocks::{Block, BlockMean};
use super::lanes::{Lanes, WIDTH, ZERO, lanes};
use super::model_error::ModelError;
use super::prediction::{Place, TimeGrid};
use super::sensor::{Quantity, Sensor};

/// Instants of contact that are considered, about the detected one.
pub(super) const SHIFTS: usize = 13;

/// Distance between them, in standard deviations of the detected instant.
const SHIFT_SPACING: f64 = 0.4;

/// Every so many of these instants are looked at for a first impression.
pub(super) const SCREENED_SHIFTS: usize = 3;

/// What the sensors have read over a block, sensor by sensor.
pub(super) type Observed = (Block, Vec<Option<BlockMean>>);

/// What the likelihood of every member needs.
#[derive(Debug, Clone)]
pub(super) struct Weighing {
    pub blocks: Vec<WeighedBlock>,
    pub sensors: Vec<WeighedSensor>,
    /// Instants of contact that are considered, about the detected one \[s\].
    pub delays: [f64; SHIFTS],
    /// Logarithms of their probabilities.
    pub log_delays: [f64; SHIFTS],
}

#[derive(Debug, Clone)]
pub(super) struct WeighedBlock {
    /// Where the block begins and ends in the predictions, for each instant of contact.
    pub start: [Place; SHIFTS],
    pub end: [Place; SHIFTS],
    pub length: f64,
    /// For each group of sensors the means over the block, and their precisions; 0 where there is no mean.
    pub terms: Vec<[Lanes; 2]>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct WeighedSensor {
    /// Precision of the factor between the column's readings and the model's.
    pub prior: f64,
    pub is_displacement: bool,
    /// It contradicts the others, and does not count.
    pub is_ignored: bool,
}

impl Weighing {
    /// For these data.
    pub fn new(
        observed: &[Observed],
        sensors: &[Sensor],
        ignored: &[bool],
        grid: &TimeGrid,
        deviation: f64,
    ) -> Self {
        let delays: [f64; SHIFTS] = std::array::from_fn(|shift| {
            (shift as f64 - (SHIFTS / 2) as f64) * SHIFT_SPACING * deviation
        });
        let errors: Vec<_> = sensors
            .iter()
            .map(|sensor| ModelError::of(sensor.quantity))
            .collect();
        let blocks = observed.iter().map(|(block, means)| {
            let mut terms = vec![[ZERO; 2]; lanes(sensors.len()).len()];
            let until = block.start + block.length;
            for (sensor, (mean, error)) in means.iter().zip(&errors).enumerate() {
                if let Some(it) = mean {
                    let model = error.variance(until, block.length, it.largest, it.yielded);
                    let [means, precisions] = &mut terms[sensor / WIDTH];
                    means[sensor % WIDTH] = it.mean;
                    precisions[sensor % WIDTH] = 1.0 / (it.variance + model).max(f64::MIN_POSITIVE);
                }
            }
            WeighedBlock {
                start: delays.map(|delay| grid.place(block.start - delay)),
                end: delays.map(|delay| grid.place(until - delay)),
                length: block.length,
                terms,
            }
        });
        let each = sensors.iter().zip(&errors).zip(ignored);
        let weighed = each.map(|((sensor, error), ignored)| WeighedSensor {
            prior: 1.0 / (error.scale * error.scale),
            is_displacement: sensor.quantity == Quantity::Displacement,
            is_ignored: *ignored,
        });
        Self {
            blocks: blocks.collect(),
            sensors: weighed.collect(),
            delays,
            log_delays: delays.map(|delay| {
                let z = delay / deviation;
                -0.5 * z * z
            }),
        }
    }
}
