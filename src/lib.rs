//! Digital twin of a steel column hit by a vehicle.
#[cfg(feature = "cli")]
pub mod cli;
pub mod column;
#[cfg(feature = "cli")]
pub mod figures;
pub mod live;
pub mod messages;
pub mod parameters;
pub mod twin;
#[cfg(feature = "cli")]
pub mod whole_file;
