//! The result of a verification.

use std::collections::BTreeMap;
use std::fmt;

use super::about::{About, build};
use super::comparison::Difference;
use super::losses::Losses;
use super::topics::INPUTS;
use crate::endpoints;
use crate::outgoing::{Message, Topic};

/// Maximum number of reasons kept for what was not checked; all are counted.
const MAX_REASONS: usize = 20;

/// Least share of the messages of a damaged recording that must be compared for it to count as verified. Below a half, what was not compared
/// outweighs what was \[A\].
pub const LEAST_SHARE: f64 = 0.5;

/// Maximum number of columns with findings that the text lists.
const MAX_COLUMNS: usize = 20;

/// Maximum number of differences and missing messages that are kept as examples; all are counted.
const MAX_EXAMPLES: usize = 5;

/// Fields that depend on the machine or on other threads, by topic, and what was done with them instead.
pub const NOT_RECOMPUTED: [(&str, &str); 9] = [
    (
        "impact_forecast, impact_report",
        "compute_time; the time at which a forecast was complete",
    ),
    (
        "twin_status",
        "overruns, worst_lateness and the dropped_ counts, which must not decrease",
    ),
    (
        "fleet_status",
        "stamp, lateness and the counts of the node; its columns are compared with their last recorded twin_status",
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
    pub rejected_by_node: u64,
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
    /// Number of columns of a fleet; `None` for a single twin.
    pub fleet: Option<usize>,
    /// What was found about each column of a fleet that the recording tells of.
    pub columns: BTreeMap<String, ColumnCheck>,
    /// The column of a fleet to which the verification was restricted.
    pub only: Option<String>,
    /// Messages of other columns, which were not compared.
    pub of_other_columns: u64,
    /// The messages on `fleet_status`; the journal counts them with the topics that cannot be recomputed.
    pub fleet_statuses: TopicCheck,
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
    /// Whether records of it are damaged, or were left out by a repair: what is missing then is not held against its counts.
    pub is_damaged: bool,
    /// Messages that the recording has according to its own count, and that cannot be read.
    pub unread: u64,
    /// The column of a fleet that is being verified, to which whatever is noted belongs.
    pub(super) at_column: String,
    pub(super) losses: Losses,
    /// All missing messages and entries so far.
    pub(super) noted_missing: u64,
}

/// The result for one column of a fleet.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ColumnCheck {
    /// Checkpoints in the recording.
    pub checkpoints: u64,
    /// Checkpoints whose exact state was compared.
    pub states_at_rest: u64,
    /// Commands that were executed again.
    pub inputs: u64,
    /// Messages that were compared.
    pub compared: u64,
    /// Differences.
    pub differences: u64,
    /// Missing messages and entries of the journal.
    pub missing: u64,
    /// Messages that were not compared.
    pub unchecked: u64,
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
        !self.is_contradicted() && !self.is_unchecked() && !self.is_too_little()
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

    /// Whether damage has left so little of the recording that most of its messages could not be compared.
    #[must_use]
    pub fn is_too_little(&self) -> bool {
        let (compared, all) = self.extent();
        self.is_damaged && (compared as f64) < LEAST_SHARE * all as f64
    }

    /// How many messages were compared, and how many there were to compare: those in the recording, the missing ones, and those
    /// that cannot be read.
    #[must_use]
    pub fn extent(&self) -> (u64, u64) {
        let checks = || self.topics.iter().chain(&self.inputs_of);
        let compared = checks().map(|it| it.compared).sum();
        let recorded = checks().map(|it| it.recorded).fold(0, u64::saturating_add);
        // Damage can make messages both missing and unread.
        let absent = self.noted_missing.max(self.unread);
        (compared, recorded.saturating_add(absent).max(compared))
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

    /// What was found so far, of all columns.
    pub(super) fn counts(&self) -> ColumnCheck {
        ColumnCheck {
            checkpoints: self.checkpoints,
            states_at_rest: self.states_at_rest,
            inputs: self.inputs,
            compared: self.compared(),
            differences: self.differences,
            missing: self.noted_missing,
            unchecked: self.unchecked_messages(),
        }
    }

    /// The difference with the column that is being verified.
    fn of_column(&self, mut difference: Difference) -> Difference {
        if difference.column_id.is_empty() {
            difference.column_id.clone_from(&self.at_column);
        }
        difference
    }

    pub(super) fn note_difference(&mut self, difference: Difference) {
        self.note_differences(1, difference);
    }

    /// Notes several differences of which this one is an example.
    pub(super) fn note_differences(&mut self, count: u64, example: Difference) {
        let example = self.of_column(example);
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
            let example = self.of_column(example);
            self.missing_examples.push(example);
        }
    }

    pub(super) fn note_unchecked(&mut self, reason: String) {
        self.unchecked_reasons += 1;
        if self.unchecked.len() < MAX_REASONS {
            self.unchecked.push(match self.at_column.is_empty() {
                true => reason,
                false => format!("column {:?}: {reason}", self.at_column),
            });
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
        let fleet = self
            .fleet
            .map(|_| (endpoints::FLEET_STATUS.name, &self.fleet_statuses));
        inputs
            .chain(twin.zip(&self.topics))
            .chain(fleet)
            .chain(events)
    }
}

impl Verification {
    /// The columns of a fleet: how many, and those with findings.
    fn write_columns(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(fleet) = self.fleet else {
            return Ok(());
        };
        writeln!(
            f,
            "Fleet of {fleet} columns, of which {} appear in the recording",
            self.columns.len()
        )?;
        if let Some(only) = &self.only {
            writeln!(
                f,
                "Only column {only:?} was verified; {} messages of others were not compared",
                self.of_other_columns
            )?;
        }
        let has_findings =
            |it: &(&String, &ColumnCheck)| it.1.differences + it.1.missing + it.1.unchecked > 0;
        let findings: Vec<_> = self.columns.iter().filter(has_findings).collect();
        for (column_id, check) in findings.iter().take(MAX_COLUMNS) {
            writeln!(
                f,
                "  {column_id}: {} commands, {} messages compared, {} differences, {} missing, {} not checked",
                check.inputs, check.compared, check.differences, check.missing, check.unchecked
            )?;
        }
        match findings.len().saturating_sub(MAX_COLUMNS) {
            0 => Ok(()),
            more => writeln!(f, "  and {more} more columns with findings"),
        }
    }
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (compared, all) = self.extent();
        let share = 100.0 * compared as f64 / all.max(1) as f64;
        writeln!(
            f,
            "Compared {compared} of {all} messages that can be recomputed ({share:.1} %)"
        )?;
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
        self.write_columns(f)?;
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
            None if self.is_too_little() => writeln!(
                f,
                "Too little could be checked: {compared} of {all} messages; the compared messages are equal"
            ),
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
