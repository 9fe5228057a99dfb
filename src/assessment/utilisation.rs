//! How close a column has come to yielding.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::column::{HINGES, Report, Sample, WEBS};
use crate::observables::{HINGE_PLACES, WEB_PLACES};

/// The part of the column that has come closest to its strength.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Utilisation {
    /// Which part it is.
    pub part: UtilisedPart,
    /// The share of its strength that was used; 1 where it yields.
    pub value: f64,
}

/// A part of a column that has a strength.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UtilisedPart {
    /// A hinge, by its index: bending moment and normal force.
    Hinge(u8),
    /// The web of a bar, by its index: shear force.
    Web(u8),
}

impl Utilisation {
    /// The largest one of a response.
    #[must_use]
    pub fn of_report(report: &Report) -> Self {
        Self::largest(
            report.hinges.map(|hinge| hinge.max_utilisation),
            report.webs.map(|web| web.max_utilisation),
        )
    }

    /// The largest one at an instant.
    #[must_use]
    pub fn of_sample(sample: &Sample) -> Self {
        Self::largest(
            sample.hinges.map(|hinge| hinge.utilisation),
            sample.webs.map(|web| web.utilisation),
        )
    }

    /// The larger of two.
    #[must_use]
    pub fn or_larger(self, other: Self) -> Self {
        if other.value > self.value {
            other
        } else {
            self
        }
    }

    fn largest(hinges: [f64; HINGES], webs: [f64; WEBS]) -> Self {
        let parts = (0..).map(UtilisedPart::Hinge).zip(hinges);
        let parts = parts.chain((0..).map(UtilisedPart::Web).zip(webs));
        let first = Self {
            part: UtilisedPart::Hinge(0),
            value: 0.0,
        };
        parts
            .map(|(part, value)| Self { part, value })
            .fold(first, Self::or_larger)
    }
}

/// Such as `91 %, bending with normal force at the base (hinge 3)`.
impl Display for Utilisation {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{:.0} %, {}", 100.0 * self.value, self.part)
    }
}

impl Display for UtilisedPart {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (what, place) = match *self {
            Self::Hinge(index) => (
                "bending with normal force",
                HINGE_PLACES.get(usize::from(index)),
            ),
            Self::Web(index) => ("shear of the web", WEB_PLACES.get(usize::from(index))),
        };
        write!(
            f,
            "{what} {}",
            place.map_or("somewhere", |it| it.in_sentence)
        )?;
        match (self, place) {
            (Self::Hinge(_), Some(hinge)) => write!(f, " (hinge {})", hinge.name),
            _ => Ok(()),
        }
    }
}
