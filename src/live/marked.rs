//! Columns that a thread is to look at, without a lock, because those that mark them have deadlines.

use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam_queue::ArrayQueue;

/// The columns that were marked and not looked at since, each at most once.
#[derive(Debug)]
pub(super) struct Marked {
    columns: ArrayQueue<u32>,
    is_marked: Box<[AtomicBool]>,
}

impl Marked {
    /// For so many columns, none of which is marked.
    pub fn new(columns: usize) -> Self {
        Self {
            columns: ArrayQueue::new(columns.max(1)),
            is_marked: (0..columns).map(|_| AtomicBool::new(false)).collect(),
        }
    }

    /// Marks a column, unless it is marked. One that there is not is not marked.
    pub fn mark(&self, column: u32) {
        let flag = self.is_marked.get(column as usize);
        if flag.is_some_and(|it| !it.swap(true, Ordering::SeqCst)) {
            // There is room: each column is in the queue at most once.
            let _ = self.columns.push(column);
        }
    }

    /// A marked column, whose mark is taken away.
    pub fn next(&self) -> Option<u32> {
        let column = self.columns.pop()?;
        // Before it is looked at, so that a change while it is looked at is not forgotten.
        if let Some(flag) = self.is_marked.get(column as usize) {
            flag.store(false, Ordering::SeqCst);
        }
        Some(column)
    }

    /// How many columns are marked.
    pub fn len(&self) -> usize {
        self.columns.len()
    }
}
