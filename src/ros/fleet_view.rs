//! What is known of the columns of fleets, from their statuses.

use std::collections::BTreeMap;

use crate::messages::column_twin_msgs::{ColumnStatus, FleetStatus};
use crate::parameters::MAX_COLUMNS;

/// The columns of fleets, from their statuses.
#[derive(Debug, Default)]
pub(super) struct FleetView(BTreeMap<String, ColumnStatus>);

impl FleetView {
    /// Takes a message and returns all columns that are known, in the order of their names. Names beyond [`MAX_COLUMNS`] are left
    /// out: anybody may send some.
    pub(super) fn take(&mut self, status: &FleetStatus) -> Vec<ColumnStatus> {
        for column in &status.columns {
            if self.0.len() < MAX_COLUMNS || self.0.contains_key(&column.column_id) {
                self.0.insert(column.column_id.clone(), column.clone());
            }
        }
        self.0.values().cloned().collect()
    }
}
