//! Is a recording what the model gives?

use std::fmt;
use std::path::Path;

use super::about::{About, build};
use super::comparison::Difference;
use super::journal_line::{JournalError, Line};
use super::replayer::{Recorded, Replayer};
use crate::endpoints;
use crate::outgoing::{Message, Topic};
use crate::recording::{self, Reader, RecordingError};

/// Most reasons why something was not checked that are kept; all are counted.
const MAX_REASONS: usize = 20;

/// What recomputing a recording has shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Verification {
    /// Who recorded.
    pub about: Option<About>,
    /// Each topic that is recomputed, at its [index](Topic::index).
    pub topics: [TopicCheck; Topic::COUNT],
    /// Checkpoints in the recording.
    pub checkpoints: u64,
    /// Of these, exact states that were compared with what the responses before them lead to.
    pub states_at_rest: u64,
    /// Inputs that the twin was given anew.
    pub inputs: u64,
    /// Inputs that the node refused before the twin saw them.
    pub refused_by_node: u64,
    /// Entries of the journal that its numbers say are missing.
    pub missing_entries: u64,
    /// Why something was not checked.
    pub unchecked: Vec<String>,
    /// How many reasons there were.
    pub unchecked_reasons: u64,
    /// Messages that the recording itself says are missing, at most: what the recorder lost may stand in the node's status, too.
    pub admitted_losses: u64,
    /// The first difference, in the order of the recording.
    pub first_difference: Option<Difference>,
    /// Differences: messages, states at rest, inputs.
    pub differences: u64,
    /// Of [`TopicCheck::differing`], those that stand in `differences`.
    pub(super) counted_differing: u64,
}

/// What was found on one topic.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TopicCheck {
    /// Messages in the recording.
    pub recorded: u64,
    /// Of these, compared value by value.
    pub compared: u64,
    /// Of these, such that differ.
    pub differing: u64,
    /// Recorded, but the model gives no such message.
    pub foreign: u64,
    /// The model gives it, and it is not in the recording.
    pub missing: u64,
    /// Recorded, and not compared.
    pub unchecked: u64,
    /// The first that differs.
    pub first_difference: Option<Difference>,
}

/// Why a recording cannot be verified at all.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// There is no journal in it.
    #[error(
        "there is no topic of type {type_name} called {name} in the recording, which verify needs to compute everything anew; \
         record with `record.mode` of `column-twin run` or with `column-twin simulate --record`",
        type_name = endpoints::JOURNAL.type_name,
        name = endpoints::JOURNAL.name
    )]
    NoJournal,
    /// The journal is none of ours.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Nothing to begin with.
    #[error(
        "there is no checkpoint in the journal of the recording ({wholeness}), from which to compute it anew; verify the \
         recording before or after it"
    )]
    NoCheckpoint {
        /// Whether all is there that was written.
        wholeness: String,
    },
}

impl Verification {
    /// Whether everything that could be compared is equal, which is not nothing, and nothing is missing but what the
    /// recording says is.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        !self.is_contradicted() && !self.is_unchecked()
    }

    /// Whether something is not as the model gives it, or is missing although the recording does not say so.
    #[must_use]
    pub fn is_contradicted(&self) -> bool {
        self.differences > 0 || self.missing() > self.admitted_losses
    }

    /// Whether there are messages to compare, and none could be.
    #[must_use]
    pub fn is_unchecked(&self) -> bool {
        self.compared() == 0 && self.topics.iter().any(|it| it.recorded > 0)
    }

    /// Messages that the model gives and that are not in the recording, and entries that are missing in its journal.
    #[must_use]
    pub fn missing(&self) -> u64 {
        let messages: u64 = self.topics.iter().map(|it| it.missing).sum();
        messages.saturating_add(self.missing_entries)
    }

    /// Messages that were compared.
    #[must_use]
    pub fn compared(&self) -> u64 {
        self.topics.iter().map(|it| it.compared).sum()
    }

    /// Messages that were not compared.
    #[must_use]
    pub fn unchecked_messages(&self) -> u64 {
        self.topics.iter().map(|it| it.unchecked).sum()
    }

    /// Whether another build recorded than this one; `None` where it does not say.
    #[must_use]
    pub fn is_other_build(&self) -> Option<bool> {
        self.about.as_ref().map(|about| about.build != build())
    }

    pub(super) fn differs(&mut self, difference: Difference) {
        self.differences += 1;
        self.first_difference.get_or_insert(difference);
    }

    /// Counts a difference that a comparison on a topic has just found.
    pub(super) fn take_difference(&mut self, topic: Topic) {
        let total: u64 = self.topics.iter().map(|it| it.differing).sum();
        if total > self.counted_differing {
            self.counted_differing = total;
            self.differences += 1;
            if self.first_difference.is_none() {
                self.first_difference = self.topics[topic.index()].first_difference.clone();
            }
        }
    }

    pub(super) fn unchecked_because(&mut self, reason: String) {
        self.unchecked_reasons += 1;
        if self.unchecked.len() < MAX_REASONS {
            self.unchecked.push(reason);
        }
    }

    /// A status says how many messages have been lost on their way here.
    pub(super) fn note_losses(&mut self, message: &Message) {
        if let Message::TwinStatus(status) = message {
            // A lost state, which `dropped_recording` counts, takes its hinge forces, joint states and markers with it.
            const MESSAGES_WITH_A_STATE: u64 = 3;
            let lost = status
                .dropped_states
                .saturating_mul(MESSAGES_WITH_A_STATE)
                .saturating_add(status.dropped_recording);
            self.admitted_losses = self.admitted_losses.max(lost);
        }
    }
}

