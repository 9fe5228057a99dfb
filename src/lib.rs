//! Digital twin of a steel column hit by a vehicle.
pub mod column;
pub mod live;
pub mod messages;
pub mod parameters;
pub mod twin;
