//! The check of the sensors when they are commissioned: readings of a column that vibrates from ambient excitation or from a tap,
//! against what the model says about frequencies, signs and amplitudes. Nothing is changed by it: what fits better is told.
//!
//! `docs/commissioning.md` describes the method.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - check.rs: The check itself: faults that a sensor shows alone, then what it shows beside the others, then the stiffness of
//   the supports
// - expected.rs: What the model expects of the sensors: the modes of the column for every stiffness that its supports may have
// - explanation.rs: Which sensors contradict the others, and what would explain it
// - motion.rs: The vibration in recorded readings: its natural frequencies, and the amplitude of every sensor at each of them
// - stiffness.rs: The stiffness of the supports that fits the readings, with its uncertainty

mod check;
mod expected;
mod explanation;
mod motion;
mod stiffness;

pub use check::{CheckError, CheckedMode, CheckedSensor, SensorCheck, SensorFault, check_sensors};
pub use explanation::Explanation;
pub use stiffness::SupportStiffness;
