//! Follows a recorded journal with a twin of its own, and compares what that gives out.

use std::collections::VecDeque;

use super::comparison::{Difference, first_difference};
use super::journal_line::LineEntry;
use super::verification::{TopicCheck, Verification};
use crate::column::ModelError;
use crate::live::monotonic_nanos;
use crate::messages::column_twin::{ImpactReport, TwinStatus};
use crate::outgoing::{Message, Outgoing, Topic};
use crate::twin::{Checkpoint, CommandRecord, Journal, Output, Position, StatusRecord, Twin};

/// A recorded message of the twin.
pub(super) struct Recorded<'a> {
    pub topic: Topic,
    pub name: &'a str,
    pub log_time: i64,
    pub bytes: &'a [u8],
}

/// Reads a recording in its order.
#[derive(Default)]
pub(super) struct Replayer {
    /// `None` while it is not known where the recorded twin is.
    course: Option<Course>,
    /// What the next checkpoint or input is to be numbered; `None` before the first.
    next_number: Option<u64>,
    /// Nothing numbered has come behind the first checkpoint.
    is_beginning: bool,
    pub findings: Verification,
}

/// A twin on the way of the recorded one.
struct Course {
    twin: Twin,
    outgoing: Outgoing,
    /// What it gave out and was not found in the recording yet.
    computed: [VecDeque<Computed>; Topic::COUNT],
    /// Messages it gave out.
    count: u64,
    /// The newest message that was found.
    newest_found: u64,
    /// Recorded messages that the twin does not give out, since the journal was last seen to be complete.
    foreign: Foreign,
}

/// Recorded messages that a twin does not give out: forged where the journal is complete, and else such that belong to
/// what is missing in it. A recording that begins in the middle of a response (the one before could not go on: a full
/// disk) begins with the last checkpoint, and lacks what the twin was given since.
#[derive(Default)]
struct Foreign {
    count: [u64; Topic::COUNT],
    first: Option<Difference>,
}

struct Computed {
    number: u64,
    message: Message,
}

impl Replayer {
    /// Takes an entry of the journal; `name` is the topic's.
    pub fn journal(&mut self, entry: &LineEntry, name: &str, log_time: i64) {
        let place = Place { name, log_time };
        match entry {
            LineEntry::Twin(Journal::Checkpoint(point)) => self.checkpoint(point, &place),
            LineEntry::Twin(Journal::Command(record)) => self.command(record, &place),
            LineEntry::Twin(Journal::Status(taken)) => self.status_taken(*taken, &place),
            LineEntry::RefusedByNode { .. } => self.findings.refused_by_node += 1,
        }
    }

    fn checkpoint(&mut self, point: &Checkpoint, place: &Place<'_>) {
        self.findings.checkpoints += 1;
        let here = Position {
            response: point.response,
            step: None,
        };
        self.number_is(point.number, place);
        self.next_number = Some(point.number.saturating_add(1));
        self.is_beginning = self.findings.checkpoints == 1;
        self.come_to(here, place);
        let Some(course) = &mut self.course else {
            return self.begin(point, place);
        };
        let Some(mut computed) = course.twin.checkpoint(point.stamp) else {
            return;
        };
        computed.number = point.number;
        self.findings.states_at_rest += 1;
        match first_difference(point, &computed) {
            None => {
                // As the node's does at this place.
                let passed = Journal::Checkpoint(std::sync::Arc::new(computed));
                course.outgoing.convert(&Output::Journal(passed), |_| {});
            }
            Some(found) => {
                let stamp = Some(point.stamp);
                self.findings
                    .differs(place.difference(found, stamp, &point.life.last_event_id));
                self.begin(point, place);
            }
        }
    }

    /// Begins anew where the recorded twin was.
    fn begin(&mut self, point: &Checkpoint, place: &Place<'_>) {
        self.end_course();
        match Course::new(point) {
            Ok(course) => self.course = Some(course),
            Err(error) => {
                let time = super::comparison::seconds(place.log_time);
                self.findings.unchecked_because(format!(
                    "the checkpoint at {time} s is of no possible column: {error}"
                ));
            }
        }
    }

