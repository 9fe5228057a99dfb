//! The section about one impact.

use maud::{Markup, PreEscaped, html};

use super::assessed::Assessed;
use super::assessment_section;
use super::energy_balance::EnergyBalance;
use super::facts::fact;
use super::reported_impact::ReportedImpact;
use super::uncertainty;
use super::verdict::Verdict;
use super::words::{base_rows, end_in_words, in_kilo};
use crate::column::{HINGE_NAMES, HINGES, Support, WEB_NAMES, WEBS};
use crate::figures::units::{Unit, significant};
use crate::figures::{FigureError, PushDownCurves, draw_svg, push_down_svg};
use crate::parameters::{CatalogueVehicle, split_crush};
use crate::shape::{HINGE_PLACES, WEB_PLACES};
use crate::time::Nanos;

/// The section; `number` among several impacts.
pub(super) fn markup(
    impact: &ReportedImpact,
    number: Option<usize>,
) -> Result<Markup, FigureError> {
    let drawings = draw_svg(&impact.history())?;
    let mut figures = Figures {
        drawings,
        impact_number: number,
        count: 0,
    };
    let assessed = Assessed::of(impact);
    if let Ok(assessed) = &assessed {
        let curves = PushDownCurves {
            title: &impact.title,
            virgin: &assessed.virgin,
            now: &assessed.now,
            remaining: &assessed.remaining,
        };
        figures
            .drawings
            .push(("push_down".to_owned(), push_down_svg(&curves)?));
    }
    let verdict = Verdict::of(impact, &assessed);
    let anchor = number.map_or("impact".to_owned(), |number| format!("impact-{number}"));
    Ok(html! {
        section.impact id=(anchor) {
            @if let Some(number) = number { h1 { "Impact " (number) ": " (impact.title) } }
            (verdict.markup(""))
            @if number.is_none() { h1 { "Impact report: " (impact.title) } }
            @for remark in &impact.remarks { p.note { (remark) } }
            (what_hit_what(impact, &assessed))
            @if let Ok(assessed) = &assessed { (assessment_section::criteria(assessed)) }
            (capacity(&assessed, &mut figures))
            (response(impact))
            (figures.markup("deformed_shape", "Shape of the column before the impact, at its largest displacement and at rest."))
            (figures.markup("fig5_horizontal_displacement", "Displacement of the impact point and of the impactor over time."))
            (hinges(impact))
            (webs(impact))
            (base(impact))
            (figures.markup("fig8_bending_moments", "Bending moments of the hinges over time; rings mark the first yield."))
            (figures.yield_path(impact.governing_hinge()))
            h3 { "Contact" }
            (figures.markup("contact_force", "Force between vehicle and column over time."))
            (vehicle(impact, &mut figures))
            (energy(impact, &mut figures))
            (uncertainty::markup(impact, &assessed))
            h3 { "Axial response" }
            (figures.markup("fig6_vertical_displacement", "Vertical displacement of the impact point and of the top over time."))
            (figures.markup("fig7_normal_forces", "Normal forces of both bars over time."))
        }
    })
}

/// The figures of the section, numbered in the order in which they appear.
struct Figures {
    drawings: Vec<(String, String)>,
    impact_number: Option<usize>,
    count: usize,
}

impl Figures {
    fn markup(&mut self, name: &str, caption: &str) -> Markup {
        let Some((_, svg)) = self.drawings.iter().find(|(drawn, _)| drawn == name) else {
            return html! {};
        };
        self.count += 1;
        let number = match self.impact_number {
            Some(impact) => format!("{impact}.{}", self.count),
            None => self.count.to_string(),
        };
        html! {
            figure role="img" aria-label=(caption) {
                (PreEscaped(svg))
                figcaption { "Figure " (number) ". " (caption) }
            }
        }
    }

    fn yield_path(&mut self, hinge: usize) -> Markup {
        let caption = format!(
            "Moment and normal force of hinge {} ({}), the most severely strained one, in its yield surface.",
            HINGE_NAMES[hinge], HINGE_PLACES[hinge]
        );
        self.markup(&format!("mn_path_{}", HINGE_NAMES[hinge]), &caption)
    }
}

