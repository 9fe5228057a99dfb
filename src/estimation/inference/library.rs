//! The responses to conceivable impacts that are prepared for one column at rest, and for all columns that are equal to it.

use std::sync::Arc;

use crate::estimation::inference::estimator::{Estimator, EstimatorError};
use crate::estimation::inference::hypothesis::hypotheses;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Seed of the random numbers, the same for every impact.
pub(crate) const SEED: u64 = 1;

/// Prepared responses. A copy shares them until one of the two is carried on.
#[derive(Debug, Clone)]
pub struct Library {
    sensors: Arc<[Sensor]>,
    column: Arc<StandingColumn>,
    estimator: Arc<Estimator>,
}

impl Library {
    /// Nothing is prepared yet for this column at rest with the sensors of its parameters.
    ///
    /// # Errors
    /// No sensors, none that is fast enough to detect an impact, or parameters that make no column.
    pub fn new(parameters: &Parameters, column: StandingColumn) -> Result<Self, EstimatorError> {
        let sensors = corrected_sensors(parameters);
        EstimatorError::unless_fast_enough(&sensors)?;
        Ok(Self {
            estimator: Arc::new(estimator_of(parameters, &column, &sensors)?),
            sensors: sensors.into(),
            column: Arc::new(column),
        })
    }

    /// Computes or assesses one more response, some milliseconds of work; returns whether everything is prepared.
    pub fn prepare_one(&mut self) -> bool {
        Arc::make_mut(&mut self.estimator).prepare_one()
    }

    /// The hypotheses whose responses are prepared.
    #[must_use]
    pub fn prepared(&self) -> usize {
        self.estimator.prepared()
    }

    /// Bytes that it takes when everything is prepared, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.estimator.bytes_when_prepared()
    }

    pub(crate) fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    pub(crate) fn column(&self) -> &StandingColumn {
        &self.column
    }

    pub(crate) fn estimator(&self) -> &Arc<Estimator> {
        &self.estimator
    }
}

/// The sensors of the parameters, as they are in batches: with corrected signs.
pub(crate) fn corrected_sensors(parameters: &Parameters) -> Vec<Sensor> {
    let correct = |sensor| Sensor {
        reversed: false,
        ..sensor
    };
    parameters.sensors().into_iter().map(correct).collect()
}

/// The estimator of live measurements.
pub(crate) fn estimator_of(
    parameters: &Parameters,
    column: &StandingColumn,
    sensors: &[Sensor],
) -> Result<Estimator, EstimatorError> {
    let hypotheses = hypotheses(parameters);
    Estimator::new(parameters, column, sensors.to_vec(), hypotheses, SEED)
}
