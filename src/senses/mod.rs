//! Sensors on the column: what they read, and what their readings say about an impact.
//!
//! A [`Probe`] is what the model says that a sensor reads. A [`Detector`] finds the impact in the readings. From there on
//! an [`Estimator`] compares what is measured with what many conceivable impacts, the [`Hypothesis`]es, would have let the
//! sensors read, and weighs them: the weighted responses are the estimate of the vehicle and of the outcome, with its
//! uncertainty. `docs/estimation.md` describes the method.
//!
//! The modules read no clock and no file, and the same readings give the same bits.

mod blocks;
mod detection;
mod estimate;
mod estimator;
mod hypothesis;
mod model_error;
mod population;
mod prediction;
mod probe;
mod random;
mod readings;
mod recorded;
mod sensor;
mod simulated;

pub use blocks::{Block, BlockMean, Blocks};
pub use detection::{Detection, Detector, Onset};
pub use estimate::{ImpactEstimate, CredibleInterval};
pub use estimator::{Estimator, EstimatorError, UPDATE_INSTANTS};
pub use hypothesis::{Front, Hypothesis, hypotheses};
pub use probe::Probe;
pub use readings::{Readings, ReadingsError};
pub use recorded::{RecordedImpact, estimate_recorded};
pub use sensor::{Quantity, Sensor};
pub use simulated::simulate_sensors;
