//! A sensor as a thing on the column: what it measures, where, and how well. What its readings say is in
//! [`senses`](crate::senses).
//!
//! `sensor.rs` is the sensor and the quantities that there are.

mod sensor;

pub use sensor::{MAX_SENSORS, NotAQuantity, Quantity, Sensor};
