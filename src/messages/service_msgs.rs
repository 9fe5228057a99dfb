//! `service_msgs`: what every service type refers to for the introspection of services. Fields and units are in the definition
//! above the struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::builtin_interfaces::Time;

/// An event of a service.
///
/// ```text
#[doc = include_str!("../../msg/deps/service_msgs/ServiceEventInfo.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ServiceEventInfo {
    pub event_type: u8,
    pub stamp: Time,
    pub client_gid: [u8; 16],
    pub sequence_number: i64,
}

impl ServiceEventInfo {
    pub const REQUEST_SENT: u8 = 0;
    pub const REQUEST_RECEIVED: u8 = 1;
    pub const RESPONSE_SENT: u8 = 2;
    pub const RESPONSE_RECEIVED: u8 = 3;
}
