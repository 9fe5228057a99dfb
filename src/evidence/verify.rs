//! Verifies a recording by recomputation.

use std::path::Path;
use std::sync::Arc;

use super::about::About;
use super::comparison::{Place, seconds};
use super::inputs::{INPUTS, Inputs};
use super::journal_line::{JournalEntry, JournalError, JournalLine};
use super::lines::{Gap, Lines};
use super::parameter_events::ParameterEvents;
use super::replayer::{RecordedBytes, Replayer};
use super::verification::Verification;
use crate::endpoints::{self, Endpoint};
use crate::outgoing::Topic;
use crate::recording::{self, Reader, RecordingError};
use crate::twin::{Journal, Output};

/// Why a recording cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording has no journal.
    #[error(
        "the recording has no topic {name} of type {type_name}, without which it cannot be recomputed; record with the \
         parameter record.mode of column-twin run, or with column-twin simulate --record",
        type_name = endpoints::JOURNAL.type_name,
        name = endpoints::JOURNAL.name
    )]
    NoJournal,
    /// The journal cannot be read.
    #[error(transparent)]
    Journal(#[from] JournalError),
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

/// What an observer of a verification is shown, in the order of the recording.
#[derive(Debug)]
pub enum Observed<'a> {
    /// An entry of the journal.
    Entry(&'a JournalEntry),
    /// A state or a report that was recomputed.
    Recomputed(&'a Output),
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
    verify_with(reader, None)
}

/// As [`verify`](fn@verify) of an open recording, and shows an observer the journal and what is recomputed from it: the
/// outputs that precede an entry first.
///
/// # Errors
/// As [`verify`](fn@verify).
pub fn verify_observed(
    reader: &Reader,
    observe: &mut dyn FnMut(Observed<'_>),
) -> Result<Verification, VerifyError> {
    verify_with(reader, Some(observe))
}

fn verify_with(
    reader: &Reader,
    observe: Option<&mut dyn FnMut(Observed<'_>)>,
) -> Result<Verification, VerifyError> {
    let journal = reader
        .topics()
        .iter()
        .find(|it| recording::is_journal(it))
        .map(|it| Arc::clone(&it.name))
        .ok_or(VerifyError::NoJournal)?;
    let mut pass = VerifyingPass::new(reader, &journal, observe);
    pass.found.about = about(reader, &journal)?;
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

/// The program that made the recording, from the first checkpoint: the names of its topics are needed from the beginning.
fn about(reader: &Reader, journal: &str) -> Result<Option<About>, VerifyError> {
    let lines = reader.messages().filter_map(Result::ok);
    for message in lines.filter(|it| *it.topic == *journal) {
        let line = JournalLine::decode(&message.data)?;
        if line.about.is_some() {
            return Ok(line.about);
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
    inputs: Inputs,
    replayer: Replayer,
    parameter_events: ParameterEvents,
    found: Verification,
    /// Missing messages that were noted when the counts of the journal were last settled.
    settled: u64,
    /// Messages of the twin before the first checkpoint, by topic.
    early: [u64; Topic::COUNT],
    last_log_time: i64,
}

impl<'a, 'o> VerifyingPass<'a, 'o> {
    fn new(
        reader: &'a Reader,
        journal: &'a str,
        observe: Option<&'o mut dyn FnMut(Observed<'_>)>,
    ) -> Self {
        let is_damaged = reader.damaged_records() > 0;
        let lost = reader.lost_messages().unwrap_or_default();
        Self {
            reader,
            journal,
            lines: Lines::new(!is_damaged, reader.repeats_checkpoint()),
            inputs: Inputs::default(),
            replayer: Replayer::new(observe.is_some(), is_damaged || lost > 0),
            observe,
            parameter_events: ParameterEvents::default(),
            found: Verification::default(),
            settled: 0,
            early: [0; Topic::COUNT],
            last_log_time: 0,
        }
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
        let topic = topic_of(
            self.found.about.as_ref(),
            message,
            Topic::ALL.map(Topic::endpoint),
        );
        let input = topic_of(self.found.about.as_ref(), message, INPUTS);
        let is_recomputed = topic.is_some() || input.is_some();
        self.lines
            .message(&message.topic, message.log_time, is_recomputed);
        let is_measurement = topic_of(
            self.found.about.as_ref(),
            message,
            [&endpoints::MEASUREMENTS],
        )
        .is_some();
        if is_measurement {
            // Its publish time is that of its arrival by the clock of the twin.
            self.lines.measurement(message.publish_time, &message.data);
            self.replayer.estimates.measured.message(
                &message.data,
                message.publish_time,
                &place,
                &mut self.found,
            );
        } else if input.is_none() && message.publish_time != message.log_time {
            let difference = place.difference(
                "publish time",
                seconds(message.publish_time),
                format!("{}, the log time", seconds(message.log_time)),
            );
            self.found.note_difference(difference);
        }
        if let Some(input) = input {
            self.inputs.message(
                input,
                &message.data,
                message.publish_time,
                &place,
                &mut self.found,
            );
        } else if let Some(topic) = topic {
            if self.found.checkpoints == 0 {
                self.early[topic] += 1;
                return Ok(());
            }
            let recorded = RecordedBytes {
                topic: Topic::ALL[topic],
                name: &message.topic,
                log_time: message.log_time,
                bytes: &message.data,
            };
            self.replayer.message(&recorded, &mut self.found);
            self.show_outputs();
        } else if topic_of(
            self.found.about.as_ref(),
            message,
            [&endpoints::PARAMETER_EVENTS],
        )
        .is_some()
        {
            self.parameter_events
                .message(&message.data, &place, &mut self.found);
        }
        Ok(())
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
        self.replayer.gap(gap, place, found);
        match gap {
            Gap::Missing(_) => self.inputs.restart(found),
            Gap::Earlier(_) => self.inputs.continue_at(place.log_time),
            Gap::None => {}
        }
        let measured = &mut self.replayer.estimates.measured;
        let is_measured = self.lines.count(line, gap, is_first, place, found);
        let is_next = matches!(gap, Gap::None | Gap::Earlier(0));
        if line.since.lost_measurements > 0 {
            measured.lose("measurements that the node took could not be recorded");
        } else if !is_measured || !is_next {
            measured.lose("measurements are missing, or are not those that the journal tells of");
        }
        if let JournalEntry::Twin(Journal::Checkpoint(checkpoint)) = &line.entry {
            measured.checkpoint(line.intake.as_ref(), &checkpoint.parameters, place, found);
        }
        match &line.entry {
            JournalEntry::Twin(entry) => {
                let before = self.replayer.parameters();
                let is_complete = self.replayer.journal(entry, place, found);
                let after = self.replayer.parameters();
                let before = before.or_else(|| after.clone());
                self.parameter_events
                    .entry(before.as_deref(), after.as_deref(), found);
                if !is_complete {
                    self.inputs.restart(found);
                }
                match entry {
                    Journal::Checkpoint(checkpoint) => {
                        let column_id = &checkpoint.parameters.settings().column_id;
                        self.inputs
                            .checkpoint(column_id, checkpoint.number, place.log_time);
                    }
                    Journal::Command(record) => self.inputs.command(&record.command, place, found),
                    Journal::Status(_) => {}
                }
                // The forecasts of a response are known to be missing at its end.
                if matches!(entry, Journal::Checkpoint(_)) {
                    self.settle(place);
                }
            }
            JournalEntry::End {} => self.lines.ended = true,
            other => {
                if let JournalEntry::RefusedByNode { stamp, .. } = other {
                    found.refused_by_node += 1;
                    if *stamp != line.recorded {
                        let own = seconds(line.recorded);
                        found.note_difference(place.difference("stamp", seconds(*stamp), own));
                    }
                }
                let is_continued = is_first || matches!(gap, Gap::Earlier(_));
                self.inputs.line(other, is_continued, place, found);
            }
        }
        self.show_outputs();
        if let Some(observe) = &mut self.observe {
            observe(Observed::Entry(&line.entry));
        }
    }

    /// Compares what was found to be missing with the counts of the journal.
    fn settle(&mut self, place: &Place<'_>) {
        let noted = self.found.noted_missing - self.settled;
        self.lines.settle(noted, place, &mut self.found);
        self.settled = self.found.noted_missing;
    }

    fn show_outputs(&mut self) {
        if let Some(observe) = &mut self.observe {
            for output in &self.replayer.take_outputs() {
                observe(Observed::Recomputed(output));
            }
        }
    }

    fn finish(mut self) -> Result<Verification, VerifyError> {
        let wholeness = self.reader.wholeness();
        if self.found.checkpoints == 0 {
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
        let replayer = std::mem::take(&mut self.replayer);
        replayer.finish(is_stopped, is_continuation, &place, &mut self.found);
        std::mem::take(&mut self.parameter_events).finish(&mut self.found);
        let inputs = std::mem::take(&mut self.inputs);
        inputs.finish(self.last_log_time, is_stopped, &mut self.found);
        self.settle(&place);
        let Self {
            reader,
            lines,
            mut found,
            early,
            ..
        } = self;
        lines.finish(&place, &mut found);
        let early_messages: u64 = early.iter().sum();
        if early_messages > 0 {
            found.note_unchecked(format!(
                "{early_messages} messages were recorded before the first checkpoint"
            ));
            for (check, count) in found.topics.iter_mut().zip(early) {
                check.recorded += count;
                check.unchecked += count;
            }
        }
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
        found.weigh_losses(lost, is_damaged);
        Ok(found)
    }
}

/// How a recording ends.
fn ending(reader: &Reader, is_stopped: bool) -> &'static str {
    match (is_stopped, reader.ended()) {
        (true, _) => "the recorder was stopped after the last one",
        (false, Some("rotated")) => "the next recording continues after the last one",
        (false, Some("no_room")) => "the disk was full after the last one",
        (false, Some("repaired")) => "what followed the last one was cut off before a repair",
        (false, _) if !reader.wholeness().is_whole() => "what followed the last one is cut off",
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
