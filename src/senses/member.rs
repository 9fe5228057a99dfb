//! One response among those that are weighed: its likelihood by the data.

use super::blocks::{Block, BlockMean};
use super::hypothesis::UNKNOWNS;
use super::model_error::ModelError;
use super::prediction::{Place, Prediction, TimeGrid};
use super::sensor::{Quantity, Sensor};
use crate::assessment::Severity;

/// Instants of contact that are considered, about the detected one.
pub(super) const SHIFTS: usize = 13;

/// Distance between them, in standard deviations of the detected instant.
const SHIFT_SPACING: f64 = 0.4;

/// Factor between the column's displacements and the model's, with its standard deviation, before any data.
pub(super) const NO_SCALE: [f64; 2] = [1.0, ModelError::of(Quantity::Displacement).scale];

/// Product of ratios beyond which its logarithm is taken, so that it does not overflow.
const LARGEST_RATIO: f64 = 1e100;

/// What the sensors have read over a block, sensor by sensor.
pub(super) type Observed = (Block, Vec<Option<BlockMean>>);

/// One response.
#[derive(Debug, Clone)]
pub(super) struct Member {
    pub hypothesis: usize,
    pub unknowns: [f64; UNKNOWNS],
    pub prediction: Prediction,
    pub log_prior: f64,
    /// Logarithm of the density with which members of its hypothesis were drawn, by so many distributions of the population.
    pub log_drawn: f64,
    pub known_drawn: usize,
    /// Blocks whose data are in the sums.
    pub seen: usize,
    /// For each sensor and shift: the sums of `e^2 / var`, `e p / var`, `p^2 / var` with the predictions `p` and `e = y - p`.
    pub sums: Vec<[[f64; 3]; SHIFTS]>,
    pub log_posterior: f64,
    /// Severity and capacity ratio, once they were computed.
    pub assessed: Option<(Severity, f64)>,
    /// The most likely instant of contact, among those that are considered.
    pub shift: usize,
    /// Its delay behind the detected one \[s\].
    pub delay: f64,
    /// Expected factor between the column's displacements and the model's, and its standard deviation.
    pub scale: [f64; 2],
}

/// How well a response explains what a sensor reads.
pub(super) struct Fit {
    /// Sum of the squared errors, each relative to its standard deviation, with the factor that fits best.
    pub squares: f64,
    pub log_likelihood: f64,
}

impl Fit {
    pub fn new([squares, cross, predicted]: &[f64; 3], error: ModelError) -> Self {
        let prior = 1.0 / (error.scale * error.scale);
        let information = predicted + prior;
        let squares = squares - cross * cross / information;
        Self {
            squares,
            log_likelihood: -(0.5 * squares + 0.5 * libm::log(information / prior)),
        }
    }
}

/// What the likelihood of every member needs.
pub(super) struct Weighing {
    blocks: Vec<WeighedBlock>,
    errors: Vec<ModelError>,
    /// Instants of contact that are considered, about the detected one \[s\].
    delays: [f64; SHIFTS],
    /// Standard deviation of that \[s\].
    deviation: f64,
}

struct WeighedBlock {
    /// Where the block begins and ends in the predictions, for each instant of contact.
    start: [Place; SHIFTS],
    end: [Place; SHIFTS],
    length: f64,
    /// For each sensor the mean over the block, and its precision.
    terms: Vec<Option<(f64, f64)>>,
}

impl Weighing {
    /// For these data.
    pub fn new(observed: &[Observed], sensors: &[Sensor], grid: &TimeGrid, deviation: f64) -> Self {
        let errors: Vec<_> = sensors
            .iter()
            .map(|sensor| ModelError::of(sensor.quantity))
            .collect();
        let delays: [f64; SHIFTS] = std::array::from_fn(|shift| {
            (shift as f64 - (SHIFTS / 2) as f64) * SHIFT_SPACING * deviation
        });
        let blocks = observed.iter().map(|(block, means)| {
            let terms = means.iter().zip(&errors).map(|(mean, error)| {
                mean.map(|it| {
                    let until = block.start + block.length;
                    let model = error.variance(until, block.length, it.largest, it.yielded);
                    (it.mean, 1.0 / (it.variance + model).max(f64::MIN_POSITIVE))
                })
            });
            WeighedBlock {
                start: delays.map(|delay| grid.place(block.start - delay)),
                end: delays.map(|delay| grid.place(block.start + block.length - delay)),
                length: block.length,
                terms: terms.collect(),
            }
        });
        Self {
            blocks: blocks.collect(),
            errors,
            delays,
            deviation,
        }
    }
}

