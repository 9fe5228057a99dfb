//! A sensor as a thing on the column: what it measures, where, and how well. What its readings say is in
//! [`estimation`](crate::estimation).
//!
//! `sensor.rs` is the sensor and the quantities that there are.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - sensor.rs: A sensor on the column: what it measures, where, and how well

mod sensor;

pub use sensor::{MAX_SENSORS, NotAQuantity, Quantity, Sensor};
