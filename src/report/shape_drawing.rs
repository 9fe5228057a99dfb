//! The shape of the column before and after the hit: to scale, and with its displacements magnified.

use maud::{Markup, html};

use super::assessed::Assessed;
use super::reported_impact::ReportedImpact;
use super::sketch::seen_depth;
use super::svg::{
    self, BLUE, FAINT, INK, ORANGE, RED, STEEL, Spot, area, arrow, height, line, scale_bar, text,
    title,
};
use super::words::{millimetres, part_of, short};
use crate::column::{Sample, Support, WEBS};
use crate::figures::units::Unit;
use crate::second_opinion::{Movement, SecondOpinion};
use crate::shape::{BentAxis, Joints, Lengths};

/// Size of the drawing.
const SIZE: (f64, f64) = (720.0, 330.0);
const GROUND: f64 = 300.0;
const HIGHEST: f64 = 252.0;
/// Axes of the straight column in both parts.
const TRUE_AXIS: f64 = 110.0;
const MAGNIFIED_AXIS: f64 = 356.0;
/// How far the peak displacement may reach in the magnified part, as a share of the height.
const LARGEST_SHARE: f64 = 0.22;

/// One shape of the column.
struct Shape<'i> {
    axis: Axis<'i>,
    words: String,
    colour: &'static str,
    dashes: &'static str,
}

/// The axis of the column, by one of both models.
enum Axis<'i> {
    Bars(Box<Sample>),
    /// Heights of the nodes \[m\], and how far each has moved along the hit, across it and upwards \[m\].
    Beam(&'i [f64], &'i [[f64; 3]]),
}

/// A point of the axis \[m\] with the unit normal of the section there, upwards: both along the hit and up.
struct Place {
    at: [f64; 2],
    normal: [f64; 2],
}

impl Axis<'_> {
    /// How far the axis is from the straight line \[m\].
    fn largest(&self) -> f64 {
        match self {
            Self::Bars(sample) => sample.v1.abs(),
            Self::Beam(_, moved) => moved.iter().map(|it| it[0].abs()).fold(0.0, f64::max),
        }
    }

    /// Its points from the base to the top.
    fn places(&self, impact: &ReportedImpact, magnification: f64) -> Vec<Place> {
        match self {
            Self::Bars(sample) => of_bars(impact, sample, magnification),
            Self::Beam(heights, moved) => heights
                .iter()
                .zip(*moved)
                .map(|(height, moved)| Place {
                    at: [magnification * moved[0], *height],
                    normal: [0.0, 1.0],
                })
                .collect(),
        }
    }
}

/// Both parts, by the model that tells what the column does; nothing where its movement is not known.
pub(super) fn markup(impact: &ReportedImpact, assessed: &Result<Assessed, String>) -> Markup {
    let opinion = assessed.as_ref().ok().and_then(Assessed::beam);
    let beam = opinion.zip(impact.beam.as_ref());
    if beam.is_none() && !impact.is_seen_by_the_bars() {
        return html! { p.note { "The movement of the column is not known: its shape is not drawn." } };
    }
    let of = match (beam, impact.is_oblique()) {
        (Some(_), true) => " along the hit, by the fibre beam",
        (Some(_), false) => ", by the fibre beam",
        (None, true) => {
            ", by the two bars: of the component of the hit in their plane, not of the whole hit"
        }
        (None, false) if opinion.is_some() => ", by the two bars",
        (None, false) => "",
    };
    let shapes = match beam {
        Some((opinion, movement)) => by_the_beam(impact, opinion, movement),
        None => shapes(impact),
    };
    let words = "Shape of the column after the hit, to scale and magnified";
    let factor = magnification(impact, &shapes);
    let content = html! {
        (to_scale(impact, &shapes))
        (magnified(impact, &shapes, factor))
    };
    html! {
        figure.shape role="img" aria-label=(words) {
            (svg::drawing(SIZE.0, SIZE.1, words, &content))
            figcaption {
                "Shape of the column" (of) ". Left: to scale. Right: displacements " (short(factor)) " times as large. Dashed: before the hit."
            }
        }
    }
}

