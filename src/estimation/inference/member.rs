//! One response among those that are weighed: its likelihood by the data.

use std::sync::Arc;

use crate::assessment::Action;
use crate::estimation::inference::hypothesis::UNKNOWNS;
use crate::estimation::inference::lanes::{Lanes, WIDTH, ZERO, lanes};
use crate::estimation::inference::model_error::{FrontError, ModelError};
use crate::estimation::inference::prediction::{Place, Prediction};
use crate::estimation::inference::weighing::{SHIFTS, WeighedBlock, Weighing};
use crate::sensors::{Quantity, Sensor};

/// Factor between the column's displacements and the model's, with its standard deviation, before any data.
pub(crate) const NO_SCALE: [f64; 2] = [1.0, ModelError::of(Quantity::Displacement).scale];

/// Product of ratios beyond which its logarithm is taken, so that it does not overflow.
const LARGEST_RATIO: f64 = 1e100;

/// Logarithm of a share that adds nothing.
const NOTHING: f64 = -40.0;

/// One response.
#[derive(Debug, Clone)]
pub(crate) struct Member {
    pub hypothesis: usize,
    pub unknowns: [f64; UNKNOWNS],
    /// Never changed, so that the estimators of equal columns share it.
    pub prediction: Arc<Prediction>,
    /// Logarithm of its density before anything is measured, and of the likelihood of what events say.
    pub log_prior: f64,
    pub log_events: f64,
    /// Logarithm of the likelihood of the data; more than that as long as not all of them are taken.
    pub log_likelihood: f64,
    /// Logarithm of the density with which members of its hypothesis were drawn, by so many distributions of the population.
    pub log_drawn: f64,
    pub known_drawn: usize,
    /// Blocks whose data are in the sums.
    pub seen: usize,
    /// Error of motions by what strikes the column.
    pub front: FrontError,
    /// For each instant of contact and group of sensors.
    sums: Vec<Sums>,
    /// For each group of sensors the logarithm of how much less likely the error of this front makes any reading.
    costs: Vec<Lanes>,
    /// Action and capacity ratio, once they were computed; `None` in it if they cannot be.
    pub assessed: Option<Option<(Action, f64)>>,
    /// The most likely instant of contact, among those that are considered.
    pub shift: usize,
    /// Its delay behind the detected one \[s\].
    pub delay: f64,
    /// Expected factor between the column's displacements and the model's, and its standard deviation.
    pub scale: [f64; 2],
}

/// With the predictions `p` and `e = y - p`: the sums of `e^2 / var`, `e p / var`, `p^2 / var`.
#[derive(Debug, Clone, Copy)]
struct Sums {
    squares: Lanes,
    cross: Lanes,
    predicted: Lanes,
}

const NO_SUMS: Sums = Sums {
    squares: ZERO,
    cross: ZERO,
    predicted: ZERO,
};

/// How well a response explains what a sensor reads.
pub(crate) struct Fit {
    /// Sum of the squared errors, each relative to its standard deviation, with the factor that fits best.
    pub squares: f64,
    pub log_likelihood: f64,
    /// Whether the factor that fits best is below 0 beyond doubt: the sensor reads the opposite.
    pub is_reversed: bool,
}

/// Standard deviations by which a factor has to be below 0 for a sensor that reads the opposite of a response \[A\].
const REVERSED: f64 = 5.0;

impl Fit {
    fn new([squares, cross, predicted]: [f64; 3], error: ModelError) -> Self {
        let prior = 1.0 / (error.scale * error.scale);
        let information = predicted + prior;
        let squares = squares - cross * cross / information;
        // By the data alone the factor is 1 + cross / predicted, with the variance 1 / predicted.
        let is_reversed = predicted + cross < -REVERSED * predicted.sqrt();
        Self {
            squares,
            is_reversed,
            log_likelihood: -(0.5 * squares + 0.5 * libm::log(information / prior)),
        }
    }
}

/// Goes through the blocks from `first` on, for one instant of contact and group of sensors: the precision of each error that does not
/// follow from the block before, the error, and what is predicted likewise.
#[inline]
fn follow_blocks(
    blocks: &[WeighedBlock],
    first: usize,
    (shift, group): (usize, usize),
    prediction: &Prediction,
    front: FrontError,
    mut each: impl FnMut(usize, f64, f64, f64),
) {
    // The errors of the block before are what those of the first one follow.
    let from = first.saturating_sub(1);
    let Some(begin) = blocks.get(from) else {
        return;
    };
    let integrals = |place: &[Place; SHIFTS]| prediction.integrals(group, place[shift]);
    // The integral up to the end of a block is that up to the beginning of the next one.
    let mut start = integrals(&begin.start);
    let (mut last_error, mut last_predicted) = (ZERO, ZERO);
    let more = front.squared();
    for (index, block) in blocks.iter().enumerate().skip(from) {
        let end = integrals(&block.end);
        let terms = &block.terms[group];
        let by_front = terms.by_front(front);
        let counts = if index < first { 0.0 } else { 1.0 };
        for k in 0..WIDTH {
            let predicted = (end[k] - start[k]) / block.length;
            let error = terms.means[k] - predicted;
            let new_error = error - terms.carried[k] * last_error[k];
            let new_predicted = predicted - terms.carried[k] * last_predicted[k];
            let precision = counts * terms.precisions[k] / (1.0 + more * by_front[k]);
            each(k, precision, new_error, new_predicted);
            (last_error[k], last_predicted[k]) = (error, predicted);
        }
        start = end;
    }
}

