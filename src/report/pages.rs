//! The four pages about one impact: what has to be done, the checks, the column after the hit, and how sure that is.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::beam_words;
use super::checks;
use super::details::ReportDetails;
use super::facts::fact;
use super::impact_section::{ResultRow, displacement_rows, facts, response_rows};
use super::inspection;
use super::limits_section;
use super::reported_impact::ReportedImpact;
use super::shape_drawing;
use super::sketch;
use super::title_block;
use super::uncertainty;
use super::verdict::Verdict;
use super::words::{base_rows, described, in_kilo, short, shortened};
use crate::column::Impact;
use crate::figures::units::{Unit, significant};
use crate::parameters::degrees;

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
    let title = shortened(&one_line(impact), MAX_HEADING);
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
            div.sheet.drawn {
                p.running { (heading) }
                h2 { "The column after the hit" }
                (shape_drawing::markup(impact, assessed))
                (results(impact, assessed))
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

/// Column and hit in one line.
fn one_line(impact: &ReportedImpact) -> String {
    let whole = Impact {
        velocity: impact.velocity,
        ..impact.impact
    };
    let angle = match impact.is_oblique() {
        true => format!(", {} to the web", degrees(impact.direction)),
        false => String::new(),
    };
    let below = impact.model.properties.length_below;
    described(&impact.parameters, &impact.vehicle, &whole, below, &angle)
}

/// What the two bars leave out, for a caption.
const COMPONENT: &str =
    "By the two bars, of the component of the hit in their plane: they do not see the whole hit.";

/// The same where the hit has no component in it.
const NOT_SEEN: &str = "The two bars do not see this hit, which is at right angles to their plane.";

fn results(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let beam = assessed.as_ref().ok().and_then(Assessed::by_beam);
    let is_oblique = impact.is_oblique();
    let caption = match (is_oblique, beam) {
        (true, _) => COMPONENT,
        (false, Some(_)) => "By the two bars.",
        (false, None) => "",
    };
    // The beam has the whole displacement.
    let mut of_bars = match is_oblique && beam.is_some() {
        true => Vec::new(),
        false => displacement_rows(impact),
    };
    of_bars.extend(response_rows(impact));
    html! {
        @if let Some(by_beam) = beam {
            (table_of_results("By the fibre beam.", &beam_words::rows(by_beam)))
        }
        @if impact.is_seen_by_the_bars() { (table_of_results(caption, &of_bars)) }
        @else { p.note { (NOT_SEEN) } }
    }
}

fn table_of_results(caption: &str, rows: &[ResultRow]) -> Markup {
    html! {
        table.compact {
            @if !caption.is_empty() { caption { (caption) } }
            thead { tr { th { "quantity" } th.number { "value" } th.number { "over the height" } th.number { "time" } } }
            tbody {
                @for row in rows {
                    tr { th scope="row" { (row.name) } td.number { (row.value) } td.number { (row.part) } td.number { (row.time) } }
                }
            }
        }
    }
}

fn base(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let beam = assessed.as_ref().ok().and_then(Assessed::beam);
    html! {
        h2 { "Base reactions" }
        @if impact.is_seen_by_the_bars() { (base_of_bars(impact, assessed)) }
        @else { p.note { (NOT_SEEN) } }
        @if let Some(opinion) = beam {
            p {
                "By the fibre beam, the shear of the base along the hit is " (short(1e-3 * opinion.beam.base_shear_n)) " kN at most"
                @if opinion.beam.base_moment_n_m.is_finite() {
                    ", and the moment of the base that bends the column along the hit "
                    (short(1e-3 * opinion.beam.base_moment_n_m)) " kN m"
                }
                ", as means over 1 ms."
            }
        }
    }
}

fn base_of_bars(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let base = assessed.as_ref().ok().and_then(|it| it.base.as_ref());
    html! {
        table.compact {
            caption {
                @if impact.is_oblique() { "By the two bars, of the component in their plane. " }
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
    let remaining = &assessed.left;
    let model = match assessed.beam() {
        Some(_) => "fibre beam",
        None => "push-down analysis",
    };
    let force = |si: f64| Unit::force(si).show(si);
    let times = |value: Option<f64>| match value {
        Some(value) => format!(" = {} times the load", significant(value, 3)),
        None => String::new(),
    };
    html! {
        h2 { "Axial resistance that is left" }
        table.facts.compact {
            tbody {
                (fact("Share of the new column", format!("{:.0} % ({model})", 100.0 * remaining.ratio)))
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
