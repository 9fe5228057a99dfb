//! The distributions of the inputs: quantiles, moments, limits.

use std::f64::consts::{FRAC_PI_2, SQRT_2};
use std::fmt;

use libm::{erf, exp, expm1, log, log1p};

use super::normal;

/// A distribution with one number of each kind, before it is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Family {
    Fixed(f64),
    Normal {
        mean: f64,
        deviation: f64,
    },
    /// Of the logarithm.
    Lognormal {
        mean: f64,
        deviation: f64,
    },
    Rayleigh {
        scale: f64,
    },
    Uniform {
        from: f64,
        to: f64,
    },
}

/// A distribution, cut at limits where it has any: what lies beyond is not there, and the rest is scaled to a probability of 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    family: Family,
    limits: [f64; 2],
    /// Probabilities of the distribution before it is cut, below its lower and below its upper limit.
    between: [f64; 2],
}

/// Why numbers make no distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct DistributionFault {
    /// Which number.
    pub number: &'static str,
    /// Its value, or the distribution.
    pub found: String,
    /// What is expected instead.
    pub expected: String,
}

impl Distribution {
    /// One value, without scatter.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn fixed(value: f64) -> Result<Self, DistributionFault> {
        finite("value", value)?;
        Ok(Self {
            family: Family::Fixed(value),
            limits: [value, value],
            between: [0.0, 1.0],
        })
    }

    /// The normal distribution with mean and standard deviation, cut at the limits (infinite: none).
    ///
    /// # Errors
    /// A standard deviation that is not positive, limits in the wrong order or that leave next to nothing.
    pub fn normal(mean: f64, deviation: f64, limits: [f64; 2]) -> Result<Self, DistributionFault> {
        finite("mean", mean)?;
        positive("sd", deviation)?;
        Self::cut(Family::Normal { mean, deviation }, limits)
    }

    /// The lognormal distribution with mean and standard deviation of the variable itself, cut at the limits.
    ///
    /// # Errors
    /// As [`normal`](Self::normal), and a mean that is not positive.
    pub fn lognormal(
        mean: f64,
        deviation: f64,
        limits: [f64; 2],
    ) -> Result<Self, DistributionFault> {
        positive("mean", mean)?;
        positive("sd", deviation)?;
        let variance = log1p((deviation / mean).powi(2));
        let family = Family::Lognormal {
            mean: log(mean) - 0.5 * variance,
            deviation: variance.sqrt(),
        };
        Self::cut(family, limits)
    }

    /// The Rayleigh distribution with this mean, cut at the limits. It has one parameter: its standard deviation is 0.5227 times its
    /// mean.
    ///
    /// # Errors
    /// A mean that is not positive, or wrong limits.
    pub fn rayleigh(mean: f64, limits: [f64; 2]) -> Result<Self, DistributionFault> {
        positive("mean", mean)?;
        let scale = mean / FRAC_PI_2.sqrt();
        Self::cut(Family::Rayleigh { scale }, limits)
    }

    /// The uniform distribution between two limits.
    ///
    /// # Errors
    /// Limits that are not finite or in the wrong order.
    pub fn uniform(limits: [f64; 2]) -> Result<Self, DistributionFault> {
        let [from, to] = limits;
        finite("min", from)?;
        finite("max", to)?;
        Self::cut(Family::Uniform { from, to }, limits)
    }

    fn cut(family: Family, limits: [f64; 2]) -> Result<Self, DistributionFault> {
        let [lower, upper] = limits;
        if lower.is_nan() || upper.is_nan() || lower >= upper {
            return Err(DistributionFault {
                number: "min",
                found: format!("{lower} with max {upper}"),
                expected: "a lower limit (min) less than the upper limit (max)".to_owned(),
            });
        }
        let between = limits.map(|limit| family.probability(limit));
        // Inside the limits the quantile needs more of the distribution than rounding leaves of a far tail.
        if between[1] - between[0] < 1e-6 {
            return Err(DistributionFault {
                number: "min",
                found: format!("{lower} to {upper}"),
                expected: "limits that leave at least a millionth of the distribution".to_owned(),
            });
        }
        Ok(Self {
            family,
            limits,
            between,
        })
    }

    /// The same distribution, cut at these limits, too. They must leave at least a millionth of it.
    pub(super) fn within(self, limits: [f64; 2]) -> Result<Self, DistributionFault> {
        match self.family {
            Family::Fixed(_) => Ok(self),
            family => {
                let [lower, upper] = self.limits;
                Self::cut(family, [lower.max(limits[0]), upper.min(limits[1])])
            }
        }
    }

    /// Whether every draw has the same value.
    #[must_use]
    pub fn is_fixed(&self) -> bool {
        matches!(self.family, Family::Fixed(_))
    }

    /// The limits; infinite where there are none. A lognormal or a Rayleigh variable is positive anyway.
    #[must_use]
    pub fn limits(&self) -> [f64; 2] {
        match self.family {
            Family::Lognormal { .. } | Family::Rayleigh { .. } => {
                [self.limits[0].max(0.0), self.limits[1]]
            }
            _ => self.limits,
        }
    }

    /// The value that is not exceeded with the probability `p`, 0 to 1.
    #[must_use]
    pub fn quantile(&self, p: f64) -> f64 {
        let [below, above] = self.between;
        let value = self.family.quantile(below + p * (above - below));
        value.clamp(self.limits[0], self.limits[1])
    }

    /// Probability that the value is at most `x`.
    #[must_use]
    pub fn probability(&self, x: f64) -> f64 {
        let [below, above] = self.between;
        if x < self.limits[0] {
            return 0.0;
        }
        if x >= self.limits[1] {
            return 1.0;
        }
        (self.family.probability(x) - below) / (above - below)
    }

    /// Probability that the value exceeds `x`.
    #[must_use]
    pub fn exceedance(&self, x: f64) -> f64 {
        1.0 - self.probability(x)
    }

    /// The mean of the distribution as cut.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let [below, above] = self.between;
        let share = above - below;
        let [lower, upper] = self.limits;
        match self.family {
            Family::Fixed(value) => value,
            Family::Normal { mean, deviation } => {
                let standard = |x: f64| (x - mean) / deviation;
                mean + deviation
                    * (normal::density(standard(lower)) - normal::density(standard(upper)))
                    / share
            }
            Family::Lognormal { mean, deviation } => {
                let inside = |x: f64| match x <= 0.0 {
                    true => 0.0,
                    false => normal::probability((log(x) - mean) / deviation - deviation),
                };
                exp(mean + 0.5 * deviation * deviation) * (inside(upper) - inside(lower)) / share
            }
            Family::Rayleigh { scale } => {
                let part = |x: f64| {
                    let x = x.max(0.0);
                    let tail = if x.is_finite() {
                        x * exp(-0.5 * (x / scale).powi(2))
                    } else {
                        0.0
                    };
                    scale * FRAC_PI_2.sqrt() * erf(x / scale / SQRT_2) - tail
                };
                (part(upper) - part(lower)) / share
            }
            Family::Uniform { from, to } => 0.5 * (from + to),
        }
    }
}

