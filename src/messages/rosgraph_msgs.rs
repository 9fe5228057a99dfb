//! `rosgraph_msgs`: simulated time. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::builtin_interfaces::Time;

/// The current simulated time.
///
/// ```text
#[doc = include_str!("../../msg/deps/rosgraph_msgs/Clock.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Clock {
    pub clock: Time,
}
