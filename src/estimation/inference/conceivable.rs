//! Impacts as the estimator conceives them, and what its sensors read of them by its own model of all errors.
//!
//! Over many of them the truths have to be distributed within the estimates as the estimates say: what an inference gets wrong by itself
//! shows here, apart from what the model gets wrong (simulation-based calibration, Talts et al. 2018).

use crate::column::{Impact, Outcome};
use crate::estimation::inference::block_layout::Block;
use crate::estimation::inference::blocks::{BlockMean, Blocks};
use crate::estimation::inference::drawn::Drawn;
use crate::estimation::inference::estimator::Estimator;
use crate::estimation::inference::hypothesis::Hypothesis;
use crate::estimation::inference::member::Member;
use crate::estimation::inference::model_error::{FrontError, ModelError};
use crate::estimation::inference::population::with_yield_factor;
use crate::estimation::inference::prediction::{HORIZON, Prediction, TimeGrid};
use crate::estimation::inference::statement::RESIDUAL_ERROR;
use crate::estimation::intake::readings::Readings;
use crate::numerics::Random;
use crate::sensors::{Quantity, Sensor};

/// Time between two samples of all sensors \[s\].
const PERIOD: f64 = 1e-4;

/// The readings begin so long before contact \[s\].
const LEAD: f64 = 5e-3;

/// Blocks that make this share of a mean together are one.
const LEAST_SHARED: f64 = 0.9;

/// Means over this time tell the peak \[s\].
const PEAK_CELL: f64 = 0.5e-3;

/// An impact with its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct ConceivedImpact {
    /// What has struck, by the model.
    pub impact: Impact,
    /// How it ends.
    pub outcome: Outcome,
    /// Momentum of the vehicle \[N s\]: of the model's vehicle, with what the model leaves open of it.
    pub momentum: f64,
    /// Peak displacement of the impact point \[m\]; it has no meaning where the column gives way.
    pub peak_v1: f64,
    /// Displacement that remains \[m\]; NaN where the column gives way.
    pub residual_v1: f64,
    /// What the sensors read, with contact at time 0.
    pub readings: Readings,
}

impl Estimator {
    /// An impact on the undamaged column, drawn by this seed from what is known before anything is measured, with the errors of model and
    /// sensors that the estimator assumes; `None` where the drawn unknowns make no response. A displacement sensor has to be at the
    /// impact point.
    #[must_use]
    pub fn conceive(&self, seed: u64) -> Option<ConceivedImpact> {
        let mut random = Random::new(seed);
        let population = &self.population;
        let (index, hypothesis) = drawn_hypothesis(&population.hypotheses, &mut random);
        let prior = Drawn::prior((index, hypothesis), 1);
        let (unknowns, impact) = loop {
            let unknowns = prior.sample(&mut random);
            let is_possible = hypothesis.log_density(&unknowns) > f64::NEG_INFINITY;
            if let Some(impact) = hypothesis.impact(&unknowns).filter(|_| is_possible) {
                break (unknowns, impact);
            }
        };
        let properties = with_yield_factor(population.properties(), libm::exp(unknowns[3]));
        let grid = TimeGrid::new();
        let (prediction, front) = population.predicted(index, &unknowns, &impact, &grid)?;
        let member = Member::new(index, unknowns, prediction, 0.0, front, 0);
        let factors: Vec<f64> = self
            .sensors()
            .iter()
            .map(|it| 1.0 + ModelError::of(it.quantity).scale * random.normal())
            .collect();
        let errors = (factors.as_slice(), front);
        let [exact, readings] = self.readings_of(&member.prediction, &grid, errors, &mut random);
        let report = &member.prediction.report;
        let at_impact = self.sensors().iter().position(|it| {
            it.quantity == Quantity::Displacement && it.height == properties.length_below
        })?;
        // What the readings rise to later is not of the impact.
        let past_peak = self.past_peak_after_contact(&member);
        let until = exact.rows().take_while(|(time, _)| *time < past_peak);
        let v1: Vec<f64> = until.map(|(_, values)| values[at_impact]).collect();
        let cell = (PEAK_CELL / PERIOD).round() as usize;
        let means = v1
            .chunks_exact(cell)
            .map(|it| it.iter().sum::<f64>() / cell as f64);
        let peak_v1 = means.fold(0.0, f64::max);
        let rest = member.prediction.rest.as_ref();
        let rest = rest.map_or(f64::NAN, |rest| rest.displacement.v1);
        Some(ConceivedImpact {
            momentum: self.drawn_momentum(&member, &mut random),
            peak_v1,
            residual_v1: factors[at_impact] * rest
                + RESIDUAL_ERROR * report.max_v1 * random.normal(),
            outcome: report.outcome,
            impact,
            readings,
        })
    }

