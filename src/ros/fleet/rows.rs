//! Vehicles that hit several columns of the fleet: events are checked with all columns that they name, and impacts are submitted
//! when they are due.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::column::VehicleReport;
use crate::fleet::{NotHit, RowImpact, Rows};
use crate::incoming::impact_command;
use crate::messages::column_twin_msgs::RowImpactEvent;
use crate::outgoing::RecordingTap;
use crate::parameters::{Parameters, crush_of_name, split_crush};
use crate::time::Nanos;
use crate::twin::{Command, Output, Striking};

use super::super::inputs::record;
use super::super::qos;
use super::live_fleet::FleetTwin;
use super::rejected::not_taken;

/// Most reasons that a rejection lists.
const MAX_LISTED: usize = 20;

/// The rows under way, shared by the thread that takes their events and the one that sees the forecasts.
pub(super) struct RowImpacts {
    rows: Mutex<Rows>,
    /// It contains each impact as the event that it is for its column, with which the column is verified.
    recording: Option<Arc<dyn RecordingTap>>,
}

impl RowImpacts {
    pub fn new(recording: Option<Arc<dyn RecordingTap>>) -> Self {
        Self {
            rows: Mutex::default(),
            recording,
        }
    }

    fn rows(&self) -> MutexGuard<'_, Rows> {
        self.rows.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes an event, all impacts of it or none. Waits for each of its columns.
    ///
    /// # Errors
    /// All reasons for which the event is rejected.
    pub fn take_event(&self, message: RowImpactEvent, fleet: &FleetTwin) -> Result<(), String> {
        let taken = self.take_whole(message.clone(), fleet);
        if let Err(reasons) = &taken {
            self.rows().reject(&message, reasons);
        }
        taken
    }

    fn take_whole(&self, message: RowImpactEvent, fleet: &FleetTwin) -> Result<(), String> {
        let row = RowImpact::new(message).map_err(listed)?;
        let mut faults = Vec::new();
        let mut striking = Vec::new();
        for event in row.described() {
            let Some(column) = fleet.index_of(&event.column_id) else {
                faults.push(format!(
                    "column {:?} is not in this fleet of {} columns; a row has columns of one fleet",
                    event.column_id,
                    fleet.column_ids().len()
                ));
                continue;
            };
            let Command::Impact(command) = impact_command(event) else {
                continue;
            };
            let column_id = command.column_id.clone();
            match fleet.check_impact(column, command) {
                Ok(found) => striking.push(found),
                Err(refusal) => faults.push(format!("column {column_id:?}: {refusal}")),
            }
        }
        if faults.is_empty() {
            faults.extend(row.differing_vehicles(&striking));
        }
        if !faults.is_empty() {
            return Err(listed(faults));
        }
        self.rows().begin(row)?;
        self.submit_due(fleet);
        Ok(())
    }

    /// Submits the impacts that are due.
    pub fn submit_due(&self, fleet: &FleetTwin) {
        let mut rows = self.rows();
        if rows.is_empty() {
            return;
        }
        let now = fleet.now();
        rows.give_up(now);
        for event in rows.due(now, |column| max_ahead(fleet, column)) {
            let Some(column) = fleet.index_of(&event.column_id) else {
                continue;
            };
            record(
                &self.recording,
                Some(&event.column_id),
                &qos::IMPACT_EVENT,
                &event,
                None,
            );
            if let Err(refusal) = fleet.submit(column, impact_command(event.clone())) {
                not_taken(
                    &self.recording,
                    &event.column_id,
                    &qos::IMPACT_EVENT,
                    &event.event_id,
                    &refusal,
                );
                rows.not_submitted(&event, &refusal.to_string());
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
    pub fn rest(&self, fleet: &FleetTwin, longest: Duration) -> Duration {
        let rows = self.rows();
        let Some(next) = rows.next_stamp() else {
            return longest;
        };
        // Its column may accept it any time before.
        let ahead = next.saturating_sub(fleet.now()).max(0).unsigned_abs();
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
fn max_ahead(fleet: &FleetTwin, column_id: &str) -> Nanos {
    let column = fleet.index_of(column_id);
    let seconds = column.map_or(0.0, |it| fleet.parameters(it).settings().event.max_ahead);
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
