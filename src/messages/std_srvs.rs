//! `std_srvs`: the service without an argument. Fields and units: the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

/// Request without content; the one byte is what rosidl sends instead.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_srvs/Trigger.srv")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerRequest {
    pub structure_needs_at_least_one_member: u8,
}

/// Whether it was done, and what there is to say.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_srvs/Trigger.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerResponse {
    pub success: bool,
    pub message: String,
}
