//! A twin that repeats the recorded one, with what it gives out until the recorded messages are found.

use std::collections::VecDeque;
use std::sync::Arc;

use super::comparison::{Difference, Place};
use super::forecasts::{Forecasts, FoundForecast};
use super::verification::Verification;
use crate::column::ModelError;
use crate::endpoints::NodeKind;
use crate::estimation::MAX_EVENTS;
use crate::live::monotonic_nanos;
use crate::messages::column_twin_msgs::{ColumnState, ImpactReport, TwinStatus};
use crate::outgoing::{Message, Outgoing, Topic};
use crate::time::Nanos;
use crate::twin::{
    Checkpoint, Command, CommandRecord, Journal, MergedEvent, Output, StateOutput, Twin,
};

/// A twin that follows the recorded one.
pub(super) struct ReplayedTwin {
    pub twin: Twin,
    pub outgoing: Outgoing,
    /// Outputs for which no recorded message has been found yet, in their order.
    pub due: VecDeque<Due>,
    /// Those that recorded messages have passed since the last entry of the journal.
    pub passed: Vec<Due>,
    pub forecasts: Forecasts,
    /// What shows the column at rest beside the last status. How often it is sent depends on status that are not recorded.
    pub optional: Vec<Message>,
    /// Outputs kept for an observer; `None` if there is no observer.
    pub outputs: Option<Vec<Output>>,
    /// Recorded messages that the twin did not compute, since the journal was last known to be complete.
    ///
    /// If the journal is complete they are differences; otherwise they may belong to what is missing there. A recording that
    /// had to begin in the middle of a response, because a full disk ended the previous one, begins with the last checkpoint
    /// and lacks the commands since then.
    pub unexpected: Vec<(Topic, Difference)>,
    /// A response has ended and no status followed yet.
    pub has_ended: bool,
    /// The next entry must be a status.
    pub must_report: bool,
    /// The newest events that are the same impact as an estimate.
    pub merged: VecDeque<MergedEvent>,
    /// Only what such a node has is recorded.
    kind: NodeKind,
}

/// Most merged events that are kept: an estimate rests on fewer.
const MAX_MERGED: usize = 4 * MAX_EVENTS;

/// What has to be recorded next.
#[derive(Debug, Clone)]
pub(super) enum Due {
    /// A state. It is converted when one of its messages is found, because the node thins out only those states that reach it.
    State(Box<StateOutput>),
    Message(Box<Message>),
}

impl Due {
    fn is_of(&self, recorded: &Message) -> bool {
        match self {
            Self::Message(it) => {
                it.topic() == recorded.topic()
                    && it.stamp() == recorded.stamp()
                    && it.event_id() == recorded.event_id()
            }
            Self::State(it) => {
                recorded.topic().is_of_state()
                    && recorded.stamp() == Some(it.stamp)
                    && recorded.event_id().is_none_or(|id| *id == *it.event_id)
            }
        }
    }
}

/// Whether a state is the last one of its response.
fn is_last(state: &ColumnState) -> bool {
    ![TwinStatus::APPROACH, TwinStatus::CONTACT, TwinStatus::FREE].contains(&state.phase)
}

/// What corresponds to a recorded message.
pub(super) struct Found {
    pub computed: Message,
    /// The recorded message follows one that should be after it.
    pub is_misplaced: bool,
}

impl ReplayedTwin {
    pub fn new(checkpoint: &Checkpoint, kind: NodeKind) -> Result<Self, ModelError> {
        Ok(Self {
            twin: Twin::from_checkpoint(checkpoint, Box::new(monotonic_nanos))?,
            outgoing: Outgoing::new(&checkpoint.parameters),
            due: VecDeque::new(),
            passed: Vec::new(),
            forecasts: Forecasts::default(),
            optional: Vec::new(),
            outputs: None,
            unexpected: Vec::new(),
            has_ended: false,
            must_report: false,
            merged: VecDeque::new(),
            kind,
        })
    }

    /// Executes a recorded command, and returns its own record of it.
    pub fn execute(&mut self, command: Command, now: Nanos) -> Option<Arc<CommandRecord>> {
        let mut out = Vec::new();
        // The outcome is in the record too.
        let _ = self.twin.handle(command, now, &mut out);
        self.twin.run_ahead(u64::MAX, now, &mut out);
        self.convert_all(&out);
        out.into_iter().find_map(|output| match output {
            Output::Journal(Journal::Command(own)) => Some(own),
            _ => None,
        })
    }

