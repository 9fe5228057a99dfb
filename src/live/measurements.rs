//! The queue of measurements: bounded, and drops its oldest batches when it is full, because the newest ones say what the
//! column does now.
//!
//! Every batch has a serial number, counted from the first one of the program: a reader sees by them how many it lost.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use crossbeam_queue::ArrayQueue;

use super::notifier::Notifier;
use super::queue::{QueueStats, WhenFull};
use super::recent_batches::RecentBatches;
use crate::senses::Batch;

/// Most batches in the queue: 5 s of 16 sensors that send a batch every 10 ms.
pub const MAX_QUEUED_BATCHES: usize = 8192;

/// Most samples in the queue: 16 MB, in few batches of many samples as in many of few.
pub const MAX_QUEUED_SAMPLES: usize = 1 << 22;

/// The batches between the thread that receives them, which alone may push, and the one that estimates, which alone may pop
/// and wait.
#[derive(Debug)]
pub struct MeasurementQueue {
    batches: ArrayQueue<(u64, Batch)>,
    /// Samples in the queue.
    samples: AtomicUsize,
    next_serial: AtomicU64,
    lost: AtomicU64,
    notifier: Notifier,
    recent: Option<Arc<RecentBatches>>,
}

impl MeasurementQueue {
    /// An empty queue, allocated at once.
    #[must_use]
    pub fn new() -> Self {
        Self {
            batches: ArrayQueue::new(MAX_QUEUED_BATCHES),
            samples: AtomicUsize::new(0),
            next_serial: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            notifier: Notifier::default(),
            recent: None,
        }
    }

    /// An empty queue that also remembers the newest batches for those who look at them.
    #[must_use]
    pub fn remembering() -> Self {
        Self {
            recent: Some(Arc::default()),
            ..Self::new()
        }
    }

    /// The newest batches, if they are remembered.
    pub fn recent(&self) -> Option<Arc<RecentBatches>> {
        self.recent.clone()
    }

    /// Adds a batch, gives it the next serial number, and wakes the reader. Drops the oldest batches for which there is no
    /// room, and counts them.
    pub fn push(&self, batch: Batch) {
        if let Some(recent) = &self.recent {
            recent.push(&batch);
        }
        let serial = self.next_serial.fetch_add(1, Ordering::Relaxed);
        let added = batch.values.len();
        let mut samples = self.samples.fetch_add(added, Ordering::Relaxed) + added;
        while samples > MAX_QUEUED_SAMPLES
            && let Some((_, oldest)) = self.take()
        {
            samples = samples.saturating_sub(oldest.values.len());
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        if let Some((_, oldest)) = self.batches.force_push((serial, batch)) {
            let dropped = oldest.values.len();
            self.samples.fetch_sub(dropped, Ordering::Relaxed);
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        self.notifier.notify();
    }

    /// The oldest batch with its serial number, from 0; does not wait.
    pub fn pop(&self) -> Option<(u64, Batch)> {
        self.take()
    }

    fn take(&self) -> Option<(u64, Batch)> {
        let entry = self.batches.pop()?;
        let samples = entry.1.values.len();
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
        self.lost.load(Ordering::Relaxed)
    }

    /// Its state, for diagnostics.
    pub fn stats(&self) -> QueueStats {
        QueueStats {
            name: "measurements".to_owned(),
            capacity: self.batches.capacity(),
            len: self.batches.len(),
            when_full: WhenFull::DropOldest,
            pushed: self.next_serial.load(Ordering::Relaxed),
            dropped: self.lost(),
        }
    }
}

impl Default for MeasurementQueue {
    fn default() -> Self {
        Self::new()
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
        let queue = MeasurementQueue::new();
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
        let queue = MeasurementQueue::new();
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
    fn a_batch_before_the_wait_ends_it() {
        let queue = MeasurementQueue::new();
        queue.push(batch(1));
        queue.wait(Duration::MAX);
        assert_eq!(serials(&queue), [0]);
        queue.notifier().notify();
        queue.wait(Duration::MAX);
    }
}
