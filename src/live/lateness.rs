//! The lateness of a cycle of the solver.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::time::Nanos;

/// The lateness of a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lateness {
    /// Delay after the deadline \[ns\].
    pub nanos: u64,
    /// Whole periods within the delay: their cycles are skipped, and this cycle makes up for their steps.
    pub skipped_periods: u64,
}

impl Lateness {
    /// Counts it among the largest lateness, the late cycles and the skipped periods.
    pub(super) fn count(
        self,
        worst: &AtomicU64,
        overruns: &AtomicU64,
        skipped_periods: &AtomicU64,
    ) {
        worst.fetch_max(self.nanos, Ordering::Relaxed);
        if self.skipped_periods > 0 {
            overruns.fetch_add(1, Ordering::Relaxed);
            skipped_periods.fetch_add(self.skipped_periods, Ordering::Relaxed);
        }
    }
}

/// The lateness of a cycle that was due at `deadline` and starts at `now`. Deadlines stay a whole number of periods apart,
/// whatever `now` is, so that delays do not accumulate.
#[must_use]
pub fn lateness(deadline: Nanos, period: u64, now: Nanos) -> Lateness {
    if now <= deadline {
        return Lateness::default();
    }
    let nanos = now.abs_diff(deadline);
    Lateness {
        nanos,
        skipped_periods: nanos / period.max(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_periods_are_skipped_and_counted() {
        let of = |now| {
            let Lateness {
                nanos,
                skipped_periods,
            } = lateness(1_000, 100, now);
            (nanos, skipped_periods)
        };
        assert_eq!(of(900), (0, 0));
        assert_eq!(of(1_000), (0, 0));
        assert_eq!(of(1_001), (1, 0));
        assert_eq!(of(1_099), (99, 0));
        assert_eq!(of(1_100), (100, 1));
        assert_eq!(of(1_350), (350, 3));
    }

    #[test]
    fn extreme_times_do_not_overflow() {
        assert_eq!(lateness(i64::MIN, 0, i64::MAX).nanos, u64::MAX);
        assert_eq!(lateness(i64::MAX, 1, i64::MIN), Lateness::default());
    }
}
