//! Replays a recorded journal with a twin of its own, and compares the outputs with the recorded messages.

use std::collections::VecDeque;
use std::sync::Arc;

use super::comparison::{Difference, Place, seconds};
use super::journal_line::JournalEntry;
use super::verification::Verification;
use crate::column::ModelError;
use crate::live::monotonic_nanos;
use crate::messages::column_twin::ImpactReport;
use crate::outgoing::{Message, Outgoing, Topic};
use crate::twin::{
    Checkpoint, CommandRecord, Journal, Nanos, Output, Position, StatusRecord, Twin,
};

/// A recorded message of the twin.
pub(super) struct RecordedBytes<'a> {
    pub topic: Topic,
    pub name: &'a str,
    pub log_time: i64,
    pub bytes: &'a [u8],
}

/// Takes the journal and the messages of a recording in their order.
#[derive(Default)]
pub(super) struct Replayer {
    /// `None` while the position of the recorded twin is unknown.
    replayed: Option<ReplayedTwin>,
    /// Expected number of the next checkpoint or command; `None` before the first.
    next_number: Option<u64>,
    /// No numbered entry has followed the first checkpoint yet.
    is_beginning: bool,
    /// Whether the outputs of the twin are kept for [`take_outputs`](Self::take_outputs).
    keeps_outputs: bool,
    /// Kept outputs of twins whose replay has ended.
    outputs: Vec<Output>,
    verification: Verification,
}

/// A twin that follows the recorded one.
struct ReplayedTwin {
    twin: Twin,
    outgoing: Outgoing,
    /// Computed messages for which no recorded message has been found yet.
    computed: [VecDeque<Computed>; Topic::COUNT],
    /// Outputs kept for an observer; `None` if there is no observer.
    outputs: Option<Vec<Output>>,
    /// Number of computed messages.
    count: u64,
    /// Number of the newest computed message for which a recorded one was found.
    newest_found: u64,
    unexpected: Unexpected,
}

/// Recorded messages that the twin did not compute, since the journal was last known to be complete.
///
/// If the journal is complete they are differences; otherwise they may belong to what is missing there. A recording that
/// had to begin in the middle of a response, because a full disk ended the previous one, begins with the last checkpoint
/// and lacks the commands since then.
#[derive(Default)]
struct Unexpected {
    count: [u64; Topic::COUNT],
    first: Option<Difference>,
}

struct Computed {
    number: u64,
    message: Message,
}

impl Replayer {
    /// A replayer that keeps the recomputed states and reports.
    pub fn keeping_outputs() -> Self {
        Self {
            keeps_outputs: true,
            ..Self::default()
        }
    }

    /// The states and reports that were recomputed since the last call.
    pub fn take_outputs(&mut self) -> Vec<Output> {
        let mut outputs = std::mem::take(&mut self.outputs);
        let replayed = self.replayed.as_mut();
        if let Some(kept) = replayed.and_then(|replayed| replayed.outputs.as_mut()) {
            outputs.append(kept);
        }
        outputs
    }

    /// Takes an entry of the journal on the topic `name`.
    pub fn journal(&mut self, entry: &JournalEntry, name: &str, log_time: i64) {
        let place = Place {
            topic: name,
            log_time,
            ..Place::default()
        };
        match entry {
            JournalEntry::Twin(Journal::Checkpoint(checkpoint)) => {
                self.checkpoint(checkpoint, &place);
            }
            JournalEntry::Twin(Journal::Command(record)) => self.command(record, &place),
            JournalEntry::Twin(Journal::Status(record)) => self.status(*record, &place),
            JournalEntry::RefusedByNode { .. } => self.verification.refused_by_node += 1,
        }
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint, place: &Place<'_>) {
        self.verification.checkpoints += 1;
        self.check_number(checkpoint.number, place);
        self.next_number = Some(checkpoint.number.saturating_add(1));
        self.is_beginning = self.verification.checkpoints == 1;
        let position = Position {
            response: checkpoint.response,
            step: None,
        };
        self.advance(position, place);
        let Some(replayed) = &mut self.replayed else {
            return self.start_from(checkpoint, place);
        };
        let Some(mut computed) = replayed.twin.checkpoint(checkpoint.stamp) else {
            return;
        };
        computed.number = checkpoint.number;
        self.verification.states_at_rest += 1;
        let place = Place {
            stamp: Some(checkpoint.stamp),
            event_id: &checkpoint.life.last_event_id,
            ..*place
        };
        match place.first_difference(checkpoint, &computed) {
            // Resets the conversion to messages, as the recorded node did at this checkpoint.
            None => replayed.convert(&Output::Journal(Journal::Checkpoint(Arc::new(computed)))),
            Some(difference) => {
                self.verification.note_difference(difference);
                self.start_from(checkpoint, &place);
            }
        }
    }

