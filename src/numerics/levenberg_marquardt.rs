//! Adjustment of unknowns to residuals and priors, one response at a time (Levenberg and Marquardt).

use crate::numerics::{cholesky, solved};

/// Factors by which the damping changes after a step that was worth it, and after one that was not.
const LESS_DAMPING: f64 = 0.2;
const MORE_DAMPING: f64 = 6.0;

/// Damping of the first step, and the least one.
const FIRST_DAMPING: f64 = 1e-2;
const LEAST_DAMPING: f64 = 1e-6;

/// One step after another: first the derivatives of the residuals are taken, one unknown after another, then steps are attempted. What the
/// residuals are is up to the caller.
#[derive(Debug, Clone)]
pub(crate) struct LevenbergMarquardt<const SIZE: usize> {
    /// How many unknowns are adjusted, from the first one on.
    unknowns: usize,
    damping: f64,
    /// Derivatives of the residuals, by one unknown after another.
    slopes: Vec<Vec<f64>>,
    /// Matrix and right side of the normal equations, once all derivatives are known.
    normal: [[f64; SIZE]; SIZE],
    gradient: [f64; SIZE],
    attempts: u32,
}

impl<const SIZE: usize> LevenbergMarquardt<SIZE> {
    pub fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            damping: FIRST_DAMPING,
            slopes: Vec::new(),
            normal: std::array::from_fn(|k| std::array::from_fn(|other| f64::from(k == other))),
            gradient: [0.0; SIZE],
            attempts: 0,
        }
    }

    /// The unknown by which the derivatives are needed next; `None` if all are known, and a step can be attempted.
    pub fn wanted_slope(&self) -> Option<usize> {
        (self.slopes.len() < self.unknowns).then_some(self.slopes.len())
    }

    /// Takes the residuals that the wanted unknown has moved by this step, from those at the unknowns `at`; `prior` gives the mean and the
    /// standard deviation of an unknown.
    pub fn take_slope(
        &mut self,
        (moved, step): (&[f64], f64),
        residuals: &[f64],
        at: &[f64; SIZE],
        prior: impl Fn(usize) -> [f64; 2],
    ) {
        let pairs = moved.iter().zip(residuals);
        self.slopes
            .push(pairs.map(|(moved, here)| (moved - here) / step).collect());
        if self.wanted_slope().is_some() {
            return;
        }
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
        for (k, own) in self.slopes.iter().enumerate() {
            let [mean, deviation] = prior(k);
            let precision = 1.0 / (deviation * deviation);
            for (entry, other) in self.normal[k].iter_mut().zip(&self.slopes) {
                *entry = product(own, other);
            }
            self.normal[k][k] += precision;
            self.gradient[k] = product(own, residuals) + precision * (at[k] - mean);
        }
    }

    /// What is to be subtracted from the unknowns in the next attempt.
    pub fn step(&self) -> [f64; SIZE] {
        let mut damped = self.normal;
        for (k, row) in damped.iter_mut().enumerate() {
            row[k] *= 1.0 + self.damping;
        }
        solved(&cholesky(&damped), &self.gradient)
    }

    /// The attempt was better: the next step begins there.
    pub fn accept(&mut self) {
        self.damping = (LESS_DAMPING * self.damping).max(LEAST_DAMPING);
        self.begin_step();
    }

    /// The attempt was not better; returns how many there were of this step.
    pub fn decline(&mut self) -> u32 {
        self.damping *= MORE_DAMPING;
        self.attempts += 1;
        self.attempts
    }

    /// Forgets the derivatives, which are needed again for another step.
    pub fn begin_step(&mut self) {
        self.attempts = 0;
        self.slopes.clear();
    }

    /// Covariance of the unknowns by the derivatives that were known last.
    pub fn covariance(&self) -> [[f64; SIZE]; SIZE] {
        let factor = cholesky(&self.normal);
        std::array::from_fn(|k| {
            solved(&factor, &std::array::from_fn(|other| f64::from(k == other)))
        })
    }
}
