//! Where new members of a population are drawn: where the weights are, and where they may be.

use crate::estimation::inference::contradiction::largest;
use crate::estimation::inference::drawn::{Drawn, independent};
use crate::estimation::inference::hypothesis::{Front, Hypothesis, OF_ONE_FACTOR, UNKNOWNS};
use crate::estimation::inference::member::likeliest;
use crate::estimation::inference::population::Population;
use crate::estimation::inference::round::Round;
use crate::numerics::cholesky;

/// Effective number of members to which weights are tempered before a distribution is fitted to them.
const LEAST_EFFECTIVE: f64 = 12.0;

/// Factor of the variances of a distribution from which new members are drawn: wider than what it was fitted to.
pub(crate) const WIDENING: f64 = 1.4;

/// Members about which half of the new members are drawn, chosen by their weights.
const KERNELS: usize = 4;

/// Width of the distribution about one of them, relative to that about all.
const KERNEL_WIDTH: f64 = 0.35;

/// Width of a distribution that takes their place where they would be too few members for so many, relative to the other one: it covers
/// what this may have left out.
const TAIL_WIDTH: f64 = 2.0;

/// Least standard deviation of such a distribution, relative to that of the hypothesis.
const LEAST_WIDTH: f64 = 0.02;

/// How new members are divided among the hypotheses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Division {
    /// Power of their shares.
    power: f64,
    /// Whether those with open fronts get [`OPEN_SHARE`] in any case.
    seeks_open: bool,
}

impl Division {
    /// A hypothesis that seems unlikely because it was not searched closely is searched.
    pub const EXPLORING: Self = Self {
        power: 0.1,
        seeks_open: true,
    };

    /// The same where there is time for few responses only.
    pub const EXPLORING_IN_HASTE: Self = Self {
        power: 0.4,
        seeks_open: true,
    };

    /// The likely ones get most.
    pub const BY_WEIGHT: Self = Self {
        power: 0.5,
        seeks_open: false,
    };
}

/// Share of a hypothesis, after that power, below which it gets no new members.
const LEAST_SHARE: f64 = 0.02;

/// Share of the new members that a hypothesis gets at least whose front has more unknowns than a factor: its prepared members are few for
/// so many unknowns, and those that explain the data have to be found.
const OPEN_SHARE: f64 = 0.15;

/// The same of vehicles with a hard front mass where the data look like a rigid hit: at first it is one by this mass.
const SHARE_BESIDE_RIGID: f64 = 0.3;

/// Share of these that begin as the rigid hit that the data have found.
const FROM_RIGID: f64 = 0.5;

/// Standard deviation of the logarithms of mass and speed about such a rigid hit.
const ABOUT_RIGID: f64 = 0.15;

impl Population {
    /// About `count` new members where the weights are, which are to be computed. They are divided among the hypotheses.
    pub fn plan(&mut self, count: usize, division: Division) -> Round {
        let mut round = Round::new(&self.random);
        let weights = self.weights();
        let shares: Vec<f64> = (0..self.hypotheses.len())
            .map(|hypothesis| {
                self.of_hypothesis(hypothesis, &weights)
                    .map(|(_, w)| w)
                    .sum()
            })
            .collect();
        let rigid = self.hypotheses.iter().zip(&shares);
        let rigid = rigid.filter(|(it, _)| it.front == Front::Rigid);
        let looks_rigid = rigid.map(|(_, share)| share).sum::<f64>() > 0.5;
        let shares: Vec<f64> = shares
            .iter()
            .map(|&share| libm::pow(share, division.power))
            .collect();
        let total: f64 = shares.iter().sum();
        for (hypothesis, share) in shares.iter().enumerate() {
            let Hypothesis {
                unknowns, front, ..
            } = &self.hypotheses[hypothesis];
            let least = match (unknowns > &OF_ONE_FACTOR, front) {
                _ if !division.seeks_open => 0.0,
                (true, Front::TwoMasses) if looks_rigid => SHARE_BESIDE_RIGID,
                (true, _) => OPEN_SHARE,
                (false, _) => 0.0,
            };
            let share = (share / total).max(least);
            let wanted = (share * count as f64).round() as usize;
            if share < LEAST_SHARE || wanted == 0 {
                continue;
            }
            if self.hypotheses[hypothesis].front == Front::TwoMasses
                && let Some(drawn_from_rigid) = self.drawn_from_rigid(hypothesis, wanted)
            {
                round.draw(drawn_from_rigid, &mut self.random);
            }
            let kernels = wanted.min(KERNELS);
            let Some(fitted) = self.fitted(hypothesis, wanted.div_ceil(2)) else {
                continue;
            };
            for kernel in self.kernels(&fitted, &weights, kernels, wanted / 2) {
                round.draw(kernel, &mut self.random);
            }
            round.draw(fitted, &mut self.random);
        }
        round
    }

