//! How long to wait before the next attempt.

use std::time::Duration;

/// The first wait.
pub(crate) const FIRST: Duration = Duration::from_millis(500);
/// The longest wait, so that alarms arrive at most a minute after the receiver is back.
pub(crate) const LONGEST: Duration = Duration::from_secs(60);

/// Waits that double after each failure.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Backoff {
    failures: u32,
}

impl Backoff {
    /// The wait after another failure.
    pub fn failed(&mut self) -> Duration {
        let wait = wait_after(self.failures);
        self.failures = self.failures.saturating_add(1);
        wait
    }

    /// After a success the next failure starts with the shortest delay again.
    pub fn succeeded(&mut self) {
        self.failures = 0;
    }
}

/// The wait after a failure that this many others came before.
pub(crate) fn wait_after(failures: u32) -> Duration {
    FIRST
        .saturating_mul(2_u32.saturating_pow(failures))
        .min(LONGEST)
}
