//! The result of a verification.

use std::fmt;

use super::about::{About, build};
use super::comparison::Difference;
use crate::outgoing::{Message, Topic};

/// Maximum number of reasons kept for what was not checked; all are counted.
const MAX_REASONS: usize = 20;

/// What the recomputation of a recording has shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Verification {
    /// The program that made the recording.
    pub about: Option<About>,
    /// The recomputed topics, each at its [index](Topic::index).
    pub topics: [TopicCheck; Topic::COUNT],
    /// Checkpoints in the recording.
    pub checkpoints: u64,
    /// Checkpoints whose exact state was compared with the outcome of the responses before them.
    pub states_at_rest: u64,
    /// Commands that were executed again.
    pub inputs: u64,
    /// Messages that the node rejected before they reached the twin.
    pub refused_by_node: u64,
    /// Missing entries of the journal, according to its consecutive numbers.
    pub missing_entries: u64,
    /// Why something was not checked; the first reasons only.
    pub unchecked: Vec<String>,
    /// Number of all such reasons.
    pub unchecked_reasons: u64,
    /// Upper bound of the messages that the recording itself declares as lost. The node may declare a loss of its
    /// recorder in its status as well, so that some may be counted twice.
    pub declared_losses: u64,
    /// The first difference, in the order of the recording.
    pub first_difference: Option<Difference>,
    /// Number of differences in messages, states at rest and commands.
    pub differences: u64,
}

/// The result for one topic.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TopicCheck {
    /// Messages in the recording.
    pub recorded: u64,
    /// Recorded messages that were compared field by field.
    pub compared: u64,
    /// Compared messages that differ.
    pub differing: u64,
    /// Recorded messages that the recomputation does not produce.
    pub unexpected: u64,
    /// Messages that the recomputation produces and the recording lacks.
    pub missing: u64,
    /// Recorded messages that were not compared.
    pub unchecked: u64,
}

impl Verification {
    /// Whether everything that could be compared is equal, something was compared, and nothing is missing beyond the
    /// declared losses.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        !self.is_contradicted() && !self.is_unchecked()
    }

    /// Whether the recording differs from the recomputation, or lacks more than it declares as lost.
    #[must_use]
    pub fn is_contradicted(&self) -> bool {
        self.differences > 0 || self.missing() > self.declared_losses
    }

    /// Whether there are messages to compare, but none could be compared.
    #[must_use]
    pub fn is_unchecked(&self) -> bool {
        self.compared() == 0 && self.topics.iter().any(|it| it.recorded > 0)
    }

    /// Missing messages and missing entries of the journal.
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

    pub(super) fn note_difference(&mut self, difference: Difference) {
        self.differences += 1;
        self.first_difference.get_or_insert(difference);
    }

    pub(super) fn note_unchecked(&mut self, reason: String) {
        self.unchecked_reasons += 1;
        if self.unchecked.len() < MAX_REASONS {
            self.unchecked.push(reason);
        }
    }

    /// Notes the losses that a recorded status declares.
    pub(super) fn note_losses(&mut self, message: &Message) {
        if let Message::TwinStatus(status) = message {
            // `dropped_recording` counts a lost state once, but its hinge forces, joint states and markers are missing too.
            const FURTHER_MESSAGES_PER_STATE: u64 = 3;
            let lost = status
                .dropped_states
                .saturating_mul(FURTHER_MESSAGES_PER_STATE)
                .saturating_add(status.dropped_recording);
            self.declared_losses = self.declared_losses.max(lost);
        }
    }
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(About {
            program,
            build: recorded,
            ..
        }) = &self.about
        {
            write!(f, "Recorded by {program}, build {recorded}")?;
            match recorded == build() {
                true => writeln!(f, ", which is this build")?,
                false => writeln!(
                    f,
                    "\n  This is another build ({}); its results may differ in the last bits",
                    build()
                )?,
            }
        }
        writeln!(
            f,
            "Recomputed from {} checkpoint(s) and {} command(s)",
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
                check.differing + check.unexpected,
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
            writeln!(f, "Not checked for {more} further reasons")?;
        }
        if self.missing() > 0 {
            writeln!(
                f,
                "Missing: {} messages, {} of them journal entries; the recording declares the loss of up to {}",
                self.missing(),
                self.missing_entries,
                self.declared_losses
            )?;
        }
        match &self.first_difference {
            Some(first) => writeln!(f, "{} differences, the first:\n  {first}", self.differences),
            None if self.is_contradicted() => writeln!(
                f,
                "More messages are missing than the recording declares as lost"
            ),
            None if self.is_unchecked() => {
                writeln!(f, "Nothing could be checked: no message was compared")
            }
            None => {
                let all = self.unchecked_reasons == 0 && self.unchecked_messages() == 0;
                writeln!(
                    f,
                    "Equal{}: {} messages and {} states at rest, bit for bit",
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
