//! The HTML file.

use std::path::{Path, PathBuf};

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::assessed::Assessed;
use super::details::ReportDetails;
#[cfg(feature = "record")]
use super::detected_section;
use super::facts::fact;
use super::impact_section;
use super::limits_section;
use super::pages;
use super::provenance;
#[cfg(feature = "record")]
use super::recorded::ReportedRecording;
#[cfg(feature = "record")]
use super::recording_section;
use super::reported_impact::ReportedImpact;
use super::title_block;
use crate::figures::FigureError;
use crate::parameters::{DefaultValue, Parameter, Parameters, Value};

/// Where the impacts of a report come from.
#[derive(Debug, Clone)]
pub enum Origin {
    /// They were simulated on an undamaged column.
    Simulation,
    /// They were recorded.
    #[cfg(feature = "record")]
    Recording(Box<ReportedRecording>),
}

/// A report about one or several impacts.
#[derive(Debug, Clone)]
pub struct ReportDocument {
    /// Where the impacts come from.
    pub origin: Origin,
    /// The impacts, in their order.
    pub impacts: Vec<ReportedImpact>,
    /// What the office writes into it.
    pub details: ReportDetails,
}

impl Origin {
    fn facts(&self) -> Markup {
        match self {
            Self::Simulation => fact(
                "Origin",
                "simulation of an impact on an undamaged column; nothing was measured",
            ),
            #[cfg(feature = "record")]
            Self::Recording(recorded) => recording_section::facts(recorded),
        }
    }

    fn verification(&self) -> Markup {
        match self {
            Self::Simulation => html! {},
            #[cfg(feature = "record")]
            Self::Recording(recorded) => recording_section::verification(recorded),
        }
    }
}

const STYLE: &str = include_str!("style.css");

impl ReportDocument {
    /// The HTML text.
    ///
    /// # Errors
    /// A figure cannot be drawn.
    pub fn html(&self) -> Result<String, FigureError> {
        let several = self.impacts.len() > 1;
        let notices = self.notices();
        let (mut bodies, mut annexes) = (Vec::new(), Vec::new());
        for (index, impact) in self.impacts.iter().enumerate() {
            let number = several.then_some(index + 1);
            let assessed = Assessed::of(impact);
            // What is signed tells that the recording is not what it was.
            let notices = (!several).then_some(&notices);
            bodies.push(pages::markup(
                impact,
                &assessed,
                &self.details,
                number,
                notices,
            ));
            annexes.push(impact_section::annex(impact, &assessed, number)?);
        }
        let column = self.impacts.first().map(|impact| {
            let parameters = &impact.parameters;
            parameters.settings().column_id.clone()
        });
        let title = match &column {
            Some(column) => format!("Impact report: column {column}"),
            None => "Impact report".to_owned(),
        };
        let detected = self.detected()?;
        let body = html! {
            (self.cover())
            @for body in &bodies { (body) }
            (detected)
            @for annex in &annexes { (annex) }
            @if bodies.is_empty() { (limits_section::markup()) }
            (self.provenance())
        };
        Ok(page(&title, &body))
    }

    /// A page before the first impact, where there is more to say than about one impact.
    fn cover(&self) -> Markup {
        let overview = self.overview();
        let is_one = self.impacts.len() == 1;
        html! {
            @if !overview.0.trim().is_empty() {
                div.cover {
                    (overview)
                    @if !is_one { (title_block::markup(&self.details, None)) }
                }
            }
        }
    }

    /// What is wrong with where the impacts come from, before the verdict and after it.
    fn notices(&self) -> [Markup; 2] {
        match &self.origin {
            Origin::Simulation => [html! {}, html! {}],
            #[cfg(feature = "record")]
            Origin::Recording(recorded) => recording_section::notices(recorded, &self.impacts),
        }
    }

    fn overview(&self) -> Markup {
        match &self.origin {
            Origin::Simulation => html! {},
            #[cfg(feature = "record")]
            Origin::Recording(recorded) => recording_section::overview(recorded, &self.impacts),
        }
    }

    /// What the sensors have detected.
    fn detected(&self) -> Result<Markup, FigureError> {
        match &self.origin {
            Origin::Simulation => Ok(html! {}),
            #[cfg(feature = "record")]
            Origin::Recording(recorded) => {
                detected_section::markup(&recorded.detected, &self.impacts)
            }
        }
    }

    fn provenance(&self) -> Markup {
        html! {
            section.annex id="provenance" {
                h1 { "Annex: provenance and verification" }
                table.facts {
                    tbody {
                        (program_facts())
                        (self.origin.facts())
                    }
                }
                (self.origin.verification())
                @for (number, parameters) in self.parameter_sets() {
                    h3 { "Parameters that differ from the defaults" (of_impacts(number)) }
                    (changed_parameters(parameters))
                }
            }
        }
    }

