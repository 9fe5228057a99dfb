//! What a recording shows in the viewer: its states with their hinges, its reports, and the column that they are of.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::repair::failure;
use super::{Exit, Failure};
use crate::evidence::{Line, LineEntry};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{ColumnState, HingeForces, ImpactEvent, ImpactReport};
use crate::messages::{Message, cdr};
use crate::parameters::Parameters;
use crate::recording::{self, Reader};
use crate::twin::Journal;
use crate::viewer::{self, Item, RecordedMessage};

/// The column of a recording, and what happened to it.
pub(super) struct Film {
    pub parameters: Arc<Parameters>,
    pub items: Vec<Item>,
}

/// Reads a recording. Its journal says which column it is of; one without is shown as the column of the parameter file
/// `config`.
pub(super) fn of_recording(bag: &Path, config: Option<&PathBuf>) -> Result<Film, Failure> {
    let reader = Reader::open(bag).map_err(failure)?;
    let mut parameters = match config {
        None => None,
        Some(file) => Some(Arc::new(
            Parameters::load(std::slice::from_ref(file), &[]).map_err(|faults| Failure {
                exit: Exit::BadInput,
                report: faults.report(),
            })?,
        )),
    };
    let mut gathered = Gathered::default();
    for message in reader.messages() {
        let message = message.map_err(failure)?;
        let topic = reader.topics().get(message.topic_index);
        if config.is_none() && topic.is_some_and(recording::is_journal) {
            if let Some(column) = starting_column(&message.data) {
                parameters.get_or_insert_with(|| Arc::clone(&column));
                gathered.told.push(RecordedMessage::Column(column));
            }
        } else {
            gathered.take(&message);
        }
    }
    let parameters = parameters.ok_or_else(|| {
        Failure::plain(
            Exit::BadInput,
            format!(
                "{} has no journal that says which column it is of; give the column's parameter file with --config",
                bag.display()
            ),
        )
    })?;
    gathered.say_what_is_not_shown();
    if gathered.shown == 0 {
        return Err(Failure::plain(
            Exit::BadInput,
            format!(
                "{} has nothing to show: expected messages of {} with {} of the same stamp, found {} and {}",
                bag.display(),
                ColumnState::INTERFACE.ros_name(),
                HingeForces::INTERFACE.ros_name(),
                gathered.states.len(),
                gathered.forces.len(),
            ),
        ));
    }
    Ok(Film {
        items: viewer::from_messages(&parameters, gathered.told),
        parameters,
    })
}

/// Stamp and event of a state or of its hinges.
type Instant = (Time, String);

/// What was found in a recording so far.
#[derive(Default)]
struct Gathered {
    told: Vec<RecordedMessage>,
    /// How many states with their hinges are in it.
    shown: usize,
    /// States whose hinges have not come.
    states: HashMap<Instant, ColumnState>,
    /// Hinges whose states have not come.
    forces: HashMap<Instant, HingeForces>,
    /// Messages that are not what their type says: how many, and what is wrong with the first.
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
            self.told.push(RecordedMessage::Report(Box::new(report)));
        } else if let Some(event) = self.read::<ImpactEvent>(message) {
            self.told.push(RecordedMessage::Event(Box::new(event)));
        }
    }

    fn pair(&mut self, state: ColumnState, forces: HingeForces) {
        self.shown += 1;
        self.told.push(RecordedMessage::State(state, forces));
    }

    /// A message of this type; `None` if it is of another one, or cannot be read.
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

    fn say_what_is_not_shown(&self) {
        if let Some(fault) = &self.first_fault {
            eprintln!(
                "{} messages cannot be read and are not shown; the first one, of {fault}",
                self.unreadable
            );
        }
        let alone = self.states.len() + self.forces.len();
        if self.shown > 0 && alone > 0 {
            eprintln!(
                "{alone} states or hinge forces have no partner of the same stamp and are not shown"
            );
        }
    }
}

fn starting_column(bytes: &[u8]) -> Option<Arc<Parameters>> {
    match Line::decode(bytes).ok()?.entry {
        LineEntry::Twin(Journal::Checkpoint(start)) => Some(Arc::clone(&start.parameters)),
        _ => None,
    }
}
