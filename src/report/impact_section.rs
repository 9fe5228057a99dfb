//! What one impact was, and the annex with its computation.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::assessment_section;
use super::checks;
use super::energy_balance::EnergyBalance;
use super::facts::fact;
use super::numbered_figures::Figures;
use super::reported_impact::ReportedImpact;
use super::second_opinion_section;
use super::uncertainty;
use super::words::{end_in_words, instead_of_a_residual, part_of, shortened};
use crate::column::{Outcome, Report, Support, share_in_plane};
use crate::figures::units::{Unit, significant};
use crate::figures::{FigureError, PushDownCurves, draw_svg, push_down_svg};
use crate::observables::{HINGE_PLACES, WEB_PLACES};
use crate::parameters::{CatalogueVehicle, degrees, plate_in_words, split_crush};
use crate::time::Nanos;

/// The annex about one impact; `number` among several impacts.
pub(super) fn annex(
    impact: &ReportedImpact,
    assessed: &Result<Assessed, String>,
    number: Option<usize>,
) -> Result<Markup, FigureError> {
    let mut drawings = draw_svg(&impact.history())?;
    if let Ok(assessed) = assessed {
        let curves = PushDownCurves {
            title: &impact.title,
            undamaged: &assessed.undamaged,
            now: &assessed.now,
            remaining: &assessed.remaining,
        };
        drawings.push(("push_down".to_owned(), push_down_svg(&curves)?));
    }
    let mut figures = Figures::new(drawings, number);
    let anchor = number.map_or("annex".to_owned(), |number| format!("annex-{number}"));
    Ok(html! {
        section.annex id=(anchor) {
            h1 {
                @match number {
                    Some(number) => { "Annex to impact " (number) ": the computation" }
                    None => { "Annex: the computation" }
                }
            }
            @for remark in &impact.remarks { p.note { (remark) } }
            (plateau(impact, assessed))
            @if let Ok(assessed) = assessed { (checks::others(assessed)) }
            (capacity(assessed, &mut figures))
            @if let Ok(assessed) = assessed { (second_opinion_section::markup(impact, assessed, &mut figures)) }
            h3 { "Response" }
            (figures.markup("fig5_horizontal_displacement", "Displacement of the impact point and of the impactor over time."))
            (hinges(impact))
            (webs(impact))
            (figures.markup("fig8_bending_moments", "Bending moments of the hinges over time; rings mark the first yield."))
            (figures.yield_path(impact.governing_hinge()))
            h3 { "Contact" }
            (figures.markup("contact_force", "Force between vehicle and column over time."))
            (figures.markup("contact_force_spectrum", FORCE_SPECTRUM))
            (vehicle(impact, &mut figures))
            (energy(impact, &mut figures))
            (uncertainty::band(assessed))
            h3 { "Axial response" }
            (figures.markup("fig6_vertical_displacement", "Vertical displacement of the impact point and of the top over time."))
            (figures.markup("fig7_normal_forces", "Normal forces of both bars over time."))
        }
    })
}

/// What the figure of the response spectrum shows.
const FORCE_SPECTRUM: &str = "Equivalent static force of the contact, by the period of a member that is pushed by the same force: a static force \
                              of this size would bend an undamped elastic member as far.";

/// What hit what, with the one load with which the column is judged.
pub(super) fn facts(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let parameters = &impact.parameters;
    let section = parameters.section();
    let steel = parameters.steel();
    let properties = &impact.model.properties;
    let force = |si: f64| Unit::force(si).show(si);
    html! {
        h2 { "What hit what" }
        table.facts {
            tbody {
                @if let Some((event_id, stamp)) = &impact.event {
                    tr { th scope="row" { "Event" } td { (shortened(event_id, MAX_NAME)) } }
                    (fact("Time of the event", when_in_words(*stamp)))
                }
                (fact("Section, steel", format!("{}, {}f_y = {} MPa", section.name.unwrap_or("user-defined"),
                    steel.grade.map_or(String::new(), |grade| format!("{grade}, ")), significant(steel.yield_strength * 1e-6, 4))))
                (fact("Height, supports", format!("{} m; base {}, top {}",
                    significant(impact.height(), 4), support(&properties.base), support(&properties.top))))
                (fact("Axial load", match assessed {
                    Ok(assessed) => assessed.assessment.load.clone(),
                    Err(_) => force(properties.top_load),
                }))
                (fact("Vehicle", vehicle_in_words(impact)))
                (fact("Speed", format!("{} km/h ({} m/s)", significant(3.6 * impact.velocity, 4), significant(impact.velocity, 4))))
                @if impact.is_oblique() {
                    (fact("Direction", format!("{} to the web; the two bars see {:.0} % of the speed", degrees(impact.direction),
                        100.0 * share_in_plane(impact.direction))))
                }
                (fact("Height of the impact", format!("{} m above the base", significant(properties.length_below, 4))))
                (fact("Largest utilisation", utilisation(impact, assessed)))
            }
        }
    }
}

