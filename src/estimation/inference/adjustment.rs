//! From one impact to the most likely one near it, by least squares.

use crate::estimation::inference::hypothesis::{Hypothesis, UNKNOWNS};
use crate::estimation::inference::member::Member;
use crate::estimation::inference::population::Population;
use crate::estimation::inference::weighing::Weighing;
use crate::numerics::LevenbergMarquardt;

/// Step of the logarithms of the unknowns by which derivatives are taken: a column that has yielded answers to a change of the force by
/// thirty times as much.
const STEP: f64 = 0.002;

/// Longest step of a logarithm.
const LONGEST_STEP: f64 = 0.4;

/// Most steps, and most attempts of one step.
const MOST_STEPS: u32 = 5;
const MOST_ATTEMPTS: u32 = 4;

/// Increase of the logarithm of the posterior that is worth another step.
const INCREASE: f64 = 0.5;

/// An adjustment of all unknowns of a hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Adjustment {
    hypothesis: usize,
    /// The most likely impact so far.
    pub at: [f64; UNKNOWNS],
    log_posterior: f64,
    /// The most likely instant of contact there, for which the residuals are.
    shift: usize,
    residuals: Vec<f64>,
    method: LevenbergMarquardt<UNKNOWNS>,
    steps: u32,
    is_over: bool,
}

impl Adjustment {
    /// From a member that is weighed.
    pub fn new(population: &Population, member: &Member, weighing: &Weighing) -> Self {
        Self {
            hypothesis: member.hypothesis,
            at: member.unknowns,
            log_posterior: member.log_posterior(),
            shift: member.shift,
            residuals: member.residuals(weighing, member.shift),
            method: LevenbergMarquardt::new(population.hypotheses[member.hypothesis].unknowns),
            steps: 0,
            is_over: false,
        }
    }

    /// Covariance of the unknowns, as far as the residuals are linear.
    pub fn covariance(&self) -> [[f64; UNKNOWNS]; UNKNOWNS] {
        self.method.covariance()
    }

    /// Computes the next response that it needs; `false` once it is over.
    pub fn step(&mut self, population: &Population, weighing: &Weighing) -> bool {
        if self.is_over {
            return false;
        }
        match self.method.wanted_slope() {
            Some(unknown) => self.take_slope(unknown, population, weighing),
            None => self.attempt(population, weighing),
        }
        true
    }

    fn take_slope(&mut self, unknown: usize, population: &Population, weighing: &Weighing) {
        let Hypothesis {
            mean, deviation, ..
        } = &population.hypotheses[self.hypothesis];
        let mut unknowns = self.at;
        unknowns[unknown] += STEP;
        let moved = population.weighed(self.hypothesis, unknowns, weighing);
        let moved = moved.map(|it| it.residuals(weighing, self.shift));
        // Beyond what is considered, only the prior counts.
        let moved = moved.as_ref().unwrap_or(&self.residuals);
        let prior = |unknown: usize| [mean[unknown], deviation[unknown]];
        let method = &mut self.method;
        method.take_slope((moved, STEP), &self.residuals, &self.at, prior);
    }

    fn attempt(&mut self, population: &Population, weighing: &Weighing) {
        let step = self.method.step();
        let longest = step
            .iter()
            .fold(LONGEST_STEP, |longest, it| longest.max(it.abs()));
        let unknowns = std::array::from_fn(|k| self.at[k] - LONGEST_STEP / longest * step[k]);
        let found = population.weighed(self.hypothesis, unknowns, weighing);
        let Some(better) = found.filter(|it| it.log_posterior() > self.log_posterior) else {
            self.is_over = self.method.decline() >= MOST_ATTEMPTS;
            return;
        };
        let increase = better.log_posterior() - self.log_posterior;
        self.steps += 1;
        self.is_over = increase < INCREASE || self.steps >= MOST_STEPS;
        self.at = better.unknowns;
        self.log_posterior = better.log_posterior();
        self.shift = better.shift;
        self.residuals = better.residuals(weighing, better.shift);
        self.method.accept();
    }
}
