//! Replays a recorded journal with a twin of its own, and compares the outputs with the recorded messages.

use std::sync::Arc;

use super::background::KnownResults;
use super::comparison::{Difference, Place, seconds};
use super::estimates::EstimateCheck;
use super::replayed_twin::{Found, ReplayedTwin, compare, note_missing};
use super::verification::Verification;
use crate::endpoints::NodeKind;
use crate::estimation::SharedPreparations;
use crate::messages::cdr::CdrError;
use crate::messages::column_twin_msgs::{ImpactReport, TwinStatus};
use crate::outgoing::{Message, Topic};
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{
    BackgroundTask, Checkpoint, Command, CommandRecord, Journal, Output, Position, StatusRecord,
};

/// A recorded message of the twin.
pub(super) struct RecordedBytes<'a> {
    pub topic: Topic,
    pub name: &'a str,
    pub log_time: i64,
    pub bytes: &'a [u8],
    /// The same, decoded.
    pub message: Result<Message, CdrError>,
}

/// Takes the journal and the messages of a recording in their order.
///
/// The node sends the outputs of the twin in one order, so that the recording has states, reports and status exactly in the
/// order of the recomputation, and an entry of the journal follows everything that the twin gave out before it. Only the place
/// of a forecast depends on the machine.
#[derive(Default)]
pub(super) struct Replayer {
    /// `None` while the position of the recorded twin is unknown.
    replayed: Option<ReplayedTwin>,
    /// Expected number of the next checkpoint or command; `None` before the first.
    next_number: Option<u64>,
    /// No checkpoint or command is missing before the present entry.
    is_complete: bool,
    /// Lines of the journal that are missing since the last checkpoint or command.
    missing_lines: u64,
    /// Whether the outputs of the twin are kept for [`take_outputs`](Self::take_outputs).
    keeps_outputs: bool,
    /// Kept outputs of twins whose replay has ended.
    outputs: Vec<Output>,
    /// The last recorded status: its counters must not decrease.
    last_status: Option<TwinStatus>,
    pub estimates: EstimateCheck,
    /// The recording declares losses, or is damaged: a message that is not expected may belong to what is missing.
    declares_losses: bool,
    kind: NodeKind,
    /// What was computed in the background for other columns.
    known: KnownResults,
}

impl Replayer {
    /// A replayer of a column of such a node, whose recording declares losses or is damaged, or not; it keeps the recomputed states
    /// and reports for an observer, if there is one.
    pub fn new(kind: NodeKind, keeps_outputs: bool, declares_losses: bool) -> Self {
        Self {
            keeps_outputs,
            declares_losses,
            kind,
            ..Self::default()
        }
    }

