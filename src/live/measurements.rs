//! The queue of measurements: bounded, and drops its oldest batches when it is full, because the newest ones say what the
//! column does now.
//!
//! Every batch has a serial number, counted from the first one of its column since the start of the program: a reader sees by them
//! how many it lost. The columns of a fleet share a queue, and each has its own numbers.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;

use super::notifier::Notifier;
use super::queue::{QueueStats, WhenFull};
use crate::estimation::Batch;

/// Most batches in the queue: 5 s of 16 sensors that send a batch every 10 ms.
pub const MAX_QUEUED_BATCHES: usize = 8192;

/// Most samples in the queue: 16 MB, in few batches of many samples as in many of few.
pub const MAX_QUEUED_SAMPLES: usize = 1 << 22;

/// Most batches in a queue of a fleet, for each of its columns: 0.3 s of two sensors that send a batch every 10 ms. A queue of few
/// columns holds as many as that of a single twin.
const QUEUED_BATCHES_OF_A_COLUMN: usize = 64;

/// Most batches in a queue of a fleet: 4 MB.
pub const MAX_QUEUED_BATCHES_OF_A_FLEET: usize = 1 << 16;

/// A batch in the queue.
#[derive(Debug)]
pub(super) struct Queued {
    /// Index of the column; 0 for a single twin.
    pub column: u32,
    pub serial: u64,
    pub batch: Batch,
}

/// What was counted of one column.
#[derive(Debug, Default)]
struct Counts {
    next_serial: AtomicU64,
    lost: AtomicU64,
}

/// The batches between the thread that receives them, which alone may push, and the one that estimates, which alone may pop
/// and wait.
#[derive(Debug)]
pub struct MeasurementQueue {
    batches: ArrayQueue<Queued>,
    /// Samples in the queue.
    samples: AtomicUsize,
    columns: Box<[Counts]>,
    notifier: Notifier,
}

impl MeasurementQueue {
    /// An empty queue for so many columns, allocated at once.
    #[must_use]
    pub fn new(columns: usize) -> Self {
        let capacity = columns.saturating_mul(QUEUED_BATCHES_OF_A_COLUMN);
        let capacity = capacity.clamp(MAX_QUEUED_BATCHES, MAX_QUEUED_BATCHES_OF_A_FLEET);
        Self {
            batches: ArrayQueue::new(capacity),
            samples: AtomicUsize::new(0),
            columns: (0..columns).map(|_| Counts::default()).collect(),
            notifier: Notifier::default(),
        }
    }

    /// Adds a batch of a single twin, as [`push_of`](Self::push_of).
    pub fn push(&self, batch: Batch) {
        self.push_of(0, batch);
    }

    /// Adds a batch of a column, gives it the next serial number of the column, and wakes the reader. Drops the oldest batches for
    /// which there is no room, and counts them for their columns. A column that there is not has no batches.
    pub fn push_of(&self, column: u32, batch: Batch) {
        let Some(counts) = self.columns.get(column as usize) else {
            return;
        };
        let serial = counts.next_serial.fetch_add(1, Ordering::Relaxed);
        let added = batch.values.len();
        let mut samples = self.samples.fetch_add(added, Ordering::Relaxed) + added;
        while samples > MAX_QUEUED_SAMPLES
            && let Some(oldest) = self.take()
        {
            samples = samples.saturating_sub(oldest.batch.values.len());
            self.count_lost(&oldest);
        }
        let queued = Queued {
            column,
            serial,
            batch,
        };
        if let Some(oldest) = self.batches.force_push(queued) {
            let dropped = oldest.batch.values.len();
            self.samples.fetch_sub(dropped, Ordering::Relaxed);
            self.count_lost(&oldest);
        }
        self.notifier.notify();
    }

    /// The oldest batch with its serial number, from 0; does not wait.
    pub fn pop(&self) -> Option<(u64, Batch)> {
        self.take().map(|it| (it.serial, it.batch))
    }

