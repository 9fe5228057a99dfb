//! The report about an impact that was estimated from the readings of sensors.

use maud::{Markup, PreEscaped, html};

use super::assessed::action;
use super::document::{all_parameters, changed_parameters, fact, limits, page, program_facts};
use super::verdict::class_of;
use super::words::{capitalised, short};
use crate::assessment::Severity;
use crate::figures::units::{Unit, significant};
use crate::figures::{EstimateFigures, FigureError, estimate_svg};
use crate::parameters::Parameters;
use crate::senses::{CredibleInterval, FEWEST_RESPONSES, ImpactEstimate, RecordedImpact, Sensor};

/// Probability below which a vehicle is not named.
const LEAST_NAMED: f64 = 0.005;

/// A report about an impact that was estimated.
#[derive(Debug, Clone, Copy)]
pub struct EstimateDocument<'a> {
    /// Parameters of the column.
    pub parameters: &'a Parameters,
    /// Its sensors.
    pub sensors: &'a [Sensor],
    /// The impact.
    pub impact: &'a RecordedImpact,
    /// Where the readings come from.
    pub source: &'a str,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl EstimateDocument<'_> {
    /// The HTML text.
    ///
    /// # Errors
    /// A figure cannot be drawn.
    pub fn html(&self) -> Result<String, FigureError> {
        let column = &self.parameters.settings().column_id;
        let title = format!("Impact estimated from sensors: column {column}");
        let drawings = estimate_svg(&EstimateFigures {
            title: &format!("column {column}, readings of {}", self.source),
            sensors: self.sensors,
            impact: self.impact,
        })?;
        let body = html! {
            @if let Some(last) = self.impact.estimates.last() {
                section.impact id="impact" {
                    (verdict(last))
                    h1 { (title) }
                    (reservations(last))
                    (numbers(last))
                    (probabilities(last))
                    (self.history())
                }
            }
            (self.figures(&drawings))
            (limits())
            (self.provenance())
            (all_parameters(self.parameters, None))
        };
        Ok(page(&title, &body))
    }

    fn history(&self) -> Markup {
        let contact = self.impact.detection.contact.time;
        html! {
            h2 { "How the estimate grew" }
            table {
                caption { "Means with 90 % intervals, by the data up to each time after contact." }
                thead { tr {
                    th.number { "data until" } th.number { "momentum" } th.number { "peak v₁" } th.number { "residual v₁" }
                    th { "severity" }
                } }
                tbody {
                    @for estimate in &self.impact.estimates {
                        tr {
                            td.number { (Unit::time(1.0).show(estimate.data_until - contact)) }
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

    fn figures(&self, drawings: &[(String, String)]) -> Markup {
        html! {
            section id="figures" {
                h2 { "Measured and predicted" }
                p {
                    "The same readings have weighed the predictions: a band shows how well the responses explain what was \
                     measured, not what they foresee."
                }
                @for (index, (name, svg)) in drawings.iter().enumerate() {
                    @let caption = match name.strip_prefix("sensor_") {
                        Some(sensor) => format!("Readings of {sensor} against what the weighted responses say that it reads."),
                        None => "Largest and remaining displacement of the impact point, over the time up to which data were \
                                 used.".to_owned(),
                    };
                    figure role="img" aria-label=(caption) {
                        (PreEscaped(svg))
                        figcaption { "Figure " (index + 1) ". " (caption) }
                    }
                }
            }
        }
    }

    fn provenance(&self) -> Markup {
        let detection = &self.impact.detection;
        let sensor = self.sensors.get(detection.sensor);
        html! {
            section id="provenance" {
                h2 { "Provenance" }
                table.facts {
                    tbody {
                        (program_facts())
                        (fact("Origin", format!("readings of {}", self.source)))
                        (fact("Sensors", names(self.sensors)))
                        (fact("Instant of contact", format!("{} s in the readings, confirmed by {}",
                            significant(detection.contact.time, 6), sensor.map_or("an unknown sensor", |it| &it.name))))
                        (fact("Seed of the random numbers", self.seed.to_string()))
                    }
                }
                h3 { "Parameters that differ from the defaults" }
                (changed_parameters(self.parameters))
            }
        }
    }
}

fn names(sensors: &[Sensor]) -> String {
    let each = sensors.iter().map(|sensor| {
        let quantity = sensor.quantity.word().replace('_', " ");
        format!("{} ({quantity} at {} m)", sensor.name, short(sensor.height))
    });
    each.collect::<Vec<_>>().join(", ")
}

fn likeliest(estimate: &ImpactEstimate) -> Option<&(Severity, f64)> {
    estimate.severity.iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The most probable severity, with the probability of a more severe one.
fn verdict(estimate: &ImpactEstimate) -> Markup {
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
            "The column is assumed to be virgin before the impact. The intervals contain the noise of the sensors and the \
             model's own error as docs/estimation.md describes it."
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
        h2 { "What struck, and what remains" }
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
