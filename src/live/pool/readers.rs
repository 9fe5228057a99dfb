//! The readers of the outputs of a fleet: each has queues of its own, so that a slow one loses its own outputs only.

use std::sync::Arc;

use super::super::queue::{OutputQueues, QueueStats};
use crate::twin::Output;

/// The queues to all readers; the first one, which publishes and records, also gets the journals.
#[derive(Debug)]
pub struct Readers(Box<[Arc<OutputQueues>]>);

impl Readers {
    pub fn new(queues: impl IntoIterator<Item = Arc<OutputQueues>>) -> Self {
        Self(queues.into_iter().collect())
    }

    /// Adds an output of a column.
    pub fn push_of(&self, column: u32, output: Output) {
        let Some((first, others)) = self.0.split_first() else {
            return;
        };
        if !matches!(output, Output::Journal(_)) {
            for it in others {
                it.push_of(column, output.clone());
            }
        }
        first.push_of(column, output);
    }

    /// The queues, for another thread that has something to say.
    #[cfg(feature = "study")]
    pub fn queues(&self) -> Vec<Arc<OutputQueues>> {
        self.0.to_vec()
    }

    pub fn notify(&self) {
        self.0.iter().for_each(|it| it.notify());
    }

    pub fn stats(&self) -> impl Iterator<Item = QueueStats> {
        self.0.iter().flat_map(|it| it.stats())
    }
}
