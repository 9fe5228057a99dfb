//! Weighted responses: adaptive multiple importance sampling over what may have struck the column.
//!
//! Every member is one response, computed once. Its likelihood grows with the data; its weight is prior times likelihood
//! over the density with which members of its hypothesis were drawn, the mixture of all distributions used so far (the
//! balance heuristic, Cornuet et al. 2012). New members are drawn where the weights are.

use rayon::iter::{IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::blocks::{Block, BlockMean};
use super::hypothesis::{Hypothesis, UNKNOWNS};
use super::model_error::ModelError;
use super::prediction::{Place, Prediction, TimeGrid};
use super::random::Random;
use super::sensor::{Quantity, Sensor};
use crate::assessment::Severity;
use crate::column::{ColumnProperties, Impact};
use crate::study::cholesky::cholesky;

/// Instants of contact that are considered, about the detected one.
const SHIFTS: usize = 13;

/// Distance between them, in standard deviations of the detected instant.
const SHIFT_SPACING: f64 = 0.4;

/// Effective number of members to which weights are tempered before a distribution is fitted to them.
const LEAST_EFFECTIVE: f64 = 12.0;

/// Factor of the variances of a distribution from which new members are drawn: wider than what it was fitted to.
const WIDENING: f64 = 1.4;

/// Members about which half of the new members are drawn, chosen by their weights.
const KERNELS: usize = 4;

/// Width of the distribution about one of them, relative to that about all.
const KERNEL_WIDTH: f64 = 0.35;

/// Least standard deviation of such a distribution, relative to that of the hypothesis.
const LEAST_WIDTH: f64 = 0.02;

/// Power of the shares of the hypotheses by which new members are divided among them, so that one that seems unlikely
/// because it was not searched closely is searched.
const EXPLORATION: f64 = 0.1;

/// Share of a hypothesis, after that power, below which it gets no new members.
const LEAST_SHARE: f64 = 0.02;

/// Seconds of standard deviation of the instant of contact, at least: the half of a block.
const LEAST_CONTACT_DEVIATION: f64 = 0.3e-3;

/// One response.
#[derive(Debug, Clone)]
pub(super) struct Member {
    pub hypothesis: usize,
    pub unknowns: [f64; UNKNOWNS],
    pub prediction: Prediction,
    log_prior: f64,
    /// Blocks whose data are in the sums.
    seen: usize,
    /// For each sensor and shift: the sums of `e^2 / var`, `e p / var`, `p^2 / var` with the predictions `p` and `e = y - p`.
    sums: Vec<[[f64; 3]; SHIFTS]>,
    log_posterior: f64,
    /// Severity and capacity ratio, once they were computed.
    pub assessed: Option<(Severity, f64)>,
    /// Delay of contact behind the detected instant \[s\].
    pub delay: f64,
    /// Expected factor between the column's displacements and the model's, and its standard deviation.
    pub scale: [f64; 2],
}

/// A normal distribution from which members of one hypothesis were drawn.
#[derive(Debug, Clone)]
struct Drawn {
    hypothesis: usize,
    count: f64,
    mean: [f64; UNKNOWNS],
    /// Lower triangular factor of the covariance.
    factor: [[f64; UNKNOWNS]; UNKNOWNS],
}

/// All members.
#[derive(Debug, Clone)]
pub(super) struct Population {
    properties: ColumnProperties,
    sensors: Vec<Sensor>,
    grid: TimeGrid,
    pub hypotheses: Vec<Hypothesis>,
    pub members: Vec<Member>,
    drawn: Vec<Drawn>,
    random: Random,
    contact_deviation: f64,
    /// Data so far.
    observed: Vec<(Block, Vec<Option<BlockMean>>)>,
}

impl Population {
    pub fn new(
        properties: ColumnProperties,
        sensors: Vec<Sensor>,
        hypotheses: Vec<Hypothesis>,
        seed: u64,
    ) -> Self {
        Self {
            properties,
            sensors,
            grid: TimeGrid::new(),
            hypotheses,
            members: Vec::new(),
            drawn: Vec::new(),
            random: Random::new(seed),
            contact_deviation: LEAST_CONTACT_DEVIATION,
            observed: Vec::new(),
        }
    }

    /// Draws `count` members of a hypothesis from what is known before the impact.
    pub fn prepare(&mut self, hypothesis: usize, count: usize) {
        let Hypothesis {
            mean, deviation, ..
        } = self.hypotheses[hypothesis];
        let mut factor = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (k, row) in factor.iter_mut().enumerate() {
            row[k] = deviation[k];
        }
        self.draw(Drawn {
            hypothesis,
            count: count as f64,
            mean,
            factor,
        });
    }

    /// The standard deviation of the detected instant of contact \[s\]. To be called before the first data.
    pub fn set_contact_deviation(&mut self, deviation: f64) {
        self.contact_deviation = deviation.max(LEAST_CONTACT_DEVIATION);
    }

    /// Takes the data of a block, sensor by sensor.
    pub fn observe(&mut self, block: Block, means: Vec<Option<BlockMean>>) {
        self.observed.push((block, means));
        self.weigh();
    }

    /// Draws about `count` new members where the weights are.
    pub fn refine(&mut self, count: usize) {
        let weights = self.weights();
        let shares: Vec<f64> = (0..self.hypotheses.len())
            .map(|hypothesis| {
                self.of_hypothesis(hypothesis, &weights)
                    .map(|(_, w)| w)
                    .sum()
            })
            .map(|share: f64| libm::pow(share, EXPLORATION))
            .collect();
        let total: f64 = shares.iter().sum();
        for (hypothesis, share) in shares.iter().enumerate() {
            let share = share / total;
            let wanted = (share * count as f64).round() as usize;
            if share < LEAST_SHARE || wanted == 0 {
                continue;
            }
            let kernels = wanted.min(KERNELS);
            let fitted = self.fitted(hypothesis, &weights, wanted.div_ceil(2));
            for drawn in self.kernels(&fitted, &weights, kernels, wanted / 2) {
                self.draw(drawn);
            }
            self.draw(fitted);
        }
        self.weigh();
    }

    /// Column and impact of a member.
    pub fn case(&self, member: &Member) -> Option<(ColumnProperties, Impact)> {
        let factor = libm::exp(member.unknowns[3]);
        let impact = self.hypotheses[member.hypothesis].impact(&member.unknowns)?;
        Some((with_yield_factor(&self.properties, factor), impact))
    }

    /// Indices of `count` members, chosen by their weights at equal distances.
    pub fn chosen(&self, weights: &[f64], count: usize) -> Vec<usize> {
        let mut chosen = Vec::with_capacity(count);
        let mut sum = 0.0;
        for (index, weight) in weights.iter().enumerate() {
            sum += weight * count as f64;
            while (chosen.len() as f64) + 0.5 < sum && chosen.len() < count {
                chosen.push(index);
            }
        }
        chosen
    }

    /// The weights of the members, which add up to 1.
    pub fn weights(&self) -> Vec<f64> {
        let logs: Vec<f64> = self
            .members
            .iter()
            .map(|member| {
                let densities = self
                    .drawn
                    .iter()
                    .filter(|drawn| drawn.hypothesis == member.hypothesis)
                    .map(|drawn| libm::log(drawn.count) + drawn.log_density(&member.unknowns));
                member.log_posterior - log_sum(densities)
            })
            .collect();
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - largest)).collect();
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        weights
    }

    fn of_hypothesis<'a>(
        &'a self,
        hypothesis: usize,
        weights: &'a [f64],
    ) -> impl Iterator<Item = (&'a Member, f64)> {
        let members = self.members.iter().zip(weights.iter().copied());
        members.filter(move |(member, _)| member.hypothesis == hypothesis)
    }

    /// The distribution of the weighted members of a hypothesis.
    fn fitted(&self, hypothesis: usize, weights: &[f64], count: usize) -> Drawn {
        let own: Vec<_> = self.of_hypothesis(hypothesis, weights).collect();
        let largest = own
            .iter()
            .map(|(_, weight)| *weight)
            .fold(f64::MIN_POSITIVE, f64::max);
        let mut power = 1.0;
        let tempered = loop {
            let mut tempered: Vec<f64> = own
                .iter()
                .map(|(_, weight)| libm::pow(weight / largest, power))
                .collect();
            let sum: f64 = tempered.iter().sum();
            let squares: f64 = tempered.iter().map(|weight| weight * weight).sum();
            if sum * sum >= LEAST_EFFECTIVE * squares || power < 1e-3 {
                for weight in &mut tempered {
                    *weight /= sum;
                }
                break tempered;
            }
            power *= 0.7;
        };
        let each = || {
            own.iter()
                .zip(&tempered)
                .map(|((member, _), w)| (&member.unknowns, *w))
        };
        let mean: [f64; UNKNOWNS] =
            std::array::from_fn(|k| each().map(|(unknowns, weight)| weight * unknowns[k]).sum());
        let mut covariance = [[0.0; UNKNOWNS]; UNKNOWNS];
        for (unknowns, weight) in each() {
            for (i, row) in covariance.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry += WIDENING * weight * (unknowns[i] - mean[i]) * (unknowns[j] - mean[j]);
                }
            }
        }
        for (k, deviation) in self.hypotheses[hypothesis].deviation.iter().enumerate() {
            let least = LEAST_WIDTH * deviation;
            covariance[k][k] += least * least;
        }
        Drawn {
            hypothesis,
            count: count as f64,
            mean,
            factor: cholesky(&covariance),
        }
    }

    /// Narrower distributions about members that are chosen by their weights, for `count` members together.
    fn kernels(
        &mut self,
        fitted: &Drawn,
        weights: &[f64],
        number: usize,
        count: usize,
    ) -> Vec<Drawn> {
        let hypothesis = fitted.hypothesis;
        let total: f64 = self
            .of_hypothesis(hypothesis, weights)
            .map(|(_, w)| w)
            .sum();
        let each = count / number.max(1);
        if each == 0 || total <= 0.0 {
            return Vec::new();
        }
        let offset = self.random.uniform();
        let mut kernels = Vec::with_capacity(number);
        let mut sum = 0.0;
        for (member, weight) in self.of_hypothesis(hypothesis, weights) {
            sum += weight / total;
            // Systematic resampling: the same member may be chosen more than once.
            while kernels.len() < number && sum * number as f64 > kernels.len() as f64 + offset {
                kernels.push(Drawn {
                    hypothesis,
                    count: each as f64,
                    mean: member.unknowns,
                    factor: fitted
                        .factor
                        .map(|row| row.map(|entry| KERNEL_WIDTH * entry)),
                });
            }
        }
        kernels
    }

    fn draw(&mut self, drawn: Drawn) {
        let candidates: Vec<[f64; UNKNOWNS]> = (0..drawn.count as usize)
            .map(|_| drawn.sample(&mut self.random))
            .collect();
        let hypothesis = &self.hypotheses[drawn.hypothesis];
        let (properties, sensors, grid) = (&self.properties, &self.sensors, &self.grid);
        let computed: Vec<Member> = candidates
            .into_par_iter()
            .filter_map(|unknowns| {
                let log_prior = hypothesis.log_density(&unknowns);
                if log_prior == f64::NEG_INFINITY {
                    return None;
                }
                let properties = with_yield_factor(properties, libm::exp(unknowns[3]));
                let impact = hypothesis.impact(&unknowns)?;
                Some(Member {
                    hypothesis: drawn.hypothesis,
                    prediction: Prediction::compute(&properties, &impact, sensors, grid)?,
                    unknowns,
                    log_prior,
                    seen: 0,
                    sums: vec![[[0.0; 3]; SHIFTS]; sensors.len()],
                    log_posterior: log_prior,
                    assessed: None,
                    delay: 0.0,
                    scale: [1.0, ModelError::of(Quantity::Displacement).scale],
                })
            })
            .collect();
        self.members.extend(computed);
        self.drawn.push(drawn);
    }

    /// Brings the likelihood of every member up to the data.
    fn weigh(&mut self) {
        let errors: Vec<_> = self
            .sensors
            .iter()
            .map(|sensor| ModelError::of(sensor.quantity))
            .collect();
        let delays: [f64; SHIFTS] = std::array::from_fn(|shift| {
            (shift as f64 - (SHIFTS / 2) as f64) * SHIFT_SPACING * self.contact_deviation
        });
        let grid = &self.grid;
        // Where each block begins and ends in the predictions is the same for all members.
        let blocks: Vec<_> = self
            .observed
            .iter()
            .map(|(block, means)| {
                let places: [[Place; 2]; SHIFTS] = delays.map(|delay| {
                    let start = block.start - delay;
                    [grid.place(start), grid.place(start + block.length)]
                });
                let terms: Vec<_> = means
                    .iter()
                    .zip(&errors)
                    .map(|(mean, error)| {
                        mean.map(|it| {
                            let until = block.start + block.length;
                            let model = error.variance(until, block.length, it.largest, it.yielded);
                            (it.mean, 1.0 / (it.variance + model).max(f64::MIN_POSITIVE))
                        })
                    })
                    .collect();
                (places, block.length, terms)
            })
            .collect();
        let deviation = self.contact_deviation;
        let sensors = &self.sensors;
        self.members.par_iter_mut().for_each(|member| {
            for (places, length, terms) in &blocks[member.seen..] {
                for (sensor, term) in terms.iter().enumerate() {
                    let Some((mean, precision)) = *term else {
                        continue;
                    };
                    for (sums, [from, to]) in member.sums[sensor].iter_mut().zip(places) {
                        let predicted = member.prediction.mean(sensor, *from, *to, *length);
                        let error = mean - predicted;
                        sums[0] += precision * error * error;
                        sums[1] += precision * error * predicted;
                        sums[2] += precision * predicted * predicted;
                    }
                }
            }
            member.seen = blocks.len();
            member.conclude(&errors, sensors, &delays, deviation);
        });
    }
}

