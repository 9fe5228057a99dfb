//! `column_twin`: messages that only fleets use. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::std_msgs::Header;

/// A vehicle hits several columns of a fleet one after another.
///
/// ```text
#[doc = include_str!("../../msg/RowImpactEvent.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RowImpactEvent {
    pub header: Header,
    pub event_id: String,
    pub vehicle: String,
    pub mass: f64,
    pub velocity: f64,
    pub gap: f64,
    pub restitution: f64,
    pub height: f64,
    pub column_ids: Vec<String>,
    pub offsets: Vec<f64>,
    pub distances: Vec<f64>,
}
