//! What the report says of a recording as a whole: the overview of its impacts, its origin and its verification.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::facts::fact;
use super::recorded::{RecordedFile, ReportedRecording};
use super::reported_impact::ReportedImpact;
use super::verdict::Verdict;
use super::words::short;
use crate::evidence::{About, Verification, build};
use crate::figures::units::Unit;
use crate::recording::{EventSummary, instant};
use crate::results::outcome_word;
use crate::study::{LIMIT_VELOCITIES, VehicleLimits};

/// Maximum number of events in the overview; of more events, the last ones are listed.
const MAX_ROWS: usize = 500;

/// What is wrong with the recording, before the verdict on it, and which impacts the verdict does not contain, after it: whoever
/// signs the verdict must see both.
pub(super) fn notices(recorded: &ReportedRecording, impacts: &[ReportedImpact]) -> [Markup; 2] {
    let before = html! {
        @if let Some((headline, reason)) = faults(recorded) {
            div.verdict.alarm {
                p.headline { (headline) }
                p { (reason) }
            }
        }
    };
    let after = html! {
        @let open = without_outcome(recorded, impacts);
        @if !open.is_empty() {
            p.fault {
                "Accepted after the last impact with an outcome, without one in this recording: " (open.join(", "))
                ". The verdict does not contain their effect on the column."
            }
        }
    };
    [before, after]
}

/// The head of the document: where it does not contain one impact alone, the notices and the last verdict; a table of all impacts.
pub(super) fn overview(recorded: &ReportedRecording, impacts: &[ReportedImpact]) -> Markup {
    // Those of a single impact stand on the page that is signed.
    let [before, after] = match impacts.len() {
        1 => Default::default(),
        _ => notices(recorded, impacts).map(Some),
    };
    let faults = faults(recorded);
    let several = impacts.len() > 1;
    let last = impacts.last().filter(|_| several);
    let last = last.and_then(|last| Some((last, &last.event.as_ref()?.0)));
    let unreported = impacts.is_empty() || recorded.events.len() > impacts.len();
    html! {
        @if let Some(before) = before { (before) }
        @if let Some((last, event_id)) = last {
            (Verdict::of(last, &Assessed::of(last)).markup(&format!("After impact \"{event_id}\": ")))
        }
        @if let Some(after) = after { (after) }
        @if impacts.is_empty() && faults.is_none() {
            div.verdict.warning {
                p.headline { "No verdict: no impact of this recording has an outcome" }
                p { "The table gives the outcome of each." }
            }
        }
        @if several || unreported {
            section id="overview" {
                h2 { "Impacts of the recording" }
                (table(recorded, impacts))
            }
        }
        @if let Some(vehicles) = recorded.critical_velocities.as_deref().filter(|it| !it.is_empty()) {
            (critical_velocities(vehicles))
        }
    }
}

/// How fast each vehicle may hit the column next.
fn critical_velocities(vehicles: &[VehicleLimits]) -> Markup {
    let velocity = |velocity: Option<f64>| match velocity {
        None => format!("not up to {} m/s", short(LIMIT_VELOCITIES[1])),
        Some(0.0) => "any speed".to_owned(),
        Some(velocity) => format!("{velocity:.1} m/s"),
    };
    html! {
        section id="critical-velocities" {
            h2 { "How fast a vehicle may hit the column next" }
            p {
                "The speed from which on one more impact leads to an action, on the column with the damage that it has at the end of "
                "this recording. A speed limit needs a margin for the uncertainty of the model and of the vehicle."
            }
            table.events {
                thead {
                    tr { th { "vehicle" } th.number { "mass" } th.number { "restrict" } th.number { "evacuate" } }
                }
                tbody {
                    @for it in vehicles {
                        tr {
                            th scope="row" { @if it.vehicle.is_empty() { "user-defined" } @else { (it.vehicle) } }
                            td.number { (short(it.mass)) " kg" }
                            td.number { (velocity(it.restrict)) }
                            td.number { (velocity(it.evacuate)) }
                        }
                    }
                }
            }
        }
    }
}

