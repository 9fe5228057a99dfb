//! Which conditions are alarms.

use std::collections::BTreeMap;

use crate::condition::Condition;

/// For each kind of condition, the least rank that is an alarm. A kind that is not listed never is.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Rules(BTreeMap<String, u8>);

impl Rules {
    /// Rules by which nothing is an alarm.
    pub fn none() -> Self {
        Self::default()
    }

    /// Also conditions of this kind, from this rank on. A rank of 0 counts as 1, because at 0 nothing is wrong.
    #[must_use]
    pub fn with(mut self, kind: impl Into<String>, at_least: u8) -> Self {
        self.0.insert(kind.into(), at_least.max(1));
        self
    }

    /// Whether this condition is an alarm.
    pub(crate) fn is_alarm(&self, condition: &Condition) -> bool {
        let at_least = self.0.get(&condition.watched.kind);
        at_least.is_some_and(|at_least| condition.level.rank >= *at_least)
    }

    /// Whether any condition of this kind can be an alarm.
    pub(crate) fn know(&self, kind: &str) -> bool {
        self.0.contains_key(kind)
    }
}
