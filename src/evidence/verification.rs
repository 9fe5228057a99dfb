//! The result of a verification.

use std::fmt;

use super::about::{About, build};
use super::comparison::Difference;
use super::inputs::INPUTS;
use super::losses::Losses;
use crate::endpoints;
use crate::outgoing::{Message, Topic};

/// Maximum number of reasons kept for what was not checked; all are counted.
const MAX_REASONS: usize = 20;

/// Maximum number of differences and missing messages that are kept as examples; all are counted.
const MAX_EXAMPLES: usize = 5;

/// Fields that depend on the machine or on other threads, by topic, and what was done with them instead.
pub const NOT_RECOMPUTED: [(&str, &str); 8] = [
    (
        "impact_forecast, impact_report",
        "compute_time; the time at which a forecast was complete",
    ),
    (
        "twin_status",
        "overruns, worst_lateness and the dropped_ counts, which must not decrease",
    ),
    ("parameter_events", "the stamp"),
    (
        "rosout, diagnostics",
        "their contents; their number, order and log times are compared with the counts in the journal",
    ),
    (
        "impact_event, column_parameters",
        "whether sender and publish time are genuine; bytes and times are compared with the journal",
    ),
    (
        "estimates in the journal",
        "the instant of contact and the zeros of the sensors with which an impact was detected, and its first batch",
    ),
    (
        "journal",
        "the sender of a command that came by a service, and the last digits of times that change no result",
    ),
    (
        "all",
        "whether a forger has recomputed messages, journal, counts and times: only a seal shows that",
    ),
];

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
    /// The estimates in the journal: `compared` were computed again from the recorded measurements.
    pub estimates: TopicCheck,
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
    /// The first differences, in the order of the recording.
    pub examples: Vec<Difference>,
    /// The topics whose messages became commands, in the order `impact_event`, `column_parameters`.
    pub inputs_of: [TopicCheck; INPUTS.len()],
    /// The messages on `parameter_events`; the journal counts them with the topics that cannot be recomputed.
    pub parameter_events: TopicCheck,
    /// Missing messages on topics that cannot be recomputed, or where nothing could be recomputed.
    pub missing_others: u64,
    /// Missing messages and entries whose loss the recording does not declare.
    pub undeclared: u64,
    /// The first missing messages, in the order in which their absence shows.
    pub missing_examples: Vec<Difference>,
    /// Numbers of the first and the last line of the journal.
    pub lines: Option<(u64, u64)>,
    /// How the recording ends, for people.
    pub ending: String,
    pub(super) losses: Losses,
    /// All missing messages and entries so far.
    pub(super) noted_missing: u64,
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
    /// Recorded messages that are at another place than the recomputation has them.
    pub misplaced: u64,
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
        self.differences > 0 || self.undeclared > 0
    }

    /// Whether there are messages to compare, but none could be compared.
    #[must_use]
    pub fn is_unchecked(&self) -> bool {
        self.compared() == 0 && self.topics.iter().any(|it| it.recorded > 0)
    }

    /// Missing messages and missing entries of the journal, whether their loss is declared or not.
    #[must_use]
    pub fn missing(&self) -> u64 {
        let checks = self.topics.iter().chain(&self.inputs_of);
        checks
            .map(|it| it.missing)
            .fold(self.missing_entries, u64::saturating_add)
            .saturating_add(self.missing_others)
    }

    /// Messages that were compared.
    #[must_use]
    pub fn compared(&self) -> u64 {
        self.topics.iter().map(|it| it.compared).sum()
    }

    /// Messages that were not compared.
    #[must_use]
    pub fn unchecked_messages(&self) -> u64 {
        let checks = self.topics.iter().chain(&self.inputs_of);
        checks.map(|it| it.unchecked).sum()
    }

    pub(super) fn note_difference(&mut self, difference: Difference) {
        self.note_differences(1, difference);
    }

    /// Notes several differences of which this one is an example.
    pub(super) fn note_differences(&mut self, count: u64, example: Difference) {
        self.differences = self.differences.saturating_add(count);
        if self.examples.len() < MAX_EXAMPLES {
            self.examples.push(example.clone());
        }
        self.first_difference.get_or_insert(example);
    }

    /// Notes that messages or entries are missing of which this one is an example; its log time is that at which they show to
    /// be missing.
    pub(super) fn note_missing(&mut self, count: u64, example: Difference) {
        self.noted_missing = self.noted_missing.saturating_add(count);
        self.losses.missing(count, example.log_time);
        if self.missing_examples.len() < MAX_EXAMPLES {
            self.missing_examples.push(example);
        }
    }

    pub(super) fn note_unchecked(&mut self, reason: String) {
        self.unchecked_reasons += 1;
        if self.unchecked.len() < MAX_REASONS {
            self.unchecked.push(reason);
        }
    }

    /// Notes the losses that a recorded status declares.
    pub(super) fn note_losses(&mut self, message: &Message, log_time: i64) {
        if let Message::TwinStatus(status) = message {
            self.losses.status(status, log_time);
        }
    }

    /// Weighs what is missing against what is declared; the recorder declares `lost` messages, and nothing is known about
    /// missing ones `if_damaged`.
    pub(super) fn weigh_losses(&mut self, lost: u64, if_damaged: bool) {
        let losses = std::mem::take(&mut self.losses);
        self.declared_losses = losses.declared().max(lost);
        self.undeclared = match if_damaged {
            true => 0,
            false => losses.undeclared(lost),
        };
    }

    /// The rows of the table: names in the table of endpoints, and their results.
    pub fn rows(&self) -> impl Iterator<Item = (&'static str, &TopicCheck)> {
        let inputs = INPUTS.iter().map(|it| it.name).zip(&self.inputs_of);
        let twin = Topic::ALL.iter().map(|it| it.endpoint().name);
        let events = [(
            endpoints::PARAMETER_EVENTS.name.trim_start_matches('/'),
            &self.parameter_events,
        )];
        inputs.chain(twin.zip(&self.topics)).chain(events)
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
            "  {:<17} {:>9} {:>9} {:>9} {:>9} {:>11}",
            "topic", "recorded", "compared", "differing", "missing", "not checked"
        )?;
        for (name, check) in self.rows() {
            writeln!(
                f,
                "  {name:<17} {:>9} {:>9} {:>9} {:>9} {:>11}",
                check.recorded,
                check.compared,
                check.differing + check.misplaced + check.unexpected,
                check.missing,
                check.unchecked
            )?;
        }
        if let Some((first, last)) = self.lines {
            writeln!(
                f,
                "  {:<17} {:>9} {:>9} {:>9} {:>9}",
                endpoints::JOURNAL.name.trim_start_matches("~/"),
                last.saturating_sub(first)
                    .saturating_add(1)
                    .saturating_sub(self.missing_entries),
                "",
                "",
                self.missing_entries
            )?;
        }
        writeln!(
            f,
            "  {:<17} {:>9} {:>9}",
            "states at rest", self.checkpoints, self.states_at_rest
        )?;
        let estimates = &self.estimates;
        if estimates.recorded > 0 {
            writeln!(
                f,
                "  {:<17} {:>9} {:>9} {:>9} {:>9} {:>11}",
                "estimates",
                estimates.recorded,
                estimates.compared,
                estimates.differing,
                "",
                estimates.unchecked
            )?;
        }
        if let Some((first, last)) = self.lines {
            writeln!(
                f,
                "The journal has the lines {first} to {last}; {}",
                self.ending
            )?;
        }
        writeln!(f, "Not recomputed:")?;
        for (topics, fields) in NOT_RECOMPUTED {
            writeln!(f, "  {topics}: {fields}")?;
        }
        for reason in &self.unchecked {
            writeln!(f, "Not checked: {reason}")?;
        }
        let more = self.unchecked_reasons - self.unchecked.len() as u64;
        if more > 0 {
            writeln!(f, "Not checked for {more} further reasons")?;
        }
        if self.noted_missing > 0 {
            writeln!(
                f,
                "Missing: {} messages, {} of them journal entries; the recording declares the loss of up to {}, which leaves \
                 {} undeclared. The first:",
                self.noted_missing, self.missing_entries, self.declared_losses, self.undeclared
            )?;
            for example in &self.missing_examples {
                writeln!(f, "  {example}")?;
            }
        }
        match &self.first_difference {
            Some(_) => {
                writeln!(f, "{} differences, the first:", self.differences)?;
                for example in &self.examples {
                    writeln!(f, "  {example}")?;
                }
                Ok(())
            }
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
