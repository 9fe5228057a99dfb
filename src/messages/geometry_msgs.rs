//! `geometry_msgs`: points, vectors, orientations, accelerations. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::std_msgs::Header;

/// An acceleration \[m/s^2\] and an angular acceleration \[rad/s^2\].
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/Accel.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Accel {
    pub linear: Vector3,
    pub angular: Vector3,
}

/// An acceleration with its time and frame.
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/AccelStamped.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AccelStamped {
    pub header: Header,
    pub accel: Accel,
}

/// A position \[m\].
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/Point.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// Position and orientation.
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/Pose.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    pub position: Point,
    pub orientation: Quaternion,
}

/// An orientation; the default is no rotation.
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/Quaternion.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }
    }
}

/// A vector.
///
/// ```text
#[doc = include_str!("../../msg/deps/geometry_msgs/Vector3.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}