    /// The different sets of parameters, each with the number of the first impact for which it held; without a number if
    /// there is one set only.
    fn parameter_sets(&self) -> Vec<(Option<usize>, &Parameters)> {
        let mut sets: Vec<(Option<usize>, &Parameters)> = Vec::new();
        for (index, impact) in self.impacts.iter().enumerate() {
            let parameters = impact.parameters.as_ref();
            if sets.last().is_none_or(|(_, last)| *last != parameters) {
                sets.push((Some(index + 1), parameters));
            }
        }
        if let [(number, _)] = sets.as_mut_slice() {
            *number = None;
        }
        sets
    }

    /// Every parameter of every impact, for the JSON file beside the report.
    #[must_use]
    pub fn parameters_json(&self) -> String {
        let sets = self.parameter_sets();
        let sets: Vec<_> = sets
            .iter()
            .map(|(number, set)| (number.unwrap_or(1), *set))
            .collect();
        parameters_json(&sets)
    }
}

/// The whole file, with this title and content.
pub(super) fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content=(provenance::program());
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main { (body) }
            }
        }
    };
    page.into_string()
}

/// Rows of a table of facts: the program and its build.
pub(super) fn program_facts() -> Markup {
    html! {
        (fact("Program", provenance::program()))
        @if let Some(build) = provenance::build() {
            tr { th scope="row" { "Build" } td { code { (build) } } }
        }
    }
}

/// Every parameter of these sets as JSON, each with the number of the first impact for which it held.
pub(super) fn parameters_json(sets: &[(usize, &Parameters)]) -> String {
    let sets: Vec<_> = sets
        .iter()
        .map(|(number, parameters)| {
            let all: Vec<_> = parameters
                .iter()
                .map(|(parameter, value)| {
                    serde_json::json!({
                        "name": parameter.name,
                        "value": value,
                        "unit": parameter.row.unit,
                        "meaning": parameter.row.meaning,
                    })
                })
                .collect();
            serde_json::json!({ "from_impact": number, "parameters": all })
        })
        .collect();
    let document = serde_json::json!({
        "program": provenance::program(),
        "build": provenance::build(),
        "parameter_sets": sets,
    });
    format!("{document:#}\n")
}

/// The file of the parameters beside a report.
#[must_use]
pub fn parameters_path(report: &Path) -> PathBuf {
    report.with_extension("parameters.json")
}

/// First parts of the names of parameters that describe the column, the impact and the judgement; all others configure the
/// program.
const ABOUT_THE_COLUMN: [&str; 23] = [
    "geometry",
    "section",
    "steel",
    "resistance",
    "yield_surface",
    "hinge",
    "support",
    "base",
    "top",
    "impact",
    "vehicle",
    "rate",
    "hardening",
    "softening",
    "shear",
    "solver",
    "damping",
    "response",
    "capacity",
    "assessment",
    "beam",
    "sensors",
    "estimation",
];

fn of_impacts(number: Option<usize>) -> Markup {
    html! { @if let Some(number) = number { ", from impact " (number) " on" } }
}

fn shown(value: &Value) -> String {
    let text = value.to_string();
    if text.is_empty() {
        "\"\"".to_owned()
    } else {
        text
    }
}

fn default_of(row: &Parameter) -> String {
    match row.default {
        DefaultValue::Required(_) => "none".to_owned(),
        _ => shown(&row.default_value()),
    }
}

/// A table of the parameters that differ from their defaults.
pub(super) fn changed_parameters(parameters: &Parameters) -> Markup {
    let defaults = Parameters::default();
    let mut changed = parameters.changed_from(&defaults);
    changed.retain(|it| {
        let first = it.name.split('.').next().unwrap_or_default();
        ABOUT_THE_COLUMN.contains(&first)
    });
    html! {
        p { "Of the column, the impact and the judgement. All parameters are in the JSON file next to this report." }
        @if changed.is_empty() {
            p { "None: each of them has its default." }
        } @else {
            table {
                thead { tr { th { "parameter" } th { "value" } th { "default" } th { "unit" } } }
                tbody {
                    @for parameter in changed {
                        tr {
                            th scope="row" { code { (parameter.name) } }
                            td { (parameters.get(parameter.name).as_ref().map_or(String::new(), shown)) }
                            td { (default_of(parameter.row)) }
                            td { (parameter.row.unit) }
                        }
                    }
                }
            }
        }
    }
}
