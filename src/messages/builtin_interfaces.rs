//! `builtin_interfaces`: instants and spans of time. Fields and units: the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

/// A span of time.
///
/// ```text
#[doc = include_str!("../../msg/deps/builtin_interfaces/Duration.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Duration {
    pub sec: i32,
    pub nanosec: u32,
}

/// An instant, counted from the epoch of its clock.
///
/// ```text
#[doc = include_str!("../../msg/deps/builtin_interfaces/Time.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

const NANOS_PER_SEC: i64 = 1_000_000_000;

impl Time {
    /// The instant that many nanoseconds after the epoch; `None` outside of what 32 bits of seconds hold.
    pub fn from_nanos(nanos: i64) -> Option<Self> {
        let sec = i32::try_from(nanos.div_euclid(NANOS_PER_SEC)).ok()?;
        let nanosec = u32::try_from(nanos.rem_euclid(NANOS_PER_SEC)).ok()?;
        Some(Self { sec, nanosec })
    }

    /// Nanoseconds after the epoch; `None` when `nanosec` is a second or more, which no instant has.
    pub fn to_nanos(self) -> Option<i64> {
        let nanosec = i64::from(self.nanosec);
        (nanosec < NANOS_PER_SEC).then(|| i64::from(self.sec) * NANOS_PER_SEC + nanosec)
    }
}