/// The shapes of the beam along the hit.
fn by_the_beam<'i>(
    impact: &ReportedImpact,
    opinion: &SecondOpinion,
    movement: &'i Movement,
) -> Vec<Shape<'i>> {
    let height = impact.height();
    let length = |metres: f64| with_part(millimetres(metres), metres, height);
    let [[peak, _], [residual, _]] = opinion.from_undamaged();
    let mut shapes = vec![Shape {
        axis: Axis::Beam(&movement.heights, &movement.peak),
        words: format!("largest: {}", length(peak)),
        colour: BLUE,
        dashes: "6 3",
    }];
    shapes.extend(movement.remains.as_deref().map(|remains| Shape {
        axis: Axis::Beam(&movement.heights, remains),
        words: format!("remains: {}", length(residual)),
        colour: ORANGE,
        dashes: "",
    }));
    shapes
}

/// A displacement as it is shown, also as a part of the height where that is a number.
fn with_part(shown: String, v1: f64, height: f64) -> String {
    match v1.abs() < 1e-4 * height {
        true => shown,
        false => format!("{shown} = {}", part_of(v1, height)),
    }
}

fn shapes(impact: &ReportedImpact) -> Vec<Shape<'static>> {
    let report = &impact.report;
    let height = impact.height();
    let length = |v1: f64| with_part(Unit::length(v1).show(v1), v1, height);
    let mut shapes = Vec::new();
    let finite = impact.samples.iter().filter(|it| it.v1.is_finite());
    if let Some(peak) = finite.max_by(|one, other| one.v1.abs().total_cmp(&other.v1.abs())) {
        shapes.push(Shape {
            axis: Axis::Bars(Box::new(*peak)),
            words: format!("largest: {}", length(report.max_v1)),
            colour: BLUE,
            dashes: "6 3",
        });
    }
    if let (Some(state), Some(v1)) = (&impact.settled, report.residual_v1) {
        shapes.push(Shape {
            axis: Axis::Bars(Box::new(state.sample(&impact.model))),
            words: format!("remains: {}", length(v1)),
            colour: ORANGE,
            dashes: "",
        });
    }
    shapes
}

