//! What a criterion consists of, without values.

use std::borrow::Cow;

use super::criterion::Action;
use super::input::AssessmentInput;
use crate::parameters::Provenance;

/// On which side of its limit a value is admissible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    AtMost,
    AtLeast,
}

/// A criterion without values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Definition {
    pub name: &'static str,
    /// What engineers call it: what is compared with the limit, and after a colon what it means to exceed it.
    pub title: &'static str,
    /// The cause of the action if it is exceeded, as a part of a sentence.
    pub cause: &'static str,
    pub edition: &'static str,
    pub tag: Provenance,
    pub unit: &'static str,
    pub relation: Relation,
    pub action: Action,
    /// What the value is.
    pub value: &'static str,
    /// What it means if the criterion is exceeded.
    pub consequence: &'static str,
    pub evaluate: fn(&AssessmentInput) -> Evaluation,
}

/// Value and limit, or why there are none.
pub(super) type Evaluation = Result<(f64, f64), NotEvaluated>;

/// Why a criterion has no value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NotEvaluated {
    /// It says nothing about this column: it cannot be exceeded.
    NotApplicable(Cow<'static, str>),
    /// Data are missing with which it might be exceeded: which, and what to give.
    Missing(Cow<'static, str>),
}

impl NotEvaluated {
    /// The reason in words.
    pub fn reason(&self) -> &str {
        match self {
            Self::NotApplicable(reason) | Self::Missing(reason) => reason,
        }
    }
}
