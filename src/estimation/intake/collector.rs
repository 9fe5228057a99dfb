//! Collects the samples of a sensor that sends each in a message of its own.

use crate::time::Nanos;

/// Duration of the batches that are collected \[s\]: every impact needs longer to be confirmed, and a message for each sample of a fast
/// sensor would cost more than its content.
pub const BATCH_DURATION: f64 = 5e-3;

/// Largest deviation of a sample from the time that it is expected at, as a share of the period; where one is missing, it is a
/// whole period.
const TOLERANCE: f64 = 0.75;

/// Samples in equal steps of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Collected {
    /// Time of the first sample \[ns\].
    pub stamp: Nanos,
    /// The samples.
    pub values: Vec<f32>,
}

/// Collects single samples of one sensor.
#[derive(Debug, Clone)]
pub struct Collector {
    /// Period of the samples \[ns\].
    period: f64,
    batch: usize,
    stamp: Nanos,
    values: Vec<f32>,
}

impl Collector {
    /// For a sensor with this rate \[Hz\], above 0.
    #[must_use]
    pub fn new(rate: f64) -> Self {
        let batch = (BATCH_DURATION * rate).round().max(1.0) as usize;
        Self {
            period: 1e9 / rate,
            batch,
            stamp: 0,
            values: Vec::with_capacity(batch),
        }
    }

    /// Takes a sample: a batch, if one is complete. A sample that does not follow the one before by about one period begins a new
    /// batch, and the one before is complete.
    pub fn push(&mut self, stamp: Nanos, value: f32) -> Option<Collected> {
        let since = stamp.saturating_sub(self.stamp) as f64;
        let expected = self.period * self.values.len() as f64;
        let follows = (since - expected).abs() <= TOLERANCE * self.period;
        let cut_off = (!self.values.is_empty() && !follows).then(|| self.take());
        if self.values.is_empty() {
            self.stamp = stamp;
        }
        self.values.push(value);
        // What was cut off shows that a batch has room for more than this one sample.
        cut_off.or_else(|| (self.values.len() >= self.batch).then(|| self.take()))
    }

    fn take(&mut self) -> Collected {
        let next = Vec::with_capacity(self.batch);
        Collected {
            stamp: self.stamp,
            values: std::mem::replace(&mut self.values, next),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPOCH: Nanos = 1_700_000_000_000_000_000;

    #[test]
    fn single_samples_become_batches_of_five_milliseconds() {
        for (rate, batch) in [(100.0, 1), (200.0, 1), (1_000.0, 5), (1_600.0, 8)] {
            let mut collector = Collector::new(rate);
            let period = 1e9 / rate;
            let mut values = Vec::new();
            for k in 0..1_000 {
                // Stamps of a driver, off by up to a third of a period.
                let jitter = 0.3 * period * f64::from(k % 3 - 1);
                let stamp = EPOCH + (period * f64::from(k) + jitter) as Nanos;
                if let Some(collected) = collector.push(stamp, k as f32) {
                    assert_eq!(collected.values.len(), batch, "{rate}");
                    values.extend(collected.values);
                }
            }
            let expected: Vec<_> = (0..values.len()).map(|k| k as f32).collect();
            assert_eq!(values, expected);
            assert!(values.len() > 1_000 - batch);
        }
    }

    #[test]
    fn a_missing_sample_ends_a_batch() {
        let mut collector = Collector::new(1_000.0);
        let at = |k: i64| EPOCH + k * 1_000_000;
        let times = [0, 1, 2, 4, 5, 6, 7, 8, 9];
        let collected: Vec<_> = times
            .into_iter()
            .filter_map(|k| collector.push(at(k), k as f32))
            .collect();
        let expected = [
            Collected {
                stamp: at(0),
                values: vec![0.0, 1.0, 2.0],
            },
            Collected {
                stamp: at(4),
                values: vec![4.0, 5.0, 6.0, 7.0, 8.0],
            },
        ];
        assert_eq!(collected, expected);
    }
}
