//! Why a text does not describe an axis of a map.

use crate::parameters::VehicleFault;

/// Most cells of a map, and most points of an axis.
pub const MAX_CELLS: u64 = 100_000_000;

/// Why a text does not describe an axis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{axis}: {problem}")]
pub struct AxisError {
    /// The axis as given.
    pub axis: String,
    /// What was expected and what was found.
    pub problem: AxisProblem,
}

/// What is wrong with an axis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AxisProblem {
    /// There is no name in front of the values.
    #[error(
        "expected NAME=from:to:number of points, such as top.load=2e5:8e5:50, or NAME=value,value"
    )]
    NoName,
    /// No parameter has this name.
    #[error("{name} is not a parameter{}; docs/parameters.md lists all parameters", did_you_mean(.nearest))]
    UnknownName {
        /// The name as given.
        name: String,
        /// Names with a similar spelling, closest first.
        nearest: Vec<String>,
    },
    /// The parameter cannot vary.
    #[error("{name} cannot vary along an axis: {reason}")]
    CannotVary {
        /// The parameter.
        name: String,
        /// Why not.
        reason: &'static str,
    },
    /// There are no values.
    #[error("there are no values; expected {expected}")]
    Empty {
        /// What was expected.
        expected: &'static str,
    },
    /// The values are neither a range nor a list.
    #[error(
        "found {parts} of the three parts of a range; expected from:to:number of points, such as 1:25:100"
    )]
    Parts {
        /// Number of parts found.
        parts: usize,
    },
    /// A value is not a finite number.
    #[error("`{found}` is not a finite number; omit the unit, which is {unit}")]
    NotANumber {
        /// What was found.
        found: String,
        /// The unit.
        unit: &'static str,
    },
    /// The number of points is not a whole number.
    #[error("`{found}` is not a number of points; expected a whole number of at least 2")]
    NotACount {
        /// What was found.
        found: String,
    },
    /// There are fewer than two points.
    #[error("an axis of {found} has no extent; expected at least 2")]
    TooFewPoints {
        /// `1 point` or `0 points`.
        found: String,
    },
    /// There are more points than a map may have cells.
    #[error("{count} points; a map has at most {MAX_CELLS} cells")]
    TooManyPoints {
        /// Number of points.
        count: u64,
    },
    /// The values do not ascend.
    #[error("the values run from {from} to {to}; expected the smaller one first")]
    NotAscending {
        /// The first of two values.
        from: String,
        /// The value after it.
        to: String,
    },
    /// The range begins with 0, which does not mean the number 0.
    #[error("the value 0 of {name} means: {zero}; begin above 0")]
    SpecialZero {
        /// The parameter.
        name: &'static str,
        /// What 0 means.
        zero: &'static str,
    },
    /// No section of the catalogue has this name.
    #[error("the catalogue has no section `{found}`{}; it has HEA, HEB and HEM 100 to 1000 and IPE 80 to 600", did_you_mean(.nearest))]
    UnknownSection {
        /// The name as given.
        found: String,
        /// The closest names.
        nearest: Vec<String>,
    },
    /// A vehicle that is not known.
    #[error(transparent)]
    Vehicle(#[from] VehicleFault),
    /// A name is listed twice.
    #[error("{name} is listed twice")]
    Twice {
        /// The name.
        name: String,
    },
    /// A number beyond the directions.
    #[error("{0} degrees is not a direction of travel; expected more than -180 and at most 180")]
    NoDirection(String),
    /// A value that the parameter does not admit.
    #[error("{0}")]
    NotAdmissible(String),
}

fn did_you_mean(nearest: &[String]) -> String {
    match nearest {
        [] => String::new(),
        nearest => format!(" (did you mean {}?)", nearest.join(" or ")),
    }
}