    fn command(&mut self, record: &CommandRecord, place: &Place<'_>) {
        self.findings.inputs += 1;
        self.number_is(record.number, place);
        self.next_number = Some(record.number.saturating_add(1));
        self.come_to(record.position, place);
        let Some(course) = &mut self.course else {
            return;
        };
        if record.taken_back && !course.twin.knows_last_response() {
            return self.lose_track(
                "an impact came so late that it belongs into a response before the recording"
                    .to_owned(),
            );
        }
        let mut out = Vec::new();
        // The outcome is in the journal that the twin gives out.
        let _ = course
            .twin
            .handle(record.command.clone(), record.now, &mut out);
        course.twin.run_ahead(u64::MAX, record.now, &mut out);
        course.gave_out(&out);
        let own = out.iter().find_map(|output| match output {
            Output::Journal(Journal::Command(own)) => Some(own),
            _ => None,
        });
        let Some(own) = own else { return };
        let outcome = |it: &CommandRecord| (it.refusal.clone(), it.taken_back);
        if let Some(found) = first_difference(&outcome(record), &outcome(own)) {
            let found = super::comparison::FieldDifference {
                field: "what became of an input".to_owned(),
                ..found
            };
            self.findings
                .differs(place.difference(found, Some(record.now), ""));
        }
    }

    fn status_taken(&mut self, taken: StatusRecord, place: &Place<'_>) {
        self.number_is(taken.next_number, place);
        self.come_to(taken.position, place);
        if let Some(course) = &mut self.course {
            let status = course.twin.status(taken.stamp);
            course.gave_out(&[Output::Status(status)]);
        }
    }

    /// The journal is at this number: complete so far, or not.
    fn number_is(&mut self, number: u64, place: &Place<'_>) {
        let is_beginning = std::mem::take(&mut self.is_beginning);
        let expected = self.next_number.replace(number).unwrap_or(number);
        if number < expected {
            let found = super::comparison::FieldDifference {
                field: "the number of the entry".to_owned(),
                recorded: number.to_string(),
                computed: expected.to_string(),
                by: None,
            };
            self.findings.differs(place.difference(found, None, ""));
            return self.lose_track("the numbers of the journal go back".to_owned());
        }
        let lost = number - expected;
        if lost > 0 {
            // A recording that had to begin in the middle of a response begins with the last checkpoint, and what the
            // twin was given since stands in the recording before. Anywhere else each number must be there.
            if !is_beginning {
                let missing = &mut self.findings.missing_entries;
                *missing = missing.saturating_add(lost);
            }
            return self.lose_track(format!("{lost} entries of the journal are missing"));
        }
        let Some(course) = &mut self.course else {
            return;
        };
        let Foreign { count, first } = std::mem::take(&mut course.foreign);
        for (check, count) in self.findings.topics.iter_mut().zip(count) {
            check.foreign += count;
            self.findings.differences += count;
        }
        if self.findings.first_difference.is_none() {
            self.findings.first_difference = first;
        }
    }

