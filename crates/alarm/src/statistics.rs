//! What became of the messages of a channel.

/// The state of one channel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChannelStatistics {
    /// `mqtt` or `webhook`.
    pub name: &'static str,
    /// Whether the last attempt succeeded; `None` before the first one.
    pub works: Option<bool>,
    /// Messages that the receiver acknowledged since the start.
    pub delivered: u64,
    /// Attempts that failed since the start.
    pub failed: u64,
    /// Messages that the receiver rejected since the start; they are offered again.
    pub rejected: u64,
    /// Messages that were given up: the spool was full, or damaged.
    pub lost: u64,
    /// Messages that wait now.
    pub waiting: u64,
    /// Alarms that are active now.
    pub active: u64,
    /// Heartbeats that were sent since the start.
    pub heartbeats: u64,
    /// Why the last attempt failed; empty if it did not.
    pub problem: String,
}

/// The state of the delivery.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Conditions that were dropped because the delivery did not keep up.
    pub dropped: u64,
    /// Its channels.
    pub channels: Vec<ChannelStatistics>,
}
