//! The first line of the report: the severity, and the criterion that decides with its margin.

use maud::{Markup, html};

use super::assessed::{Assessed, action};
use super::reported_impact::ReportedImpact;
use super::words::capitalised;
use crate::assessment::{Assessment, Criterion, Severity};
use crate::column::{End, HINGE_NAMES, Outcome};
use crate::figures::units::{Unit, significant};
use crate::shape::{HINGE_PLACES, WEB_PLACES};

/// The verdict on one impact.
pub(super) struct Verdict {
    /// Class of the style.
    class: &'static str,
    /// The severity and the deciding criterion with its margin.
    headline: String,
    /// What has to be done.
    action: String,
    /// Between which actions the verdict lies; empty where it is not known.
    range: String,
    /// The outcome in numbers.
    outcome: String,
    /// What the verdict leaves open.
    reservations: Vec<String>,
}

impl Verdict {
    /// The verdict of the model; `assessed` has the reason where there is no assessment.
    pub fn of(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Self {
        let report = &impact.report;
        let mut reservations = Vec::new();
        if report.end == End::DurationReached {
            reservations.push(format!(
                "The computation ended after {} (response.duration), before the column came to rest: what happens later is not \
                 included.",
                Unit::time(report.end_time).show(report.end_time),
            ));
        }
        let range = match assessed {
            Ok(Assessed {
                range: Ok(range), ..
            }) => format!("Range of the verdict: {range}."),
            _ => String::new(),
        };
        let (class, headline, action) = match assessed {
            Ok(assessed) => {
                let assessment = &assessed.assessment;
                reservations.push(assessment.reservations().trim().to_owned());
                let class = match assessment.at_least {
                    // The calm colours would say that no more can be the matter.
                    true if assessment.severity < Severity::Restrict => {
                        class_of(Severity::Restrict)
                    }
                    _ => class_of(assessment.severity),
                };
                (
                    class,
                    headline(assessment, assessed.deciding()),
                    action(assessment.severity).to_owned(),
                )
            }
            Err(reason) => (
                "warning",
                format!("No assessment: {reason}"),
                "An engineer has to examine the column.".to_owned(),
            ),
        };
        Self {
            class,
            headline,
            action,
            range,
            outcome: outcome(impact),
            reservations,
        }
    }

    /// The box, with a text before the severity where there are several impacts.
    pub fn markup(&self, before: &str) -> Markup {
        html! {
            div.verdict.(self.class) {
                p.headline { (before) (self.headline) }
                p { strong { (self.action) } }
                @if !self.range.is_empty() { p { (self.range) } }
                p { (self.outcome) }
                @for reservation in self.reservations.iter().filter(|it| !it.is_empty()) { p.reservation { (reservation) } }
            }
        }
    }
}

/// The severity and what decides it, in one or two sentences.
fn headline(assessment: &Assessment, deciding: Option<&Criterion>) -> String {
    let mut words = capitalised(&assessment.severity_in_words());
    if assessment.at_least {
        let missing: Vec<_> = assessment
            .not_evaluated
            .iter()
            .filter(|it| it.severity > assessment.severity)
            .map(|it| it.criterion.replace('_', " "))
            .collect();
        words += &format!(", because {} could not be evaluated", missing.join(", "));
    }
    match assessment.severity {
        Severity::None => words + ": no criterion that decides is exceeded.",
        _ => format!(
            "{words}. {}",
            deciding.map_or("", |criterion| &criterion.statement)
        ),
    }
}

/// The style of the box of a severity.
pub(super) fn class_of(severity: Severity) -> &'static str {
    match severity {
        Severity::None => "calm",
        Severity::Inspect => "notice",
        Severity::Restrict => "warning",
        Severity::Prop | Severity::Evacuate => "alarm",
    }
}

/// What the model predicts, with its numbers.
fn outcome(impact: &ReportedImpact) -> String {
    let report = &impact.report;
    let hinge = impact.governing_hinge();
    let named = format!("hinge {} ({})", HINGE_NAMES[hinge], HINGE_PLACES[hinge]);
    let length = Unit::length(report.max_v1);
    let end = Unit::time(report.end_time).show(report.end_time);
    let rotation = report.hinges[hinge].plastic_rotation;
    let angle = format!(
        "{} rad ({:.1}°)",
        significant(rotation, 3),
        rotation.to_degrees()
    );
    let yielded = report
        .hinges
        .iter()
        .filter(|it| it.first_yield.is_some())
        .count();
    let sheared: String = report
        .webs
        .iter()
        .zip(WEB_PLACES)
        .filter(|(web, _)| web.first_yield.is_some())
        .map(|(web, place)| {
            let angle = significant(web.plastic_angle, 3);
            format!(" The web {place} shears by {angle} rad.")
        })
        .collect();
    let hinges = match yielded {
        0 => "No hinge yields.".to_owned(),
        _ => format!(
            "{yielded} of 4 hinges yield; the largest plastic rotation is {angle}, at {named}."
        ),
    };
    match report.outcome {
        Outcome::Elastic => format!(
            "The model predicts no plastic deformation by this impact: {named} comes closest to yielding, with a utilisation of \
             {:.3}. The impact point moves {} at most.",
            report.hinges[hinge].max_utilisation,
            length.show(report.max_v1),
        ),
        Outcome::Plastic => format!(
            "The model predicts a displacement of the impact point of {} at most, of which {}. {hinges}{sheared}",
            length.show(report.max_v1),
            report
                .residual_v1
                .map_or("the rest is not known".to_owned(), |it| format!(
                    "{} remain",
                    length.show(it)
                )),
        ),
        Outcome::Collapsed => format!(
            "The model predicts that the column loses its shape or its equilibrium {end} after the event."
        ),
        Outcome::Severed if impact.fractured_web().is_some() => format!(
            "The model predicts that the web {} fractures in shear {end} after the event, at a plastic shear angle of {} rad; a \
             fractured column carries nothing.",
            impact.fractured_web().map_or("", |web| WEB_PLACES[web]),
            significant(
                impact
                    .fractured_web()
                    .map_or(f64::NAN, |web| report.webs[web].plastic_angle),
                3
            ),
        ),
        Outcome::Severed => format!(
            "The model predicts that {named} tears {end} after the event, at a plastic rotation of {angle}; a torn hinge or web carries \
             nothing."
        ),
    }
}
