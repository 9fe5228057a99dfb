//! Puts messages into the order of their times without holding more than what is out of order.
//!
//! A first reading notes the smallest time of every block of messages; a second reading may hand out a message as soon as
//! no later block holds an older one. No index is needed, and none is believed.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Messages of a block.
const BLOCK_MESSAGES: usize = 1024;

/// Bytes at which a block ends earlier.
const BLOCK_BYTES: usize = 1 << 20;

/// Where blocks end: equal for equal messages.
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

/// The smallest time of every block; after the first reading that of all blocks from there on.
#[derive(Debug, Default)]
pub(crate) struct Blocks {
    ends: BlockEnds,
    minima: Vec<u64>,
    open: bool,
}

impl Blocks {
    /// The next message of the first reading.
    pub fn add(&mut self, time: u64, bytes: usize) {
        if !self.open {
            self.minima.push(u64::MAX);
        }
        if let Some(minimum) = self.minima.last_mut() {
            *minimum = time.min(*minimum);
        }
        self.open = !self.ends.ends_with(bytes);
    }

    /// The end of the first reading.
    pub fn finish(mut self) -> Vec<u64> {
        let mut least = u64::MAX;
        for minimum in self.minima.iter_mut().rev() {
            least = least.min(*minimum);
            *minimum = least;
        }
        self.minima
    }
}

/// Puts the messages of the second reading into order; those of equal time stay as they are.
#[derive(Debug)]
pub(crate) struct Reordering<T> {
    ends: BlockEnds,
    block: usize,
    /// Smallest time from each block on.
    least_from: Arc<[u64]>,
    held: BinaryHeap<Reverse<Held<T>>>,
    held_bytes: usize,
    next_number: u64,
}

#[derive(Debug)]
struct Held<T> {
    time: u64,
    number: u64,
    bytes: usize,
    message: T,
}

impl<T> Reordering<T> {
    pub fn new(least_from: Arc<[u64]>) -> Self {
        Self {
            ends: BlockEnds::default(),
            block: 0,
            least_from,
            held: BinaryHeap::new(),
            held_bytes: 0,
            next_number: 0,
        }
    }

    /// The next message of the second reading.
    pub fn push(&mut self, time: u64, bytes: usize, message: T) {
        self.held.push(Reverse(Held {
            time,
            number: self.next_number,
            bytes,
            message,
        }));
        self.next_number += 1;
        self.held_bytes += bytes;
        self.block += usize::from(self.ends.ends_with(bytes));
    }

    /// A message before which none can come any more.
    pub fn pop(&mut self) -> Option<T> {
        // Behind the last block nothing comes; of a block that is open more may.
        let least = self.least_from.get(self.block).copied().unwrap_or(u64::MAX);
        // Of equal times the one that was there first comes first, so those that are held may go.
        let may_go = self
            .held
            .peek()
            .is_some_and(|Reverse(first)| first.time <= least);
        if may_go { self.take() } else { None }
    }

    /// The next of those that are left at the end.
    pub fn take(&mut self) -> Option<T> {
        let Reverse(first) = self.held.pop()?;
        self.held_bytes -= first.bytes;
        Some(first.message)
    }

    /// Bytes that are held: of the messages, and of what is known of each, for a message may be empty.
    pub fn held_bytes(&self) -> usize {
        self.held_bytes + self.held.len() * size_of::<Reverse<Held<T>>>()
    }
}

impl<T> Held<T> {
    fn key(&self) -> (u64, u64) {
        (self.time, self.number)
    }
}

impl<T> PartialEq for Held<T> {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl<T> Eq for Held<T> {}

impl<T> PartialOrd for Held<T> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Held<T> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The order that comes out, and the most that was held.
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
    fn what_is_in_order_is_hardly_held() {
        let times: Vec<u64> = (0..10_000).collect();
        let (out, most) = reordered(&times);
        assert_eq!(out, expected(&times));
        let each = 1 + size_of::<Reverse<Held<(u64, usize)>>>();
        assert!(most <= BLOCK_MESSAGES * each, "{most}");
    }

    #[test]
    fn an_empty_message_takes_memory_too() {
        let mut reordering = Reordering::new(vec![0; 100].into());
        for time in 1..=1000 {
            reordering.push(time, 0, ());
            assert!(reordering.pop().is_none());
        }
        assert!(reordering.held_bytes() >= 1000 * size_of::<Held<()>>());
        while reordering.take().is_some() {}
        assert_eq!(reordering.held_bytes(), 0);
    }

    #[test]
    fn whatever_the_order_it_comes_out_sorted_and_stable() {
        // The simplest generator of numbers that jump: those of Knuth's MMIX.
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
