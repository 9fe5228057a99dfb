//! An estimate: what struck the column and how it ends, with its uncertainty.

use serde::{Deserialize, Serialize};

use crate::assessment::Action;
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

/// An estimate with a smaller effective sample size is unreliable.
pub const FEWEST_RESPONSES: f64 = 20.0;

/// Ratio of the ends of an interval of the mass beyond which the mass is not known: about half of the width, in logarithms, of the
/// interval before anything is measured.
pub const MASS_OPEN_BEYOND: f64 = 5.0;

/// The same of the speed.
pub const VELOCITY_OPEN_BEYOND: f64 = 3.5;

/// The same of the momentum.
pub const MOMENTUM_OPEN_BEYOND: f64 = 8.0;

/// Probability of a collapse from which on an estimate tells it \[A\].
pub const COLLAPSE_TOLD_FROM: f64 = 0.9;

/// The same from which on a collapse is possible \[A\], and the next estimate follows soon.
const COLLAPSE_POSSIBLE_FROM: f64 = 0.01;

/// Probability outside of an interval, on each side.
const TAIL: f64 = 0.05;

/// Standard deviations to either end of a 90 % interval of a normal distribution.
const TAIL_DEVIATIONS: f64 = 1.645;

/// Ten equal shares of the standard normal distribution. The outermost ones are the ends of its 90 % interval; the others are the
/// quantiles at the middles of their shares, stretched so that all have its variance.
const QUANTILES: [f64; 10] = [
    -TAIL_DEVIATIONS,
    -1.206_30,
    -0.785_04,
    -0.448_47,
    -0.146_26,
    0.146_26,
    0.448_47,
    0.785_04,
    1.206_30,
    TAIL_DEVIATIONS,
];

/// A weighted value with its own standard deviation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    pub mean: f64,
    pub deviation: f64,
    pub weight: f64,
}

impl CredibleInterval {
    /// Of a normal distribution.
    pub(crate) fn normal(mean: f64, deviation: f64) -> Self {
        Self {
            mean,
            low: mean - TAIL_DEVIATIONS * deviation,
            high: mean + TAIL_DEVIATIONS * deviation,
        }
    }

    /// Standard deviations of the normal distribution whose interval this is by which a value is above its mean.
    pub(crate) fn deviations(&self, value: f64) -> f64 {
        TAIL_DEVIATIONS * (value - self.mean) / (self.high - self.mean)
    }

    /// Whether the ratio of its ends is larger than this one, so that it leaves a positive quantity open.
    #[must_use]
    pub fn is_open(&self, beyond: f64) -> bool {
        let is_narrow = self.high <= beyond * self.low;
        // An interval without numbers says nothing.
        !is_narrow
    }

