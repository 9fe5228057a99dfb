//! How far the numbers of an impact may be off: the time step, and the band between no hardening and one per cent.

use maud::{Markup, html};

use super::document::fact;
use super::reported_impact::ReportedImpact;
use super::words::{outcome_in_words, short};
use crate::assessment::{HARDENING_BAND, Severity, WholeFront};
use crate::column::{ColumnProperties, Model, PerBar, Report};
use crate::figures::units::Unit;

/// The same impact with and without hardening.
struct Band {
    /// Without hardening.
    ideal: Report,
    /// With the largest hardening of [`HARDENING_BAND`].
    hardening: Report,
}

/// Error of the step, band, and where the error of the model is described.
pub(super) fn markup(impact: &ReportedImpact) -> Markup {
    html! {
        h3 { "Uncertainty" }
        table.facts {
            tbody {
                (fact("Time step", match impact.error_estimate() {
                    Some(error) => format!(
                        "{:.1e} of the largest v1, estimated by a second run with half the step of {} µs",
                        error, short(impact.model.step_secs * 1e6)
                    ),
                    None => "not estimated".to_owned(),
                }))
                (fact("Energy balance", format!("largest residual {:.1e} of the energy of the vehicle", impact.report.ledger_residual)))
                @if let Some(whole) = whole_front(impact) {
                    (fact("Narrow object [A]", format!(
                        "the column is assumed to meet a part of the front only (vehicle.narrow_object); with the whole front: {}, \
                         largest displacement {}, severity {}",
                        outcome_in_words(whole.outcome),
                        Unit::length(whole.max_v1).show(whole.max_v1),
                        whole.severity.map_or("not assessed", Severity::name),
                    )))
                }
                (fact("Model", "see \"What this report cannot know\""))
            }
        }
        @match band(impact) {
            Ok(band) => { (band_table(&band)) }
            Err(reason) => { p.note { "The band between no hardening and one per cent was not computed: " (reason) "." } }
        }
    }
}

/// What the factor for narrow objects has changed, for a virgin column.
fn whole_front(impact: &ReportedImpact) -> Option<WholeFront> {
    let struck = impact.struck?;
    let is_virgin = struck.state.plastic == PerBar::default();
    let model = Model::new(&impact.parameters.column_properties());
    (is_virgin && model.is_ok_and(|model| model == impact.model))
        .then(|| WholeFront::of(&impact.parameters, &impact.impact))
        .flatten()
}

fn band(impact: &ReportedImpact) -> Result<Band, String> {
    let struck = impact
        .struck
        .ok_or("the column was still moving when the impact began")?;
    let plastic = &struck.state.plastic;
    let was_damaged = (0..2).any(|k| plastic.below.has_flowed(k) || plastic.above.has_flowed(k));
    if was_damaged {
        return Err(
            "the column was damaged before, and its hardening since then is not known".into(),
        );
    }
    let properties = impact.model.properties;
    let with = |hardening_ratio: f64| {
        if properties.hardening_ratio.to_bits() == hardening_ratio.to_bits() {
            return Ok(impact.report);
        }
        let changed = ColumnProperties {
            hardening_ratio,
            ..properties
        };
        struck
            .with_properties(&changed)
            .ok_or("these parameters allow no hardening".to_owned())?
            .report()
            .map_err(|error| error.to_string())
    };
    Ok(Band {
        ideal: with(HARDENING_BAND[0])?,
        hardening: with(HARDENING_BAND[1])?,
    })
}

fn band_table(Band { ideal, hardening }: &Band) -> Markup {
    let length = Unit::length(ideal.max_v1.max(hardening.max_v1));
    let force = Unit::force(ideal.peak_contact_force.max(hardening.peak_contact_force));
    let residual = |report: &Report| {
        report
            .residual_v1
            .map_or("none".to_owned(), |value| length.show(value))
    };
    let rotation = |report: &Report| {
        let rotations = report
            .hinges
            .iter()
            .map(|hinge| hinge.plastic_rotation.abs());
        format!("{:.4} rad", rotations.fold(0.0, f64::max))
    };
    let row = |name: &str, of: &dyn Fn(&Report) -> String| {
        html! {
            tr { th scope="row" { (name) } td.number { (of(ideal)) } td.number { (of(hardening)) } }
        }
    };
    html! {
        table.compact {
            caption {
                "Band of hardening, the slope of the steel after yield relative to its modulus of elasticity. Without hardening, \
                 displacements are on the safe side and forces on the unsafe side."
            }
            thead { tr { th { "quantity" } th.number { "no hardening" } th.number { "hardening " (HARDENING_BAND[1]) } } }
            tbody {
                (row("largest displacement of the impact point", &|report| length.show(report.max_v1)))
                (row("residual displacement of the impact point", &residual))
                (row("largest plastic rotation", &rotation))
                (row("peak contact force, without percussions", &|report| force.show(report.peak_contact_force)))
                @if ideal.outcome != hardening.outcome {
                    tr {
                        th scope="row" { "outcome" }
                        td { (outcome_in_words(ideal.outcome)) }
                        td { (outcome_in_words(hardening.outcome)) }
                    }
                }
            }
        }
    }
}
