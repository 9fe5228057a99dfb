//! The wording that summary and report share.

use crate::column::{End, Outcome};

/// The outcome of an impact, for a sentence that is a line of its own.
#[must_use]
pub fn outcome_in_words(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Elastic => "elastic: no hinge has yielded",
        Outcome::Plastic => "plastic: hinges have yielded and the column remains standing",
        Outcome::Collapsed => "COLLAPSED: the column has lost its shape or its equilibrium",
    }
}

/// Why a response ended.
#[must_use]
pub fn end_in_words(end: End) -> &'static str {
    match end {
        End::AtRest => "at rest",
        End::DurationReached => "stopped at response.duration, not at rest",
        End::Collapsed => "collapsed",
    }
}
