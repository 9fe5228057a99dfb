//! Distributions as files and command lines give them, checked against what each input may be.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::distribution::{Distribution, DistributionFault};
use crate::parameters::Provenance;

/// A distribution with its provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// The distribution.
    pub distribution: Distribution,
    /// Whether the distribution follows from the steel of the column, for which [`super::Scenario::for_column`] replaces it.
    pub of_steel: bool,
    /// Where its numbers come from; `None` for those of a user who gives none.
    pub tag: Option<Provenance>,
    /// The source, or the reason.
    pub source: String,
}

/// What an entry with a distribution may be; the rest is cut away by its definition.
pub(super) struct Definition {
    pub name: &'static str,
    /// Smallest and largest value that the distribution may give.
    pub range: [f64; 2],
    unit: &'static str,
    /// Whether it may have only one value.
    constant: bool,
}

/// Every distribution of a scenario, in the order of the fields.
pub(super) const DISTRIBUTIONS: [Definition; 8] = [
    distribution("speed_km_h", [0.0, MAX_SPEED_KM_H], "km/h"),
    distribution("angle_deg", [0.0, 90.0], "degrees"),
    distribution("deceleration_m_s2", [0.0, f64::INFINITY], "m/s2"),
    distribution("distance_m", [0.0, f64::INFINITY], "m"),
    constant("encroachment_rate_per_m", [0.0, 1.0], "1/m"),
    constant("hit_width_m", [0.0, 100.0], "m"),
    distribution(YIELD_STRENGTH, [1e-3, 100.0], "-"),
    distribution("top_load_factor", [0.0, 100.0], "-"),
];

/// The angle from the road to the plane of the web, which a scenario need not have; between the road and its web a column may stand in
/// any direction.
pub(super) const ORIENTATION: Definition =
    distribution("orientation_deg", [-180.0, 180.0], "degrees");

/// The largest speed that a vehicle may have \[km/h\]: that of the parameter `impact.velocity`.
const MAX_SPEED_KM_H: f64 = 216.0;

/// The name of the distribution of the yield strength of a rolled section over its nominal one, by the JCSS Probabilistic Model Code,
/// part 3, "Static properties of structural steel".
const JCSS_STEEL: &str = "jcss_steel";
/// The input that may have this distribution.
const YIELD_STRENGTH: &str = "yield_strength_factor";
/// `u`: the nominal value is so many logarithmic standard deviations away from the mean; of the range from -1.5 to -2 the end
/// with the lower mean.
const STEEL_FRACTILE: f64 = -1.5;
/// `v`: coefficient of variation.
const STEEL_VARIATION: f64 = 0.07;
/// `C`: from the yield strength of usual mill tests to the static one \[Pa\].
const STEEL_STATIC: f64 = 20e6;
/// The distribution that stands for an unknown steel is that of S355.
const USUAL_STEEL: f64 = 355e6;

/// `f_y exp(-u v) - C` over `f_y`, with a coefficient of variation `v`, for a nominal strength \[Pa\]. The factor 1.05 of webs is
/// left out, which is on the safe side. `C` takes at most a tenth of the nominal strength, for steels below all grades.
///
/// # Errors
/// None for a positive strength.
pub(super) fn jcss_steel(nominal: f64) -> Result<Distribution, DistributionFault> {
    let reduction = STEEL_STATIC.min(0.1 * nominal);
    let mean = libm::exp(-STEEL_FRACTILE * STEEL_VARIATION) - reduction / nominal;
    let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
    Distribution::lognormal(mean, STEEL_VARIATION * mean, unlimited)
}

pub(super) const MASS: Definition = distribution("mass_kg", [1e-3, 1e6], "kg");
pub(super) const FORCE_FACTOR: Definition = distribution("force_factor", [1e-3, 100.0], "-");

const fn distribution(name: &'static str, range: [f64; 2], unit: &'static str) -> Definition {
    Definition {
        name,
        range,
        unit,
        constant: false,
    }
}

const fn constant(name: &'static str, range: [f64; 2], unit: &'static str) -> Definition {
    Definition {
        name,
        range,
        unit,
        constant: true,
    }
}

/// A distribution as files have it.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InputRow {
    distribution: String,
    value: Option<f64>,
    mean: Option<f64>,
    sd: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    tag: Option<Provenance>,
    #[serde(default)]
    source: String,
}

/// Entry, what was found, what is expected.
pub(super) type Wrong = (String, String, String);

