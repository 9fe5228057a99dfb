//! `column_twin`: messages that only fleets use. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::column_twin_msgs::{TwinStatus, is_at_rest};
use super::std_msgs::Header;

/// A vehicle hits several columns of a fleet one after another.
///
/// ```text
#[doc = include_str!("../../msg/RowImpactEvent.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RowImpactEvent {
    pub header: Header,
    pub event_id: String,
    pub vehicle: String,
    pub mass: f64,
    pub velocity: f64,
    pub gap: f64,
    pub restitution: f64,
    pub height: f64,
    pub direction: f64,
    pub column_ids: Vec<String>,
    pub offsets: Vec<f64>,
    pub distances: Vec<f64>,
}

/// The status of one column of a fleet.
///
/// ```text
#[doc = include_str!("../../msg/ColumnStatus.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ColumnStatus {
    pub column_id: String,
    pub phase: u8,
    pub action: u8,
    pub deciding_criterion: String,
    pub action_reason: String,
    pub range_least: u8,
    pub range_most: u8,
    pub range_at_least: bool,
    pub range_decided_by: String,
    pub event_id: String,
    pub events_accepted: u64,
    pub events_rejected: u64,
    pub parameters_rejected: u64,
    pub last_rejection_code: u16,
    pub last_rejection_reason: String,
    pub last_rejection_event_id: String,
    pub fault: String,
    pub impacts_since_reset: u32,
    pub residual_v1: f64,
    pub residual_u2: f64,
    pub plastic_work_since_reset: f64,
    pub residual_capacity: f64,
    pub capacity_ratio: f64,
    pub reserve: f64,
    pub critical_velocity_restrict: f64,
    pub sensor_problem: String,
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

/// The status of a fleet.
///
/// ```text
#[doc = include_str!("../../msg/FleetStatus.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FleetStatus {
    pub header: Header,
    pub columns_total: u32,
    pub columns_active: u32,
    pub of_all: bool,
    pub ignored: u64,
    pub dropped_inputs: u64,
    pub dropped_states: u64,
    pub dropped_outputs: u64,
    pub late_states: u64,
    pub worst_lateness: f64,
    pub sensors_total: u32,
    pub sensors_faulty: u32,
    pub dropped_measurements: u64,
    pub columns: Vec<ColumnStatus>,
}
