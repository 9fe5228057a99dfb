//! The crate `rosbag2_mcap` with the names, message definitions and parameters of this program.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - completeness.rs: Whether anything is missing in a recording, in words
// - earlier.rs: Recordings of earlier versions, whose messages belong to another package
// - event_summary.rs: The impacts in a recording
// - instant.rs: Times of a recording for people
// - seal_finding.rs: What the seal of a recording proves, in words

mod completeness;
mod earlier;
mod event_summary;
mod instant;
mod seal_finding;

use std::path::Path;
use std::time::{Duration, SystemTime};

pub use rosbag2_mcap::*;

use crate::endpoints::{JOURNAL, Qos};
use crate::messages::{self, INTERFACES, type_hash::TypeHash};
use crate::parameters::{Compression, RecordSettings};
use crate::state_home;
pub use completeness::incompleteness;
pub use earlier::{check_version, is_of_earlier_version, open};
pub use event_summary::{EventSummary, summarise_events};
pub use instant::instant;
pub use seal_finding::{SealFinding, public_key};

/// The names of recordings of this program, and of the metadata records in them, begin with this.
pub const APPLICATION: &str = "column_twin";

/// A topic whose messages have one of our [types](INTERFACES).
///
/// # Errors
/// The type is unknown.
pub fn topic(name: &str, type_name: &str, qos: OfferedQos) -> Result<TopicInfo, RecordingError> {
    let schema_error = |reason: String| RecordingError::Schema {
        topic: name.to_owned(),
        type_name: type_name.to_owned(),
        reason,
    };
    let interface = messages::find(type_name).ok_or_else(|| {
        schema_error(
            "this program does not define this type; add its definition to msg/deps".to_owned(),
        )
    })?;
    let schema = interface.schema_text(INTERFACES);
    let hash = TypeHash::of(interface, INTERFACES);
    Ok(TopicInfo {
        name: name.to_owned(),
        type_name: type_name.to_owned(),
        schema: schema.map_err(|error| schema_error(error.to_string()))?,
        type_hash: hash
            .map_err(|error| schema_error(error.to_string()))?
            .to_string(),
        qos,
    })
}

/// Checks that a recording defines the type of a topic as this program does, so that
/// [`cdr::decode`](messages::cdr::decode) decodes its messages correctly.
///
/// # Errors
/// This program does not define the type, or defines other fields, field types or constants; the error names the first
/// difference.
pub fn check_definition(of: &RecordedTopic) -> Result<(), RecordingError> {
    let unused = OfferedQos {
        reliable: true,
        transient_local: false,
        depth: 1,
    };
    of.check_definition(&topic(&of.name, &of.type_name, unused)?.schema)
}

/// Whether a topic is the journal of a twin, for any name of the node.
#[must_use]
pub fn is_journal(topic: &RecordedTopic) -> bool {
    let name = JOURNAL.name.trim_start_matches('~');
    *topic.type_name == *JOURNAL.type_name && topic.name.ends_with(name)
}

/// The options with which this program writes a recording.
#[must_use]
pub fn writer_options(compression: Compression) -> WriterOptions {
    let notes = [
        ("program", "column-twin"),
        ("version", env!("CARGO_PKG_VERSION")),
    ];
    WriterOptions {
        application: APPLICATION.to_owned(),
        compression: compression.into(),
        notes: notes
            .map(|(name, note)| (name.to_owned(), note.to_owned()))
            .into(),
        ..WriterOptions::default()
    }
}

/// The key with which the parameters `record.seal` and `record.seal_key` ask to seal recordings.
///
/// # Errors
/// The file of the key cannot be used, or the system provides no random numbers for a fresh key.
pub fn seal_key(record: &RecordSettings) -> Result<Option<SealKey>, RecordingError> {
    let key = || match record.seal_key.as_str() {
        "" => SealKey::fresh(),
        path => SealKey::read(Path::new(path)),
    };
    record.seal.then(key).transpose()
}

/// The options that the parameters `record.*` ask for; `started` is the current time.
///
/// # Errors
/// As [`seal_key`].
pub fn recorder_options(
    record: &RecordSettings,
    started: SystemTime,
) -> Result<RecorderOptions, RecordingError> {
    let seconds = |value: f64| (value > 0.0).then(|| Duration::from_secs_f64(value));
    let number = |value: u64| (value > 0).then_some(value);
    let WriterOptions {
        application, notes, ..
    } = writer_options(record.compression);
    Ok(RecorderOptions {
        application,
        notes,
        seal: seal_key(record)?,
        compression: record.compression.into(),
        sync: record.sync,
        max_file_size: record.max_file_size,
        max_duration: seconds(record.max_duration),
        max_files: number(record.max_files),
        max_total_size: number(record.max_total_size),
        max_age: seconds(record.max_age),
        ..RecorderOptions::new(state_home::resolve(&record.directory), started)
    })
}

/// The text of an error, with the parameter that can be changed to avoid it.
#[must_use]
pub fn with_parameter(error: &RecordingError) -> String {
    match error {
        RecordingError::Directory { .. } => format!("{error} with the parameter record.directory"),
        RecordingError::BadKey { .. } => format!("{error}; the parameter record.seal_key names it"),
        other => other.to_string(),
    }
}

impl From<&Qos> for OfferedQos {
    fn from(qos: &Qos) -> Self {
        Self {
            reliable: qos.reliable,
            transient_local: qos.transient_local,
            depth: qos.depth,
        }
    }
}

impl From<Compression> for ChunkCompression {
    fn from(compression: Compression) -> Self {
        match compression {
            Compression::None => Self::None,
            Compression::Lz4 => Self::Lz4,
            Compression::Zstd => Self::Zstd,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;

    #[test]
    fn default_parameters_become_recorder_options() {
        let parameters = Parameters::default();
        let record = &parameters.settings().record;
        let options = recorder_options(record, SystemTime::UNIX_EPOCH).expect("a fresh key");
        // In whichever state folder these tests run.
        assert_eq!(
            options.directory,
            state_home::resolve("$XDG_STATE_HOME/column_twin/recordings")
        );
        assert_eq!(
            (options.max_file_size, options.max_files),
            (1_000_000_000, Some(100))
        );
        assert_eq!(
            (options.max_duration, options.max_age),
            (Some(Duration::from_secs(3600)), None)
        );
        assert_eq!((options.max_total_size, options.sync), (None, true));
        assert!(options.seal.is_some_and(|key| key.is_fresh()));
    }
}
