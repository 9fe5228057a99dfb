//! Clocks that a twin can live by.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

use super::notifier::Notifier;
use crate::twin::Nanos;

const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// A wait that is longer than this is one at the notifier, so that an input ends it \[ns\].
const MAX_SLEEP: Nanos = 2_000_000;

/// Tells the time and waits for it.
pub trait Clock: Send + Sync {
    /// Nanoseconds since the epoch.
    fn now(&self) -> Nanos;

    /// Waits until `deadline`, or shorter: until the notifier rings where the wait is a long one.
    fn wait_until(&self, deadline: Nanos, notifier: &Notifier);

    /// Told the notifier of the thread that lives by this clock, before it waits for the first time.
    fn serve(&self, _bell: &Arc<Notifier>) {}

    /// Called while nothing depends on it that time goes on evenly: a clock that has been set may jump now.
    fn resynchronise(&self) {}
}

/// The time of day, which goes on evenly while a response runs: it is set only in between.
#[derive(Debug)]
pub struct SystemClock {
    /// From monotonic time to time since the epoch \[ns\].
    offset: AtomicI64,
}

impl SystemClock {
    /// The time of day.
    #[must_use]
    pub fn new() -> Self {
        Self {
            offset: AtomicI64::new(offset()),
        }
    }
}

impl Default for SystemClock {
    fn default() -> Self {
        Self::new()
    }
}

impl Clock for SystemClock {
    fn now(&self) -> Nanos {
        read(ClockId::Monotonic).saturating_add(self.offset.load(Ordering::Relaxed))
    }

    fn wait_until(&self, deadline: Nanos, notifier: &Notifier) {
        let left = deadline.saturating_sub(self.now());
        if left > MAX_SLEEP {
            notifier.wait(Duration::from_nanos(left.unsigned_abs()));
        } else if left > 0 {
            let monotonic = deadline.saturating_sub(self.offset.load(Ordering::Relaxed));
            let request = Timespec {
                tv_sec: monotonic.div_euclid(NANOS_PER_SECOND),
                tv_nsec: monotonic.rem_euclid(NANOS_PER_SECOND) as _,
            };
            // A signal ends it early: the caller looks at the clock anyway.
            let _ = clock_nanosleep_absolute(ClockId::Monotonic, &request);
        }
    }

    fn resynchronise(&self) {
        // Reading two clocks in turn is not exact: only a clock that was set, or has crept away, is followed.
        const SET: u64 = 100_000;
        let new = offset();
        if new.abs_diff(self.offset.load(Ordering::Relaxed)) > SET {
            self.offset.store(new, Ordering::Relaxed);
        }
    }
}

/// From monotonic time to time since the epoch. The thread may lose its processor between two readings: the reading with
/// the least time around it counts.
fn offset() -> i64 {
    const READINGS: usize = 5;
    let reading = || {
        let before = read(ClockId::Monotonic);
        let since_epoch = read(ClockId::Realtime);
        let around = read(ClockId::Monotonic).saturating_sub(before);
        let between = before.saturating_add(around / 2);
        (around, since_epoch.saturating_sub(between))
    };
    let readings = (0..READINGS).map(|_| reading());
    readings.min().map_or(0, |(_, offset)| offset)
}

/// Monotonic nanoseconds, for stopwatches.
#[must_use]
pub fn monotonic_nanos() -> u64 {
    read(ClockId::Monotonic).unsigned_abs()
}

fn read(clock: ClockId) -> i64 {
    let time = clock_gettime(clock);
    time.tv_sec
        .saturating_mul(NANOS_PER_SECOND)
        .saturating_add(time.tv_nsec)
}

/// A clock that somebody sets: simulated time from `/clock`, or a test.
#[derive(Debug, Default)]
pub struct SimClock {
    now: AtomicI64,
    notifier: OnceLock<Arc<Notifier>>,
}

impl SimClock {
    /// A clock that stands at `now`.
    #[must_use]
    pub fn new(now: Nanos) -> Self {
        Self {
            now: AtomicI64::new(now),
            notifier: OnceLock::new(),
        }
    }

    /// Sets the time, forwards or backwards.
    pub fn set(&self, now: Nanos) {
        self.now.store(now, Ordering::SeqCst);
        if let Some(notifier) = self.notifier.get() {
            notifier.notify();
        }
    }
}

impl Clock for SimClock {
    fn now(&self) -> Nanos {
        self.now.load(Ordering::SeqCst)
    }

    fn wait_until(&self, deadline: Nanos, notifier: &Notifier) {
        if self.now() < deadline {
            notifier.wait(Duration::MAX);
        }
    }

    fn serve(&self, notifier: &Arc<Notifier>) {
        // A clock serves one twin; a second one would have to look at it in its own time.
        let _ = self.notifier.set(Arc::clone(notifier));
    }
}

impl<C: Clock> Clock for Arc<C> {
    fn now(&self) -> Nanos {
        (**self).now()
    }

    fn wait_until(&self, deadline: Nanos, notifier: &Notifier) {
        (**self).wait_until(deadline, notifier);
    }

    fn serve(&self, notifier: &Arc<Notifier>) {
        (**self).serve(notifier);
    }

    fn resynchronise(&self) {
        (**self).resynchronise();
    }
}
