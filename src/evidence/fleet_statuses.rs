//! Compares the columns in `fleet_status` with their last recorded `twin_status`.

use std::collections::HashMap;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::{ColumnStatus, FleetStatus, TwinStatus};

/// What the columns of a fleet have last reported in a recording.
#[derive(Debug, Default)]
pub(super) struct FleetStatuses {
    last: HashMap<String, ColumnStatus>,
}

impl FleetStatuses {
    /// Takes a recorded status of a column.
    pub fn reported(&mut self, status: &TwinStatus) {
        self.last
            .insert(status.column_id.clone(), ColumnStatus::from(status));
    }

    /// Compares a recorded message with what its columns have reported. Columns that have reported nothing in this recording are not
    /// compared, and with `may_miss` none is: the recording may lack the last report.
    pub fn message(
        &self,
        bytes: &[u8],
        place: &Place<'_>,
        columns: usize,
        may_miss: bool,
        found: &mut Verification,
    ) {
        found.fleet_statuses.recorded += 1;
        let status: FleetStatus = match cdr::decode(bytes) {
            Ok(status) => status,
            Err(error) => {
                found.fleet_statuses.unexpected += 1;
                return found.note_difference(place.unreadable(&error));
            }
        };
        let place = &Place {
            stamp: status.header.stamp.to_nanos(),
            ..*place
        };
        found.fleet_statuses.compared += 1;
        let mut difference = None;
        if status.columns_total as usize != columns {
            let total = status.columns_total.to_string();
            difference = Some(place.difference("columns_total", total, columns.to_string()));
        }
        for column in &status.columns {
            let Some(last) = self.last.get(&column.column_id).filter(|_| !may_miss) else {
                continue;
            };
            // The node knows its sensors, the twin does not.
            let column = &ColumnStatus {
                sensor_problem: String::new(),
                ..column.clone()
            };
            let differing = place.first_difference(column, last).map(|it| Difference {
                column_id: column.column_id.clone(),
                ..it
            });
            difference = difference.or(differing);
        }
        if let Some(difference) = difference {
            found.fleet_statuses.differing += 1;
            found.note_difference(difference);
        }
    }
}
