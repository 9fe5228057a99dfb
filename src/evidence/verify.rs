//! Verifies a recording by recomputation.

use std::path::Path;
use std::sync::Arc;

use super::about::About;
use super::journal_line::{JournalEntry, JournalError, JournalLine};
use super::replayer::{RecordedBytes, Replayer};
use super::verification::Verification;
use crate::endpoints;
use crate::outgoing::Topic;
use crate::recording::{self, Reader, RecordingError};
use crate::twin::Output;

/// Why a recording cannot be verified.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording has no journal.
    #[error(
        "the recording has no topic {name} of type {type_name}, without which it cannot be recomputed; record with the \
         parameter record.mode of column-twin run, or with column-twin simulate --record",
        type_name = endpoints::JOURNAL.type_name,
        name = endpoints::JOURNAL.name
    )]
    NoJournal,
    /// The journal cannot be read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The journal has no checkpoint.
    #[error(
        "the journal of the recording has no checkpoint, from which a recomputation could start (the recording is \
         {wholeness}); verify the previous or the next recording"
    )]
    NoCheckpoint {
        /// Whether the recording is complete.
        wholeness: String,
    },
}

/// What an observer of a verification is shown, in the order of the recording.
#[derive(Debug)]
pub enum Observed<'a> {
    /// An entry of the journal.
    Entry(&'a JournalEntry),
    /// A state or a report that was recomputed.
    Recomputed(&'a Output),
}

/// Recomputes a recording, given by its directory or its MCAP file, and compares every value.
///
/// # Errors
/// The recording cannot be read, or has no journal that this program can read.
pub fn verify(path: &Path) -> Result<Verification, VerifyError> {
    verify_with(&Reader::open(path)?, Replayer::default(), &mut |_| ())
}

/// As [`verify`](fn@verify) of an open recording.
///
/// # Errors
/// As [`verify`](fn@verify).
pub fn verify_reader(reader: &Reader) -> Result<Verification, VerifyError> {
    verify_with(reader, Replayer::default(), &mut |_| ())
}

/// As [`verify`](fn@verify) of an open recording, and shows an observer the journal and what is recomputed from it: the
/// outputs that precede an entry first.
///
/// # Errors
/// As [`verify`](fn@verify).
pub fn verify_observed(
    reader: &Reader,
    observe: &mut dyn FnMut(Observed<'_>),
) -> Result<Verification, VerifyError> {
    verify_with(reader, Replayer::keeping_outputs(), observe)
}

fn verify_with(
    reader: &Reader,
    mut replayer: Replayer,
    observe: &mut dyn FnMut(Observed<'_>),
) -> Result<Verification, VerifyError> {
    let journal = reader
        .topics()
        .iter()
        .find(|it| recording::is_journal(it))
        .map(|it| Arc::clone(&it.name))
        .ok_or(VerifyError::NoJournal)?;
    let mut about: Option<About> = None;
    let mut early = [0_u64; Topic::COUNT];
    for message in reader.messages() {
        let message = message?;
        if *message.topic == *journal {
            let line = JournalLine::decode(&message.data)?;
            if let Some(found) = &line.about {
                about.get_or_insert_with(|| found.clone());
            }
            replayer.journal(&line.entry, &journal, message.log_time);
            show_outputs(&mut replayer, observe);
            observe(Observed::Entry(&line.entry));
            continue;
        }
        let Some(topic) = topic_of(about.as_ref(), &message.topic, &message.type_name) else {
            continue;
        };
        if about.is_none() {
            early[topic.index()] += 1;
            continue;
        }
        replayer.message(&RecordedBytes {
            topic,
            name: &message.topic,
            log_time: message.log_time,
            bytes: &message.data,
        });
        show_outputs(&mut replayer, observe);
    }
    let mut verification = replayer.finish();
    let wholeness = reader.wholeness();
    if verification.checkpoints == 0 {
        let wholeness = wholeness.to_string();
        return Err(VerifyError::NoCheckpoint { wholeness });
    }
    let early_messages: u64 = early.iter().sum();
    if early_messages > 0 {
        verification.note_unchecked(format!(
            "{early_messages} messages were recorded before the first checkpoint"
        ));
        for (check, count) in verification.topics.iter_mut().zip(early) {
            check.recorded += count;
            check.unchecked += count;
        }
    }
    verification.about = about;
    if !wholeness.is_whole() {
        verification.note_unchecked(format!("the recording is {wholeness}"));
    }
    let lost = reader.lost_messages().unwrap_or_default();
    verification.declared_losses = verification.declared_losses.saturating_add(lost);
    Ok(verification)
}

fn show_outputs(replayer: &mut Replayer, observe: &mut dyn FnMut(Observed<'_>)) {
    for output in &replayer.take_outputs() {
        observe(Observed::Recomputed(output));
    }
}

/// Finds the twin's topic for a recorded topic: by the names in the journal or, before its first checkpoint, by type and
/// name.
fn topic_of(about: Option<&About>, name: &str, type_name: &str) -> Option<Topic> {
    Topic::ALL.into_iter().find(|topic| {
        let endpoint = topic.endpoint();
        match about {
            Some(about) => about.topics.get(endpoint.name).is_some_and(|it| it == name),
            None => endpoint.type_name == type_name && name.ends_with(endpoint.name),
        }
    })
}
