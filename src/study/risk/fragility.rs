//! Fragility curves: the probability of a severity as a function of the speed at the column.

use serde::Serialize;

use super::estimate::Estimate;
use super::normal;
use super::tally::{Cell, SPEED_BINS, Tally, sum};
use crate::assessment::Severity;

/// Most iterations of a fit.
const MAX_ITERATIONS: usize = 60;

/// The probability of a severity or a higher one as a function of the speed at the column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FragilityCurve {
    /// Vehicle of one class; `None`: the whole traffic.
    pub vehicle: Option<&'static str>,
    /// The severity that is reached or exceeded.
    pub severity: Severity,
    /// By interval of the speed, slowest first.
    pub points: Vec<FragilityPoint>,
    /// The lognormal curve through them; `None` where they do not determine one.
    pub fit: Option<LognormalFit>,
}

/// The probability in an interval of the speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FragilityPoint {
    /// The interval \[m/s\]; the last one contains faster vehicles, too.
    pub speed: [f64; 2],
    /// Samples in the interval.
    pub samples: u64,
    /// The probability; `None` without a sample.
    pub probability: Option<Estimate>,
}

/// `P = Phi(ln(v / median) / dispersion)`, by maximum likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LognormalFit {
    /// Speed of an equal chance \[m/s\].
    pub median: f64,
    /// Standard deviation of its logarithm.
    pub dispersion: f64,
    /// Standard error of the logarithm of the median.
    pub median_error: f64,
    /// Standard error of the dispersion.
    pub dispersion_error: f64,
}

impl LognormalFit {
    /// The probability at a speed \[m/s\].
    #[must_use]
    pub fn probability(&self, speed: f64) -> f64 {
        match speed > 0.0 {
            true => normal::probability(libm::log(speed / self.median) / self.dispersion),
            false => 0.0,
        }
    }

    /// Probit regression on the logarithm of the speed: Fisher scoring from a given start. Each row has a speed, a number of
    /// trials and the share of events among them.
    fn new(rows: &[(f64, f64, f64)]) -> Option<Self> {
        let events: f64 = rows.iter().map(|(_, n, p)| n * p).sum();
        let trials: f64 = rows.iter().map(|(_, n, _)| n).sum();
        // Without events on both sides, or in one interval only, there is no maximum.
        let mixed = rows
            .iter()
            .filter(|(_, n, p)| *n > 0.0 && *p > 0.0 && *p < 1.0)
            .count();
        if events < 5.0 || trials - events < 5.0 || mixed < 2 {
            return None;
        }
        let half = rows
            .iter()
            .find(|(_, n, p)| *n > 0.0 && *p >= 0.5)
            .or(rows.last())?;
        let (mut a, mut b) = (-4.0 * libm::log(half.0), 4.0);
        let mut information = [0.0; 3];
        for _ in 0..MAX_ITERATIONS {
            information = [0.0; 3];
            let mut score = [0.0; 2];
            for (speed, n, p) in rows.iter().filter(|row| row.1 > 0.0) {
                let x = libm::log(*speed);
                let eta = (a + b * x).clamp(-8.0, 8.0);
                let expected = normal::probability(eta);
                let density = normal::density(eta);
                let variance = expected * normal::probability(-eta);
                let weight = n * density * density / variance;
                let residual = n * density * (p - expected) / variance;
                score[0] += residual;
                score[1] += residual * x;
                information[0] += weight;
                information[1] += weight * x;
                information[2] += weight * x * x;
            }
            let [i00, i01, i11] = information;
            let determinant = i00 * i11 - i01 * i01;
            if !(determinant.is_finite() && determinant > 1e-12 * i00 * i11) {
                return None;
            }
            let step = [
                (i11 * score[0] - i01 * score[1]) / determinant,
                (i00 * score[1] - i01 * score[0]) / determinant,
            ];
            // A long step from a poor start is shortened to a change that the next one can correct.
            let length = (step[1].abs() / (0.5 * b.abs())).max(1.0);
            a += step[0] / length;
            b += step[1] / length;
            if !(a.is_finite() && b > 1e-3) {
                return None;
            }
            if step[1].abs() < 1e-9 * b && step[0].abs() < 1e-9 * (1.0 + a.abs()) {
                break;
            }
        }
        let [i00, i01, i11] = information;
        let determinant = i00 * i11 - i01 * i01;
        let (vaa, vab, vbb) = (i11 / determinant, -i01 / determinant, i00 / determinant);
        // ln(median) = -a/b, dispersion = 1/b, by the delta method.
        let ratio = a / b;
        let median_variance = (vaa - 2.0 * ratio * vab + ratio * ratio * vbb) / (b * b);
        Some(Self {
            median: libm::exp(-ratio),
            dispersion: 1.0 / b,
            median_error: median_variance.max(0.0).sqrt(),
            dispersion_error: vbb.sqrt() / (b * b),
        })
    }
}

