//! The two bars and the fibre beam beside one another: their shapes to one scale, and their displacements over time.

use column_beam::{Movement, is_in_plane};
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::PlotAxis;
use super::chart::{Curve, TimeChart, axes};
use super::page::{self, BOTTOM, Drawn, LEFT, LegendKey, RIGHT, Stroke, TEXT, colour};
use super::response_history::ResponseHistory;
use super::units::{Unit, significant};

const BARS: Stroke = Stroke::solid(colour::IMPACT_POINT, 16);
const BEAM: Stroke = Stroke::solid(colour::IMPACTOR, 16);
const BARS_AT_REST: Stroke = Stroke::dashed(colour::IMPACT_POINT, 10);
const BEAM_AT_REST: Stroke = Stroke::dashed(colour::IMPACTOR, 10);
const SIDEWAYS: Stroke = Stroke::solid(colour::TOP, 14);
const SIDEWAYS_AT_REST: Stroke = Stroke::dashed(colour::TOP, 10);

/// Magnifications of displacements, the largest first.
const MAGNIFICATIONS: [f64; 10] = [1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0];

/// Times of the longer response to its peak or its end at which the curves end: what follows are elastic vibrations.
const SHOWN: f64 = 1.5;

/// Width of the plot of shapes over that of the shapes.
const ROOM: f64 = 1.1;

/// Height of the line that names the magnification.
const SCALE_ROW: i32 = 108;

/// Share of the beam's peak below which the two bars hardly move.
const LEAST_SHARE: f64 = 1e-3;

/// Draws the displacement of the impact point over time by both models, from the touch on.
pub(super) fn displacements(response: &ResponseHistory<'_>, beam: &Movement) -> Drawn<String> {
    let report = response.report;
    let touch = report.first_contact_time.unwrap_or(0.0);
    let is_oblique = !is_in_plane(beam.direction);
    let of_beam = |quantity: usize| -> Vec<(f64, f64)> {
        let points = beam.points.iter();
        points.map(|point| (point[0], point[quantity])).collect()
    };
    let bars_end = response.samples.last().map_or(0.0, |it| it.time - touch);
    let beam_end = beam.points.last().map_or(0.0, |point| point[0]);
    let notable = [
        beam_end,
        report.max_v1_time - touch,
        report.release_time.unwrap_or(touch) - touch,
    ];
    let shown = SHOWN * notable.into_iter().fold(0.0, f64::max);
    let end = shown.min(bars_end).max(beam_end);
    let of_bars: Vec<_> = response
        .over_time(|sample| sample.v1)
        .into_iter()
        .map(|(time, v1)| (time - touch, v1))
        .filter(|(time, _)| *time >= 0.0 && *time <= end)
        .collect();
    let (along, across) = (of_beam(1), of_beam(2));
    let largest = |points: &[(f64, f64)]| {
        let finite = points.iter().map(|point| point.1.abs());
        finite.filter(|it| it.is_finite()).fold(0.0, f64::max)
    };
    let unit = Unit::length(largest(&of_bars).max(largest(&along)).max(if is_oblique {
        largest(&across)
    } else {
        0.0
    }));
    let time = Unit::time(end);
    let peak = beam.largest();
    let mut curves = vec![
        Curve::line(
            format!(
                "two bars: {} at {}",
                unit.show(report.max_v1),
                time.show(report.max_v1_time - touch)
            ),
            of_bars,
            BARS,
        ),
        Curve::line(
            format!(
                "fibre beam: {} at {}",
                unit.show(peak[1]),
                time.show(peak[0])
            ),
            along,
            BEAM,
        ),
    ];
    let at_rest =
        |value: f64, from: f64, stroke| Curve::line("", vec![(from, value), (end, value)], stroke);
    let remains = beam.remains_at(response.lengths.below);
    if let Some(v1) = report.residual_v1 {
        let from = (report.max_v1_time - touch).min(end);
        curves.push(at_rest(v1, from, BARS_AT_REST));
    }
    if let Some([along, _]) = remains {
        curves.push(at_rest(along, peak[0], BEAM_AT_REST));
    }
    if is_oblique {
        let name = format!(
            "its displacement across the hit: {}",
            unit.show(largest(&across))
        );
        curves.push(Curve::line(name, across, SIDEWAYS));
        if let Some([_, across]) = remains {
            curves.push(at_rest(across, peak[0], SIDEWAYS_AT_REST));
        }
    }
    TimeChart {
        title: "Displacement of the impact point by both models",
        lines: [response.title, &compared(response, beam)],
        quantity: match is_oblique {
            true => "displacement, along the hit and across it",
            false => "displacement along the hit",
        },
        unit,
        span: (0.0, end),
        curves,
        keys: vec![(
            LegendKey::Line(Stroke::dashed(colour::FAINT, 10)),
            "dashed: what remains".to_owned(),
        )],
        ..TimeChart::default()
    }
    .draw()
}

