//! Bounded queues between the threads, each with a name, a policy for overflow, and counters.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crossbeam_queue::ArrayQueue;

use super::notifier::Notifier;
use crate::twin::Output;

/// The overflow policy of a queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhenFull {
    /// The new entry is rejected, and its sender notified.
    Reject,
    /// The oldest entry is dropped.
    DropOldest,
    /// The new entry is dropped.
    DropNewest,
}

impl WhenFull {
    /// The policy in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Reject => "new entries are rejected",
            Self::DropOldest => "the oldest entry is dropped",
            Self::DropNewest => "the newest entry is dropped",
        }
    }
}

/// The current state of a queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueStats {
    /// Name of the queue.
    pub name: String,
    /// Maximum number of entries.
    pub capacity: usize,
    /// Current number of entries.
    pub len: usize,
    /// Overflow policy.
    pub when_full: WhenFull,
    /// Entries offered since the start.
    pub pushed: u64,
    /// Entries rejected or dropped since the start.
    pub dropped: u64,
}

/// A bounded lock-free queue, allocated at the start.
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

    /// Adds an entry; `false` if this or another entry was rejected or dropped.
    pub fn push(&self, entry: T) -> bool {
        self.pushed.fetch_add(1, Ordering::Relaxed);
        let kept = match self.when_full {
            WhenFull::Reject | WhenFull::DropNewest => self.entries.push(entry).is_ok(),
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

/// The queue to a reader of the outputs of the twin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputQueue {
    /// Name of the reader.
    pub name: String,
    /// Maximum number of queued states.
    pub states: usize,
    /// Maximum number of queued forecasts, their withdrawals, reports and parameter changes together; of rejections, status and notices
    /// together; and of entries of the journal.
    pub others: usize,
    /// Overflow policy of all of them.
    pub when_full: WhenFull,
}

impl OutputQueue {
    /// Name of the reader that publishes the outputs.
    pub const ROS: &str = "ros";

    /// The queue to the reader that publishes the outputs; drops the oldest entries.
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

/// Number of channels to one reader.
const CHANNELS: usize = 4;

/// The channels to one reader, separate so that a flood of states or rejections cannot displace a report.
#[derive(Debug)]
pub(super) struct OutputQueues {
    pub name: String,
    channels: [Queue<Numbered>; CHANNELS],
    next_number: AtomicU64,
    notifier: Notifier,
    /// The reader is to return from its wait without an output.
    woken: AtomicBool,
}

#[derive(Debug)]
struct Numbered {
    number: u64,
    /// The column of the fleet that it is about; 0 for a single twin.
    column: u32,
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
        let channel =
            |what, capacity| Queue::new(format!("{what} to {name}"), capacity, *when_full);
        Self {
            name: name.clone(),
            channels: [
                channel("states", *states),
                channel("results", *others),
                channel("messages", *others),
                channel("journal", *others),
            ],
            next_number: AtomicU64::new(0),
            notifier: Notifier::default(),
            woken: AtomicBool::new(false),
        }
    }

    /// Adds an output of a column. The outputs of one column keep their order, whichever threads they come from, as
    /// long as its threads work one after another.
    pub fn push_of(&self, column: u32, output: Output) {
        let number = self.next_number.fetch_add(1, Ordering::Relaxed);
        let [states, results, messages, journal] = &self.channels;
        let channel = match &output {
            Output::State(_) => states,
            Output::Forecast(_)
            | Output::Report(_)
            | Output::Supplemented(_)
            | Output::Withdrawn(_)
            | Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::ParametersChanged(_) => results,
            Output::Status(_) | Output::Rejected(_) | Output::Notice(_) | Output::Save(_) => {
                messages
            }
            Output::Journal(_) => journal,
        };
        channel.push(Numbered {
            number,
            column,
            output,
        });
    }

    pub fn notify(&self) {
        self.notifier.notify();
    }

    fn wake(&self) {
        self.woken.store(true, Ordering::SeqCst);
        self.notify();
    }

    pub fn stats(&self) -> [QueueStats; CHANNELS] {
        self.channels.each_ref().map(Queue::stats)
    }
}

/// A source of outputs, in their order.
pub trait OutputSource: Send + 'static {
    /// Waits at most `timeout` for the next output, or until it is [woken](Waker::wake).
    fn receive(&mut self, timeout: Duration) -> Option<Output>;

    /// The same with the index of the column that it is about; 0 for a single twin.
    fn receive_of(&mut self, timeout: Duration) -> Option<(u32, Output)> {
        self.receive(timeout).map(|output| (0, output))
    }

    /// Ends a wait before its time.
    fn waker(&self) -> Waker {
        Waker::default()
    }
}