    /// Takes a message that the recorded twin gave out.
    pub fn message(&mut self, recorded: &Recorded<'_>) {
        let place = Place {
            name: recorded.name,
            log_time: recorded.log_time,
        };
        let message = match Message::decode(recorded.topic, recorded.bytes) {
            Ok(message) => message,
            Err(error) => {
                let found = super::comparison::FieldDifference {
                    field: "the message".to_owned(),
                    recorded: format!("unreadable ({error})"),
                    computed: "a message of this type".to_owned(),
                    by: None,
                };
                return self.findings.differs(place.difference(found, None, ""));
            }
        };
        let check = &mut self.findings.topics[recorded.topic.index()];
        check.recorded += 1;
        self.findings.note_losses(&message);
        let Some(course) = &mut self.course else {
            self.findings.topics[recorded.topic.index()].unchecked += 1;
            return;
        };
        match course.find(recorded.topic, &message) {
            Some(found) => self.findings.topics[recorded.topic.index()].compare(
                &place,
                &message,
                found,
                recorded.bytes,
            ),
            None => {
                let found = super::comparison::FieldDifference {
                    field: "the message".to_owned(),
                    recorded: "there".to_owned(),
                    computed: "none".to_owned(),
                    by: None,
                };
                let event = message.event_id().unwrap_or_default().to_owned();
                let found = place.difference(found, message.stamp(), &event);
                course.foreign.count[recorded.topic.index()] += 1;
                course.foreign.first.get_or_insert(found);
                return;
            }
        }
        let newest = course.newest_found;
        let missing = course.missing_before(recorded.topic, newest);
        self.findings.topics[recorded.topic.index()].missing += missing;
        self.findings.take_difference(recorded.topic);
    }

    /// Follows the twin to where the recorded one was.
    fn come_to(&mut self, wanted: Position, place: &Place<'_>) {
        let Some(course) = &mut self.course else {
            return;
        };
        let mut out = Vec::new();
        let reached = course.twin.advance_to_position(wanted, &mut out);
        course.gave_out(&out);
        if let Err(not_reached) = reached {
            let words = |position: Position| match position.step {
                Some(step) => format!("step {step} of response {}", position.response),
                None => format!("at rest after response {}", position.response),
            };
            let found = super::comparison::FieldDifference {
                field: "how far the twin had come".to_owned(),
                recorded: words(not_reached.wanted),
                computed: words(not_reached.found),
                by: None,
            };
            self.findings.differs(place.difference(found, None, ""));
            self.lose_track("the twin went another way".to_owned());
        }
    }

    fn lose_track(&mut self, why: String) {
        self.end_course();
        self.findings
            .unchecked_because(format!("{why}; not checked until the next checkpoint"));
    }

    /// What was computed and should have been recorded by now is missing.
    fn end_course(&mut self) {
        let Some(mut course) = self.course.take() else {
            return;
        };
        for topic in Topic::ALL {
            let newest = course.newest_found;
            let check = &mut self.findings.topics[topic.index()];
            check.missing += course.missing_before(topic, newest);
            check.unchecked += course.foreign.count[topic.index()];
        }
        let foreign: u64 = course.foreign.count.iter().sum();
        if foreign > 0 {
            self.findings.unchecked_because(format!(
                "{foreign} messages belong to what came before the recording, or is missing in its journal"
            ));
        }
    }

    /// The end of the recording.
    pub fn finish(mut self) -> Verification {
        self.end_course();
        self.findings
    }
}

impl Course {
    fn new(point: &Checkpoint) -> Result<Self, ModelError> {
        let stopwatch = Box::new(monotonic_nanos);
        Ok(Self {
            twin: Twin::from_checkpoint(point, stopwatch)?,
            outgoing: Outgoing::new(&point.parameters),
            computed: Default::default(),
            count: 0,
            newest_found: 0,
            foreign: Foreign::default(),
        })
    }

    fn gave_out(&mut self, outputs: &[Output]) {
        for output in outputs {
            // The twin's own journal is not that of the recording.
            if matches!(output, Output::Journal(_)) {
                continue;
            }
            self.outgoing.convert(output, |message| {
                self.count += 1;
                let number = self.count;
                self.computed[message.topic().index()].push_back(Computed { number, message });
            });
        }
    }

    /// The computed message that belongs to a recorded one; those before it stay for
    /// [`missing_before`](Self::missing_before).
    fn find(&mut self, topic: Topic, recorded: &Message) -> Option<Message> {
        let same = |it: &Computed| {
            it.message.stamp() == recorded.stamp() && it.message.event_id() == recorded.event_id()
        };
        let mut index = self.computed[topic.index()].iter().position(same);
        if index.is_none() && topic != Topic::TwinStatus {
            let stamp = recorded.stamp()?;
            let mut out = Vec::new();
            self.twin.advance_to_instant(stamp, &mut out);
            self.gave_out(&out);
            index = self.computed[topic.index()].iter().position(same);
        }
        let found = self.computed[topic.index()].remove(index?)?;
        self.newest_found = self.newest_found.max(found.number);
        Some(found.message)
    }

