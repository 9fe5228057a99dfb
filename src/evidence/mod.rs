//! Recordings as evidence: what of the twin is recorded, and the proof by recomputation that the numbers are what the
//! model gives.
//!
//! Recorded is every message that the node sends, byte for byte, every event and set of parameters that it receives, and
//! on `~/journal` what recomputing needs: the exact state at rest with all parameters, each input with how far the twin
//! had come, the refused ones with their reason ([`Line`], JSON in `std_msgs/msg/String`). [`verify`](fn@verify) makes
//! a twin of it, and compares what that gives out with what was recorded.
//!
//! [`NodeRecording`] is the node's side, [`record_impact`] writes the same without any ROS.

mod about;
mod comparison;
mod entries;
mod journal_line;
#[cfg(feature = "ros")]
mod node_recording;
mod replayer;
mod simulated;
mod topics;
mod verification;

pub use about::{About, build};
pub use comparison::Difference;
pub use journal_line::{JOURNAL_FORMAT, JOURNAL_VERSION, JournalError, Line, LineEntry};
#[cfg(feature = "ros")]
pub use node_recording::NodeRecording;
pub use simulated::{RecordedImpact, SimulatedRecordingError, record_impact};
pub use topics::{RECORDED, Topics};
pub use verification::{TopicCheck, Verification, VerifyError, verify};
