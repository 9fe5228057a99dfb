//! What a criterion says, and what has to be done if it is exceeded.

use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::parameters::Provenance;

/// `gamma_M` of every resistance: what is left of a column is judged by its characteristic strength, which a limit of 1.5
/// stands beside.
pub const PARTIAL_FACTOR: f64 = 1.0;

/// Unit of a bow over the length to which it belongs.
pub(crate) const PART_OF_LENGTH: &str = "L";

/// What has to be done where a column cannot be assessed.
pub const NOT_ASSESSED: &str = "Act as for EVACUATE, and have an engineer examine the column.";

/// What has to be done, least severe first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// No criterion that decides is exceeded.
    None,
    /// Have an engineer examine the column.
    Inspect,
    /// Keep people away from the column, and additional loads off the part of the building that it carries, until an engineer has
    /// examined it.
    Restrict,
    /// Clear the part of the building that the column carries, and have it shored as an engineer directs.
    Shore,
    /// Clear the part of the building that the column carries; nobody enters it before an engineer allows it.
    Evacuate,
}

/// One criterion with its values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Criterion {
    /// Its name, as in the parameter `assessment.criteria`.
    pub name: &'static str,
    /// What engineers call it: what is compared with the limit, and after a colon what it means to exceed it.
    #[serde(skip)]
    pub title: &'static str,
    /// The cause of the action if it is exceeded, as a part of a sentence.
    #[serde(skip)]
    pub cause: &'static str,
    /// Document and edition, or what the criterion is based on.
    pub edition: &'static str,
    /// Where its limit comes from; the weakest link where several numbers enter.
    pub tag: Provenance,
    /// The value; `None` if it could not be evaluated.
    pub value: Option<f64>,
    /// Its limit; `None` if it could not be evaluated.
    pub limit: Option<f64>,
    /// Unit of both; empty for a ratio.
    pub unit: &'static str,
    /// Distance to the limit, relative to it: positive while the criterion is met, negative when it is exceeded. Where the
    /// limit is 0, the value with its sign reversed. `None` if it could not be evaluated.
    pub margin: Option<f64>,
    /// Whether the criterion is exceeded; `None` if it could not be evaluated.
    pub exceeded: Option<bool>,
    /// Action if it is exceeded.
    pub action: Action,
    /// Whether it decides, by the user's choice.
    pub decides: bool,
    /// What it says, with its numbers, or why it could not be evaluated.
    pub statement: String,
}

impl Criterion {
    /// What is compared with the limit, without what it means to exceed it.
    #[must_use]
    pub fn quantity(&self) -> &'static str {
        self.title.split(": ").next().unwrap_or(self.title)
    }
}

impl Action {
    /// Every action, the least severe first.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Inspect,
        Self::Restrict,
        Self::Shore,
        Self::Evacuate,
    ];

    /// Its name, as messages and files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Inspect => "inspect",
            Self::Restrict => "restrict",
            Self::Shore => "shore",
            Self::Evacuate => "evacuate",
        }
    }

    /// What has to be done, as an imperative that goes on after a colon and ends with a full stop.
    #[must_use]
    pub fn order(self) -> &'static str {
        match self {
            Self::None => "no action follows from these checks.",
            Self::Inspect => "have an engineer examine the column.",
            Self::Restrict => "keep people away from the column, and additional loads off it.",
            Self::Shore => "clear the structure that the column carries, and have it shored.",
            Self::Evacuate => "clear the structure that the column carries, and let nobody in.",
        }
    }
}

impl Display for Action {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A number with its unit: forces in kN, moments in kNm, bows as parts of a length, otherwise three significant digits.
pub(super) fn quantity(value: f64, unit: &str) -> String {
    if unit == PART_OF_LENGTH {
        return match value {
            value if value > 0.0 && value.is_finite() => match 1.0 / value {
                part if part >= 1e4 => "less than L/10000".to_owned(),
                part => format!("L/{part:.0}"),
            },
            0.0 => "0".to_owned(),
            _ => "not a number".to_owned(),
        };
    }
    let (value, unit) = if unit == "N" {
        (value / 1e3, "kN")
    } else if unit == "N m" {
        (value / 1e3, "kNm")
    } else {
        (value, unit)
    };
    let size = value.abs();
    let decimals = match size {
        _ if size == 0.0 || !size.is_finite() => 0,
        _ if size >= 99.95 => 0,
        _ if size >= 9.995 => 1,
        _ if size >= 0.9995 => 2,
        _ if size >= 0.0001 => 4,
        _ => 6,
    };
    let space = if unit.is_empty() { "" } else { " " };
    format!("{value:.decimals$}{space}{unit}")
}