impl Family {
    fn probability(self, x: f64) -> f64 {
        match self {
            Self::Fixed(value) => f64::from(x >= value),
            Self::Normal { mean, deviation } => normal::probability((x - mean) / deviation),
            Self::Lognormal { .. } | Self::Rayleigh { .. } if x <= 0.0 => 0.0,
            Self::Lognormal { mean, deviation } => normal::probability((log(x) - mean) / deviation),
            Self::Rayleigh { scale } => -expm1(-0.5 * (x / scale).powi(2)),
            Self::Uniform { from, to } => ((x - from) / (to - from)).clamp(0.0, 1.0),
        }
    }

    fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Normal { mean, deviation } => mean + deviation * normal::quantile(p),
            Self::Lognormal { mean, deviation } => exp(mean + deviation * normal::quantile(p)),
            Self::Rayleigh { scale } => scale * (-2.0 * log1p(-p)).sqrt(),
            Self::Uniform { from, to } => from + p * (to - from),
        }
    }
}

fn finite(number: &'static str, value: f64) -> Result<(), DistributionFault> {
    check(number, value, value.is_finite(), "a finite number")
}

fn positive(number: &'static str, value: f64) -> Result<(), DistributionFault> {
    check(
        number,
        value,
        value.is_finite() && value > 0.0,
        "a finite number > 0",
    )
}

