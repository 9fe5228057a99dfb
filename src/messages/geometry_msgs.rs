//! `geometry_msgs`: points, vectors, orientations. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

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
