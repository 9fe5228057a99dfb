//! By how much a measure changes the annual probability.

use serde::Serialize;

use super::estimate::Estimate;
use super::measure::{Measure, MeasureEffect};
use super::result::RiskResult;
use crate::assessment::Action;
use crate::parameters::readable;

/// The annual probability with a measure beside that without it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasureRisk {
    /// The measure with its assumptions.
    #[serde(flatten)]
    pub measure: Measure,
    /// The section that the column has with it, where that changes.
    pub section: Option<String>,
    /// Probability of at least one impact in a year.
    pub impact: Estimate,
    /// By action that is reached or exceeded.
    pub actions: Vec<MeasureAction>,
}

impl MeasureRisk {
    /// What the measure is assumed to do, in a few words with its number and tag: `takes 98.8 kJ from a vehicle [C]`.
    #[must_use]
    pub fn assumption(&self) -> String {
        let words = match self.measure.effect {
            MeasureEffect::TakesEnergy(energy) => {
                format!("takes {} kJ from a vehicle", readable(1e-3 * energy))
            }
            MeasureEffect::HoldsLateralEnergy(energy) => {
                format!("holds {} kJ across the rail", readable(1e-3 * energy))
            }
            MeasureEffect::StopsUpTo(height) => {
                format!("stops what strikes up to {} m", readable(height))
            }
            MeasureEffect::SectionsHeavier(sizes) => match &self.section {
                Some(section) => format!("section {section}"),
                None => format!("{sizes} sizes heavier"),
            },
        };
        let tag = self
            .measure
            .tag
            .map_or("user".to_owned(), |tag| tag.to_string());
        format!("{words} [{tag}]")
    }
}

/// The annual probability of an action or a higher one with a measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasureAction {
    /// The action that is reached or exceeded.
    pub action: Action,
    /// The probability with the measure.
    pub annual: Estimate,
    /// The same over that without it; `None` where that is 0.
    pub times: Option<f64>,
}

impl MeasureRisk {
    /// Compares the result of a study behind a measure with that of the same study without it.
    #[must_use]
    pub fn new(
        measure: &Measure,
        section: Option<String>,
        without: &RiskResult,
        with: &RiskResult,
    ) -> Self {
        let actions = without.annual.iter().zip(&with.annual);
        let compared = actions.map(|(without, with)| MeasureAction {
            action: with.action,
            annual: with.annual,
            times: (without.annual.value > 0.0).then(|| with.annual.value / without.annual.value),
        });
        Self {
            measure: measure.clone(),
            section,
            impact: with.annual_impact(),
            actions: compared.collect(),
        }
    }
}
