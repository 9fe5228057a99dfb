//! The section about the impacts of a recording that the sensors have detected.

use maud::{Markup, PreEscaped, html};

use super::detected_impact::{DetectedDecision, DetectedImpact};
use super::estimate_section;
use super::facts::fact;
use super::reported_impact::ReportedImpact;
use super::words::{outcome_in_words, short};
use crate::estimation::EstimateRecord;
use crate::figures::units::{Unit, significant};
use crate::figures::{FigureError, TimedEstimate, comparison_svg, forecast_svg};
use crate::parameters::RIGID;
use crate::recording::instant;
use crate::twin::Decision;

/// The section; empty without such impacts. `impacts` are those of the report with a section of their own.
pub(super) fn markup(
    detected: &[DetectedImpact],
    impacts: &[ReportedImpact],
) -> Result<Markup, FigureError> {
    let sections: Result<Vec<Markup>, FigureError> =
        detected.iter().map(|it| impact(it, impacts)).collect();
    let sections = sections?;
    Ok(html! {
        @if !sections.is_empty() {
            section id="detected" {
                h2 { "Detected by the sensors" }
                p {
                    "The impact as the sensors have detected it, and the decision of the twin. The journal of the recording holds these \
                     estimates."
                }
                @for section in &sections { (section) }
            }
        }
    })
}

fn impact(detected: &DetectedImpact, impacts: &[ReportedImpact]) -> Result<Markup, FigureError> {
    let records = &detected.estimates;
    let (Some(first), Some(last)) = (records.first(), records.last()) else {
        return Ok(html! {});
    };
    // The times of an estimate have the origin of its own record.
    let estimates: Vec<_> = records
        .iter()
        .flat_map(|it| TimedEstimate::all([&it.estimate], it.detection.contact.time))
        .collect();
    let title = format!("impact \"{}\", detected by the sensors", last.event_id);
    let drawing = forecast_svg(&title, &estimates)?;
    let compared = comparison_svg(&title, &detected.sensors, &detected.comparisons)?;
    let caption = "Largest and remaining displacement of the impact point, over the time up to which data were used.";
    Ok(html! {
        h3 { "Impact " (last.event_id) }
        @if !last.is_final {
            p.fault { "The recording ends before the final estimate, or another impact came before it." }
        }
        (estimate_section::verdict(&estimates))
        table.facts {
            tbody {
                (fact("Detected", detection(detected, first)))
                (fact("Estimated", format!(
                    "{} times, the last time with data until {} after contact{}",
                    records.len(),
                    since_contact(last),
                    if last.is_final { "; final" } else { "" },
                )))
                @if detected.decisions.is_empty() {
                    (fact("Decision", "none in this recording"))
                }
                @for (index, decision) in detected.decisions.iter().enumerate() {
                    (fact(if index == 0 { "Decision" } else { "" }, in_words(detected, decision)))
                }
                tr {
                    th scope="row" { "What it became" }
                    td { (became(detected, impacts)) }
                }
            }
        }
        (estimate_section::content(&estimates))
        (figure(&drawing, caption))
        @if compared.is_empty() {
            p.note {
                "The prediction of the last estimate for each sensor is not known, because it could not be computed again from the \
                 recorded measurements."
            }
        } @else {
            h3 { "Measured and predicted" }
            p {
                "The readings of each sensor and their prediction by the last estimate, computed again from the recorded \
                 measurements. The same readings have weighed the predictions: a band shows how well they are explained, not \
                 how well they were predicted."
            }
            @for (name, drawing) in &compared {
                (figure(drawing, &format!("Readings of {} and their prediction by the weighted responses.",
                    name.strip_prefix("sensor_").unwrap_or(name))))
            }
        }
    })
}

fn figure(drawing: &str, caption: &str) -> Markup {
    html! {
        figure role="img" aria-label=(caption) {
            (PreEscaped(drawing))
            figcaption { (caption) }
        }
    }
}

/// When it was detected, and by which sensor.
fn detection(detected: &DetectedImpact, first: &EstimateRecord) -> String {
    let contact = &first.detection.contact;
    let after = first.detection.confirmed_at - contact.time;
    let sensor = detected.sensors.get(first.detection.sensor);
    let at = first
        .origin
        .saturating_add((1e9 * contact.time).round() as i64);
    format!(
        "contact at {}; confirmed by {} {} later",
        instant(at),
        sensor.map_or("a sensor", |it| &it.name),
        Unit::time(1.0).show(after)
    )
}

/// Up to when an estimate used data.
fn since_contact(record: &EstimateRecord) -> String {
    let since = record.estimate.data_until - record.detection.contact.time;
    Unit::time(1.0).show(since)
}

/// What has become of the estimate, when, and by whom.
fn in_words(detected: &DetectedImpact, decision: &DetectedDecision) -> String {
    let mut estimates = detected.estimates.iter();
    let record = estimates.find(|it| it.update == decision.update);
    let then = record.map_or(String::new(), |record| {
        format!(" (data until {} after contact)", since_contact(record))
    });
    let event = decision.merged_event_id.as_deref().unwrap_or_default();
    let what = match decision.decision {
        Decision::Pending => "open again".to_owned(),
        Decision::Accepted if event.is_empty() => "accepted as an impact of the twin".to_owned(),
        Decision::Accepted => {
            format!("the event \"{event}\" is the same impact, and was merged as evidence")
        }
        Decision::Merged => {
            format!("the event \"{event}\" is the same impact, and the twin follows the event")
        }
        Decision::Declined => "declined".to_owned(),
        Decision::Rejected => "rejected, because the column could not take it".to_owned(),
    };
    let by = match (&decision.by, decision.decision) {
        (Some(by), _) => format!(", by {by}"),
        (None, Decision::Accepted) if event.is_empty() => {
            ", by the twin itself (estimation.accept)".to_owned()
        }
        (None, _) => String::new(),
    };
    format!("{what} with estimate {}{then}{by}", decision.update)
}

/// The impact of the twin that it became, with a link to its section.
fn became(detected: &DetectedImpact, impacts: &[ReportedImpact]) -> Markup {
    let Some(event_id) = detected.became() else {
        return html! { "no impact of the twin" };
    };
    let is_it = |impact: &ReportedImpact| {
        let event = impact.event.as_ref();
        event.is_some_and(|(id, _)| *id == event_id)
    };
    let Some(index) = impacts.iter().position(is_it) else {
        return html! { "impact \"" (event_id) "\" of the twin, which has no section in this report" };
    };
    let section = match impacts.len() {
        1 => "#impact".to_owned(),
        _ => format!("#impact-{}", index + 1),
    };
    let ReportedImpact {
        vehicle,
        impact,
        velocity,
        report,
        ..
    } = &impacts[index];
    let vehicle = match vehicle.as_str() {
        "" | RIGID => "rigid mass or user-defined vehicle",
        name => name,
    };
    let length = |value: f64| Unit::length(value).show(value);
    html! {
        a href=(section) { "impact \"" (event_id) "\"" }
        ": " (vehicle) ", " (short(impact.mass.round())) " kg with " (significant(*velocity, 3)) " m/s; "
        (outcome_in_words(report.outcome)) ", largest v₁ " (length(report.max_v1))
        @if let Some(residual) = report.residual_v1 { ", " (length(residual)) " remain" }
    }
}
