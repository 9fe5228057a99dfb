//! An impact whose verdict has, or will have, a range or a second opinion, as a checkpoint holds it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::opinion_state::{KnownBeamDamage, OpinionState};
use super::striking::{Striking, Travel};
use crate::assessment::{EarlierImpacts, VerdictRange};
use crate::column::{Impact, Report};
use crate::time::Nanos;

/// An impact whose report was given out and whose verdict has, or will have, a range or a second opinion: all that is needed to give
/// the report out once more.
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
    /// How the vehicle travels, where that is not in the direction 0 rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel: Option<Travel>,
    /// Its outcome.
    pub report: Report,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// Length of a time step \[ns\].
    pub step_nanos: u64,
    /// Whether its verdict has a range.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub has_range: bool,
    /// What the impacts before it have left, on which the range depends; `None` where they have left nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earlier: Option<Arc<EarlierImpacts>>,
    /// The range of the verdict; `None` until it is known.
    pub range: Option<Arc<VerdictRange>>,
    /// Where the second opinion stands.
    #[serde(default = "not_recorded")]
    pub opinion: OpinionState,
    /// The damage before it as the beam knew it.
    #[serde(default, skip_serializing_if = "KnownBeamDamage::is_undamaged")]
    pub beam_before: KnownBeamDamage,
}

/// Recordings of programs that keep no other impacts.
fn yes() -> bool {
    true
}

/// Recordings of programs without a second opinion.
fn not_recorded() -> OpinionState {
    OpinionState::None("no second opinion: the program that wrote the recording has none".into())
}

impl JudgedImpact {
    /// What has hit the column.
    #[must_use]
    pub fn striking(&self) -> Striking {
        Striking {
            vehicle: Arc::clone(&self.vehicle),
            impact: self.impact,
            travel: self.travel,
        }
    }
}
