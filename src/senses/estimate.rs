//! An estimate: what struck the column and how it ends, with its uncertainty.

use serde::{Deserialize, Serialize};

use crate::assessment::Severity;
use crate::exact_number;

/// A quantity with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CredibleInterval {
    /// Its mean.
    #[serde(with = "exact_number")]
    pub mean: f64,
    /// Lower end of the 90 % interval.
    #[serde(with = "exact_number")]
    pub low: f64,
    /// Upper end of the 90 % interval.
    #[serde(with = "exact_number")]
    pub high: f64,
}

/// An estimate that rests on fewer effective responses is unreliable.
pub const FEWEST_RESPONSES: f64 = 20.0;

/// Probability outside of an interval, on each side.
#[cfg(feature = "study")]
const TAIL: f64 = 0.05;

/// Standard deviations to either end of a 90 % interval of a normal distribution.
#[cfg(feature = "study")]
const TAIL_DEVIATIONS: f64 = 1.645;

impl CredibleInterval {
    /// Of a normal distribution.
    #[cfg(feature = "study")]
    pub(super) fn normal(mean: f64, deviation: f64) -> Self {
        Self {
            mean,
            low: mean - TAIL_DEVIATIONS * deviation,
            high: mean + TAIL_DEVIATIONS * deviation,
        }
    }

    /// Of weighted values; NaN without any. Values that are not finite do not count.
    #[cfg(feature = "study")]
    pub(super) fn of(values: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut values: Vec<(f64, f64)> = values
            .filter(|(value, weight)| value.is_finite() && *weight > 0.0)
            .collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = values.iter().map(|(_, weight)| weight).sum();
        let quantile = |share: f64| {
            let mut sum = 0.0;
            let found = values.iter().find(|(_, weight)| {
                sum += weight / total;
                sum >= share
            });
            found
                .or(values.last())
                .map_or(f64::NAN, |(value, _)| *value)
        };
        let (low, high) = (quantile(TAIL), quantile(1.0 - TAIL));
        let mean = values
            .iter()
            .map(|(value, weight)| value * weight)
            .sum::<f64>()
            / total;
        Self { mean, low, high }
    }
}

/// What struck the column and how it ends, by the data up to an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactEstimate {
    /// Data up to this instant are used \[s\].
    #[serde(with = "exact_number")]
    pub data_until: f64,
    /// Instant of contact \[s\].
    pub contact_time: CredibleInterval,
    /// Mass of the vehicle \[kg\].
    pub mass: CredibleInterval,
    /// Its speed \[m/s\].
    pub velocity: CredibleInterval,
    /// Its momentum \[N s\].
    pub momentum: CredibleInterval,
    /// Correlation of the logarithms of mass and speed.
    #[serde(with = "exact_number")]
    pub mass_velocity_correlation: f64,
    /// Largest `v1`, past or still to come \[m\].
    pub peak_v1: CredibleInterval,
    /// `v1` that remains \[m\]; among the responses after which the column stands.
    pub residual_v1: CredibleInterval,
    /// Probability that the column has yielded.
    #[serde(with = "exact_number")]
    pub yielded: f64,
    /// Probability that it collapses or is torn.
    #[serde(with = "exact_number")]
    pub collapsed: f64,
    /// Remaining axial capacity over that of the virgin column.
    pub capacity_ratio: CredibleInterval,
    /// Probability of each severity, the least severe first.
    #[serde(with = "exact_number::labelled")]
    pub severity: Vec<(Severity, f64)>,
    /// Probabilities of the hypotheses, the most probable first.
    #[serde(with = "exact_number::labelled")]
    pub vehicle_probabilities: Vec<(String, f64)>,
    /// Effective number of responses behind the estimate; below [`FEWEST_RESPONSES`] the intervals are unreliable.
    #[serde(with = "exact_number")]
    pub effective_responses: f64,
    /// Names of the sensors that contradict the others: no response that the others consider plausible explains what they
    /// read. They do not count, unless several are equally suspicious.
    pub doubtful_sensors: Vec<String>,
}
