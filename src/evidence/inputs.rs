//! Compares the messages that the node received with the journal: each one with the line that describes it, and with the
//! command that the twin was given.

use std::collections::VecDeque;

use super::about::sha256_of;
use super::comparison::{Difference, Place, seconds};
use super::journal_line::JournalEntry;
use super::topics::INPUTS;
use super::verification::Verification;
use crate::endpoints;
use crate::incoming::{column_command, impact_command};
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin_msgs::{ColumnParameters, ImpactEvent};
use crate::time::Nanos;
use crate::twin::{Command, RejectionCode};

/// Maximum time from a message to its command in the journal \[ns\]. Without a command by then, and if the journal goes on, it
/// did not reach the twin.
pub const MAX_WAIT: Nanos = 10_000_000_000;

/// Received messages that wait for their command.
#[derive(Debug, Default)]
pub(super) struct Inputs {
    topics: [Waiting; INPUTS.len()],
    /// Name of the twin's column; `None` before the first checkpoint.
    column_id: Option<String>,
    /// Messages of before the recording may still wait for their commands: until this log time.
    earlier_until: Option<Nanos>,
}

#[derive(Debug, Default)]
struct Waiting {
    messages: VecDeque<Received>,
    /// The last message, until the line that describes it is read.
    undescribed: Option<Described>,
    /// Messages that could not be recorded and whose commands follow.
    unrecorded: u64,
}

/// A message that waits for its command.
#[derive(Debug)]
struct Received {
    bytes: Vec<u8>,
    place: Difference,
    log_time: Nanos,
    /// The solver did not answer in time: the command may be executed or not.
    optional: bool,
}

/// What the journal has to tell about a message.
#[derive(Debug, PartialEq)]
struct Described {
    published: Nanos,
    sha256: String,
}

impl Inputs {
    /// Takes the name of the column from a checkpoint. If it continues another recording, the last messages of that may have
    /// their commands here.
    pub fn checkpoint(&mut self, column_id: &str, is_continued: bool, log_time: Nanos) {
        if self.column_id.is_none() {
            self.column_id = Some(column_id.to_owned());
            if is_continued {
                self.continue_at(log_time);
            }
        }
    }

    /// Takes a recorded message of the topic [`INPUTS`]`[topic]`.
    pub fn message(
        &mut self,
        topic: usize,
        bytes: &[u8],
        publish_time: Nanos,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let waiting = &mut self.topics[topic];
        found.inputs_of[topic].recorded += 1;
        let described = Described {
            published: publish_time,
            sha256: sha256_of(bytes),
        };
        if waiting.undescribed.replace(described).is_some() {
            undescribed(topic, place, found);
        }
        let present = place.difference("the message", "present", "absent");
        waiting.messages.push_back(Received {
            bytes: bytes.to_vec(),
            place: present,
            log_time: place.log_time,
            optional: false,
        });
    }

    /// Takes a line of the journal that is not an entry of the twin; `is_continued` if the message right before it may be in an
    /// earlier recording.
    pub fn line(
        &mut self,
        entry: &JournalEntry,
        is_continued: bool,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        match entry {
            JournalEntry::Received {
                topic,
                published,
                sha256,
            } => {
                let Some(index) = index_of(topic) else {
                    let known = INPUTS.map(|it| it.name).join(", ");
                    return found.note_difference(place.difference("topic", topic.clone(), known));
                };
                let described = Described {
                    published: *published,
                    sha256: sha256.clone(),
                };
                // The recording may have begun between the message and this line, but also before the message.
                if !is_continued || self.topics[index].undescribed.is_some() {
                    self.described(index, &described, place, found);
                }
            }
            JournalEntry::RejectedByNode {
                topic, what, code, ..
            } => self.rejected(topic, what, *code, place, found),
            JournalEntry::Twin(_)
            | JournalEntry::Sensors { .. }
            | JournalEntry::Fleet { .. }
            | JournalEntry::End {} => {}
        }
    }

