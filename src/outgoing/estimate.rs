//! What the sensors say about an impact as a message.

use crate::estimation::{self, FEWEST_RESPONSES};
use crate::messages::column_twin_msgs::{CredibleInterval, ImpactEstimate};
use crate::twin::{Decision, EstimateOutput};

impl From<estimation::CredibleInterval> for CredibleInterval {
    fn from(interval: estimation::CredibleInterval) -> Self {
        let estimation::CredibleInterval { mean, low, high } = interval;
        Self { mean, low, high }
    }
}

impl CredibleInterval {
    /// The interval with another origin.
    fn relative_to(self, origin: f64) -> Self {
        Self {
            mean: self.mean - origin,
            low: self.low - origin,
            high: self.high - origin,
        }
    }
}

impl From<&EstimateOutput> for ImpactEstimate {
    /// Leaves header and column empty.
    fn from(output: &EstimateOutput) -> Self {
        let EstimateOutput {
            record,
            decision,
            merged_event_id,
            ..
        } = output;
        let estimate = &record.estimate;
        let contact = estimate.contact_time.mean;
        let vehicles = &estimate.vehicle_probabilities;
        let actions = estimate.action.iter();
        let mut action_probabilities = [0.0; 5];
        for (action, probability) in actions {
            action_probabilities[*action as usize] = *probability;
        }
        Self {
            event_id: record.event_id.to_string(),
            update: record.update,
            is_final: record.is_final,
            data_until: estimate.data_until - contact,
            contact_time: CredibleInterval::from(estimate.contact_time).relative_to(contact),
            mass: estimate.mass.into(),
            velocity: estimate.velocity.into(),
            momentum: estimate.momentum.into(),
            mass_velocity_correlation: estimate.mass_velocity_correlation,
            peak_v1: estimate.peak_v1.into(),
            residual_v1: estimate.residual_v1.into(),
            capacity_ratio: estimate.capacity_ratio.into(),
            yielded: estimate.yielded,
            collapsed: estimate.collapsed,
            vehicles: vehicles.iter().map(|(name, _)| name.clone()).collect(),
            vehicle_probabilities: vehicles.iter().map(|(_, it)| *it).collect(),
            action_probabilities,
            effective_sample_size: estimate.effective_sample_size,
            reliable: estimate.effective_sample_size >= FEWEST_RESPONSES,
            doubtful_sensors: estimate.doubtful_sensors.clone(),
            scale_not_confirmed: estimate.scale_not_confirmed.clone(),
            decision: decision_code(*decision),
            merged_event_id: merged_event_id.as_deref().unwrap_or_default().to_owned(),
            ..Self::default()
        }
    }
}

fn decision_code(decision: Decision) -> u8 {
    match decision {
        Decision::Pending => ImpactEstimate::DECISION_PENDING,
        Decision::Accepted => ImpactEstimate::DECISION_ACCEPTED,
        Decision::Merged => ImpactEstimate::DECISION_MERGED,
        Decision::Declined => ImpactEstimate::DECISION_DECLINED,
        Decision::Rejected => ImpactEstimate::DECISION_REJECTED,
    }
}
