//! How far the numbers of an impact may be off: the time step, and the band of hardening and softening.

use maud::{Markup, html};

use super::document::fact;
use super::reported_impact::ReportedImpact;
use super::words::{outcome_in_words, short};
use crate::assessment::{Severity, WholeFront, band_properties};
use crate::column::{ColumnProperties, Model, PerBar, Report};
use crate::figures::units::Unit;

/// The same impact on the columns of [`band_properties`].
struct Band {
    weakest: Report,
    strongest: Report,
    /// Whether the weakest one softens.
    softens: bool,
    /// Their hardening.
    hardening: [f64; 2],
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
            Err(reason) => { p.note { "The band of hardening and softening was not computed: " (reason) "." } }
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
    let with = |changed: ColumnProperties| {
        if changed == properties {
            return Ok(impact.report);
        }
        struck
            .with_properties(&changed)
            .ok_or("these parameters allow no hardening".to_owned())?
            .report()
            .map_err(|error| error.to_string())
    };
    let [weakest, strongest] = band_properties(&properties);
    Ok(Band {
        softens: weakest.softening.is_some(),
        hardening: [weakest.hardening_ratio, strongest.hardening_ratio],
        weakest: with(weakest)?,
        strongest: with(strongest)?,
    })
}

fn band_table(
    Band {
        weakest,
        strongest,
        softens,
        hardening: [least, most],
    }: &Band,
) -> Markup {
    let length = Unit::length(weakest.max_v1.max(strongest.max_v1));
    let force = Unit::force(weakest.peak_contact_force.max(strongest.peak_contact_force));
    let buckling = if *softens {
        "local buckling"
    } else {
        "no local buckling"
    };
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
            tr { th scope="row" { (name) } td.number { (of(weakest)) } td.number { (of(strongest)) } }
        }
    };
    html! {
        table.compact {
            caption {
                "Band of the steel. Columns of one section and one yield strength differ in the slope of the steel after yield, here \
                 relative to its modulus of elasticity, and in when their flanges and web buckle locally. The result lies between \
                 these two; the weaker one is on the safe side for displacements, the stronger one for forces."
            }
            thead { tr { th { "quantity" }
                th.number { "hardening " (least) ", " (buckling) }
                th.number { "hardening " (most) ", no local buckling" }
            } }
            tbody {
                (row("largest displacement of the impact point", &|report| length.show(report.max_v1)))
                (row("residual displacement of the impact point", &residual))
                (row("largest plastic rotation", &rotation))
                (row("peak contact force, without percussions", &|report| force.show(report.peak_contact_force)))
                @if weakest.outcome != strongest.outcome {
                    tr {
                        th scope="row" { "outcome" }
                        td { (outcome_in_words(weakest.outcome)) }
                        td { (outcome_in_words(strongest.outcome)) }
                    }
                }
            }
        }
    }
}