    /// Takes the twin's outputs. Its own journal is left out, because entries are taken from the recording.
    pub fn convert_all(&mut self, outputs: &[Output]) {
        for output in outputs {
            if !matches!(output, Output::Journal(_)) {
                self.convert(output);
            }
            if let (Some(kept), Output::State(_) | Output::Report(_) | Output::Estimate(_)) =
                (&mut self.outputs, output)
            {
                kept.push(output.clone());
            }
        }
    }

    pub fn convert(&mut self, output: &Output) {
        if let Output::State(state) = output {
            return self.due.push_back(Due::State(Box::new(state.clone())));
        }
        if let Output::Merged(event) = output {
            self.merged.push_back(event.clone());
            if self.merged.len() > MAX_MERGED {
                self.merged.pop_front();
            }
        }
        if let Output::Replaced(event_id) = output {
            return self.forecasts.replace(event_id);
        }
        self.has_ended |= matches!(output, Output::Report(_));
        let (due, forecasts) = (&mut self.due, &mut self.forecasts);
        self.outgoing
            .convert(output, |message| match message.topic() {
                Topic::ImpactForecast => forecasts.add(message),
                _ => due.push_back(Due::Message(Box::new(message))),
            });
    }

    /// Takes the status at an instant. A converter of its own leaves nothing out, whatever it has sent before.
    pub fn convert_status(&mut self, stamp: i64) {
        let status = Output::Status(self.twin.status(stamp));
        let mut outgoing = Outgoing::new(self.twin.parameters());
        self.optional.clear();
        outgoing.convert(&status, |message| match message.topic() {
            Topic::TwinStatus => self.due.push_back(Due::Message(Box::new(message))),
            _ => self.optional.push(message),
        });
    }

    /// Takes the message that corresponds to a recorded one and need not be there.
    pub fn take_optional(&mut self, recorded: &Message) -> Option<Found> {
        let is_same =
            |it: &Message| it.topic() == recorded.topic() && it.stamp() == recorded.stamp();
        let index = self.optional.iter().position(is_same)?;
        Some(Found {
            computed: self.optional.remove(index),
            is_misplaced: false,
        })
    }

    pub fn is_due(&self, recorded: &Message) -> bool {
        self.due.iter().any(|it| it.is_of(recorded))
    }

    /// Follows the twin until everything is given out that may precede a recorded message. A status has its own entry.
    pub fn advance_towards(&mut self, recorded: &Message) {
        let (Some(stamp), true) = (recorded.stamp(), recorded.topic() != Topic::TwinStatus) else {
            return;
        };
        let mut out = Vec::new();
        // Another impact, which may be the next one to come, has ended the response.
        let instant = match is_withdrawn(recorded) {
            true => self.twin.next_impact().unwrap_or(stamp),
            false => stamp,
        };
        if !is_stopped(recorded) {
            self.twin.advance_to_instant(instant, &mut out);
        }
        match recorded {
            // What was still to come when the twin was stopped never happened.
            _ if is_stopped(recorded) => self.twin.abandon_forecasts(&mut out),
            // The last state has the stamp of the step before the one that cannot be computed.
            Message::ColumnState(state) if is_last(state) && out.is_empty() => {
                self.twin.try_next_step(&mut out);
            }
            // Its stamp is that of the impact, and the states before it may be lost.
            Message::ImpactReport(report)
                if *self.twin.status(stamp).event_id == *report.event_id =>
            {
                self.twin.advance_to_end(&mut out);
            }
            _ => {}
        }
        self.convert_all(&out);
    }