    /// The replayer with what all columns share.
    pub fn sharing(self, known: KnownResults, prepared: SharedPreparations) -> Self {
        Self {
            known,
            estimates: EstimateCheck::new(self.kind.keeps_measurements(), prepared),
            ..self
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

    /// The parameters of the twin; `None` while they are unknown.
    pub fn parameters(&self) -> Option<Arc<Parameters>> {
        let replayed = self.replayed.as_ref()?;
        Some(Arc::clone(replayed.twin.parameters()))
    }

    /// Frees what the twin knows of a response to which no impact at this time or later belongs any more, if the recorded one did.
    pub fn forget_what_is_too_old(&mut self, now: Nanos) {
        if let (true, Some(replayed)) = (self.kind.has_checkpoints_on_demand(), &mut self.replayed)
        {
            replayed.twin.forget_what_is_too_old(now);
        }
    }

    /// Takes note that so many lines are missing before the present one, or are in an earlier recording. Without them the position
    /// of the twin may be unknown.
    pub fn lines_are_missing(&mut self, lost: u64) {
        self.missing_lines = self.missing_lines.saturating_add(lost);
        if let Some(replayed) = &mut self.replayed {
            replayed.must_report = false;
        }
    }

    /// Does not expect the entries of status that may be among so many missing lines. What a status leads to is published right after
    /// it, before the next entry.
    fn excuse_statuses(&mut self, missing_lines: u64, found: &mut Verification) {
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        let mut excused = missing_lines;
        replayed.unexpected.retain(|(topic, _)| {
            let is_excused = match topic {
                Topic::TwinStatus => excused > 0,
                _ => topic.endpoint().shows_rest && missing_lines > 0,
            };
            if is_excused {
                excused -= u64::from(*topic == Topic::TwinStatus);
                found.topics[topic.index()].unchecked += 1;
            }
            !is_excused
        });
    }

    /// Takes an entry of the twin's journal; `false` if entries before it are missing.
    pub fn journal(
        &mut self,
        entry: &Journal,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> bool {
        self.is_complete = true;
        match entry {
            Journal::Checkpoint(checkpoint) => self.checkpoint(checkpoint, place, found),
            Journal::Command(record) => self.command(record, place, found),
            Journal::Status(record) => self.status(*record, place, found),
        }
        self.is_complete
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint, place: &Place<'_>, found: &mut Verification) {
        found.checkpoints += 1;
        self.check_number(checkpoint.number, place, found);
        self.next_number = Some(checkpoint.number.saturating_add(1));
        let position = Position {
            response: checkpoint.response,
            step: None,
        };
        self.advance(position, place, found);
        self.expect_no_status(place, found);
        let Some(replayed) = &mut self.replayed else {
            return self.start_from(checkpoint, place, found);
        };
        replayed.must_report = std::mem::take(&mut replayed.has_ended);
        let Some(mut computed) = replayed.twin.checkpoint(checkpoint.stamp) else {
            return;
        };
        computed.number = checkpoint.number;
        found.states_at_rest += 1;
        let place = Place {
            stamp: Some(checkpoint.stamp),
            event_id: &checkpoint.life.last_event_id,
            ..*place
        };
        for message in replayed.forecasts.take_all() {
            note_missing(&message, &place, found);
        }
        match place.first_difference(checkpoint, &computed) {
            // Resets the conversion to messages, as the recorded node did at this checkpoint.
            None => {
                let entry = Output::Journal(Journal::Checkpoint(Arc::new(computed)));
                replayed.outgoing.convert(&entry, |_| ());
            }
            Some(difference) => {
                found.note_difference(difference);
                self.start_from(checkpoint, &place, found);
            }
        }
    }

    /// Starts a new twin at a checkpoint.
    fn start_from(&mut self, checkpoint: &Checkpoint, place: &Place<'_>, found: &mut Verification) {
        self.end_replay(false, found);
        match ReplayedTwin::new(checkpoint, self.kind) {
            Ok(mut replayed) => {
                if let Some(vehicles) = &checkpoint.critical_velocities {
                    let task = replayed.twin.task_at_rest();
                    let task = task.map(Box::new).map(BackgroundTask::CriticalVelocities);
                    let vehicles = Arc::clone(vehicles);
                    let recorded = Command::CriticalVelocities { vehicles };
                    self.known.check(&recorded, task, place, found);
                }
                let judged = checkpoint.judged.as_ref();
                if let Some(range) = judged.and_then(|it| it.range.as_ref()) {
                    let task = replayed.twin.range_task_at_rest();
                    let task = task.map(Box::new).map(BackgroundTask::Range);
                    let recorded = Command::VerdictRange(Arc::clone(range));
                    self.known.check(&recorded, task, place, found);
                }
                self.known
                    .check_opinion(checkpoint, &replayed.twin, place, found);
                replayed.outputs = self.keeps_outputs.then(Vec::new);
                self.replayed = Some(replayed);
            }
            Err(error) => found.note_unchecked(format!(
                "the checkpoint at {} s describes an impossible column: {error}",
                seconds(place.log_time)
            )),
        }
    }

    fn command(&mut self, record: &CommandRecord, place: &Place<'_>, found: &mut Verification) {
        found.inputs += 1;
        self.check_number(record.number, place, found);
        self.next_number = Some(record.number.saturating_add(1));
        self.advance(record.position, place, found);
        self.expect_no_status(place, found);
        // As the recorded twin did before its command.
        self.forget_what_is_too_old(record.now);
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        if record.taken_back && !replayed.twin.knows_last_response() {
            return self.stop_checking(
                "a late impact belongs to a response before the recording",
                found,
            );
        }
        let place = Place {
            stamp: Some(record.now),
            ..*place
        };
        self.estimates.parameters(replayed.twin.parameters());
        let outcome = |it: &CommandRecord| (it.rejection.clone(), it.taken_back);
        let command = match &record.command {
            Command::CriticalVelocities { .. } => {
                let task = replayed.twin.critical_velocity_task();
                let task = task.map(Box::new).map(BackgroundTask::CriticalVelocities);
                self.known.check(&record.command, task, &place, found)
            }
            Command::SecondOpinion(_) => {
                let task = replayed.twin.opinion_task();
                let task = task.map(Box::new).map(BackgroundTask::SecondOpinion);
                self.known.check(&record.command, task, &place, found)
            }
            Command::VerdictRange(_) => {
                let task = replayed.twin.range_task();
                let task = task.map(Box::new).map(BackgroundTask::Range);
                self.known.check(&record.command, task, &place, found)
            }
            Command::Estimate(estimate) => {
                let merged = &replayed.merged;
                self.estimates.command(estimate, merged, &place, found)
            }
            other => other.clone(),
        };
        let Some(own) = replayed.execute(command, record.now) else {
            return;
        };
        if let Some(difference) = place.first_difference(&outcome(record), &outcome(&own)) {
            found.note_difference(Difference {
                field: "outcome of a command".to_owned(),
                ..difference
            });
        } else if let Some(difference) = place.first_difference(&record.impact, &own.impact) {
            let field = format!("impact.{}", difference.field);
            found.note_difference(Difference {
                field,
                ..difference
            });
            self.stop_checking(
                "the parameters and the catalogue of vehicles of this program give another impact",
                found,
            );
        }
    }

    fn status(&mut self, record: StatusRecord, place: &Place<'_>, found: &mut Verification) {
        self.check_number(record.next_number, place, found);
        self.advance(record.position, place, found);
        if let Some(replayed) = &mut self.replayed {
            replayed.must_report = false;
            replayed.has_ended = false;
            replayed.convert_status(record.stamp);
        }
    }

    /// A status follows the end of every response, before any other entry but its checkpoint.
    fn expect_no_status(&mut self, place: &Place<'_>, found: &mut Verification) {
        let Some(replayed) = &mut self.replayed else {
            return;
        };
        if std::mem::take(&mut replayed.must_report) {
            found.topics[Topic::TwinStatus.index()].missing += 1;
            found.note_missing(
                1,
                place.difference(
                    "twin_status before this entry",
                    "absent",
                    "the status at the end of the response",
                ),
            );
        }
    }

    /// Compares the number of an entry with the expected one. If no entry is missing, messages that were unexpected so far are
    /// differences.
    fn check_number(&mut self, number: u64, place: &Place<'_>, found: &mut Verification) {
        let expected = self.next_number.replace(number).unwrap_or(number);
        let missing_lines = std::mem::take(&mut self.missing_lines);
        self.excuse_statuses(missing_lines, found);
        if number < expected {
            found.note_difference(place.difference(
                "number of the entry",
                number.to_string(),
                expected.to_string(),
            ));
            return self.stop_checking("the numbers of the journal decrease", found);
        }
        let lost = number - expected;
        self.is_complete = lost == 0;
        if lost > 0 {
            // The queue to the node may have dropped entries, which are then in no line.
            let more = lost.saturating_sub(missing_lines);
            if self.replayed.is_some() && more > 0 {
                found.missing_entries = found.missing_entries.saturating_add(more);
                found.note_missing(
                    more,
                    place.difference(
                        "the entries before this one",
                        "absent",
                        format!("{lost} entries"),
                    ),
                );
            }
            return self
                .stop_checking(&format!("{lost} entries of the journal are missing"), found);
        }
        if let Some(replayed) = &mut self.replayed {
            for (topic, difference) in std::mem::take(&mut replayed.unexpected) {
                unexpected(topic, difference, found);
            }
        }
    }

    /// Takes a recorded message of the twin.
    pub fn message(&mut self, recorded: RecordedBytes<'_>, found: &mut Verification) {
        let RecordedBytes {
            topic,
            name,
            log_time,
            bytes,
            message,
        } = recorded;
        let place = Place {
            topic: name,
            log_time,
            ..Place::default()
        };
        found.topics[topic.index()].recorded += 1;
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                found.topics[topic.index()].unexpected += 1;
                return found.note_difference(place.unreadable(&error));
            }
        };
        let place = Place {
            stamp: message.stamp(),
            event_id: message.event_id().unwrap_or_default(),
            ..place
        };
        self.check_counters(&message, &place, found);
        let Some(replayed) = &mut self.replayed else {
            found.topics[topic.index()].unchecked += 1;
            return;
        };
        let own = match topic {
            Topic::ImpactForecast => replayed.take_forecast(&message, &place, bytes, found),
            _ => replayed.take(&message, &place, found),
        };
        let check = &mut found.topics[topic.index()];
        let Some(Found {
            computed,
            is_misplaced,
        }) = own
        else {
            let difference = place.difference("the message", "present", "absent");
            replayed.unexpected.push((topic, difference));
            return;
        };
        check.compared += 1;
        if is_misplaced {
            check.misplaced += 1;
            found.note_difference(place.difference(
                "place of the message",
                "after messages that follow it",
                "before them",
            ));
        }
        if let Some(difference) = compare(&place, &message, computed, bytes) {
            found.topics[topic.index()].differing += 1;
            found.note_difference(difference);
        }
    }

    /// Checks what cannot be recomputed in a message: counters that never decrease, and a compute time that is one.
    fn check_counters(&mut self, message: &Message, place: &Place<'_>, found: &mut Verification) {
        match message {
            Message::ImpactForecast(report) | Message::ImpactReport(report)
                if [ImpactReport::FORECAST, ImpactReport::RESULT].contains(&report.kind) =>
            {
                let time = report.compute_time;
                if !time.is_finite() || time < 0.0 {
                    let own = "a time that is not negative";
                    found.note_difference(place.difference("compute_time", time.to_string(), own));
                }
            }
            Message::TwinStatus(status) => {
                if let Some(last) = self.last_status.replace(status.clone()) {
                    for (field, before, now) in counters(&last, status) {
                        if before.is_some_and(|before| now.is_none_or(|now| now < before)) {
                            let text = |it: Option<f64>| {
                                it.map_or_else(|| "NaN".to_owned(), |it| it.to_string())
                            };
                            found.note_difference(place.difference(
                                field,
                                text(now),
                                format!("at least {}, as in the status before", text(before)),
                            ));
                        }
                    }
                }
            }
            _ => {}
        }
    }

    /// Advances the twin to the position of the recorded one. Everything that it has given out by then is recorded before.
    fn advance(&mut self, wanted: Position, place: &Place<'_>, found: &mut Verification) {
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
            found.note_difference(place.difference(
                "position of the twin",
                text(not_reached.wanted),
                text(not_reached.found),
            ));
            return self.stop_checking(
                "the recomputation does not reach the recorded position",
                found,
            );
        }
        replayed.pass(replayed.due.len(), place, found);
        replayed.note_passed(place, found);
    }

