//! The newest measurements, for those who only look at them: they take nothing from the estimation, and lose what they look at
//! too late.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::estimation::Batch;
use crate::time::Nanos;

/// Time for which batches are kept \[ns\]: the final estimate of an impact comes some seconds after it.
const KEPT: Nanos = 5_000_000_000;

/// Most batches of a column that are kept: 5 s of 16 sensors that send a batch every 10 ms.
const MAX_BATCHES: usize = 8192;

/// Most samples of a column that are kept, 8 MB: 5 s of 40 sensors at 10 kHz.
const MAX_SAMPLES: usize = 1 << 21;

/// Most samples of all columns together that are kept, 64 MB: 5 s of 160 columns with two sensors at 10 kHz. The columns have equal
/// shares.
const MAX_SAMPLES_OF_ALL: usize = 1 << 24;

/// The newest batches of all sensors of a column.
#[derive(Debug)]
pub struct RecentBatches {
    kept: Mutex<Kept>,
    max_samples: usize,
}

impl Default for RecentBatches {
    /// Those of a single column.
    fn default() -> Self {
        Self::of_columns(1)
    }
}

#[derive(Debug, Default)]
struct Kept {
    batches: VecDeque<Batch>,
    samples: usize,
}

impl RecentBatches {
    /// Those of one of so many columns, empty.
    #[must_use]
    pub fn of_columns(columns: usize) -> Self {
        let share = MAX_SAMPLES_OF_ALL / columns.max(1);
        Self {
            kept: Mutex::default(),
            max_samples: share.min(MAX_SAMPLES),
        }
    }

    /// Remembers a batch, and forgets those that are too old or too many. The samples are shared, not copied.
    pub fn push(&self, batch: &Batch) {
        let mut kept = self.kept();
        kept.samples += batch.values.len();
        kept.batches.push_back(batch.clone());
        let oldest_time = batch.end().saturating_sub(KEPT);
        while let Some(oldest) = kept.batches.front()
            && (oldest.end() < oldest_time
                || kept.samples > self.max_samples
                || kept.batches.len() > MAX_BATCHES)
        {
            kept.samples -= oldest.values.len();
            kept.batches.pop_front();
        }
    }

    /// The batches with samples between two instants \[ns\], in the order in which they came.
    pub fn between(&self, from: Nanos, until: Nanos) -> Vec<Batch> {
        let kept = self.kept();
        let found = kept.batches.iter();
        found
            .filter(|it| it.end() > from && it.first < until)
            .cloned()
            .collect()
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A batch of this many samples that lasts 10 ms.
    fn batch(first: Nanos, samples: usize) -> Batch {
        Batch {
            sensor: 0,
            first,
            period: 10_000_000 / samples as u64,
            values: vec![0.0; samples].into(),
        }
    }

    #[test]
    fn the_windows_of_many_columns_are_bounded_together() {
        let windows: Vec<_> = (0..100).map(|_| RecentBatches::of_columns(100)).collect();
        let kept = |it: &RecentBatches| it.kept().samples;
        for window in &windows {
            (0..300).for_each(|number| window.push(&batch(10_000_000 * number, 1_000)));
        }
        let all: usize = windows.iter().map(kept).sum();
        assert!((MAX_SAMPLES_OF_ALL - 100_000..=MAX_SAMPLES_OF_ALL).contains(&all));
        // One alone keeps all of it, which is less than it may.
        let alone = RecentBatches::default();
        (0..300).for_each(|number| alone.push(&batch(10_000_000 * number, 1_000)));
        assert_eq!(kept(&alone), 300_000);
    }

    #[test]
    fn what_is_asked_for_is_there_and_what_is_old_or_too_much_is_not() {
        let recent = RecentBatches::default();
        let firsts = |from: Nanos, until: Nanos| -> Vec<Nanos> {
            let found = recent.between(from, until);
            found.iter().map(|it| it.first / 10_000_000).collect()
        };
        for number in 0..10 {
            recent.push(&batch(10_000_000 * number, 100));
        }
        assert_eq!(firsts(25_000_000, 50_000_000), [2, 3, 4]);
        assert_eq!(firsts(100_000_000, Nanos::MAX), [0; 0]);
        recent.push(&batch(KEPT + 50_000_000, 100));
        assert_eq!(firsts(0, 200_000_000), [5, 6, 7, 8, 9]);
        // Many samples push out what is not old.
        recent.push(&batch(KEPT + 60_000_000, MAX_SAMPLES - 100));
        assert_eq!(firsts(0, Nanos::MAX), [505, 506]);
        recent.push(&batch(KEPT + 70_000_000, 1));
        assert_eq!(firsts(0, Nanos::MAX), [506, 507]);
    }
}
