//! Messages that are given up because they are too long.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::guid_prefix::GuidPrefix;
use super::log_limit::SubjectLimit;

/// Most of them that are logged per [`LIMIT_PERIOD`]; further ones are only counted.
const MAX_LOGGED: u64 = 10;

/// Period of [`MAX_LOGGED`].
const LIMIT_PERIOD: Duration = Duration::from_secs(60);

/// Counts and logs messages that RustDDS does not put together from their fragments. Their sender is not asked for them again,
/// so that what it sends afterwards arrives.
#[derive(Debug)]
pub struct GivenUp {
    count: AtomicU64,
    limit: SubjectLimit,
}

impl Default for GivenUp {
    fn default() -> Self {
        Self {
            count: AtomicU64::new(0),
            limit: SubjectLimit::new("messages that are too long", MAX_LOGGED, LIMIT_PERIOD),
        }
    }
}

impl GivenUp {
    /// Number since the start.
    pub fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }

    /// A message of this size was given up.
    pub fn take(&self, name: &str, sender: GuidPrefix, size: u32, limit: u32, now: Instant) {
        self.count.fetch_add(1, Ordering::Relaxed);
        if let Some(hidden) = self.limit.admit(now) {
            tracing::warn!(
                "a message of {size} bytes on {name} was given up: the node takes at most {limit} bytes as one message; let the \
                 sender with the GUID {sender} send shorter ones{hidden}"
            );
        }
    }
}
