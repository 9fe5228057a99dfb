//! The items of a recording for the viewer: states with their hinges, reports, and the parameters of the column.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::failure::{Exit, Failure};
use super::recorded_detected::RecordedDetected;
use column_twin::evidence::{JournalEntry, JournalError, JournalLine};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEstimate, ImpactEvent, ImpactReport, Measurement,
};
use column_twin::messages::{Message, cdr};
use column_twin::parameters::Parameters;
use column_twin::recording;
use column_twin::twin::Journal;
use column_twin::viewer::{self, DetectedUpdate, RecordedMessage, ViewerItem};

/// The parameters of the column of a recording, and the items to show.
pub(super) struct RecordedItems {
    pub parameters: Arc<Parameters>,
    pub items: Vec<ViewerItem>,
}

/// Reads a recording. Its journal contains the parameters of the column; for a recording without a journal they come from
/// the parameter file `config`.
pub(super) fn of_recording(bag: &Path, config: Option<&PathBuf>) -> Result<RecordedItems, Failure> {
    let reader = recording::open(bag)?;
    let mut parameters = match config {
        None => None,
        Some(file) => Some(Arc::new(Parameters::load(std::slice::from_ref(file), &[])?)),
    };
    let mut gathered = Gathered::default();
    if let Some(parameters) = &parameters {
        gathered.detected.parameters(parameters);
    }
    for message in reader.messages() {
        let message = message?;
        let topic = reader.topics().get(message.topic_index);
        if topic.is_some_and(recording::is_journal) {
            let line = match JournalLine::decode(&message.data) {
                Ok(line) => line,
                Err(error @ JournalError::OtherVersion { .. }) if config.is_none() => {
                    return Err(Failure::plain(Exit::BadInput, error));
                }
                Err(_) => continue,
            };
            match &line.entry {
                JournalEntry::Fleet { columns } => {
                    let reason = format!(
                        "expected the recording of one column to show, found the recording of a fleet of {} in {}; column-twin report \
                         --column shows one of them, and viewer.mode:=save writes a file for the viewer while a fleet runs",
                        columns.len(),
                        bag.display()
                    );
                    return Err(Failure::plain(Exit::BadInput, reason));
                }
                JournalEntry::Twin(Journal::Checkpoint(start)) if config.is_none() => {
                    let column = Arc::clone(&start.parameters);
                    parameters.get_or_insert_with(|| Arc::clone(&column));
                    gathered.messages.push(RecordedMessage::Column(column));
                }
                _ => {}
            }
            if config.is_none() {
                let updates = gathered.detected.line(&line);
                gathered.show_detected(updates);
            }
        } else {
            gathered.take(&message);
        }
    }
    let parameters = parameters.ok_or_else(|| {
        Failure::plain(
            Exit::BadInput,
            format!(
                "{} has no journal with the parameters of its column; give the parameter file of the column with --config",
                bag.display()
            ),
        )
    })?;
    let left = gathered.detected.end();
    gathered.show_detected(left);
    gathered.report_unshown();
    if gathered.shown == 0 {
        return Err(Failure::plain(
            Exit::BadInput,
            format!(
                "{} has nothing to show: expected messages of type {} and {} with equal stamps, found {} and {} without a partner",
                bag.display(),
                ColumnState::INTERFACE.ros_name(),
                HingeForces::INTERFACE.ros_name(),
                gathered.states.len(),
                gathered.forces.len(),
            ),
        ));
    }
    Ok(RecordedItems {
        items: viewer::from_messages(&parameters, gathered.messages),
        parameters,
    })
}

/// Stamp and event that identify a state and its hinges.
type Instant = (Time, String);

/// The messages read from a recording so far.
#[derive(Default)]
struct Gathered {
    messages: Vec<RecordedMessage>,
    /// Number of states with their hinges.
    shown: usize,
    /// States without the message of their hinges.
    states: HashMap<Instant, ColumnState>,
    /// Messages of hinges without their state.
    forces: HashMap<Instant, HingeForces>,
    detected: RecordedDetected,
    /// Number of messages that cannot be decoded.
    unreadable: usize,
    first_fault: Option<String>,
}

impl Gathered {
    fn take(&mut self, message: &recording::Message) {
        if let Some(state) = self.read::<ColumnState>(message) {
            let instant = (state.header.stamp, state.event_id.clone());
            match self.forces.remove(&instant) {
                Some(forces) => self.pair(state, forces),
                None => drop(self.states.insert(instant, state)),
            }
        } else if let Some(forces) = self.read::<HingeForces>(message) {
            let instant = (forces.header.stamp, forces.event_id.clone());
            match self.states.remove(&instant) {
                Some(state) => self.pair(state, forces),
                None => drop(self.forces.insert(instant, forces)),
            }
        } else if let Some(report) = self.read::<ImpactReport>(message) {
            self.messages
                .push(RecordedMessage::Report(Box::new(report)));
        } else if let Some(event) = self.read::<ImpactEvent>(message) {
            self.messages.push(RecordedMessage::Event(Box::new(event)));
        } else if let Some(measurement) = self.read::<Measurement>(message) {
            self.detected.measurement(&measurement, message.log_time);
        } else if let Some(estimate) = self.read::<ImpactEstimate>(message) {
            let updates = self.detected.estimate(estimate);
            self.show_detected(updates);
        }
    }

    fn show_detected(&mut self, updates: Vec<DetectedUpdate>) {
        let updates = updates.into_iter();
        let messages = updates.map(|it| RecordedMessage::Detected(Box::new(it)));
        self.messages.extend(messages);
    }

    fn pair(&mut self, state: ColumnState, forces: HingeForces) {
        self.shown += 1;
        self.messages.push(RecordedMessage::State(state, forces));
    }

    /// Decodes a message of type `M`; `None` if it has another type or cannot be decoded.
    fn read<M: Message + DeserializeOwned>(&mut self, message: &recording::Message) -> Option<M> {
        if *message.type_name != *M::INTERFACE.ros_name() {
            return None;
        }
        let read = cdr::decode(&message.data);
        if let Err(error) = &read {
            self.unreadable += 1;
            self.first_fault
                .get_or_insert_with(|| format!("{}: {error}", message.topic));
        }
        read.ok()
    }

    fn report_unshown(&self) {
        if let Some(fault) = &self.first_fault {
            tell!(
                "{} messages cannot be decoded and are not shown; the first: {fault}",
                self.unreadable
            );
        }
        let alone = self.states.len() + self.forces.len();
        if self.shown > 0 && alone > 0 {
            tell!(
                "{alone} messages are not shown: a state without hinge forces of the same stamp, or the reverse"
            );
        }
    }
}