    fn described(
        &mut self,
        index: usize,
        described: &Described,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let waiting = &mut self.topics[index];
        let Some(message) = waiting.undescribed.take() else {
            waiting.unrecorded += 1;
            found.inputs_of[index].missing += 1;
            return found.note_missing(
                1,
                place.difference(INPUTS[index].name, "absent", "a message that was received"),
            );
        };
        if message == *described {
            return;
        }
        let difference = match message.published == described.published {
            true => place.difference(
                format!("SHA-256 of the message on {}", INPUTS[index].name),
                message.sha256,
                described.sha256.clone(),
            ),
            false => place.difference(
                format!("publish time of the message on {}", INPUTS[index].name),
                seconds(message.published),
                seconds(described.published),
            ),
        };
        found.inputs_of[index].differing += 1;
        found.note_difference(difference);
    }

    fn rejected(
        &mut self,
        topic: &str,
        what: &str,
        code: Option<RejectionCode>,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let Some(index) = index_of(topic) else {
            return;
        };
        let may_be_earlier = self.may_be_earlier(place);
        let waiting = &mut self.topics[index];
        match code {
            // The message could not be recorded; its command follows all the same.
            None => waiting.unrecorded += 1,
            // What a sender sends that is not allowed to, or sends too much, is not recorded.
            Some(RejectionCode::SenderNotAllowed | RejectionCode::SenderTooFast) => {}
            Some(RejectionCode::NoAnswer) => {
                if let Some(last) = waiting.messages.back_mut() {
                    last.optional = true;
                }
            }
            Some(_) => {
                let of_impact = |it: &Received| match command(index, &it.bytes, "") {
                    Ok(Command::Impact(impact)) => impact.event_id == what,
                    _ => true,
                };
                match waiting.messages.iter().rposition(of_impact) {
                    Some(position) => {
                        waiting.messages.remove(position);
                        found.inputs_of[index].compared += 1;
                    }
                    None if may_be_earlier => {}
                    None => {
                        let present = "a message that the node rejected";
                        found.inputs_of[index].missing += 1;
                        found.note_missing(1, place.difference(topic, "absent", present));
                    }
                }
            }
        }
    }

    /// Whether the message that led to what is at this place may be in an earlier recording, even if there is one like it in this
    /// recording: an event may come twice.
    fn may_be_earlier(&self, place: &Place<'_>) -> bool {
        self.earlier_until.is_some_and(|it| place.log_time <= it)
    }

    /// Compares a command of the journal with the message from which it follows.
    pub fn command(&mut self, own: &Command, place: &Place<'_>, found: &mut Verification) {
        let index = match own {
            Command::Impact(_) => 0,
            Command::SetParameters { source, .. } | Command::RejectedChange { source, .. }
                if **source == *endpoints::COLUMN_PARAMETERS.name =>
            {
                1
            }
            _ => return,
        };
        let may_be_earlier = self.may_be_earlier(place);
        let waiting = &mut self.topics[index];
        let column_id = self.column_id.as_deref().unwrap_or_default();
        let follows = |it: &Received| {
            let recorded = command(index, &it.bytes, column_id);
            // A number that is not one is equal to itself here.
            recorded.is_ok_and(|it| Place::default().first_difference(&it, own).is_none())
        };
        while waiting.messages.len() > 1
            && waiting.messages[0].optional
            && !follows(&waiting.messages[0])
        {
            waiting.messages.pop_front();
        }
        let Some(first) = waiting.messages.front() else {
            return self.without_message(index, place, found);
        };
        // A message before the recording, or one that could not be recorded, may have led to this command.
        if (waiting.unrecorded > 0 || may_be_earlier) && !follows(first) {
            return self.without_message(index, place, found);
        }
        let Some(first) = waiting.messages.pop_front() else {
            return;
        };
        found.inputs_of[index].compared += 1;
        let difference = match command(index, &first.bytes, column_id) {
            Ok(recorded) => {
                first
                    .place_in(place)
                    .first_difference(&recorded, own)
                    .map(|difference| Difference {
                        field: format!("command.{}", difference.field),
                        ..difference
                    })
            }
            Err(error) => Some(first.place_in(place).unreadable(&error)),
        };
        if let Some(difference) = difference {
            found.inputs_of[index].differing += 1;
            found.note_difference(difference);
        }
    }

