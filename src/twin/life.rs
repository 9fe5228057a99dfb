//! What the column has been through since the last reset.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::assessed::LastImpact;
use super::damage_correction::DamageCorrection;
use super::opinion_state::KnownBeamDamage;
use crate::assessment::BaseDemand;

/// What the column has been through since the last reset, in responses that have ended.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Life {
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// Rejected impacts since the last reset.
    pub rejected_since_reset: u64,
    /// Work dissipated in the hinges since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// The last accepted impact; empty before the first.
    pub last_event_id: Arc<str>,
    /// The last impact whose response has ended; `None` before the first.
    #[serde(default)]
    pub last_impact: Option<LastImpact>,
    /// Measurements by which the damage was corrected or confirmed since the last reset.
    pub corrections_since_reset: u32,
    /// The last of them.
    pub last_correction: Option<DamageCorrection>,
    /// The damage as the beam knows it.
    #[serde(default, skip_serializing_if = "KnownBeamDamage::is_undamaged")]
    pub beam: KnownBeamDamage,
    /// Whether the column may have a damage that the twin does not know, because its state file could not be used.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_damage_unknown: bool,
}

impl Life {
    /// What the impacts so far have put into the base.
    pub(super) fn base_before(&self) -> Option<BaseDemand> {
        self.last_impact.as_ref()?.base
    }
}
