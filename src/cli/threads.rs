//! The option `--threads` of the studies.

use std::num::NonZeroUsize;

use column_twin::study::{Batch, Threads};

/// A batch for so many computations on as many threads as were asked for; fewer if they would be too many, which it tells on the
/// standard error.
pub fn batch(asked: Option<NonZeroUsize>, computations: u64) -> Batch {
    if let Some(reduction) = Threads::new(asked, computations).reduction() {
        tell!("Warning: {reduction}");
    }
    asked.map_or_else(Batch::default, Batch::on_threads)
}
