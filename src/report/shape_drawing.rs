//! The shape of the column before and after the hit: to scale, and with its displacements magnified.

use maud::{Markup, html};

use super::reported_impact::ReportedImpact;
use super::svg::{
    self, BLUE, FAINT, INK, ORANGE, RED, STEEL, Spot, area, arrow, height, line, scale_bar, text,
    title,
};
use super::words::{part_of, short};
use crate::column::{Sample, Support, WEBS};
use crate::figures::units::Unit;
use crate::shape::{BentAxis, Joints, Lengths, Station, drawn_section};

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
struct Shape {
    sample: Sample,
    words: String,
    colour: &'static str,
    dashes: &'static str,
}

/// Both parts.
pub(super) fn markup(impact: &ReportedImpact) -> Markup {
    let shapes = shapes(impact);
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
                "Shape of the column. Left: to scale. Right: displacements " (short(factor)) " times as large. Dashed: before the hit."
            }
        }
    }
}

fn shapes(impact: &ReportedImpact) -> Vec<Shape> {
    let report = &impact.report;
    let height = impact.height();
    let length = |v1: f64| {
        let shown = Unit::length(v1).show(v1);
        match v1.abs() < 1e-4 * height {
            true => shown,
            false => format!("{shown} = {}", part_of(v1, height)),
        }
    };
    let mut shapes = Vec::new();
    let finite = impact.samples.iter().filter(|it| it.v1.is_finite());
    if let Some(peak) = finite.max_by(|one, other| one.v1.abs().total_cmp(&other.v1.abs())) {
        shapes.push(Shape {
            sample: *peak,
            words: format!("largest: {}", length(report.max_v1)),
            colour: BLUE,
            dashes: "6 3",
        });
    }
    if let (Some(state), Some(v1)) = (&impact.settled, report.residual_v1) {
        shapes.push(Shape {
            sample: state.sample(&impact.model),
            words: format!("remains: {}", length(v1)),
            colour: ORANGE,
            dashes: "",
        });
    }
    shapes
}

fn magnification(impact: &ReportedImpact, shapes: &[Shape]) -> f64 {
    let largest = shapes
        .iter()
        .map(|it| it.sample.v1.abs())
        .fold(0.0, f64::max);
    let most = LARGEST_SHARE * impact.height() / largest.max(1e-6);
    [1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0]
        .into_iter()
        .find(|factor| *factor <= most)
        .unwrap_or(1.0)
}

/// The stations of the bent axis.
fn stations(impact: &ReportedImpact, sample: &Sample, magnification: f64) -> Vec<Station> {
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
    axis.stations().to_vec()
}

fn to_scale(impact: &ReportedImpact, shapes: &[Shape]) -> Markup {
    let total = impact.height();
    let scale = HIGHEST / total;
    let half = 0.5 * drawn_section(&impact.parameters).depth;
    let place = |x: f64, z: f64| (TRUE_AXIS + scale * x, GROUND - scale * z);
    let last = shapes.last();
    let outline: Vec<Spot> = last.map_or(Vec::new(), |shape| {
        let stations = stations(impact, &shape.sample, 1.0);
        let side = |sign: f64| {
            let offset = move |it: &Station| {
                let across = sign * half;
                place(
                    it.place.x + across * it.section.z,
                    it.place.z - across * it.section.x,
                )
            };
            stations.iter().map(offset).collect::<Vec<_>>()
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

fn magnified(impact: &ReportedImpact, shapes: &[Shape], factor: f64) -> Markup {
    let total = impact.height();
    let scale = HIGHEST / total;
    let place = |x: f64, z: f64| (MAGNIFIED_AXIS + scale * x, GROUND - scale * z);
    let below = impact.model.properties.length_below;
    let curve = |shape: &Shape| {
        // Heights stay as they are: only what is transverse is magnified.
        let stations = stations(impact, &shape.sample, factor);
        let points: Vec<Spot> = stations
            .iter()
            .map(|it| place(it.place.x, it.place.z))
            .collect();
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