impl Member {
    /// The likelihood over all instants of contact, with the factor of each sensor's readings integrated out.
    fn conclude(
        &mut self,
        errors: &[ModelError],
        sensors: &[Sensor],
        delays: &[f64; SHIFTS],
        deviation: f64,
    ) {
        let mut logs = [0.0; SHIFTS];
        let mut scales = [[1.0, ModelError::of(Quantity::Displacement).scale]; SHIFTS];
        for (shift, delay) in delays.iter().enumerate() {
            let z = delay / deviation;
            logs[shift] = -0.5 * z * z;
            for ((sums, error), sensor) in self.sums.iter().zip(errors).zip(sensors) {
                let [squares, cross, predicted] = sums[shift];
                let prior = 1.0 / (error.scale * error.scale);
                let information = predicted + prior;
                logs[shift] -= 0.5 * (squares - cross * cross / information)
                    + 0.5 * libm::log(information / prior);
                if sensor.quantity == Quantity::Displacement {
                    scales[shift] = [1.0 + cross / information, (1.0 / information).sqrt()];
                }
            }
        }
        let best = (0..SHIFTS).fold(0, |best, k| if logs[k] > logs[best] { k } else { best });
        self.delay = delays[best];
        self.scale = scales[best];
        self.log_posterior = self.log_prior + log_sum(logs.into_iter());
    }
}

