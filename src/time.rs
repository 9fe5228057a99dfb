//! Time as this program counts it.

/// Nanoseconds since the epoch of the clock that drives the twin: that of ROS, or simulated time.
pub type Nanos = i64;

/// Nanoseconds of a second.
pub(crate) const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// The stamp of a message that states a second or more of nanoseconds, which is no time: every check rejects it.
pub(crate) const INVALID_STAMP: Nanos = Nanos::MIN;

/// Why such a stamp is rejected.
pub(crate) const INVALID_STAMP_REASON: &str = "the stamp has a second or more of nanoseconds; expected header.stamp.nanosec from 0 to 999999999";

/// A duration \[ns\] in seconds.
pub(crate) fn seconds(nanos: u64) -> f64 {
    nanos as f64 / NANOS_PER_SECOND as f64
}
