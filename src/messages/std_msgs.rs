//! `std_msgs`: header, colour and text. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::builtin_interfaces::Time;

/// A colour.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_msgs/ColorRGBA.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ColorRGBA {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}

/// Time stamp and frame of a message.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_msgs/Header.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Time,
    pub frame_id: std::string::String,
}

/// A text.
///
/// ```text
#[doc = include_str!("../../msg/deps/std_msgs/String.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct String {
    pub data: std::string::String,
}
