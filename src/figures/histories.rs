//! Displacements, forces and moments over time: the paper's Figures 5 to 8, and the contact force.

use super::chart::{Curve, ImpulseArrow, Mark, TimeChart};
use super::page::{Drawn, LegendKey, Stroke, colour};
use super::response_history::ResponseHistory;
use super::units::{Unit, significant};
use crate::column::{HINGE_NAMES, HINGES, Sample};
use crate::shape::HINGE_PLACES;

/// Figure 5: `v1` and the impactor's position `v_c`.
pub(super) fn horizontal_displacement(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::length(response.largest(|sample| [sample.v1]));
    let residual = report
        .residual_v1
        .map_or("none".into(), |value| unit.show(value));
    let key = format!(
        "peak {} at {}, residual {residual}; final velocity of the impactor {} m/s",
        unit.show(report.max_v1),
        response.time_unit().show(report.max_v1_time),
        significant(report.impactor_velocity, 4),
    );
    TimeChart {
        title: "Horizontal displacement of the impact point and the impactor",
        lines: [response.title, &key],
        quantity: "displacement v",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves: vec![
            Curve::line(
                "v₁ impact point",
                response.over_time(|sample| sample.v1),
                Stroke::solid(colour::IMPACT_POINT, 18),
            ),
            Curve::line(
                "v_c impactor",
                response.over_time(|sample| sample.impactor_position),
                Stroke::dashed(colour::IMPACTOR, 12),
            ),
        ],
        marks: vec![peak(
            report.max_v1_time,
            report.max_v1,
            unit,
            colour::IMPACT_POINT,
        )],
        arrows: Vec::new(),
        keys: Vec::new(),
        events: response.events(),
    }
    .draw()
}

/// Figure 6: `u1` and `u2`.
pub(super) fn vertical_displacement(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::length(response.largest(|sample| [sample.u1, sample.u2]));
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
    TimeChart {
        title: "Vertical displacement of the impact point and the top",
        lines: [response.title, &key],
        quantity: "displacement u, positive down",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves: vec![
            Curve::line(
                "u₁ impact point",
                response.over_time(|sample| sample.u1),
                Stroke::solid(colour::IMPACT_POINT, 14),
            ),
            Curve::line(
                "u₂ top",
                response.over_time(|sample| sample.u2),
                Stroke::solid(colour::TOP, 14),
            ),
        ],
        marks: highest
            .map(|sample| peak(sample.time, sample.u2, unit, colour::TOP))
            .into_iter()
            .collect(),
        arrows: Vec::new(),
        keys: Vec::new(),
        events: response.events(),
    }
    .draw()
}

/// Figure 7: the normal forces of the bars, tension positive.
pub(super) fn normal_forces(response: &ResponseHistory<'_>) -> Drawn<String> {
    let bar_a = |sample: &Sample| sample.normal_forces()[0];
    let bar_b = |sample: &Sample| sample.normal_forces()[1];
    let unit = Unit::force(response.largest(|sample| [bar_a(sample), bar_b(sample)]));
    let range = |bar: &dyn Fn(&Sample) -> f64| {
        let values = || response.samples.iter().map(bar);
        format!(
            "{} to {}",
            significant(unit.of(values().fold(f64::INFINITY, f64::min)), 4),
            unit.show(values().fold(f64::NEG_INFINITY, f64::max)),
        )
    };
    let key = format!(
        "bar a {}, bar b {}; squash load {}",
        range(&bar_a),
        range(&bar_b),
        unit.show(response.resistance_axial)
    );
    TimeChart {
        title: "Normal forces of the bars",
        lines: [response.title, &key],
        quantity: "normal force N, tension positive",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves: vec![
            Curve::line(
                "N_a below the impact (hinges 1a, 3)",
                response.over_time(bar_a),
                Stroke::solid(colour::BAR_A, 12),
            ),
            Curve::line(
                "N_b above the impact (hinges 1b, 2)",
                response.over_time(bar_b),
                Stroke::solid(colour::BAR_B, 12),
            ),
        ],
        marks: Vec::new(),
        arrows: Vec::new(),
        keys: Vec::new(),
        events: response.events(),
    }
    .draw()
}

/// Figure 8: the bending moments of the hinges, with a ring at the first yield of each.
///
/// The moments of 1a and 1b are equal: 1b is dashed over 1a.
pub(super) fn bending_moments(response: &ResponseHistory<'_>) -> Drawn<String> {
    let largest = response.largest(|sample| sample.hinges.map(|hinge| hinge.moment));
    let unit = Unit::moment(largest.max(response.resistance_moment));
    let strokes = [
        Stroke::solid(colour::HINGES[0], 24),
        Stroke::dashed(colour::HINGES[1], 12),
        Stroke::solid(colour::HINGES[2], 12),
        Stroke::solid(colour::HINGES[3], 12),
    ];
    let curves = (0..HINGES).map(|hinge| {
        let name = format!("hinge {} {}", HINGE_NAMES[hinge], HINGE_PLACES[hinge]);
        let points = response.over_time(|sample| sample.hinges[hinge].moment);
        Curve::line(name, points, strokes[hinge])
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
    TimeChart {
        title: "Bending moments of the hinges",
        lines: [response.title, &order_of_yield(response)],
        quantity: "bending moment M",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves: plastic_moment.into_iter().chain(curves).collect(),
        marks,
        arrows: Vec::new(),
        keys,
        events: response.events(),
    }
    .draw()
}

/// The smooth contact force as a curve, impact impulses as arrows.
pub(super) fn contact_force(response: &ResponseHistory<'_>) -> Drawn<String> {
    let report = response.report;
    let unit = Unit::force(response.largest(|sample| [sample.contact_force]));
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
    let mut force = Curve::line(
        "contact force",
        response.over_time(|sample| sample.contact_force),
        Stroke::solid(colour::CONTACT, 12),
    );
    force.fill = Some(plotters::style::RGBColor(219, 234, 244));
    let arrows = impact_impulses(response);
    let keys = if arrows.is_empty() {
        Vec::new()
    } else {
        vec![(
            LegendKey::Arrow(colour::IMPACT_IMPULSE),
            "impact impulse (instantaneous impulse, not to scale)".to_owned(),
        )]
    };
    let marks = report
        .peak_contact_force_time
        .map(|time| peak(time, report.peak_contact_force, unit, colour::CONTACT));
    TimeChart {
        title: "Contact force between impactor and column",
        lines: [response.title, &key],
        quantity: "contact force",
        unit,
        span: response.span(),
        bands: Vec::new(),
        curves: vec![force],
        marks: marks.into_iter().collect(),
        arrows,
        keys,
        events: response.events(),
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
        colour: colour::HINGES[hinge],
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
