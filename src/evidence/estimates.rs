//! The estimates of a recording: each is a command in its journal.

use std::sync::Arc;

use super::verification::Verification;
use crate::senses::EstimateRecord;
use crate::twin::Command;

/// Why no estimate is computed again.
const NO_MEASUREMENTS: &str = "the recording has no measurements";

/// Checks the estimates of a recording.
#[derive(Debug, Default)]
pub(super) struct EstimateCheck {
    /// Estimates that were not computed again.
    unchecked: u64,
}

impl EstimateCheck {
    /// Takes an estimate of the journal; the command with which the recomputed twin goes on.
    pub fn command(&mut self, recorded: &Arc<EstimateRecord>, found: &mut Verification) -> Command {
        found.estimates.recorded += 1;
        found.estimates.unchecked += 1;
        self.unchecked += 1;
        Command::Estimate(Arc::clone(recorded))
    }

    /// Tells what was not checked.
    pub fn finish(self, found: &mut Verification) {
        if self.unchecked > 0 {
            found.note_unchecked(format!(
                "{} estimates were not computed again: {NO_MEASUREMENTS}; their messages are compared with the journal",
                self.unchecked
            ));
        }
    }
}
