//! Peers that joined with a valid identity, and peers that were rejected: counted, and logged within a limit.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::guid_prefix::GuidPrefix;
use crate::log_limit::SubjectLimit;

/// Maximum number of log messages about peers per [`LIMIT_PERIOD`]; further ones are counted. A hostile peer may try to join
/// as often as it likes, so that this bounds what it can write into the log: about 3 MB a day.
const MAX_LOGGED: u64 = 10;

/// Period of [`MAX_LOGGED`].
const LIMIT_PERIOD: Duration = Duration::from_secs(60);

/// Maximum number of peers whose subject is remembered; the oldest entry by identifier gives way.
const MAX_REMEMBERED: usize = 1024;

/// Maximum length of a reason, parts of which may come from the peer \[characters\].
const MAX_REASON: usize = 300;

/// The peers of a protected participant.
#[derive(Debug)]
pub struct Peers {
    joined: AtomicU64,
    rejected: AtomicU64,
    /// Subjects of authenticated peers by the prefix of their GUID.
    subjects: Mutex<BTreeMap<GuidPrefix, String>>,
    limit: SubjectLimit,
}

impl Default for Peers {
    fn default() -> Self {
        Self {
            joined: AtomicU64::new(0),
            rejected: AtomicU64::new(0),
            subjects: Mutex::default(),
            limit: SubjectLimit::new("peers", MAX_LOGGED, LIMIT_PERIOD),
        }
    }
}

impl Peers {
    /// Number of times that a peer joined.
    #[must_use]
    pub fn joined(&self) -> u64 {
        self.joined.load(Ordering::Relaxed)
    }

    /// Number of rejections; a peer that keeps trying is counted each time.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected.load(Ordering::Relaxed)
    }

    /// The subject of the certificate of an authenticated peer, such as `CN=/monitor`.
    #[must_use]
    pub fn subject(&self, prefix: GuidPrefix) -> Option<String> {
        let subjects = self.subjects.lock().unwrap_or_else(PoisonError::into_inner);
        subjects.get(&prefix).cloned()
    }

    /// A peer has proved its identity, and its permissions are valid.
    pub fn take_joined(&self, prefix: GuidPrefix, subject: &str, now: Instant) {
        self.joined.fetch_add(1, Ordering::Relaxed);
        let subject = printable(subject);
        if let Some(hidden) = self.limit.admit(now) {
            tracing::info!("peer {prefix} joined with the identity {subject}{hidden}");
        }
        let mut subjects = self.subjects.lock().unwrap_or_else(PoisonError::into_inner);
        if subjects.len() >= MAX_REMEMBERED {
            subjects.pop_first();
        }
        subjects.insert(prefix, subject);
    }

    /// A peer was rejected.
    pub fn take_rejected(&self, prefix: GuidPrefix, reason: &str, now: Instant) {
        self.rejected.fetch_add(1, Ordering::Relaxed);
        if let Some(hidden) = self.limit.admit(now) {
            tracing::warn!("peer {prefix} was rejected: {}{hidden}", printable(reason));
        }
    }

    /// A peer has left.
    pub fn take_lost(&self, prefix: GuidPrefix) {
        let mut subjects = self.subjects.lock().unwrap_or_else(PoisonError::into_inner);
        subjects.remove(&prefix);
    }
}

/// Parts of a text may come from the peer: no control characters, and a bounded length.
fn printable(text: &str) -> String {
    text.chars()
        .take(MAX_REASON)
        .map(|it| if it.is_ascii_graphic() { it } else { ' ' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rejected_peer_cannot_fill_the_log() {
        let (peers, start) = (Peers::default(), Instant::now());
        let shown = |at| {
            (0..1000)
                .filter(|_| peers.limit.admit(at).is_some())
                .count()
        };
        assert_eq!(shown(start), 10);
        assert_eq!(shown(start + Duration::from_secs(59)), 0);
        assert_eq!(
            peers.limit.admit(start + Duration::from_secs(60)),
            Some(" (1990 messages about peers before this one are not shown)".to_owned()),
            "the hidden ones are counted"
        );
        assert_eq!(shown(start + Duration::from_secs(61)), 9);
    }

    #[test]
    fn every_peer_is_counted_and_only_present_ones_are_remembered() {
        let (peers, now) = (Peers::default(), Instant::now());
        for index in 0..100u8 {
            peers.take_joined(GuidPrefix([index; 12]), "CN=/monitor", now);
            peers.take_rejected(GuidPrefix([index; 12]), "forged", now);
        }
        assert_eq!((peers.joined(), peers.rejected()), (100, 100));
        assert_eq!(
            peers.subject(GuidPrefix([7; 12])).as_deref(),
            Some("CN=/monitor")
        );
        peers.take_lost(GuidPrefix([7; 12]));
        assert_eq!(peers.subject(GuidPrefix([7; 12])), None);
        for index in 0..3000u16 {
            let mut prefix = [0; 12];
            prefix[..2].copy_from_slice(&index.to_be_bytes());
            peers.take_joined(GuidPrefix(prefix), "CN=/flood", now);
        }
        let remembered = peers.subjects.lock().expect("not poisoned").len();
        assert!(remembered <= MAX_REMEMBERED, "{remembered}");
    }

    #[test]
    fn a_peer_cannot_write_control_characters_into_the_log() {
        assert_eq!(printable("a\nb\u{1b}[31m\u{202e}c"), "a b [31m c");
        assert_eq!(printable(&"x".repeat(100_000)).len(), MAX_REASON);
    }
}
