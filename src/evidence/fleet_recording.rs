//! What the recording of a fleet knows of its columns: where another recording may begin, and which messages belong into it.

use std::collections::HashSet;
use std::sync::Arc;

use super::activity::Activity;
use super::journal_line::JournalEntry;
use super::selection::{Levels, Selection};
use crate::endpoints::{self, Endpoint};
use crate::messages::cdr;
use crate::messages::column_twin_msgs::{FleetStatus, TwinStatus};
use crate::messages::rcl_interfaces::ParameterEvent;
use crate::parameters::{RecordMode, RecordSettings};
use crate::time::Nanos;
use crate::twin::{CHECKPOINT_PERIOD, Command, CommandRecord, Journal};

/// Time after which the columns are listed again \[ns\], so that another recording can begin there.
const LIST_PERIOD: Nanos = CHECKPOINT_PERIOD;

/// They are listed sooner if this part of the largest file has been recorded since then, or its longest duration is over.
const LISTS_IN_A_FILE: u64 = 8;

/// The columns of a recorded fleet.
#[derive(Debug)]
pub(super) struct FleetRecording {
    columns: Arc<[Arc<str>]>,
    activity: Activity,
    /// When the columns were listed \[ns since 1970\].
    listed: Option<Nanos>,
    /// What was recorded since then \[B\].
    recorded: u64,
    period: Nanos,
    bytes: u64,
    /// A status at rest is in no `fleet_status` yet.
    owes_status: bool,
    /// As little as possible is recorded of what is sent while nothing happens.
    events_only: bool,
    levels: Levels,
    /// The columns whose sensors the journal has told of since the columns were listed.
    has_sensors: HashSet<String>,
}

impl FleetRecording {
    pub fn new(columns: Arc<[Arc<str>]>, record: &RecordSettings) -> Self {
        // 0: a recording may last for ever.
        let longest = match record.max_duration > 0.0 {
            true => (1e9 * record.max_duration) as Nanos,
            false => Nanos::MAX,
        };
        Self {
            period: LIST_PERIOD.min(longest),
            bytes: record.max_file_size / LISTS_IN_A_FILE,
            columns,
            activity: Activity::default(),
            listed: None,
            recorded: 0,
            owes_status: false,
            events_only: record.mode == RecordMode::Events,
            levels: Levels::default(),
            has_sensors: HashSet::new(),
        }
    }

    fn takes_status(&mut self, bytes: &[u8]) -> bool {
        let Ok(status) = cdr::decode::<TwinStatus>(bytes) else {
            return true;
        };
        let is_recorded = self.activity.is_responding(&status.column_id);
        if is_recorded && status.is_at_rest() {
            self.activity.rests(&status.column_id);
            self.owes_status = true;
        }
        is_recorded
    }
}

impl Selection for FleetRecording {
    fn due_list(&mut self, now: Nanos, begins: bool) -> Option<JournalEntry> {
        let is_due = self.listed.is_none_or(|last| {
            let is_long_ago = now.saturating_sub(last) >= self.period;
            let is_worthwhile = self.recorded > 0 || begins;
            is_worthwhile && (is_long_ago || self.recorded >= self.bytes)
        });
        if !is_due || !self.activity.is_idle(now) {
            return None;
        }
        self.listed = Some(now);
        self.recorded = 0;
        self.has_sensors.clear();
        Some(JournalEntry::Fleet {
            columns: Arc::clone(&self.columns),
        })
    }

    fn owes_sensors(&mut self, column: Option<&str>) -> bool {
        column.is_some_and(|it| {
            !self.has_sensors.contains(it) && self.has_sensors.insert(it.to_owned())
        })
    }

    fn received(&mut self, column: Option<&str>, now: Nanos) {
        if let Some(column) = column {
            self.activity.received(column, now);
        }
    }

    fn rejected(&mut self, column: Option<&str>) {
        if let Some(column) = column {
            self.activity.rejected(column);
        }
    }

    /// The status of a column that has executed no command since the last one tells nothing new, and needs no checkpoint before it if it
    /// is left out.
    fn journal(&mut self, column: Option<&str>, entry: &Journal, now: Nanos) -> bool {
        let column = column.unwrap_or_default();
        match entry {
            Journal::Command(record) => {
                self.activity.command(column, is_received(record), now);
                true
            }
            Journal::Checkpoint(_) => {
                self.activity.checkpoint(column, now);
                true
            }
            Journal::Status(_) => {
                self.activity.reported(column, now);
                self.activity.is_responding(column)
            }
        }
    }

    fn recorded(&mut self, bytes: usize) {
        self.recorded = self.recorded.saturating_add(bytes as u64);
    }

    fn is_recorded(&mut self, endpoint: &Endpoint, bytes: &[u8], now: Nanos) -> bool {
        let is_change = endpoint.name == endpoints::DIAGNOSTICS.name && self.levels.change(bytes);
        if endpoint.name == endpoints::TWIN_STATUS.name {
            return self.takes_status(bytes);
        }
        // A column that nothing happens to costs nothing here; the others tell their parameters before their first command.
        if endpoint.name == endpoints::PARAMETER_EVENTS.name && announces(bytes) {
            return false;
        }
        if !self.events_only || !self.activity.is_idle(now) {
            return true;
        }
        if endpoint.name == endpoints::DIAGNOSTICS.name {
            return is_change;
        }
        if endpoint.name != endpoints::FLEET_STATUS.name {
            return true;
        }
        let of_all = cdr::decode::<FleetStatus>(bytes).is_ok_and(|status| status.of_all);
        !of_all && std::mem::take(&mut self.owes_status)
    }
}

/// Whether an event on parameters tells of new ones, as at the start.
fn announces(event: &[u8]) -> bool {
    cdr::decode::<ParameterEvent>(event).is_ok_and(|it| !it.new_parameters.is_empty())
}

/// Whether a command follows from a received message.
fn is_received(record: &CommandRecord) -> bool {
    match &record.command {
        Command::Impact(_) => true,
        Command::SetParameters { source, .. } | Command::RejectedChange { source, .. } => {
            **source == *endpoints::COLUMN_PARAMETERS.name
        }
        _ => false,
    }
}
