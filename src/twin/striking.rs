//! What hits the column.

use std::sync::Arc;

use crate::column::Impact;

/// What hits the column: an impact with everything that its specification left open.
#[derive(Debug, Clone, PartialEq)]
pub struct Striking {
    /// Name of the vehicle in the catalogue; empty: the one that the parameters give by numbers.
    pub vehicle: Arc<str>,
    /// The impact.
    pub impact: Impact,
}

impl Striking {
    /// Time until the vehicle touches a column that stands still \[ns\].
    pub(super) fn approach_nanos(&self) -> i64 {
        (1e9 * self.impact.approach_secs()).round() as i64
    }
}
