//! The domains that documents are valid for.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Highest domain with valid port numbers (RTPS 9.6.1.1).
pub const MAX_DOMAIN_ID: u16 = 232;

/// Ranges of domains that documents are valid for, in the order given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DomainRanges(Vec<RangeInclusive<u16>>);

/// A text does not name domains.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}`: expected domains from 0 to {MAX_DOMAIN_ID}, such as 0, 0-9 or 3,7-9, with the lower end of a range first"
)]
pub struct DomainRangesError(String);

impl From<u16> for DomainRanges {
    fn from(id: u16) -> Self {
        Self(vec![id..=id])
    }
}

impl FromIterator<RangeInclusive<u16>> for DomainRanges {
    /// From ranges as a document holds them.
    fn from_iter<T: IntoIterator<Item = RangeInclusive<u16>>>(ranges: T) -> Self {
        Self(ranges.into_iter().collect())
    }
}

impl FromStr for DomainRanges {
    type Err = DomainRangesError;

    fn from_str(text: &str) -> Result<Self, DomainRangesError> {
        let wrong = || DomainRangesError(text.chars().take(40).collect());
        let id = |text: &str| {
            let id = text.trim().parse().ok().filter(|id| *id <= MAX_DOMAIN_ID);
            id.ok_or_else(wrong)
        };
        let range = |part: &str| {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            let (first, last) = (id(first)?, id(last)?);
            (first <= last).then_some(first..=last).ok_or_else(wrong)
        };
        text.split(',')
            .map(range)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

impl fmt::Display for DomainRanges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, range) in self.0.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            match (range.start(), range.end()) {
                (first, last) if first == last => write!(f, "{comma}{first}")?,
                (first, last) => write!(f, "{comma}{first}-{last}")?,
            }
        }
        Ok(())
    }
}

impl DomainRanges {
    /// Whether the documents are valid in this domain.
    #[must_use]
    pub fn contain(&self, id: u16) -> bool {
        self.0.iter().any(|range| range.contains(&id))
    }

    /// The ranges.
    #[must_use]
    pub fn ranges(&self) -> &[RangeInclusive<u16>] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn domains_are_read_and_written() {
        for text in ["0", "0-9", "3,7-9,232"] {
            let domains: DomainRanges = text.parse().expect(text);
            assert_eq!(domains.to_string(), text);
        }
        let domains: DomainRanges = " 3 , 7 - 9 ".parse().expect("blanks are allowed");
        assert!(domains.contain(3) && domains.contain(8) && !domains.contain(10));
        for wrong in ["", "233", "9-0", "-1", "1-", "1,,2", "a", "0-9-12", "1.0"] {
            let error = wrong.parse::<DomainRanges>().expect_err(wrong).to_string();
            assert!(error.contains("from 0 to 232"), "{error}");
        }
    }
}
