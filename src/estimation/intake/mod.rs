//! Measurements, from single samples to batches in the order and on the clock of the twin.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - batch.rs: Consecutive samples of one sensor, as the intake of measurements passes them on
// - collector.rs: Collects the samples of a sensor that sends each in a message of its own
// - measurement_intake.rs: Takes the measurements of all sensors: checks every batch, brings it into the order and the clock of
//   the twin, and counts what is missing
// - readings.rs: Recorded readings of sensors, as a table in a CSV file
// - sensor_clock.rs: The clock of a sensor against the clock that drives the twin
// - stillness.rs: Whether a sensor that sends is stuck: it repeats one value for longer than its noise allows

pub(super) mod batch;
pub(super) mod collector;
pub(super) mod measurement_intake;
pub(super) mod readings;
pub(super) mod sensor_clock;
pub(super) mod stillness;
