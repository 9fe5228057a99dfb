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
mod detection;
mod estimate;
mod estimate_record;
#[cfg(feature = "study")]
mod estimator;
#[cfg(feature = "study")]
mod hypothesis;
#[cfg(feature = "study")]
mod model_error;
#[cfg(feature = "study")]
mod population;
#[cfg(feature = "study")]
mod prediction;
mod probe;
#[cfg(feature = "study")]
mod random;
#[cfg(feature = "study")]
mod readings;
#[cfg(feature = "study")]
mod recorded;
mod sensor;
#[cfg(feature = "study")]
mod simulated;
mod standing_column;

pub use batch::Batch;
pub use detection::{Detection, Detector, Onset};
pub use estimate::{CredibleInterval, FEWEST_RESPONSES, ImpactEstimate};
pub use estimate_record::EstimateRecord;
#[cfg(feature = "study")]
pub use estimator::{Estimator, EstimatorError, UPDATE_INSTANTS};
#[cfg(feature = "study")]
pub use hypothesis::{Front, Hypothesis, hypotheses};
pub use probe::Probe;
#[cfg(feature = "study")]
pub use readings::{Readings, ReadingsError};
#[cfg(feature = "study")]
pub use recorded::{RecordedImpact, estimate_recorded};
pub use sensor::{MAX_SENSORS, Quantity, Sensor};
#[cfg(feature = "study")]
pub use simulated::simulate_sensors;
pub use standing_column::{Damage, StandingColumn};
