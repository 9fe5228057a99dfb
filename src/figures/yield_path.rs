//! The path of a hinge's moment and normal force in its yield surface.

use std::collections::HashSet;

use plotters::element::{PathElement, Polygon, Rectangle};
use plotters::style::{Color, RGBColor};

use super::axis::PlotAxis;
use super::chart::{PlotArea, axes};
use super::page::{self, Area, CANVAS, Drawn, LegendKey, Stroke, colour};
use super::response_history::ResponseHistory;
use super::units::{Unit, significant};
use crate::observables::HINGE_PLACES;
use crate::shape::yield_curve;

/// Draws the whole surface on the left and the part around the path on the right.
pub(super) fn yield_path(response: &ResponseHistory<'_>, hinge: usize) -> Drawn<String> {
    let path: Vec<(f64, f64)> = response
        .samples
        .iter()
        .map(|sample| {
            (
                sample.hinges[hinge].moment,
                sample.hinges[hinge].normal_force,
            )
        })
        .filter(|(moment, force)| moment.is_finite() && force.is_finite())
        .collect();
    let figure = YieldPath {
        moment: Unit::moment(response.resistance_moment),
        force: Unit::force(response.resistance_axial),
        surface: surface(response),
        first_yield: response.report.hinges[hinge].first_yield.and_then(|time| {
            let sample = response.samples.iter().find(|sample| sample.time >= time)?;
            Some((
                sample.hinges[hinge].moment,
                sample.hinges[hinge].normal_force,
            ))
        }),
        path,
        colour: colour::HINGE[hinge],
    };
    let title = format!(
        "Moment and normal force of hinge {} in its yield surface",
        HINGE_PLACES[hinge]
    );
    page::draw(|page| {
        let top = page::heading(
            page,
            &title,
            [response.title, &key(response, hinge)],
            &figure.legend(),
        )?;
        let (_, below) = page.split_vertically(top + 20);
        let (left, right) = below.split_horizontally(CANVAS.0 as i32 / 2 + 40);
        let passed = figure.extent(figure.path.iter(), 0.12);
        let corners = [(passed[0].0, passed[1].0), (passed[0].1, passed[1].1)];
        let whole = figure.extent(figure.surface.iter().chain(&corners), 0.04);
        figure.panel(page, &left, &whole, "", Some(&passed))?;
        figure.panel(page, &right, &passed, " (enlarged)", None)
    })
}

/// The key figures of the hinge.
fn key(response: &ResponseHistory<'_>, hinge: usize) -> String {
    let report = &response.report.hinges[hinge];
    let yielded = match report.first_yield {
        Some(time) => format!("first yield at {}", response.time_unit().show(time)),
        None => "never yields".into(),
    };
    format!(
        "α = {}, β = {}; {yielded}; largest utilisation {}, plastic rotation {} rad",
        response.yield_surface.alpha,
        response.yield_surface.beta,
        significant(report.max_utilisation, 4),
        significant(report.plastic_rotation, 4),
    )
}

/// The yield surface, in SI units.
fn surface(response: &ResponseHistory<'_>) -> Vec<(f64, f64)> {
    yield_curve(response.yield_surface, 720)
        .map(|[moment, force]| {
            (
                response.resistance_moment * moment,
                response.resistance_axial * force,
            )
        })
        .filter(|(moment, force)| moment.is_finite() && force.is_finite())
        .collect()
}

struct YieldPath {
    moment: Unit,
    force: Unit,
    /// In SI units.
    surface: Vec<(f64, f64)>,
    /// In SI units.
    path: Vec<(f64, f64)>,
    first_yield: Option<(f64, f64)>,
    colour: RGBColor,
}

/// The ranges of moment and normal force, in SI units.
type Extent = [(f64, f64); 2];

impl YieldPath {
    fn legend(&self) -> Vec<(LegendKey, String)> {
        let mut entries = vec![
            (
                LegendKey::Line(Stroke::solid(colour::INK, 8)),
                "yield surface".to_owned(),
            ),
            (
                LegendKey::Line(Stroke::solid(self.colour, 12)),
                "path (● start, ■ end)".to_owned(),
            ),
        ];
        if self.first_yield.is_some() {
            entries.push((LegendKey::Ring(self.colour), "first yield".to_owned()));
        }
        entries
    }

