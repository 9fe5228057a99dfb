//! `sensor_msgs`: joint states and compressed images. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::std_msgs::Header;

/// An image in a file format.
///
/// ```text
#[doc = include_str!("../../msg/deps/sensor_msgs/CompressedImage.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CompressedImage {
    pub header: Header,
    pub format: String,
    pub data: Vec<u8>,
}

/// Positions, velocities and efforts of named joints.
///
/// ```text
#[doc = include_str!("../../msg/deps/sensor_msgs/JointState.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}
