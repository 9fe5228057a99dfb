//! One impact with everything that the report needs of it.

use std::sync::Arc;

use crate::column::{ColumnProperties, Impact, Report, Sample, SimulationError, respond};
use crate::figures::ResponseHistory;
use crate::parameters::Parameters;
use crate::twin::{Lengths, Nanos};

/// One impact with everything that the report needs of it.
#[derive(Debug, Clone)]
pub struct ReportedImpact {
    /// One line that describes column and impact.
    pub title: String,
    /// Identifier and stamp of the event; `None` for a simulation.
    pub event: Option<(String, Nanos)>,
    /// The parameters that held.
    pub parameters: Arc<Parameters>,
    /// The column that was hit; its lower bar ends at the impact point.
    pub properties: ColumnProperties,
    /// What hit it.
    pub impact: Impact,
    /// The history, possibly thinned.
    pub samples: Vec<Sample>,
    /// The outcome.
    pub report: Report,
    /// Relative difference of the largest `v1` from that of a run with half the step; `None`: not computed.
    pub error_estimate: Option<f64>,
}

impl ReportedImpact {
    /// The impact that `parameters` describe on a virgin column, with its history and outcome.
    #[must_use]
    pub fn simulated(
        title: &str,
        parameters: &Parameters,
        samples: Vec<Sample>,
        report: Report,
    ) -> Self {
        Self {
            title: title.to_owned(),
            event: None,
            parameters: Arc::new(parameters.clone()),
            properties: parameters.column_properties(),
            impact: parameters.impact(),
            samples,
            report,
            error_estimate: None,
        }
    }

    /// The same impact, simulated on a virgin column, with the error of its step estimated by a second run.
    ///
    /// # Errors
    /// The second run fails.
    pub fn with_error_estimate(self) -> Result<Self, SimulationError> {
        let halved = ColumnProperties {
            step_nanos: (self.properties.step_nanos / 2).max(1),
            ..self.properties
        };
        let finer = respond(&halved, &self.impact, self.parameters.response_duration())?;
        let scale = finer.max_v1.abs().max(f64::MIN_POSITIVE);
        Ok(Self {
            error_estimate: Some((self.report.max_v1 - finer.max_v1).abs() / scale),
            ..self
        })
    }

    /// The history for the figures.
    #[must_use]
    pub fn history(&self) -> ResponseHistory<'_> {
        ResponseHistory {
            title: &self.title,
            samples: &self.samples,
            report: &self.report,
            yield_surface: self.properties.yield_surface,
            resistance_moment: self.properties.resistance_moment,
            resistance_axial: self.properties.resistance_axial,
            lengths: Lengths {
                below: self.properties.length_below,
                above: self.properties.length_above,
            },
            vehicle: self.impact.vehicle,
        }
    }

    /// The hinge with the largest plastic rotation or, where none has yielded, with the largest utilisation.
    pub(super) fn governing_hinge(&self) -> usize {
        let hinges = &self.report.hinges;
        let order = |index: &usize| {
            let hinge = &hinges[*index];
            (hinge.plastic_rotation.abs(), hinge.max_utilisation)
        };
        (0..hinges.len())
            .max_by(|one, other| {
                let (one, other) = (order(one), order(other));
                one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
            })
            .unwrap_or_default()
    }
}
