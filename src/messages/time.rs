//! Times of messages as nanoseconds.

use super::builtin_interfaces::Time;

const NANOS_PER_SEC: i64 = 1_000_000_000;

impl Time {
    /// Converts from nanoseconds since the epoch; `None` if the seconds do not fit into 32 bits.
    pub fn from_nanos(nanos: i64) -> Option<Self> {
        let sec = i32::try_from(nanos.div_euclid(NANOS_PER_SEC)).ok()?;
        let nanosec = u32::try_from(nanos.rem_euclid(NANOS_PER_SEC)).ok()?;
        Some(Self { sec, nanosec })
    }

    /// Nanoseconds since the epoch; `None` if `nanosec` is not valid, i.e. a second or more.
    pub fn to_nanos(self) -> Option<i64> {
        let nanosec = i64::from(self.nanosec);
        (nanosec < NANOS_PER_SEC).then(|| i64::from(self.sec) * NANOS_PER_SEC + nanosec)
    }
}
