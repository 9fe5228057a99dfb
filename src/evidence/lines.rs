//! Checks the lines of the journal against the messages between them: numbers, times and counts.

use super::comparison::{Place, seconds};
use super::journal_line::{Counting, JournalEntry, JournalLine, Tally};
use super::verification::Verification;
use crate::time::Nanos;
use crate::twin::Journal;

/// Maximum time between what an entry of the journal describes and its recording \[ns\], which the fastest entry of every
/// recording keeps: one that keeps it in no entry was moved in time.
pub const MAX_DELAY: Nanos = 900_000_000;

/// Maximum time by which an entry may be recorded before what it describes \[ns\]: the twin's clock follows the system clock
/// only while the column is at rest.
pub const MAX_LEAD: Nanos = 100_000_000;

/// Minimum number of entries for a check of delays: at the start of a node, all of them are late.
const MIN_DELAYS: u64 = 4;

/// The checks of the lines, in the order of the recording.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// The number of the next line; `None` before the first.
    next: Option<u64>,
    since: Counting,
    /// Whether counts hold: nothing in the recording is damaged.
    is_undamaged: bool,
    /// The messages between the first line and the second one are in an earlier recording.
    repeats_checkpoint: bool,
    /// What has begun in an earlier recording may not be over: the columns of a fleet may not have given out a checkpoint.
    pub is_late: bool,
    /// Missing messages according to the counts that recomputation has not found to be missing.
    shortage: u64,
    delays: Delays,
    /// The end of the journal was read.
    pub ended: bool,
}

/// Delays between what the entries describe and their recording \[ns\].
#[derive(Debug, Default)]
struct Delays {
    count: u64,
    range: Option<(Nanos, Nanos)>,
    simulated: bool,
    /// A checkpoint has told whether the times are simulated. One of a fleet may begin late, and have none.
    is_clock_known: bool,
}

/// What a line tells about the lines before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gap {
    /// None is missing.
    None,
    /// This many lines are missing.
    Missing(u64),
    /// This many lines that follow the first checkpoint, and messages before this line, are in an earlier recording, as the
    /// recording declares.
    Earlier(u64),
}

impl Lines {
    pub fn new(is_undamaged: bool, repeats_checkpoint: bool) -> Self {
        Self {
            is_undamaged,
            repeats_checkpoint,
            is_late: repeats_checkpoint,
            ..Self::default()
        }
    }

    /// Takes a message on any topic but the journal's.
    pub fn message(&mut self, topic: &str, log_time: Nanos, is_recomputed: bool) {
        self.since.add(topic, log_time, is_recomputed);
    }

    /// Takes the content of measurements, after [`message`](Self::message).
    pub fn measurement(&mut self, publish_time: Nanos, bytes: &[u8]) {
        self.since.add_measurement(publish_time, bytes);
    }

    /// The number of the next line, if there was one.
    pub fn next(&self) -> Option<u64> {
        self.next
    }

    /// Whether the recording begins with a copy of a checkpoint that no other line has followed.
    pub fn is_continuation(&self) -> bool {
        self.repeats_checkpoint
    }

    /// Compares the number and the time of a line with its place.
    pub fn place(
        &mut self,
        line: &JournalLine,
        place: &Place<'_>,
        publish_time: Nanos,
        found: &mut Verification,
    ) -> Gap {
        for (field, time) in [("log time", place.log_time), ("publish time", publish_time)] {
            if time != line.recorded {
                found.note_difference(place.difference(
                    field,
                    seconds(time),
                    format!("{} according to the line", seconds(line.recorded)),
                ));
            }
        }
        if self.ended {
            found.note_difference(place.difference("the line", "after the end", "before the end"));
        }
        self.delays.add(line);
        let is_second = self.next.is_some() && std::mem::take(&mut self.repeats_checkpoint);
        let next = self.next.replace(line.number.saturating_add(1));
        let Some(expected) = next else {
            return Gap::None;
        };
        if line.number < expected {
            found.note_difference(place.difference(
                "number of the line",
                line.number.to_string(),
                expected.to_string(),
            ));
            return Gap::None;
        }
        match line.number - expected {
            lost if is_second => Gap::Earlier(lost),
            0 => Gap::None,
            lost => Gap::Missing(lost),
        }
    }