fn what_hit_what(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let parameters = &impact.parameters;
    let settings = parameters.settings();
    let section = parameters.section();
    let steel = parameters.steel();
    let properties = &impact.model.properties;
    let given = |name: Option<&str>| name.unwrap_or("given by numbers").to_owned();
    let force = |si: f64| Unit::force(si).show(si);
    html! {
        h2 { "What hit what" }
        table.facts {
            tbody {
                @if let Some((event_id, stamp)) = &impact.event {
                    (fact("Event", event_id))
                    (fact("Time of the event", when_in_words(*stamp)))
                }
                (fact("Column", &settings.column_id))
                (fact("Section, steel", format!("{}, {} (f_y = {} MPa)", given(section.name), given(steel.grade),
                    significant(steel.yield_strength * 1e-6, 4))))
                (fact("Height, supports", format!("{} m; base {}, top {}",
                    significant(properties.length_below + properties.length_above, 4),
                    support(&properties.base), support(&properties.top))))
                (fact("Axial load carried", force(properties.top_load)))
                @if let Ok(assessed) = assessed {
                    (fact("Plastic plateau of the column", format!("F0 = {}: the force at the impact point at which its hinges \
                        form a mechanism", force(assessed.plateau))))
                    @if let Some(front) = assessed.front_force {
                        (fact("Plateau over crush force", format!("{}, with {} as the largest force of the vehicle's front: above 1 \
                            the front crushes first, below 1 the column bends first", significant(assessed.plateau / front, 3), force(front))))
                    }
                }
                (fact("Vehicle", vehicle_in_words(impact)))
                @if let Some(sources) = vehicle_sources(&impact.vehicle) {
                    (fact("Sources of the vehicle", sources))
                }
                (fact("Speed", format!("{} m/s ({} km/h)", significant(impact.impact.velocity, 4),
                    significant(3.6 * impact.impact.velocity, 4))))
                (fact("Height of the impact", format!("{} m above the base", significant(properties.length_below, 4))))
                (fact("Distance at the event", format!("{} m", significant(impact.impact.gap, 4))))
            }
        }
    }
}

#[cfg(feature = "record")]
fn when_in_words(stamp: Nanos) -> String {
    crate::recording::instant(stamp)
}

#[cfg(not(feature = "record"))]
fn when_in_words(stamp: Nanos) -> String {
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
            "rigid mass of {mass} kg, restitution {}: it does not crush, which overestimates what a real vehicle does",
            significant(impact.impact.restitution, 3)
        );
    };
    let described = CatalogueVehicle::of_crushed(&impact.vehicle);
    let name = described.map_or("given by numbers".to_owned(), |it| {
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
        h3 { "Remaining axial capacity" }
        @match assessed {
            Ok(assessed) => {
                (assessment_section::capacity(assessed))
                (figures.markup("push_down", "Axial force over the shortening of the column, virgin and as it is."))
            }
            Err(reason) => { p.note { "Not computed: " (reason) "." } }
        }
    }
}

fn response(impact: &ReportedImpact) -> Markup {
    let report = &impact.report;
    let time = |secs: f64| Unit::time(report.end_time).show(secs);
    let when = |secs: Option<f64>| secs.map_or("-".to_owned(), time);
    let (v1, u2) = (Unit::length(report.max_v1), Unit::length(report.max_u2));
    let force = Unit::force(report.peak_contact_force);
    let residual = |value: Option<f64>, unit: Unit| {
        value.map_or("none: no equilibrium".to_owned(), |value| unit.show(value))
    };
    let row = |name: &str, value: String, at: String| {
        html! { tr { th scope="row" { (name) } td.number { (value) } td.number { (at) } } }
    };
    html! {
        h3 { "Response" }
        table.compact {
            caption { "Times count from the event. The response ended at " (time(report.end_time)) " (" (end_in_words(report.end)) ")." }
            thead { tr { th { "quantity" } th.number { "value" } th.number { "time" } } }
            tbody {
                (row("largest displacement of the impact point, v1", v1.show(report.max_v1), time(report.max_v1_time)))
                (row("residual displacement of the impact point", residual(report.residual_v1, v1), String::new()))
                (row("largest lowering of the top, u2", u2.show(report.max_u2), String::new()))
                (row("residual lowering of the top", residual(report.residual_u2, u2), String::new()))
                (row("first contact", String::new(), when(report.first_contact_time)))
                (row("last separation", String::new(), when(report.release_time)))
                (row("peak contact force, without percussions", force.show(report.peak_contact_force),
                    when(report.peak_contact_force_time)))
                (row("impulse, including percussions", format!("{} N s", significant(report.impulse, 4)), String::new()))
                (row("final velocity of the vehicle", format!("{} m/s", significant(report.impactor_velocity, 4)), String::new()))
            }
        }
    }
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
                @for index in 0..HINGES {
                    @let hinge = &report.hinges[index];
                    tr {
                        th scope="row" { (HINGE_NAMES[index]) ", " (HINGE_PLACES[index]) }
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
                        @for index in 0..WEBS {
                            @let web = &report.webs[index];
                            @let length = impact.model.properties.clear_lengths()[index];
                            tr {
                                th scope="row" { (WEB_NAMES[index]) ", " (WEB_PLACES[index]) }
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

fn base(impact: &ReportedImpact) -> Markup {
    html! {
        h3 { "Base" }
        table.compact {
            caption {
                "Reactions of the base, means over 1 ms except for the plateau; the normal force is positive in tension. What is larger \
                 than the resistance of the connection stands among the criteria."
            }
            thead { tr { th { "at" } th.number { "shear force, kN" } th.number { "moment, kNm" } th.number { "normal force, kN" } } }
            tbody {
                @for (name, forces) in base_rows(&impact.report.base) {
                    tr {
                        th scope="row" { (name) }
                        @for number in in_kilo(forces) { td.number { (number) } }
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
