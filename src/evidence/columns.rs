//! The columns of a recording, each of which is verified by itself: one of a single twin, many of a fleet.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::background::KnownResults;
use super::comparison::Place;
use super::inputs::Inputs;
use super::journal_line::{JournalEntry, JournalLine};
use super::lines::Gap;
use super::measured::UNREADABLE;
use super::parameter_events::ParameterEvents;
use super::policy::UNNAMED;
use super::replayer::Replayer;
use super::verification::{ColumnCheck, Verification};
use crate::endpoints::NodeKind;
use crate::estimation::SharedPreparations;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::Measurement;
use crate::outgoing::Topic;
use crate::recording::Message;
use crate::time::Nanos;
use crate::twin::Journal;

/// What verification knows of one column.
pub(super) struct Column {
    pub inputs: Inputs,
    pub replayer: Replayer,
    pub parameter_events: ParameterEvents,
    /// Messages before its first checkpoint, by topic.
    pub early: [u64; Topic::COUNT],
    pub has_checkpoint: bool,
}

/// The columns that a recording has told of so far.
pub(super) struct Columns {
    /// By their identifiers, or [`UNNAMED`].
    columns: BTreeMap<Arc<str>, Column>,
    /// The identifiers of the columns of a fleet.
    fleet: Option<BTreeSet<Arc<str>>>,
    /// The column of a fleet to which the verification is restricted.
    only: Option<String>,
    known: KnownResults,
    prepared: SharedPreparations,
    keeps_outputs: bool,
    declares_losses: bool,
    /// The latest time of the columns' clock in an entry \[ns\].
    latest: Nanos,
    /// Lines that are missing before a column has told of itself count for it as well.
    continues_at: Option<i64>,
}

impl Columns {
    pub fn new(only: Option<&str>, keeps_outputs: bool, declares_losses: bool) -> Self {
        Self {
            columns: BTreeMap::new(),
            fleet: None,
            only: only.map(str::to_owned),
            known: KnownResults::default(),
            prepared: SharedPreparations::default(),
            keeps_outputs,
            declares_losses,
            latest: Nanos::MIN,
            continues_at: None,
        }
    }

    /// Takes the list of the columns of a fleet.
    pub fn list(&mut self, columns: &[Arc<str>]) {
        self.fleet
            .get_or_insert_with(|| columns.iter().cloned().collect());
    }

    /// The columns of the fleet; `None` for a single twin.
    pub fn fleet(&self) -> Option<&BTreeSet<Arc<str>>> {
        self.fleet.as_ref()
    }

    /// The kind of the node that made the recording.
    pub fn kind(&self) -> NodeKind {
        match self.fleet {
            Some(_) => NodeKind::Fleet,
            None => NodeKind::Single,
        }
    }

    /// The column to which a message belongs that names this one. A single twin takes all of them, even if they cannot be read.
    pub fn addressed<E>(&self, named: impl FnOnce() -> Result<String, E>) -> Result<String, E> {
        match self.kind().names_columns() {
            true => named(),
            false => Ok(UNNAMED.to_owned()),
        }
    }

    /// Whether a message belongs to a column that is to be verified. One that belongs to no column of the fleet is a difference.
    pub fn is_wanted(&self, column_id: &str, place: &Place<'_>, found: &mut Verification) -> bool {
        let fleet = self.fleet();
        if fleet.is_some_and(|fleet| !fleet.contains(column_id)) {
            let own = "a column of the fleet";
            let difference = place.difference("column_id", format!("{column_id:?}"), own);
            found.note_difference(difference);
            return false;
        }
        let is_wanted = self.is_verified(column_id);
        if !is_wanted {
            found.of_other_columns += 1;
        }
        is_wanted
    }

    fn is_verified(&self, column_id: &str) -> bool {
        let is_asked_for = || self.only.as_deref().is_none_or(|it| it == column_id);
        let fleet = self.fleet.as_ref();
        fleet.is_none_or(|fleet| fleet.contains(column_id) && is_asked_for())
    }

    /// Takes a message on measurements.
    pub fn measurement(&mut self, message: &Message, place: &Place<'_>, found: &mut Verification) {
        let decoded = cdr::decode::<Measurement>(&message.data);
        let named = || decoded.as_ref().map(|it| it.column_id.clone());
        let column_id = match self.addressed(named) {
            Ok(column_id) => column_id,
            Err(error) => {
                // It may be of any column.
                self.lose_measurements(UNREADABLE, found);
                return found.note_difference(place.unreadable(&error));
            }
        };
        if self.is_wanted(&column_id, place, found) {
            self.in_column(&column_id, found, |column, found| {
                let measured = &mut column.replayer.estimates.measured;
                measured.message(&decoded, message.publish_time, place, found);
            });
        }
    }

