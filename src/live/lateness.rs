//! How late a turn of the solver is.

use crate::twin::Nanos;

/// How late a turn began.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lateness {
    /// After its deadline \[ns\].
    pub nanos: u64,
    /// Whole periods that passed meanwhile: their turns are skipped, and this one makes their steps.
    pub skipped_periods: u64,
}

/// The lateness of a turn that was due at `deadline` and begins at `now`; the next is due a whole number of periods
/// after the deadline, never a period after `now`, so that lateness does not add up.
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
    fn no_clock_overflows_it() {
        assert_eq!(lateness(i64::MIN, 0, i64::MAX).nanos, u64::MAX);
        assert_eq!(lateness(i64::MAX, 1, i64::MIN), Lateness::default());
    }
}
