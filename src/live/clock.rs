//! Clocks that drive a twin.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

use super::notifier::Notifier;
use crate::time::NANOS_PER_SECOND;
use crate::time::Nanos;

/// A longer wait uses the notifier, so that a command can end it \[ns\].
const MAX_SLEEP: Nanos = 2_000_000;

/// A clock that can be waited for.
pub trait Clock: Send + Sync {
    /// The current time \[ns since the epoch\].
    fn now(&self) -> Nanos;

    /// Waits until `deadline`. A long wait also ends when the notifier is notified.
    fn wait_until(&self, deadline: Nanos, notifier: &Notifier);

    /// As [`wait_until`](Self::wait_until), where a notification ends even a short wait, for threads that share their work.
    fn wait_for_news(&self, deadline: Nanos, notifier: &Notifier) {
        self.wait_until(deadline, notifier);
    }

    /// Passes the notifier of a thread that uses this clock, before its first wait.
    fn serve(&self, _notifier: &Arc<Notifier>) {}

    /// The instant by which a thread that sees `now` could have acted at the latest, to judge its lateness: a clock that goes in steps
    /// shows a deadline that lies between two of them only at the second.
    fn could_act_at(&self, now: Nanos) -> Nanos {
        now
    }

    /// Called while no response is running: a clock that has been set may jump now. Returns whether it has.
    fn resynchronise(&self) -> bool {
        false
    }
}

/// The system time. During a response it advances steadily, even if the system clock is set.
#[derive(Debug)]
pub struct SystemClock {
    /// System time minus monotonic time \[ns\].
    offset: AtomicI64,
}

impl SystemClock {
    /// The current system time.
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
            // A signal may end the wait early; the caller reads the clock anyway.
            let _ = clock_nanosleep_absolute(ClockId::Monotonic, &request);
        }
    }

    fn wait_for_news(&self, deadline: Nanos, notifier: &Notifier) {
        let left = deadline.saturating_sub(self.now());
        if left > 0 {
            notifier.wait(Duration::from_nanos(left.unsigned_abs()));
        }
    }

    fn resynchronise(&self) -> bool {
        // Two clocks cannot be read at the same instant: smaller changes of the offset are measurement errors.
        const MIN_CHANGE: u64 = 100_000;
        let new = offset();
        let was_set = new.abs_diff(self.offset.load(Ordering::Relaxed)) > MIN_CHANGE;
        if was_set {
            self.offset.store(new, Ordering::Relaxed);
        }
        was_set
    }
}

/// System time minus monotonic time. The thread may be preempted between readings, so that the reading that took the least
/// time counts.
fn offset() -> i64 {
    const READINGS: usize = 5;
    let reading = || {
        let before = read(ClockId::Monotonic);
        let since_epoch = read(ClockId::Realtime);
        let duration = read(ClockId::Monotonic).saturating_sub(before);
        let middle = before.saturating_add(duration / 2);
        (duration, since_epoch.saturating_sub(middle))
    };
    let readings = (0..READINGS).map(|_| reading());
    readings.min().map_or(0, |(_, offset)| offset)
}

/// Monotonic time \[ns\], to measure compute times.
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

/// A clock that is set from outside: simulated time from `/clock`, or a test.
#[derive(Debug, Default)]
pub struct SimClock {
    now: AtomicI64,
    /// What it showed before it was set last.
    before: AtomicI64,
    /// Of the threads that use it.
    notifiers: RwLock<Vec<Arc<Notifier>>>,
}

impl SimClock {
    /// A clock that shows `now` until it is set.
    #[must_use]
    pub fn new(now: Nanos) -> Self {
        Self {
            now: AtomicI64::new(now),
            before: AtomicI64::new(now),
            notifiers: RwLock::default(),
        }
    }

    /// Sets the time, forward or backward.
    pub fn set(&self, now: Nanos) {
        let before = self.now.swap(now, Ordering::SeqCst);
        self.before.store(before, Ordering::SeqCst);
        let notifiers = self.notifiers.read();
        let notifiers = notifiers.unwrap_or_else(PoisonError::into_inner);
        notifiers.iter().for_each(|it| it.notify());
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

    fn could_act_at(&self, now: Nanos) -> Nanos {
        self.before.load(Ordering::SeqCst).min(now)
    }

    fn serve(&self, notifier: &Arc<Notifier>) {
        let mut notifiers = self
            .notifiers
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        notifiers.push(Arc::clone(notifier));
    }
}

impl<C: Clock + ?Sized> Clock for Arc<C> {
    fn now(&self) -> Nanos {
        (**self).now()
    }

    fn wait_until(&self, deadline: Nanos, notifier: &Notifier) {
        (**self).wait_until(deadline, notifier);
    }

    fn wait_for_news(&self, deadline: Nanos, notifier: &Notifier) {
        (**self).wait_for_news(deadline, notifier);
    }

    fn serve(&self, notifier: &Arc<Notifier>) {
        (**self).serve(notifier);
    }

    fn could_act_at(&self, now: Nanos) -> Nanos {
        (**self).could_act_at(now)
    }

    fn resynchronise(&self) -> bool {
        (**self).resynchronise()
    }
}
