//! Digital twin of a steel column hit by a vehicle.
pub mod column;
pub mod live;
pub mod messages;
pub mod parameters;
#[cfg(feature = "ros")]
pub mod ros;
pub mod twin;
