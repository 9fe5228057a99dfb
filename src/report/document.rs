//! The HTML file.

use maud::{DOCTYPE, Markup, PreEscaped, html};

#[cfg(feature = "record")]
use super::facts::fact;
use super::felt_section;
use super::impact_section;
use super::limits::LIMITS;
use super::provenance;
#[cfg(feature = "record")]
use super::recorded::ReportedRecording;
#[cfg(feature = "record")]
use super::recording_section;
use super::reported_impact::ReportedImpact;
use crate::figures::FigureError;
use crate::parameters::{DefaultValue, Parameter, Parameters, Value};

/// Where the impacts of a report come from.
#[derive(Debug, Clone)]
pub enum Origin {
    /// They were simulated on a virgin column.
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
}

impl Origin {
    fn facts(&self) -> Markup {
        match self {
            Self::Simulation => fact(
                "Origin",
                "simulation of an impact on a virgin column; nothing was measured",
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
        let mut sections = Vec::new();
        for (index, impact) in self.impacts.iter().enumerate() {
            let number = several.then_some(index + 1);
            sections.push(impact_section::markup(impact, number)?);
        }
        let column = self.impacts.first().map(|impact| {
            let parameters = &impact.parameters;
            parameters.settings().column_id.clone()
        });
        let title = match &column {
            Some(column) => format!("Impact report: column {column}"),
            None => "Impact report".to_owned(),
        };
        let felt = self.felt()?;
        let body = html! {
            (self.overview())
            @for section in &sections { (section) }
            (felt)
            (limits())
            (self.provenance())
            (self.appendix())
        };
        Ok(page(&title, &body))
    }

    fn overview(&self) -> Markup {
        match &self.origin {
            Origin::Simulation => html! {},
            #[cfg(feature = "record")]
            Origin::Recording(recorded) => recording_section::overview(recorded, &self.impacts),
        }
    }

    /// What the sensors have felt.
    fn felt(&self) -> Result<Markup, FigureError> {
        match &self.origin {
            Origin::Simulation => Ok(html! {}),
            #[cfg(feature = "record")]
            Origin::Recording(recorded) => felt_section::markup(&recorded.felt, &self.impacts),
        }
    }

    fn provenance(&self) -> Markup {
        html! {
            section id="provenance" {
                h2 { "Provenance" }
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

    fn appendix(&self) -> Markup {
        html! {
            @for (number, parameters) in self.parameter_sets() {
                (all_parameters(parameters, number))
            }
        }
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

/// The appendix with all parameters; `number` of the first impact for which they held, where there are several sets.
pub(super) fn all_parameters(parameters: &Parameters, number: Option<usize>) -> Markup {
    html! {
        section.appendix {
            h2 { "Appendix: all parameters" (of_impacts(number)) }
            table.parameters {
                thead {
                    tr { th { "parameter" } th { "value" } th { "unit" } th { "meaning" } }
                }
                tbody {
                    @for (parameter, value) in parameters.iter() {
                        tr {
                            th scope="row" { code { (parameter.name) } }
                            td { (shown(&value)) }
                            td { (parameter.row.unit) }
                            td { (parameter.row.meaning) }
                        }
                    }
                }
            }
        }
    }
}

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
    let changed = parameters.changed_from(&defaults);
    html! {
        @if changed.is_empty() {
            p { "None: every parameter has its default." }
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

/// What the model does not know.
pub(super) fn limits() -> Markup {
    html! {
        section id="limits" {
            h2 { "What this report cannot know" }
            p {
                "The numbers above are the answers of a model. It is validated against a reference solution of the same \
                 equations and against a fibre beam model of other authorship, not against a crash test of a column."
            }
            dl.limits {
                @for (limit, consequence) in LIMITS {
                    dt { (limit) }
                    dd { (consequence) }
                }
            }
        }
    }
}
