//! Parameters by their names, also misspelt and old ones.

use super::parameter::Parameter;
use super::qos_overrides::{QOS_PARAMETERS, qos_row};
use super::sensors::{
    GROUP, PLACEHOLDER, SENSOR_PARAMETERS, full_name, is_sensor_name, sensor_and_row,
};
use super::spelling::{may_be_misspelt, nearest_word};
use super::table::PARAMETERS;

impl Parameter {
    /// The parameter of this name; those of sensors are in [`SENSOR_PARAMETERS`].
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::index_of(name).map(|index| &PARAMETERS[index])
    }

    /// Its index in [`PARAMETERS`].
    pub(super) fn index_of(name: &str) -> Option<usize> {
        PARAMETERS
            .iter()
            .position(|parameter| parameter.name == name)
    }

    /// The names closest to a misspelt one, closest first, at most three.
    ///
    /// A name without its group (`velocity`) is completed to the most likely one (`impact.velocity`).
    #[must_use]
    pub fn nearest(name: &str) -> Vec<&'static str> {
        nearest_names(name, PARAMETERS.iter().map(|parameter| parameter.name))
    }

    /// The parameters of the group of this name, such as `impact`; empty if there is no such group.
    pub fn in_group(group: &str) -> impl Iterator<Item = &'static Self> {
        PARAMETERS.iter().filter(move |parameter| {
            parameter
                .name
                .strip_prefix(group)
                .is_some_and(|rest| rest.starts_with('.'))
        })
    }

    /// The word that replaces a deprecated one; `None` if `word` is not deprecated.
    pub(crate) fn replacement_of(&self, word: &str) -> Option<&'static str> {
        DEPRECATED_WORDS
            .iter()
            .find(|(name, old, _)| *name == self.name && *old == word)
            .map(|(.., new)| *new)
    }
}

/// The row of the table that describes a parameter, whether or not its sensor is declared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Entry<'a> {
    /// Index in [`PARAMETERS`].
    Single(usize),
    /// The sensor, and the index in [`SENSOR_PARAMETERS`].
    OfSensor(&'a str, usize),
    /// The index in [`QOS_PARAMETERS`].
    OfTopic(usize),
}

impl<'a> Entry<'a> {
    pub fn named(name: &'a str) -> Option<Self> {
        match Parameter::index_of(name) {
            Some(index) => Some(Self::Single(index)),
            None => sensor_and_row(name)
                .map(|(sensor, row)| Self::OfSensor(sensor, row))
                .or_else(|| qos_row(name).map(Self::OfTopic)),
        }
    }

    pub fn row(self) -> &'static Parameter {
        match self {
            Self::Single(index) => &PARAMETERS[index],
            Self::OfSensor(_, row) => &SENSOR_PARAMETERS[row],
            Self::OfTopic(row) => &QOS_PARAMETERS[row],
        }
    }
}

/// As [`Parameter::nearest`], and among the parameters of the sensor that a name such as `sensors.top_laser.heigth` contains.
pub(super) fn nearest_with_sensors(name: &str) -> Vec<String> {
    let parts: Vec<_> = name.split(['.', '/']).take(4).collect();
    let of_sensor: Vec<_> = match parts[..] {
        [group, sensor, _] if nearest_word(group, [GROUP].into_iter()).is_some() => {
            let rows = SENSOR_PARAMETERS.iter();
            rows.map(|row| full_name(row, sensor)).collect()
        }
        _ => vec![],
    };
    let single = PARAMETERS.iter().map(|parameter| parameter.name);
    let all = single.chain(of_sensor.iter().map(String::as_str));
    let nearest = nearest_names(name, all).into_iter();
    nearest.map(str::to_owned).collect()
}

/// The parameters of the group of this name, such as `impact` or `sensors.top_laser`; empty if there is no such group.
pub(super) fn members_of(group: &str) -> Vec<String> {
    let of_sensors = |sensor| {
        SENSOR_PARAMETERS
            .iter()
            .map(move |row| full_name(row, sensor))
    };
    let single = Parameter::in_group(group).map(|it| it.name.to_owned());
    match group.strip_prefix(GROUP) {
        Some("") => single.chain(of_sensors(PLACEHOLDER)).collect(),
        Some(rest) => match rest.strip_prefix('.').filter(|it| is_sensor_name(it)) {
            Some(sensor) => of_sensors(sensor).collect(),
            None => single.collect(),
        },
        None => single.collect(),
    }
}

/// The candidates closest to a misspelt name, closest first, at most three.
fn nearest_names<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    if !may_be_misspelt(name) {
        return Vec::new();
    }
    let wanted = name.to_ascii_lowercase().replace('/', ".");
    let wanted_last = wanted.rsplit('.').next().unwrap_or(&wanted);
    let mut ranked: Vec<_> = candidates
        .map(|candidate| {
            let known = candidate.to_ascii_lowercase();
            let whole = strsim::normalized_damerau_levenshtein(&wanted, &known);
            let last = known.rsplit('.').next().unwrap_or(&known);
            // A wrong or missing group weighs less than a wrong name within it.
            let within = 0.9 * strsim::normalized_damerau_levenshtein(wanted_last, last);
            (whole.max(within), candidate)
        })
        .filter(|(score, _)| *score >= 0.6)
        .collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = ranked.first().map_or(0.0, |(score, _)| *score);
    ranked
        .into_iter()
        .take_while(|(score, _)| *score >= best - 0.05)
        .map(|(_, name)| name)
        .take(3)
        .collect()
}

/// Words that are still accepted as values: the parameter, the old word and the one that replaces it.
const DEPRECATED_WORDS: &[(&str, &str, &str)] =
    &[("solver.scheme", "energy", "conserving_midpoint")];