fn magnification(impact: &ReportedImpact, shapes: &[Shape<'_>]) -> f64 {
    let largest = shapes
        .iter()
        .map(|it| it.axis.largest())
        .fold(0.0, f64::max);
    let most = LARGEST_SHARE * impact.height() / largest.max(1e-6);
    [1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0]
        .into_iter()
        .find(|factor| *factor <= most)
        .unwrap_or(1.0)
}

/// The stations of the bent axis of the two bars.
fn of_bars(impact: &ReportedImpact, sample: &Sample, magnification: f64) -> Vec<Place> {
    let properties = &impact.model.properties;
    let joints = Joints::new(Lengths::from(properties), sample, magnification);
    let is_fixed =
        |support: &Support| matches!(support, Support::BuiltIn | Support::SemiRigid { .. });
    let rotation = magnification * sample.beta1;
    let axis = BentAxis::new(
        &joints,
        rotation,
        [0.0; WEBS],
        is_fixed(&properties.base),
        is_fixed(&properties.top),
    );
    let stations = axis.stations().iter();
    stations
        .map(|it| Place {
            at: [it.place.x, it.place.z],
            normal: [it.section.x, it.section.z],
        })
        .collect()
}

fn to_scale(impact: &ReportedImpact, shapes: &[Shape<'_>]) -> Markup {
    let total = impact.height();
    let scale = HIGHEST / total;
    let half = 0.5 * seen_depth(impact);
    let place = |x: f64, z: f64| (TRUE_AXIS + scale * x, GROUND - scale * z);
    let last = shapes.last();
    let outline: Vec<Spot> = last.map_or(Vec::new(), |shape| {
        let places = shape.axis.places(impact, 1.0);
        let side = |sign: f64| {
            let offset = move |it: &Place| {
                let across = sign * half;
                place(
                    it.at[0] + across * it.normal[1],
                    it.at[1] - across * it.normal[0],
                )
            };
            places.iter().map(offset).collect::<Vec<_>>()
        };
        let mut right = side(1.0);
        right.reverse();
        [side(-1.0), right].concat()
    });
    let before =
        [(-half, 0.0), (-half, total), (half, total), (half, 0.0)].map(|(x, z)| place(x, z));
    let bar = if total > 12.0 { 5.0 } else { 1.0 };
    let below = impact.model.properties.length_below;
    html! {
        (title((4.0, 14.0), "To scale"))
        (line(&[(TRUE_AXIS - 70.0, GROUND), (TRUE_AXIS + 80.0, GROUND)], FAINT, 1.0, ""))
        (area(&outline, STEEL, INK, 1.0))
        (line(&before, FAINT, 1.0, "4 3"))
        (arrow((TRUE_AXIS - 60.0, GROUND - scale * below), (TRUE_AXIS - scale * half - 2.0, GROUND - scale * below), RED, 2.0))
        (scale_bar((4.0, SIZE.1 - 8.0), scale * bar, &format!("{} m", short(bar))))
        (height(TRUE_AXIS + 90.0, GROUND, GROUND - scale * total, &format!("L = {} m", short(total))))
    }
}

fn magnified(impact: &ReportedImpact, shapes: &[Shape<'_>], factor: f64) -> Markup {
    let total = impact.height();
    let scale = HIGHEST / total;
    let place = |x: f64, z: f64| (MAGNIFIED_AXIS + scale * x, GROUND - scale * z);
    let below = impact.model.properties.length_below;
    let curve = |shape: &Shape<'_>| {
        // Heights stay as they are: only what is transverse is magnified.
        let places = shape.axis.places(impact, factor);
        let points: Vec<Spot> = places.iter().map(|it| place(it.at[0], it.at[1])).collect();
        line(&points, shape.colour, 2.2, shape.dashes)
    };
    let bar = 0.1_f64;
    let drawn = scale * bar * factor;
    let (bar, drawn) = match drawn {
        drawn if drawn > 220.0 => (0.01 * bar, 0.01 * drawn),
        drawn if drawn > 90.0 => (0.1 * bar, 0.1 * drawn),
        _ => (bar, drawn),
    };
    html! {
        (title((286.0, 14.0), &format!("Displacements x {}", short(factor))))
        (line(&[(MAGNIFIED_AXIS - 70.0, GROUND), (MAGNIFIED_AXIS + 90.0, GROUND)], FAINT, 1.0, ""))
        (line(&[place(0.0, 0.0), place(0.0, total)], INK, 1.0, "4 3"))
        @for shape in shapes { (curve(shape)) }
        (arrow((MAGNIFIED_AXIS - 60.0, GROUND - scale * below), (MAGNIFIED_AXIS - 2.0, GROUND - scale * below), RED, 2.0))
        (text((MAGNIFIED_AXIS - 62.0, GROUND - scale * below - 8.0), "start", RED, "hit"))
        @for (index, shape) in shapes.iter().enumerate() {
            @let y = 60.0 + 20.0 * index as f64;
            (line(&[(478.0, y - 4.0), (498.0, y - 4.0)], shape.colour, 2.2, shape.dashes))
            (text((504.0, y), "start", INK, &shape.words))
        }
        (scale_bar((286.0, SIZE.1 - 8.0), drawn, &format!("{} mm of displacement", short(1e3 * bar))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The legend had "remains: 0.238 mm = less than L/10000".
    #[test]
    fn a_displacement_that_is_no_part_worth_naming_stands_alone() {
        let with = |v1: f64| with_part(millimetres(v1), v1, 4.0);
        assert!(!with(0.238e-3).contains('='), "{}", with(0.238e-3));
        assert!(with(20e-3).ends_with(" = L/200"), "{}", with(20e-3));
    }
}