    /// Compares the messages since the previous line with its count. `is_first` if there was no line before.
    /// Returns whether the measurements are those that the line tells of.
    pub fn count(
        &mut self,
        line: &JournalLine,
        gap: Gap,
        is_first: bool,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> bool {
        let own = std::mem::take(&mut self.since).tally();
        let is_measured = own.measurements == line.since.measurements;
        // The messages before the first line are in an earlier recording, unless it is the first of all.
        let is_known = gap == Gap::None && (!is_first || line.number == 0);
        if !is_known || !self.is_undamaged {
            return is_measured;
        }
        let Tally {
            messages,
            others,
            times,
            measurements,
            lost_measurements: _,
        } = &line.since;
        let difference = || {
            place.difference(
                "messages that are not recomputed since the previous line",
                own.others.to_string(),
                others.to_string(),
            )
        };
        let extra = own.others.saturating_sub(*others);
        if extra > 0 {
            found.note_differences(extra, difference());
        }
        let lost = others.saturating_sub(own.others);
        if lost > 0 {
            found.missing_others += lost;
            found.note_missing(lost, difference());
        }
        self.shortage += messages.saturating_sub(own.messages);
        if own.messages == *messages && own.times != *times {
            found.note_difference(place.difference(
                "order and log times of the messages since the previous line",
                own.times,
                times.clone(),
            ));
        } else if own.messages > *messages {
            found.note_difference(place.difference(
                "messages since the previous line",
                own.messages.to_string(),
                messages.to_string(),
            ));
        } else if own.messages == *messages && own.measurements != *measurements {
            found.note_difference(place.difference(
                "content and publish times of the measurements since the previous line",
                own.measurements,
                measurements.clone(),
            ));
        }
        is_measured
    }

    /// Settles the counts where recomputation has noted everything that is missing, `noted` messages since the last time.
    pub fn settle(&mut self, noted: u64, place: &Place<'_>, found: &mut Verification) {
        let more = std::mem::take(&mut self.shortage).saturating_sub(noted);
        if more > 0 {
            found.missing_others += more;
            found.note_missing(
                more,
                place.difference(
                    "messages since the previous line",
                    format!("{more} fewer"),
                    "as many as the line counts",
                ),
            );
        }
    }

    /// Checks the delays of all entries.
    pub fn finish(&self, place: &Place<'_>, found: &mut Verification) {
        let Some((least, most)) = self.delays.range else {
            return;
        };
        let is_comparable = self.delays.is_clock_known && !self.delays.simulated;
        if !is_comparable || self.delays.count < MIN_DELAYS {
            return;
        }
        if least > MAX_DELAY || most < -MAX_LEAD {
            found.note_difference(place.difference(
                "log times",
                format!(
                    "{} s to {} s after what the entries of the journal describe",
                    seconds(least),
                    seconds(most)
                ),
                format!("at most {} s after it at least once", seconds(MAX_DELAY)),
            ));
        }
    }
}

impl Delays {
    fn add(&mut self, line: &JournalLine) {
        let JournalEntry::Twin(entry) = &line.entry else {
            return;
        };
        let described = match entry {
            Journal::Checkpoint(checkpoint) => {
                self.is_clock_known = true;
                // Times of another clock tell nothing about this one.
                self.simulated |= checkpoint.parameters.settings().use_sim_time;
                checkpoint.stamp
            }
            Journal::Command(record) => record.now,
            Journal::Status(record) => record.stamp,
        };
        let delay = line.recorded.saturating_sub(described);
        self.count += 1;
        self.range = Some(self.range.map_or((delay, delay), |(least, most)| {
            (least.min(delay), most.max(delay))
        }));
    }
}