impl InputRow {
    /// The notation of a command line; the error is what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let distribution = parts.next().unwrap_or_default().trim().to_owned();
        let numbers: Result<Vec<f64>, _> = parts.map(|part| part.trim().parse::<f64>()).collect();
        let numbers = numbers
            .map_err(|_| "numbers after the distribution, separated by colons".to_owned())?;
        let mut row = Self {
            distribution,
            source: "given on the command line".to_owned(),
            ..Self::default()
        };
        let (places, form): (&mut [&mut Option<f64>], _) = match row.distribution.as_str() {
            "fixed" => (&mut [&mut row.value], "fixed:VALUE"),
            "normal" | "lognormal" => (
                &mut [&mut row.mean, &mut row.sd, &mut row.min, &mut row.max],
                "normal:MEAN:SD or lognormal:MEAN:SD, with :MIN:MAX where it is cut",
            ),
            "rayleigh" => (
                &mut [&mut row.mean, &mut row.min, &mut row.max],
                "rayleigh:MEAN, with :MIN:MAX where it is cut",
            ),
            "uniform" => (&mut [&mut row.min, &mut row.max], "uniform:MIN:MAX"),
            JCSS_STEEL if numbers.is_empty() => return Ok(row),
            _ => {
                return Err(
                    "a distribution: fixed, normal, lognormal, rayleigh or uniform".to_owned(),
                );
            }
        };
        let required = match places.len() {
            4 => 2,
            3 => 1,
            all => all,
        };
        if numbers.len() != required && numbers.len() != places.len() {
            return Err(form.to_owned());
        }
        for (place, number) in places.iter_mut().zip(numbers) {
            **place = Some(number);
        }
        Ok(row)
    }

    fn distribution(&self) -> Result<Distribution, DistributionFault> {
        let wrong = |number, found: &str, expected: &str| DistributionFault {
            number,
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        let given = |number: &'static str, value: Option<f64>| {
            value.ok_or_else(|| {
                wrong(
                    number,
                    "nothing",
                    &format!(
                        "a number, as the distribution {} needs it",
                        self.distribution
                    ),
                )
            })
        };
        let absent = |numbers: &[(&'static str, Option<f64>)]| match numbers
            .iter()
            .find(|it| it.1.is_some())
        {
            Some((number, Some(value))) => Err(wrong(
                number,
                &value.to_string(),
                &format!(
                    "nothing: the distribution {} has no such number",
                    self.distribution
                ),
            )),
            _ => Ok(()),
        };
        let limits = [
            self.min.unwrap_or(f64::NEG_INFINITY),
            self.max.unwrap_or(f64::INFINITY),
        ];
        let (value, mean, sd) = (("value", self.value), ("mean", self.mean), ("sd", self.sd));
        match self.distribution.as_str() {
            "fixed" => {
                absent(&[mean, sd, ("min", self.min), ("max", self.max)])?;
                Distribution::fixed(given("value", self.value)?)
            }
            "normal" => {
                absent(&[value])?;
                Distribution::normal(given("mean", self.mean)?, given("sd", self.sd)?, limits)
            }
            "lognormal" => {
                absent(&[value])?;
                Distribution::lognormal(given("mean", self.mean)?, given("sd", self.sd)?, limits)
            }
            "rayleigh" => {
                absent(&[value, sd])?;
                Distribution::rayleigh(given("mean", self.mean)?, limits)
            }
            JCSS_STEEL => {
                absent(&[value, mean, sd, ("min", self.min), ("max", self.max)])?;
                jcss_steel(USUAL_STEEL)
            }
            "uniform" => {
                absent(&[value, mean, sd])?;
                Distribution::uniform([given("min", self.min)?, given("max", self.max)?])
            }
            other => Err(wrong(
                "distribution",
                other,
                "fixed, normal, lognormal, rayleigh or uniform",
            )),
        }
    }
}

impl Definition {
    pub fn input(&self, json: &Json) -> Result<Input, Wrong> {
        let row: InputRow = serde_json::from_value(json.clone()).map_err(|wrong| {
            (
                self.name.to_owned(),
                wrong.to_string(),
                "a distribution as in config/risk.json".to_owned(),
            )
        })?;
        self.check(&row)
    }

    pub fn check(&self, row: &InputRow) -> Result<Input, Wrong> {
        let distribution = row.distribution().map_err(|fault| {
            (
                format!("{}.{}", self.name, fault.number),
                fault.found,
                fault.expected,
            )
        })?;
        let of_steel = row.distribution == JCSS_STEEL;
        if of_steel && self.name != YIELD_STRENGTH {
            let expected =
                format!("another distribution: {JCSS_STEEL} is that of {YIELD_STRENGTH}");
            return Err((
                format!("{}.distribution", self.name),
                row.distribution.clone(),
                expected,
            ));
        }
        let [lowest, highest] = self.range;
        // A distribution that leaves the range only with one draw in a billion is cut there; another one is a mistake.
        let [lower, upper] = [1e-9, 1.0 - 1e-9].map(|level| distribution.quantile(level));
        if lower < lowest || upper > highest {
            let found = format!("{distribution}");
            let range = match highest.is_finite() {
                true => format!("from {lowest} to {highest} {}", self.unit),
                false => format!("not below {lowest} {}", self.unit),
            };
            return Err((
                self.name.to_owned(),
                found,
                format!("values {range}; cut the distribution with min and max"),
            ));
        }
        let unlimited = distribution.to_string();
        let distribution = distribution
            .within(self.range)
            .map_err(|fault| (self.name.to_owned(), unlimited, fault.expected))?;
        if self.constant && !distribution.is_fixed() {
            return Err((
                self.name.to_owned(),
                format!("{distribution}"),
                "one value: distribution fixed".to_owned(),
            ));
        }
        Ok(Input {
            distribution,
            of_steel,
            tag: row.tag,
            source: row.source.clone(),
        })
    }
}

/// A distribution and its provenance, for programs.
impl Serialize for Input {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Row<'a> {
            distribution: String,
            tag: Option<Provenance>,
            source: &'a str,
        }
        Row {
            distribution: self.distribution.to_string(),
            tag: self.tag,
            source: &self.source,
        }
        .serialize(serializer)
    }
}
