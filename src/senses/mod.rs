//! Sensors on the column: what they read, and what their readings say about an impact.
//!
//! A `Probe` is what the model says that a sensor reads. A `Detector` finds the impact in the readings. From there on
//! an `Estimator` compares what is measured with what many conceivable impacts, the hypotheses, would have let the
//! sensors read, and weighs them: the weighted responses are the estimate of the vehicle and of the outcome, with its
//! uncertainty. `docs/estimation.md` describes the method.
//!
//! The modules read no clock and no file, and the same readings give the same bits. Without the feature `study` there are only
//! the sensors, what the model says that they read, detection, and estimates as data.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - batch.rs: Consecutive samples of one sensor, as the intake of measurements passes them on
// - blocks.rs: Readings averaged over blocks of time that grow with the time after contact
// - collector.rs: Collects the samples of a sensor that sends each in a message of its own
// - comparison.rs: What each sensor has read, against what the weighted responses say that it reads
// - contradiction.rs: Sensors that contradict each other
// - detection.rs: Finds impacts in the readings of the sensors
// - estimate.rs: An estimate: what struck the column and how it ends, with its uncertainty
// - estimate_record.rs: An estimate together with what made it so
// - estimator.rs: From readings to estimates
// - event_evidence.rs: What an event says about an impact that the sensors have detected: another witness, such as a camera or
//   a person
// - hypothesis.rs: What may have struck the column, before anything is measured
// - intake.rs: Takes the measurements of all sensors: checks every batch, brings it into the order and the clock of the twin,
//   and counts what is missing
// - lanes.rs: Numbers of several sensors side by side, with which the processor calculates at once
// - library.rs: The responses to conceivable impacts that are prepared for one column at rest, and for all columns that are
//   equal to it
// - member.rs: One response among those that are weighed: its likelihood by the data
// - model_error.rs: How far the model may be from the column: its own error, beside the noise of the sensors
// - population.rs: Weighted responses: adaptive multiple importance sampling over what may have struck the column
// - predicted.rs: What one impact lets the sensors read, to be seen beside what they have read
// - prediction.rs: What one conceivable impact would have let the sensors read, and how it would have ended
// - probe.rs: What the model says that a sensor reads
// - readings.rs: Recorded readings of sensors, as a table in a CSV file
// - recomputation.rs: Estimates computed again from recorded measurements
// - recorded.rs: Estimates from recorded readings: the same detection and the same updates as with live ones
// - sensing.rs: From live measurements to estimates: learns, detects an impact, and estimates it while data arrive
// - sensor_clock.rs: The clock of a sensor against the clock that drives the twin
// - simulated.rs: What sensors read in a simulated impact, with their errors
// - stillness.rs: Whether a sensor that sends is stuck: it repeats one value for longer than its noise allows
// - undamaged_capacities.rs: Residual capacity of the undamaged column, for any yield strength near the given one
// - update.rs: The work on an estimate in slices of a few milliseconds, so that a thread can take new data between them
// - weighing.rs: What the likelihood of every response needs of the data: block means with their precisions, and where the
//   blocks are in the predictions

mod batch;
#[cfg(feature = "study")]
mod blocks;
mod collector;
#[cfg(feature = "study")]
mod comparison;
#[cfg(feature = "study")]
mod contradiction;
mod detection;
mod estimate;
mod estimate_record;
#[cfg(feature = "study")]
mod estimator;
mod event_evidence;
#[cfg(feature = "study")]
mod hypothesis;
mod intake;
#[cfg(feature = "study")]
mod lanes;
#[cfg(feature = "study")]
mod library;
#[cfg(feature = "study")]
mod member;
#[cfg(feature = "study")]
mod model_error;
#[cfg(feature = "study")]
mod population;
#[cfg(feature = "study")]
mod predicted;
#[cfg(feature = "study")]
mod prediction;
mod probe;
#[cfg(feature = "study")]
mod readings;
#[cfg(feature = "study")]
mod recomputation;
#[cfg(feature = "study")]
mod recorded;
#[cfg(feature = "study")]
mod sensing;
mod sensor_clock;
#[cfg(feature = "study")]
mod simulated;
mod stillness;
#[cfg(feature = "study")]
mod undamaged_capacities;
#[cfg(feature = "study")]
mod update;
#[cfg(feature = "study")]
mod weighing;

pub use batch::Batch;
pub use collector::{BATCH_DURATION, Collected, Collector};
#[cfg(feature = "study")]
pub use comparison::{ComparedMean, SensorComparison};
pub use detection::{Detection, Detector, Onset};
pub use estimate::{CredibleInterval, FEWEST_RESPONSES, ImpactEstimate};
pub use estimate_record::EstimateRecord;
#[cfg(feature = "study")]
pub use estimator::{Estimator, EstimatorError, UPDATE_INSTANTS};
pub use event_evidence::{EventEvidence, MAX_EVENTS};
#[cfg(feature = "study")]
pub use hypothesis::{Front, Hypothesis, hypotheses};
pub use intake::{
    BELIEVED, BatchRejection, Intake, IntakeState, MAX_BATCH_SAMPLES, MAX_CLOCK_ERROR, MAX_JITTER,
    PERIOD_TOLERANCE, RawBatch, SILENCE, SensorCondition, SensorCounts, SensorHealth, Strays,
};
#[cfg(feature = "study")]
pub use library::Library;
#[cfg(feature = "study")]
pub use predicted::{AVERAGED_OVER, predicted_means};
pub use probe::Probe;
#[cfg(feature = "study")]
pub use readings::{Readings, ReadingsError};
#[cfg(feature = "study")]
pub use recomputation::{NotRecomputed, Recomputation, SharedPreparations};
#[cfg(feature = "study")]
pub use recorded::{RecordedImpact, estimate_recorded};
#[cfg(feature = "study")]
pub use sensing::{Sensing, Work};
pub use sensor_clock::TOLERATED_OFFSET;
#[cfg(feature = "study")]
pub use simulated::{simulate_sensors, with_sensor_errors};