    /// From here on it is not known which measurements the node took, for this reason.
    fn lose_measurements(&mut self, why: &'static str, found: &mut Verification) {
        self.in_each(found, |column, _| {
            column.replayer.estimates.measured.lose(why)
        });
    }

    /// Takes what a line tells of the measurements before it, which are all known or not.
    pub fn measured_before(
        &mut self,
        line: &JournalLine,
        is_known: bool,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        if line.since.lost_measurements > 0 {
            let why = "measurements that the node took could not be recorded";
            self.lose_measurements(why, found);
        } else if !is_known {
            let why = "measurements are missing, or differ from the measurements in the journal";
            self.lose_measurements(why, found);
        }
        let column = line.column_id.as_deref().unwrap_or_default();
        let (sensors, column_id) = match &line.entry {
            JournalEntry::Twin(Journal::Checkpoint(checkpoint)) => {
                let parameters = &checkpoint.parameters;
                (parameters.sensors(), &*parameters.settings().column_id)
            }
            JournalEntry::Sensors { sensors } => (sensors.clone(), column),
            _ => return,
        };
        // Nobody asked for this column, or it is unknown, which the handling of the entry itself reports.
        if !self.is_verified(column) {
            return;
        }
        self.in_column(column, found, |column, found| {
            let measured = &mut column.replayer.estimates.measured;
            measured.line(line.intake.as_ref(), (&sensors, column_id), place, found);
        });
    }

    /// Lets `work` act on a column, and accounts for what it finds.
    pub fn in_column<T>(
        &mut self,
        column_id: &str,
        found: &mut Verification,
        work: impl FnOnce(&mut Column, &mut Verification) -> T,
    ) -> T {
        let (kind, continues_at) = (self.kind(), self.continues_at);
        let new = || {
            let replayer = Replayer::new(kind, self.keeps_outputs, self.declares_losses);
            let mut column = Column {
                inputs: Inputs::default(),
                replayer: replayer.sharing(self.known.clone(), self.prepared.clone()),
                parameter_events: ParameterEvents::default(),
                early: [0; Topic::COUNT],
                has_checkpoint: false,
            };
            if let Some(log_time) = continues_at {
                column.inputs.continue_at(log_time);
            }
            column
        };
        let column = match self.columns.get_mut(column_id) {
            Some(column) => column,
            None => self.columns.entry(column_id.into()).or_insert_with(new),
        };
        if !kind.names_columns() {
            return work(column, found);
        }
        let before = found.counts();
        column_id.clone_into(&mut found.at_column);
        let result = work(column, found);
        found.at_column.clear();
        let after = found.counts();
        let check = found.columns.entry(column_id.to_owned()).or_default();
        check.add(&before, &after);
        result
    }

    /// Lets `work` act on every column in turn, as [`in_column`](Self::in_column).
    pub fn in_each(
        &mut self,
        found: &mut Verification,
        mut work: impl FnMut(&mut Column, &mut Verification),
    ) {
        let ids: Vec<_> = self.columns.keys().cloned().collect();
        for column_id in ids {
            self.in_column(&column_id, found, &mut work);
        }
    }

    /// Takes note of the time of an entry.
    pub fn at(&mut self, now: Nanos) {
        self.latest = self.latest.max(now);
    }

    /// Frees what the columns know of responses to which no impact belongs any more, as they did themselves.
    pub fn forget_what_is_too_old(&mut self) {
        for column in self.columns.values_mut() {
            column.replayer.forget_what_is_too_old(self.latest);
        }
    }

    /// Takes note of a gap in the lines, which may be those of any column.
    pub fn gap(&mut self, gap: Gap, log_time: i64, found: &mut Verification) {
        let (Gap::Missing(lost) | Gap::Earlier(lost)) = gap else {
            return;
        };
        if matches!(gap, Gap::Earlier(_)) {
            self.continues_at = Some(log_time);
        }
        self.in_each(found, |column, found| {
            column.replayer.lines_are_missing(lost);
            match gap {
                Gap::Missing(_) => column.inputs.restart(log_time, found),
                Gap::Earlier(_) => column.inputs.continue_at(log_time),
                Gap::None => {}
            }
        });
    }
}

impl ColumnCheck {
    /// Adds what was found between two counts.
    fn add(&mut self, before: &Self, after: &Self) {
        let Self {
            checkpoints,
            states_at_rest,
            inputs,
            compared,
            differences,
            missing,
            unchecked,
        } = self;
        *checkpoints += after.checkpoints - before.checkpoints;
        *states_at_rest += after.states_at_rest - before.states_at_rest;
        *inputs += after.inputs - before.inputs;
        *compared += after.compared - before.compared;
        *differences += after.differences - before.differences;
        *missing += after.missing - before.missing;
        *unchecked += after.unchecked - before.unchecked;
    }
}