    /// Starts a new twin at a checkpoint.
    fn start_from(&mut self, checkpoint: &Checkpoint, place: &Place<'_>) {
        self.end_replay();
        match ReplayedTwin::new(checkpoint) {
            Ok(mut replayed) => {
                replayed.outputs = self.keeps_outputs.then(Vec::new);
                self.replayed = Some(replayed);
            }
            Err(error) => self.verification.note_unchecked(format!(
                "the checkpoint at {} s describes an impossible column: {error}",
                seconds(place.log_time)
            )),
        }
    }

    fn command(&mut self, record: &CommandRecord, place: &Place<'_>) {
        self.verification.inputs += 1;
        self.check_number(record.number, place);
        self.next_number = Some(record.number.saturating_add(1));
        self.advance(record.position, place);
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        if record.taken_back && !replayed.twin.knows_last_response() {
            return self.stop_checking("a late impact belongs to a response before the recording");
        }
        let place = Place {
            stamp: Some(record.now),
            ..*place
        };
        let outcome = |it: &CommandRecord| (it.refusal.clone(), it.taken_back);
        let Some(own) = replayed.execute(record) else {
            return;
        };
        if let Some(difference) = place.first_difference(&outcome(record), &outcome(&own)) {
            self.verification.note_difference(Difference {
                field: "outcome of a command".to_owned(),
                ..difference
            });
        } else if let Some(difference) = place.first_difference(&record.impact, &own.impact) {
            let field = format!("impact.{}", difference.field);
            self.verification.note_difference(Difference {
                field,
                ..difference
            });
            self.stop_checking(
                "the parameters and the catalogue of vehicles of this program give another impact",
            );
        }
    }

    fn status(&mut self, record: StatusRecord, place: &Place<'_>) {
        self.check_number(record.next_number, place);
        self.advance(record.position, place);
        if let Some(replayed) = &mut self.replayed {
            let status = replayed.twin.status(record.stamp);
            replayed.convert(&Output::Status(status));
        }
    }

    /// Compares the number of an entry with the expected one. If no entry is missing, messages that were unexpected so
    /// far are differences.
    fn check_number(&mut self, number: u64, place: &Place<'_>) {
        let is_beginning = std::mem::take(&mut self.is_beginning);
        let expected = self.next_number.replace(number).unwrap_or(number);
        if number < expected {
            self.verification.note_difference(place.difference(
                "number of the entry",
                number.to_string(),
                expected.to_string(),
            ));
            return self.stop_checking("the numbers of the journal decrease");
        }
        let lost = number - expected;
        if lost > 0 {
            // Entries between the first checkpoint and the next one are in the previous recording if this one had to begin
            // in the middle of a response. Anywhere else every number must be there.
            if !is_beginning {
                let missing = &mut self.verification.missing_entries;
                *missing = missing.saturating_add(lost);
            }
            return self.stop_checking(&format!("{lost} entries of the journal are missing"));
        }
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        let Unexpected { count, first } = std::mem::take(&mut replayed.unexpected);
        for (check, count) in self.verification.topics.iter_mut().zip(count) {
            check.unexpected += count;
            self.verification.differences += count;
        }
        if self.verification.first_difference.is_none() {
            self.verification.first_difference = first;
        }
    }

    /// Takes a recorded message of the twin.
    pub fn message(&mut self, recorded: &RecordedBytes<'_>) {
        let RecordedBytes {
            topic,
            name,
            log_time,
            bytes,
        } = *recorded;
        let place = Place {
            topic: name,
            log_time,
            ..Place::default()
        };
        let message = match Message::decode(topic, bytes) {
            Ok(message) => message,
            Err(error) => {
                return self.verification.note_difference(place.difference(
                    "the message",
                    format!("not readable ({error})"),
                    "a message of this type",
                ));
            }
        };
        let place = Place {
            stamp: message.stamp(),
            event_id: message.event_id().unwrap_or_default(),
            ..place
        };
        self.verification.note_losses(&message);
        let check = &mut self.verification.topics[topic.index()];
        check.recorded += 1;
        let Some(replayed) = &mut self.replayed else {
            check.unchecked += 1;
            return;
        };
        let Some(computed) = replayed.find(topic, &message) else {
            replayed.unexpected.count[topic.index()] += 1;
            let difference = || place.difference("the message", "present", "absent");
            replayed.unexpected.first.get_or_insert_with(difference);
            return;
        };
        check.compared += 1;
        check.missing += replayed.take_missing(topic);
        if let Some(difference) = compare(&place, &message, computed, bytes) {
            check.differing += 1;
            self.verification.note_difference(difference);
        }
    }

