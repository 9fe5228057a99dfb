//! Messages that a reader never saw.
//!
//! RustDDS keeps as many messages as the quality of service says, and drops the oldest in silence when a sender is faster
//! than they are taken. What a writer numbers without a hole must arrive without one: holes are losses.

use std::collections::HashMap;

use ros2_client::{Gid, MessageInfo};

/// Most writers that are remembered; beyond that all are forgotten, and holes across that point are not seen.
const MAX_WRITERS: usize = 1024;

/// Counts the holes in what the writers of a reliable topic have numbered.
#[derive(Debug, Default)]
pub(super) struct Missed {
    last: HashMap<Gid, LastMessage>,
    /// Messages that came and could not be read, by whom is not known: they leave holes too.
    unreadable: u64,
}

/// The newest message of a writer.
#[derive(Debug, Clone, Copy)]
struct LastMessage {
    number: i64,
    /// Of [`Missed::unreadable`], those before it: they explain no hole behind it.
    unreadable: u64,
}

impl Missed {
    /// How many messages are missing before this one.
    pub fn before(&mut self, info: &MessageInfo) -> u64 {
        self.before_number(info.publisher_gid(), info.sequence_number())
    }

    /// A message that came could not be read.
    pub fn unreadable(&mut self) {
        self.unreadable += 1;
    }

    fn before_number(&mut self, writer: Gid, number: i64) -> u64 {
        if self.last.len() >= MAX_WRITERS && !self.last.contains_key(&writer) {
            self.last.clear();
        }
        let this = LastMessage {
            number,
            unreadable: self.unreadable,
        };
        let Some(last) = self.last.insert(writer, this) else {
            // Nothing is known of what was sent before the two had met.
            return 0;
        };
        let hole = number.saturating_sub(last.number).saturating_sub(1);
        let hole = u64::try_from(hole).unwrap_or(0);
        hole.saturating_sub(this.unreadable - last.unreadable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_counted_writer_by_writer() {
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

    /// A peer of another type that goes on and on excuses no loss that comes later.
    #[test]
    fn what_was_unreadable_before_explains_no_hole() {
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
