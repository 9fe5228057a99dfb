//! The readers of the outputs: each has queues of its own, so that a slow one loses its own outputs only.

use std::sync::Arc;

use crate::live::queue::{OutputQueues, QueueStats};
use crate::twin::Output;

/// The queues to all readers.
#[derive(Debug)]
pub struct Readers {
    queues: Box<[Arc<OutputQueues>]>,
    /// The first so many also get the journals.
    journals: usize,
}

impl Readers {
    pub fn new(queues: impl IntoIterator<Item = Arc<OutputQueues>>, journals: usize) -> Self {
        Self {
            queues: queues.into_iter().collect(),
            journals,
        }
    }

    /// Whether any reader gets the journals.
    pub fn have_journals(&self) -> bool {
        self.journals > 0
    }

    /// Adds an output of a column.
    pub fn push_of(&self, column: u32, output: Output) {
        let readers = match output {
            Output::Journal(_) => self.queues.get(..self.journals).unwrap_or_default(),
            _ => &self.queues,
        };
        if let Some((first, others)) = readers.split_first() {
            for it in others {
                it.push_of(column, output.clone());
            }
            first.push_of(column, output);
        }
    }

    /// The queues, for another thread that has something to say.
    pub fn queues(&self) -> Vec<Arc<OutputQueues>> {
        self.queues.to_vec()
    }

    pub fn notify(&self) {
        self.queues.iter().for_each(|it| it.notify());
    }

    pub fn stats(&self) -> impl Iterator<Item = QueueStats> {
        self.queues.iter().flat_map(|it| it.stats())
    }
}
