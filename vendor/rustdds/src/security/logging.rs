// Macros for logging security events.
// Currently these just create a normal log entry,
// but they're intended as a reminder that security-related
// logging should be handled with special care (by a security-logging-plugin in
// the future?) So they act as a placeholder for more to come.

use std::{
  sync::{Mutex, PoisonError},
  time::{Duration, Instant},
};

/// Maximum number of warnings or errors from one place of the program per
/// [`LOG_LIMIT_PERIOD`]. Many of them are caused by what peers send, so that
/// without a limit a peer, even one that is not admitted, fills the log.
const MAX_LOGGED: u32 = 5;

const LOG_LIMIT_PERIOD: Duration = Duration::from_secs(10);

/// Counts the messages of one place of the program.
#[doc(hidden)]
pub struct LogLimit(Mutex<Option<(Instant, u32)>>);

impl LogLimit {
  #[allow(clippy::new_without_default)] // for statics
  pub const fn new() -> Self {
    LogLimit(Mutex::new(None))
  }

  /// Should one more message be logged?
  pub fn admit(&self) -> bool {
    self.admit_at(Instant::now())
  }

  fn admit_at(&self, now: Instant) -> bool {
    let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
    let (start, count) = state.get_or_insert((now, 0));
    if now.saturating_duration_since(*start) >= LOG_LIMIT_PERIOD {
      (*start, *count) = (now, 0);
    }
    *count = count.saturating_add(1);
    *count <= MAX_LOGGED
  }
}

#[macro_export]
macro_rules! security_info {
  ($($arg:tt)*) => (
      {log::info!($($arg)*);}
    )
}

#[macro_export]
macro_rules! security_warn {
  ($($arg:tt)*) => (
      {
        static LIMIT: $crate::security::logging::LogLimit = $crate::security::logging::LogLimit::new();
        if LIMIT.admit() { log::warn!($($arg)*); }
      }
    )
}

#[macro_export]
macro_rules! security_error {
  ($($arg:tt)*) => (
      {
        static LIMIT: $crate::security::logging::LogLimit = $crate::security::logging::LogLimit::new();
        if LIMIT.admit() { log::error!($($arg)*); }
      }
    )
}

#[cfg(test)]
mod tests {
  use super::*;

  #[test]
  fn a_peer_cannot_fill_the_log() {
    let (limit, start) = (LogLimit::new(), Instant::now());
    let logged = |at| (0..1000).filter(|_| limit.admit_at(at)).count();
    assert_eq!(logged(start), 5);
    assert_eq!(logged(start + Duration::from_secs(9)), 0);
    assert_eq!(logged(start + Duration::from_secs(10)), 5);
  }
}
