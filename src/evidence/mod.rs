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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - about.rs: The program that made a recording
// - activity.rs: Which columns of a fleet are in the middle of something that a recording must not be cut off in
// - background.rs: Computes again what a recorded twin was told by the thread in the background, once for columns that differ
//   by their names only
// - columns.rs: The columns of a recording, each of which is verified by itself: one of a single twin, many of a fleet
// - comparison.rs: Compares recorded with computed values field by field
// - definitions.rs: Compares the definitions of the types in a recording with those of this program
// - entry_encoder.rs: Encodes messages and journal entries as entries of a recording, and accounts for them in the lines of the
//   journal
// - estimates.rs: The estimates of a recording: each is a command in its journal, and is computed again from the recorded
//   measurements
// - fleet_recording.rs: What the recording of a fleet knows of its columns: where another recording may begin, and which
//   messages belong into it
// - fleet_statuses.rs: Compares the columns in `fleet_status` with their last recorded `twin_status`
// - forecasts.rs: The forecasts that a recording has to contain, and the messages that a forecast no longer holds or will never
//   be there
// - inputs.rs: Compares the messages that the node received with the journal: each one with the line that describes it, and
//   with the command that the twin was given
// - journal_line.rs: The recorded form of a journal entry: one line of JSON, with numbers that read back bit for bit
// - lines.rs: Checks the lines of the journal against the messages between them: numbers, times and counts
// - losses.rs: Weighs what is missing in a recording against the losses that it declares
// - measured.rs: The recorded measurements as the numbered batches that the estimator of the node was given
// - node_recording.rs: The recording of a running node
// - parameter_events.rs: Compares the messages on `/parameter_events` with the parameters of the recomputed twin
// - policy.rs: In what the recordings of the two kinds of nodes differ; all else is the same for both
// - replayed_twin.rs: A twin that repeats the recorded one, with what it gives out until the recorded messages are found
// - replayer.rs: Replays a recorded journal with a twin of its own, and compares the outputs with the recorded messages
// - selection.rs: What a recording has of what its node does: the policies of a single twin and of a fleet
// - simulated.rs: Records a simulated impact on an undamaged column as a node would record it, without ROS and faster than real
//   time
// - topics.rs: The topics of a recording
// - verification.rs: The result of a verification
// - verify.rs: Verifies a recording by recomputation

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
mod policy;
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
pub use topics::Topics;
pub use verification::{ColumnCheck, LEAST_SHARE, NOT_RECOMPUTED, TopicCheck, Verification};
pub use verify::{
    Observed, VerifyError, listed_columns, verify, verify_column, verify_observed, verify_reader,
};
