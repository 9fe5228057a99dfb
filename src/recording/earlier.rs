//! Recordings of earlier versions, whose messages belong to another package.

use std::path::Path;

use super::{Reader, RecordedTopic, RecordingError};

/// What the types of our messages began with before they were a package of their own.
const EARLIER_PACKAGE: &str = "column_twin/";

/// Whether the messages of a topic are those of an earlier version. Their names, fields and order may be others.
#[must_use]
pub fn is_of_earlier_version(topic: &RecordedTopic) -> bool {
    topic.type_name.starts_with(EARLIER_PACKAGE)
}

/// Checks that a recording is none of an earlier version, whose messages this program cannot use.
///
/// # Errors
/// It is one; the error says what to do with it.
pub fn check_version(reader: &Reader) -> Result<(), RecordingError> {
    let Some(topic) = reader.topics().iter().find(|it| is_of_earlier_version(it)) else {
        return Ok(());
    };
    let path = reader.path();
    Err(RecordingError::OtherProgram {
        path: path.to_path_buf(),
        reason: format!(
            "an earlier version recorded it, whose messages ({}) this version does not read; use the program that recorded it, or \
             read the numbers with: column-twin export {} --csv",
            topic.type_name,
            path.display()
        ),
    })
}

/// Opens a recording whose messages this program uses: not one of an earlier version.
///
/// # Errors
/// The recording cannot be read, or is one of an earlier version.
pub fn open(path: &Path) -> Result<Reader, RecordingError> {
    let reader = Reader::open(path)?;
    check_version(&reader)?;
    Ok(reader)
}