    /// Takes out what was given out before message `newest` and is still there, and counts it. A forecast is no loss:
    /// that of a response which another impact ended may never have been complete.
    fn missing_before(&mut self, topic: Topic, newest: u64) -> u64 {
        let queue = &mut self.computed[topic.index()];
        if topic == Topic::ImpactForecast {
            return 0;
        }
        let before = queue.len();
        queue.retain(|it| it.number >= newest);
        (before - queue.len()) as u64
    }
}

/// Where in the recording.
pub(super) struct Place<'a> {
    pub name: &'a str,
    pub log_time: i64,
}

impl Place<'_> {
    pub fn difference(
        &self,
        found: super::comparison::FieldDifference,
        stamp: Option<i64>,
        event_id: &str,
    ) -> Difference {
        Difference {
            topic: self.name.to_owned(),
            log_time: self.log_time,
            stamp,
            event_id: event_id.to_owned(),
            field: found.field,
            recorded: found.recorded,
            computed: found.computed,
            by: found.by,
        }
    }
}

impl TopicCheck {
    /// Compares all that the model can know of a message.
    fn compare(&mut self, place: &Place<'_>, recorded: &Message, computed: Message, bytes: &[u8]) {
        self.compared += 1;
        let computed = with_what_nobody_can_recompute(computed, recorded);
        // Equal bytes are equal values. Others may write other bytes between the values.
        if computed.encode().is_ok_and(|own| own == bytes) {
            return;
        }
        let event = recorded.event_id().unwrap_or_default();
        if let Some(found) = difference_of(recorded, &computed) {
            self.differing += 1;
            let found = place.difference(found, recorded.stamp(), event);
            self.first_difference.get_or_insert(found);
        }
    }
}

/// What depends on the machine and its other threads is taken from the recording.
fn with_what_nobody_can_recompute(computed: Message, recorded: &Message) -> Message {
    match (computed, recorded) {
        (Message::ImpactForecast(report), Message::ImpactForecast(other)) => {
            Message::ImpactForecast(ImpactReport {
                compute_time: other.compute_time,
                ..report
            })
        }
        (Message::ImpactReport(report), Message::ImpactReport(other)) => {
            Message::ImpactReport(ImpactReport {
                compute_time: other.compute_time,
                ..report
            })
        }
        (Message::TwinStatus(status), Message::TwinStatus(other)) => {
            Message::TwinStatus(TwinStatus {
                overruns: other.overruns,
                worst_lateness: other.worst_lateness,
                dropped_inputs: other.dropped_inputs,
                dropped_states: other.dropped_states,
                dropped_recording: other.dropped_recording,
                dropped_viewer: other.dropped_viewer,
                ..status
            })
        }
        (computed, _) => computed,
    }
}

fn difference_of(
    recorded: &Message,
    computed: &Message,
) -> Option<super::comparison::FieldDifference> {
    match (recorded, computed) {
        (Message::ColumnState(one), Message::ColumnState(other)) => first_difference(one, other),
        (Message::HingeForces(one), Message::HingeForces(other)) => first_difference(one, other),
        (Message::ImpactForecast(one), Message::ImpactForecast(other))
        | (Message::ImpactReport(one), Message::ImpactReport(other)) => {
            first_difference(one, other)
        }
        (Message::TwinStatus(one), Message::TwinStatus(other)) => first_difference(one, other),
        (Message::JointStates(one), Message::JointStates(other)) => first_difference(one, other),
        (Message::Markers(one), Message::Markers(other)) => first_difference(one, other),
        // Both are of one topic.
        _ => None,
    }
}
