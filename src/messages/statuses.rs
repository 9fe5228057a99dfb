//! What the statuses of a twin and of a column of a fleet say.

use super::column_twin_msgs::{ColumnStatus, TwinStatus};

/// Whether no response is running in this phase of a status.
fn is_at_rest(phase: u8) -> bool {
    use TwinStatus as It;
    !matches!(phase, It::APPROACH | It::CONTACT | It::FREE)
}

impl TwinStatus {
    /// Whether no response is running.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        is_at_rest(self.phase)
    }
}

impl From<&TwinStatus> for ColumnStatus {
    fn from(status: &TwinStatus) -> Self {
        // The first vehicle is that of the parameters.
        let critical = status.critical_velocity_restrict.first();
        Self {
            column_id: status.column_id.clone(),
            phase: status.phase,
            action: status.action,
            deciding_criterion: status.deciding_criterion.clone(),
            action_reason: status.action_reason.clone(),
            range_least: status.range_least,
            range_most: status.range_most,
            range_at_least: status.range_at_least,
            range_decided_by: status.range_decided_by.clone(),
            event_id: status.event_id.clone(),
            events_accepted: status.events_accepted,
            events_rejected: status.events_rejected,
            parameters_rejected: status.parameters_rejected,
            last_rejection_code: status.last_rejection_code,
            last_rejection_reason: status.last_rejection_reason.clone(),
            last_rejection_event_id: status.last_rejection_event_id.clone(),
            fault: status.fault.clone(),
            impacts_since_reset: status.impacts_since_reset,
            residual_v1: status.residual_v1,
            residual_u2: status.residual_u2,
            plastic_work_since_reset: status.plastic_work_since_reset,
            residual_capacity: status.residual_capacity,
            capacity_ratio: status.capacity_ratio,
            reserve: status.reserve,
            critical_velocity_restrict: critical.copied().unwrap_or(f64::NAN),
            // The twin does not know its sensors.
            sensor_problem: String::new(),
        }
    }
}

impl ColumnStatus {
    /// Whether no response is running.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        is_at_rest(self.phase)
    }

    /// Whether the column takes no impact before it is reset: it has collapsed, is fractured, or cannot be computed.
    #[must_use]
    pub fn is_out_of_service(&self) -> bool {
        matches!(
            self.phase,
            TwinStatus::COLLAPSED | TwinStatus::FAULTED | TwinStatus::FRACTURED
        )
    }
}
