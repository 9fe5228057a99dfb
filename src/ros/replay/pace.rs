//! The due times of recorded messages.

/// Admissible rates of a replay, in recorded seconds per second.
pub const RATES: std::ops::RangeInclusive<f64> = 0.001..=1000.0;

/// Maps recorded time to monotonic time, both in nanoseconds. Due times are absolute, so that delays do not accumulate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pace {
    rate: f64,
    /// A recorded time and the monotonic time at which it is due.
    anchor: (i64, i64),
    paused: bool,
}

impl Pace {
    /// Starts the replay: the recorded time `first` is due at `now`.
    pub fn new(rate: f64, first: i64, now: i64) -> Self {
        Self {
            rate: rate.clamp(*RATES.start(), *RATES.end()),
            anchor: (first, now),
            paused: false,
        }
    }

    /// When a recorded time is due; `None` while paused.
    pub fn due(&self, recorded: i64) -> Option<i64> {
        let (first, at) = self.anchor;
        let since = recorded.saturating_sub(first) as f64 / self.rate;
        // A float represents 100 days in nanoseconds exactly; `as` saturates.
        (!self.paused).then(|| at.saturating_add(since.round() as i64))
    }

    /// The recorded time that is replayed at `now`.
    pub fn position(&self, now: i64) -> i64 {
        let (first, at) = self.anchor;
        if self.paused {
            return first;
        }
        let since = now.saturating_sub(at) as f64 * self.rate;
        first.saturating_add(since.round() as i64)
    }

    pub fn rate(&self) -> f64 {
        self.rate
    }

    pub fn is_paused(&self) -> bool {
        self.paused
    }

    pub fn pause(&mut self, now: i64) {
        self.anchor = (self.position(now), now);
        self.paused = true;
    }

    pub fn resume(&mut self, now: i64) {
        self.anchor.1 = now;
        self.paused = false;
    }

    /// Advances to a later recorded time while paused.
    pub fn skip_to(&mut self, recorded: i64) {
        self.anchor.0 = self.anchor.0.max(recorded);
    }

    /// Goes to a recorded time, paused or not.
    #[cfg_attr(not(feature = "foxglove"), allow(dead_code))] // only its clients seek
    pub fn seek(&mut self, recorded: i64, now: i64) {
        self.anchor = (recorded, now);
    }

    pub fn set_rate(&mut self, rate: f64, now: i64) {
        self.anchor = (self.position(now), now);
        self.rate = rate.clamp(*RATES.start(), *RATES.end());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn the_rate_scales_the_time() {
        for (rate, due) in [(0.1, 20 * S), (1.0, 2 * S), (10.0, S / 5)] {
            let pace = Pace::new(rate, 100 * S, 7);
            assert_eq!(pace.due(102 * S), Some(7 + due));
            assert_eq!(pace.position(7 + due), 102 * S);
        }
    }

    #[test]
    fn a_pause_delays_everything_after_it() {
        let mut pace = Pace::new(2.0, 0, 0);
        pace.pause(S);
        assert_eq!((pace.due(3 * S), pace.position(50 * S)), (None, 2 * S));
        pace.resume(10 * S);
        assert_eq!(pace.due(3 * S), Some(10 * S + S / 2));
        pace.set_rate(1.0, 11 * S);
        assert_eq!(
            (pace.position(11 * S), pace.due(5 * S)),
            (4 * S, Some(12 * S))
        );
    }

    #[test]
    fn a_sought_time_is_due_at_once() {
        let mut pace = Pace::new(2.0, 0, 0);
        pace.seek(10 * S, S);
        assert_eq!((pace.due(10 * S), pace.position(S)), (Some(S), 10 * S));
        pace.pause(2 * S);
        pace.seek(4 * S, 3 * S);
        assert_eq!((pace.due(4 * S), pace.position(9 * S)), (None, 4 * S));
    }

    #[test]
    fn extreme_times_do_not_overflow() {
        let pace = Pace::new(0.0, i64::MIN, i64::MAX);
        assert_eq!(pace.due(i64::MAX), Some(i64::MAX));
        assert_eq!(pace.position(i64::MIN), i64::MIN);
    }
}
