//! Wakes one thread, without a lock.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::Duration;

/// Polling period of further threads.
const POLL_PERIOD: Duration = Duration::from_millis(1);

/// Wakes the thread that waits for it, without a lock or an allocation. Notifications before a wait count as one.
#[derive(Debug, Default)]
pub struct Notifier {
    notified: AtomicBool,
    sleeper: OnceLock<Thread>,
}

impl Notifier {
    /// Wakes the waiting thread, or lets its next wait return immediately.
    pub fn notify(&self) {
        // A swap, not a store: if it follows the swap of the first wait, it reads that one's value and so sees the sleeper.
        self.notified.swap(true, Ordering::SeqCst);
        if let Some(sleeper) = self.sleeper.get() {
            sleeper.unpark();
        }
    }

    /// Waits for a notification, at most `timeout`. May return early, so the caller must check its condition again. Only the
    /// first thread that ever waits is woken; others poll every millisecond.
    pub fn wait(&self, timeout: Duration) {
        let me = thread::current();
        let known = self.sleeper.get_or_init(|| me.clone()).id() == me.id();
        if !self.notified.swap(false, Ordering::SeqCst) {
            thread::park_timeout(if known {
                timeout
            } else {
                timeout.min(POLL_PERIOD)
            });
            self.notified.swap(false, Ordering::SeqCst);
        }
    }
}