/// Impacts after the last one with an outcome that were accepted and have none.
fn without_outcome<'r>(
    recorded: &'r ReportedRecording,
    impacts: &[ReportedImpact],
) -> Vec<&'r str> {
    let last = impacts
        .iter()
        .filter_map(|impact| Some(impact.event.as_ref()?.1))
        .max();
    let events = recorded.events.iter();
    events
        .filter(|event| event.rejected.is_none() && event.outcome.is_none())
        .filter(|event| {
            last.zip(event.stamp)
                .is_some_and(|(last, stamp)| stamp > last)
        })
        .map(|event| event.event_id.as_str())
        .collect()
}

/// What is so wrong with the recording that it comes before every verdict.
fn faults(recorded: &ReportedRecording) -> Option<(String, String)> {
    match &recorded.verification {
        Err(reason) => Some((
            "This recording could not be verified".to_owned(),
            format!("{}. Only the contents of its messages are shown.", reason.trim_end_matches('.')),
        )),
        Ok(found) if found.is_contradicted() => Some((
            "This recording differs from its recomputation".to_owned(),
            format!(
                "{} differences, {} messages missing, of which the recording declares up to {} as lost. It was changed, or \
                 recorded by another build. The verdicts below come from the recomputation; see \"Verification\".",
                found.differences,
                found.missing(),
                found.declared_losses
            ),
        )),
        Ok(found) if found.is_unchecked() => Some((
            "Nothing in this recording could be verified".to_owned(),
            "The reasons are listed under \"Verification\".".to_owned(),
        )),
        Ok(_) if recorded.seal.fault().is_some() => recorded.seal.fault().map(|fault| {
            (
                "The seal shows that this recording was changed, or that one is missing".to_owned(),
                format!("In detail: {fault}. The remainder is equal to its recomputation."),
            )
        }),
        Ok(_) => recorded.incomplete.as_ref().map(|why| {
            (
                "This recording is not complete".to_owned(),
                format!("In detail: {why}. The report contains what can be read; impacts may be missing."),
            )
        }),
    }
}

fn table(recorded: &ReportedRecording, impacts: &[ReportedImpact]) -> Markup {
    let section_of = |event: &EventSummary| {
        let same = |impact: &&ReportedImpact| {
            impact.event.as_ref().is_some_and(|(id, stamp)| {
                *id == event.event_id && event.stamp.is_none_or(|it| it == *stamp)
            })
        };
        let index = impacts.iter().position(|impact| same(&impact))?;
        Some(match impacts.len() {
            1 => "impact".to_owned(),
            _ => format!("impact-{}", index + 1),
        })
    };
    let millimetres =
        |value: Option<f64>| value.map_or("-".to_owned(), |it| Unit::length(it).show(it));
    let hidden = recorded.events.len().saturating_sub(MAX_ROWS);
    html! {
        @if hidden > 0 { p.note { "The first " (hidden) " events are not listed; column-twin info lists all of them." } }
        table.events {
            thead {
                tr {
                    th { "event" } th { "time" } th.number { "mass" } th.number { "speed" }
                    th { "outcome" } th.number { "peak v1" } th.number { "residual v1" }
                }
            }
            tbody {
                @for event in &recorded.events[hidden..] {
                    tr {
                        th scope="row" {
                            @match section_of(event) {
                                Some(section) => { a href=(format!("#{section}")) { (event.event_id) } }
                                None => { (event.event_id) }
                            }
                        }
                        td { (event.stamp.map_or("-".to_owned(), instant)) }
                        td.number { (event.mass.map_or("-".to_owned(), |it| format!("{} kg", short(it)))) }
                        td.number { (event.velocity.map_or("-".to_owned(), |it| format!("{} m/s", short(it)))) }
                        td {
                            @match event.outcome {
                                Some(outcome) => { (outcome_word(outcome)) }
                                None => { (event.without_outcome()) }
                            }
                        }
                        td.number { (millimetres(event.max_v1)) }
                        td.number { (millimetres(event.residual_v1)) }
                    }
                }
            }
        }
        @if recorded.without_section > 0 {
            p.note {
                (recorded.without_section) " further outcomes have no section of their own; choose one with "
                code { "--event ID" } "."
            }
        }
    }
}

