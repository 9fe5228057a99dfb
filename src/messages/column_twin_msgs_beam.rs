//! What the fibre beam says, which the module of `column_twin_msgs` re-exports.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

/// An outcome or an action that is not known, as in `ImpactReport`.
const UNKNOWN: u8 = 255;

/// What the fibre beam says of an impact beside the two bars.
///
/// ```text
#[doc = include_str!("../../msg/SecondOpinion.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SecondOpinion {
    pub state: u8,
    pub text: String,
    pub outcome: u8,
    pub max_displacement: f64,
    pub max_sideways: f64,
    pub max_displacement_time: f64,
    pub residual_displacement: f64,
    pub residual_sideways: f64,
    pub undamaged_capacity: [f64; 2],
    pub residual_capacity: [f64; 2],
    pub base_shear: f64,
    pub base_moment: f64,
    pub error_estimate: f64,
    pub ratio_to_two_bars: f64,
    pub action: u8,
    pub counts: bool,
    pub decides: bool,
}

impl SecondOpinion {
    pub const NONE: u8 = 0;
    pub const PENDING: u8 = 1;
    pub const KNOWN: u8 = 2;
}

impl Default for SecondOpinion {
    /// That there is none, without a reason.
    fn default() -> Self {
        Self {
            state: Self::NONE,
            text: String::new(),
            outcome: UNKNOWN,
            max_displacement: f64::NAN,
            max_sideways: f64::NAN,
            max_displacement_time: f64::NAN,
            residual_displacement: f64::NAN,
            residual_sideways: f64::NAN,
            undamaged_capacity: [f64::NAN; 2],
            residual_capacity: [f64::NAN; 2],
            base_shear: f64::NAN,
            base_moment: f64::NAN,
            error_estimate: f64::NAN,
            ratio_to_two_bars: f64::NAN,
            action: UNKNOWN,
            counts: false,
            decides: false,
        }
    }
}
