//! Bounded queues between the threads, each with a name, a policy for when it is full, and its counts.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crossbeam_queue::ArrayQueue;

use super::notifier::Notifier;
use crate::twin::Output;

/// What a full queue does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhenFull {
    /// It refuses, and its sender is told.
    Refuse,
    /// It drops its oldest entry.
    DropOldest,
    /// It drops what comes.
    DropNewest,
}

impl WhenFull {
    /// The policy in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Refuse => "the sender is refused",
            Self::DropOldest => "the oldest entry is dropped",
            Self::DropNewest => "the newest entry is dropped",
        }
    }
}

/// A queue as it is now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueStats {
    /// What it is called.
    pub name: String,
    /// Most entries.
    pub capacity: usize,
    /// Entries now.
    pub len: usize,
    /// What it does when it is full.
    pub when_full: WhenFull,
    /// Entries that were offered since the start.
    pub pushed: u64,
    /// Entries that were refused or dropped since the start.
    pub dropped: u64,
}

/// A bounded queue without locks; its memory is taken at the start.
#[derive(Debug)]
pub(crate) struct Queue<T> {
    name: String,
    entries: ArrayQueue<T>,
    when_full: WhenFull,
    pushed: AtomicU64,
    dropped: AtomicU64,
}

impl<T> Queue<T> {
    pub fn new(name: String, capacity: usize, when_full: WhenFull) -> Self {
        Self {
            name,
            entries: ArrayQueue::new(capacity.max(1)),
            when_full,
            pushed: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        }
    }

    /// Puts an entry in; `false` if an entry was lost, or this one refused.
    pub fn push(&self, entry: T) -> bool {
        self.pushed.fetch_add(1, Ordering::Relaxed);
        let kept = match self.when_full {
            WhenFull::Refuse | WhenFull::DropNewest => self.entries.push(entry).is_ok(),
            WhenFull::DropOldest => self.entries.force_push(entry).is_none(),
        };
        if !kept {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        kept
    }

    pub fn pop(&self) -> Option<T> {
        self.entries.pop()
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub fn stats(&self) -> QueueStats {
        QueueStats {
            name: self.name.clone(),
            capacity: self.entries.capacity(),
            len: self.entries.len(),
            when_full: self.when_full,
            pushed: self.pushed.load(Ordering::Relaxed),
            dropped: self.dropped.load(Ordering::Relaxed),
        }
    }
}

/// A reader that everything is sent to which leaves the twin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputQueue {
    /// Who reads it.
    pub name: String,
    /// Most states that wait for it.
    pub states: usize,
    /// Most forecasts, reports and changes of parameters together, and most refusals, status and notices together, and most entries of the journal.
    pub others: usize,
    /// What all of them do when they are full.
    pub when_full: WhenFull,
}

impl OutputQueue {
    /// Name of the queue to ROS.
    pub const ROS: &str = "ros";

    /// To ROS: the oldest are dropped.
    #[must_use]
    pub fn ros() -> Self {
        Self {
            name: Self::ROS.to_owned(),
            states: 4096,
            others: 1024,
            when_full: WhenFull::DropOldest,
        }
    }
}

/// Ways to one reader.
const WAYS: usize = 4;

/// All ways to one reader, so that no flood of states or refusals can drop a report.
#[derive(Debug)]
pub(super) struct OutputQueues {
    pub name: String,
    ways: [Queue<Numbered>; WAYS],
    next_number: AtomicU64,
    notifier: Notifier,
}

#[derive(Debug)]
struct Numbered {
    number: u64,
    output: Output,
}

impl OutputQueues {
    pub fn new(queue: &OutputQueue) -> Self {
        let OutputQueue {
            name,
            states,
            others,
            when_full,
        } = queue;
        let way = |what, capacity| Queue::new(format!("{what} to {name}"), capacity, *when_full);
        Self {
            name: name.clone(),
            ways: [
                way("states", *states),
                way("results", *others),
                way("messages", *others),
                way("journal", *others),
            ],
            next_number: AtomicU64::new(0),
            notifier: Notifier::default(),
        }
    }

    pub fn push(&self, output: Output) {
        let number = self.next_number.fetch_add(1, Ordering::Relaxed);
        let [states, results, messages, journal] = &self.ways;
        let way = match &output {
            Output::State(_) => states,
            Output::Forecast(_) | Output::Report(_) | Output::ParametersChanged(_) => results,
            Output::Status(_) | Output::Refused(_) | Output::Notice(_) | Output::Save(_) => {
                messages
            }
            Output::Journal(_) => journal,
        };
        way.push(Numbered { number, output });
    }

    pub fn notify(&self) {
        self.notifier.notify();
    }