    fn without_message(&mut self, index: usize, place: &Place<'_>, found: &mut Verification) {
        let may_be_earlier = self.may_be_earlier(place);
        let waiting = &mut self.topics[index];
        if waiting.unrecorded > 0 {
            waiting.unrecorded -= 1;
            return;
        }
        if may_be_earlier {
            return;
        }
        found.inputs_of[index].missing += 1;
        let present = "the message that led to this command";
        found.note_missing(1, place.difference(INPUTS[index].name, "absent", present));
    }

    /// The messages before this log time are in an earlier recording.
    pub fn continue_at(&mut self, log_time: Nanos) {
        self.earlier_until = Some(log_time.saturating_add(MAX_WAIT));
    }

    /// Forgets everything that waits: commands of the journal are missing before this log time.
    pub fn restart(&mut self, log_time: Nanos, found: &mut Verification) {
        for (index, waiting) in self.topics.iter_mut().enumerate() {
            found.inputs_of[index].unchecked += waiting.messages.len() as u64;
            *waiting = Waiting::default();
        }
        self.continue_at(log_time);
    }

    /// Ends the recording, whose last log time is this one; `is_stopped` if its journal has an end.
    pub fn finish(self, end: Nanos, is_stopped: bool, found: &mut Verification) {
        for (index, waiting) in self.topics.into_iter().enumerate() {
            if is_stopped
                && waiting.undescribed.is_some()
                && let Some(last) = waiting.messages.back()
            {
                found.inputs_of[index].unexpected += 1;
                found.note_difference(last.place.clone());
            }
            let mut unanswered = 0_u64;
            for message in waiting.messages {
                if message.optional {
                    continue;
                }
                if message.log_time.saturating_add(MAX_WAIT) >= end {
                    unanswered += 1;
                    continue;
                }
                found.inputs_of[index].unexpected += 1;
                found.note_difference(Difference {
                    field: "the command of the message".to_owned(),
                    recorded: "absent from the journal".to_owned(),
                    computed: "present".to_owned(),
                    ..message.place
                });
            }
            if unanswered > 0 {
                found.inputs_of[index].unchecked += unanswered;
                found.note_unchecked(format!(
                    "{unanswered} messages on {} came at the end of the recording, which does not have their commands",
                    INPUTS[index].name
                ));
            }
        }
    }
}

impl Received {
    /// The place of this message for a difference that shows at `place`.
    fn place_in<'a>(&'a self, place: &Place<'a>) -> Place<'a> {
        Place {
            topic: &self.place.topic,
            log_time: self.log_time,
            ..*place
        }
    }
}

fn undescribed(topic: usize, place: &Place<'_>, found: &mut Verification) {
    found.inputs_of[topic].unexpected += 1;
    found.note_difference(place.difference(
        "the line of the journal about the message before",
        "absent",
        "present",
    ));
}

/// Index of a topic in [`INPUTS`] by its name in the table of endpoints.
fn index_of(topic: &str) -> Option<usize> {
    INPUTS.iter().position(|it| it.name == topic)
}

/// The column that a message on the topic [`INPUTS`]`[topic]` is for.
pub(super) fn column_of(topic: usize, bytes: &[u8]) -> Result<String, CdrError> {
    match topic {
        0 => cdr::decode::<ImpactEvent>(bytes).map(|it| it.column_id),
        _ => cdr::decode::<ColumnParameters>(bytes).map(|it| it.column_id),
    }
}

/// The command that follows from a message.
fn command(index: usize, bytes: &[u8], column_id: &str) -> Result<Command, CdrError> {
    match index {
        0 => cdr::decode(bytes).map(impact_command),
        _ => cdr::decode(bytes).map(|message| column_command(&message, column_id)),
    }
}
