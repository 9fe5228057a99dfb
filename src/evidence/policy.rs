//! In what the recordings of the two kinds of nodes differ; all else is the same for both.

use crate::endpoints::NodeKind;
use crate::time::Nanos;

/// Time for which the batches of one of many columns are kept \[ns\], beside the other bounds: there may be thousands of columns. An
/// estimate that has to wait for others, or for its responses, comes some seconds after its data.
const KEPT_OF_ONE_OF_MANY: Nanos = 30_000_000_000;

/// The column of a recording whose messages do not name it: it is known from the first checkpoint only.
pub(super) const UNNAMED: &str = "";

impl NodeKind {
    /// Whether messages and lines of the journal name their column, lists of the columns stand in the journal where a recording can
    /// begin, and each column has a result of its own.
    pub(super) fn names_columns(self) -> bool {
        self == Self::Fleet
    }

    /// Whether a column that nothing happens to is left alone: a checkpoint precedes its first command, whatever its number is, and
    /// with each command it forgets what no event can need any more. Otherwise checkpoints come from the start on, so that the first
    /// one of a recording may continue an earlier recording.
    pub(super) fn has_checkpoints_on_demand(self) -> bool {
        self == Self::Fleet
    }

    /// Time for which the measurements of a column are kept \[ns\].
    pub(super) fn keeps_measurements(self) -> Nanos {
        match self {
            Self::Single => Nanos::MAX,
            Self::Fleet => KEPT_OF_ONE_OF_MANY,
        }
    }
}
