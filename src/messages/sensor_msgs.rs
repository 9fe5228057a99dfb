//! `sensor_msgs`: joint states, compressed images, readings of inertial sensors. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::geometry_msgs::{Quaternion, Vector3};
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

/// A reading of an inertial measurement unit.
///
/// ```text
#[doc = include_str!("../../msg/deps/sensor_msgs/Imu.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Imu {
    pub header: Header,
    pub orientation: Quaternion,
    pub orientation_covariance: [f64; 9],
    pub angular_velocity: Vector3,
    pub angular_velocity_covariance: [f64; 9],
    pub linear_acceleration: Vector3,
    pub linear_acceleration_covariance: [f64; 9],
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
