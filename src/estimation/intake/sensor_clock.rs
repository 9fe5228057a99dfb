//! The clock of a sensor against the clock that drives the twin.
//!
//! A batch cannot arrive before its last sample was taken. How long after it the fastest of many batches arrives is
//! therefore what the two clocks differ by, and the shortest time of transport, which is a millisecond or two.

use serde::{Deserialize, Serialize};

use crate::time::Nanos;

/// Differences between the clocks up to this are left as they are \[ns\]: synchronised clocks differ by less, and most of such a
/// difference is transport, which no correction can tell from it.
pub const TOLERATED_OFFSET: Nanos = 50_000_000;

/// The fastest batch is sought in at least this time and at most twice as long \[ns\].
const PERIOD: u64 = 5_000_000_000;

/// After its beginning, the correction follows every faster batch at once for this time \[ns\].
const SETTLING: u64 = 1_000_000_000;

/// Afterwards it changes by at most this share of the time that passes, so that it neither compresses nor stretches an impact.
const MAX_SLEW: f64 = 500e-6;

/// A change beyond this is made at once \[ns\]: the clock was set.
const STEP: u64 = 100_000_000;

/// Follows the clock of one sensor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SensorClock {
    /// End of the first batch and of the last one, by the sensor's clock.
    span: Option<(Nanos, Nanos)>,
    /// When the current period began.
    period_start: Nanos,
    /// Shortest delays of the current period and of the one before.
    shortest: [Option<Nanos>; 2],
    is_corrected: bool,
    correction: Nanos,
}

impl SensorClock {
    /// Takes a batch whose last sample ended at `end` by the sensor's clock, and which arrived at `received` by the twin's: what
    /// to add to its times \[ns\].
    pub fn correct(&mut self, end: Nanos, received: Nanos) -> Nanos {
        let delay = received.saturating_sub(end);
        let (first, last) = *self.span.get_or_insert((end, end));
        self.span = Some((first, end));
        if self.shortest[0].is_none() {
            self.period_start = end;
        }
        // Periods pass by the sensor's clock: a pause of the program may not make a late batch the fastest one.
        if between(self.period_start, end) > PERIOD {
            self.period_start = end;
            self.shortest = [None, self.shortest[0]];
        }
        let shortest = &mut self.shortest[0];
        *shortest = Some(shortest.map_or(delay, |it| it.min(delay)));
        let wanted = self.wanted();
        let change = wanted.saturating_sub(self.correction);
        let is_settling = between(first, end) < SETTLING;
        self.correction = if is_settling || change.unsigned_abs() > STEP {
            wanted
        } else {
            let most = (MAX_SLEW * between(last, end) as f64) as Nanos;
            self.correction.saturating_add(change.clamp(-most, most))
        };
        self.correction
    }

    /// What the correction has to become.
    fn wanted(&mut self) -> Nanos {
        let offset = self.offset();
        let limit = match self.is_corrected {
            // A little less, so that the correction does not come and go.
            true => TOLERATED_OFFSET / 2,
            false => TOLERATED_OFFSET,
        };
        self.is_corrected = offset.unsigned_abs() > limit.unsigned_abs();
        if self.is_corrected { offset } else { 0 }
    }

    /// How much the sensor's clock is behind the twin's, with the shortest time of transport \[ns\]; 0 before the first batch.
    pub fn offset(&self) -> Nanos {
        self.shortest.into_iter().flatten().min().unwrap_or(0)
    }

    /// What is added to the times of the sensor \[ns\].
    pub fn correction(&self) -> Nanos {
        self.correction
    }
}

fn between(earlier: Nanos, later: Nanos) -> u64 {
    u64::try_from(later.saturating_sub(earlier)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND: Nanos = 1_000_000;

    /// Passes `count` batches of 10 ms whose clock is behind by `offset` at its beginning and drifts, with these delays in
    /// transport; the largest error of the corrected times.
    fn largest_error(
        clock: &mut SensorClock,
        count: i64,
        offset: Nanos,
        drift: f64,
        transport: impl Fn(i64) -> Nanos,
        judged_from: i64,
    ) -> Nanos {
        let mut largest = 0;
        for k in 0..count {
            let truth = (k + 1) * 10 * MILLISECOND;
            let stamp = truth - offset - (drift * truth as f64) as Nanos;
            let corrected = stamp + clock.correct(stamp, truth + transport(k));
            if k >= judged_from {
                largest = largest.max((corrected - truth).abs());
            }
        }
        largest
    }

    /// Between 1 and 9 ms, in an order that looks random.
    fn jittering(k: i64) -> Nanos {
        MILLISECOND * (1 + (k * 7919 + 13) % 9)
    }

    #[test]
    fn a_clock_within_the_tolerance_is_left_alone() {
        for offset in [-40 * MILLISECOND, 0, 40 * MILLISECOND] {
            let mut clock = SensorClock::default();
            for k in 0..10_000 {
                let truth = k * 10 * MILLISECOND;
                assert_eq!(clock.correct(truth - offset, truth + jittering(k)), 0);
            }
            assert_eq!(clock.offset(), offset + MILLISECOND);
        }
    }

    #[test]
    fn a_constant_offset_is_corrected_but_for_the_transport() {
        let hour = 3_600_000 * MILLISECOND;
        for offset in [
            -hour,
            -200 * MILLISECOND,
            200 * MILLISECOND,
            1_000_000 * hour,
        ] {
            let mut clock = SensorClock::default();
            let error = largest_error(&mut clock, 3_000, offset, 0.0, jittering, 20);
            assert_eq!(error, MILLISECOND, "{offset}");
        }
    }

    #[test]
    fn a_drift_is_followed_without_a_step() {
        for drift in [-100e-6, 100e-6] {
            let mut clock = SensorClock::default();
            let offset = 3_000 * MILLISECOND;
            let count = 360_000;
            // Where the clock loses time, the fastest batch of the last ten seconds is one millisecond old.
            let error = largest_error(&mut clock, count, offset, drift, jittering, 20);
            assert!(error <= 3 * MILLISECOND, "{drift}: {error}");
            let mut before = clock.correction();
            for k in count..count + 1_000 {
                let truth = (k + 1) * 10 * MILLISECOND;
                let stamp = truth - offset - (drift * truth as f64) as Nanos;
                let correction = clock.correct(stamp, truth + jittering(k));
                assert!((correction - before).abs() <= 6_000);
                before = correction;
            }
        }
    }

    #[test]
    fn a_pause_of_the_program_is_no_offset() {
        let mut clock = SensorClock::default();
        let punctual = largest_error(&mut clock, 3_000, 0, 0.0, jittering, 0);
        assert_eq!(punctual, 0);
        // It stops for 20 s, finds what came in the last 0.5 s of them, and goes on.
        let resumed = 50_000 * MILLISECOND;
        for k in 0..500 {
            let end = resumed - 500 * MILLISECOND + 10 * k * MILLISECOND;
            let received = end.max(resumed) + MILLISECOND;
            assert_eq!(clock.correct(end, received), 0);
        }
    }
}
