//! What the solver threads of a fleet tell those that detect impacts.

use std::sync::Arc;

use crate::live::sensing_news::SensingNews;

/// What the solver threads tell those that detect impacts.
#[derive(Debug)]
pub(super) struct FleetNews(Box<[Arc<SensingNews>]>);

impl FleetNews {
    /// The news for each thread.
    pub fn new(threads: Box<[Arc<SensingNews>]>) -> Self {
        Self(threads)
    }

    /// The thread of this column.
    pub fn of(&self, column: u32) -> &SensingNews {
        &self.0[column as usize % self.0.len()]
    }

    /// The news for each thread, in the order of the threads.
    pub fn threads(&self) -> &[Arc<SensingNews>] {
        &self.0
    }
}
