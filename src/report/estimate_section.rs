//! What a report says of the estimates of one impact, the last of which counts.

use maud::{Markup, html};

use super::verdict::{action, class_of};
use super::words::capitalised;
use crate::assessment::Severity;
use crate::figures::TimedEstimate;
use crate::figures::units::{Unit, significant};
use crate::senses::{CredibleInterval, FEWEST_RESPONSES, ImpactEstimate};

/// Probability below which a vehicle is not named.
const LEAST_NAMED: f64 = 0.005;

/// The last estimate in numbers, and how it grew.
pub(super) fn content(estimates: &[TimedEstimate<'_>]) -> Markup {
    html! {
        @if let Some(TimedEstimate { estimate, .. }) = estimates.last() {
            (reservations(estimate))
            (numbers(estimate))
            (probabilities(estimate))
            (history(estimates))
        }
    }
}

fn history(estimates: &[TimedEstimate<'_>]) -> Markup {
    html! {
        h3 { "How the estimate grew" }
        table {
            caption { "Means with 90 % intervals, by the data up to each time after contact." }
            thead { tr {
                th.number { "data until" } th.number { "momentum" } th.number { "peak v₁" } th.number { "residual v₁" }
                th { "severity" }
            } }
            tbody {
                @for TimedEstimate { since_contact, estimate } in estimates {
                    tr {
                        td.number { (Unit::time(1.0).show(*since_contact)) }
                        td.number { (cell(&estimate.momentum, 1e-3, "kN s")) }
                        td.number { (cell(&estimate.peak_v1, 1e3, "mm")) }
                        td.number { (cell(&estimate.residual_v1, 1e3, "mm")) }
                        td { @if let Some((severity, share)) = likeliest(estimate) {
                            (severity.to_string()) " " (percent(*share))
                        } }
                    }
                }
            }
        }
    }
}

fn likeliest(estimate: &ImpactEstimate) -> Option<&(Severity, f64)> {
    estimate.severity.iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The box with the most probable severity by the last estimate, and the probability of a more severe one.
pub(super) fn verdict(estimates: &[TimedEstimate<'_>]) -> Markup {
    let Some(TimedEstimate { estimate, .. }) = estimates.last() else {
        return html! {};
    };
    let Some((severity, share)) = likeliest(estimate) else {
        return html! {};
    };
    let worse = estimate.severity.iter().filter(|(it, _)| it > severity);
    let worse: f64 = worse.map(|(_, share)| share).sum();
    html! {
        div.verdict.(class_of(*severity)) {
            p.headline {
                (capitalised(&severity.to_string())) " with a probability of " (percent(*share))
                "; more severe with " (percent(worse))
            }
            p { strong { (action(*severity)) } }
            p {
                "From the readings of the sensors: the column has yielded with a probability of " (percent(estimate.yielded))
                ", and collapses or is torn with " (percent(estimate.collapsed)) "."
            }
        }
    }
}

fn reservations(estimate: &ImpactEstimate) -> Markup {
    html! {
        @if estimate.effective_responses < FEWEST_RESPONSES {
            p.fault {
                "The estimate rests on " (significant(estimate.effective_responses, 2)) " effective responses; its intervals \
                 are unreliable."
            }
        }
        @if !estimate.doubtful_sensors.is_empty() {
            p.fault {
                (estimate.doubtful_sensors.join(", ")) " contradicts the other sensors; check its scale, sign and position."
            }
        }
        p.note {
            "The intervals contain the noise of the sensors and the model's own error as docs/estimation.md describes it."
        }
    }
}

fn numbers(estimate: &ImpactEstimate) -> Markup {
    let rows = [
        ("Mass of the vehicle", &estimate.mass, 1.0, "kg"),
        ("Speed of the vehicle", &estimate.velocity, 1.0, "m/s"),
        ("Momentum", &estimate.momentum, 1e-3, "kN s"),
        ("Largest v₁", &estimate.peak_v1, 1e3, "mm"),
        ("v₁ that remains", &estimate.residual_v1, 1e3, "mm"),
        (
            "Remaining capacity over that of the virgin column",
            &estimate.capacity_ratio,
            100.0,
            "%",
        ),
    ];
    html! {
        h3 { "What struck, and what remains" }
        table.compact {
            caption { "v₁ is the transverse displacement of the impact point." }
            thead { tr { th {} th.number { "mean" } th.number { "90 % interval" } } }
            tbody {
                @for (name, interval, factor, unit) in rows {
                    tr {
                        th scope="row" { (name) }
                        td.number { (number(factor * interval.mean)) " " (unit) }
                        td.number { (number(factor * interval.low)) " to " (number(factor * interval.high)) " " (unit) }
                    }
                }
            }
        }
    }
}

fn probabilities(estimate: &ImpactEstimate) -> Markup {
    let severities = estimate.severity.iter();
    let vehicles = estimate.vehicle_probabilities.iter();
    html! {
        h3 { "Probabilities" }
        table.compact {
            tbody {
                @for (severity, share) in severities {
                    tr { th scope="row" { "Severity: " (severity.to_string()) } td.number { (percent(*share)) } }
                }
                @for (vehicle, share) in vehicles.filter(|(_, share)| *share >= LEAST_NAMED) {
                    tr { th scope="row" { "Vehicle: " (vehicle) } td.number { (percent(*share)) } }
                }
            }
        }
    }
}

fn cell(interval: &CredibleInterval, factor: f64, unit: &str) -> String {
    let CredibleInterval { mean, low, high } = interval;
    let [mean, low, high] = [mean, low, high].map(|it| number(factor * it));
    format!("{mean} ({low} to {high}) {unit}")
}

fn number(value: f64) -> String {
    match value.is_finite() {
        true => significant(value, 3),
        false => "unknown".to_owned(),
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