    /// Vehicles whose hard front mass does what the most likely rigid vehicle does, with anything behind it.
    fn drawn_from_rigid(&self, hypothesis: usize, wanted: usize) -> Option<Drawn> {
        let count = (FROM_RIGID * wanted as f64).round() as usize;
        let rigid = self.members.iter();
        let rigid = rigid.filter(|it| self.hypotheses[it.hypothesis].front == Front::Rigid);
        let likeliest = likeliest(rigid)?;
        let Hypothesis {
            mut mean,
            deviation,
            unknowns,
            ..
        } = self.hypotheses[hypothesis];
        let mut factor = independent(&deviation);
        // The share of the front times the mass is the mass of the rigid vehicle.
        const SHARE: usize = UNKNOWNS - 1;
        mean[1] = likeliest.unknowns[1];
        mean[SHARE] = likeliest.unknowns[0] - mean[0];
        (factor[1][1], factor[SHARE][SHARE]) = (ABOUT_RIGID, ABOUT_RIGID);
        factor[SHARE][0] = -factor[0][0];
        (count > 0).then(|| Drawn::new((hypothesis, unknowns), count, mean, factor))
    }

    /// The distribution of the weighted members of a hypothesis; `None` if no member of it has a weight, however small.
    fn fitted(&self, hypothesis: usize, count: usize) -> Option<Drawn> {
        let own = self.members.iter().filter(|it| it.hypothesis == hypothesis);
        // Beside another hypothesis the weights may be too small for a number.
        let own: Vec<_> = own.map(|it| (it, self.log_weight(it))).collect();
        let largest = largest(own.iter().map(|(_, log)| *log));
        if !largest.is_finite() {
            return None;
        }
        let mut power = 1.0;
        let tempered = loop {
            let mut tempered: Vec<f64> = own
                .iter()
                .map(|(_, log)| libm::exp(power * (log - largest)))
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
        let unknowns = self.hypotheses[hypothesis].unknowns;
        let factor = cholesky(&covariance);
        Some(Drawn::new((hypothesis, unknowns), count, mean, factor))
    }

    /// Narrower distributions about members that are chosen by their weights, for `count` members together; a wider one where these are too
    /// few.
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
        if count == 0 || total <= 0.0 {
            return Vec::new();
        }
        let wider = |by: f64| fitted.factor.map(|row| row.map(|entry| by * entry));
        let of = (hypothesis, fitted.unknowns);
        let each = count / number.max(1);
        if each == 0 {
            return vec![Drawn::new(of, count, fitted.mean, wider(TAIL_WIDTH))];
        }
        let offset = self.random.uniform();
        let mut kernels = Vec::with_capacity(number);
        let mut sum = 0.0;
        for (member, weight) in self.of_hypothesis(hypothesis, weights) {
            sum += weight / total;
            // Systematic resampling: the same member may be chosen more than once.
            while kernels.len() < number && sum * number as f64 > kernels.len() as f64 + offset {
                let factor = wider(KERNEL_WIDTH);
                kernels.push(Drawn::new(of, each, member.unknowns, factor));
            }
        }
        kernels
    }
}
