//! Measures that protect a column, as scenarios describe them.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::input::Wrong;
use crate::parameters::{CatalogueSection, ParameterFaults, Parameters, Provenance};
use crate::study::axis::{self, AxisValue, MapQuantity};

/// Most measures of a scenario.
pub(super) const MAX_MEASURES: usize = 12;
/// Longest name of a measure, so that tables and figures have room for it.
const MAX_NAME: usize = 32;
/// Most sizes of a series by which a section is made heavier.
const MAX_SIZES: usize = 20;

/// A measure with its assumptions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measure {
    /// Such as `bollard`.
    pub name: String,
    /// What is built, in a few words.
    pub description: String,
    /// What it changes.
    pub effect: MeasureEffect,
    /// Where its numbers come from.
    pub tag: Option<Provenance>,
    /// The source, or the reason.
    pub source: String,
}

/// What a measure changes. Whatever it does not stop hits the column as if it were not there, except for a bollard, which takes
/// its energy from faster vehicles, too.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MeasureEffect {
    /// A bollard in front of the column takes this kinetic energy from a vehicle \[J\].
    TakesEnergy(f64),
    /// A guard rail holds a vehicle whose kinetic energy across the rail, `m (v sin(angle))^2 / 2`, is at most this \[J\].
    HoldsLateralEnergy(f64),
    /// Something rigid around the foot of the column stops every vehicle that strikes at most this high above the base \[m\].
    StopsUpTo(f64),
    /// The section of the column is this many sizes heavier, in the order of its series.
    SectionsHeavier(usize),
}

/// A measure as files have it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    #[serde(default)]
    description: String,
    takes_energy_kj: Option<f64>,
    holds_lateral_energy_kj: Option<f64>,
    stops_up_to_m: Option<f64>,
    sections_heavier: Option<usize>,
    tag: Option<Provenance>,
    #[serde(default)]
    source: String,
}

const EFFECTS: &str =
    "one of takes_energy_kj, holds_lateral_energy_kj, stops_up_to_m and sections_heavier";

/// Why a measure cannot be built at a column.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasureFault {
    /// The column has no section of the catalogue.
    #[error("its section is user-defined; give section.name")]
    NoSeries,
    /// The series ends before.
    #[error("the series of {section} has no section {sizes} sizes heavier")]
    EndOfSeries {
        /// The section of the column.
        section: String,
        /// How many sizes.
        sizes: usize,
    },
    /// The parameters do not admit the section.
    #[error("{}", .0.in_one_line())]
    Parameters(#[from] ParameterFaults),
}

impl Measure {
    /// Reads a measure.
    pub(super) fn of_json(json: &Json) -> Result<Self, Wrong> {
        let row: Row = serde_json::from_value(json.clone()).map_err(|wrong| {
            let expected = "a measure as in config/risk.json".to_owned();
            (String::new(), wrong.to_string(), expected)
        })?;
        let name_is_right = !row.name.is_empty()
            && row.name.len() <= MAX_NAME
            && row
                .name
                .chars()
                .all(|it| it.is_ascii_alphanumeric() || it == '_');
        if !name_is_right {
            let expected = format!("1 to {MAX_NAME} letters, digits and underscores");
            return Err(("name".to_owned(), row.name, expected));
        }
        let energy = |it: f64| MeasureEffect::TakesEnergy(1e3 * it);
        let lateral = |it: f64| MeasureEffect::HoldsLateralEnergy(1e3 * it);
        let given = [
            (
                "takes_energy_kj",
                row.takes_energy_kj,
                row.takes_energy_kj.map(energy),
            ),
            (
                "holds_lateral_energy_kj",
                row.holds_lateral_energy_kj,
                row.holds_lateral_energy_kj.map(lateral),
            ),
            (
                "stops_up_to_m",
                row.stops_up_to_m,
                row.stops_up_to_m.map(MeasureEffect::StopsUpTo),
            ),
            (
                "sections_heavier",
                row.sections_heavier.map(|it| it as f64),
                row.sections_heavier.map(MeasureEffect::SectionsHeavier),
            ),
        ];
        let mut effects = Vec::new();
        for (entry, number, effect) in given {
            let (Some(number), Some(effect)) = (number, effect) else {
                continue;
            };
            let most = match effect {
                MeasureEffect::SectionsHeavier(_) => MAX_SIZES as f64,
                MeasureEffect::StopsUpTo(_) => 100.0,
                _ => 1e6,
            };
            if !(number > 0.0 && number <= most) {
                let expected = format!("a number above 0, at most {most}");
                return Err((entry.to_owned(), number.to_string(), expected));
            }
            effects.push(effect);
        }
        let [effect] = effects[..] else {
            let found = format!("{} of them", effects.len());
            return Err((String::new(), found, EFFECTS.to_owned()));
        };
        Ok(Self {
            name: row.name,
            description: row.description,
            effect,
            tag: row.tag,
            source: row.source,
        })
    }

    /// The column with the measure, where that changes the column.
    ///
    /// # Errors
    /// The column has no section of the catalogue, or none that is as much heavier.
    pub fn column(&self, parameters: &Parameters) -> Result<Option<Parameters>, MeasureFault> {
        let MeasureEffect::SectionsHeavier(sizes) = self.effect else {
            return Ok(None);
        };
        let section = parameters.section().name.ok_or(MeasureFault::NoSeries)?;
        let heavier =
            CatalogueSection::heavier(section, sizes).ok_or_else(|| MeasureFault::EndOfSeries {
                section: section.to_owned(),
                sizes,
            })?;
        let name = AxisValue::Name(&heavier.name);
        let changes = axis::changes(MapQuantity::Section, parameters, name);
        Ok(Some(parameters.with_changes(changes)?))
    }
}
