//! Probabilities with confidence intervals, from counts.

use serde::Serialize;

use super::normal;
use super::tally::{Cell, LEVELS};
use crate::assessment::Action;

/// A probability with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval; greater than 0 where no event was seen, too.
    pub high: f64,
}

/// The two-sided normal quantile of a confidence level, such as 1.96 for 0.95.
pub(super) fn deviations(confidence: f64) -> f64 {
    normal::quantile(0.5 + 0.5 * confidence)
}

/// The score interval of Wilson for `events` of `trials`, `z` standard deviations wide on either side: for no event of n it
/// is 0 to about z^2/n. Without a trial nothing is known: 0 to 1.
pub(super) fn wilson(events: u64, trials: u64, z: f64) -> Estimate {
    if trials == 0 {
        return Estimate {
            value: 0.0,
            low: 0.0,
            high: 1.0,
        };
    }
    let (n, p) = (trials as f64, events as f64 / trials as f64);
    let square = z * z / n;
    let centre = (p + 0.5 * square) / (1.0 + square);
    let half = z / (1.0 + square) * ((p * (1.0 - p) + 0.25 * square) / n).sqrt();
    // At the ends rounding leaves next to nothing of a difference that is 0.
    let low = if events == 0 {
        0.0
    } else {
        (centre - half).max(0.0)
    };
    let high = if events == trials {
        1.0
    } else {
        (centre + half).min(1.0)
    };
    Estimate {
        value: p,
        low,
        high,
    }
}

impl Cell {
    /// Probability of this action or a higher one.
    ///
    /// The share of samples that reach it, a prediction taken for the truth, plus the share of predictions that are too low,
    /// minus the share of those that are too high; the audit samples of each class of doubt measure both. Each of these
    /// shares has a Wilson interval. Their sum has the interval of Zou and Donner (2008, "MOVER"): its distances from the
    /// estimate are the root of the sum of squares of theirs.
    pub(super) fn at_least(&self, action: Action, z: f64) -> Estimate {
        self.at_least_of(self.impacts(), action, z)
    }

    /// The same as a share of `all` impacts, to which those of the cell belong.
    pub(super) fn at_least_of(&self, all: u64, action: Action, z: f64) -> Estimate {
        let from = action as usize;
        if all == 0 {
            return Estimate {
                value: 0.0,
                low: 0.0,
                high: 1.0,
            };
        }
        let reached = |levels: &[u64; LEVELS]| levels[from..].iter().sum::<u64>();
        let predicted: u64 = self.predicted.iter().map(|it| reached(&it.all)).sum();
        let plain = wilson(reached(&self.computed) + predicted, all, z);
        let (mut value, mut below, mut above) = (
            plain.value,
            (plain.value - plain.low).powi(2),
            (plain.high - plain.value).powi(2),
        );
        for of_doubt in &self.predicted {
            // Predictions on one side of the action, of which the audit samples on the other side are wrong.
            let correction = |own: std::ops::Range<usize>, other: std::ops::Range<usize>| {
                let predicted: u64 = of_doubt.all[own.clone()].iter().sum();
                let audit_samples = &of_doubt.audited[own];
                let checked: u64 = audit_samples.iter().flatten().sum();
                let wrong: u64 = audit_samples
                    .iter()
                    .flat_map(|row| &row[other.clone()])
                    .sum();
                wilson(wrong, checked, z).times(predicted as f64 / all as f64)
            };
            let missed = correction(0..from, from..LEVELS);
            let excess = correction(from..LEVELS, 0..from);
            value += missed.value - excess.value;
            below += (missed.value - missed.low).powi(2) + (excess.high - excess.value).powi(2);
            above += (missed.high - missed.value).powi(2) + (excess.value - excess.low).powi(2);
        }
        let [below, above] = [below, above].map(f64::sqrt);
        Estimate {
            value: value.clamp(0.0, 1.0),
            low: (value - below).clamp(0.0, 1.0),
            high: (value + above).clamp(0.0, 1.0),
        }
    }
}

impl Estimate {
    /// Each number times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        self.map(|it| it * factor)
    }

    /// Each number through an increasing function.
    #[must_use]
    pub fn map(self, function: impl Fn(f64) -> f64) -> Self {
        Self {
            value: function(self.value),
            low: function(self.low),
            high: function(self.high),
        }
    }

    /// The product with an independent estimate. Where both are positive, the relative distances of the ends of the interval
    /// are the roots of the sums of squares of those of the factors; otherwise the ends are the products of the ends, which
    /// is on the safe side.
    #[must_use]
    pub fn product(self, other: Self) -> Self {
        let value = self.value * other.value;
        if value <= 0.0 {
            return Self {
                value,
                low: 0.0,
                high: self.high * other.high,
            };
        }
        let relative = |end: fn(&Self) -> f64| {
            let distance = |it: &Self| end(it) / it.value - 1.0;
            libm::hypot(distance(&self), distance(&other))
        };
        Self {
            value,
            low: (value * (1.0 - relative(|it| it.low))).max(0.0),
            high: value * (1.0 + relative(|it| it.high)),
        }
    }

    /// Whether a value is in the interval.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wilson's intervals in Newcombe (1998), Statistics in Medicine 17, table I, method 3: 81/263, 15/148, 0/20, 1/29.
    #[test]
    fn wilson_intervals_of_the_literature() {
        let z = deviations(0.95);
        for (events, trials, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let found = wilson(events, trials, z);
            assert!((found.low - low).abs() < 6e-5, "{found:?}");
            assert!((found.high - high).abs() < 6e-5, "{found:?}");
        }
    }

    #[test]
    fn no_event_is_no_probability_of_zero() {
        let mut cell = Cell::default();
        cell.computed[0] = 1000;
        let estimate = cell.at_least(Action::Shore, deviations(0.9));
        assert_eq!((estimate.value, estimate.low), (0.0, 0.0));
        // The rule of three gives 3 of 1000 for a one-sided bound of 95 %.
        assert!((estimate.high - 2.7e-3).abs() < 1e-4, "{estimate:?}");
        let none = Cell::default().at_least(Action::Shore, 2.0);
        assert_eq!((none.low, none.high), (0.0, 1.0));
    }

    /// Wrong predictions that the audit samples find correct the estimate; predictions without an audit sample widen the interval to all
    /// of them.
    #[test]
    fn controls_correct_predictions() {
        let mut cell = Cell::default();
        cell.predicted[2].all = [9000, 0, 0, 0, 1000];
        let z = deviations(0.95);
        let unchecked = cell.at_least(Action::Evacuate, z);
        assert_eq!((unchecked.value, unchecked.high), (0.1, 1.0));
        assert_eq!(unchecked.low, 0.0);
        cell.predicted[2].audited[0][0] = 450;
        cell.predicted[2].audited[0][4] = 0;
        cell.predicted[2].audited[4][4] = 50;
        let right = cell.at_least(Action::Evacuate, z);
        assert!(
            right.value == 0.1 && right.low > 0.08 && right.high < 0.11,
            "{right:?}"
        );
        cell.predicted[2].audited[0][0] = 441;
        cell.predicted[2].audited[0][4] = 9;
        let corrected = cell.at_least(Action::Evacuate, z);
        assert!((corrected.value - (0.1 + 0.9 * 9.0 / 450.0)).abs() < 1e-12);
        assert!(corrected.high > right.high);
    }
}
