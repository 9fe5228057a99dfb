//! What a report says of the estimates of one impact, the last of which counts.

use maud::{Markup, html};

use super::verdict::{class_of, instruction};
use crate::assessment::{Action, capitalised};
use crate::estimation::{CredibleInterval, FEWEST_RESPONSES, ImpactEstimate};
use crate::figures::TimedEstimate;
use crate::figures::units::{Unit, significant};

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
                th { "action" }
            } }
            tbody {
                @for TimedEstimate { since_contact, estimate } in estimates {
                    tr {
                        td.number { (Unit::time(1.0).show(*since_contact)) }
                        td.number { (cell(&estimate.momentum, 1e-3, "kN s")) }
                        td.number { (cell(&estimate.peak_v1, 1e3, "mm")) }
                        td.number { (cell(&estimate.residual_v1, 1e3, "mm")) }
                        td { @if let Some((action, share)) = likeliest(estimate) {
                            (action.to_string()) " " (percent(*share))
                        } }
                    }
                }
            }
        }
    }
}

fn likeliest(estimate: &ImpactEstimate) -> Option<&(Action, f64)> {
    estimate.action.iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The box with the most probable action by the last estimate, and the probability of a more severe one.
pub(super) fn verdict(estimates: &[TimedEstimate<'_>]) -> Markup {
    let Some(TimedEstimate { estimate, .. }) = estimates.last() else {
        return html! {};
    };
    let Some((action, share)) = likeliest(estimate) else {
        return html! {};
    };
    let worse = estimate.action.iter().filter(|(it, _)| it > action);
    let worse: f64 = worse.map(|(_, share)| share).sum();
    html! {
        div.verdict.(class_of(*action)) {
            p.headline {
                (capitalised(&action.to_string())) " with a probability of " (percent(*share))
                "; more severe with " (percent(worse))
            }
            p { strong { (instruction(*action)) } }
            @if estimate.tells_collapse() {
                p { strong { "The column collapses or is fractured." } }
            }
            p {
                "From the readings of the sensors: the column has yielded with a probability of " (percent(estimate.yielded))
                ", and collapses or is fractured with " (percent(estimate.collapsed)) "."
            }
        }
    }
}

fn reservations(estimate: &ImpactEstimate) -> Markup {
    html! {
        @if estimate.effective_sample_size < FEWEST_RESPONSES {
            p.fault {
                "The effective sample size of the estimate is " (significant(estimate.effective_sample_size, 2)) "; its intervals \
                 are unreliable."
            }
        }
        @if let Some(doubt) = estimate.doubt_in_words() {
            p.fault { (doubt) }
        }
        @for note in estimate.notes() {
            p.note { (note) }
        }
        p.note {
            "The intervals contain the noise of the sensors and the model's own error as docs/estimation.md describes it."
        }
    }
}

fn numbers(estimate: &ImpactEstimate) -> Markup {
    let rows = [
        ("Mass of the vehicle", "mass", &estimate.mass, 1.0, "kg"),
        (
            "Speed of the vehicle",
            "velocity",
            &estimate.velocity,
            1.0,
            "m/s",
        ),
        ("Momentum", "momentum", &estimate.momentum, 1e-3, "kN s"),
        ("Largest v₁", "", &estimate.peak_v1, 1e3, "mm"),
        ("v₁ that remains", "", &estimate.residual_v1, 1e3, "mm"),
        (
            "Residual over undamaged capacity",
            "",
            &estimate.capacity_ratio,
            100.0,
            "%",
        ),
    ];
    let not_known = estimate.not_known();
    html! {
        h3 { "Vehicle and residual damage" }
        table.compact {
            caption { "v₁ is the transverse displacement of the impact point." }
            thead { tr { th {} th.number { "mean" } th.number { "90 % interval" } } }
            tbody {
                @for (name, quantity, interval, factor, unit) in rows {
                    tr {
                        th scope="row" { (name) }
                        td.number {
                            @if not_known.contains(&quantity) { "not known" } @else {
                                (number(factor * interval.mean)) " " (unit)
                            }
                        }
                        td.number { (number(factor * interval.low)) " to " (number(factor * interval.high)) " " (unit) }
                    }
                }
            }
        }
    }
}

fn probabilities(estimate: &ImpactEstimate) -> Markup {
    let actions = estimate.action.iter();
    let vehicles = estimate.vehicle_probabilities.iter();
    html! {
        h3 { "Probabilities" }
        table.compact {
            tbody {
                @for (action, share) in actions {
                    tr { th scope="row" { "Action: " (action.to_string()) } td.number { (percent(*share)) } }
                }
                @for (vehicle, share) in vehicles.filter(|(_, share)| *share >= LEAST_NAMED) {
                    tr { th scope="row" { "Front like: " (vehicle) } td.number { (percent(*share)) } }
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
