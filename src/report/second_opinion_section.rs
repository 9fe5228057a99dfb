//! The page of the report about the second opinion.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::facts::fact;
use super::numbered_figures::Figures;
use super::reported_impact::ReportedImpact;
use super::words::{instead_of_a_residual, millimetres, short};
use crate::column::Outcome;
use crate::figures::units::significant;
use crate::second_opinion::{BAND, SecondOpinion, is_out_of_plane};

/// What the fibre beam says beside the two bars; nothing where it was not asked.
pub(super) fn markup(
    impact: &ReportedImpact,
    assessed: &Assessed,
    figures: &mut Figures,
) -> Markup {
    html! {
        @match &assessed.second_opinion {
            None => {}
            Some(Err(reason)) => {
                h3 { "Second opinion" }
                p { (reason) "." }
            }
            Some(Ok(opinion)) => {
                section.sheet.second-opinion {
                    h3 { "Second opinion" }
                    p { (agreement(opinion)) }
                    (comparison(impact, opinion))
                    @match &impact.beam {
                        Some(_) => {
                            (figures.markup("second_opinion_shape", &shapes(opinion)))
                            (figures.markup("second_opinion_displacement", &displacements(opinion)))
                        }
                        None => { p.note { "The movement of the beam is not drawn: the damage before this hit is not known." } }
                    }
                    (of_the_beam(opinion))
                }
            }
        }
    }
}

/// What the figure of the shapes shows.
fn shapes(opinion: &SecondOpinion) -> String {
    let across = match is_out_of_plane(opinion.direction) {
        true => {
            " Right: the displacement of the beam across the hit, which the two bars do not see."
        }
        false => "",
    };
    format!(
        "Shape of the column at the peak and at rest after the hit by the two bars and by the fibre beam, to one scale.{across} {}",
        in_brief(opinion)
    )
}

/// What the figure of the displacements shows.
fn displacements(opinion: &SecondOpinion) -> String {
    format!(
        "Displacement of the impact point over time, from the touch on, by the two bars and by the fibre beam, whose response ends \
         soon after its peak. {}",
        in_brief(opinion)
    )
}

/// Whether both models agree, in one sentence.
fn in_brief(opinion: &SecondOpinion) -> &'static str {
    match (opinion.agrees(), opinion.ratio_to_two_bars) {
        (true, _) => "Both models agree on the peak, on what remains and on how the response ends.",
        (false, Some(_)) => "The two models part.",
        (false, None) => "The two bars do not see this hit.",
    }
}

/// Whether both models agree, in words.
fn agreement(opinion: &SecondOpinion) -> String {
    let mut text = "The same hit was computed with a fibre beam in space, which bends about both axes, shears, twists and yields along \
                    its whole length. "
        .to_owned();
    text += in_brief(opinion);
    if !opinion.counts.is_empty() {
        text += &format!(
            " The verdict of the beam counts, because {}; {}.",
            opinion.counts_because(),
            match opinion.decides {
                true => "it is more severe than that of the two bars, and decides",
                false => "that of the two bars is as severe or more",
            }
        );
    }
    text
}

fn comparison(impact: &ReportedImpact, opinion: &SecondOpinion) -> Markup {
    let (beam, report) = (&opinion.beam, &impact.report);
    let length = |metres: f64| match metres.is_finite() {
        true => millimetres(metres),
        false => instead_of_a_residual(report.outcome).to_owned(),
    };
    let ratio = |ratio: f64| match ratio.is_finite() {
        true => significant(ratio, 3),
        false => String::new(),
    };
    let residual = report.residual_v1.unwrap_or(f64::NAN);
    let touch = report.first_contact_time.unwrap_or(0.0);
    // From the undamaged column, as the two bars count.
    let [peak, remains] = opinion.from_undamaged();
    let rows = [
        (
            "peak",
            length(report.max_v1),
            length(peak[0]),
            opinion.ratio_to_two_bars.map_or(String::new(), ratio),
        ),
        (
            "time of the peak, from the touch",
            format!("{} ms", significant(1e3 * (report.max_v1_time - touch), 3)),
            format!("{} ms", significant(1e3 * beam.max_displacement_time_s, 3)),
            String::new(),
        ),
        (
            "what remains",
            length(residual),
            length(remains[0]),
            match opinion.ratio_to_two_bars {
                Some(_) if residual.abs() > 1e-5 => ratio(remains[0] / residual),
                _ => String::new(),
            },
        ),
        (
            "peak across the hit",
            "not known".to_owned(),
            length(peak[1]),
            String::new(),
        ),
        (
            "residual across the hit",
            "not known".to_owned(),
            length(remains[1]),
            String::new(),
        ),
        (
            "residual bow at any height",
            length(residual.abs()),
            match beam.residual_bow_m.is_finite() {
                true => format!(
                    "{} at {} m",
                    length(beam.residual_bow_m),
                    significant(beam.residual_bow_height_m, 3)
                ),
                false => length(f64::NAN),
            },
            match residual.abs() > 1e-5 {
                true => ratio(beam.residual_bow_m / residual.abs()),
                false => String::new(),
            },
        ),
        (
            "largest shear of the base, over 1 ms",
            format!("{} kN", short(1e-3 * report.base.peak_shear.shear.abs())),
            format!("{} kN", short(1e-3 * beam.base_shear_n)),
            ratio(beam.base_shear_n / report.base.peak_shear.shear.abs()),
        ),
        (
            "largest moment of the base, over 1 ms",
            format!(
                "{} kN m",
                short(1e-3 * report.base.peak_moment.moment.abs())
            ),
            match beam.base_moment_n_m.is_finite() {
                true => format!("{} kN m", short(1e-3 * beam.base_moment_n_m)),
                false => "not recorded".to_owned(),
            },
            ratio(beam.base_moment_n_m / report.base.peak_moment.moment.abs()),
        ),
    ];
    html! {
        table {
            thead { tr { th { "" } th { "two bars" } th { "fibre beam" } th { "ratio" } } }
            tbody {
                @for (name, bars, beam, ratio) in &rows {
                    tr { th scope="row" { (name) } td { (bars) } td { (beam) } td { (ratio) } }
                }
            }
        }
    }
}

fn of_the_beam(opinion: &SecondOpinion) -> Markup {
    let beam = &opinion.beam;
    let [undamaged, left] = opinion.capacity.map(|force| short(1e-3 * force));
    let outcome = match opinion.outcome() {
        Outcome::Elastic => "elastic: no fibre has yielded",
        Outcome::Plastic => "plastic: fibres have yielded, and the column stands",
        Outcome::Collapsed | Outcome::Fractured => "COLLAPSED: the column gives way under its load",
    };
    html! {
        table.facts {
            tbody {
                (fact("Outcome of the beam", outcome))
                (fact("Axial capacity of the beam, bowed", format!("{undamaged} kN undamaged, {left} kN after the impact")))
                (fact("Action by the beam", opinion.action().map_or("not assessed", |action| action.name())))
                (fact("Elements", format!("{}, error of the peak about {:.1} %", beam.elements, 100.0 * beam.error_estimate)))
                (fact("Band of agreement", format!("the peaks may differ by a factor of {} before the verdict of the beam counts", short(BAND))))
            }
        }
    }
}