    /// With its mean and its ends as this increasing function gives them.
    pub(crate) fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self {
            mean: of(self.mean),
            low: of(self.low),
            high: of(self.high),
        }
    }

    /// Of weighted values that are themselves uncertain, of which so many are effective; NaN without any. Values that are not
    /// finite do not count.
    ///
    /// The fewer they are, the less they show how far apart the values are that were not computed: each of them stands for a
    /// distribution about it that is wider by the variance of their mean.
    pub(crate) fn of_spread(mut values: Vec<Spread>, effective: f64) -> Self {
        widen(&mut values, effective);
        let each = values
            .iter()
            .flat_map(|it| QUANTILES.map(|z| (it.mean + it.deviation * z, it.weight)));
        Self::of(each)
    }

    /// Of weighted values; NaN without any. Values that are not finite do not count.
    pub(crate) fn of(values: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut values: Vec<(f64, f64)> = values
            .filter(|(value, weight)| value.is_finite() && *weight > 0.0)
            .collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total = values.iter().fold(0.0, |sum, (_, weight)| sum + weight);
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

/// Lets each value stand for a distribution about it that is wider by the variance of the mean of all of them, of which so many are
/// effective. Values that are not finite, or have no weight, are dropped.
fn widen(values: &mut Vec<Spread>, effective: f64) {
    values.retain(|it| it.mean.is_finite() && it.weight > 0.0);
    let sum = |of: &dyn Fn(&Spread) -> f64| values.iter().fold(0.0, |sum, it| sum + of(it));
    let total = sum(&|it| it.weight);
    let mean = sum(&|it| it.weight * it.mean) / total;
    let variance = sum(&|it| it.weight * (it.mean - mean) * (it.mean - mean)) / total;
    let others = effective - 1.0;
    // One response may stand for values far apart. Their variance is not the one between responses then, but no mean is off by more than
    // the range of all values.
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [least, most] = values.iter().fold(ends, |[least, most], it| {
        [least.min(it.mean), most.max(it.mean)]
    });
    let of_few = match others > 0.0 {
        true => (variance / others).min((most - least) * (most - least)),
        false => 0.0,
    };
    for value in values {
        value.deviation = (value.deviation * value.deviation + of_few).sqrt();
    }
}

/// The share of the distribution of [`CredibleInterval::of_spread`] that is below a number; NaN without any value.
pub(crate) fn share_below(mut values: Vec<Spread>, effective: f64, number: f64) -> f64 {
    widen(&mut values, effective);
    let total = values.iter().fold(0.0, |sum, it| sum + it.weight);
    let each = values.iter().map(|it| {
        let z = (number - it.mean) / it.deviation;
        it.weight * 0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
    });
    each.fold(0.0, |sum, it| sum + it) / total
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
    /// Peak `v1`, past or still to come \[m\].
    pub peak_v1: CredibleInterval,
    /// `v1` that remains \[m\]; among the responses after which the column stands.
    pub residual_v1: CredibleInterval,
    /// Probability that the column has yielded.
    #[serde(with = "exact_number")]
    pub yielded: f64,
    /// Probability that it collapses or is fractured.
    #[serde(with = "exact_number")]
    pub collapsed: f64,
    /// Residual axial capacity over that of the undamaged column.
    pub capacity_ratio: CredibleInterval,
    /// Probability of each action, the least severe first.
    #[serde(with = "exact_number::labelled")]
    pub action: Vec<(Action, f64)>,
    /// Probabilities of the hypotheses, the most probable first: that the front presses like that of a vehicle, and not that it is this
    /// vehicle.
    #[serde(with = "exact_number::labelled")]
    pub vehicle_probabilities: Vec<(String, f64)>,
    /// Effective number of responses behind the estimate; below [`FEWEST_RESPONSES`] the intervals are unreliable.
    #[serde(with = "exact_number")]
    pub effective_sample_size: f64,
    /// Names of the sensors that are in doubt. No response that the others consider plausible explains what they read: then they do not
    /// count, unless several are equally suspicious. Or the others contradict their scale, they have failed, their readings stray from
    /// what is predicted for them, or a displacement rises on after the end of the impact: then what they read, or have read, counts.
    pub doubtful_sensors: Vec<String>,
    /// Names of the sensors of displacement on whose scale the peak rests, and which no other sensor of this impact confirms: an error of
    /// 30 % may be unnoticed. They are not in doubt.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scale_not_confirmed: Vec<String>,
    /// Whether mass, speed and momentum are those of a rigid vehicle that explains all readings by the fibre beam; otherwise they are those of
    /// the two bars.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub vehicle_by_beam: bool,
}

impl ImpactEstimate {
    /// Whether it tells that the column collapses or is fractured: the probability is [`COLLAPSE_TOLD_FROM`] or more.
    #[must_use]
    pub fn tells_collapse(&self) -> bool {
        self.collapsed >= COLLAPSE_TOLD_FROM
    }

    /// Whether a collapse is possible, but not told yet.
    pub(crate) fn expects_collapse(&self) -> bool {
        (COLLAPSE_POSSIBLE_FROM..COLLAPSE_TOLD_FROM).contains(&self.collapsed)
    }

    /// That sensors are in doubt, as sentences; `None` where none is.
    #[must_use]
    pub fn doubt_in_words(&self) -> Option<String> {
        let names = self.doubtful_sensors.join(", ");
        (!names.is_empty()).then(|| {
            format!(
                "In doubt: {names}. Such a sensor contradicts the others, is not as declared, is cut off or has stopped; check its scale, range, \
                 sign, position and data."
            )
        })
    }

    /// What a reader of the estimate has to know beside its numbers, each as sentences.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let of_model = self.model_in_words().map(str::to_owned);
        self.scale_reservation().into_iter().chain(of_model)
    }

    /// Which model the vehicle is by, where it is not the two bars, as a sentence.
    fn model_in_words(&self) -> Option<&'static str> {
        self.vehicle_by_beam.then_some(
            "Mass, speed and momentum belong to a rigid vehicle that explains all readings by the fibre beam. Peak, residual displacement and \
             capacity follow from the two bars.",
        )
    }

    /// What the peak rests on that no sensor confirms, as sentences; `None` where the sensors confirm each other.
    #[must_use]
    pub fn scale_reservation(&self) -> Option<String> {
        let names = self.scale_not_confirmed.join(", ");
        (!names.is_empty()).then(|| {
            format!(
                "The peak rests on the scale of {names}. In this impact, no other sensor confirms it: an error of gain or height, or a filter, \
                 that changes the readings by 30 % may be unnoticed. Check the sensors with `column-twin sensors check`."
            )
        })
    }

    /// Quantities of the vehicle that the data do not tell, by their names: `mass`, `velocity`, `momentum`. Their intervals are wider
    /// than about half of those before anything is measured.
    #[must_use]
    pub fn not_known(&self) -> Vec<&'static str> {
        let all = [
            ("mass", &self.mass, MASS_OPEN_BEYOND),
            ("velocity", &self.velocity, VELOCITY_OPEN_BEYOND),
            ("momentum", &self.momentum, MOMENTUM_OPEN_BEYOND),
        ];
        let open = all
            .into_iter()
            .filter(|(_, of, beyond)| of.is_open(*beyond));
        open.map(|(name, ..)| name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(mean: f64, deviation: f64, weight: f64) -> Spread {
        Spread {
            mean,
            deviation,
            weight,
        }
    }

    #[test]
    fn the_interval_of_one_value_is_that_of_its_own_normal_law() {
        let one = CredibleInterval::of_spread(vec![spread(2.0, 0.1, 1.0)], 1.0);
        assert!((one.low - (2.0 - 0.1645)).abs() < 1e-9, "{one:?}");
        assert!((one.high - (2.0 + 0.1645)).abs() < 1e-9, "{one:?}");
        assert!((one.mean - 2.0).abs() < 1e-12, "{one:?}");
    }

    /// The interval of a normal law that is represented by the middles of equal shares of it.
    #[test]
    fn the_interval_of_many_values_is_that_of_their_law_with_their_own() {
        let count = 400;
        let each = |k: i32| {
            let z = normal_quantile((f64::from(k) + 0.5) / f64::from(count));
            spread(5.0 + 0.3 * z, 0.4, 1.0)
        };
        let many = CredibleInterval::of_spread((0..count).map(each).collect(), f64::from(count));
        // sqrt(0.3^2 + 0.4^2) = 0.5; ten points for a normal law leave 1 or 2 %.
        assert!((many.high - (5.0 + 0.5 * 1.645)).abs() < 0.02, "{many:?}");
        assert!((many.low - (5.0 - 0.5 * 1.645)).abs() < 0.02, "{many:?}");
    }

    #[test]
    fn a_dominating_value_does_not_hide_how_far_the_next_one_is() {
        let values = vec![spread(1.0, 0.03, 0.98), spread(2.0, 0.03, 0.02)];
        let effective = 1.0 / (0.98_f64.powi(2) + 0.02_f64.powi(2));
        let of_two = CredibleInterval::of_spread(values, effective);
        assert!(of_two.high > 1.5, "{of_two:?}");
        // Values that are no numbers do not count.
        let values = vec![spread(f64::NAN, 0.1, 0.5), spread(1.0, 0.1, 0.5)];
        let one = CredibleInterval::of_spread(values, 1.0);
        assert!((one.mean - 1.0).abs() < 1e-12);
        assert!(CredibleInterval::of_spread(Vec::new(), 1.0).mean.is_nan());
    }

    /// The momentum of one response to a vehicle that had not stopped had an interval up to 1e68 times the truth: its values are far apart,
    /// and the number of effective responses was hardly more than one.
    #[test]
    fn one_response_that_leaves_a_quantity_open_does_not_leave_everything_open() {
        let values = || vec![spread(1.0, 0.1, 0.5), spread(4.0, 0.1, 0.5)];
        let open = CredibleInterval::of_spread(values(), 1.0 + 1e-6);
        let widest = 3.0 * (TAIL_DEVIATIONS + 1.0);
        assert!(
            open.low > 1.0 - widest && open.high < 4.0 + widest,
            "{open:?}"
        );
    }

    /// Quantile of the standard normal distribution, by halving an interval of its distribution function.
    fn normal_quantile(share: f64) -> f64 {
        let below = |z: f64| 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
        let (mut low, mut high) = (-8.0, 8.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match below(middle) < share {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}
