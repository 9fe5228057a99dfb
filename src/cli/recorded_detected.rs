//! What the sensors of a recorded twin have detected, for the viewer: its measurements, and its estimates with their records.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use column_twin::estimation::{EstimateRecord, Intake};
use column_twin::evidence::{JournalEntry, JournalLine};
use column_twin::incoming::raw_batch;
use column_twin::live::RecentBatches;
use column_twin::messages::column_twin_msgs::{ImpactEstimate, Measurement};
use column_twin::parameters::Parameters;
use column_twin::sensors::Sensor;
use column_twin::twin::{Command, Journal};
use column_twin::viewer::{DetectedImpacts, DetectedUpdate};

/// Number of an estimate: the impact, and the update.
type Number = (String, u32);

/// Collects what the sensors have detected, message by message.
#[derive(Default)]
pub(super) struct RecordedDetected {
    intake: Option<Intake>,
    recent: RecentBatches,
    detected: Option<DetectedImpacts>,
    records: HashMap<Number, Arc<EstimateRecord>>,
    /// Estimates whose record has not come yet.
    waiting: VecDeque<ImpactEstimate>,
}

impl RecordedDetected {
    /// Takes a line of the journal, and returns what is to be shown then.
    pub fn line(&mut self, line: &JournalLine) -> Vec<DetectedUpdate> {
        match &line.entry {
            JournalEntry::Twin(Journal::Checkpoint(start)) => {
                self.parameters(&start.parameters);
                let column_id = &start.parameters.settings().column_id;
                self.begin(line, &start.parameters.sensors(), column_id);
                Vec::new()
            }
            // A column of a fleet has no checkpoint before its first command.
            JournalEntry::Sensors { sensors } => {
                self.begin(line, sensors, line.column_id.as_deref().unwrap_or_default());
                Vec::new()
            }
            JournalEntry::Twin(Journal::Command(command)) => {
                if let Command::Estimate(record) = &command.command {
                    let number = (record.event_id.to_string(), record.update);
                    self.records.insert(number, Arc::clone(record));
                }
                self.updates(false)
            }
            _ => Vec::new(),
        }
    }

    /// Takes measurements from the first line on that tells of their intake, for these sensors.
    fn begin(&mut self, line: &JournalLine, sensors: &[Sensor], column_id: &str) {
        if let (None, Some(state)) = (&self.intake, &line.intake) {
            let mut intake = Intake::new(sensors, column_id);
            self.intake = intake.resume(state).then_some(intake);
        }
    }

    /// The parameters of the column from here on.
    pub fn parameters(&mut self, parameters: &Arc<Parameters>) {
        match &mut self.detected {
            Some(detected) => detected.change(Arc::clone(parameters)),
            None => self.detected = Some(DetectedImpacts::new(Arc::clone(parameters))),
        }
    }

    /// Takes measurements that arrived at `received`, by the clock of the twin \[ns\].
    pub fn measurement(&mut self, measurement: &Measurement, received: i64) {
        let intake = self.intake.as_mut();
        // What the node has not taken is not shown either.
        if let Some(Ok(batch)) = intake.map(|it| it.take(&raw_batch(measurement), received)) {
            self.recent.push(&batch);
        }
    }

    /// Takes a published estimate, and returns what is to be shown then.
    pub fn estimate(&mut self, estimate: ImpactEstimate) -> Vec<DetectedUpdate> {
        self.waiting.push_back(estimate);
        self.updates(false)
    }

    /// What is left at the end of the recording: estimates without their records.
    pub fn end(&mut self) -> Vec<DetectedUpdate> {
        self.updates(true)
    }

    /// The estimates that can be shown, in their order.
    fn updates(&mut self, all: bool) -> Vec<DetectedUpdate> {
        let mut updates = Vec::new();
        let Some(detected) = &mut self.detected else {
            return updates;
        };
        while let Some(estimate) = self.waiting.front() {
            let number = (estimate.event_id.clone(), estimate.update);
            let record = self.records.get(&number);
            if record.is_none() && !all {
                break;
            }
            let record = record.map(Arc::clone);
            if let Some(estimate) = self.waiting.pop_front() {
                let readings = |from, until| self.recent.between(from, until);
                updates.push(detected.update(estimate, record.as_deref(), readings));
            }
        }
        updates
    }
}