impl Drawn {
    fn sample(&self, random: &mut Random) -> [f64; UNKNOWNS] {
        let z: [f64; UNKNOWNS] = std::array::from_fn(|_| random.normal());
        std::array::from_fn(|i| {
            let row = &self.factor[i];
            self.mean[i] + (0..=i).map(|k| row[k] * z[k]).sum::<f64>()
        })
    }

    /// Logarithm of the density, without the constant that all have.
    fn log_density(&self, unknowns: &[f64; UNKNOWNS]) -> f64 {
        let mut z = [0.0; UNKNOWNS];
        let mut log = 0.0;
        for i in 0..UNKNOWNS {
            let known: f64 = (0..i).map(|k| self.factor[i][k] * z[k]).sum();
            z[i] = (unknowns[i] - self.mean[i] - known) / self.factor[i][i];
            log -= 0.5 * z[i] * z[i] + libm::log(self.factor[i][i]);
        }
        log
    }
}

/// The column with its yield strength times a factor.
fn with_yield_factor(properties: &ColumnProperties, factor: f64) -> ColumnProperties {
    ColumnProperties {
        resistance_moment: factor * properties.resistance_moment,
        resistance_axial: factor * properties.resistance_axial,
        ..*properties
    }
}

/// Logarithm of the sum of exponentials.
fn log_sum(logs: impl Iterator<Item = f64>) -> f64 {
    logs.fold(f64::NEG_INFINITY, |sum, log| {
        let (large, small) = if sum > log { (sum, log) } else { (log, sum) };
        if small == f64::NEG_INFINITY {
            large
        } else {
            large + libm::log1p(libm::exp(small - large))
        }
    })
}