impl Member {
    /// Back to what it was before any data.
    pub fn forget(&mut self) {
        (self.known_drawn, self.log_drawn) = (0, f64::NEG_INFINITY);
        self.seen = 0;
        self.sums.fill([[0.0; 3]; SHIFTS]);
        self.log_posterior = self.log_prior;
        self.assessed = None;
        (self.shift, self.delay, self.scale) = (SHIFTS / 2, 0.0, NO_SCALE);
    }

    /// Takes at most `count` more blocks.
    pub fn weigh(
        &mut self,
        weighing: &Weighing,
        sensors: &[Sensor],
        ignored: &[bool],
        count: usize,
    ) {
        let until = weighing.blocks.len().min(self.seen.saturating_add(count));
        let blocks = &weighing.blocks[self.seen.min(until)..until];
        for (sensor, sums) in self.sums.iter_mut().enumerate() {
            let integrals = |edge: &[Place; SHIFTS]| {
                let prediction = &self.prediction;
                edge.map(|place| prediction.integral(sensor, place))
            };
            // The integral up to the end of the last block is that up to the beginning of the next one.
            let mut from = None;
            for block in blocks {
                let Some((mean, precision)) = block.terms[sensor] else {
                    from = None;
                    continue;
                };
                let start = from.unwrap_or_else(|| integrals(&block.start));
                let end = integrals(&block.end);
                for ((sums, start), end) in sums.iter_mut().zip(start).zip(end) {
                    let predicted = (end - start) / block.length;
                    let error = mean - predicted;
                    sums[0] += precision * error * error;
                    sums[1] += precision * error * predicted;
                    sums[2] += precision * predicted * predicted;
                }
                from = Some(end);
            }
        }
        self.seen = until;
        self.conclude(weighing, sensors, ignored);
    }

    /// The likelihood over all instants of contact, with the factor of each sensor's readings integrated out.
    fn conclude(&mut self, weighing: &Weighing, sensors: &[Sensor], ignored: &[bool]) {
        let Weighing {
            errors,
            delays,
            deviation,
            ..
        } = weighing;
        let mut logs = [0.0; SHIFTS];
        let mut scales = [NO_SCALE; SHIFTS];
        for (shift, delay) in delays.iter().enumerate() {
            let z = delay / deviation;
            logs[shift] = -0.5 * z * z;
            let each = self.sums.iter().zip(errors).zip(sensors).zip(ignored);
            // One logarithm for all sensors: it would take most of the time.
            let mut ratio = 1.0;
            for (((sums, error), sensor), _) in each.filter(|(_, ignored)| !**ignored) {
                let [squares, cross, predicted] = sums[shift];
                let prior = 1.0 / (error.scale * error.scale);
                let information = predicted + prior;
                logs[shift] -= 0.5 * (squares - cross * cross / information);
                ratio *= information / prior;
                if ratio > LARGEST_RATIO {
                    logs[shift] -= 0.5 * libm::log(ratio);
                    ratio = 1.0;
                }
                if sensor.quantity == Quantity::Displacement {
                    scales[shift] = [1.0 + cross / information, (1.0 / information).sqrt()];
                }
            }
            logs[shift] -= 0.5 * libm::log(ratio);
        }
        let best = (0..SHIFTS).fold(0, |best, k| if logs[k] > logs[best] { k } else { best });
        self.shift = best;
        self.delay = delays[best];
        self.scale = scales[best];
        self.log_posterior = self.log_prior + log_sum(logs.into_iter());
    }
}

/// Logarithm of the sum of exponentials.
pub(super) fn log_sum(logs: impl Iterator<Item = f64>) -> f64 {
    logs.fold(f64::NEG_INFINITY, |sum, log| {
        let (large, small) = if sum > log { (sum, log) } else { (log, sum) };
        if small == f64::NEG_INFINITY {
            large
        } else {
            large + libm::log1p(libm::exp(small - large))
        }
    })
}
