//! The services of `column_twin`, which its module re-exports.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use super::column_twin_msgs::ImpactReport;

/// Request to make one column of a fleet undamaged.
///
/// ```text
#[doc = include_str!("../../srv/ResetColumn.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ResetColumnRequest {
    pub column_id: String,
}

/// Whether the column is undamaged.
///
/// ```text
#[doc = include_str!("../../srv/ResetColumn.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ResetColumnResponse {
    pub success: bool,
    pub rejection_code: u16,
    pub message: String,
}

/// Request for a prediction of an impact.
///
/// ```text
#[doc = include_str!("../../srv/PredictImpact.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PredictImpactRequest {
    pub column_id: String,
    pub event_id: String,
    pub vehicle: String,
    pub mass: f64,
    pub velocity: f64,
    pub gap: f64,
    pub restitution: f64,
    pub height: f64,
    pub direction: f64,
}

/// The prediction.
///
/// ```text
#[doc = include_str!("../../srv/PredictImpact.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PredictImpactResponse {
    pub success: bool,
    pub rejection_code: u16,
    pub message: String,
    pub report: ImpactReport,
}

/// Request for a decision about an estimate.
///
/// ```text
#[doc = include_str!("../../srv/ConfirmEstimate.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ConfirmEstimateRequest {
    pub column_id: String,
    pub event_id: String,
    pub accept: bool,
}

/// What was decided.
///
/// ```text
#[doc = include_str!("../../srv/ConfirmEstimate.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ConfirmEstimateResponse {
    pub success: bool,
    pub rejection_code: u16,
    pub message: String,
}

/// A measurement on the column at rest.
///
/// ```text
#[doc = include_str!("../../srv/CorrectDamage.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CorrectDamageRequest {
    pub column_id: String,
    pub quantity: u8,
    pub height: f64,
    pub value: f64,
    pub deviation: f64,
}

impl CorrectDamageRequest {
    pub const DISPLACEMENT: u8 = 0;
    pub const ROTATION: u8 = 1;
}

/// What the measurement has changed.
///
/// ```text
#[doc = include_str!("../../srv/CorrectDamage.srv")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CorrectDamageResponse {
    pub success: bool,
    pub rejection_code: u16,
    pub message: String,
    pub before: f64,
    pub after: f64,
    pub factor: f64,
}
