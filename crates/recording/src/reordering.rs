//! Sorts messages by time while holding only those that are out of order.
//!
//! A first pass notes the smallest time of every block of messages; a second pass can return a message as soon as no
//! later block contains an older one. This needs no index.

use std::collections::BTreeMap;
use std::sync::Arc;

/// Maximum number of bytes of messages that are held to sort them.
pub const MAX_OUT_OF_ORDER: usize = 256 << 20;

/// Number of messages in a block.
const BLOCK_MESSAGES: usize = 1024;

/// Number of bytes at which a block ends earlier.
const BLOCK_BYTES: usize = 1 << 20;

/// Finds the ends of blocks, at the same messages in both passes.
#[derive(Debug, Default)]
struct BlockEnds {
    messages: usize,
    bytes: usize,
}

impl BlockEnds {
    /// Whether a block ends with this message.
    fn ends_with(&mut self, bytes: usize) -> bool {
        self.messages += 1;
        self.bytes += bytes;
        let ends = self.messages >= BLOCK_MESSAGES || self.bytes >= BLOCK_BYTES;
        if ends {
            *self = Self::default();
        }
        ends
    }
}

/// The smallest time of every block.
#[derive(Debug, Default)]
pub(crate) struct Blocks {
    ends: BlockEnds,
    minima: Vec<u64>,
    open: bool,
}

impl Blocks {
    /// Adds the next message of the first pass.
    pub fn add(&mut self, time: u64, bytes: usize) {
        if !self.open {
            self.minima.push(u64::MAX);
        }
        if let Some(minimum) = self.minima.last_mut() {
            *minimum = time.min(*minimum);
        }
        self.open = !self.ends.ends_with(bytes);
    }

    /// The smallest time from each block on.
    pub fn finish(mut self) -> Vec<u64> {
        let mut min = u64::MAX;
        for minimum in self.minima.iter_mut().rev() {
            min = min.min(*minimum);
            *minimum = min;
        }
        self.minima
    }
}

/// Sorts the messages of the second pass; messages with equal times keep their order.
#[derive(Debug)]
pub(crate) struct Reordering<T> {
    ends: BlockEnds,
    block: usize,
    /// Smallest time from each block on.
    min_from: Arc<[u64]>,
    /// The messages that wait, with their bytes, by time and number.
    held: BTreeMap<(u64, u64), (usize, T)>,
    held_bytes: usize,
    next_number: u64,
}

impl<T> Reordering<T> {
    pub fn new(min_from: Arc<[u64]>) -> Self {
        Self {
            ends: BlockEnds::default(),
            block: 0,
            min_from,
            held: BTreeMap::new(),
            held_bytes: 0,
            next_number: 0,
        }
    }

    /// Adds the next message of the second pass.
    pub fn push(&mut self, time: u64, bytes: usize, message: T) {
        self.held.insert((time, self.next_number), (bytes, message));
        self.next_number += 1;
        self.held_bytes += bytes;
        self.block += usize::from(self.ends.ends_with(bytes));
    }

    /// The first message, if no message that follows can precede it.
    pub fn pop(&mut self) -> Option<T> {
        // Nothing follows the last block; more messages of the current block may follow.
        let min = self.min_from.get(self.block).copied().unwrap_or(u64::MAX);
        // A later message with an equal time comes after those that are held.
        let ((first, _), _) = self.held.first_key_value()?;
        if *first <= min { self.take() } else { None }
    }

    /// The first message, once all messages were added.
    pub fn take(&mut self) -> Option<T> {
        let (_, (bytes, message)) = self.held.pop_first()?;
        self.held_bytes -= bytes;
        Some(message)
    }

    /// Bytes of the messages that are held, and of their entries here, because a message may be empty.
    pub fn held_bytes(&self) -> usize {
        self.held_bytes + self.held.len() * size_of::<Entry<T>>()
    }
}

/// An entry for a message that is held.
type Entry<T> = ((u64, u64), (usize, T));

#[cfg(test)]
mod tests {
    use super::*;

    /// The resulting order, and the maximum that was held.
    fn reordered(times: &[u64]) -> (Vec<(u64, usize)>, usize) {
        let mut blocks = Blocks::default();
        times.iter().for_each(|time| blocks.add(*time, 1));
        let mut reordering = Reordering::new(blocks.finish().into());
        let (mut out, mut most) = (Vec::new(), 0);
        for (index, time) in times.iter().enumerate() {
            reordering.push(*time, 1, (*time, index));
            most = most.max(reordering.held_bytes());
            while let Some(message) = reordering.pop() {
                out.push(message);
            }
        }
        while let Some(message) = reordering.take() {
            out.push(message);
        }
        (out, most)
    }

    fn expected(times: &[u64]) -> Vec<(u64, usize)> {
        let mut sorted: Vec<_> = times.iter().copied().zip(0..).collect();
        sorted.sort_by_key(|(time, _)| *time);
        sorted
    }

    #[test]
    fn sorted_messages_are_hardly_held() {
        let times: Vec<u64> = (0..10_000).collect();
        let (out, most) = reordered(&times);
        assert_eq!(out, expected(&times));
        let each = 1 + size_of::<Entry<(u64, usize)>>();
        assert!(most <= BLOCK_MESSAGES * each, "{most}");
    }

    #[test]
    fn an_empty_message_counts_too() {
        let mut reordering = Reordering::new(vec![0; 100].into());
        for time in 1..=1000 {
            reordering.push(time, 0, ());
            assert!(reordering.pop().is_none());
        }
        assert!(reordering.held_bytes() >= 1000 * size_of::<Entry<()>>());
        while reordering.take().is_some() {}
        assert_eq!(reordering.held_bytes(), 0);
    }

    #[test]
    fn any_order_becomes_sorted_and_stable() {
        // The linear congruential generator of Knuth's MMIX.
        let mut state = 1_u64;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        for spread in [1, 3, 1000, 100_000] {
            let times: Vec<u64> = (0..5_000).map(|index| index + random() % spread).collect();
            assert_eq!(reordered(&times).0, expected(&times), "spread {spread}");
        }
        let backwards: Vec<u64> = (0..5_000).rev().collect();
        assert_eq!(reordered(&backwards).0, expected(&backwards));
        assert_eq!(reordered(&[]).0, []);
    }
}
