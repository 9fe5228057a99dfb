//! Digital twin of a steel column hit by a vehicle.
#[cfg(feature = "cli")]
pub mod cli;
pub mod column;
#[cfg(feature = "cli")]
pub mod figures;
pub mod messages;
pub mod parameters;
#[cfg(feature = "cli")]
pub mod whole_file;
