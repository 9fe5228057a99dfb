//! The report about an impact that was estimated from the readings of sensors.

use maud::{Markup, PreEscaped, html};

use super::document::{changed_parameters, page, parameters_json, program_facts};
use super::estimate_section;
use super::facts::fact;
use super::limits_section;
use super::words::short;
use crate::estimation::RecordedImpact;
use crate::figures::units::significant;
use crate::figures::{EstimateFigures, FigureError, TimedEstimate, estimate_svg};
use crate::parameters::Parameters;
use crate::sensors::Sensor;

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
        let contact = self.impact.detection.contact.time;
        let estimates = TimedEstimate::all(&self.impact.estimates, contact);
        let body = html! {
            section.impact id="impact" {
                (estimate_section::verdict(&estimates))
                h1 { (title) }
                p.note { "The column is assumed to be undamaged before the impact." }
                (estimate_section::content(&estimates))
            }
            (self.figures(&drawings))
            (limits_section::markup())
            (self.provenance())
        };
        Ok(page(&title, &body))
    }

    /// Every parameter, for the JSON file beside the report.
    #[must_use]
    pub fn parameters_json(&self) -> String {
        parameters_json(&[(1, self.parameters)])
    }

    fn figures(&self, drawings: &[(String, String)]) -> Markup {
        html! {
            section id="figures" {
                h2 { "Measured and predicted" }
                p {
                    "The same readings have weighed the predictions: a band shows how well the responses explain the readings, not how well they predict."
                }
                @for (index, (name, svg)) in drawings.iter().enumerate() {
                    @let caption = match name.strip_prefix("sensor_") {
                        Some(sensor) => format!("Readings of {sensor} and their prediction by the weighted responses."),
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
