//! Losses of the node itself, counted for `/diagnostics` and the log.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::lifecycle::Lifecycle;
use super::senders::Senders;
use ros_node::clock_watch::ClockWatch;
use ros_node::given_up::GivenUp;
use ros_node::lost_peers::LostPeers;

/// Losses of the node itself since the start.
#[derive(Debug, Default)]
pub(super) struct NodeCounters {
    /// Unreadable messages and requests.
    pub unreadable: AtomicU64,
    /// Events and sets of parameters that arrived faster than they could be taken, or were sent while the network was interrupted.
    pub missed: AtomicU64,
    /// Messages that could not be written, or not in time for a slow reader.
    pub unpublished: AtomicU64,
    /// Messages for columns that are not in this fleet.
    pub ignored: AtomicU64,
    /// Events of vehicles that hit several columns, which were rejected.
    pub rejected_rows: AtomicU64,
    /// Log messages dropped because their queue was full.
    pub unlogged: AtomicU64,
    /// Peers that fell silent, and what was published meanwhile.
    pub lost_peers: Arc<LostPeers>,
    /// Messages that were given up because they are too long.
    pub given_up: Arc<GivenUp>,
    /// The simulated clock; `None` with the system's.
    pub clock: Option<ClockWatch>,
    /// The senders, if the parameters limit them.
    pub senders: Option<Arc<Senders>>,
    /// The state of a managed node; `None` of one that is always active.
    pub lifecycle: Option<Arc<Lifecycle>>,
}

impl NodeCounters {
    /// Messages and requests of senders that are not allowed, or too fast.
    pub fn rejected_senders(&self) -> u64 {
        let senders = self.senders.as_ref();
        senders.map_or(0, |it| it.not_allowed() + it.too_fast())
    }

    /// Whether the node publishes the outputs of the columns.
    pub fn is_active(&self) -> bool {
        self.lifecycle.as_ref().is_none_or(|it| it.is_active())
    }

    pub fn count(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }
}
