//! How far the numbers of an impact may be off: the time step, the range of the verdict, and the band of hardening and
//! softening.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::facts::fact;
use super::reported_impact::ReportedImpact;
use super::words::{instead_of_a_residual, outcome_in_words, short};
use crate::assessment::{ActionRange, Variation, capitalised};
use crate::column::Report;
use crate::figures::units::Unit;

/// Error of the step, range of the verdict, band of the steel, and where the error of the model is described.
pub(super) fn markup(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let range = match assessed {
        Ok(assessed) => assessed.range.as_ref().map_err(|reason| *reason),
        Err(_) => Err("there is no assessment"),
    };
    let beam = assessed.as_ref().ok().and_then(Assessed::beam);
    let error = beam.map(|opinion| opinion.beam.error_estimate);
    let models = match impact.is_oblique() {
        true => "Each row is by the model that decides there. ",
        false => "",
    };
    html! {
        h2 { "How sure this is" }
        table.facts {
            tbody {
                (fact("Time step", match impact.error_estimate() {
                    Some(error) => format!(
                        "{:.1e} of the peak displacement, estimated by a second run with half the step of {} µs",
                        error, short(impact.model.step_secs * 1e6)
                    ),
                    None => "not estimated".to_owned(),
                }))
                (fact("Energy balance", format!("largest residual {:.1e} of the energy of the vehicle", impact.report.ledger_residual)))
                @if let Some(error) = error.filter(|it| it.is_finite()) {
                    (fact("Fibre beam", format!("{:.1} % of its peak displacement, estimated by a second run with fewer elements", 100.0 * error)))
                }
                (fact("Model", "see the limits below"))
            }
        }
        @match range {
            Ok(range) => {
                @if range.variations.is_empty() { p { "Range of the verdict: " (range) "." } }
                @else { (range_table(range, models)) }
                @for (assumption, reason) in &range.not_varied {
                    p.note { (capitalised(assumption.in_words())) " was not varied: " (reason) "." }
                }
            }
            Err(reason) => { p.note { "The range of the verdict was not computed: " (reason) "." } }
        }
    }
}

/// The band of the steel, for the annex.
pub(super) fn band(assessed: &Result<Assessed, String>) -> Markup {
    let range = assessed.as_ref().ok().and_then(|it| it.range.as_ref().ok());
    let range = range.filter(|it| it.band().is_some());
    html! {
        @if let Some(range) = range {
            h3 { "Band of the steel" }
            (band_table(range))
        }
    }
}

/// One assumption after the other, with the action to which it leads.
fn range_table(range: &ActionRange, models: &str) -> Markup {
    let row = |it: &Variation| {
        let (max, residual) = displacements(&it.report);
        html! {
            tr {
                th scope="row" { (capitalised(it.assumption.in_words())) }
                td { (it.instead) }
                td { (outcome_in_words(it.report.outcome)) }
                td.number { (max) }
                td.number { (residual) }
                td.word { (it.action.name()) }
            }
        }
    };
    html! {
        table.compact {
            caption {
                "Range of the verdict: " (range) ". " (models) "Each assumption is changed alone [A]; two that both err on the unsafe side may lead \
                 beyond this range."
            }
            thead { tr {
                th { "what is not known exactly" } th { "instead" } th { "outcome" }
                th.number { "largest" } th.number { "residual" } th { "action" }
            } }
            tbody { @for variation in &range.variations { (row(variation)) } }
        }
    }
}

/// Largest and residual displacement of the impact point.
fn displacements(report: &Report) -> (String, String) {
    let unit = Unit::length(report.max_v1);
    (unit.show(report.max_v1), residual(report, unit))
}

/// The residual displacement of the impact point, or why there is none.
fn residual(report: &Report, unit: Unit) -> String {
    let instead = || instead_of_a_residual(report.outcome).to_owned();
    report.residual_v1.map_or_else(instead, |it| unit.show(it))
}

fn band_table(range: &ActionRange) -> Markup {
    let Some([weakest, strongest]) = range.band() else {
        return html! {};
    };
    let [least, most] = [weakest, strongest].map(|end| end.hardening_ratio);
    let softens = weakest.softens;
    let (weakest, strongest) = (&weakest.report, &strongest.report);
    let length = Unit::length(weakest.max_v1.max(strongest.max_v1));
    let force = Unit::force(weakest.peak_contact_force.max(strongest.peak_contact_force));
    let buckling = if softens {
        "local buckling"
    } else {
        "no local buckling"
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
                 relative to its modulus of elasticity, and in when their flanges and web buckle locally. A web of the weaker one that \
                 yields in shear bears without its flanges. The result lies between these two; the weaker one is on the safe side for \
                 displacements, the stronger one for forces."
            }
            thead { tr { th { "quantity" }
                th.number { "hardening " (least) ", " (buckling) }
                th.number { "hardening " (most) ", no local buckling" }
            } }
            tbody {
                (row("peak displacement of the impact point", &|report| length.show(report.max_v1)))
                (row("residual displacement of the impact point", &|report| residual(report, length)))
                (row("largest plastic rotation", &rotation))
                (row("peak contact force, without impact impulses", &|report| force.show(report.peak_contact_force)))
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
