//! Parameters by their names, also misspelt and old ones.

use super::parameter::Parameter;
use super::spelling::may_be_misspelt;
use super::table::PARAMETERS;

impl Parameter {
    /// The parameter of this name.
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
        if !may_be_misspelt(name) {
            return Vec::new();
        }
        let wanted = name.to_ascii_lowercase().replace('/', ".");
        let mut ranked: Vec<_> = PARAMETERS
            .iter()
            .map(|parameter| {
                let whole = strsim::normalized_damerau_levenshtein(&wanted, parameter.name);
                let last = parameter.name.rsplit('.').next().unwrap_or(parameter.name);
                let wanted_last = wanted.rsplit('.').next().unwrap_or(&wanted);
                // A wrong or missing group weighs less than a wrong name within it.
                let within = 0.9 * strsim::normalized_damerau_levenshtein(wanted_last, last);
                (whole.max(within), parameter.name)
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

/// Words that are still accepted as values: the parameter, the old word and the one that replaces it.
const DEPRECATED_WORDS: &[(&str, &str, &str)] =
    &[("solver.scheme", "energy", "conserving_midpoint")];
