//! Recordings as evidence: what is recorded of the twin, and how a recording is verified by recomputation.
//!
//! A recording contains every message that the node sends, byte for byte, every event and set of parameters that it
//! receives, and on `~/journal` what recomputation needs: the exact state at rest with all parameters, and each command
//! with the position of the twin at that time, including rejected commands with their reason ([`JournalLine`], JSON in
//! `std_msgs/msg/String`). [`verify`](fn@verify) starts a twin from the journal, and compares its outputs with the
//! recorded messages.
//!
//! The recording of a fleet has one journal, whose lines name the columns; each column is verified by itself.
//!
//! [`NodeRecording`] records a running node; [`record_impact`] writes the same form of recording without ROS.

mod about;
mod activity;
mod background;
mod columns;
mod comparison;
mod definitions;
mod entry_encoder;
mod estimates;
mod fleet_recording;
mod fleet_statuses;
mod forecasts;
mod inputs;
mod journal_line;
mod lines;
mod losses;
mod measured;
mod node_recording;
mod parameter_events;
mod replayed_twin;
mod replayer;
mod selection;
mod simulated;
mod topics;
mod verification;
mod verify;

pub use about::{About, build, sha256_of_file};
pub use comparison::Difference;
pub use inputs::MAX_WAIT;
pub use journal_line::{
    JOURNAL_FORMAT, JOURNAL_VERSION, JournalEntry, JournalError, JournalLine, Tally,
};
pub use lines::{MAX_DELAY, MAX_LEAD};
pub use losses::LOSS_SHOWS_WITHIN;
pub use node_recording::{NodeRecording, WallClock};
pub use simulated::{RecordedImpact, SimulatedRecordingError, record_impact};
pub use topics::{RECORDED, RECORDED_OF_FLEET, Topics};
pub use verification::{ColumnCheck, LEAST_SHARE, NOT_RECOMPUTED, TopicCheck, Verification};
pub use verify::{Observed, VerifyError, verify, verify_column, verify_observed, verify_reader};
