//! The course of one response, computed from the instant at which the impact begins.

use crate::column::{
    ColumnProperties, ForceSpectrum, Model, Progress, Report, Response, Sample, State, StepError,
    residual_state,
};
use crate::figures::HistoryThinning;

/// A column on which an impact has just begun.
#[derive(Debug, Clone, Copy)]
pub struct Struck {
    /// The column; its lower bar ends at the impact point.
    pub model: Model,
    /// Its state, with what hits it.
    pub state: State,
    /// The response that has begun.
    pub response: Response,
}

/// The course of a response from its beginning to its end.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// The history, thinned to what figures need.
    pub samples: Vec<Sample>,
    pub report: Report,
    /// The response spectrum of the contact force, of every step; the thinned history has lost the short periods.
    pub spectrum: ForceSpectrum,
    /// The equilibrium that the response leaves behind, if there is one.
    pub settled: Option<State>,
}

impl Struck {
    /// Follows the response to its end, with its history.
    pub(super) fn course(&self) -> Result<Course, StepError> {
        // The length of the history is known after a first run, so that a history of any length fits in a bounded memory.
        let report = self.report()?;
        let mut thinning = HistoryThinning::new(report.steps, report.end_time);
        let mut spectrum = ForceSpectrum::default();
        let (report, settled) = self.follow(&mut |sample| {
            thinning.push(sample);
            spectrum.push(sample.time, sample.impulse);
        })?;
        Ok(Course {
            samples: thinning.finish(),
            report,
            spectrum,
            settled,
        })
    }

    /// The outcome alone.
    pub(super) fn report(&self) -> Result<Report, StepError> {
        let Self {
            model,
            mut state,
            mut response,
        } = *self;
        loop {
            if let Progress::Over(end) = response.advance(&model, &mut state, u64::MAX)? {
                return Ok(response.report(&model, &state, end));
            }
        }
    }

    fn follow(
        &self,
        observe: &mut dyn FnMut(&Sample),
    ) -> Result<(Report, Option<State>), StepError> {
        let Self {
            model,
            mut state,
            mut response,
        } = *self;
        observe(&state.sample(&model));
        loop {
            let progress = response.advance(&model, &mut state, u64::MAX)?;
            observe(&state.sample(&model));
            if let Progress::Over(end) = progress {
                let report = response.report(&model, &state, end);
                let stands = report.residual_v1.is_some();
                let settled = stands.then(|| residual_state(&model, &state)).flatten();
                return Ok((report, settled));
            }
        }
    }

    /// The same impact on a column with other properties, or `None` if they do not make a column.
    pub(super) fn with_properties(&self, properties: &ColumnProperties) -> Option<Self> {
        Some(Self {
            model: Model::new(properties).ok()?,
            ..*self
        })
    }
}
