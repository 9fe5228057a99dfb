//! Fragility curves: the probability of an action as a function of the speed at the column.

use serde::Serialize;

use super::estimate::Estimate;
use super::normal;
use super::tally::{Cell, SPEED_BINS, Tally, sum};
use crate::assessment::Action;

/// Most iterations of a fit.
const MAX_ITERATIONS: usize = 60;
/// Fewest samples with an action, and without it, from which a curve is fitted.
const FEWEST_EVENTS: f64 = 5.0;
/// Largest standard error of the logarithm of a median: a speed that may as well be a quarter higher or lower helps nobody.
const LARGEST_MEDIAN_ERROR: f64 = 0.25;

/// The probability of an action or a higher one as a function of the speed at the column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FragilityCurve {
    /// Vehicle of one class; `None`: the whole traffic.
    pub vehicle: Option<&'static str>,
    /// The action that is reached or exceeded.
    pub action: Action,
    /// By interval of the speed, slowest first.
    pub points: Vec<FragilityPoint>,
    /// The lognormal curve through them; `None` where they do not determine one.
    pub fit: Option<LognormalFit>,
    /// Why there is none.
    pub rejected: Option<Rejected>,
}

/// Why the samples of an action have no fragility curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Rejected {
    /// Too few samples on one of its sides.
    #[error("fewer than {FEWEST_EVENTS} samples with it or without it")]
    TooFew,
    /// The shares lie between 0 and 1 in less than two intervals of the speed, or do not rise with it.
    #[error("the samples do not determine a curve")]
    Undetermined,
    /// The curve reaches 50 % outside of the speeds that were drawn.
    #[error("the samples, {from:.1} to {to:.1} m/s fast, do not reach a probability of 50 %")]
    OutsideSamples {
        /// The slowest interval with samples begins here \[m/s\].
        from: f64,
        /// The fastest interval with samples ends here \[m/s\].
        to: f64,
    },
    /// The median is not known well enough to be used.
    #[error("too few samples: the standard error of its median is {:.0} %", 100.0 * .error)]
    Uncertain {
        /// Standard error of the logarithm of the median.
        error: f64,
    },
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
    fn new(rows: &[(f64, f64, f64)]) -> Result<Self, Rejected> {
        let events: f64 = rows.iter().map(|(_, n, p)| n * p).sum();
        let trials: f64 = rows.iter().map(|(_, n, _)| n).sum();
        // Without events on both sides, or in one interval only, there is no maximum.
        let mixed = rows
            .iter()
            .filter(|(_, n, p)| *n > 0.0 && *p > 0.0 && *p < 1.0)
            .count();
        if events < FEWEST_EVENTS || trials - events < FEWEST_EVENTS {
            return Err(Rejected::TooFew);
        }
        if mixed < 2 {
            return Err(Rejected::Undetermined);
        }
        let half = rows
            .iter()
            .find(|(_, n, p)| *n > 0.0 && *p >= 0.5)
            .or(rows.last())
            .ok_or(Rejected::Undetermined)?;
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
                return Err(Rejected::Undetermined);
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
                return Err(Rejected::Undetermined);
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
        Ok(Self {
            median: libm::exp(-ratio),
            dispersion: 1.0 / b,
            median_error: median_variance.max(0.0).sqrt(),
            dispersion_error: vbb.sqrt() / (b * b),
        })
    }

    /// The fit, if its median lies among the speeds of the samples and is known well enough.
    fn usable(self, points: &[FragilityPoint]) -> Result<Self, Rejected> {
        let mut sampled = points.iter().filter(|point| point.samples > 0);
        let first = sampled.next().ok_or(Rejected::TooFew)?;
        let (from, to) = (
            first.speed[0],
            sampled.next_back().unwrap_or(first).speed[1],
        );
        if !(from..=to).contains(&self.median) {
            return Err(Rejected::OutsideSamples { from, to });
        }
        match self.median_error <= LARGEST_MEDIAN_ERROR {
            true => Ok(self),
            false => Err(Rejected::Uncertain {
                error: self.median_error,
            }),
        }
    }
}

/// The curve of an action, of one class or of the whole traffic.
pub(super) fn curve(
    tally: &Tally,
    class: Option<(usize, &'static str)>,
    action: Action,
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
            probability: (cell.impacts() > 0).then(|| cell.at_least(action, z)),
        })
        .collect();
    let rows: Vec<_> = points
        .iter()
        .filter_map(|point| {
            let middle = 0.5 * (point.speed[0] + point.speed[1]);
            Some((middle, point.samples as f64, point.probability?.value))
        })
        .collect();
    let fit = LognormalFit::new(&rows).and_then(|fit| fit.usable(&points));
    FragilityCurve {
        vehicle: class.map(|(_, vehicle)| vehicle),
        action,
        points,
        fit: fit.ok(),
        rejected: fit.err(),
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
        let rejected = |rows: &[(f64, f64, f64)]| LognormalFit::new(rows).unwrap_err();
        assert_eq!(rejected(&[]), Rejected::TooFew);
        let none = [(1.0, 100.0, 0.0), (2.0, 100.0, 0.0)];
        assert_eq!(rejected(&none), Rejected::TooFew);
        let step = [(1.0, 100.0, 0.0), (2.0, 100.0, 1.0)];
        assert_eq!(rejected(&step), Rejected::Undetermined);
        assert_eq!(rejected(&[(1.0, 100.0, 0.5)]), Rejected::Undetermined);
    }

    /// The speeds of a true curve with a median of 11 m/s say nothing of it if they end at 6 m/s, and little if they are few
    /// and the curve is flat.
    #[test]
    fn a_median_outside_of_the_samples_is_rejected_with_the_reason() {
        let curve = |ends: std::ops::Range<u32>, samples: u64, dispersion: f64| {
            let truth = |speed: f64| normal::probability(libm::log(speed / 11.0) / dispersion);
            let points: Vec<_> = ends
                .map(|it| [f64::from(it), f64::from(it + 1)])
                .map(|speed| FragilityPoint {
                    speed,
                    samples,
                    probability: None,
                })
                .collect();
            let middle = |it: &FragilityPoint| 0.5 * (it.speed[0] + it.speed[1]);
            let rows: Vec<_> = points
                .iter()
                .map(|it| (middle(it), samples as f64, truth(middle(it))))
                .collect();
            LognormalFit::new(&rows).and_then(|fit| fit.usable(&points))
        };
        let found = curve(2..20, 1000, 0.5).expect("a curve");
        assert!((found.median - 11.0).abs() < 1e-3, "{found:?}");
        let outside = curve(2..6, 1000, 0.5).unwrap_err();
        assert_eq!(outside, Rejected::OutsideSamples { from: 2.0, to: 6.0 });
        assert_eq!(
            outside.to_string(),
            "the samples, 2.0 to 6.0 m/s fast, do not reach a probability of 50 %"
        );
        let few = curve(5..13, 10, 2.0).unwrap_err();
        assert!(
            matches!(few, Rejected::Uncertain { error } if error > 0.25),
            "{few:?}"
        );
    }
}