/// Ends a wait of [`OutputSource::receive`] in another thread. The default is that of a source which cannot be woken.
#[derive(Debug, Clone, Default)]
pub struct Waker(Option<Arc<OutputQueues>>);

impl Waker {
    /// Ends the present wait, or the next one.
    pub fn wake(&self) {
        if let Some(queues) = &self.0 {
            queues.wake();
        }
    }
}

impl OutputSource for Receiver {
    fn receive(&mut self, timeout: Duration) -> Option<Output> {
        self.receive_of(timeout).map(|(_, output)| output)
    }

    fn receive_of(&mut self, timeout: Duration) -> Option<(u32, Output)> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some(output) = self.try_next_of() {
                return Some(output);
            }
            let rest = deadline.saturating_duration_since(Instant::now());
            if rest.is_zero() || self.queues.woken.swap(false, Ordering::SeqCst) {
                return None;
            }
            self.wait(rest);
        }
    }

    fn waker(&self) -> Waker {
        Waker(Some(Arc::clone(&self.queues)))
    }
}

/// The receiving end of a queue. Outputs of one thread are received in the order in which they were sent.
#[derive(Debug)]
pub struct Receiver {
    queues: Arc<OutputQueues>,
    /// At most one output of each channel, taken out for comparison.
    heads: [Option<Numbered>; CHANNELS],
}

impl Receiver {
    pub(super) fn new(queues: Arc<OutputQueues>) -> Self {
        Self {
            queues,
            heads: [const { None }; CHANNELS],
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.queues.name
    }

    /// The next output, if there is one; does not wait.
    pub fn try_next(&mut self) -> Option<Output> {
        self.try_next_of().map(|(_, output)| output)
    }

    /// The next output of a fleet with the index of its column, if there is one; does not wait.
    pub fn try_next_of(&mut self) -> Option<(u32, Output)> {
        self.fill_heads();
        if self.heads.iter().all(Option::is_none) {
            return None;
        }
        // While the channels were read one after another, an earlier output may have reached a channel that had been found
        // empty. Every output with a smaller number than one of the heads was sent before it, so a second pass finds it.
        self.fill_heads();
        let number_of = |head: &Option<Numbered>| head.as_ref().map_or(u64::MAX, |it| it.number);
        let first = self.heads.iter_mut().min_by_key(|head| number_of(head))?;
        first.take().map(|it| (it.column, it.output))
    }

    fn fill_heads(&mut self) {
        for (head, channel) in self.heads.iter_mut().zip(&self.queues.channels) {
            if head.is_none() {
                *head = channel.pop();
            }
        }
    }

    /// Waits at most `timeout` until there may be an output. Must be called by one thread only.
    pub fn wait(&self, timeout: Duration) {
        if self.heads.iter().all(Option::is_none) {
            self.queues.notifier.wait(timeout);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::{Journal, Notice, NoticeLevel, Position, StatusRecord};

    #[test]
    fn a_full_queue_follows_its_policy_and_counts() {
        for (when_full, kept) in [
            (WhenFull::Reject, [0, 1]),
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
    fn a_notification_before_the_wait_ends_it() {
        let notifier = Notifier::default();
        notifier.notify();
        notifier.wait(Duration::MAX);
    }

    /// The reader polls while outputs alternate between two channels.
    #[test]
    fn outputs_of_different_channels_keep_their_order() {
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
            level: NoticeLevel::Info,
            text: "".into(),
        };
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for stamp in 0..OUTPUTS {
                    while full(&queues) {
                        std::thread::yield_now();
                    }
                    queues.push_of(
                        0,
                        match stamp % 2 {
                            0 => Output::Notice(notice(stamp)),
                            _ => Output::Journal(Journal::Status(status(stamp))),
                        },
                    );
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

    /// However the two threads meet, also in the very first wait.
    #[test]
    fn no_notification_is_lost() {
        for _ in 0..2_000 {
            let notifier = Notifier::default();
            std::thread::scope(|scope| {
                scope.spawn(|| notifier.wait(Duration::MAX));
                notifier.notify();
            });
        }
    }

    #[test]
    fn a_source_that_is_woken_returns_nothing_once() {
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let mut receiver = Receiver::new(Arc::clone(&queues));
        receiver.waker().wake();
        assert!(receiver.receive(Duration::from_secs(3600)).is_none());
        let text: Arc<str> = "text".into();
        queues.push_of(
            0,
            Output::Notice(Notice {
                stamp: 0,
                level: NoticeLevel::Info,
                text,
            }),
        );
        assert!(receiver.receive(Duration::from_secs(3600)).is_some());
    }
}
