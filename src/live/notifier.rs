//! Wakes one thread, without a lock.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::Duration;

/// How long a thread that the notifier does not know sleeps at a time.
const UNKNOWN_NAP: Duration = Duration::from_millis(1);

/// How long a thread sleeps at the most, so that a ring that crosses with its very first wait is heard in the end.
const MAX_NAP: Duration = Duration::from_millis(100);

/// Wakes the one thread that waits at it. Ringing takes no lock and no memory; rings before the next wait are one.
#[derive(Debug, Default)]
pub struct Notifier {
    rung: AtomicBool,
    sleeper: OnceLock<Thread>,
}

impl Notifier {
    /// Wakes the thread that waits, or lets its next wait return at once.
    pub fn notify(&self) {
        self.rung.store(true, Ordering::SeqCst);
        if let Some(sleeper) = self.sleeper.get() {
            sleeper.unpark();
        }
    }

    /// Waits for a ring, for `most` at the longest and sometimes shorter: look again at what is waited for. The first
    /// thread that waits is the one that is woken; others look every millisecond.
    pub fn wait(&self, most: Duration) {
        let me = thread::current();
        let known = self.sleeper.get_or_init(|| me.clone()).id() == me.id();
        if !self.rung.swap(false, Ordering::SeqCst) {
            thread::park_timeout(most.min(if known { MAX_NAP } else { UNKNOWN_NAP }));
            self.rung.store(false, Ordering::SeqCst);
        }
    }
}
