//! Vehicles that hit several columns of the fleet: events are checked with all columns that they name, and impacts are submitted
//! when they are due.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::column::VehicleReport;
use crate::fleet::{NotHit, RowImpact, Rows};
use crate::incoming::impact_command;
use crate::messages::column_twin_msgs::RowImpactEvent;
use crate::parameters::{Parameters, crush_of_name, split_crush};
use crate::ros::live_columns::LiveColumns;
use crate::ros::qos;
use crate::ros::receiving::Receiving;
use crate::time::Nanos;
use crate::twin::{Command, Output, Striking};

/// Most reasons that a rejection lists.
const MAX_LISTED: usize = 20;

/// The rows under way, shared by the thread that takes their events and the one that sees the forecasts.
pub(in crate::ros) struct RowImpacts {
    rows: Mutex<Rows>,
    /// The recording contains each impact as the event that it is for its column, with which the column is verified.
    receiving: Receiving,
}

impl RowImpacts {
    pub fn new(receiving: Receiving) -> Self {
        Self {
            rows: Mutex::default(),
            receiving,
        }
    }

    fn rows(&self) -> MutexGuard<'_, Rows> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes an event, all impacts of it or none. Waits for each of its columns.
    ///
    /// # Errors
    /// All reasons for which the event is rejected.
    pub fn take_event(&self, message: RowImpactEvent) -> Result<(), String> {
        let taken = self.take_whole(message.clone());
        if let Err(reasons) = &taken {
            self.rows().reject(&message, reasons);
        }
        taken
    }

    fn take_whole(&self, message: RowImpactEvent) -> Result<(), String> {
        let columns = &self.receiving.columns;
        let row = RowImpact::new(message).map_err(listed)?;
        let mut faults = Vec::new();
        let mut striking = Vec::new();
        for event in row.described() {
            let Some(column) = columns.face().index_of(&event.column_id) else {
                faults.push(format!(
                    "column {:?} is not in this fleet of {} columns; a row has columns of one fleet",
                    event.column_id,
                    columns.face().ids().len()
                ));
                continue;
            };
            let Command::Impact(command) = impact_command(event) else {
                continue;
            };
            let column_id = command.column_id.clone();
            match columns.check_impact(column, command) {
                Ok(found) => striking.push(found),
                Err(rejection) => faults.push(format!("column {column_id:?}: {rejection}")),
            }
        }
        if faults.is_empty() {
            faults.extend(row.differing_vehicles(&striking));
        }
        if !faults.is_empty() {
            return Err(listed(faults));
        }
        self.rows().begin(row)?;
        self.submit_due();
        Ok(())
    }

    /// Submits the impacts that are due.
    pub fn submit_due(&self) {
        let columns = &self.receiving.columns;
        let mut rows = self.rows();
        if rows.is_empty() {
            return;
        }
        let now = columns.now();
        rows.give_up(now);
        for event in rows.due(now, |column| max_ahead(columns, column)) {
            let Some(column) = columns.face().index_of(&event.column_id) else {
                continue;
            };
            let endpoint = &qos::IMPACT_EVENT;
            self.receiving.record(column, endpoint, &event, None);
            if let Err(rejection) = columns.submit(column, impact_command(event.clone())) {
                // Rejections by the twin are among its outputs, and logged there; this impact did not reach it.
                tracing::error!(
                    "impact event {:?} did not reach column {:?}: {rejection}",
                    event.event_id,
                    event.column_id
                );
                self.receiving
                    .not_taken(Some(column), endpoint, &event.event_id, &rejection);
                rows.not_submitted(&event, &rejection.to_string());
            }
        }
    }

    /// Takes an output of a column, which may tell what is left of a vehicle.
    pub fn take(&self, column_id: &str, output: &Output, parameters: impl Fn() -> ParametersOf) {
        let mut rows = self.rows();
        if !rows.is_empty() {
            rows.take(column_id, output, |striking, report| {
                crush_after(&parameters(), striking, report)
            });
        }
    }

    /// How long nothing is to be done, at most `longest`.
    pub fn rest(&self, columns: &LiveColumns, longest: Duration) -> Duration {
        let rows = self.rows();
        let Some(next) = rows.next_stamp() else {
            return longest;
        };
        // Its column may accept it any time before.
        let ahead = next.saturating_sub(columns.now()).max(0).unsigned_abs();
        longest.min(Duration::from_nanos(ahead)).min(LOOK_AGAIN)
    }

    /// Gives up what is still to come, at a stop.
    pub fn stop(&self) {
        self.rows().stop();
    }

    /// The columns of which it has turned out that they are not hit.
    pub fn take_ended(&self) -> Vec<NotHit> {
        self.rows().take_ended()
    }
}

/// Longest time between two looks at whether a column accepts the stamp of an impact that is kept.
const LOOK_AGAIN: Duration = Duration::from_millis(50);

type ParametersOf = Arc<Parameters>;

/// How far ahead of the clock a column accepts stamps \[ns\].
fn max_ahead(columns: &LiveColumns, column_id: &str) -> Nanos {
    let column = columns.face().index_of(column_id);
    let seconds = column.map_or(0.0, |it| columns.parameters(it).settings().event.max_ahead);
    (1e9 * seconds) as Nanos
}

/// The largest crush of each spring of a vehicle since it was new, after an impact.
fn crush_after(parameters: &Parameters, striking: &Striking, report: &VehicleReport) -> Vec<f64> {
    let (name, _) = split_crush(&striking.vehicle);
    let before = crush_of_name(&striking.vehicle).unwrap_or_default();
    let more = &report.max_crush[..report.masses.min(report.max_crush.len())];
    // The vehicle has hit the column, so that its name is one.
    let new = parameters.vehicle_named(name).ok().flatten();
    let crush = new.map(|it| it.crush_after(&before, more));
    crush.map_or_else(|| more.to_vec(), |it| it[..more.len()].to_vec())
}

fn listed(reasons: Vec<String>) -> String {
    let more = reasons.len().saturating_sub(MAX_LISTED);
    let mut shown = reasons;
    shown.truncate(MAX_LISTED);
    if more > 0 {
        shown.push(format!("and {more} more reasons"));
    }
    shown.join("; ")
}
