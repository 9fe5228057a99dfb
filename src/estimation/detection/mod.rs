//! Whether the readings show an impact.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - detector.rs: Finds impacts in the readings of the sensors
// - second_blow.rs: A second impact while the column still moves from the first one, which is told although it cannot be
//   estimated
// - sensing.rs: From live measurements to estimates: learns, detects an impact, and estimates it while data arrive
// - sway.rs: A column that sways, as in an earthquake or a storm, and was taken for one that is struck

pub(super) mod detector;
pub(super) mod second_blow;
pub(super) mod sensing;
pub(super) mod sway;
