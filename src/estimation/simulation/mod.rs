//! What the model says that the sensors read, and what simulated sensors read.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - predicted.rs: What one impact lets the sensors read, to be seen beside what they have read
// - probe.rs: What the model says that a sensor reads
// - simulated.rs: What sensors read in a simulated impact, with their errors

pub(super) mod predicted;
pub(super) mod probe;
pub(super) mod simulated;
