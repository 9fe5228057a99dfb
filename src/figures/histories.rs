//! Displacements, forces and moments over time: the paper's Figures 5 to 8, and the contact force.

use super::chart::{Curve, ImpulseArrow, Mark, TimeChart};
use super::page::{Drawn, LegendKey, Stroke, colour};
use super::response_history::ResponseHistory;
use super::units::{Unit, significant};
use crate::column::{HINGE_NAMES, HINGES};
use crate::observables::{
    CONTACT_FORCE, IMPACT_IMPULSE, IMPACTOR, MOMENT, NORMAL_FORCE, U1, U2, V1, WEB_PLACES,
};

/// Figure 5: `v1` and the impactor's position `v_c`.
pub(super) fn horizontal_displacement(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::length(response.largest(&[V1]));
    let residual = report
        .residual_v1
        .map_or("none".into(), |value| unit.show(value));
    let key = format!(
        "peak {} at {}, residual {residual}; final velocity of the impactor {} m/s",
        unit.show(report.max_v1),
        response.time_unit().show(report.max_v1_time),
        significant(report.impactor_velocity, 4),
    );
    let title = "Horizontal displacement of the impact point and the impactor";
    TimeChart {
        curves: vec![
            response.curve(&V1, 0, Stroke::solid(colour::IMPACT_POINT, 18)),
            response.curve(&IMPACTOR, 0, Stroke::dashed(colour::IMPACTOR, 12)),
        ],
        marks: vec![peak(
            report.max_v1_time,
            report.max_v1,
            unit,
            colour::IMPACT_POINT,
        )],
        ..response.chart(title, &key, "displacement v", unit)
    }
    .draw()
}

/// Figure 6: `u1` and `u2`.
pub(super) fn vertical_displacement(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::length(response.largest(&[U1, U2]));
    let residual = report
        .residual_u2
        .map_or("none".into(), |value| unit.show(value));
    let outcome = response.outcome();
    let key = format!(
        "largest u₂ {}, residual {residual}; the column {outcome}",
        unit.show(report.max_u2)
    );
    let highest = response
        .samples
        .iter()
        .max_by(|one, other| one.u2.total_cmp(&other.u2));
    let title = "Vertical displacement of the impact point and the top";
    TimeChart {
        curves: vec![
            response.curve(&U1, 0, Stroke::solid(colour::IMPACT_POINT, 14)),
            response.curve(&U2, 0, Stroke::solid(colour::TOP, 14)),
        ],
        marks: highest
            .map(|sample| peak(sample.time, sample.u2, unit, colour::TOP))
            .into_iter()
            .collect(),
        ..response.chart(title, &key, "displacement u, positive down", unit)
    }
    .draw()
}

/// Figure 7: the normal forces of the bars, tension positive.
pub(super) fn normal_forces(response: &ResponseHistory<'_>) -> Drawn<String> {
    let unit = Unit::force(response.largest(&[NORMAL_FORCE]));
    let ranges = WEB_PLACES.iter().enumerate().map(|(bar, place)| {
        let values = || {
            response
                .samples
                .iter()
                .map(|it| NORMAL_FORCE.value(it, bar))
        };
        format!(
            "bar {} {} to {}",
            place.name,
            significant(unit.of(values().fold(f64::INFINITY, f64::min)), 4),
            unit.show(values().fold(f64::NEG_INFINITY, f64::max)),
        )
    });
    let key = format!(
        "{}; squash load {}",
        ranges.collect::<Vec<_>>().join(", "),
        unit.show(response.resistance_axial)
    );
    let strokes = colour::BARS
        .map(|colour| Stroke::solid(colour, 12))
        .into_iter()
        .enumerate();
    TimeChart {
        curves: strokes
            .map(|(bar, stroke)| response.curve(&NORMAL_FORCE, bar, stroke))
            .collect(),
        ..response.chart(
            "Normal forces of the bars",
            &key,
            "normal force N, tension positive",
            unit,
        )
    }
    .draw()
}

/// Figure 8: the bending moments of the hinges, with a ring at the first yield of each.
///
/// The moments of 1a and 1b are equal: 1b is dashed over 1a.
pub(super) fn bending_moments(response: &ResponseHistory<'_>) -> Drawn<String> {
    let unit = Unit::moment(response.largest(&[MOMENT]).max(response.resistance_moment));
    let curves = colour::HINGE
        .into_iter()
        .enumerate()
        .map(|(hinge, colour)| {
            let stroke = match hinge {
                0 => Stroke::solid(colour, 24),
                1 => Stroke::dashed(colour, 12),
                _ => Stroke::solid(colour, 12),
            };
            response.curve(&MOMENT, hinge, stroke)
        });
    let plastic_moment = [1.0, -1.0].map(|sign| {
        let level = sign * response.resistance_moment;
        let (from, to) = response.span();
        let name = if sign > 0.0 {
            "plastic moment without normal force"
        } else {
            ""
        };
        let stroke = Stroke {
            dashes: Some((20, 28)),
            ..Stroke::solid(colour::FAINT, 8)
        };
        Curve::line(name, vec![(from, level), (to, level)], stroke)
    });
    let marks: Vec<_> = (0..HINGES)
        .filter_map(|hinge| first_yield(response, hinge))
        .collect();
    let keys = if marks.is_empty() {
        Vec::new()
    } else {
        vec![(LegendKey::Ring(colour::INK), "first yield".to_owned())]
    };
    let order = order_of_yield(response);
    TimeChart {
        curves: plastic_moment.into_iter().chain(curves).collect(),
        marks,
        keys,
        ..response.chart(
            "Bending moments of the hinges",
            &order,
            "bending moment M",
            unit,
        )
    }
    .draw()
}

