#![doc = include_str!("../README.md")]

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - bag_metadata.rs: `metadata.yaml` of a recording, version 9, as rosbag2 writes it (`rosbag2_storage/yaml.hpp`)
// - bounded_yaml.rs: YAML from recordings of unknown origin
// - chain.rs: The hash chain over the content of a recording, in the order of the file
// - compression.rs: How the chunks of a recording are compressed, and how much of them is unpacked
// - declared.rs: Schemas and channels as a file declares them, compared by hashes: a file may declare thousands of channels
//   with one long schema, and each of them takes a time that depends on its own length only
// - decode.rs: Decodes messages of any type by the definition that the recording holds
// - definition.rs: The definitions that a recording holds of its types
// - described.rs: Topics with all their texts in the file
// - error.rs: The errors of recordings, each with what to do next
// - files.rs: The files of a recording
// - index_check.rs: Checks that a sealed file leads every reader to the sealed messages and to nothing else
// - keys.rs: Keys of the metadata of a channel, which writer and reader share
// - names.rs: Names of recordings: `recording_2026_11_21-07_40_00`, UTC, with the time format of rosbag2
// - notes.rs: The metadata records of a recording: what its recorder, or a repair, notes about it
// - predecessor.rs: The recording before a sealed one
// - reader.rs: Reads recordings of this crate and of other writers, whole or cut off
// - recorder.rs: The recorder: a thread with a bounded queue in front of it, so that the sender of a message never waits for a
//   disk
// - records.rs: The records of an MCAP file, one after the other (<https://mcap.dev/spec>), also of a damaged one: a record or
//   chunk that cannot be read is reported and left out, and reading goes on behind it
// - reordering.rs: Sorts messages by time while holding only those that are out of order
// - repair.rs: Repairs a recording that was cut off or damaged by writing a new one
// - report.rs: Reports of what happens to a recorder
// - retention.rs: Deletes old recordings to keep within the limits
// - seal.rs: Seals: what a writer adds to a recording so that later changes can be detected
// - seal_check.rs: Checks the seal of a recording while it is read
// - seal_key.rs: Ed25519 keys of seals
// - session.rs: What a recorder does with each message
// - startup.rs: What a recorder does at its start with the recordings that a crash has cut off
// - statistics.rs: The state of a recorder
// - storage.rs: The file of a recording
// - syncing.rs: Makes data survive a loss of power, in a separate thread, because a disk may need half a second for it
// - table.rs: Messages as rows of a table: the elements of a fixed array become columns, and so do those of a bounded sequence
//   of numbers or texts, with empty cells where it is shorter than its bound; any other sequence becomes one cell
// - topic.rs: A topic of a recording and its quality of service, in the terms of rosbag2
// - value.rs: The values of a decoded message
// - wholeness.rs: Whether a recording is whole, or cut off and damaged
// - writer.rs: Writes one recording

mod bag_metadata;
mod bounded_yaml;
mod chain;
mod compression;
mod declared;
mod decode;
mod definition;
mod described;
mod error;
mod files;
mod index_check;
mod keys;
mod names;
mod notes;
mod predecessor;
mod reader;
mod recorder;
mod records;
mod reordering;
mod repair;
mod report;
mod retention;
mod seal;
mod seal_check;
mod seal_key;
mod session;
mod startup;
mod statistics;
mod storage;
mod syncing;
mod table;
mod topic;
mod value;
mod wholeness;
mod writer;

pub use compression::ChunkCompression;
pub use decode::Decoder;
pub use error::RecordingError;
pub use names::{directory_name, directory_time};
pub use predecessor::Predecessor;
pub use reader::{Message, Messages, Reader, RecordedTopic};
pub use recorder::{Recorder, RecorderHandle};
pub use records::MAX_CHUNK;
pub use reordering::MAX_OUT_OF_ORDER;
pub use repair::{Repaired, repair};
pub use report::{RecorderReport, ReportLevel};
pub use seal::PreviousRecording;
pub use seal_check::Seal;
pub use seal_key::{PublicKey, SealKey};
pub use session::{OnReport, RecorderOptions, Session};
pub use statistics::{QueueStatistics, RecorderStatistics};
pub use topic::{OfferedQos, TopicInfo};
pub use value::Decoded;
pub use wholeness::Wholeness;
pub use writer::{Entry, FLUSH_WITHIN, Finished, Writer, WriterOptions};
