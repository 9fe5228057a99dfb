//! Time as this program counts it.

/// Nanoseconds since the epoch of the clock that drives the twin: that of ROS, or simulated time.
pub type Nanos = i64;

/// Nanoseconds of a second.
pub(crate) const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// A duration \[ns\] in seconds.
pub(crate) fn seconds(nanos: u64) -> f64 {
    nanos as f64 / NANOS_PER_SECOND as f64
}
