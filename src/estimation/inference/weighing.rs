//! What the likelihood of every response needs of the data: block means with their precisions, and where the blocks are in the
//! predictions.

use crate::estimation::inference::block_layout::Block;
use crate::estimation::inference::blocks::BlockMean;
use crate::estimation::inference::lanes::{Lanes, WIDTH, ZERO, lanes};
use crate::estimation::inference::model_error::{FrontError, ModelError};
use crate::estimation::inference::prediction::{Place, TimeGrid};
use crate::sensors::{Quantity, Sensor};

/// Instants of contact that are considered, about the detected one.
pub(crate) const SHIFTS: usize = 13;

/// Distance between them, in standard deviations of the detected instant.
const SHIFT_SPACING: f64 = 0.4;

/// What the sensors have read over a block, sensor by sensor.
pub(crate) type Observed = (Block, Vec<Option<BlockMean>>);

/// What the likelihood of every member needs.
#[derive(Debug, Clone)]
pub(crate) struct Weighing {
    pub blocks: Vec<WeighedBlock>,
    pub sensors: Vec<WeighedSensor>,
    /// The instants at which predictions are needed for it.
    pub grid: TimeGrid,
    /// Instants of contact that are considered, about the detected one \[s\].
    pub delays: [f64; SHIFTS],
    /// Logarithms of their probabilities.
    pub log_delays: [f64; SHIFTS],
}

#[derive(Debug, Clone)]
pub(crate) struct WeighedBlock {
    /// Where the block begins and ends in the predictions, for each instant of contact.
    pub start: [Place; SHIFTS],
    pub end: [Place; SHIFTS],
    pub length: f64,
    /// For each group of sensors what the likelihood needs of the block.
    pub terms: Vec<Terms>,
}

/// What the likelihood needs of a block and a group of sensors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms {
    /// Means over the block.
    pub means: Lanes,
    /// Precisions of their errors, once the error in the block before is known; 0 where there is no mean.
    pub precisions: Lanes,
    /// The error that is expected, relative to that in the block before.
    pub carried: Lanes,
    /// Variances by errors of size 1 by a light and by a soft front, times the precision.
    light: Lanes,
    soft: Lanes,
}

impl Terms {
    /// What the square of the error by the front is multiplied with.
    pub fn by_front(&self, front: FrontError) -> &Lanes {
        match front {
            FrontError::Light(_) => &self.light,
            FrontError::Soft(_) => &self.soft,
        }
    }
}

const NO_TERMS: Terms = Terms {
    means: ZERO,
    precisions: ZERO,
    carried: ZERO,
    light: ZERO,
    soft: ZERO,
};

#[derive(Debug, Clone, Copy)]
pub(crate) struct WeighedSensor {
    /// Precision of the factor between the column's readings and the model's.
    pub prior: f64,
    pub is_displacement: bool,
    /// It contradicts the others, and does not count.
    pub is_ignored: bool,
}

impl Weighing {
    /// For these data and the standard deviation of the instant of contact \[s\]; `by_front` gives the variance of a mean of a sensor by
    /// the error of a front.
    pub fn new(
        observed: &[Observed],
        sensors: &[Sensor],
        ignored: &[bool],
        grid: &TimeGrid,
        deviation: f64,
        by_front: impl Fn(FrontError, usize, &(Block, BlockMean)) -> f64,
    ) -> Self {
        let delays: [f64; SHIFTS] = std::array::from_fn(|shift| {
            (shift as f64 - (SHIFTS / 2) as f64) * SHIFT_SPACING * deviation
        });
        let errors: Vec<_> = sensors
            .iter()
            .map(|sensor| ModelError::of(sensor.quantity))
            .collect();
        let mut before: Option<&Observed> = None;
        let blocks = observed.iter().map(|of_block| {
            let (block, means) = of_block;
            let mut terms = vec![NO_TERMS; lanes(sensors.len()).len()];
            let until = block.start + block.length;
            let before = before.replace(of_block);
            for (sensor, (mean, error)) in means.iter().zip(&errors).enumerate() {
                if let Some(it) = mean {
                    let last = before.and_then(|(block, means)| Some((*block, means[sensor]?)));
                    let (carried, variance) = error.given(last.as_ref(), &(*block, *it));
                    let (terms, lane) = (&mut terms[sensor / WIDTH], sensor % WIDTH);
                    terms.means[lane] = it.mean;
                    terms.precisions[lane] = 1.0 / variance.max(f64::MIN_POSITIVE);
                    terms.carried[lane] = carried;
                    let relative = |front| {
                        by_front(front, sensor, &(*block, *it)) / variance.max(f64::MIN_POSITIVE)
                    };
                    terms.light[lane] = relative(FrontError::Light(1.0));
                    terms.soft[lane] = relative(FrontError::Soft(1.0));
                }
            }
            WeighedBlock {
                start: delays.map(|delay| grid.place(block.start - delay)),
                end: delays.map(|delay| grid.place(until - delay)),
                length: block.length,
                terms,
            }
        });
        let blocks: Vec<_> = blocks.collect();
        let last = observed.last();
        let seen = last.map_or(0.0, |(block, _)| block.start + block.length);
        let each = sensors.iter().zip(&errors).zip(ignored);
        let weighed = each.map(|((sensor, error), ignored)| WeighedSensor {
            prior: 1.0 / (error.scale * error.scale),
            is_displacement: sensor.quantity == Quantity::Displacement,
            is_ignored: *ignored,
        });
        Self {
            blocks,
            sensors: weighed.collect(),
            // The earliest contact sees most of a response.
            grid: grid.until(seen - delays[0]),
            delays,
            log_delays: delays.map(|delay| {
                let z = delay / deviation;
                -0.5 * z * z
            }),
        }
    }
}
