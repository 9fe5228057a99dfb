//! The items of a recording for the viewer: states with their hinges, reports, and the parameters of the column.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::failure::{Exit, Failure};
use super::recorded_detected::RecordedDetected;
use column_twin::evidence::{JournalEntry, JournalError, JournalLine, VerifyError, listed_columns};
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
/// the parameter file `config`. A recording of several columns needs the identifier of one of them.
pub(super) fn of_recording(
    bag: &Path,
    config: Option<&PathBuf>,
    column_id: Option<&str>,
) -> Result<RecordedItems, Failure> {
    let reader = recording::open(bag)?;
    let mut parameters = match config {
        None => None,
        Some(file) => Some(Arc::new(Parameters::load(std::slice::from_ref(file), &[])?)),
    };
    let mut gathered = Gathered {
        wanted: column_id.map(str::to_owned),
        ..Gathered::default()
    };
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
                    columns.iter().for_each(|it| gathered.know(it));
                }
                JournalEntry::Twin(Journal::Checkpoint(start)) => {
                    gathered.know(&start.parameters.settings().column_id);
                }
                _ => {}
            }
            let of_column = line.column_id.as_deref();
            if config.is_some() || of_column.is_some_and(|it| !gathered.is_shown(it)) {
                continue;
            }
            if let JournalEntry::Twin(Journal::Checkpoint(start)) = &line.entry {
                let column = Arc::clone(&start.parameters);
                parameters.get_or_insert_with(|| Arc::clone(&column));
                gathered.messages.push(RecordedMessage::Column(column));
            }
            let updates = gathered.detected.line(&line);
            gathered.show_detected(updates);
        } else {
            gathered.take(&message);
        }
    }
    gathered.report_unshown();
    gathered.check_column(bag)?;
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
    /// The column to show, if one is named.
    wanted: Option<String>,
    /// The identifiers of all columns of the recording.
    known: BTreeSet<String>,
    /// Those of them that have states.
    with_states: BTreeSet<String>,
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
    /// Takes note of a column of the recording.
    fn know(&mut self, column_id: &str) {
        if !self.known.contains(column_id) {
            self.known.insert(column_id.to_owned());
        }
    }

    /// Whether messages of this column are to be shown. Those of several columns cannot be shown as one.
    fn is_shown(&self, column_id: &str) -> bool {
        match &self.wanted {
            Some(wanted) => wanted == column_id,
            None => self.known.len() <= 1,
        }
    }

    fn take(&mut self, message: &recording::Message) {
        if let Some(state) = self.read::<ColumnState>(message) {
            self.know(&state.column_id);
            if !self.with_states.contains(&state.column_id) {
                self.with_states.insert(state.column_id.clone());
            }
            if !self.is_shown(&state.column_id) {
                return;
            }
            let instant = (state.header.stamp, state.event_id.clone());
            match self.forces.remove(&instant) {
                Some(forces) => self.pair(state, forces),
                None => drop(self.states.insert(instant, state)),
            }
        } else if let Some(forces) = self.read_shown::<HingeForces>(message, |it| &it.column_id) {
            let instant = (forces.header.stamp, forces.event_id.clone());
            match self.states.remove(&instant) {
                Some(state) => self.pair(state, forces),
                None => drop(self.forces.insert(instant, forces)),
            }
        } else if let Some(report) = self.read_shown::<ImpactReport>(message, |it| &it.column_id) {
            self.messages
                .push(RecordedMessage::Report(Box::new(report)));
        } else if let Some(event) = self.read_shown::<ImpactEvent>(message, |it| &it.column_id) {
            self.messages.push(RecordedMessage::Event(Box::new(event)));
        } else if let Some(measurement) =
            self.read_shown::<Measurement>(message, |it| &it.column_id)
        {
            self.detected
                .measurement(&measurement, message.publish_time);
        } else if let Some(estimate) =
            self.read_shown::<ImpactEstimate>(message, |it| &it.column_id)
        {
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

    /// As [`read`](Self::read), of a column that is to be shown.
    fn read_shown<M: Message + DeserializeOwned>(
        &mut self,
        message: &recording::Message,
        column_id: impl Fn(&M) -> &String,
    ) -> Option<M> {
        self.read(message).filter(|it| self.is_shown(column_id(it)))
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

    /// Checks that there is something to show, of one column.
    fn check_column(&self, bag: &Path) -> Result<(), Failure> {
        let bag = bag.display();
        let with_states = listed_columns(&self.with_states);
        let reason = match &self.wanted {
            Some(wanted) if !self.known.contains(wanted) => {
                let known = listed_columns(&self.known);
                VerifyError::NoSuchColumn {
                    wanted: wanted.clone(),
                    columns: known,
                }
                .to_string()
            }
            None if self.known.len() > 1 => format!(
                "expected the recording of one column to show, found {} columns in {bag}; choose one with --column (columns with \
                 states: {with_states})",
                self.known.len(),
            ),
            wanted if self.shown == 0 => {
                let of_column = wanted.as_ref().map(|it| format!(" of column {it:?}"));
                format!(
                    "{bag} has nothing{} to show: expected messages of type {} and {} with equal stamps, found {} and {} without a \
                     partner (columns with states: {with_states})",
                    of_column.unwrap_or_default(),
                    ColumnState::INTERFACE.ros_name(),
                    HingeForces::INTERFACE.ros_name(),
                    self.states.len(),
                    self.forces.len(),
                )
            }
            _ => return Ok(()),
        };
        Err(Failure::plain(Exit::BadInput, reason))
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