    /// Advances the twin to the position of the recorded one.
    fn advance(&mut self, wanted: Position, place: &Place<'_>) {
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        let mut out = Vec::new();
        let reached = replayed.twin.advance_to_position(wanted, &mut out);
        replayed.convert_all(&out);
        if let Err(not_reached) = reached {
            let text = |position: Position| match position.step {
                Some(step) => format!("step {step} of response {}", position.response),
                None => format!("at rest after response {}", position.response),
            };
            self.verification.note_difference(place.difference(
                "position of the twin",
                text(not_reached.wanted),
                text(not_reached.found),
            ));
            self.stop_checking("the recomputation does not reach the recorded position");
        }
    }

    fn stop_checking(&mut self, reason: &str) {
        self.end_replay();
        self.verification
            .note_unchecked(format!("{reason}; not checked until the next checkpoint"));
    }

    /// Counts what was computed and should have been recorded by now.
    fn end_replay(&mut self) {
        let Some(mut replayed) = self.replayed.take() else {
            return;
        };
        self.outputs
            .extend(replayed.outputs.take().into_iter().flatten());
        for topic in Topic::ALL {
            let check = &mut self.verification.topics[topic.index()];
            check.missing += replayed.take_missing(topic);
            check.unchecked += replayed.unexpected.count[topic.index()];
        }
        let unexpected: u64 = replayed.unexpected.count.iter().sum();
        if unexpected > 0 {
            self.verification.note_unchecked(format!(
                "{unexpected} messages belong to commands before the recording, or to missing entries of the journal"
            ));
        }
    }

    /// Ends the recording.
    pub fn finish(mut self) -> Verification {
        self.end_replay();
        self.verification
    }
}

impl ReplayedTwin {
    fn new(checkpoint: &Checkpoint) -> Result<Self, ModelError> {
        Ok(Self {
            twin: Twin::from_checkpoint(checkpoint, Box::new(monotonic_nanos))?,
            outgoing: Outgoing::new(&checkpoint.parameters),
            computed: Default::default(),
            outputs: None,
            count: 0,
            newest_found: 0,
            unexpected: Unexpected::default(),
        })
    }

    /// Executes a recorded command, and returns its own record of it.
    fn execute(&mut self, record: &CommandRecord) -> Option<Arc<CommandRecord>> {
        let mut out = Vec::new();
        // The outcome is in the record too.
        let _ = self
            .twin
            .handle(record.command.clone(), record.now, &mut out);
        self.twin.run_ahead(u64::MAX, record.now, &mut out);
        self.convert_all(&out);
        out.into_iter().find_map(|output| match output {
            Output::Journal(Journal::Command(own)) => Some(own),
            _ => None,
        })
    }

    /// Converts the twin's outputs to messages. Its own journal is left out, because entries are taken from the recording.
    fn convert_all(&mut self, outputs: &[Output]) {
        for output in outputs {
            if !matches!(output, Output::Journal(_)) {
                self.convert(output);
            }
            if let (Some(kept), Output::State(_) | Output::Report(_)) = (&mut self.outputs, output)
            {
                kept.push(output.clone());
            }
        }
    }

    fn convert(&mut self, output: &Output) {
        self.outgoing.convert(output, |message| {
            self.count += 1;
            let number = self.count;
            self.computed[message.topic().index()].push_back(Computed { number, message });
        });
    }

    /// Takes the computed message that corresponds to a recorded one. Earlier ones stay for
    /// [`take_missing`](Self::take_missing).
    fn find(&mut self, topic: Topic, recorded: &Message) -> Option<Message> {
        if let Some(found) = self.find_computed(topic, recorded) {
            return Some(found);
        }
        let withdrawn_kinds = [ImpactReport::WITHDRAWN, ImpactReport::NO_FORECAST];
        match recorded {
            Message::TwinStatus(_) => None,
            // What was still to come when the twin was stopped never happened.
            Message::ImpactForecast(it) if it.end == ImpactReport::END_STOPPED => None,
            // Another impact, which may be the next one to come, has ended the response.
            Message::ImpactForecast(it) if withdrawn_kinds.contains(&it.kind) => {
                let instant = self.twin.next_impact()?;
                self.advance_to_instant(instant);
                self.find_computed(topic, recorded)
            }
            _ => {
                self.advance_to_instant(recorded.stamp()?);
                self.find_computed(topic, recorded)
            }
        }
    }

