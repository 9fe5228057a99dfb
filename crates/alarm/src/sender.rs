//! What the senders of all channels share: when to try, when to wait, when to end.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use crate::backoff::Backoff;
use crate::bell::Bell;
use crate::channel::Channel;
use crate::spool::Next;

/// A fresh alarm ends the wait after a failure, but not more often than so.
pub(crate) const LEAST_WAIT: Duration = Duration::from_secs(1);
/// Longest time without looking at what else is due.
pub(crate) const LONGEST_WAIT: Duration = Duration::from_secs(3600);

/// Why a message was not delivered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SendFault {
    /// The receiver cannot be reached, or is not ready; it asks for so long a wait.
    Away(String, Option<Duration>),
    /// The receiver rejected this message.
    Rejected(String),
}

/// What the sender of a channel is given.
#[derive(Clone)]
pub(crate) struct Sender {
    pub channel: Arc<Mutex<Channel>>,
    pub bell: Bell,
    pub ending: Arc<AtomicBool>,
    pub heartbeat: Option<Duration>,
    /// Grows as long as the host lives.
    pub signs_of_life: Arc<AtomicU64>,
    /// Where the clock begins.
    pub began: Instant,
}

impl Sender {
    pub fn channel(&self) -> MutexGuard<'_, Channel> {
        // A panic elsewhere must not stop the alarms.
        self.channel.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn now(&self) -> Duration {
        self.began.elapsed()
    }

    pub fn ends(&self) -> bool {
        self.ending.load(Ordering::Acquire)
    }
}

/// When heartbeats are due. A host that gives no sign of life has none.
pub(crate) struct Pulse {
    period: Option<Duration>,
    next: Duration,
    seen: u64,
}

impl Pulse {
    pub fn new(period: Option<Duration>) -> Self {
        Self {
            period,
            next: Duration::ZERO,
            seen: 0,
        }
    }

    /// When to ask again.
    pub fn next(&self) -> Option<Duration> {
        self.period.map(|_| self.next)
    }

    /// Whether a heartbeat is due, with the host's signs of life so far.
    pub fn is_due(&mut self, now: Duration, signs_of_life: u64) -> bool {
        let Some(period) = self.period else {
            return false;
        };
        if now < self.next {
            return false;
        }
        self.next = now + period;
        std::mem::replace(&mut self.seen, signs_of_life) != signs_of_life
    }
}

/// Offers what is due to a receiver that is asked one message after the other. Knows no clock: the caller gives the time.
pub(crate) struct Turns {
    backoff: Backoff,
    /// No attempt before this time.
    resume: Duration,
    last: Duration,
}

impl Turns {
    pub fn new() -> Self {
        Self {
            backoff: Backoff::default(),
            resume: Duration::ZERO,
            last: Duration::ZERO,
        }
    }

    /// Makes an attempt if one is due, and returns when the next one is, at the latest.
    pub fn turn(
        &mut self,
        channel: &Mutex<Channel>,
        now: Duration,
        rung: bool,
        send: &mut dyn FnMut(&crate::message::Message) -> Result<(), SendFault>,
    ) -> Duration {
        if rung {
            self.resume = self.resume.min(self.last + LEAST_WAIT);
        }
        if now < self.resume {
            return self.resume;
        }
        let locked = || channel.lock().unwrap_or_else(PoisonError::into_inner);
        let next = locked().next(now);
        match next {
            Next::Nothing => now + LONGEST_WAIT,
            Next::At(time) => time,
            Next::Send(it) => {
                self.last = now;
                // Without the lock: the receiver may take its time.
                match send(&it.message) {
                    Ok(()) => {
                        self.backoff.succeeded();
                        locked().delivered(it.number);
                    }
                    Err(SendFault::Rejected(why)) => {
                        self.backoff.succeeded();
                        locked().rejected(it.number, now, &why);
                    }
                    Err(SendFault::Away(why, asked)) => {
                        let wait = self.backoff.failed().max(asked.unwrap_or_default());
                        self.resume = now + wait;
                        locked().failed(&why, wait);
                        return self.resume;
                    }
                }
                now
            }
        }
    }

    /// Whether the receiver could not be reached the last time.
    pub fn is_waiting(&self, now: Duration) -> bool {
        now < self.resume
    }
}

/// The time of day.
pub(crate) fn time_of_day() -> SystemTime {
    SystemTime::now()
}
