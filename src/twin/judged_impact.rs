//! An impact whose verdict has, or will have, a range, as a checkpoint holds it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::assessment::VerdictRange;
use crate::column::{Impact, Report};
use crate::time::Nanos;

/// An impact whose report was given out and whose verdict has, or will have, a range: all that is needed to give the report
/// out once more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedImpact {
    /// Stamp of the event.
    pub stamp: Nanos,
    /// The impact.
    pub event_id: Arc<str>,
    /// Name of the vehicle.
    pub vehicle: Arc<str>,
    /// What hit the column.
    pub impact: Impact,
    /// Its outcome.
    pub report: Report,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// Length of a time step \[ns\].
    pub step_nanos: u64,
    /// The range of the verdict; `None` until it is known.
    pub range: Option<Arc<VerdictRange>>,
}