impl Sums {
    /// Takes the blocks from `first` on, for one instant of contact and group of sensors.
    fn take(
        &mut self,
        blocks: &[WeighedBlock],
        first: usize,
        shift: usize,
        group: usize,
        prediction: &Prediction,
        front: FrontError,
    ) {
        follow_blocks(
            blocks,
            first,
            (shift, group),
            prediction,
            front,
            |k, precision, error, predicted| {
                let weighed = precision * error;
                self.squares[k] += weighed * error;
                self.cross[k] += weighed * predicted;
                self.predicted[k] += precision * predicted * predicted;
            },
        );
    }

    fn of(&self, lane: usize) -> [f64; 3] {
        [self.squares[lane], self.cross[lane], self.predicted[lane]]
    }
}

impl Member {
    /// Before any data. `front` is the error of motions by what strikes the column.
    pub fn new(
        hypothesis: usize,
        unknowns: [f64; UNKNOWNS],
        prediction: Prediction,
        log_prior: f64,
        front: FrontError,
        groups: usize,
    ) -> Self {
        Self {
            hypothesis,
            unknowns,
            prediction: Arc::new(prediction),
            log_prior,
            log_events: 0.0,
            log_likelihood: 0.0,
            log_drawn: f64::NEG_INFINITY,
            known_drawn: 0,
            seen: 0,
            front,
            sums: vec![NO_SUMS; SHIFTS * groups],
            costs: vec![ZERO; groups],
            assessed: None,
            shift: SHIFTS / 2,
            delay: 0.0,
            scale: NO_SCALE,
        }
    }

    /// Bytes that a member takes without its prediction.
    pub fn bytes(sensors: &[Sensor]) -> usize {
        let of_group = SHIFTS * size_of::<Sums>() + size_of::<Lanes>();
        size_of::<Self>() + lanes(sensors.len()).len() * of_group
    }

    /// Back to what it was before any data. What was assessed does not depend on them.
    pub fn forget(&mut self) {
        (self.known_drawn, self.log_drawn) = (0, f64::NEG_INFINITY);
        self.seen = 0;
        self.sums.fill(NO_SUMS);
        self.costs.fill(ZERO);
        (self.log_events, self.log_likelihood) = (0.0, 0.0);
        (self.shift, self.delay, self.scale) = (SHIFTS / 2, 0.0, NO_SCALE);
    }

    /// Logarithm of prior times likelihood.
    pub fn log_posterior(&self) -> f64 {
        self.log_prior + self.log_events + self.log_likelihood
    }

    /// Logarithm of its weight.
    pub fn log_weight(&self) -> f64 {
        self.log_posterior() - self.log_drawn
    }

    /// The sums of a sensor for the most likely instant of contact.
    pub fn sums(&self, sensor: usize) -> [f64; 3] {
        let groups = self.sums.len() / SHIFTS;
        self.sums[self.shift * groups + sensor / WIDTH].of(sensor % WIDTH)
    }

    /// The whitened errors of all sensors at this instant of contact, with the factor of each sensor that fits best.
    pub fn residuals(&self, weighing: &Weighing, shift: usize) -> Vec<f64> {
        let blocks = &weighing.blocks;
        let groups = self.sums.len() / SHIFTS;
        let mut residuals = Vec::with_capacity(blocks.len() * groups * WIDTH);
        for (group, sensors) in (0..groups).zip(weighing.sensors.chunks(WIDTH)) {
            let sums = &self.sums[shift * groups + group];
            let scales: Lanes = std::array::from_fn(|k| match sensors.get(k) {
                Some(it) if !it.is_ignored => {
                    let scale = sums.cross[k] / (sums.predicted[k] + it.prior);
                    residuals.push(scale * it.prior.sqrt());
                    scale
                }
                _ => 0.0,
            });
            follow_blocks(
                blocks,
                0,
                (shift, group),
                &self.prediction,
                self.front,
                |k, precision, error, predicted| {
                    if sensors.get(k).is_some_and(|it| !it.is_ignored) {
                        residuals.push(precision.sqrt() * (error - scales[k] * predicted));
                    }
                },
            );
        }
        residuals
    }

    /// How well it explains what a sensor reads, at the most likely instant of contact.
    pub fn fit(&self, sensor: usize, error: ModelError) -> Fit {
        let fit = Fit::new(self.sums(sensor), error);
        Fit {
            log_likelihood: fit.log_likelihood - self.costs[sensor / WIDTH][sensor % WIDTH],
            ..fit
        }
    }

