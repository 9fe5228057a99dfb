//! The samples of a study, on all processors.

use std::ops::Range;

use rayon::ThreadPoolBuildError;

use super::critical_speeds::CriticalSpeedSurface;
use super::departure::{Departure, DepartureSampler};
use super::evaluation::LimitState;
use super::measure::Measure;
use super::tally::{Basis, CONTROL_SHARES, Prediction, RiskSample, Tally};
use crate::study::{Batch, BatchEnd};

/// A study: vehicles that leave the road, and what decides how severe each of their impacts is.
#[derive(Debug)]
pub struct RiskStudy<'a, L> {
    sampler: &'a DepartureSampler,
    limit_state: &'a L,
    /// Predictions of the action; `None`: every response is computed.
    predictions: Option<&'a CriticalSpeedSurface>,
    /// A measure in front of the column.
    measure: Option<&'a Measure>,
}

impl<'a, L: LimitState> RiskStudy<'a, L> {
    /// A study that computes the response of every sample.
    #[must_use]
    pub fn new(sampler: &'a DepartureSampler, limit_state: &'a L) -> Self {
        Self {
            sampler,
            limit_state,
            predictions: None,
            measure: None,
        }
    }

    /// The same study, which computes the response where these predictions know nothing, and the audit share of the others.
    #[must_use]
    pub fn with_predictions(self, predictions: &'a CriticalSpeedSurface) -> Self {
        Self {
            predictions: Some(predictions),
            ..self
        }
    }

    /// The same study with the same vehicles, of which this measure stops some before the column.
    #[must_use]
    pub fn behind(self, measure: &'a Measure) -> Self {
        Self {
            measure: Some(measure),
            ..self
        }
    }

    /// The sample of this number with its action. A vehicle that a measure stops keeps the speed that it would have had at the
    /// column.
    #[must_use]
    pub fn sample(&self, index: u64) -> RiskSample {
        let mut departure = self.sampler.departure(index);
        if let Some(measure) = self.measure {
            let class = &self.sampler.scenario().classes[departure.class];
            let behind = measure.speed_behind(&departure, class);
            if behind == 0.0 {
                let basis = Basis::Stopped;
                return RiskSample { departure, basis };
            }
            departure.velocity = behind;
        }
        RiskSample {
            basis: self.basis(&departure),
            departure,
        }
    }

    fn basis(&self, departure: &Departure) -> Basis {
        if !departure.reaches_column() {
            return Basis::Stopped;
        }
        let predicted = self.predictions.and_then(|it| it.predict(departure));
        let predicted = predicted.map(|it| Prediction {
            doubt: self.limit_state.doubt(departure, it.doubt),
            ..it
        });
        if let Some(prediction) = predicted
            && departure.choice >= CONTROL_SHARES[prediction.doubt]
        {
            return Basis::Predicted(prediction);
        }
        match (predicted, self.limit_state.action(departure)) {
            // An audit sample that cannot be computed says nothing about the prediction, and counts among the computed ones.
            (_, None) => Basis::Undetermined,
            (None, Some(action)) => Basis::Computed(action),
            (Some(prediction), Some(computed)) => Basis::Control {
                prediction,
                computed,
            },
        }
    }

    /// Computes the samples of these numbers, counts them, and hands each to `sink`, in their order. After an interruption
    /// the samples that were finished without a gap are counted.
    ///
    /// # Errors
    /// The system gives no threads, or the first error of `sink`.
    pub fn run<E: From<ThreadPoolBuildError>>(
        &self,
        batch: &Batch,
        numbers: Range<u64>,
        mut sink: impl FnMut(&RiskSample) -> Result<(), E>,
    ) -> Result<(Tally, BatchEnd), E> {
        let mut tally = Tally::new(self.sampler);
        let count = numbers.end.saturating_sub(numbers.start);
        let end = batch.run(
            count,
            |index| self.sample(numbers.start + index),
            |samples| {
                for sample in &samples {
                    tally.add(sample);
                    sink(sample)?;
                }
                Ok::<(), E>(())
            },
        )?;
        Ok((tally, end))
    }
}

/// Why the samples of a study end early.
#[derive(Debug, thiserror::Error)]
pub enum StudyRunError {
    /// The system gives no threads.
    #[error("cannot start the threads of the study: {0}")]
    Threads(#[from] ThreadPoolBuildError),
    /// The samples cannot be written.
    #[error("cannot write the samples: {0}")]
    Write(#[from] std::io::Error),
}
