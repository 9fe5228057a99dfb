//! Foxglove in a program without the feature `foxglove`: says so if the parameters ask for it.

use crate::parameters::{FoxgloveMode, FoxgloveSettings};

use super::node::NodeError;

/// Fails if the parameters ask for Foxglove.
pub(super) fn not_wanted(settings: &FoxgloveSettings) -> Result<(), NodeError> {
    match settings.mode {
        FoxgloveMode::Off => Ok(()),
        FoxgloveMode::Serve => Err(NodeError::Foxglove(
            "this program was built without live topics for Foxglove; build it with the feature `foxglove`, or set foxglove.mode to off"
                .to_owned(),
        )),
    }
}
