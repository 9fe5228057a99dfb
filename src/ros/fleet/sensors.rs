//! The health of the sensors of a fleet, for `/diagnostics` and `fleet_status`.

use std::sync::Arc;

use crate::estimation::{SensorCondition, SensorHealth};
use crate::live::{LibraryStatistics, MAX_ESTIMATED_AT_ONCE, MAX_LIBRARIES, SensingStatistics};
use crate::messages::diagnostic_msgs::DiagnosticStatus;
use crate::time::Nanos;

use crate::ros::diagnostics::entry;
use crate::ros::measurements::SensedColumns;
use crate::ros::sensor_watch::values;

/// Most columns whose sensors have a status of their own: the first ones of which something is wrong.
const MAX_SHOWN: usize = 20;

/// How many sensors there are, and what of them was lost.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SensorCount {
    pub total: usize,
    /// Those of which something is wrong.
    pub faulty: usize,
    alive: usize,
    waiting: usize,
    stuck: usize,
    dead: usize,
    /// Samples that did not arrive.
    lost_samples: u64,
    /// Batches that the estimation did not take in time.
    pub lost_batches: u64,
    /// Columns of which a sensor is not as it should be.
    columns: usize,
}

impl SensorCount {
    fn add(&mut self, sensor: &SensorHealth) {
        self.total += 1;
        self.lost_samples += sensor.counts.lost;
        *match sensor.condition {
            SensorCondition::Waiting => &mut self.waiting,
            SensorCondition::Alive => &mut self.alive,
            SensorCondition::Stuck => &mut self.stuck,
            SensorCondition::Dead(_) => &mut self.dead,
        } += 1;
    }
}

/// What the sensors of all columns were like when they were looked at last.
pub(super) struct FleetSensors {
    sensed: Arc<SensedColumns>,
    count: SensorCount,
    shown: Vec<DiagnosticStatus>,
}

impl FleetSensors {
    pub fn new(sensed: Arc<SensedColumns>) -> Self {
        Self {
            sensed,
            count: SensorCount::default(),
            shown: Vec::new(),
        }
    }

    /// Looks at all sensors, logs what has changed, and tells for each column what is wrong, in few words that do not change while it
    /// lasts; nothing is an empty text.
    pub fn look(&mut self, now: Nanos, mut tell: impl FnMut(u32, &str)) {
        let mut count = SensorCount::default();
        self.shown.clear();
        for column in self.sensed.columns() {
            let (health, problems, lost) = column.problems(now);
            health.iter().for_each(|sensor| count.add(sensor));
            count.lost_batches += lost;
            count.faulty += problems.len().min(health.len());
            count.columns += usize::from(!problems.is_empty());
            let problem = problems.join("; ");
            tell(column.column(), &problem);
            if !problem.is_empty() && self.shown.len() < MAX_SHOWN {
                let name = format!("{}: sensors", column.column_id());
                let mut status = entry(&name, DiagnosticStatus::WARN, problem, values(&health));
                column.column_id().clone_into(&mut status.hardware_id);
                self.shown.push(status);
            }
        }
        self.count = count;
    }

    /// How many sensors there are, and what was lost.
    pub fn count(&self) -> SensorCount {
        self.count
    }

    /// The sensors of the first columns of which something is wrong.
    pub fn worst(&self) -> impl Iterator<Item = DiagnosticStatus> {
        self.shown.iter().cloned()
    }

    /// The sensors of all columns, and what is done with their measurements.
    pub fn status(&self, sensing: SensingStatistics) -> DiagnosticStatus {
        let SensorCount {
            total,
            faulty,
            alive,
            waiting,
            stuck,
            dead,
            lost_samples,
            lost_batches,
            columns,
        } = self.count;
        let SensingStatistics {
            lost_estimates,
            delayed,
            libraries,
        } = sensing;
        let LibraryStatistics {
            kinds,
            complete,
            beyond,
            bytes,
            waited,
        } = libraries;
        let (level, message) = match (lost_estimates, faulty, beyond) {
            (1.., _, _) => (
                DiagnosticStatus::ERROR,
                format!("{lost_estimates} estimates did not reach their twins"),
            ),
            (0, 1.., _) => (
                DiagnosticStatus::WARN,
                format!("something is wrong with sensors of {columns} columns"),
            ),
            (0, 0, 1..) => (
                DiagnosticStatus::WARN,
                format!(
                    "there are {kinds} different columns with sensors; for {beyond} of them nothing is prepared before an impact, so \
                     that its estimate comes some seconds later"
                ),
            ),
            (0, 0, 0) => (DiagnosticStatus::OK, "all sensors send".to_owned()),
        };
        let of_columns = self.sensed.columns().len();
        let values = [
            ("columns with sensors", of_columns.to_string()),
            ("sensors", total.to_string()),
            ("alive", alive.to_string()),
            ("waiting for the first batch", waiting.to_string()),
            ("stuck", stuck.to_string()),
            ("dead", dead.to_string()),
            ("samples lost on their way", lost_samples.to_string()),
            (
                "batches that the estimation did not take in time",
                lost_batches.to_string(),
            ),
            (
                "batches for columns that are elsewhere or have no sensors",
                self.sensed.strays().to_string(),
            ),
            (
                "estimates that did not reach their twins",
                lost_estimates.to_string(),
            ),
            (
                "impacts that waited for the estimates of others",
                format!(
                    "{delayed}, at most {MAX_ESTIMATED_AT_ONCE} are estimated by a thread at a time"
                ),
            ),
            (
                "different columns whose responses are prepared",
                format!("{complete} of {kinds}, at most {MAX_LIBRARIES}"),
            ),
            (
                "different columns for which nothing is prepared",
                beyond.to_string(),
            ),
            ("memory of prepared responses [B]", bytes.to_string()),
            (
                "impacts that waited for their responses",
                waited.to_string(),
            ),
        ];
        let values = values.map(|(key, value)| (key.to_owned(), value));
        entry("sensors", level, message, values)
    }
}
