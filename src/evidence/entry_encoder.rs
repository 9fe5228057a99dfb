//! Encodes messages and journal entries as entries of a recording, and accounts for them in the lines of the journal.

use std::sync::Arc;

use super::about::{About, sha256_of};
use super::journal_line::{Counting, JournalEntry, JournalError, JournalLine};
use super::topics::{Topics, is_recomputed};
use crate::endpoints::{self, Endpoint};
use crate::estimation::IntakeState;
use crate::recording::Entry;
use crate::twin::Journal;

/// Encodes messages and journal entries for a recording. What it is told to have been recorded appears in the next line of
/// the journal.
#[derive(Debug)]
pub(super) struct EntryEncoder {
    topics: Topics,
    about: About,
    next_number: u64,
    since: Counting,
}

impl EntryEncoder {
    pub fn new(topics: &Topics, events_only: bool) -> Self {
        Self {
            topics: topics.clone(),
            about: About::this_program(topics.by_endpoint(), events_only),
            next_number: 0,
            since: Counting::default(),
        }
    }

    /// A message; `None` if its topic is not recorded.
    pub fn message(
        &self,
        endpoint: &Endpoint,
        data: Arc<[u8]>,
        log_time: i64,
        publish_time: i64,
    ) -> Option<Entry> {
        Some(Entry {
            topic: self.topics.index_of(endpoint)?,
            log_time,
            publish_time,
            data,
            checkpoint: false,
        })
    }

    /// Takes note of a message that was recorded.
    pub fn recorded_message(&mut self, endpoint: &Endpoint, log_time: i64) {
        if let Some(name) = self.about.topics.get(endpoint.name) {
            self.since.add(name, log_time, is_recomputed(endpoint.name));
        }
    }

    /// Takes note of measurements that were recorded, after [`recorded_message`](Self::recorded_message).
    pub fn recorded_measurement(&mut self, published: i64, bytes: &[u8]) {
        self.since.add_measurement(published, bytes);
    }

    /// Takes note of measurements that the node took and that could not be recorded.
    pub fn lost_measurement(&mut self) {
        self.since.add_lost_measurement();
    }

    /// The entry about a received message.
    pub fn received(endpoint: &Endpoint, bytes: &[u8], published: i64) -> JournalEntry {
        JournalEntry::Received {
            topic: endpoint.name.to_owned(),
            published,
            sha256: sha256_of(bytes),
        }
    }

    /// The next line of the journal, of this column of a fleet; `intake` is that of the measurements that were recorded before it,
    /// for a checkpoint.
    pub fn line(
        &self,
        entry: JournalEntry,
        column: Option<&str>,
        time: i64,
        intake: Option<IntakeState>,
    ) -> Result<Option<Entry>, JournalError> {
        let is_beginning = match &entry {
            // That of one column of a fleet says nothing of the others.
            JournalEntry::Twin(Journal::Checkpoint(_)) => column.is_none(),
            JournalEntry::Fleet { .. } => true,
            _ => false,
        };
        let about = is_beginning.then(|| self.about.clone());
        let since = self.since.tally();
        let line = JournalLine::new(entry, about, self.next_number, time, since, intake);
        let data = line.of_column(column).encode()?.into();
        Ok(self
            .message(&endpoints::JOURNAL, data, time, time)
            .map(|entry| Entry {
                checkpoint: is_beginning,
                ..entry
            }))
    }

    /// Takes note that the next line was recorded.
    pub fn recorded_line(&mut self) {
        self.next_number += 1;
        self.since = Counting::default();
    }
}
