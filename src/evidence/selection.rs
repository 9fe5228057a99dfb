//! What a recording has of what its node does: the policies of a single twin and of a fleet.

use super::journal_line::JournalEntry;
use crate::endpoints::{self, Endpoint};
use crate::messages::cdr;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::messages::diagnostic_msgs::DiagnosticArray;
use crate::time::Nanos;
use crate::twin::Journal;

/// Decides what is recorded. `column` is as in [`RecordingTap`](crate::outgoing::RecordingTap).
pub(super) trait Selection: Send {
    /// Whether a sent message is recorded.
    fn is_recorded(&mut self, endpoint: &Endpoint, bytes: &[u8], now: Nanos) -> bool;

    /// Takes note of an entry of a column's journal; whether it is recorded.
    fn journal(&mut self, column: Option<&str>, entry: &Journal, now: Nanos) -> bool;

    /// The list of the columns, if it is due and a recording can begin here. After a quiet time it is due where something
    /// `begins` that will be recorded, so that the recording does not have to begin in the middle of it.
    fn due_list(&mut self, _now: Nanos, _begins: bool) -> Option<JournalEntry> {
        None
    }

    /// Takes note that a message or a line about a column was recorded, of so many bytes.
    fn recorded(&mut self, _bytes: usize) {}

    /// Takes note of a received message.
    fn received(&mut self, _column: Option<&str>, _now: Nanos) {}

    /// Takes note that a message which was received did not reach its column.
    fn rejected(&mut self, _column: Option<&str>) {}

    /// Whether the journal has to tell of the sensors of a column that has sent measurements: once after each list, so that those of
    /// the recording that begins there can be followed.
    fn owes_sensors(&mut self, _column: Option<&str>) -> bool {
        false
    }
}

/// The levels of the latest diagnostics.
#[derive(Debug, Default)]
pub(super) struct Levels(Option<Vec<u8>>);

impl Levels {
    /// Whether a level in these diagnostics differs from the previous ones.
    pub fn change(&mut self, diagnostics: &[u8]) -> bool {
        let Ok(array) = cdr::decode::<DiagnosticArray>(diagnostics) else {
            return true;
        };
        let levels = Some(array.status.iter().map(|it| it.level).collect());
        let changed = self.0 != levels;
        self.0 = levels;
        changed
    }
}

/// What is recorded of a single twin: with `events_only` no periodic message while the column is at rest.
#[derive(Debug)]
pub(super) struct SingleRecording {
    events_only: bool,
    /// A command has been executed since the last status at rest.
    is_active: bool,
    levels: Levels,
}

impl SingleRecording {
    pub fn new(events_only: bool) -> Self {
        Self {
            events_only,
            is_active: true,
            levels: Levels::default(),
        }
    }
}

impl Selection for SingleRecording {
    fn is_recorded(&mut self, endpoint: &Endpoint, bytes: &[u8], _: Nanos) -> bool {
        if !self.events_only {
            return true;
        }
        if endpoint.name == endpoints::DIAGNOSTICS.name {
            return self.levels.change(bytes) || self.is_active;
        }
        if !endpoint.shows_rest {
            return true;
        }
        let was_active = self.is_active;
        if endpoint.name == endpoints::TWIN_STATUS.name && is_at_rest(bytes) {
            self.is_active = false;
        }
        was_active
    }

    fn journal(&mut self, _: Option<&str>, entry: &Journal, _: Nanos) -> bool {
        match entry {
            Journal::Command(_) => {
                self.is_active = true;
                true
            }
            // The status that follows it is left out as well.
            Journal::Status(_) => !self.events_only || self.is_active,
            Journal::Checkpoint(_) => true,
        }
    }
}

/// Whether a status reports that no response is running.
fn is_at_rest(status: &[u8]) -> bool {
    cdr::decode::<TwinStatus>(status).is_ok_and(|status| status.is_at_rest())
}