/// The smooth contact force as a curve, impact impulses as arrows.
pub(super) fn contact_force(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::force(response.largest(&[CONTACT_FORCE]));
    let key = if report.first_contact_time.is_none() {
        "no contact".to_owned()
    } else {
        format!(
            "peak {}; impulse {} N s, of which {} N s in {} impact impulse{}",
            unit.show(report.peak_contact_force),
            significant(report.impulse, 5),
            significant(report.total_impact_impulse, 4),
            report.impact_impulses,
            if report.impact_impulses == 1 { "" } else { "s" },
        )
    };
    let mut force = response.curve(&CONTACT_FORCE, 0, Stroke::solid(colour::CONTACT, 12));
    force.fill = Some(plotters::style::RGBColor(219, 234, 244));
    let arrows = impact_impulses(response);
    let keys = if arrows.is_empty() {
        Vec::new()
    } else {
        vec![(
            LegendKey::Arrow(colour::IMPACT_IMPULSE),
            IMPACT_IMPULSE.in_figures(0),
        )]
    };
    let marks = report
        .peak_contact_force_time
        .map(|time| peak(time, report.peak_contact_force, unit, colour::CONTACT));
    let title = "Contact force between impactor and column";
    TimeChart {
        curves: vec![force],
        marks: marks.into_iter().collect(),
        arrows,
        keys,
        ..response.chart(title, &key, "contact force", unit)
    }
    .draw()
}

/// The largest impact impulses as arrows of proportional height; up to three of them, far enough apart, with their impulse.
fn impact_impulses(response: &ResponseHistory<'_>) -> Vec<ImpulseArrow> {
    /// More arrows could not be distinguished.
    const MAX_ARROWS: usize = 200;
    let mut struck: Vec<_> = response
        .samples
        .iter()
        .filter(|sample| sample.impact_impulse > 0.0 && sample.impact_impulse.is_finite())
        .map(|sample| (sample.time, sample.impact_impulse))
        .collect();
    struck.sort_by(|one, other| other.1.total_cmp(&one.1));
    struck.truncate(MAX_ARROWS);
    let largest = struck.first().map_or(1.0, |first| first.1);
    let (from, to) = response.span();
    let mut named: Vec<f64> = Vec::new();
    let arrows: Vec<_> = struck
        .into_iter()
        .map(|(time, impulse)| {
            let free = named
                .iter()
                .all(|other| (time - other).abs() > 0.1 * (to - from));
            let text = (free && named.len() < 3).then(|| {
                named.push(time);
                format!("{} N s", significant(impulse, 4))
            });
            ImpulseArrow {
                time,
                height: impulse / largest,
                text,
            }
        })
        .collect();
    // The largest are drawn last, so that their texts lie over other arrows.
    arrows.into_iter().rev().collect()
}

fn peak(time: f64, value: f64, unit: Unit, colour: plotters::style::RGBColor) -> Mark {
    Mark {
        time,
        value,
        colour,
        text: Some(unit.show(value)),
    }
}

/// A ring at the first yield of a hinge.
fn first_yield(response: &ResponseHistory<'_>, hinge: usize) -> Option<Mark> {
    let time = response.report.hinges[hinge].first_yield?;
    let sample = response.samples.iter().find(|sample| sample.time >= time)?;
    Some(Mark {
        time,
        value: sample.hinges[hinge].moment,
        colour: colour::HINGE[hinge],
        text: None,
    })
}

/// "first yield: hinge 3 at 0.3170 ms, ..."
fn order_of_yield(response: &ResponseHistory<'_>) -> String {
    let mut yields: Vec<_> = (0..HINGES)
        .filter_map(|hinge| Some((response.report.hinges[hinge].first_yield?, hinge)))
        .collect();
    if yields.is_empty() {
        return "no hinge yields".into();
    }
    yields.sort_by(|one, other| one.0.total_cmp(&other.0));
    let unit = response.time_unit();
    let named: Vec<_> = yields
        .iter()
        .map(|(time, hinge)| format!("{} at {}", HINGE_NAMES[*hinge], unit.show(*time)))
        .collect();
    format!("first yield of hinge {}", named.join(", "))
}
