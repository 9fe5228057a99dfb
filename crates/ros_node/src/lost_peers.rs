//! Peers that fell silent, because of a broken network or because they were killed, and peers that came back.
//!
//! A peer that leaves in order says so and is not lost. One that is silent for longer than its lease counts as lost: nothing that is
//! published from then on is kept for it. If it comes back, it has missed those messages, and its user must know.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::guid_prefix::GuidPrefix;
use super::log_limit::SubjectLimit;

/// Maximum number of log messages about lost peers per [`LIMIT_PERIOD`], and of those about peers that came back; further ones are
/// counted. Without DDS security anyone can claim to be a peer.
const MAX_LOGGED: u64 = 20;

/// Period of [`MAX_LOGGED`].
const LIMIT_PERIOD: Duration = Duration::from_secs(60);

/// Maximum number of lost peers that are remembered. The one that was lost first gives way, and its return goes unnoticed.
const MAX_REMEMBERED: usize = 1024;

/// The lost peers of a participant.
#[derive(Debug)]
pub struct LostPeers {
    lost: Mutex<BTreeMap<GuidPrefix, Loss>>,
    losses: AtomicU64,
    returns: AtomicU64,
    /// Messages that the participant has published.
    published: AtomicU64,
    /// Those of them that were published while a peer that has come back was lost.
    published_meanwhile: AtomicU64,
    limit_of_losses: SubjectLimit,
    /// Its own: many losses must not hide that a peer is back.
    limit_of_returns: SubjectLimit,
}

/// When a peer was lost.
#[derive(Debug, Clone, Copy)]
struct Loss {
    /// Its last sign of life.
    last_heard: Instant,
    noticed: Instant,
    /// Number of messages published before.
    published: u64,
}

impl Default for LostPeers {
    fn default() -> Self {
        Self {
            lost: Mutex::default(),
            losses: AtomicU64::new(0),
            returns: AtomicU64::new(0),
            published: AtomicU64::new(0),
            published_meanwhile: AtomicU64::new(0),
            limit_of_losses: SubjectLimit::new("lost peers", MAX_LOGGED, LIMIT_PERIOD),
            limit_of_returns: SubjectLimit::new("peers that came back", MAX_LOGGED, LIMIT_PERIOD),
        }
    }
}

impl LostPeers {
    /// Number of peers that fell silent for longer than their lease.
    pub fn losses(&self) -> u64 {
        self.losses.load(Ordering::Relaxed)
    }

    /// Number of peers that came back after that.
    pub fn returns(&self) -> u64 {
        self.returns.load(Ordering::Relaxed)
    }

    /// Number of messages that were published while a peer that has come back was lost, for each such peer.
    pub fn published_meanwhile(&self) -> u64 {
        self.published_meanwhile.load(Ordering::Relaxed)
    }

    /// A message is published.
    pub fn count_published(&self) {
        self.published.fetch_add(1, Ordering::Relaxed);
    }

    /// A peer that was matched on these topics has been silent for `silence`, longer than its `lease`.
    pub fn take_lost(
        &self,
        peer: GuidPrefix,
        topics: &[String],
        (silence, lease): (Duration, Duration),
        now: Instant,
    ) {
        self.losses.fetch_add(1, Ordering::Relaxed);
        let loss = Loss {
            last_heard: now.checked_sub(silence).unwrap_or(now),
            noticed: now,
            published: self.published.load(Ordering::Relaxed),
        };
        {
            let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
            if lost.len() >= MAX_REMEMBERED {
                let first = lost.iter().min_by_key(|(_, it)| it.noticed);
                let first = first.map(|(peer, _)| *peer);
                first.map(|first| lost.remove(&first));
            }
            lost.insert(peer, loss);
        }
        if let Some(hidden) = self.limit_of_losses.admit(now) {
            tracing::warn!(
                "peer {peer} has been silent for {:.0} s, longer than its lease of {:.0} s, and counts as lost; it was matched on {}. \
                 Check its machine and the network{hidden}",
                silence.as_secs_f64(),
                lease.as_secs_f64(),
                topics.join(", ")
            );
        }
    }

    /// A peer is matched with an endpoint; it may be one that was lost.
    pub fn take_matched(&self, peer: GuidPrefix, now: Instant) {
        let loss = {
            let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
            lost.remove(&peer)
        };
        let Some(loss) = loss else {
            return;
        };
        self.returns.fetch_add(1, Ordering::Relaxed);
        let missed = self.published.load(Ordering::Relaxed) - loss.published;
        self.published_meanwhile
            .fetch_add(missed, Ordering::Relaxed);
        if let Some(hidden) = self.limit_of_returns.admit(now) {
            tracing::warn!(
                "peer {peer} is back after {:.0} s; it was found lost {:.0} s ago, and {missed} messages were published since then, \
                 of which it has received at most the latched ones{hidden}",
                (now - loss.last_heard).as_secs_f64(),
                (now - loss.noticed).as_secs_f64()
            );
        }
    }

    /// A peer has left in order, possibly after it was lost.
    pub fn take_left(&self, peer: GuidPrefix) {
        let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.remove(&peer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEASE: Duration = Duration::from_secs(20);

    /// Programs that are killed one after the other are many losses.
    #[test]
    fn many_losses_do_not_hide_a_return() {
        let (peers, now) = (LostPeers::default(), Instant::now());
        for number in 0..=MAX_LOGGED as u8 {
            peers.take_lost(GuidPrefix([number; 12]), &[], (LEASE, LEASE), now);
        }
        assert!(peers.limit_of_losses.admit(now).is_none());
        assert!(peers.limit_of_returns.admit(now).is_some());
    }

    #[test]
    fn what_is_published_while_a_peer_is_lost_counts_when_it_comes_back() {
        let (peers, now) = (LostPeers::default(), Instant::now());
        let [one, other, gone] = [1, 2, 3].map(|it| GuidPrefix([it; 12]));
        let publish = |count| (0..count).for_each(|_| peers.count_published());
        publish(5);
        peers.take_matched(one, now);
        for peer in [one, gone] {
            peers.take_lost(peer, &["/a".to_owned()], (LEASE, LEASE), now);
        }
        publish(7);
        peers.take_lost(other, &[], (LEASE, LEASE), now);
        publish(2);
        peers.take_left(gone);
        for _ in 0..2 {
            for peer in [one, other, gone] {
                peers.take_matched(peer, now);
            }
        }
        assert_eq!((peers.losses(), peers.returns()), (3, 2));
        assert_eq!(peers.published_meanwhile(), 9 + 2);
    }

    #[test]
    fn the_number_of_remembered_peers_is_bounded() {
        let (peers, now) = (LostPeers::default(), Instant::now());
        let peer = |index: u16| {
            let mut prefix = [0; 12];
            prefix[..2].copy_from_slice(&index.to_be_bytes());
            GuidPrefix(prefix)
        };
        for index in 0..2000 {
            let now = now + Duration::from_millis(index.into());
            peers.take_lost(peer(index), &[], (LEASE, LEASE), now);
        }
        peers.take_matched(peer(0), now);
        peers.take_matched(peer(1999), now + 2 * LEASE);
        assert_eq!(peers.returns(), 1, "the newest ones are remembered");
        let remembered = peers.lost.lock().expect("not poisoned").len();
        assert!(remembered < MAX_REMEMBERED, "{remembered}");
    }
}
