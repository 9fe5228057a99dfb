//! Detects lost messages.
//!
//! RustDDS keeps as many messages as the quality of service allows and silently drops the oldest when they arrive faster
//! than they are taken. Writers number their messages consecutively, so gaps are losses.

use std::collections::HashMap;

use ros2_client::{Gid, MessageInfo};

/// Maximum number of writers that are tracked; beyond that all are forgotten, and gaps across that point go unnoticed.
const MAX_WRITERS: usize = 1024;

/// Counts the gaps in the sequence numbers of the writers on a reliable topic.
#[derive(Debug, Default)]
pub struct Missed {
    last: HashMap<Gid, LastMessage>,
    /// Unreadable messages, whose writers are unknown: they leave gaps too.
    unreadable: u64,
}

/// The newest message of a writer.
#[derive(Debug, Clone, Copy)]
struct LastMessage {
    number: i64,
    /// Value of [`Missed::unreadable`] at this message; earlier ones explain no later gap.
    unreadable: u64,
}

impl Missed {
    /// Number of messages missing before this one.
    pub fn before(&mut self, info: &MessageInfo) -> u64 {
        self.before_number(info.publisher_gid(), info.sequence_number())
    }

    /// Notes an unreadable message.
    pub fn unreadable(&mut self) {
        self.unreadable += 1;
    }

    /// As [`before`](Self::before), of the message with this number of a writer.
    pub fn before_number(&mut self, writer: Gid, number: i64) -> u64 {
        if self.last.len() >= MAX_WRITERS && !self.last.contains_key(&writer) {
            self.last.clear();
        }
        let this = LastMessage {
            number,
            unreadable: self.unreadable,
        };
        let Some(last) = self.last.insert(writer, this) else {
            // Messages sent before the match are not counted.
            return 0;
        };
        let gap = number.saturating_sub(last.number).saturating_sub(1);
        let gap = u64::try_from(gap).unwrap_or(0);
        gap.saturating_sub(this.unreadable - last.unreadable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_counted_per_writer() {
        let mut missed = Missed::default();
        let [one, other] = [1, 2].map(|first| Gid::from([first; 16]));
        let counts: Vec<_> = [
            (one, 7),
            (one, 8),
            (other, 1),
            (one, 12),
            (other, 2),
            (one, 12),
            (one, 3),
        ]
        .map(|(writer, number)| missed.before_number(writer, number))
        .to_vec();
        assert_eq!(counts, [0, 0, 0, 3, 0, 0, 0]);
        missed.unreadable();
        assert_eq!(missed.before_number(other, 5), 1);
    }

    /// A peer that keeps sending another type does not explain later losses.
    #[test]
    fn earlier_unreadable_messages_explain_no_gap() {
        let mut missed = Missed::default();
        let writer = Gid::from([1; 16]);
        assert_eq!(missed.before_number(writer, 1), 0);
        (0..1000).for_each(|_| missed.unreadable());
        assert_eq!(missed.before_number(writer, 2), 0);
        assert_eq!(missed.before_number(writer, 6), 3);
        missed.unreadable();
        assert_eq!(missed.before_number(writer, 8), 0);
    }
}
