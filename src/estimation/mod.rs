//! Sensors on the column: what they read, and what their readings say about an impact.
//!
//! A `Probe` is what the model says that a sensor reads. A `Detector` finds the impact in the readings. From there on
//! an `Estimator` compares what is measured with what many conceivable impacts, the hypotheses, would have let the
//! sensors read, and weighs them: the weighted responses are the estimate of the vehicle and of the outcome, with its
//! uncertainty. `docs/estimation.md` describes the method.
//!
//! The modules read no clock and no file, and the same readings give the same bits.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - detection/: Whether the readings show an impact
// - inference/: What the readings of an impact say about what struck the column and how it ends
// - intake/: Measurements, from single samples to batches in the order and on the clock of the twin
// - simulation/: What the model says that the sensors read, and what simulated sensors read

mod detection;
mod inference;
mod intake;
mod simulation;

pub use detection::detector::{Detection, Detector, Onset};
pub use detection::sensing::{Sensing, Work};
pub use inference::comparison::{ComparedMean, SensorComparison};
pub use inference::conceivable::ConceivedImpact;
pub use inference::estimate::{
    COLLAPSE_TOLD_FROM, CredibleInterval, FEWEST_RESPONSES, ImpactEstimate, MASS_OPEN_BEYOND,
    MOMENTUM_OPEN_BEYOND, VELOCITY_OPEN_BEYOND,
};
pub use inference::estimate_record::EstimateRecord;
pub use inference::estimator::{Estimator, EstimatorError, UNKNOWN_VEHICLE, UPDATE_INSTANTS};
pub use inference::event_evidence::{EventEvidence, MAX_EVENTS};
pub use inference::hypothesis::{Front, Hypothesis, hypotheses};
pub use inference::library::Library;
pub use inference::recomputation::{NotRecomputed, Recomputation, SharedPreparations};
pub use inference::recorded::{RecordedImpact, estimate_prepared, estimate_recorded};
pub use intake::batch::Batch;
pub use intake::collector::{BATCH_DURATION, Collected, Collector};
pub use intake::measurement_intake::{
    BELIEVED, BatchRejection, Intake, IntakeState, MAX_BATCH_SAMPLES, MAX_CLOCK_ERROR, MAX_JITTER,
    PERIOD_TOLERANCE, RawBatch, SILENCE, SensorCondition, SensorCounts, SensorHealth, Strays,
};
pub use intake::readings::{Readings, ReadingsError};
pub use intake::sensor_clock::TOLERATED_OFFSET;
pub use simulation::predicted::{AVERAGED_OVER, predicted_means};
pub use simulation::probe::Probe;
pub use simulation::simulated::{simulate_sensors, with_sensor_errors};
