//! `rcl_interfaces`: log messages and parameter changes, which every node publishes. Fields and units are in the
//! definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::builtin_interfaces::Time;

/// A log message of a node.
///
/// ```text
#[doc = include_str!("../../msg/deps/rcl_interfaces/Log.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Log {
    pub stamp: Time,
    pub level: u8,
    pub name: String,
    pub msg: String,
    pub file: String,
    pub function: String,
    pub line: u32,
}

impl Log {
    pub const DEBUG: u8 = 10;
    pub const INFO: u8 = 20;
    pub const WARN: u8 = 30;
    pub const ERROR: u8 = 40;
    pub const FATAL: u8 = 50;
}

/// A change of parameters of a node.
///
/// ```text
#[doc = include_str!("../../msg/deps/rcl_interfaces/ParameterEvent.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParameterEvent {
    pub stamp: Time,
    pub node: String,
    pub new_parameters: Vec<Parameter>,
    pub changed_parameters: Vec<Parameter>,
    pub deleted_parameters: Vec<Parameter>,
}

/// A parameter.
///
/// ```text
#[doc = include_str!("../../msg/deps/rcl_interfaces/Parameter.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameter {
    pub name: String,
    pub value: ParameterValue,
}

/// The value of a parameter.
///
/// ```text
#[doc = include_str!("../../msg/deps/rcl_interfaces/ParameterValue.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParameterValue {
    #[serde(rename = "type")]
    pub kind: u8,
    pub bool_value: bool,
    pub integer_value: i64,
    pub double_value: f64,
    pub string_value: String,
    pub byte_array_value: Vec<u8>,
    pub bool_array_value: Vec<bool>,
    pub integer_array_value: Vec<i64>,
    pub double_array_value: Vec<f64>,
    pub string_array_value: Vec<String>,
}