fn check(
    number: &'static str,
    value: f64,
    right: bool,
    expected: &str,
) -> Result<(), DistributionFault> {
    match right {
        true => Ok(()),
        false => Err(DistributionFault {
            number,
            found: value.to_string(),
            expected: expected.to_owned(),
        }),
    }
}

/// The distribution in words, such as `lognormal, mean 10, sd 5, from 0 to 216`.
impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |x: f64| {
            let digits = format!("{x:.4e}").parse::<f64>().unwrap_or(x);
            digits.to_string()
        };
        match self.family {
            Family::Fixed(value) => return write!(f, "{}", number(value)),
            Family::Normal { mean, deviation } => {
                write!(f, "normal, mean {}, sd {}", number(mean), number(deviation))?;
            }
            Family::Lognormal { mean, deviation } => {
                let variance = deviation * deviation;
                let mean = exp(mean + 0.5 * variance);
                let deviation = mean * expm1(variance).sqrt();
                write!(
                    f,
                    "lognormal, mean {}, sd {}",
                    number(mean),
                    number(deviation)
                )?;
            }
            Family::Rayleigh { scale } => {
                write!(f, "Rayleigh, mean {}", number(scale * FRAC_PI_2.sqrt()))?;
            }
            Family::Uniform { .. } => write!(f, "uniform")?,
        }
        let [lower, upper] = self.limits;
        // A limit that cuts off less than one draw in a billion is not worth a word.
        let uniform = matches!(self.family, Family::Uniform { .. });
        let cut = [
            uniform || self.between[0] > 1e-9,
            uniform || self.between[1] < 1.0 - 1e-9,
        ];
        match (cut[0], cut[1]) {
            (true, true) => write!(f, ", from {} to {}", number(lower), number(upper)),
            (true, false) => write!(f, ", at least {}", number(lower)),
            (false, true) => write!(f, ", at most {}", number(upper)),
            (false, false) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_LIMITS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Mean and variance by Gauss-Legendre quadrature of the quantile, on intervals that shrink towards both ends.
    fn moments(distribution: &Distribution) -> (f64, f64) {
        const NODES: [(f64, f64); 3] = [
            (-0.774_596_669_241_483_4, 5.0 / 9.0),
            (0.0, 8.0 / 9.0),
            (0.774_596_669_241_483_4, 5.0 / 9.0),
        ];
        let mut edges: Vec<f64> = (0..=400).map(|it| 0.5 * 0.93_f64.powi(it)).collect();
        edges.extend((0..=400).map(|it| 1.0 - 0.5 * 0.93_f64.powi(it)));
        edges.sort_by(f64::total_cmp);
        let (mut mean, mut square) = (0.0, 0.0);
        for pair in edges.windows(2) {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            for (node, weight) in NODES {
                let x = distribution.quantile(middle + half * node);
                mean += weight * half * x;
                square += weight * half * x * x;
            }
        }
        (mean, square - mean * mean)
    }

    #[test]
    fn moments_of_the_uncut_laws_are_those_of_the_textbook() {
        let half_normal = (2.0 / std::f64::consts::PI).sqrt();
        for (distribution, mean, deviation) in [
            (Distribution::normal(3.0, 2.0, NO_LIMITS), 3.0, 2.0),
            (Distribution::lognormal(80.0, 10.0, NO_LIMITS), 80.0, 10.0),
            (Distribution::lognormal(10.0, 5.0, NO_LIMITS), 10.0, 5.0),
            (Distribution::lognormal(4.0, 1.3, NO_LIMITS), 4.0, 1.3),
            // sd of a Rayleigh distribution: sqrt(4/pi - 1) of its mean.
            (
                Distribution::rayleigh(10.0, NO_LIMITS),
                10.0,
                10.0 * (4.0 / std::f64::consts::PI - 1.0).sqrt(),
            ),
            (Distribution::uniform([1.0, 4.0]), 2.5, 3.0 / 12_f64.sqrt()),
            // Half of a normal distribution.
            (
                Distribution::normal(0.0, 1.0, [0.0, f64::INFINITY]),
                half_normal,
                (1.0 - half_normal * half_normal).sqrt(),
            ),
        ] {
            let distribution = distribution.unwrap();
            let (found_mean, found_variance) = moments(&distribution);
            assert!(
                (found_mean - mean).abs() < 2e-4 * deviation,
                "{distribution}: {found_mean}"
            );
            assert!(
                (found_variance.sqrt() / deviation - 1.0).abs() < 2e-3,
                "{distribution}: {found_variance}"
            );
            assert!(
                (distribution.mean() - mean).abs() < 1e-12 * mean.abs().max(1.0),
                "{distribution}: {}",
                distribution.mean()
            );
        }
    }

    #[test]
    fn the_mean_of_a_cut_law_is_the_integral_of_its_quantile() {
        for distribution in [
            Distribution::normal(20e3, 12e3, [12e3, 26e3]),
            Distribution::lognormal(15.0, 6.0, [5.0, 20.0]),
            Distribution::rayleigh(10.0, [2.0, 15.0]),
        ] {
            let distribution = distribution.unwrap();
            let (mean, _) = moments(&distribution);
            assert!(
                (distribution.mean() / mean - 1.0).abs() < 1e-6,
                "{distribution}: {} {mean}",
                distribution.mean()
            );
            let [lower, upper] = distribution.limits();
            for p in [0.0, 0.01, 0.3, 0.5, 0.9, 1.0] {
                let x = distribution.quantile(p);
                assert!((lower..=upper).contains(&x));
                assert!(
                    (distribution.probability(x) - p).abs() < 1e-12,
                    "{distribution}: {p}"
                );
            }
        }
    }

    #[test]
    fn numbers_that_make_no_law_are_named() {
        let number = |distribution: Result<Distribution, DistributionFault>| {
            distribution.unwrap_err().number
        };
        assert_eq!(number(Distribution::normal(1.0, -1.0, NO_LIMITS)), "sd");
        assert_eq!(
            number(Distribution::normal(f64::NAN, 1.0, NO_LIMITS)),
            "mean"
        );
        assert_eq!(number(Distribution::lognormal(0.0, 1.0, NO_LIMITS)), "mean");
        assert_eq!(number(Distribution::lognormal(1.0, 0.0, NO_LIMITS)), "sd");
        assert_eq!(number(Distribution::rayleigh(-10.0, NO_LIMITS)), "mean");
        assert_eq!(number(Distribution::fixed(f64::INFINITY)), "value");
        assert_eq!(number(Distribution::uniform([2.0, 1.0])), "min");
        let reversed = Distribution::normal(1.0, 1.0, [2.0, 1.0]).unwrap_err();
        assert_eq!(reversed.found, "2 with max 1");
        let empty = Distribution::normal(0.0, 1.0, [9.0, 10.0]).unwrap_err();
        assert_eq!(
            empty.expected,
            "limits that leave at least a millionth of the distribution"
        );
    }

    #[test]
    fn laws_in_words() {
        let distribution = Distribution::lognormal(10.0, 5.0, [f64::NEG_INFINITY, 60.0]).unwrap();
        assert_eq!(
            distribution.to_string(),
            "lognormal, mean 10, sd 5, at most 60"
        );
        assert_eq!(Distribution::fixed(3.0).unwrap().to_string(), "3");
    }
}
