//! Verifies a recording by recomputation.

use std::path::Path;
use std::sync::Arc;

use super::about::About;
use super::columns::Columns;
use super::comparison::{Place, seconds};
use super::definitions::compare_definitions;
use super::fleet_statuses::FleetStatuses;
use super::inputs;
use super::journal_line::{JournalEntry, JournalError, JournalLine};
use super::lines::{Gap, Lines};
use super::parameter_events::EventOfColumn;
use super::policy::UNNAMED;
use super::replayer::RecordedBytes;
use super::topics::INPUTS;
use super::verification::Verification;
use crate::endpoints::{self, Endpoint};
use crate::estimation::SensorComparison;
use crate::outgoing::{Message, Topic};
use crate::recording::{self, Reader, RecordingError};
use crate::twin::{Journal, Output};

/// Most columns that an error lists.
const MAX_NAMED: usize = 20;

/// Why a recording cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording has no journal.
    #[error(
        "the recording has no topic {name} of type {type_name}, without which it cannot be recomputed; record with the \
         parameter record.mode of column-twin run or column-twin fleet, or with column-twin simulate --record",
        type_name = endpoints::JOURNAL.type_name,
        name = endpoints::JOURNAL.name
    )]
    NoJournal,
    /// The journal cannot be read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The recording has no such column.
    #[error("expected a column of the recording ({columns}), found {wanted:?}")]
    NoSuchColumn {
        /// As given.
        wanted: String,
        /// Those that the recording has, as many as fit into a line.
        columns: String,
    },
    /// The journal has no checkpoint.
    #[error(
        "the journal of the recording has no checkpoint, from which a recomputation could start (the recording is \
         {wholeness}); verify the previous or the next recording"
    )]
    NoCheckpoint {
        /// Whether the recording is complete.
        wholeness: String,
    },
}

/// The identifiers of columns for an error, as many as fit into a line; `none` without columns.
#[must_use]
pub fn listed_columns(
    columns: impl IntoIterator<Item: std::fmt::Debug, IntoIter: ExactSizeIterator>,
) -> String {
    let mut rest = columns.into_iter();
    if rest.len() == 0 {
        return "none".to_owned();
    }
    let named = rest.by_ref().take(MAX_NAMED);
    let mut listed = named
        .map(|it| format!("{it:?}"))
        .collect::<Vec<_>>()
        .join(", ");
    if let more @ 1.. = rest.len() {
        listed += &format!(" and {more} more");
    }
    listed
}

