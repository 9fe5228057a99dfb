//! `diagnostic_msgs`: the messages on `/diagnostics`. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::std_msgs::Header;

/// The states of several components.
///
/// ```text
#[doc = include_str!("../../msg/deps/diagnostic_msgs/DiagnosticArray.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

/// The state of one component.
///
/// ```text
#[doc = include_str!("../../msg/deps/diagnostic_msgs/DiagnosticStatus.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    pub const OK: u8 = 0;
    pub const WARN: u8 = 1;
    pub const ERROR: u8 = 2;
    pub const STALE: u8 = 3;
}

/// A named value.
///
/// ```text
#[doc = include_str!("../../msg/deps/diagnostic_msgs/KeyValue.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}