/// Rows about the origin of the recording.
pub(super) fn facts(recorded: &ReportedRecording) -> Markup {
    html! {
        (fact("Origin", match recorded.detected.is_empty() {
            true => "recording of a twin; the twin computes, and nothing was measured on the column",
            false => "recording of a twin, which computes; its sensors have detected impacts",
        }))
        (fact("Recording", recorded.path.display().to_string()))
        (fact("Written by", &recorded.written_by))
        @if let Ok(Verification { about: Some(About { build: recorded_build, .. }), .. }) = &recorded.verification {
            tr {
                th scope="row" { "Build of the recorder" }
                td {
                    code { (recorded_build) }
                    @if recorded_build == build() { ", which is this build" }
                    @else { ", another build than this report: results may differ in the last bits" }
                }
            }
        }
        (fact("Time", recorded.span.map_or("no messages".to_owned(), |(first, last)| {
            format!("{} to {}", instant(first), instant(last))
        })))
        (fact("Complete", recorded.incomplete.as_ref().map_or("yes".to_owned(), |why| format!("no: {why}"))))
        (fact("Declared losses", recorded.lost.map_or("unknown".to_owned(), |lost| format!("{lost} messages"))))
        @for (index, text) in recorded.seal.texts().iter().enumerate() {
            (fact(if index == 0 { "Seal" } else { "" }, text))
        }
        @for RecordedFile { name, fingerprint } in &recorded.files {
            tr {
                th scope="row" { "SHA-256 of " (name) }
                td {
                    @match fingerprint {
                        Ok((bytes, hash)) => { code { (hash) } " (" (bytes) " bytes)" }
                        Err(reason) => { "cannot be read again: " (reason) }
                    }
                }
            }
        }
    }
}

/// The result of the verification.
pub(super) fn verification(recorded: &ReportedRecording) -> Markup {
    html! {
        h3 { "Verification by recomputation" }
        @match &recorded.verification {
            Err(reason) => { p.fault { "Not verified: " (reason) } }
            Ok(found) => { (result(found)) }
        }
    }
}

fn result(found: &Verification) -> Markup {
    let all = found.unchecked_reasons == 0 && found.unchecked_messages() == 0;
    html! {
        @if found.is_equal() {
            p {
                strong { @if all { "Equal" } @else { "Equal as far as it could be checked" } }
                ": the twin was run again from " (found.checkpoints) " recorded state(s) with " (found.inputs)
                " command(s); " (found.compared()) " messages and " (found.states_at_rest)
                " states at rest are the same, bit for bit. This proves that the recording belongs to this computation; it does not \
                 prove that the model is right."
            }
        } @else {
            p.fault {
                (found.differences) " differences, " (found.missing()) " messages missing"
                @if let Some(first) = &found.first_difference { "; the first difference: " (first) }
                "."
            }
        }
        table {
            thead {
                tr {
                    th { "topic" } th.number { "recorded" } th.number { "compared" } th.number { "differing" }
                    th.number { "missing" } th.number { "not checked" }
                }
            }
            tbody {
                @for (topic, check) in found.rows() {
                    tr {
                        th scope="row" { (topic) }
                        td.number { (check.recorded) }
                        td.number { (check.compared) }
                        td.number { (check.differing + check.misplaced + check.unexpected) }
                        td.number { (check.missing) }
                        td.number { (check.unchecked) }
                    }
                }
            }
        }
        @for reason in &found.unchecked { p.note { "Not checked: " (reason) "." } }
        @let more = found.unchecked_reasons.saturating_sub(found.unchecked.len() as u64);
        @if more > 0 { p.note { "Not checked for " (more) " further reasons." } }
    }
}
