//! The four pages about one impact: what has to be done, the checks, the column after the hit, and how sure that is.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::checks;
use super::details::ReportDetails;
use super::facts::fact;
use super::impact_section::{facts, result_rows};
use super::inspection;
use super::limits_section;
use super::reported_impact::ReportedImpact;
use super::shape_drawing;
use super::sketch;
use super::title_block;
use super::uncertainty;
use super::verdict::Verdict;
use super::words::{base_rows, in_kilo, shortened};
use crate::figures::units::{Unit, significant};

/// Most characters of the description of an impact in a heading.
const MAX_HEADING: usize = 110;

/// The four pages; `number` among several impacts. The title block is on the first page of a report about one impact, and so are the
/// `notices` of what has happened to the recording, before the verdict and after it.
pub(super) fn markup(
    impact: &ReportedImpact,
    assessed: &Result<Assessed, String>,
    details: &ReportDetails,
    number: Option<usize>,
    notices: Option<&[Markup; 2]>,
) -> Markup {
    let anchor = number.map_or("impact".to_owned(), |number| format!("impact-{number}"));
    let title = shortened(&impact.title, MAX_HEADING);
    let heading = match number {
        Some(number) => format!("Impact {number}: {title}"),
        None => format!("Impact report: {title}"),
    };
    let verdict = Verdict::of(impact, assessed);
    html! {
        section.impact id=(anchor) {
            div.sheet.first {
                @if let Some([before, _]) = notices { (before) }
                (verdict.markup(""))
                @if let Some([_, after]) = notices { (after) }
                h1 { (heading) }
                (verdict.people())
                (inspection::markup(impact, assessed))
                (sketch::markup(impact))
                @if number.is_none() { (title_block::markup(details, Some(impact))) }
            }
            div.sheet {
                p.running { (heading) }
                (facts(impact, assessed))
                @match assessed {
                    Ok(assessed) => { (checks::deciding(assessed)) }
                    Err(reason) => { h2 { "Checks that decide" } p.fault { "Not made, because " (reason) "." } }
                }
            }
            div.sheet {
                p.running { (heading) }
                h2 { "The column after the hit" }
                (shape_drawing::markup(impact))
                (results(impact))
                (base(impact, assessed))
                (capacity(assessed))
            }
            div.sheet {
                p.running { (heading) }
                (uncertainty::markup(impact, assessed))
                (limits_section::markup())
            }
        }
    }
}

fn results(impact: &ReportedImpact) -> Markup {
    html! {
        table.compact {
            thead { tr { th { "quantity" } th.number { "value" } th.number { "over the height" } th.number { "time" } } }
            tbody {
                @for row in result_rows(impact) {
                    tr { th scope="row" { (row.name) } td.number { (row.value) } td.number { (row.part) } td.number { (row.time) } }
                }
            }
        }
    }
}

fn base(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let base = assessed.as_ref().ok().and_then(|it| it.base.as_ref());
    html! {
        h2 { "Base reactions" }
        table.compact {
            caption {
                "During the hit, means over 1 ms except for the plateau; the axial force is positive in tension. "
                @match base {
                    Some(base) if base.is_assumed => { "Resistances: of an assumed plate [A], without partial factors." }
                    Some(_) => { "Resistances: of the plate that is given, without partial factors." }
                    None => { "The connection is not known: no resistance." }
                }
            }
            thead {
                tr {
                    th { "at" } th.number { "shear, kN" } th.number { "moment, kNm" } th.number { "axial force, kN" }
                    th.number { "shear resistance, kN" } th.number { "moment resistance, kNm" }
                }
            }
            tbody {
                @for (name, forces) in base_rows(&impact.report.base) {
                    tr {
                        th scope="row" { (name) }
                        @for number in in_kilo(forces) { td.number { (number) } }
                        @match base {
                            Some(base) => {
                                td.number { (format!("{:.0}", 1e-3 * base.resistance.shear(forces.normal_force))) }
                                td.number {
                                    @if base.bears_moment { (format!("{:.0}", 1e-3 * base.resistance.moment(forces.normal_force))) }
                                    @else { "pinned" }
                                }
                            }
                            None => { td.number { "-" } td.number { "-" } }
                        }
                    }
                }
            }
        }
    }
}

/// What is left of the axial resistance, in three lines; the annex has the rest.
fn capacity(assessed: &Result<Assessed, String>) -> Markup {
    let Ok(assessed) = assessed else {
        return html! {};
    };
    let remaining = &assessed.remaining;
    let force = |si: f64| Unit::force(si).show(si);
    let times = |value: Option<f64>| match value {
        Some(value) => format!(" = {} times the load", significant(value, 3)),
        None => String::new(),
    };
    html! {
        h2 { "Axial resistance that is left" }
        table.facts.compact {
            tbody {
                (fact("Share of the new column", format!("{:.0} % (push-down analysis)", 100.0 * remaining.ratio)))
                (fact("About the strong axis", format!("{} of {}{}", force(remaining.axial_capacity),
                    force(remaining.strong.force), times(remaining.reserve))))
                (fact("About the weaker axis", match remaining.resistance {
                    Some(left) => format!("{}{}", force(left), times(remaining.resistance_over_load())),
                    None => "not known: the dimensions of the section are not given".to_owned(),
                }))
            }
        }
    }
}