    /// The momentum, among those that the response of this member leaves open once the contact is over.
    fn drawn_momentum(&self, member: &Member, random: &mut Random) -> f64 {
        let before = self.before_impact();
        let mut at = random.uniform();
        let open = self.spread_of_vehicle(member, 1.0, [1.0, 1.0], &before, 0.0);
        let mut drawn = None;
        for it in open.filter(|it| it.weight > 0.0) {
            drawn = Some(it);
            at -= it.weight;
            if at < 0.0 {
                break;
            }
        }
        let known = member.unknowns[0] + member.unknowns[1];
        libm::exp(drawn.map_or(known, |it| it.mean + it.deviation * random.normal()))
    }

    /// The readings of all sensors without and with their noise; the errors are the factors between column and model, and that of motions
    /// by the front.
    fn readings_of(
        &self,
        prediction: &Prediction,
        grid: &TimeGrid,
        (factors, front): (&[f64], FrontError),
        random: &mut Random,
    ) -> [Readings; 2] {
        let samples = ((LEAD + HORIZON) / PERIOD).round() as usize;
        let times: Vec<f64> = (0..samples)
            .map(|row| (row as f64 + 0.5) * PERIOD - LEAD)
            .collect();
        let columns: Vec<Vec<f64>> = self
            .sensors()
            .iter()
            .zip(factors)
            .enumerate()
            .map(|(index, (_, factor))| {
                let at = |time: f64| prediction.integral(index, grid.place(time));
                let half = 0.5 * PERIOD;
                let exact: Vec<f64> = times
                    .iter()
                    .map(|time| factor * (at(time + half) - at(time - half)) / PERIOD)
                    .collect();
                self.with_model_error((index, front), &times, exact, random)
            })
            .collect();
        let table = |value: &mut dyn FnMut(&Sensor, f64) -> f64| {
            let sensors = self.sensors();
            let mut values = Vec::with_capacity(samples * sensors.len());
            for row in 0..samples {
                for (sensor, column) in sensors.iter().zip(&columns) {
                    values.push(sensor.clipped(value(sensor, column[row])));
                }
            }
            Readings {
                sensors: sensors.len(),
                times: times.clone(),
                values,
            }
        };
        let exact = table(&mut |_, value| value);
        let noisy = table(&mut |sensor, value| value + sensor.noise * random.normal());
        [exact, noisy]
    }

    /// Readings with an error of the model that is one number over a fifth of the time since contact, as in a likelihood of shorter blocks,
    /// which counts each as a part of such a mean.
    fn with_model_error(
        &self,
        (index, front): (usize, FrontError),
        times: &[f64],
        mut readings: Vec<f64>,
        random: &mut Random,
    ) -> Vec<f64> {
        let sensor = &self.sensors()[index];
        // What the errors are relative to has errors of its own.
        let mut read = self.blocks_of(sensor);
        let error = ModelError::of(sensor.quantity);
        let mut before: Option<((Block, BlockMean), f64)> = None;
        // The share of a mean that the blocks with the last error make together.
        let mut shared = 1.0;
        for (number, block) in read.layout().to_vec().iter().enumerate() {
            let rows = [block.start, block.start + block.length]
                .map(|edge| times.partition_point(|time| *time < edge));
            let push = |blocks: &mut Blocks, readings: &[f64]| {
                for row in rows[0]..rows[1] {
                    // Without any noise it would be stuck at rest.
                    let flicker = if row % 2 == 0 { 1e-9 } else { -1e-9 };
                    blocks.push(0, times[row], readings[row] + flicker * sensor.noise);
                }
            };
            let mut next = read.clone();
            push(&mut next, &readings);
            let Some(mean) = next.mean(0, number) else {
                before = None;
                read = next;
                continue;
            };
            let now = (
                *block,
                BlockMean {
                    variance: 0.0,
                    ..mean
                },
            );
            let own = match before {
                Some((_, last)) if shared < LEAST_SHARED => last,
                _ => {
                    let (carried, variance) = error.given(before.as_ref().map(|it| &it.0), &now);
                    let by_front = self.population.variance_by_front(front, index, &now);
                    let variance = block.share_of_mean() * variance.max(0.0) + by_front;
                    let last = before.map_or(0.0, |(_, last)| last);
                    shared = 0.0;
                    carried * last + variance.max(0.0).sqrt() * random.normal()
                }
            };
            shared += block.share_of_mean();
            for value in &mut readings[rows[0]..rows[1]] {
                *value += own;
            }
            push(&mut read, &readings);
            before = Some((now, own));
        }
        readings
    }

    /// Blocks for the readings of one sensor whose zero is known, with contact at time 0.
    fn blocks_of(&self, sensor: &Sensor) -> Blocks {
        let sensors = std::slice::from_ref(sensor);
        Blocks::new(
            0.0,
            HORIZON,
            self.yield_strain,
            self.period,
            sensors,
            &[(0.0, 0.0)],
        )
    }
}

/// One of the hypotheses, by their probabilities.
fn drawn_hypothesis<'a>(all: &'a [Hypothesis], random: &mut Random) -> (usize, &'a Hypothesis) {
    let mut at = random.uniform();
    let found = all.iter().position(|it| {
        at -= it.probability;
        at < 0.0
    });
    let index = found.unwrap_or(all.len() - 1);
    (index, &all[index])
}
