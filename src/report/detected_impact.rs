//! An impact of a recording that the sensors have detected, and what has become of it.

use std::sync::Arc;

use crate::estimation::{EstimateRecord, SensorComparison};
use crate::sensors::Sensor;
use crate::twin::{Decision, EstimateOutput};

/// An impact that the sensors have detected.
#[derive(Debug, Clone)]
pub struct DetectedImpact {
    /// Its estimates in their order, at least one.
    pub estimates: Vec<Arc<EstimateRecord>>,
    /// What has become of it, in the order of time; by the recomputation.
    pub decisions: Vec<DetectedDecision>,
    /// The sensors of the twin.
    pub sensors: Vec<Sensor>,
    /// What each sensor has read against what the last estimate predicts; by the recomputation, and empty without it.
    pub comparisons: Vec<SensorComparison>,
}

/// What has become of an impact that was detected.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectedDecision {
    /// Number of the estimate that was the newest one then, from 0.
    pub update: u32,
    /// What has become of it.
    pub decision: Decision,
    /// The event that is the same impact, if there is one.
    pub merged_event_id: Option<Arc<str>>,
    /// Who has decided; `None`: the twin itself.
    pub by: Option<Arc<str>>,
}

impl DetectedImpact {
    /// Its identifier.
    #[must_use]
    pub fn event_id(&self) -> Option<&str> {
        self.estimates.first().map(|it| &*it.event_id)
    }

    /// The impact of the twin that it has become, if it has: itself, or the event that is the same impact.
    #[must_use]
    pub fn became(&self) -> Option<&str> {
        let last = self.decisions.last()?;
        match last.decision {
            Decision::Accepted => self.event_id(),
            Decision::Merged => last.merged_event_id.as_deref(),
            Decision::Pending | Decision::Declined | Decision::Rejected => None,
        }
    }

    /// Takes what the recomputed twin gives out, with who has decided something since, if anybody has.
    pub(super) fn decide(&mut self, output: &EstimateOutput, by: &mut Option<Arc<str>>) {
        let (decision, merged_event_id) = (output.decision, &output.merged_event_id);
        let before = self.decisions.last();
        let is_same = before
            .is_some_and(|it| (it.decision, &it.merged_event_id) == (decision, merged_event_id));
        let is_open = before.is_none() && decision == Decision::Pending;
        if !is_same && !is_open {
            self.decisions.push(DetectedDecision {
                update: output.record.update,
                decision,
                merged_event_id: merged_event_id.clone(),
                by: by.take(),
            });
        }
    }
}
