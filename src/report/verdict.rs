//! The first lines of the report: what has to be done, then the cause in plain words, then the number and its limit.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::beam_words;
use super::checks::{limit_in_words, value_in_words};
use super::reported_impact::ReportedImpact;
use super::words::part_of;
use crate::assessment::{
    Action, ActionRange, Assessment, MissingKind, NOT_ASSESSED, Utilisation, capitalised,
    missing_in_words,
};
use crate::column::{End, Outcome};
use crate::figures::units::Unit;
use crate::observables::WEB_PLACES;

/// The verdict on one impact.
pub(super) struct Verdict {
    /// Class of the style.
    class: &'static str,
    /// The action and what has to be done, in the imperative.
    headline: String,
    /// Why, in plain words.
    cause: String,
    /// The number that decides and its limit, in the line of the cause; empty where there is none.
    number: String,
    /// The other causes, and the shape that the hit leaves.
    besides: String,
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
                    number: String::new(),
                    besides: by_two_bars(impact),
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
            reservations.extend(missing(assessment));
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
            number: number(impact, assessed),
            besides: format!("{}{}", other_causes(assessed), shape(impact, assessed)),
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
                p { strong { (self.cause) } " " (self.number) }
                p { (self.besides) }
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
        _ => format!("Cause: {}.", assessment.cause),
    }
}

/// The causes of the other checks that lead to the same action, as a sentence before the next one; empty where there are none.
fn other_causes(assessed: &Assessed) -> String {
    let assessment = &assessed.assessment;
    let others = assessed.criteria.iter().filter(|it| {
        let is_as_severe =
            it.decides && it.exceeded == Some(true) && it.action == assessment.action;
        is_as_severe && it.name != assessment.deciding_criterion
    });
    let causes: Vec<_> = others.map(|it| it.cause).collect();
    match (&causes[..], assessment.action) {
        ([], _) | (_, Action::None) => String::new(),
        _ => format!("Also: {}. ", causes.join("; ")),
    }
}

/// The number that decides with its limit, or how far the column has come where nothing decides.
fn number(impact: &ReportedImpact, assessed: &Assessed) -> String {
    let assessment = &assessed.assessment;
    match assessed.deciding() {
        Some(criterion) if assessment.action > Action::None && criterion.name != "collapse" => {
            match (value_in_words(criterion), limit_in_words(criterion)) {
                (Some(value), Some(limit)) => {
                    format!("{}: {value}; limit {limit}.", criterion.quantity())
                }
                _ => String::new(),
            }
        }
        // Of an oblique hit the two bars know a part.
        Some(_)
            if assessment.action == Action::None
                && assessed.beam().is_none()
                && !impact.is_oblique() =>
        {
            let utilisation = Utilisation::of_report(&impact.report);
            format!("Largest utilisation of the column: {utilisation}.")
        }
        _ => String::new(),
    }
}

/// The shape that the hit leaves, by the model that decides.
fn shape(impact: &ReportedImpact, assessed: &Assessed) -> String {
    match assessed.by_beam() {
        Some(by_beam) => beam_words::outcome(by_beam),
        None => by_two_bars(impact),
    }
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
            let opinion = capitalised(&opinion.to_string());
            format!("Model that decides: the fibre beam. {opinion}")
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

/// What the two bars predict, and where it is not the whole.
fn by_two_bars(impact: &ReportedImpact) -> String {
    match (impact.is_seen_by_the_bars(), impact.is_oblique()) {
        (false, _) => {
            "What the column does is not known: the two bars do not see a hit at right angles to their plane."
                .to_owned()
        }
        (true, true) => format!(
            "{} This is by the component of the hit in the plane of the two bars; what the column does across it is not known.",
            outcome(impact)
        ),
        (true, false) => outcome(impact),
    }
}

/// What the two bars predict, in one sentence.
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
        (Outcome::Fractured, _) => match (report.base.fractured, impact.fractured_web()) {
            (Some(failure), _) => {
                format!("The base fails {end} after the event: {}.", failure.name())
            }
            (None, Some(web)) => format!(
                "The web {} fractures in shear {end} after the event.",
                WEB_PLACES[web].words
            ),
            (None, None) => format!("A hinge fractures {end} after the event."),
        },
    }
}

/// What is not known and could ask for more: inputs that nobody has given, and checks that are missing.
fn missing(assessment: &Assessment) -> Vec<String> {
    let (mut inputs, mut names): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    let missing = assessment.not_evaluated.iter();
    for it in missing.filter(|it| it.action > assessment.action) {
        match it.kind {
            MissingKind::Input => inputs.push(&it.needs),
            _ if !names.contains(&it.title) => names.push(it.title),
            _ => (),
        }
    }
    let mut text = Vec::new();
    if !inputs.is_empty() {
        text.push(format!(
            "A more severe action may be necessary.{}",
            sentences(&inputs)
        ));
    }
    if !names.is_empty() {
        text.push(format!(
            "A more severe action may be necessary, because data are missing for: {}. The table of checks lists them.",
            names.join("; ")
        ));
    }
    text
}

/// Each text as a sentence behind a space.
fn sentences(texts: &[&str]) -> String {
    let texts = texts.iter();
    texts.map(|it| format!(" {}.", capitalised(it))).collect()
}

/// Until when nobody goes near a column for which no calm answer is possible.
fn until_known(assessment: &Assessment) -> String {
    let missing = assessment.not_evaluated.iter();
    let missing: Vec<_> = missing.filter(|it| it.action > assessment.action).collect();
    if missing.iter().any(|it| it.kind != MissingKind::Input) {
        return "an engineer has made the checks that are missing".to_owned();
    }
    let names = missing.iter().map(|it| missing_in_words(it.criterion));
    let names: Vec<_> = names.map(|it| format!("the {it}")).collect();
    let verb = if names.len() == 1 { "is" } else { "are" };
    format!("{} {verb} known and given", names.join(" and "))
}

/// Whether people may stay, and under which condition.
fn people(assessment: &Assessment, range: Option<&ActionRange>) -> [String; 2] {
    let action = assessment.action;
    let not_answered = format!(
        "Keep people away from the column until {}.",
        until_known(assessment)
    );
    let (answer, condition) = match action {
        Action::None | Action::Inspect if assessment.at_least => {
            ("Not answered by these checks.", not_answered.as_str())
        }
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
    let ends = range.map(|it| &it.ends);
    if let Some(ends) = ends.filter(|it| it.most > action && it.most >= Action::Restrict) {
        let most = ends.most.name().to_uppercase();
        let causes: Vec<_> = ends.decided_by.iter().map(|it| it.in_words()).collect();
        if !causes.is_empty() {
            condition += &format!(
                " Act as for {most} unless this is known well enough to rule it out: {}.",
                causes.join(", ")
            );
        }
        let missing = ends.not_evaluated.iter();
        let missing: Vec<_> = missing.map(|it| missing_in_words(it)).collect();
        if !missing.is_empty() {
            condition += &format!(
                " Act as for {most} unless what is missing is known well enough to rule it out: {}.",
                missing.join("; ")
            );
        }
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