    fn count_lost(&self, queued: &Queued) {
        if let Some(counts) = self.columns.get(queued.column as usize) {
            counts.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// The oldest batch; does not wait.
    pub(super) fn take(&self) -> Option<Queued> {
        let entry = self.batches.pop()?;
        let samples = entry.batch.values.len();
        self.samples.fetch_sub(samples, Ordering::Relaxed);
        Some(entry)
    }

    /// Waits at most `timeout` until there may be a batch, or the notifier is notified.
    pub fn wait(&self, timeout: Duration) {
        if self.batches.is_empty() {
            self.notifier.wait(timeout);
        }
    }

    /// Wakes the reader, for example to end it.
    pub fn notifier(&self) -> &Notifier {
        &self.notifier
    }

    /// Batches that were dropped since the start because the reader was too slow.
    pub fn lost(&self) -> u64 {
        let each = self.columns.iter();
        each.map(|it| it.lost.load(Ordering::Relaxed)).sum()
    }

    /// The same of one column; 0 of one that there is not.
    pub fn lost_of(&self, column: u32) -> u64 {
        let counts = self.columns.get(column as usize);
        counts.map_or(0, |it| it.lost.load(Ordering::Relaxed))
    }

    /// Number of the columns that share it.
    pub(super) fn columns(&self) -> usize {
        self.columns.len()
    }

    /// Its state, for diagnostics.
    pub fn stats(&self) -> QueueStats {
        QueueStats {
            name: "measurements".to_owned(),
            capacity: self.batches.capacity(),
            len: self.batches.len(),
            when_full: WhenFull::DropOldest,
            pushed: {
                let each = self.columns.iter();
                each.map(|it| it.next_serial.load(Ordering::Relaxed)).sum()
            },
            dropped: self.lost(),
        }
    }
}

impl Default for MeasurementQueue {
    /// That of one column.
    fn default() -> Self {
        Self::new(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(samples: usize) -> Batch {
        Batch {
            sensor: 0,
            first: 0,
            period: 100_000,
            values: vec![0.0; samples].into(),
        }
    }

    fn serials(queue: &MeasurementQueue) -> Vec<u64> {
        std::iter::from_fn(|| queue.pop())
            .map(|(serial, _)| serial)
            .collect()
    }

    #[test]
    fn the_oldest_of_too_many_batches_are_lost_and_missing_in_the_serial_numbers() {
        let queue = MeasurementQueue::default();
        let most = MAX_QUEUED_BATCHES as u64;
        for _ in 0..most + 3 {
            queue.push(batch(1));
        }
        assert_eq!(queue.lost(), 3);
        assert_eq!(queue.stats().dropped, 3);
        let expected: Vec<_> = (3..most + 3).collect();
        assert_eq!(serials(&queue), expected);
        // The serial numbers go on.
        queue.push(batch(1));
        assert_eq!(serials(&queue), [most + 3]);
    }

    #[test]
    fn many_samples_in_few_batches_are_bounded_too() {
        let queue = MeasurementQueue::default();
        for _ in 0..5 {
            queue.push(batch(MAX_QUEUED_SAMPLES / 4));
        }
        assert_eq!(queue.lost(), 1);
        assert_eq!(serials(&queue), [1, 2, 3, 4]);
        // What was taken out makes room.
        for _ in 0..4 {
            queue.push(batch(MAX_QUEUED_SAMPLES / 4));
        }
        assert_eq!((queue.lost(), serials(&queue).len()), (1, 4));
    }

    #[test]
    fn the_columns_of_a_fleet_have_their_own_numbers_and_losses() {
        let queue = MeasurementQueue::new(3);
        for column in [2, 0, 2, 7] {
            queue.push_of(column, batch(1));
        }
        let taken: Vec<_> = std::iter::from_fn(|| queue.take())
            .map(|it| (it.column, it.serial))
            .collect();
        assert_eq!(taken, [(2, 0), (0, 0), (2, 1)]);
        for column in 0..=u32::try_from(MAX_QUEUED_BATCHES).expect("few") {
            queue.push_of(u32::from(column > 0), batch(1));
        }
        assert_eq!([0, 1, 2, 7].map(|it| queue.lost_of(it)), [1, 0, 0, 0]);
        assert_eq!(queue.lost(), 1);
        let most = MeasurementQueue::new(2000).stats();
        assert_eq!(most.capacity, MAX_QUEUED_BATCHES_OF_A_FLEET);
    }

    #[test]
    fn a_batch_before_the_wait_ends_it() {
        let queue = MeasurementQueue::default();
        queue.push(batch(1));
        queue.wait(Duration::MAX);
        assert_eq!(serials(&queue), [0]);
        queue.notifier().notify();
        queue.wait(Duration::MAX);
    }
}
