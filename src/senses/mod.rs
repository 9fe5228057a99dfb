//! Sensors on the column: what they read, and what their readings say about an impact.
//!
//! A `Probe` is what the model says that a sensor reads. A `Detector` finds the impact in the readings. From there on
//! an `Estimator` compares what is measured with what many conceivable impacts, the hypotheses, would have let the
//! sensors read, and weighs them: the weighted responses are the estimate of the vehicle and of the outcome, with its
//! uncertainty. `docs/estimation.md` describes the method.
//!
//! The modules read no clock and no file, and the same readings give the same bits. Without the feature `study` there are only
//! the sensors, what the model says that they read, detection, and estimates as data.

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