    fn advance_to_instant(&mut self, instant: Nanos) {
        let mut out = Vec::new();
        self.twin.advance_to_instant(instant, &mut out);
        self.convert_all(&out);
    }

    fn find_computed(&mut self, topic: Topic, recorded: &Message) -> Option<Message> {
        let computed = &mut self.computed[topic.index()];
        let Some(index) = computed
            .iter()
            .position(|it| is_same(&it.message, recorded))
        else {
            return self.instead_of_forecasts(recorded);
        };
        let found = computed.remove(index)?;
        self.newest_found = self.newest_found.max(found.number);
        Some(found.message)
    }

    /// The message with which the recorded twin said that it had no time to compute a forecast, which depends on the machine.
    /// It takes the place of the computed forecasts; why and when the twin gave up cannot be recomputed.
    fn instead_of_forecasts(&mut self, recorded: &Message) -> Option<Message> {
        let recorded = match recorded {
            Message::ImpactForecast(it) if it.kind == ImpactReport::NO_FORECAST => it,
            _ => return None,
        };
        let of_impact = |it: &Computed| match &it.message {
            Message::ImpactForecast(it) => {
                it.header == recorded.header && it.event_id == recorded.event_id
            }
            _ => false,
        };
        let forecasts = &mut self.computed[Topic::ImpactForecast.index()];
        let first = forecasts.iter().position(of_impact)?;
        let Message::ImpactForecast(forecast) = forecasts.remove(first)?.message else {
            return None;
        };
        forecasts.retain(|it| !of_impact(it));
        let (end, reason) = (recorded.end, &recorded.severity_reason);
        Some(Message::ImpactForecast(ImpactReport {
            header: forecast.header,
            column_id: forecast.column_id,
            event_id: forecast.event_id,
            vehicle: forecast.vehicle,
            mass: forecast.mass,
            velocity: forecast.velocity,
            ..ImpactReport::without_results(ImpactReport::NO_FORECAST, end, reason)
        }))
    }

    /// Removes and counts the messages that were computed before the newest one found, and are not in the recording. A
    /// forecast does not count: the recorded twin may have had no time to compute it.
    fn take_missing(&mut self, topic: Topic) -> u64 {
        if topic == Topic::ImpactForecast {
            return 0;
        }
        let queue = &mut self.computed[topic.index()];
        let before = queue.len();
        queue.retain(|it| it.number >= self.newest_found);
        (before - queue.len()) as u64
    }
}

/// Whether a computed message corresponds to a recorded one. Forecasts of the same impact are of several kinds.
fn is_same(computed: &Message, recorded: &Message) -> bool {
    let kind = |message: &Message| match message {
        Message::ImpactForecast(it) => Some(it.kind),
        _ => None,
    };
    computed.stamp() == recorded.stamp()
        && computed.event_id() == recorded.event_id()
        && kind(computed) == kind(recorded)
}

/// Compares everything in a message that the model determines.
fn compare(
    place: &Place<'_>,
    recorded: &Message,
    mut computed: Message,
    bytes: &[u8],
) -> Option<Difference> {
    copy_machine_dependent_fields(recorded, &mut computed);
    // Equal bytes are equal values. Different bytes may be too: other encoders may fill the padding differently.
    if computed.encode().is_ok_and(|own| own == bytes) {
        return None;
    }
    place.first_difference(recorded, &computed)
}

/// Takes over what depends on the machine and on other threads, and cannot be recomputed.
fn copy_machine_dependent_fields(recorded: &Message, computed: &mut Message) {
    match (recorded, computed) {
        (Message::ImpactForecast(recorded), Message::ImpactForecast(computed))
        | (Message::ImpactReport(recorded), Message::ImpactReport(computed)) => {
            computed.compute_time = recorded.compute_time;
            // A forecast may have been withdrawn before its error was estimated.
            if recorded.kind == ImpactReport::WITHDRAWN && recorded.error_estimate.is_nan() {
                computed.error_estimate = f64::NAN;
            }
        }
        (Message::TwinStatus(recorded), Message::TwinStatus(computed)) => {
            computed.overruns = recorded.overruns;
            computed.worst_lateness = recorded.worst_lateness;
            computed.dropped_inputs = recorded.dropped_inputs;
            computed.dropped_states = recorded.dropped_states;
            computed.dropped_recording = recorded.dropped_recording;
            computed.dropped_viewer = recorded.dropped_viewer;
        }
        _ => {}
    }
}
