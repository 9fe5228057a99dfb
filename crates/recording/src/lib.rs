//! Recordings: MCAP files in the layout of rosbag2, which every ROS tool reads, which survive a crash, and which replay.
//!
//! A recording is a directory: `metadata.yaml` and one MCAP file. [`Writer`] writes one, [`Recorder`] writes them one after
//! the other in a thread of its own, [`Reader`] reads ours and those of others, [`repair`](fn@repair) writes one anew that
//! was cut off. Times are nanoseconds since 1970, or of the simulated clock. Message bytes are those on the wire:
//! encapsulation header, then CDR.
//!
//! What holds for a recording of ours:
//! - Whatever ends the program, all but the last [`FLUSH_WITHIN`] are in the file, and the file ends with a whole record.
//! - `metadata.yaml` is there if, and only if, the recording was finished.
//! - It begins with a [checkpoint](Entry::checkpoint) wherever one was recorded, so that it needs no other.
//! - What is missing is counted, and the count stands in the file.
//!
//! Reading trusts nothing: no length, no index, no order. Its memory is bounded by [`MAX_CHUNK`] and the size of what is
//! out of order, [`MAX_OUT_OF_ORDER`].

mod bag_metadata;
mod compression;
mod decode;
mod error;
mod names;
mod reader;
mod recorder;
mod records;
mod reordering;
mod repair;
mod report;
mod retention;
mod session;
mod statistics;
mod storage;
mod syncing;
mod table;
mod topic;
mod writer;

pub use compression::ChunkCompression;
pub use decode::{Decoded, Decoder};
pub use error::RecordingError;
pub use names::{directory_name, directory_time};
pub use reader::{MAX_OUT_OF_ORDER, Message, Messages, Reader, RecordedTopic, Wholeness};
pub use recorder::{Recorder, RecorderHandle};
pub use records::MAX_CHUNK;
pub use repair::{Repaired, repair};
pub use report::{RecorderReport, ReportLevel};
pub use session::{RecorderOptions, Telling};
pub use statistics::{QueueStatistics, RecorderStatistics};
pub use topic::{OfferedQos, TopicInfo};
pub use writer::{Entry, FLUSH_WITHIN, Finished, Writer, WriterOptions};
