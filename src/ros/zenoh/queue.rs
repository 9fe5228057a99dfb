//! What has arrived and is not taken yet: keeps the last messages, within a number and a size.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::Poll;

use futures::future::poll_fn;
use futures::task::AtomicWaker;

/// Most bytes of one queue, as many as RustDDS keeps for the topic of a reader.
const MAX_BYTES: usize = 64 << 20;

/// A queue with one receiver. When it is full, the oldest entries are dropped, which gaps in their numbers show.
pub(super) struct Queue<T> {
    depth: usize,
    content: Mutex<Content<T>>,
    waker: AtomicWaker,
}

struct Content<T> {
    entries: VecDeque<(T, usize)>,
    bytes: usize,
}

impl<T> Queue<T> {
    /// For at most `depth` entries.
    pub fn new(depth: usize) -> Self {
        Self {
            depth: depth.max(1),
            content: Mutex::new(Content {
                entries: VecDeque::new(),
                bytes: 0,
            }),
            waker: AtomicWaker::new(),
        }
    }

    /// Adds an entry of so many bytes.
    pub fn push(&self, entry: T, bytes: usize) {
        let mut content = self.content();
        content.entries.push_back((entry, bytes));
        content.bytes += bytes;
        while content.entries.len() > self.depth || content.bytes > MAX_BYTES {
            content.pop();
        }
        drop(content);
        self.waker.wake();
    }

    /// The oldest entry, if there is one.
    pub fn pop(&self) -> Option<T> {
        self.content().pop()
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
    fn pop(&mut self) -> Option<T> {
        let (entry, bytes) = self.entries.pop_front()?;
        self.bytes -= bytes;
        Some(entry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures::executor::block_on;

    #[test]
    fn the_last_entries_are_kept_within_number_and_size() {
        let queue = Queue::new(3);
        (0..5).for_each(|it| queue.push(it, 1));
        assert_eq!(block_on(queue.next()), 2);
        queue.push(5, MAX_BYTES);
        assert_eq!((queue.pop(), queue.pop()), (Some(5), None));
        queue.push(6, MAX_BYTES + 1);
        assert_eq!(queue.pop(), None);
    }
}