    fn stop_checking(&mut self, reason: &str, found: &mut Verification) {
        self.end_replay(false, found);
        found.note_unchecked(format!("{reason}; not checked until the next checkpoint"));
    }

    /// Ends the replay. `is_complete` if no entry of the journal is missing before this.
    fn end_replay(&mut self, is_complete: bool, found: &mut Verification) {
        let Some(mut replayed) = self.replayed.take() else {
            return;
        };
        self.outputs
            .extend(replayed.outputs.take().into_iter().flatten());
        let unexpected_messages = std::mem::take(&mut replayed.unexpected);
        let count = unexpected_messages.len();
        for (topic, difference) in unexpected_messages {
            match is_complete {
                true => unexpected(topic, difference, found),
                false => found.topics[topic.index()].unchecked += 1,
            }
        }
        if count > 0 && !is_complete {
            found.note_unchecked(format!(
                "{count} messages belong to commands before the recording, or to missing entries of the journal"
            ));
        }
    }

    /// Ends the recording at this place. `is_stopped` if its journal has an end: everything is recorded then. `is_continuation` if
    /// it has nothing but the end of what an earlier recording began.
    pub fn finish(
        mut self,
        is_stopped: bool,
        is_continuation: bool,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        if let Some(replayed) = &mut self.replayed {
            if is_stopped {
                replayed.pass(replayed.due.len(), place, found);
            }
            replayed.note_passed(place, found);
        }
        let missing_lines = self.missing_lines;
        self.excuse_statuses(missing_lines, found);
        // Without an entry after them, nothing tells whether commands are among the missing lines.
        let is_complete = !self.declares_losses && !is_continuation && missing_lines == 0;
        self.end_replay(is_complete, found);
        self.estimates.finish(found);
    }
}