/// How close the column comes to yielding, whatever decides.
fn utilisation(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> String {
    let beam = assessed.as_ref().ok().and_then(Assessed::beam);
    let beam = beam.map(|opinion| match opinion.outcome() {
        Outcome::Elastic => "below 100 % by the fibre beam, which stays elastic",
        _ => "100 %: the column yields by the fibre beam",
    });
    match (beam, impact.is_oblique()) {
        (None, false) => utilisations(impact),
        (None, true) => format!(
            "by the component in the plane of the two bars only: {}",
            utilisations(impact)
        ),
        (Some(beam), true) => beam.to_owned(),
        (Some(beam), false) => format!("{beam}; by the two bars {}", utilisations(impact)),
    }
}

/// The same by the two bars.
fn utilisations(impact: &ReportedImpact) -> String {
    let report = &impact.report;
    let share = |value: f64| format!("{:.0} %", 100.0 * value.min(1.0));
    let bending = report.hinges.iter().map(|it| it.max_utilisation);
    let web = report.webs.iter().map(|it| it.max_utilisation);
    let shear = match impact.model.properties.shear {
        Some(_) => share(web.fold(0.0, f64::max)),
        None => "not evaluated".to_owned(),
    };
    format!(
        "bending with axial force {}, shear of the web {shear}; the column yields at 100 %",
        share(bending.fold(0.0, f64::max))
    )
}

/// Most characters of the name of an event on the page of the checks.
const MAX_NAME: usize = 80;

/// Names in full, the plateau, and where the numbers of the vehicle come from.
fn plateau(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let force = |si: f64| Unit::force(si).show(si);
    html! {
        table.facts {
            tbody {
                (fact("Column", &impact.parameters.settings().column_id))
                (fact("Impact", &impact.title))
                @if let Some((event_id, _)) = &impact.event { (fact("Event", event_id)) }
                @if let Ok(assessed) = assessed {
                    (fact("Plastic plateau of the column", format!("F0 = {}: the force at the impact point at which its hinges \
                        form a mechanism", force(assessed.plateau))))
                    @if let Some(front) = assessed.front_force {
                        (fact("Plateau over crush force", format!("{}, with {} as the largest force of the vehicle's front: above 1 \
                            the front crushes first, below 1 the column bends first", significant(assessed.plateau / front, 3), force(front))))
                    }
                    @if let Some(base) = &assessed.base {
                        (fact("Base plate", format!("{}{}", plate_in_words(&base.plate), if base.is_assumed { "; assumed [A]" } else { "" })))
                    }
                }
                @if let Some(sources) = vehicle_sources(&impact.vehicle) {
                    (fact("Sources of the vehicle", sources))
                }
                (fact("Distance at the event", format!("{} m", significant(impact.impact.gap, 4))))
            }
        }
    }
}

#[cfg(feature = "record")]
pub(super) fn when_in_words(stamp: Nanos) -> String {
    crate::recording::instant(stamp)
}

#[cfg(not(feature = "record"))]
pub(super) fn when_in_words(stamp: Nanos) -> String {
    format!("{stamp} ns after 1970")
}

fn support(support: &Support) -> String {
    match support {
        Support::BuiltIn => "built in".to_owned(),
        Support::Pinned => "pinned".to_owned(),
        Support::Free => "free".to_owned(),
        Support::SemiRigid { stiffness } => {
            format!("semi-rigid ({} kN m/rad)", significant(stiffness * 1e-3, 4))
        }
    }
}

fn vehicle_in_words(impact: &ReportedImpact) -> String {
    let mass = significant(impact.impact.mass, 4);
    let Some(vehicle) = &impact.impact.vehicle else {
        return format!(
            "rigid mass of {mass} kg, restitution {}: it does not crush, which overestimates the effect of a real vehicle",
            significant(impact.impact.restitution, 3)
        );
    };
    let described = CatalogueVehicle::of_crushed(&impact.vehicle);
    let name = described.map_or("user-defined".to_owned(), |it| {
        format!("{}: {}", it.name, it.description)
    });
    let crushed = split_crush(&impact.vehicle).1;
    let crushed = crushed.map_or(String::new(), |it| {
        format!(", which earlier impacts have crushed by {it} m")
    });
    let masses: Vec<_> = vehicle
        .masses()
        .iter()
        .map(|mass| significant(*mass, 4))
        .collect();
    format!(
        "{name}; {} kg, with a front that crushes{crushed}",
        masses.join(" + ")
    )
}

/// Where the numbers of a vehicle of the catalogue come from.
fn vehicle_sources(name: &str) -> Option<String> {
    let vehicle = CatalogueVehicle::of_crushed(name)?;
    let springs = vehicle.springs.iter().enumerate();
    let sources = springs
        .map(|(index, spring)| format!("spring {} [{}] {}", index + 1, spring.tag, spring.source));
    let masses = &vehicle.masses;
    let all: Vec<_> = std::iter::once(format!("masses [{}] {}", masses.tag, masses.source))
        .chain(sources)
        .collect();
    Some(all.join("; "))
}

fn capacity(assessed: &Result<Assessed, String>, figures: &mut Figures) -> Markup {
    html! {
        h3 { "Residual axial capacity" }
        @match assessed {
            Ok(assessed) => {
                (assessment_section::capacity(assessed))
                (figures.markup("push_down", "Axial force over the shortening of the column, undamaged and as it is."))
            }
            Err(reason) => { p.note { "Not computed: " (reason) "." } }
        }
    }
}

/// A row of the table of results.
pub(super) struct ResultRow {
    pub name: &'static str,
    pub value: String,
    /// As a part of the height; empty where that says nothing.
    pub part: String,
    pub time: String,
}

/// A length that remains after a response, or why it does not.
fn residual(report: &Report, value: Option<f64>, unit: Unit) -> String {
    let instead = || instead_of_a_residual(report.outcome).to_owned();
    value.map_or_else(instead, |value| unit.show(value))
}

fn row(name: &'static str, value: String, part: String, time: String) -> ResultRow {
    ResultRow {
        name,
        value,
        part,
        time,
    }
}

/// How the two bars move the impact point and the top.
pub(super) fn displacement_rows(impact: &ReportedImpact) -> Vec<ResultRow> {
    let report = &impact.report;
    let v1 = Unit::length(report.max_v1);
    let u2 = Unit::length(report.max_u2);
    let part = |value: f64| part_of(value, impact.height());
    let none = String::new;
    vec![
        row(
            "peak displacement of the impact point",
            v1.show(report.max_v1),
            part(report.max_v1),
            Unit::time(report.end_time).show(report.max_v1_time),
        ),
        row(
            "residual displacement of the impact point (bow)",
            residual(report, report.residual_v1, v1),
            report.residual_v1.map_or_else(none, part),
            none(),
        ),
        row(
            "kink that remains at the impact point",
            format!("{:.2}°", impact.kink().to_degrees()),
            none(),
            none(),
        ),
        row(
            "largest lowering of the top, with the elastic one",
            u2.show(report.max_u2),
            none(),
            none(),
        ),
        row(
            "lowering of the top at rest, with the elastic one",
            residual(report, report.residual_u2, u2),
            none(),
            none(),
        ),
    ]
}

/// What else their response comes to.
pub(super) fn response_rows(impact: &ReportedImpact) -> Vec<ResultRow> {
    let report = &impact.report;
    let at = |secs: f64| Unit::time(report.end_time).show(secs);
    let when = |secs: Option<f64>| secs.map_or("-".to_owned(), at);
    let force = Unit::force(report.peak_contact_force);
    let none = String::new;
    let mut rows = vec![
        row(
            "first contact",
            none(),
            none(),
            when(report.first_contact_time),
        ),
        row("last separation", none(), none(), when(report.release_time)),
        row(
            "peak contact force, without impact impulses",
            force.show(report.peak_contact_force),
            none(),
            when(report.peak_contact_force_time),
        ),
        row(
            "impulse, including impact impulses",
            format!("{} N s", significant(report.impulse, 4)),
            none(),
            none(),
        ),
        row(
            "final velocity of the vehicle",
            format!("{} m/s", significant(report.impactor_velocity, 4)),
            none(),
            none(),
        ),
    ];
    // That of the component alone is of no use.
    if !impact.is_oblique() {
        rows.push(row(
            "end of the response",
            end_in_words(report.end).to_owned(),
            none(),
            at(report.end_time),
        ));
    }
    rows
}

fn hinges(impact: &ReportedImpact) -> Markup {
    let report = &impact.report;
    let time = Unit::time(report.end_time);
    let dynamic = impact.model.properties.rate.is_some();
    html! {
        h3 { "Hinges" }
        table.compact {
            thead {
                tr { th { "hinge" } th.number { "first yield" } th.number { "plastic rotation" } th.number { "utilisation" }
                    @if dynamic { th.number { "strength by strain rate" } } }
            }
            tbody {
                @for (index, (hinge, place)) in report.hinges.iter().zip(HINGE_PLACES).enumerate() {
                    tr {
                        th scope="row" { (place.name) ", " (place.words) }
                        td.number { (hinge.first_yield.map_or("never".to_owned(), |secs| time.show(secs))) }
                        td.number {
                            (significant(hinge.plastic_rotation, 3)) " rad (" (format!("{:.2}", hinge.plastic_rotation.to_degrees())) "°)"
                        }
                        td.number { (format!("{:.3}", hinge.max_utilisation)) }
                        @if dynamic { td.number { "× " (format!("{:.3}", report.max_dynamic_factor[index])) } }
                    }
                }
            }
        }
    }
}

/// The shear of the webs, or why it is not evaluated.
fn webs(impact: &ReportedImpact) -> Markup {
    let report = &impact.report;
    let time = Unit::time(report.end_time);
    html! {
        @match impact.parameters.shear() {
            Err(why) => {
                h3 { "Shear of the web" }
                p { "Not evaluated: " (why) "." }
            }
            Ok(shear) => {
                h3 { "Shear of the web" }
                table.compact {
                    thead {
                        tr { th { "web" } th.number { "resistance" } th.number { "first yield" } th.number { "plastic angle" }
                            th.number { "utilisation" } }
                    }
                    tbody {
                        @for (index, (web, place)) in report.webs.iter().zip(WEB_PLACES).enumerate() {
                            @let length = impact.model.properties.clear_lengths()[index];
                            tr {
                                th scope="row" { (place.name) ", " (place.words) }
                                td.number { (Unit::force(shear.resistance(length)).show(shear.resistance(length))) }
                                td.number { (web.first_yield.map_or("never".to_owned(), |secs| time.show(secs))) }
                                td.number {
                                    (significant(web.plastic_angle, 3)) " rad (" (format!("{:.2}", web.plastic_angle.to_degrees())) "°)"
                                }
                                td.number { (format!("{:.3}", web.max_utilisation)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn vehicle(impact: &ReportedImpact, figures: &mut Figures) -> Markup {
    let crushed = &impact.report.vehicle;
    html! {
        @if crushed.masses > 0 {
            h3 { "Vehicle" }
            table.compact {
                thead {
                    tr {
                        th { "spring, front first" } th.number { "largest crush" } th.number { "permanent crush" }
                        th.number { "energy absorbed" } th.number { "final velocity of its mass" }
                    }
                }
                tbody {
                    @for index in 0..crushed.masses {
                        tr {
                            th scope="row" { (index + 1) }
                            td.number { (significant(1e3 * crushed.max_crush[index], 4)) " mm" }
                            td.number { (significant(1e3 * crushed.permanent_crush[index], 4)) " mm" }
                            td.number { (significant(1e-3 * crushed.dissipated[index], 4)) " kJ" }
                            td.number { (significant(crushed.velocity[index], 4)) " m/s" }
                        }
                    }
                }
            }
            (figures.markup("force_crush", "Force of each spring of the vehicle over its crush, with the envelope of the force."))
        }
    }
}

fn energy(impact: &ReportedImpact, figures: &mut Figures) -> Markup {
    let balance = EnergyBalance::from(&impact.report);
    let supplied = balance.supplied();
    let row = |name: &str, energy: f64| {
        let part = if supplied > 0.0 {
            100.0 * energy / supplied
        } else {
            0.0
        };
        html! {
            th scope="row" { (name) }
            td.number { (format!("{:.1}", energy + 0.0)) }
            td.number { (format!("{part:.2}")) }
        }
    };
    html! {
        h3 { "Energy" }
        table.compact {
            thead { tr { th { "at the end" } th.number { "J" } th.number { "% of the supply" } } }
            tbody {
                @for entry in &balance.spent { tr { (row(&entry.name, entry.energy)) } }
                tr.sum { (row("sum", balance.sum())) }
                tr { (row("supplied by the vehicle", balance.by_impactor)) }
                tr { (row("supplied by the load", balance.by_load)) }
                tr.sum { (row("supplied in total", supplied)) }
            }
        }
        (figures.markup("energy_ledger", "Energy over time: the stack of all entries reaches the energy supplied until then."))
    }
}
