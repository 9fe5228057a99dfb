//! What the arrays about hinges and webs consist of, which the module of `column_twin_msgs` re-exports.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use ros_interface::BoundedSequence;

/// Most hinges, and most webs, that a message has room for: those of a column of eight bars.
pub const MAX_HINGES: usize = 16;

/// One value for each hinge, or for each web, in the order of [`HingeDescription`] in `TwinStatus`. It is stored in place.
pub type PerHinge<T = f64> = BoundedSequence<T, MAX_HINGES>;

/// What an entry about a hinge or a web stands for.
///
/// ```text
#[doc = include_str!("../../msg/HingeDescription.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeDescription {
    pub name: String,
    pub place: String,
    pub height: f64,
    pub bar: u8,
    pub end: u8,
}

impl HingeDescription {
    pub const LOWER_END: u8 = 0;
    pub const UPPER_END: u8 = 1;
    pub const WHOLE_BAR: u8 = 2;
}