/// Notes a recorded message that the recomputation does not have. The entry of a status may be lost while the status is not.
fn unexpected(topic: Topic, difference: Difference, found: &mut Verification) {
    if topic == Topic::TwinStatus {
        let check = &mut found.topics[topic.index()];
        check.unchecked += 1;
        found.missing_entries += 1;
        let field = "the entry of the journal before the message".to_owned();
        return found.note_missing(
            1,
            Difference {
                field,
                recorded: "absent".to_owned(),
                computed: "present".to_owned(),
                ..difference
            },
        );
    }
    found.topics[topic.index()].unexpected += 1;
    found.note_difference(difference);
}

/// The counters of two status that must not decrease.
fn counters(last: &TwinStatus, now: &TwinStatus) -> [(&'static str, Option<f64>, Option<f64>); 6] {
    let both =
        |name, of: fn(&TwinStatus) -> u64| (name, Some(of(last) as f64), Some(of(now) as f64));
    let number = |it: f64| (!it.is_nan()).then_some(it);
    [
        both("overruns", |it| it.overruns),
        both("dropped_inputs", |it| it.dropped_inputs),
        both("dropped_states", |it| it.dropped_states),
        both("dropped_recording", |it| it.dropped_recording),
        both("dropped_viewer", |it| it.dropped_viewer),
        (
            "worst_lateness",
            number(last.worst_lateness),
            number(now.worst_lateness),
        ),
    ]
}
