//! The first lines of the report: what has to be done, then the cause in plain words, then the number and its limit.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::checks::{limit_in_words, value_in_words};
use super::reported_impact::ReportedImpact;
use super::words::part_of;
use crate::assessment::{Action, ActionRange, Assessment, NOT_ASSESSED, Utilisation, capitalised};
use crate::column::{End, Outcome};
use crate::figures::units::Unit;
use crate::shape::WEB_PLACES;

/// The verdict on one impact.
pub(super) struct Verdict {
    /// Class of the style.
    class: &'static str,
    /// The action and what has to be done, in the imperative.
    headline: String,
    /// Why, in plain words.
    cause: String,
    /// The number that decides and its limit; empty where there is none.
    numbers: String,
    /// The model that decides.
    model: String,
    /// Between which actions the verdict lies; empty where it is not known.
    range: String,
    /// What the verdict leaves open.
    reservations: Vec<String>,
    /// Whether people may stay, and under which condition.
    people: [String; 2],
}

impl Verdict {
    /// The verdict of the model; `assessed` has the reason where there is no assessment.
    pub fn of(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Self {
        let report = &impact.report;
        let mut reservations = Vec::new();
        if report.end == End::DurationReached {
            reservations.push(format!(
                "The computation ended after {} (response.duration), before the column came to rest: the later motion is not included.",
                Unit::time(report.end_time).show(report.end_time),
            ));
        }
        let assessed = match assessed {
            Ok(assessed) => assessed,
            Err(reason) => {
                return Self {
                    class: "warning",
                    headline: format!("NO ASSESSMENT: {NOT_ASSESSED}"),
                    cause: format!("There is no assessment, because {reason}."),
                    numbers: outcome(impact),
                    model: String::new(),
                    range: String::new(),
                    reservations,
                    people: [
                        "Not known: act as for EVACUATE.".to_owned(),
                        "Nobody goes back before an engineer has examined the column and allows it."
                            .to_owned(),
                    ],
                };
            }
        };
        let assessment = &assessed.assessment;
        if assessment.at_least {
            reservations.push(missing(assessment));
        }
        let range = assessed.range.as_ref().ok();
        Self {
            class: match assessment.at_least {
                // The calm colours would say that no more can be the matter.
                true if assessment.action < Action::Restrict => class_of(Action::Restrict),
                _ => class_of(assessment.action),
            },
            headline: headline(assessment),
            cause: cause(assessment),
            numbers: numbers(impact, assessed),
            model: model(assessed),
            range: range.map_or(String::new(), |range| {
                format!("Range of the verdict: {range}.")
            }),
            reservations,
            people: people(assessment, range),
        }
    }

    /// The box, with a text before the action where there are several impacts.
    pub fn markup(&self, before: &str) -> Markup {
        html! {
            div.verdict.(self.class) {
                p.headline { (before) (self.headline) }
                p { strong { (self.cause) } }
                @if !self.numbers.is_empty() { p { (self.numbers) } }
                @if !self.model.is_empty() { p { (self.model) } }
                @if !self.range.is_empty() { p { (self.range) } }
                @for reservation in &self.reservations { p.reservation { (reservation) } }
            }
        }
    }

    /// The answer to the question whether people may stay.
    pub fn people(&self) -> Markup {
        let [answer, condition] = &self.people;
        html! {
            div.answer {
                h2 { "May people stay?" }
                p { strong { (answer) } " " (condition) }
            }
        }
    }
}

fn headline(assessment: &Assessment) -> String {
    let action = assessment.action.name().to_uppercase();
    let at_least = if assessment.at_least { "AT LEAST " } else { "" };
    format!("{at_least}{action}: {}", assessment.action.order())
}

fn cause(assessment: &Assessment) -> String {
    match assessment.action {
        Action::None => "No limit of the checks that decide is exceeded.".to_owned(),
        action => {
            let others = assessment.criteria.iter().filter(|it| {
                let is_as_severe = it.decides && it.exceeded == Some(true) && it.action == action;
                is_as_severe && it.name != assessment.deciding_criterion
            });
            let causes: Vec<_> = others.map(|it| it.cause).collect();
            let also = match &causes[..] {
                [] => String::new(),
                _ => format!(" Also: {}.", causes.join("; ")),
            };
            format!("Cause: {}.{also}", assessment.cause)
        }
    }
}

/// The number that decides with its limit, and the shape that the hit leaves.
fn numbers(impact: &ReportedImpact, assessed: &Assessed) -> String {
    let assessment = &assessed.assessment;
    let mut text = String::new();
    match assessed.deciding() {
        Some(criterion) if assessment.action > Action::None && criterion.name != "collapse" => {
            if let (Some(value), Some(limit)) =
                (value_in_words(criterion), limit_in_words(criterion))
            {
                let name = criterion.quantity();
                text = format!("{name}: {value}; limit {limit}. ");
            }
        }
        Some(_) if assessment.action == Action::None => {
            let utilisation = Utilisation::of_report(&impact.report);
            text = format!("Largest utilisation of the column: {utilisation}. ");
        }
        _ => (),
    }
    text + &outcome(impact)
}

/// The model that decides, and what the other one says.
fn model(assessed: &Assessed) -> String {
    match &assessed.second_opinion {
        None => "Model that decides: the two bars alone.".to_owned(),
        Some(Err(_)) => {
            "Model that decides: the two bars alone; the annex gives the reason why there is no second opinion."
                .to_owned()
        }
        Some(Ok(opinion)) if opinion.decides => {
            let says = capitalised(&opinion.to_string());
            format!("Model that decides: the fibre beam. {says}")
        }
        Some(Ok(opinion)) => {
            let by_beam = opinion.action().map_or("not assessed", Action::name);
            let says = match opinion.counts.is_empty() {
                true if opinion.action() == Some(assessed.assessment.action) => {
                    "the fibre beam agrees with them".to_owned()
                }
                true => format!(
                    "the action by the fibre beam alone is {by_beam}, but the models differ too little for its verdict to count"
                ),
                false => format!(
                    "the verdict of the fibre beam ({by_beam}) counts, too, and is no more severe"
                ),
            };
            format!("Model that decides: the two bars; {says}.")
        }
    }
}

/// What the model predicts, in one sentence.
fn outcome(impact: &ReportedImpact) -> String {
    let report = &impact.report;
    let height = impact.height();
    let bow = |v1: f64| format!("{} = {}", Unit::length(v1).show(v1), part_of(v1, height));
    let end = Unit::time(report.end_time).show(report.end_time);
    match (report.outcome, report.residual_v1) {
        (Outcome::Elastic, _) => format!(
            "The column stays elastic; it moves {} at the impact point at most.",
            Unit::length(report.max_v1).show(report.max_v1)
        ),
        (Outcome::Plastic, Some(residual)) => format!(
            "Bow that remains: {}; kink at the impact point {:.1}°.",
            bow(residual),
            impact.kink().to_degrees()
        ),
        (Outcome::Plastic, None) => format!(
            "The impact point moves {} at most; the bow that remains is not known.",
            bow(report.max_v1)
        ),
        (Outcome::Collapsed, _) => {
            format!("It loses its shape or its equilibrium {end} after the event.")
        }
        (Outcome::Fractured, _) => match impact.fractured_web() {
            Some(web) => format!(
                "The web {} fractures in shear {end} after the event.",
                WEB_PLACES[web]
            ),
            None => format!("A hinge fractures {end} after the event."),
        },
    }
}

/// The checks that are missing and could ask for more.
fn missing(assessment: &Assessment) -> String {
    let mut names: Vec<&str> = Vec::new();
    for it in &assessment.not_evaluated {
        let name = it.title;
        if it.action > assessment.action && !names.contains(&name) {
            names.push(name);
        }
    }
    format!(
        "A more severe action may be necessary, because data are missing for: {}. The table of checks lists them.",
        names.join("; ")
    )
}

/// Whether people may stay, and under which condition.
fn people(assessment: &Assessment, range: Option<&ActionRange>) -> [String; 2] {
    let action = assessment.action;
    let (answer, condition) = match action {
        Action::None | Action::Inspect if assessment.at_least => (
            "Not answered by these checks.",
            "Keep people away from the column until an engineer has made the checks that are missing.",
        ),
        Action::None => ("Yes.", "No check gives a reason to keep people away."),
        Action::Inspect => (
            "Yes.",
            "Bring no additional load onto the part that the column carries until an engineer has examined it.",
        ),
        Action::Restrict => (
            "Not near the column.",
            "Keep people away from it, and additional loads off the part of the building that it carries, until an engineer has examined it.",
        ),
        Action::Shore => (
            "Not where the column carries the building.",
            "Only those go in who shore it, as an engineer directs.",
        ),
        Action::Evacuate => (
            "No.",
            "Everybody leaves the part of the building that the column carries, and nobody enters it, not even to shore it, before an engineer allows it.",
        ),
    };
    let mut condition = condition.to_owned();
    if let Some(range) =
        range.filter(|it| it.ends.most > action && it.ends.most >= Action::Restrict)
    {
        let causes: Vec<_> = range
            .ends
            .decided_by
            .iter()
            .map(|it| it.in_words())
            .collect();
        condition += &format!(
            " Act as for {} unless this is known well enough to rule it out: {}.",
            range.ends.most.name().to_uppercase(),
            causes.join(", ")
        );
    }
    [answer.to_owned(), condition]
}

/// The style of the box of an action.
pub(super) fn class_of(action: Action) -> &'static str {
    match action {
        Action::None => "calm",
        Action::Inspect => "notice",
        Action::Restrict => "warning",
        Action::Shore | Action::Evacuate => "alarm",
    }
}

/// What has to be done, for the box of an estimate.
pub(super) fn instruction(action: Action) -> String {
    capitalised(action.order())
}