    /// Takes all blocks that are not in the sums yet.
    pub fn weigh(&mut self, weighing: &Weighing) {
        let blocks = &weighing.blocks;
        let groups = self.sums.len() / SHIFTS;
        for (shift, sums) in self.sums.chunks_exact_mut(groups).enumerate() {
            for (group, sums) in sums.iter_mut().enumerate() {
                sums.take(
                    blocks,
                    self.seen,
                    shift,
                    group,
                    &self.prediction,
                    self.front,
                );
            }
        }
        for (group, costs) in self.costs.iter_mut().enumerate() {
            for block in &blocks[self.seen..] {
                let by_front = block.terms[group].by_front(self.front);
                for (cost, by_front) in costs.iter_mut().zip(by_front) {
                    *cost += 0.5 * libm::log1p(self.front.squared() * by_front);
                }
            }
        }
        self.seen = blocks.len();
        self.conclude(weighing);
    }

    /// A first impression by the last `count` blocks only, before any were taken: the likelihood is not larger with all of them, because
    /// more data never make it larger. All instants of contact are looked at: some of them would give a smaller number than the likelihood
    /// has, and the more often, the smaller.
    pub fn prefilter(&mut self, weighing: &Weighing, count: usize) {
        let blocks = &weighing.blocks;
        let first = blocks.len().saturating_sub(count);
        let groups = self.sums.len() / SHIFTS;
        let mut logs = weighing.log_delays;
        for (shift, log) in logs.iter_mut().enumerate() {
            for (group, sensors) in (0..groups).zip(weighing.sensors.chunks(WIDTH)) {
                let mut sums = NO_SUMS;
                sums.take(blocks, first, shift, group, &self.prediction, self.front);
                for (lane, sensor) in sensors.iter().enumerate() {
                    if !sensor.is_ignored {
                        let [squares, cross, predicted] = sums.of(lane);
                        *log -= 0.5 * (squares - cross * cross / (predicted + sensor.prior));
                    }
                }
            }
        }
        self.log_likelihood = self.log_likelihood.min(log_sum(logs.into_iter()));
    }

    /// The likelihood over all instants of contact, with the factor of each sensor's readings integrated out.
    fn conclude(&mut self, weighing: &Weighing) {
        let groups = self.sums.len() / SHIFTS;
        let mut logs = weighing.log_delays;
        let mut ratios = [1.0; SHIFTS];
        let mut scales = [NO_SCALE; SHIFTS];
        for (shift, sums) in self.sums.chunks_exact(groups).enumerate() {
            let each = sums.iter().zip(&self.costs);
            for ((sums, costs), sensors) in each.zip(weighing.sensors.chunks(WIDTH)) {
                for (lane, sensor) in sensors.iter().enumerate() {
                    if sensor.is_ignored {
                        continue;
                    }
                    let [squares, cross, predicted] = sums.of(lane);
                    let information = predicted + sensor.prior;
                    logs[shift] -= 0.5 * (squares - cross * cross / information) + costs[lane];
                    // One logarithm for all sensors and instants: they would take most of the time.
                    let ratio = &mut ratios[shift];
                    *ratio *= information / sensor.prior;
                    if *ratio > LARGEST_RATIO {
                        logs[shift] -= 0.5 * libm::log(*ratio);
                        *ratio = 1.0;
                    }
                    if sensor.is_displacement {
                        scales[shift] = [1.0 + cross / information, (1.0 / information).sqrt()];
                    }
                }
            }
        }
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares: [f64; SHIFTS] = std::array::from_fn(|shift| {
            let log = logs[shift] - largest;
            match log > NOTHING {
                true => libm::exp(log) / ratios[shift].sqrt(),
                false => 0.0,
            }
        });
        let best = (0..SHIFTS).fold(0, |best, k| if shares[k] > shares[best] { k } else { best });
        self.shift = best;
        self.delay = weighing.delays[best];
        self.scale = scales[best];
        self.log_likelihood = largest + libm::log(shares.iter().fold(0.0, |sum, it| sum + it));
    }
}

/// The member with the largest posterior.
pub(crate) fn likeliest<M: std::borrow::Borrow<Member>>(
    members: impl Iterator<Item = M>,
) -> Option<M> {
    let posterior = |it: &M| it.borrow().log_posterior();
    members.max_by(|a, b| posterior(a).total_cmp(&posterior(b)))
}

/// Logarithm of the sum of exponentials.
pub(crate) fn log_sum(logs: impl Iterator<Item = f64>) -> f64 {
    logs.fold(f64::NEG_INFINITY, |sum, log| {
        let (large, small) = if sum > log { (sum, log) } else { (log, sum) };
        if small == f64::NEG_INFINITY {
            large
        } else {
            large + libm::log1p(libm::exp(small - large))
        }
    })
}
