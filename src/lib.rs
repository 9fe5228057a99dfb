//! Digital twin of a steel column hit by a vehicle.
pub mod column;
#[cfg(feature = "cli")]
pub mod figures;
#[cfg(feature = "cli")]
pub mod whole_file;
