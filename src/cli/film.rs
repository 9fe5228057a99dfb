//! What a recording shows in the viewer: its states with their hinges, its reports, and the column that they are of.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::{Exit, Failure};
use crate::evidence::{Line, LineEntry};
use crate::messages::column_twin::{ColumnState, HingeForces, ImpactReport};
use crate::messages::{Message, cdr};
use crate::parameters::Parameters;
use crate::recording::{self, Reader};
use crate::twin::Journal;
use crate::viewer::{self, Item};

/// The column of a recording, and what happened to it.
pub(super) struct Film {
    pub parameters: Arc<Parameters>,
    pub items: Vec<Item>,
}

/// Reads a recording. Its journal says which column it is of; one without is shown as the column of the parameter file
/// `config`.
pub(super) fn of_recording(bag: &Path, config: Option<&PathBuf>) -> Result<Film, Failure> {
    let reader = Reader::open(bag).map_err(|error| {
        let exit = if error.is_bad_input() {
            Exit::BadInput
        } else {
            Exit::Failed
        };
        Failure::plain(exit, error)
    })?;
    let mut parameters = match config {
        None => None,
        Some(file) => Some(Arc::new(
            Parameters::load(std::slice::from_ref(file), &[]).map_err(|faults| Failure {
                exit: Exit::BadInput,
                report: faults.report(),
            })?,
        )),
    };
    let mut states: Vec<ColumnState> = Vec::new();
    let mut forces = HashMap::new();
    let mut reports: Vec<ImpactReport> = Vec::new();
    for message in reader.messages() {
        let message = message.map_err(|error| Failure::plain(Exit::BadInput, error))?;
        if parameters.is_none() && message.topic.ends_with("/journal") {
            parameters = starting_column(&message.data);
        }
        if let Some(state) = read(&message) {
            states.push(state);
        } else if let Some(read) = read::<HingeForces>(&message) {
            forces.insert(instant(&read.header.stamp, &read.event_id), read);
        } else if let Some(report) = read(&message) {
            reports.push(report);
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
    let count = states.len();
    let pairs: Vec<_> = states
        .into_iter()
        .filter_map(|state| {
            let forces = forces.remove(&instant(&state.header.stamp, &state.event_id))?;
            Some((state, forces))
        })
        .collect();
    if pairs.is_empty() {
        return Err(Failure::plain(
            Exit::BadInput,
            format!(
                "{} has nothing to show: expected messages of {} with {} of the same stamp, found {count} of the first",
                bag.display(),
                ColumnState::INTERFACE.ros_name(),
                HingeForces::INTERFACE.ros_name(),
            ),
        ));
    }
    if pairs.len() < count {
        eprintln!(
            "{} of {count} states have no hinge forces of the same stamp and are not shown",
            count - pairs.len()
        );
    }
    Ok(Film {
        parameters,
        items: viewer::from_messages(pairs, reports),
    })
}

/// A message of this type; `None` if it is of another one, or cannot be read.
fn read<M: Message + DeserializeOwned>(message: &recording::Message) -> Option<M> {
    if *message.type_name != *M::INTERFACE.ros_name() {
        return None;
    }
    cdr::decode(&message.data).ok()
}

fn instant(
    stamp: &crate::messages::builtin_interfaces::Time,
    event_id: &str,
) -> (i32, u32, String) {
    (stamp.sec, stamp.nanosec, event_id.to_owned())
}

fn starting_column(bytes: &[u8]) -> Option<Arc<Parameters>> {
    match Line::decode(bytes).ok()?.entry {
        LineEntry::Twin(Journal::StartingPoint(start)) => Some(Arc::clone(&start.parameters)),
        _ => None,
    }
}
