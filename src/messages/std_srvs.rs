//! `std_srvs`: the service without arguments. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

/// A request without content; rosidl sends one byte instead.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_srvs/Trigger.srv")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerRequest {
    pub structure_needs_at_least_one_member: u8,
}

/// Whether the request succeeded, and a message for people.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_srvs/Trigger.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerResponse {
    pub success: bool,
    pub message: String,
}
