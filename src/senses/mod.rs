//! The sensors on the column.

mod sensor;

pub use sensor::{MAX_SENSORS, Quantity, Sensor};
