//! What has arrived and is not taken yet: keeps the last messages, within a number and a size.

use std::collections::{HashMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::Poll;

use futures::future::poll_fn;
use futures::task::AtomicWaker;

/// The bytes of the identifier of a sender; zeros where it gives none.
pub(super) type Sender = [u8; 16];

/// Most bytes of one queue, as many as RustDDS keeps for the topic of a reader.
const MAX_BYTES: usize = 64 << 20;

/// A queue with one receiver. When it is full, the oldest entry of the sender with the largest share of it is dropped, which gaps in the
/// numbers of that sender show: a flood by one sender does not drive out what others send.
pub(super) struct Queue<T> {
    depth: usize,
    content: Mutex<Content<T>>,
    waker: AtomicWaker,
}

struct Content<T> {
    entries: VecDeque<Entry<T>>,
    /// What is in the queue of each sender.
    shares: HashMap<Sender, Share>,
    bytes: usize,
}

struct Entry<T> {
    value: T,
    bytes: usize,
    sender: Sender,
}

#[derive(Default)]
struct Share {
    entries: usize,
    bytes: usize,
}

impl<T> Queue<T> {
    /// For at most `depth` entries.
    pub fn new(depth: usize) -> Self {
        Self {
            depth: depth.max(1),
            content: Mutex::new(Content {
                entries: VecDeque::new(),
                shares: HashMap::new(),
                bytes: 0,
            }),
            waker: AtomicWaker::new(),
        }
    }

    /// Adds an entry of so many bytes by this sender.
    pub fn push(&self, value: T, bytes: usize, sender: Sender) {
        let mut content = self.content();
        let share = content.shares.entry(sender).or_default();
        share.entries += 1;
        share.bytes += bytes;
        content.bytes += bytes;
        content.entries.push_back(Entry {
            value,
            bytes,
            sender,
        });
        while content.entries.len() > self.depth {
            content.drop_of_largest(|share| share.entries);
        }
        while content.bytes > MAX_BYTES {
            content.drop_of_largest(|share| share.bytes);
        }
        drop(content);
        self.waker.wake();
    }

    /// The oldest entry, if there is one.
    pub fn pop(&self) -> Option<T> {
        self.content().remove(0)
    }

    /// Waits for an entry.
    pub async fn next(&self) -> T {
        poll_fn(|context| {
            self.waker.register(context.waker());
            self.pop().map_or(Poll::Pending, Poll::Ready)
        })
        .await
    }

    fn content(&self) -> MutexGuard<'_, Content<T>> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Content<T> {
    /// Drops the oldest entry of a sender whose share is the largest by this measure.
    fn drop_of_largest(&mut self, measure: impl Fn(&Share) -> usize) {
        let largest = self.shares.values().map(&measure).max();
        let has_most = |it: &Entry<T>| self.shares.get(&it.sender).map(&measure) == largest;
        let index = self.entries.iter().position(has_most);
        self.remove(index.unwrap_or(0));
    }

    fn remove(&mut self, index: usize) -> Option<T> {
        let Entry {
            value,
            bytes,
            sender,
        } = self.entries.remove(index)?;
        self.bytes -= bytes;
        if let Some(share) = self.shares.get_mut(&sender) {
            share.entries -= 1;
            share.bytes -= bytes;
            if share.entries == 0 {
                self.shares.remove(&sender);
            }
        }
        Some(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures::executor::block_on;

    #[test]
    fn the_last_entries_are_kept_within_number_and_size() {
        let (queue, sender) = (Queue::new(3), Sender::default());
        (0..5).for_each(|it| queue.push(it, 1, sender));
        assert_eq!(block_on(queue.next()), 2);
        queue.push(5, MAX_BYTES, sender);
        assert_eq!((queue.pop(), queue.pop()), (Some(5), None));
        queue.push(6, MAX_BYTES + 1, sender);
        assert_eq!(queue.pop(), None);
    }

    #[test]
    fn a_flood_does_not_drive_out_what_others_send() {
        let [flood, other] = [1, 2].map(|it| [it; 16]);
        let left = |queue: &Queue<i32>| std::iter::from_fn(|| queue.pop()).collect::<Vec<_>>();
        let queue = Queue::new(4);
        queue.push(-1, 1, other);
        (0..100).for_each(|it| queue.push(it, 1, flood));
        assert_eq!(left(&queue), [-1, 97, 98, 99]);
        // Nor do few large messages drive out many small ones.
        let queue = Queue::new(100);
        (0..50).for_each(|it| queue.push(it, 1, other));
        (0..10).for_each(|_| queue.push(-1, MAX_BYTES / 2, flood));
        assert_eq!(left(&queue), (0..50).chain([-1]).collect::<Vec<_>>());
    }
}
