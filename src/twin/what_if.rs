//! What an impact would do to the column as it is: a snapshot of the twin that answers without touching it.

use std::sync::Arc;

use super::plant::{Plant, Struck, is_same_height, with_impact_height};
use super::refusal::{Refusal, RefusalCode};
use super::registry::check_column_id;
use super::seconds;
use super::timeline::{LookAhead, Outlook};
use crate::column::{ColumnProperties, Impact, ImpactSpecification, Report};
use crate::parameters::{Parameter, Parameters, Value};

/// The column at one instant with its parameters: all that a what-if needs.
#[derive(Debug, Clone)]
pub struct ColumnSnapshot {
    pub(super) column_id: Arc<str>,
    pub(super) parameters: Arc<Parameters>,
    pub(super) plant: Plant,
}

/// The forecast of an impact that has not happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// What the impact would do.
    pub report: Report,
    /// What computing it took \[s\].
    pub compute_time: f64,
}

impl ColumnSnapshot {
    /// Predicts what an impact would do to the column, in the caller's thread. An empty `column_id` means this column;
    /// `stopwatch` gives monotonic nanoseconds.
    ///
    /// # Errors
    /// The impact would be refused, or its response cannot be computed to its end.
    pub fn predict(
        &self,
        column_id: &str,
        specification: &ImpactSpecification,
        stopwatch: &dyn Fn() -> u64,
    ) -> Result<Prediction, Refusal> {
        if !column_id.is_empty() {
            check_column_id(&self.column_id, column_id)?;
        }
        let impact = self.complete(specification)?;
        let mut ahead = LookAhead::new(self.strike(impact, specification.height)?);
        match ahead.run(u64::MAX, stopwatch) {
            Outlook::Over { report, .. } => Ok(Prediction {
                report,
                compute_time: seconds(ahead.compute_nanos()),
            }),
            Outlook::Failed(reason) => Err(Refusal::new(RefusalCode::NotComputed, reason)),
            Outlook::Running => {
                let reason = "the prediction was not carried to its end";
                Err(Refusal::new(RefusalCode::NotComputed, reason))
            }
        }
    }

    /// The impact with what its specification leaves open taken from the parameters, every number checked against the
    /// one table.
    ///
    /// # Errors
    /// All numbers that are not finite or out of range.
    pub(super) fn complete(&self, specification: &ImpactSpecification) -> Result<Impact, Refusal> {
        let defaults = self.parameters.impact();
        let impact = specification
            .complete(&defaults, defaults.vehicle)
            .map_err(|error| Refusal::new(RefusalCode::ImpactOutOfRange, error.to_string()))?;
        // A mass that is left open is that of a compliant vehicle, which is complete by now.
        let open = (impact.mass == 0.0 || impact.mass.is_nan()).then(|| {
            let mass = impact.mass;
            format!("mass = {mass}: is required, because a rigid vehicle has no mass of its own")
        });
        let faults: Vec<_> = [
            open.or_else(|| fault_of("mass", "impact.mass", impact.mass)),
            fault_of("velocity", "impact.velocity", impact.velocity),
            fault_of("gap", "impact.gap", impact.gap),
            fault_of("restitution", "impact.restitution", impact.restitution),
        ]
        .into_iter()
        .flatten()
        .collect();
        match faults.is_empty() {
            true => Ok(impact),
            false => Err(Refusal::new(
                RefusalCode::ImpactOutOfRange,
                faults.join("; "),
            )),
        }
    }

    /// A copy of the column with an impactor on its way to this height above the base \[m\]; `None`: where the
    /// parameters have it.
    ///
    /// # Errors
    /// The column cannot take an impact, or not at this height.
    pub(super) fn strike(&self, impact: Impact, height: Option<f64>) -> Result<Struck, Refusal> {
        let properties = self.properties_for(height)?;
        let max_duration = self.parameters.response_duration();
        self.plant.strike(&properties, impact, max_duration)
    }

    fn properties_for(&self, height: Option<f64>) -> Result<ColumnProperties, Refusal> {
        let properties = self.parameters.column_properties();
        let Some(height) = height.filter(|it| !is_same_height(*it, properties.length_below)) else {
            return Ok(properties);
        };
        let whole = properties.length_below + properties.length_above;
        let faults = [
            fault_of("height", "geometry.length_below", height),
            fault_of(
                "the length of the column above it",
                "geometry.length_above",
                whole - height,
            ),
        ];
        match faults.into_iter().flatten().next() {
            Some(fault) => Err(Refusal::new(
                RefusalCode::ImpactOutOfRange,
                format!("{fault}; the column is {whole} m high"),
            )),
            None => Ok(with_impact_height(&properties, height)),
        }
    }
}

/// The fault of a number that has the range of the parameter `name`.
fn fault_of(called: &str, name: &str, number: f64) -> Option<String> {
    let problem = Parameter::named(name)?
        .check(&Value::Double(number))
        .err()?;
    Some(format!("{called} = {number}: {problem}"))
}