/// The curve of a severity, of one class or of the whole traffic.
pub(super) fn curve(
    tally: &Tally,
    class: Option<(usize, &'static str)>,
    severity: Severity,
    z: f64,
) -> FragilityCurve {
    let width = tally.greatest_speed / SPEED_BINS as f64;
    let cells: Vec<Cell> = (0..SPEED_BINS)
        .map(|bin| match class {
            Some((class, _)) => tally.by_speed[class][bin].clone(),
            None => sum(tally.by_speed.iter().map(|bins| &bins[bin])),
        })
        .collect();
    let points: Vec<FragilityPoint> = cells
        .iter()
        .enumerate()
        .map(|(bin, cell)| FragilityPoint {
            speed: [bin as f64 * width, (bin + 1) as f64 * width],
            samples: cell.impacts(),
            probability: (cell.impacts() > 0).then(|| cell.at_least(severity, z)),
        })
        .collect();
    let rows: Vec<_> = points
        .iter()
        .filter_map(|point| {
            let middle = 0.5 * (point.speed[0] + point.speed[1]);
            Some((middle, point.samples as f64, point.probability?.value))
        })
        .collect();
    FragilityCurve {
        vehicle: class.map(|(_, vehicle)| vehicle),
        severity,
        points,
        fit: LognormalFit::new(&rows),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fit finds the curve from which exact shares were computed, and its errors are those of the number of trials.
    #[test]
    fn the_fit_finds_the_curve() {
        let truth = LognormalFit {
            median: 11.0,
            dispersion: 0.3,
            median_error: 0.0,
            dispersion_error: 0.0,
        };
        let rows: Vec<_> = (1..40)
            .map(|it| f64::from(it) * 0.7)
            .map(|speed| (speed, 1000.0, truth.probability(speed)))
            .collect();
        let found = LognormalFit::new(&rows).unwrap();
        assert!((found.median - 11.0).abs() < 1e-6, "{found:?}");
        assert!((found.dispersion - 0.3).abs() < 1e-6, "{found:?}");
        let fewer: Vec<_> = rows
            .iter()
            .map(|(speed, n, p)| (*speed, n / 4.0, *p))
            .collect();
        let less = LognormalFit::new(&fewer).unwrap();
        assert!((less.median_error / found.median_error - 2.0).abs() < 1e-6);
        assert!(found.median_error < 0.01);
    }

    #[test]
    fn what_does_not_determine_a_curve_has_no_fit() {
        assert_eq!(LognormalFit::new(&[]), None);
        assert_eq!(
            LognormalFit::new(&[(1.0, 100.0, 0.0), (2.0, 100.0, 0.0)]),
            None
        );
        assert_eq!(
            LognormalFit::new(&[(1.0, 100.0, 0.0), (2.0, 100.0, 1.0)]),
            None
        );
        assert_eq!(LognormalFit::new(&[(1.0, 100.0, 0.5)]), None);
    }
}
