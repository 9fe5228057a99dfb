//! A normal distribution from which members of one hypothesis were drawn.

use crate::estimation::inference::hypothesis::{Hypothesis, UNKNOWNS};
use crate::numerics::Random;

/// A normal distribution from which members of one hypothesis were drawn.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    pub hypothesis: usize,
    pub count: f64,
    /// Unknowns of the hypothesis, from the first on.
    pub unknowns: usize,
    pub mean: [f64; UNKNOWNS],
    /// Lower triangular factor of the covariance.
    pub factor: [[f64; UNKNOWNS]; UNKNOWNS],
    /// Logarithms of the diagonal of the factor.
    log_diagonal: [f64; UNKNOWNS],
}

impl Drawn {
    pub fn new(
        (hypothesis, unknowns): (usize, usize),
        count: usize,
        mean: [f64; UNKNOWNS],
        factor: [[f64; UNKNOWNS]; UNKNOWNS],
    ) -> Self {
        Self {
            hypothesis,
            count: count as f64,
            unknowns,
            mean,
            factor,
            log_diagonal: std::array::from_fn(|k| libm::log(factor[k][k])),
        }
    }

    /// What is known of a hypothesis with this index before an impact.
    pub fn prior((index, hypothesis): (usize, &Hypothesis), count: usize) -> Self {
        let Hypothesis {
            mean,
            deviation,
            unknowns,
            ..
        } = hypothesis;
        Self::new((index, *unknowns), count, *mean, independent(deviation))
    }

    pub fn sample(&self, random: &mut Random) -> [f64; UNKNOWNS] {
        let mut z = [0.0; UNKNOWNS];
        z[..self.unknowns].fill_with(|| random.normal());
        std::array::from_fn(|i| {
            let row = &self.factor[i];
            self.mean[i] + (0..=i).map(|k| row[k] * z[k]).sum::<f64>()
        })
    }

    /// Logarithm of the density, without the constant that all have.
    pub fn log_density(&self, unknowns: &[f64; UNKNOWNS]) -> f64 {
        let mut z = [0.0; UNKNOWNS];
        let mut log = 0.0;
        for i in 0..self.unknowns {
            let known: f64 = (0..i).map(|k| self.factor[i][k] * z[k]).sum();
            z[i] = (unknowns[i] - self.mean[i] - known) / self.factor[i][i];
            log -= 0.5 * z[i] * z[i] + self.log_diagonal[i];
        }
        log
    }
}

/// The factor of the covariance of independent unknowns with these standard deviations.
pub(super) fn independent(deviation: &[f64; UNKNOWNS]) -> [[f64; UNKNOWNS]; UNKNOWNS] {
    let mut factor = [[0.0; UNKNOWNS]; UNKNOWNS];
    for (k, row) in factor.iter_mut().enumerate() {
        row[k] = deviation[k];
    }
    factor
}
