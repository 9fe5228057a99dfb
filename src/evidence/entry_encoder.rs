//! Encodes messages and journal entries as entries of a recording.

use std::sync::Arc;

use super::about::About;
use super::journal_line::{JournalEntry, JournalError, JournalLine};
use super::topics::Topics;
use crate::endpoints::{self, Endpoint};
use crate::recording::Entry;
use crate::twin::Journal;

/// Encodes messages and journal entries for a recording.
#[derive(Debug)]
pub(super) struct EntryEncoder {
    about: About,
}

impl EntryEncoder {
    pub fn new(topics: &Topics) -> Self {
        Self {
            about: About::this_program(topics.by_endpoint()),
        }
    }

    /// A message; `None` if its topic is not recorded.
    pub fn message(
        endpoint: &Endpoint,
        data: Arc<[u8]>,
        log_time: i64,
        publish_time: i64,
    ) -> Option<Entry> {
        Some(Entry {
            topic: Topics::index_of(endpoint)?,
            log_time,
            publish_time,
            data,
            checkpoint: false,
        })
    }

    /// An entry of the twin's journal.
    pub fn journal(&self, entry: &Journal, time: i64) -> Result<Option<Entry>, JournalError> {
        let about = matches!(entry, Journal::Checkpoint(_)).then(|| self.about.clone());
        let line = JournalLine::new(JournalEntry::Twin(entry.clone()), about);
        Self::line(&line, time)
    }

    /// A line of the journal.
    pub fn line(line: &JournalLine, time: i64) -> Result<Option<Entry>, JournalError> {
        let data = line.encode()?.into();
        Ok(
            Self::message(&endpoints::JOURNAL, data, time, time).map(|entry| Entry {
                checkpoint: line.is_checkpoint(),
                ..entry
            }),
        )
    }
}