/// What an observer of a verification is shown, in the order of the recording.
#[derive(Debug)]
pub enum Observed<'a> {
    /// An entry of the journal.
    Entry(&'a JournalEntry),
    /// A state or a report that was recomputed.
    Recomputed(&'a Output),
    /// What each sensor has read against what the estimate predicts that is the last entry; if it was computed again and is
    /// the recorded one.
    Compared {
        /// Its impact.
        event_id: &'a str,
        /// Sensor by sensor.
        comparisons: &'a [SensorComparison],
    },
}

/// Recomputes a recording, given by its directory or its MCAP file, and compares every value.
///
/// # Errors
/// The recording cannot be read, or has no journal that this program can read.
pub fn verify(path: &Path) -> Result<Verification, VerifyError> {
    verify_reader(&Reader::open(path)?)
}

/// As [`verify`](fn@verify) of an open recording.
///
/// # Errors
/// As [`verify`](fn@verify).
pub fn verify_reader(reader: &Reader) -> Result<Verification, VerifyError> {
    verify_with(reader, None, None)
}

/// As [`verify`](fn@verify) of an open recording, of one column of a fleet only. The numbers, times and counts of the whole
/// recording are checked all the same.
///
/// # Errors
/// As [`verify`](fn@verify), or the recording has no such column.
pub fn verify_column(reader: &Reader, column_id: &str) -> Result<Verification, VerifyError> {
    verify_with(reader, Some(column_id), None)
}

/// As [`verify`](fn@verify) of an open recording, and shows an observer the journal and what is recomputed from it: the
/// outputs that precede an entry first. With a `column_id`, as [`verify_column`]: the entries of several columns of a fleet cannot be
/// told from one another.
///
/// # Errors
/// As [`verify`](fn@verify), or the recording has no such column.
pub fn verify_observed(
    reader: &Reader,
    column_id: Option<&str>,
    observe: &mut dyn FnMut(Observed<'_>),
) -> Result<Verification, VerifyError> {
    verify_with(reader, column_id, Some(observe))
}

fn verify_with(
    reader: &Reader,
    only: Option<&str>,
    observe: Option<&mut dyn FnMut(Observed<'_>)>,
) -> Result<Verification, VerifyError> {
    recording::check_version(reader)?;
    let journal = reader
        .topics()
        .iter()
        .find(|it| recording::is_journal(it))
        .map(|it| Arc::clone(&it.name))
        .ok_or(VerifyError::NoJournal)?;
    let mut pass = VerifyingPass::new(reader, &journal, only, observe);
    pass.begin(beginning(reader, &journal)?, only)?;
    compare_definitions(reader, &mut pass.found);
    for message in reader.messages() {
        match message {
            Ok(message) => pass.message(&message)?,
            // The damage was counted when the recording was opened.
            Err(RecordingError::Damaged { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    pass.finish()
}

/// The first line with which a recording can begin: the names of the topics and the columns of a fleet are needed from the
/// beginning.
fn beginning(reader: &Reader, journal: &str) -> Result<Option<JournalLine>, VerifyError> {
    let lines = reader.messages().filter_map(Result::ok);
    for message in lines.filter(|it| *it.topic == *journal) {
        let line = JournalLine::decode(&message.data)?;
        if line.about.is_some() {
            return Ok(Some(line));
        }
    }
    Ok(None)
}

/// One pass over the messages of a recording.
struct VerifyingPass<'a, 'o> {
    reader: &'a Reader,
    /// Name of the journal's topic.
    journal: &'a str,
    observe: Option<&'o mut dyn FnMut(Observed<'_>)>,
    lines: Lines,
    columns: Columns,
    statuses: FleetStatuses,
    found: Verification,
    /// Missing messages that were noted when the counts of the journal were last settled.
    settled: u64,
    last_log_time: i64,
    /// The recording declares losses, or is damaged.
    declares_losses: bool,
}

impl<'a, 'o> VerifyingPass<'a, 'o> {
    fn new(
        reader: &'a Reader,
        journal: &'a str,
        only: Option<&str>,
        observe: Option<&'o mut dyn FnMut(Observed<'_>)>,
    ) -> Self {
        let is_damaged = reader.damaged_records() > 0;
        let lost = reader.lost_messages().unwrap_or_default();
        let declares_losses = is_damaged || lost > 0;
        Self {
            reader,
            journal,
            lines: Lines::new(!is_damaged, reader.repeats_checkpoint()),
            columns: Columns::new(only, observe.is_some(), declares_losses),
            statuses: FleetStatuses::default(),
            observe,
            found: Verification::default(),
            settled: 0,
            last_log_time: 0,
            declares_losses,
        }
    }

    /// Takes the first line with which the recording can begin.
    fn begin(&mut self, line: Option<JournalLine>, only: Option<&str>) -> Result<(), VerifyError> {
        let Some(line) = line else {
            return Ok(());
        };
        let known = match &line.entry {
            JournalEntry::Fleet { columns } => {
                self.found.fleet = Some(columns.len());
                self.columns.list(columns);
                columns.to_vec()
            }
            JournalEntry::Twin(Journal::Checkpoint(it)) => {
                vec![it.parameters.settings().column_id.as_str().into()]
            }
            _ => Vec::new(),
        };
        self.found.about = line.about;
        let Some(wanted) = only else {
            return Ok(());
        };
        if !known.iter().any(|it| **it == *wanted) {
            let columns = listed_columns(&known);
            let wanted = wanted.to_owned();
            return Err(VerifyError::NoSuchColumn { wanted, columns });
        }
        self.found.only = self.found.fleet.map(|_| wanted.to_owned());
        Ok(())
    }

    fn message(&mut self, message: &recording::Message) -> Result<(), VerifyError> {
        self.last_log_time = message.log_time;
        let place = Place {
            topic: &message.topic,
            log_time: message.log_time,
            ..Place::default()
        };
        if *message.topic == *self.journal {
            let line = JournalLine::decode(&message.data)?;
            self.line(&line, message.publish_time, &place);
            return Ok(());
        }
        if self.lines.ended {
            let after = place.difference("the message", "after the end of the journal", "before");
            self.found.note_difference(after);
        }
        let about = self.found.about.as_ref();
        let is_on = |endpoint: &Endpoint| topic_of(about, message, [endpoint]).is_some();
        let topic = topic_of(about, message, Topic::ALL.map(Topic::endpoint));
        let input = topic_of(about, message, INPUTS);
        let is_measurement = is_on(&endpoints::MEASUREMENTS);
        let is_parameter_event = is_on(&endpoints::PARAMETER_EVENTS);
        let is_fleet_status = is_on(&endpoints::FLEET_STATUS);
        let is_recomputed = topic.is_some() || input.is_some();
        self.lines
            .message(&message.topic, message.log_time, is_recomputed);
        if is_measurement {
            // Its publish time is that of its arrival by the clock of the twin.
            self.lines.measurement(message.publish_time, &message.data);
            let found = &mut self.found;
            self.columns.measurement(message, &place, found);
        } else if input.is_none() && message.publish_time != message.log_time {
            let difference = place.difference(
                "publish time",
                seconds(message.publish_time),
                format!("{}, the log time", seconds(message.log_time)),
            );
            self.found.note_difference(difference);
        }
        if let Some(input) = input {
            self.input(input, message, &place);
        } else if let Some(topic) = topic {
            self.of_twin(Topic::ALL[topic], message, &place);
        } else if is_parameter_event {
            self.parameter_event(&message.data, &place);
        } else if is_fleet_status && let Some(fleet) = self.columns.fleet() {
            self.statuses.message(
                &message.data,
                &place,
                fleet.len(),
                self.declares_losses,
                &mut self.found,
            );
        }
        Ok(())
    }

    /// Takes a message that becomes a command.
    fn input(&mut self, input: usize, message: &recording::Message, place: &Place<'_>) {
        let named = || inputs::column_of(input, &message.data);
        let column_id = match self.columns.addressed(named) {
            Ok(column_id) => column_id,
            Err(error) => return self.found.note_difference(place.unreadable(&error)),
        };
        if !self.columns.is_wanted(&column_id, place, &mut self.found) {
            return;
        }
        self.columns
            .in_column(&column_id, &mut self.found, |column, found| {
                column
                    .inputs
                    .message(input, &message.data, message.publish_time, place, found);
            });
    }

    /// Takes a message about parameters.
    fn parameter_event(&mut self, bytes: &[u8], place: &Place<'_>) {
        match EventOfColumn::decode(bytes, self.columns.fleet(), place) {
            Ok(event) => {
                let column_id = Arc::clone(&event.column_id);
                if self.columns.is_wanted(&column_id, place, &mut self.found) {
                    self.columns
                        .in_column(&column_id, &mut self.found, |column, found| {
                            event.take(&mut column.parameter_events, place, found);
                        });
                }
            }
            Err(difference) => {
                self.found.parameter_events.recorded += 1;
                self.found.parameter_events.unexpected += 1;
                self.found.note_difference(*difference);
            }
        }
    }

    /// Takes a message of the twin.
    fn of_twin(&mut self, topic: Topic, message: &recording::Message, place: &Place<'_>) {
        let decoded = Message::decode(topic, &message.data);
        if let Ok(decoded) = &decoded {
            self.found.note_losses(decoded, message.log_time);
            if let Message::TwinStatus(status) = decoded {
                self.statuses.reported(status);
            }
        }
        let named = || {
            decoded
                .as_ref()
                .map(|it| it.column_id().unwrap_or_default().to_owned())
        };
        let column_id = match self.columns.addressed(named) {
            Ok(column_id) => column_id,
            Err(error) => return self.found.note_difference(place.unreadable(&error)),
        };
        if !self.columns.is_wanted(&column_id, place, &mut self.found) {
            return;
        }
        let recorded = RecordedBytes {
            topic,
            name: &message.topic,
            log_time: message.log_time,
            bytes: &message.data,
            message: decoded,
        };
        // What a column does is then preceded by its checkpoint, except after what the recording declares.
        let is_early = self.columns.kind().has_checkpoints_on_demand()
            && !self.lines.is_late
            && !self.declares_losses;
        self.columns
            .in_column(&column_id, &mut self.found, |column, found| {
                if column.has_checkpoint {
                    return column.replayer.message(recorded, found);
                }
                column.early[topic.index()] += 1;
                if is_early {
                    found.topics[topic.index()].unexpected += 1;
                    let own = "after a checkpoint of its column";
                    found.note_difference(place.difference("the message", "present", own));
                }
            });
        self.show_outputs();
    }

    fn line(&mut self, line: &JournalLine, publish_time: i64, place: &Place<'_>) {
        let found = &mut self.found;
        let (first, last) = found.lines.unwrap_or((line.number, line.number));
        found.lines = Some((first, last.max(line.number)));
        let is_first = self.lines.next().is_none();
        let gap = self.lines.place(line, place, publish_time, found);
        // Every recording begins with a checkpoint, except that a message may come before the first of all.
        if is_first && line.number > 0 && line.about.is_none() {
            found.missing_entries += 1;
            let missing = place.difference("the lines before this one", "absent", "a checkpoint");
            found.note_missing(1, missing);
        }
        if let Gap::Missing(lost) = gap {
            found.missing_entries = found.missing_entries.saturating_add(lost);
            let own = format!("{lost} lines");
            let missing = place.difference("the lines before this one", "absent", own);
            found.note_missing(lost, missing);
        }
        self.columns.gap(gap, place.log_time, found);
        let is_measured = self.lines.count(line, gap, is_first, place, found);
        let kind = self.columns.kind();
        let is_known = is_measured && matches!(gap, Gap::None | Gap::Earlier(0));
        self.columns.measured_before(line, is_known, place, found);
        let is_wanted = match &line.entry {
            JournalEntry::Fleet { columns } => {
                self.list(columns, place);
                // No column is in the middle of anything, except in the copy of the list with which a recording has begun late.
                self.lines.is_late &= is_first;
                self.settle(place);
                self.columns.forget_what_is_too_old();
                true
            }
            JournalEntry::End {} => {
                self.lines.ended = true;
                true
            }
            JournalEntry::RejectedByNode { stamp, .. }
                if kind.names_columns() && line.column_id.is_none() =>
            {
                // A request whose sender is not admitted names no column.
                rejected_by_node(*stamp, line.recorded, place, &mut self.found);
                true
            }
            entry => {
                let column_id = line.column_id.as_deref().unwrap_or(UNNAMED);
                let is_wanted = self.columns.is_wanted(column_id, place, &mut self.found);
                if is_wanted {
                    let is_continued = is_first || matches!(gap, Gap::Earlier(_));
                    self.entry(entry, column_id, line.recorded, is_continued, place);
                }
                // The forecasts of a response are known to be missing at its end.
                if !kind.has_checkpoints_on_demand()
                    && matches!(entry, JournalEntry::Twin(Journal::Checkpoint(_)))
                {
                    self.settle(place);
                }
                is_wanted
            }
        };
        self.show_outputs();
        if let Some(observe) = self.observe.as_mut().filter(|_| is_wanted) {
            observe(Observed::Entry(&line.entry));
            self.columns.in_each(&mut self.found, |column, _| {
                if let Some((event_id, comparisons)) = column.replayer.estimates.take_comparisons()
                {
                    observe(Observed::Compared {
                        event_id: &event_id,
                        comparisons: &comparisons,
                    });
                }
            });
        }
    }

    /// Takes a list of the columns of a fleet, which are the same in all lists.
    fn list(&mut self, columns: &[Arc<str>], place: &Place<'_>) {
        let known = self.columns.fleet();
        if !known.is_some_and(|known| {
            columns.len() == known.len() && columns.iter().all(|it| known.contains(it))
        }) {
            let number = |it: usize| format!("{it} columns");
            let own = known.map_or(0, std::collections::BTreeSet::len);
            let difference = place.difference(
                "the list of the columns",
                number(columns.len()),
                format!("the {} of the first list", number(own)),
            );
            self.found.note_difference(difference);
        }
    }

    /// Takes an entry about a column.
    fn entry(
        &mut self,
        entry: &JournalEntry,
        column_id: &str,
        recorded: i64,
        is_continued: bool,
        place: &Place<'_>,
    ) {
        let kind = self.columns.kind();
        if let JournalEntry::Twin(Journal::Command(record)) = entry {
            self.columns.at(record.now);
        }
        self.columns
            .in_column(column_id, &mut self.found, |column, found| {
                let entry = match entry {
                    JournalEntry::Twin(entry) => entry,
                    other => {
                        if let JournalEntry::RejectedByNode { stamp, .. } = other {
                            rejected_by_node(*stamp, recorded, place, found);
                        }
                        return column.inputs.line(other, is_continued, place, found);
                    }
                };
                column.has_checkpoint |= matches!(entry, Journal::Checkpoint(_));
                let before = column.replayer.parameters();
                let is_complete = column.replayer.journal(entry, place, found);
                let after = column.replayer.parameters();
                let before = before.or_else(|| after.clone());
                column
                    .parameter_events
                    .entry(before.as_deref(), after.as_deref(), found);
                if !is_complete {
                    column.inputs.restart(place.log_time, found);
                }
                match entry {
                    Journal::Checkpoint(checkpoint) => {
                        let own = &checkpoint.parameters.settings().column_id;
                        if kind.names_columns() && own != column_id {
                            let wanted = format!("{column_id:?}, as the line has it");
                            let own = format!("{own:?}");
                            found.note_difference(place.difference("column_id", own, wanted));
                        }
                        let is_continued =
                            !kind.has_checkpoints_on_demand() && checkpoint.number > 0;
                        column.inputs.checkpoint(own, is_continued, place.log_time);
                    }
                    Journal::Command(record) => {
                        column.inputs.command(&record.command, place, found);
                    }
                    Journal::Status(_) => {}
                }
            });
    }

    /// Compares what was found to be missing with the counts of the journal.
    fn settle(&mut self, place: &Place<'_>) {
        let noted = self.found.noted_missing - self.settled;
        self.lines.settle(noted, place, &mut self.found);
        self.settled = self.found.noted_missing;
    }

    fn show_outputs(&mut self) {
        if let Some(observe) = &mut self.observe {
            self.columns.in_each(&mut self.found, |column, _| {
                for output in &column.replayer.take_outputs() {
                    observe(Observed::Recomputed(output));
                }
            });
        }
    }

    fn finish(mut self) -> Result<Verification, VerifyError> {
        let wholeness = self.reader.wholeness();
        if self.found.checkpoints == 0 && !self.columns.kind().has_checkpoints_on_demand() {
            let wholeness = wholeness.to_string();
            return Err(VerifyError::NoCheckpoint { wholeness });
        }
        let place = Place {
            topic: self.journal,
            log_time: self.last_log_time,
            ..Place::default()
        };
        let is_stopped = self.lines.ended;
        let is_damaged = self.reader.damaged_records() > 0;
        let is_continuation = self.lines.is_continuation();
        let last_log_time = self.last_log_time;
        self.columns.in_each(&mut self.found, |column, found| {
            let replayer = std::mem::take(&mut column.replayer);
            replayer.finish(is_stopped, is_continuation, &place, found);
            let inputs = std::mem::take(&mut column.inputs);
            inputs.finish(last_log_time, is_stopped, found);
            std::mem::take(&mut column.parameter_events).finish(found);
            let early_messages: u64 = column.early.iter().sum();
            if early_messages > 0 {
                found.note_unchecked(format!(
                    "{early_messages} messages were recorded before the first checkpoint"
                ));
                for (check, count) in found.topics.iter_mut().zip(column.early) {
                    check.recorded += count;
                    check.unchecked += count;
                }
            }
        });
        self.settle(&place);
        let Self {
            reader,
            lines,
            mut found,
            ..
        } = self;
        lines.finish(&place, &mut found);
        let moved = reader.out_of_order();
        if moved > 0 {
            let difference = place.difference(
                "order in the file",
                format!("{moved} messages after one with a later log time"),
                "the order of log times",
            );
            found.note_differences(moved, difference);
        }
        if !wholeness.is_whole() {
            found.note_unchecked(format!("the recording is {wholeness}"));
        } else if is_damaged {
            found.note_unchecked(format!(
                "{} damaged records were left out when the recording was repaired",
                reader.damaged_records()
            ));
        }
        let lost = reader.lost_messages().unwrap_or_default();
        found.ending = ending(reader, is_stopped).to_owned();
        let may_end = reader.ended().is_some_and(|it| it != "stopped") || !wholeness.is_whole();
        if !is_stopped && !may_end {
            let end = "the line that the recorder writes when it is stopped";
            found.missing_entries += 1;
            found.note_missing(1, place.difference("the end of the journal", "absent", end));
        }
        found.unread = reader.unread_messages();
        found.is_damaged = is_damaged;
        found.weigh_losses(lost, is_damaged);
        Ok(found)
    }
}

/// Takes note of a message that the node rejected when the line about it was recorded.
fn rejected_by_node(stamp: i64, recorded: i64, place: &Place<'_>, found: &mut Verification) {
    found.rejected_by_node += 1;
    if stamp != recorded {
        found.note_difference(place.difference("stamp", seconds(stamp), seconds(recorded)));
    }
}

/// How a recording ends.
fn ending(reader: &Reader, is_stopped: bool) -> &'static str {
    match (is_stopped, reader.ended()) {
        (true, _) => "the recorder was stopped after the last one",
        (false, Some("rotated")) => "the next recording continues after the last one",
        (false, Some("no_room")) => "the disk was full after the last one",
        (false, Some("repaired")) => "the messages after the last one were cut off before a repair",
        (false, _) if !reader.wholeness().is_whole() => {
            "the messages after the last one are cut off"
        }
        (false, _) => "the end is missing",
    }
}

/// Finds the endpoint of a recorded message: by the names in the journal or, before its first checkpoint, by type and name.
fn topic_of<const COUNT: usize>(
    about: Option<&About>,
    message: &recording::Message,
    endpoints: [&Endpoint; COUNT],
) -> Option<usize> {
    endpoints.iter().position(|endpoint| match about {
        Some(about) => about
            .topics
            .get(endpoint.name)
            .is_some_and(|it| **it == *message.topic),
        None => {
            *message.type_name == *endpoint.type_name
                && message
                    .topic
                    .ends_with(endpoint.name.trim_start_matches("~/"))
        }
    })
}