/// Draws the column at the peak and at rest by both models, to one scale; where the hit is oblique, what the beam does at right angles
/// to it stands beside it.
pub(super) fn shapes(response: &ResponseHistory<'_>, beam: &Movement) -> Drawn<String> {
    let mut panels = vec![("along the hit", along(response, beam))];
    if !is_in_plane(beam.direction) {
        panels.push(("across the hit", across(beam)));
    }
    let points = panels.iter().flat_map(|(_, shapes)| shapes);
    let values = points.flat_map(|(_, points)| points.iter().map(|point| point.0));
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((0.0_f64, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    let unit = Unit::length(high.max(-low));
    let total = response.lengths.below + response.lengths.above;
    page::draw(|page| {
        let lines = [response.title, &*compared(response, beam)];
        let legend = legend(beam);
        let used = page::heading(page, "Shape of the column by both models", lines, &legend)?;
        let (_, below) = page.split_vertically(used + 40 + SCALE_ROW);
        let areas = below.split_evenly((1, panels.len()));
        let (wide, tall) = areas[0].dim_in_pixel();
        let wide = f64::from(wide as i32 - LEFT - RIGHT);
        let tall = f64::from(tall as i32 - BOTTOM);
        let height = PlotAxis::exactly(0.0, 1.04 * total, 8);
        let per_metre = tall / height.to;
        let needed = ROOM * (high - low).max(1e-9);
        let fits = |factor: &f64| needed * per_metre * factor <= wide;
        let magnification = MAGNIFICATIONS.into_iter().find(fits);
        // A column that has fallen is wider than its drawing: its heights are then the ones that are magnified.
        let shown = magnification.map_or(needed, |factor| wide / (per_metre * factor));
        let words = match magnification {
            Some(1.0) => "Displacements and heights have the same scale.".to_owned(),
            Some(factor) => format!("Displacements are drawn {factor} times as large as heights."),
            None => "Displacements are drawn smaller than heights.".to_owned(),
        };
        let style = page::text_style(TEXT, colour::INK, HPos::Left, VPos::Center);
        page.draw_text(&words, &style, (LEFT / 2, used + SCALE_ROW / 2))?;
        let middle = 0.5 * (low + high);
        let ends = [-0.5, 0.5].map(|part| unit.of(middle + part * shown));
        let x = PlotAxis::exactly(ends[0], ends[1], 12 / panels.len());
        for ((name, shapes), area) in panels.iter().zip(&areas) {
            let names = [
                &*format!("displacement {name} [{}]", unit.symbol),
                "height above the base [m]",
            ];
            let plot = axes(area, &x, &height, names)?;
            for (stroke, points) in shapes {
                let finite = points.iter().filter(|it| it.0.is_finite());
                let places = finite.map(|it| plot.backend_coord(&(unit.of(it.0), it.1)));
                stroke.draw(page, places.collect())?;
            }
        }
        Ok(())
    })
}

fn legend(beam: &Movement) -> Vec<(LegendKey, String)> {
    let key = |stroke, name: &str| (LegendKey::Line(stroke), name.to_owned());
    let mut entries = vec![
        key(BARS, "two bars at the peak"),
        key(BEAM, "fibre beam at the peak"),
    ];
    if !is_in_plane(beam.direction) {
        entries.push(key(SIDEWAYS, "the beam across the hit"));
    }
    entries.push(key(
        Stroke::dashed(colour::FAINT, 10),
        "dashed: at rest after the hit; grey: before it",
    ));
    entries
}

/// How the peaks compare, in words.
fn compared(response: &ResponseHistory<'_>, beam: &Movement) -> String {
    let (bars, [_, peak]) = (response.report.max_v1, beam.largest());
    if bars.abs() < LEAST_SHARE * peak.abs() {
        return "the two bars do not see this hit, which is out of their plane".to_owned();
    }
    format!(
        "the peak of the fibre beam along the hit is {} times that of the two bars",
        significant(peak / bars, 3)
    )
}

/// A shape: displacement and height of points of the axis \[m\].
type Shape = (Stroke, Vec<(f64, f64)>);

/// The column before the hit, then both models along the hit at their peaks and at rest.
fn along(response: &ResponseHistory<'_>, beam: &Movement) -> Vec<Shape> {
    let (below, above) = (response.lengths.below, response.lengths.above);
    // Above a free top's impact point the column goes on straight, as it leans.
    let bars = |v1: f64| {
        let top = match response.lengths.top_is_free {
            true => v1 * (below + above) / below,
            false => 0.0,
        };
        vec![(0.0, 0.0), (v1, below), (top, below + above)]
    };
    let mut shapes = vec![(
        Stroke::dashed(colour::FAINT, 8),
        vec![(0.0, 0.0), (0.0, below + above)],
    )];
    shapes.extend(
        response
            .report
            .residual_v1
            .map(|v1| (BARS_AT_REST, bars(v1))),
    );
    shapes.extend(
        beam.remains
            .as_deref()
            .map(|it| (BEAM_AT_REST, nodes(beam, it, 0))),
    );
    shapes.push((BARS, bars(response.report.max_v1)));
    shapes.push((BEAM, nodes(beam, &beam.peak, 0)));
    shapes
}

/// The column before the hit, then the beam at right angles to the hit.
fn across(beam: &Movement) -> Vec<Shape> {
    let top = beam.heights.last().copied().unwrap_or(0.0);
    let mut shapes = vec![(
        Stroke::dashed(colour::FAINT, 8),
        vec![(0.0, 0.0), (0.0, top)],
    )];
    shapes.extend(
        beam.remains
            .as_deref()
            .map(|it| (SIDEWAYS_AT_REST, nodes(beam, it, 1))),
    );
    shapes.push((SIDEWAYS, nodes(beam, &beam.peak, 1)));
    shapes
}

fn nodes(beam: &Movement, moved: &[[f64; 3]], way: usize) -> Vec<(f64, f64)> {
    let moved = moved.iter().map(|it| it[way]);
    moved.zip(beam.heights.iter().copied()).collect()
}