    /// The extent of some points with a margin; never empty.
    fn extent<'p>(&self, points: impl Iterator<Item = &'p (f64, f64)>, margin: f64) -> Extent {
        let empty = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        let extent = points.fold(empty, |[moment, force], point| {
            [
                (moment.0.min(point.0), moment.1.max(point.0)),
                (force.0.min(point.1), force.1.max(point.1)),
            ]
        });
        let sizes = self
            .surface
            .iter()
            .fold((0.0, 0.0), |(moment, force): (f64, f64), point| {
                (moment.max(point.0), force.max(point.1))
            });
        // A path without extent is shown within a fiftieth of the surface.
        let widen = |(low, high): (f64, f64), size: f64| {
            let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
            let room = margin * (high - low) + 0.02 * size * f64::from(high - low < 0.02 * size);
            (low - room, high + room)
        };
        [widen(extent[0], sizes.0), widen(extent[1], sizes.1)]
    }

    fn panel(
        &self,
        page: &Area<'_>,
        area: &Area<'_>,
        extent: &Extent,
        note: &str,
        enlarged: Option<&Extent>,
    ) -> Drawn<()> {
        let axis = |(low, high): (f64, f64), unit: Unit, count| {
            PlotAxis::between(unit.of(low), unit.of(high), count)
        };
        let plot = axes(
            area,
            &axis(extent[0], self.moment, 5),
            &axis(extent[1], self.force, 8),
            [
                &format!("bending moment M [{}]{note}", self.moment.symbol),
                &format!("normal force N, tension positive [{}]", self.force.symbol),
            ],
        )?;
        let place = |point: &(f64, f64)| {
            plot.backend_coord(&(self.moment.of(point.0), self.force.of(point.1)))
        };
        self.draw_surface(page, &plot, extent)?;
        if let Some([moment, force]) = enlarged {
            let corners = [place(&(moment.0, force.1)), place(&(moment.1, force.0))];
            let outline = [
                corners[0],
                (corners[1].0, corners[0].1),
                corners[1],
                (corners[0].0, corners[1].1),
                corners[0],
            ];
            let stroke = Stroke {
                dashes: Some((16, 24)),
                ..Stroke::solid(colour::FAINT, 6)
            };
            stroke.draw(page, outline.to_vec())?;
        }
        for line in lines_once(self.path.iter().map(place)) {
            page.draw(&PathElement::new(line, self.colour.stroke_width(10)))?;
        }
        if let Some(point) = &self.first_yield {
            page::ring(page, place(point), self.colour)?;
        }
        if let (Some(start), Some(end)) = (self.path.first(), self.path.last()) {
            page::dot(page, place(start), colour::INK)?;
            let (x, y) = place(end);
            let corners = [(x - 28, y - 28), (x + 28, y + 28)];
            page.draw(&Rectangle::new(corners, colour::INK.filled()))?;
        }
        Ok(())
    }

    /// Draws the surface, clipped to the plot.
    fn draw_surface(&self, page: &Area<'_>, plot: &PlotArea<'_, '_>, extent: &Extent) -> Drawn<()> {
        let inside = clipped(&self.surface, extent);
        let place = |point: &(f64, f64)| {
            plot.backend_coord(&(self.moment.of(point.0), self.force.of(point.1)))
        };
        let polygon: Vec<_> = inside.iter().map(place).collect();
        if polygon.len() > 2 {
            page.draw(&Polygon::new(polygon, colour::SURFACE.mix(0.7).filled()))?;
        }
        // The middle of a piece of the plot's edge lies on that edge, even after rounding.
        let within = |(from, to): (f64, f64), value: f64| {
            let rounding = 1e-9 * (to - from);
            value > from + rounding && value < to - rounding
        };
        let on_surface = |from: &(f64, f64), to: &(f64, f64)| {
            within(extent[0], (from.0 + to.0) / 2.0) && within(extent[1], (from.1 + to.1) / 2.0)
        };
        // The outline follows the surface, not the edges of the plot.
        for line in inside.chunk_by(on_surface) {
            let line: Vec<_> = line.iter().map(place).collect();
            page.draw(&PathElement::new(line, colour::INK.stroke_width(8)))?;
        }
        Ok(())
    }
}

/// Clips a closed curve to a rectangle, edge by edge (Sutherland and Hodgman); exact because the surface is convex.
fn clipped(curve: &[(f64, f64)], [moment, force]: &Extent) -> Vec<(f64, f64)> {
    let mut points = curve.to_vec();
    // The signed distance from each edge, positive inside.
    type Distance<'e> = &'e dyn Fn(&(f64, f64)) -> f64;
    let edges: [Distance<'_>; 4] = [
        &|point| point.0 - moment.0,
        &|point| moment.1 - point.0,
        &|point| point.1 - force.0,
        &|point| force.1 - point.1,
    ];
    for inside in edges {
        let mut cut = Vec::with_capacity(points.len() + 2);
        for (number, point) in points.iter().enumerate() {
            let before = &points[(number + points.len() - 1) % points.len()];
            let (from, to) = (inside(before), inside(point));
            if (from < 0.0) != (to < 0.0) {
                let part = from / (from - to);
                cut.push((
                    before.0 + part * (point.0 - before.0),
                    before.1 + part * (point.1 - before.1),
                ));
            }
            if to >= 0.0 {
                cut.push(*point);
            }
        }
        points = cut;
    }
    points.extend(points.first().copied());
    points
}

/// The segments of a path in units of the canvas, each once however often the path passes it.
fn lines_once(path: impl Iterator<Item = (i32, i32)>) -> Vec<Vec<(i32, i32)>> {
    let mut drawn = HashSet::new();
    let mut lines: Vec<Vec<(i32, i32)>> = Vec::new();
    let mut last = None;
    for point in path {
        let Some(from) = last.replace(point) else {
            continue;
        };
        if from == point || !drawn.insert((from.min(point), from.max(point))) {
            continue;
        }
        match lines.last_mut() {
            Some(line) if line.last() == Some(&from) => line.push(point),
            _ => lines.push(vec![from, point]),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_back_and_forth_is_drawn_once() {
        let there = [(0, 0), (5, 0), (9, 3)];
        let and_back = there.iter().chain(there.iter().rev()).cycle().take(600);
        assert_eq!(lines_once(and_back.copied()), [there.to_vec()]);
        assert!(lines_once([(1, 1); 4].into_iter()).is_empty());
    }

    #[test]
    fn the_surface_is_clipped_to_the_plot() {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let cut = clipped(&square, &[(0.0, 5.0), (-0.5, 0.5)]);
        let expected = [(1.0, -0.5), (1.0, 0.5), (0.0, 0.5), (0.0, -0.5)];
        for corner in expected {
            assert!(cut.contains(&corner), "{cut:?}");
        }
        assert!(
            cut.iter()
                .all(|point| (0.0..=1.0).contains(&point.0) && point.1.abs() <= 0.5)
        );
        assert!(clipped(&square, &[(2.0, 3.0), (2.0, 3.0)]).is_empty());
    }
}