/// Computes a recording anew, from its directory or its MCAP file, and compares every value.
///
/// # Errors
/// It cannot be read, or has nothing to compute it from.
pub fn verify(path: &Path) -> Result<Verification, VerifyError> {
    let reader = Reader::open(path)?;
    let journal = reader
        .topics()
        .iter()
        .find(|it| recording::is_journal(it))
        .map(|it| std::sync::Arc::clone(&it.name))
        .ok_or(VerifyError::NoJournal)?;
    let mut replayer = Replayer::default();
    let mut about: Option<About> = None;
    let mut before = [0_u64; Topic::COUNT];
    for message in reader.messages() {
        let message = message?;
        if *message.topic == *journal {
            let line = Line::decode(&message.data)?;
            if let Some(found) = &line.about {
                about.get_or_insert_with(|| found.clone());
            }
            replayer.journal(&line.entry, &journal, message.log_time);
            continue;
        }
        let Some(topic) = topic_of(about.as_ref(), &message.topic, &message.type_name) else {
            continue;
        };
        if about.is_none() {
            before[topic.index()] += 1;
            continue;
        }
        replayer.message(&Recorded {
            topic,
            name: &message.topic,
            log_time: message.log_time,
            bytes: &message.data,
        });
    }
    let mut findings = replayer.finish();
    if findings.checkpoints == 0 {
        let wholeness = reader.wholeness().to_string();
        return Err(VerifyError::NoCheckpoint { wholeness });
    }
    let early: u64 = before.iter().sum();
    if early > 0 {
        findings.unchecked_because(format!(
            "{early} messages stand before the first checkpoint"
        ));
        for (check, count) in findings.topics.iter_mut().zip(before) {
            check.recorded += count;
            check.unchecked += count;
        }
    }
    findings.about = about;
    if !reader.wholeness().is_whole() {
        findings.unchecked_because(format!("the recording is {}", reader.wholeness()));
    }
    let lost = reader.lost_messages().unwrap_or_default();
    findings.admitted_losses = findings.admitted_losses.saturating_add(lost);
    Ok(findings)
}

/// The topic of the twin that a recorded topic is: as the journal has it, and before the journal begins by type and name.
fn topic_of(about: Option<&About>, name: &str, type_name: &str) -> Option<Topic> {
    Topic::ALL.into_iter().find(|topic| {
        let endpoint = topic.endpoint();
        match about {
            Some(about) => about.topics.get(endpoint.name).is_some_and(|it| it == name),
            None => endpoint.type_name == type_name && name.ends_with(endpoint.name),
        }
    })
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(about) = &self.about {
            write!(f, "Recorded by {}, build {}", about.program, about.build)?;
            match self.is_other_build() {
                Some(true) => writeln!(
                    f,
                    "\n  another build than this one ({}): its last bits may differ",
                    build()
                )?,
                _ => writeln!(f, ", which is this one")?,
            }
        }
        writeln!(
            f,
            "Computed anew from {} checkpoints and {} inputs",
            self.checkpoints, self.inputs
        )?;
        writeln!(
            f,
            "  {:<16} {:>9} {:>9} {:>9} {:>9} {:>11}",
            "topic", "recorded", "compared", "differing", "missing", "not checked"
        )?;
        for (topic, check) in Topic::ALL.iter().zip(&self.topics) {
            writeln!(
                f,
                "  {:<16} {:>9} {:>9} {:>9} {:>9} {:>11}",
                topic.endpoint().name,
                check.recorded,
                check.compared,
                check.differing + check.foreign,
                check.missing,
                check.unchecked
            )?;
        }
        writeln!(
            f,
            "  {:<16} {:>9} {:>9}",
            "states at rest", self.checkpoints, self.states_at_rest
        )?;
        for reason in &self.unchecked {
            writeln!(f, "Not checked: {reason}")?;
        }
        let more = self.unchecked_reasons - self.unchecked.len() as u64;
        if more > 0 {
            writeln!(f, "Not checked for {more} more reasons")?;
        }
        if self.missing() > 0 {
            writeln!(
                f,
                "Missing: {} messages, {} of them of the journal; the recording itself says that up to {} were lost",
                self.missing(),
                self.missing_entries,
                self.admitted_losses
            )?;
        }
        match &self.first_difference {
            Some(first) => writeln!(f, "{} differences, the first:\n  {first}", self.differences),
            None if self.is_contradicted() => writeln!(
                f,
                "Messages are missing that the recording does not account for"
            ),
            None if self.is_unchecked() => {
                writeln!(f, "Nothing could be checked: no message was compared")
            }
            None => {
                let all = self.unchecked_reasons == 0 && self.unchecked_messages() == 0;
                writeln!(
                    f,
                    "Equal{}: {} messages and {} states at rest, to the last bit",
                    if all {
                        ""
                    } else {
                        " as far as it could be checked"
                    },
                    self.compared(),
                    self.states_at_rest
                )
            }
        }
    }
}