    /// Takes the computed message that corresponds to a recorded one, and passes those before it.
    pub fn take(
        &mut self,
        recorded: &Message,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> Option<Found> {
        if !self.is_due(recorded) && !self.passed.iter().any(|it| it.is_of(recorded)) {
            let optional = self.take_optional(recorded);
            if optional.is_some() {
                return optional;
            }
            self.advance_towards(recorded);
        }
        let index = self.due.iter().position(|it| it.is_of(recorded));
        let (due, is_misplaced) = match index {
            Some(index) => {
                self.pass(index, place, found);
                (self.due.pop_front()?, false)
            }
            None => {
                let index = self.passed.iter().position(|it| it.is_of(recorded))?;
                (self.passed.remove(index), true)
            }
        };
        let computed = match due {
            Due::Message(computed) => *computed,
            Due::State(state) => self.take_of_state(*state, recorded, is_misplaced)?,
        };
        if let Message::ImpactReport(_) = &computed {
            self.note_missing_forecasts(&computed, place, found);
        }
        Some(Found {
            computed,
            is_misplaced,
        })
    }

    /// Converts a state and takes the message of it that corresponds to a recorded one.
    pub fn take_of_state(
        &mut self,
        state: StateOutput,
        recorded: &Message,
        is_misplaced: bool,
    ) -> Option<Message> {
        let mut messages = Vec::new();
        let kind = self.kind;
        self.outgoing.convert(&Output::State(state), |message| {
            if message.topic().endpoint().is_of(kind) {
                messages.push(message);
            }
        });
        let index = messages
            .iter()
            .position(|it| it.topic() == recorded.topic());
        let mut rest = messages
            .split_off(index.map_or(0, |index| index + 1))
            .into_iter()
            .map(|it| Due::Message(Box::new(it)));
        let found = index.and_then(|_| messages.pop());
        let before = messages.into_iter().map(|it| Due::Message(Box::new(it)));
        self.passed.extend(before);
        match is_misplaced {
            true => self.passed.extend(rest),
            false => {
                while let Some(last) = rest.next_back() {
                    self.due.push_front(last);
                }
            }
        }
        found
    }

    /// Passes the next outputs, for which there is no recorded message in its place.
    pub fn pass(&mut self, count: usize, place: &Place<'_>, found: &mut Verification) {
        for due in self.due.drain(..count).collect::<Vec<_>>() {
            if let Due::Message(message) = &due
                && message.topic() == Topic::ImpactReport
            {
                self.note_missing_forecasts(message, place, found);
            }
            self.passed.push(due);
        }
    }

    /// Notes what was passed as missing.
    pub fn note_passed(&mut self, place: &Place<'_>, found: &mut Verification) {
        for due in std::mem::take(&mut self.passed) {
            match due {
                Due::Message(message) => note_missing(&message, place, found),
                Due::State(state) => {
                    // Which messages for displays there were of a state that is not recorded is not known.
                    let mut outgoing = self.outgoing.clone();
                    outgoing.convert(&Output::State(*state), |message| {
                        if message.topic().is_of_every_state() {
                            note_missing(&message, place, found);
                        }
                    });
                }
            }
        }
    }

    /// Takes the forecast that corresponds to a recorded one.
    pub fn take_forecast(
        &mut self,
        recorded: &Message,
        place: &Place<'_>,
        bytes: &[u8],
        found: &mut Verification,
    ) -> Option<Found> {
        if !self.forecasts.expect(recorded) {
            self.advance_towards(recorded);
        }
        let is_equal = |it: &Message| compare(place, recorded, it.clone(), bytes).is_none();
        let FoundForecast { forecast, passed } = self.forecasts.take(recorded, is_equal)?;
        for message in passed {
            note_missing(&message, place, found);
        }
        Some(Found {
            computed: forecast,
            is_misplaced: false,
        })
    }

    /// The forecasts of an impact precede its report.
    pub fn note_missing_forecasts(
        &mut self,
        report: &Message,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        for message in self.forecasts.take_reported(report) {
            note_missing(&message, place, found);
        }
    }
}

/// Whether a message tells that the forecast of an impact no longer holds, or that there is none.
fn is_withdrawn(recorded: &Message) -> bool {
    let kinds = [ImpactReport::WITHDRAWN, ImpactReport::NO_FORECAST];
    matches!(recorded, Message::ImpactForecast(it) if kinds.contains(&it.kind))
}

/// Whether it tells so because the twin was stopped.
fn is_stopped(recorded: &Message) -> bool {
    is_withdrawn(recorded)
        && matches!(recorded, Message::ImpactForecast(it) if it.end == ImpactReport::END_STOPPED)
}

/// Notes a computed message that is not recorded, which shows at this place.
pub(super) fn note_missing(message: &Message, place: &Place<'_>, found: &mut Verification) {
    let topic = message.topic();
    found.topics[topic.index()].missing += 1;
    let place = Place {
        topic: topic.endpoint().name,
        stamp: message.stamp(),
        event_id: message.event_id().unwrap_or_default(),
        ..*place
    };
    found.note_missing(1, place.difference("the message", "absent", "present"));
}

/// Compares everything in a message that the model determines.
pub(super) fn compare(
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