    pub fn stats(&self) -> [QueueStats; WAYS] {
        self.ways.each_ref().map(Queue::stats)
    }
}

/// Where outputs come from, in their order.
pub trait OutputSource: Send + 'static {
    /// The next output, waiting for it for at most `timeout`; `None` if none came in that time.
    fn receive(&mut self, timeout: Duration) -> Option<Output>;
}

impl OutputSource for Receiver {
    fn receive(&mut self, timeout: Duration) -> Option<Output> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some(output) = self.try_next() {
                return Some(output);
            }
            let rest = deadline.saturating_duration_since(Instant::now());
            if rest.is_zero() {
                return None;
            }
            self.wait(rest);
        }
    }
}

/// The reader's end: everything that one thread gave out in the order in which it did.
#[derive(Debug)]
pub struct Receiver {
    queues: Arc<OutputQueues>,
    /// At most one of each way, taken out to be compared.
    heads: [Option<Numbered>; WAYS],
}

impl Receiver {
    pub(super) fn new(queues: Arc<OutputQueues>) -> Self {
        Self {
            queues,
            heads: [const { None }; WAYS],
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.queues.name
    }

    /// The next output, if there is one.
    pub fn try_next(&mut self) -> Option<Output> {
        self.look_into_ways();
        if self.heads.iter().all(Option::is_none) {
            return None;
        }
        // A way that was empty when it was looked into may have got an entry before another way got the one that was
        // found there. What has a smaller number than one that was found was put in before it: a second look sees it.
        self.look_into_ways();
        let number_of = |head: &Option<Numbered>| head.as_ref().map_or(u64::MAX, |it| it.number);
        let first = self.heads.iter_mut().min_by_key(|head| number_of(head))?;
        first.take().map(|it| it.output)
    }

    fn look_into_ways(&mut self) {
        for (head, way) in self.heads.iter_mut().zip(&self.queues.ways) {
            if head.is_none() {
                *head = way.pop();
            }
        }
    }

    /// Waits until there may be an output, for `most` at the longest. To be called by one thread.
    pub fn wait(&self, most: Duration) {
        if self.heads.iter().all(Option::is_none) {
            self.queues.notifier.wait(most);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::{Journal, Notice, Position, Severity, StatusRecord};

    #[test]
    fn a_full_queue_follows_its_policy_and_counts() {
        for (when_full, kept) in [
            (WhenFull::Refuse, [0, 1]),
            (WhenFull::DropNewest, [0, 1]),
            (WhenFull::DropOldest, [3, 4]),
        ] {
            let queue = Queue::new("test".to_owned(), 2, when_full);
            let taken = (0..5).filter(|entry| queue.push(*entry)).count();
            assert_eq!(taken, 2);
            let stats = queue.stats();
            assert_eq!((stats.len, stats.pushed, stats.dropped), (2, 5, 3));
            assert_eq!(
                [queue.pop(), queue.pop(), queue.pop()],
                [Some(kept[0]), Some(kept[1]), None]
            );
        }
    }

    #[test]
    fn a_ring_before_the_wait_is_heard() {
        let notifier = Notifier::default();
        notifier.notify();
        notifier.wait(Duration::MAX);
    }

    /// A reader that looks while the outputs come: each goes another way than the one before, the earlier one first.
    #[test]
    fn outputs_of_different_ways_keep_their_order() {
        const OUTPUTS: i64 = 200_000;
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let mut receiver = Receiver::new(Arc::clone(&queues));
        let full =
            |queues: &OutputQueues| queues.stats().iter().any(|it| it.len + 1 >= it.capacity);
        let status = |stamp| StatusRecord {
            next_number: 0,
            stamp,
            position: Position {
                response: 0,
                step: None,
            },
        };
        let notice = |stamp| Notice {
            stamp,
            severity: Severity::Info,
            text: "".into(),
        };
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for stamp in 0..OUTPUTS {
                    while full(&queues) {
                        std::thread::yield_now();
                    }
                    queues.push(match stamp % 2 {
                        0 => Output::Notice(notice(stamp)),
                        _ => Output::Journal(Journal::Status(status(stamp))),
                    });
                }
            });
            for expected in 0..OUTPUTS {
                let output = loop {
                    if let Some(output) = receiver.try_next() {
                        break output;
                    }
                };
                let stamp = match output {
                    Output::Notice(notice) => notice.stamp,
                    Output::Journal(Journal::Status(status)) => status.stamp,
                    other => panic!("{other:?}"),
                };
                assert_eq!(stamp, expected);
            }
        });
    }

    #[test]
    fn nothing_waits_for_ever() {
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let mut receiver = Receiver::new(Arc::clone(&queues));
        receiver.wait(Duration::MAX);
        assert!(receiver.try_next().is_none());
        let text: Arc<str> = "text".into();
        queues.push(Output::Notice(Notice {
            stamp: 0,
            severity: Severity::Info,
            text,
        }));
        receiver.wait(Duration::MAX);
        assert!(receiver.try_next().is_some());
    }
}
