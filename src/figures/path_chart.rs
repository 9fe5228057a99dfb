//! The chart of one quantity over another that is not time: paths, envelopes and shapes.

use super::axis::PlotAxis;
use super::chart::{Mark, axes};
use super::page::{self, Drawn, LegendKey, Stroke, colour};
use super::units::Unit;

/// An axis of the chart.
pub(super) struct PathAxis<'a> {
    /// Name without unit.
    pub name: &'a str,
    pub unit: Unit,
    /// Values that the axis shows whatever the lines are, in SI units.
    pub includes: &'a [f64],
}

/// A line through points in SI units, in any order.
pub(super) struct PathLine {
    /// Name in the legend; empty: not in the legend.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub stroke: Stroke,
}

impl PathLine {
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>, stroke: Stroke) -> Self {
        Self {
            name: name.into(),
            points,
            stroke,
        }
    }
}

/// One quantity over another. A [`Mark`] has its horizontal place in its `time`.
pub(super) struct PathChart<'a> {
    pub title: &'a str,
    pub lines: [&'a str; 2],
    pub x: PathAxis<'a>,
    pub y: PathAxis<'a>,
    pub paths: Vec<PathLine>,
    pub marks: Vec<Mark>,
    /// Additional entries of the legend.
    pub keys: Vec<(LegendKey, String)>,
}

impl PathChart<'_> {
    /// The figure as SVG.
    pub fn draw(&self) -> Drawn<String> {
        page::draw(|page| {
            let top = page::heading(page, self.title, self.lines, &self.legend())?;
            let (_, below) = page.split_vertically(top + 40);
            let x = self.axis(&self.x, |point| point.0, 8);
            let y = self.axis(&self.y, |point| point.1, 8);
            let names = [
                &*format!("{} [{}]", self.x.name, self.x.unit.symbol),
                &*format!("{} [{}]", self.y.name, self.y.unit.symbol),
            ];
            let plot = axes(&below, &x, &y, names)?;
            let place = |point: &(f64, f64)| {
                plot.backend_coord(&(self.x.unit.of(point.0), self.y.unit.of(point.1)))
            };
            for path in &self.paths {
                let mut points: Vec<_> = path.points.iter().filter(is_finite).map(place).collect();
                points.dedup();
                match points.as_slice() {
                    [] => {}
                    [only] => page::dot(page, *only, path.stroke.colour)?,
                    _ => path.stroke.draw(page, points)?,
                }
            }
            let range = plot.plotting_area().get_pixel_range().0;
            for mark in &self.marks {
                let point = (mark.time, mark.value);
                if !is_finite(&&point) {
                    continue;
                }
                let centre = place(&point);
                match &mark.text {
                    None => page::ring(page, centre, mark.colour)?,
                    Some(text) => {
                        page::dot(page, centre, mark.colour)?;
                        let above = (centre.0, centre.1 - 56);
                        page::label(page, text, above, (range.start, range.end), colour::INK)?;
                    }
                }
            }
            Ok(())
        })
    }

    fn legend(&self) -> Vec<(LegendKey, String)> {
        let named = self.paths.iter().filter(|path| !path.name.is_empty());
        named
            .map(|path| (LegendKey::Line(path.stroke), path.name.clone()))
            .chain(self.keys.iter().cloned())
            .collect()
    }

    /// An axis that contains every line, with room for the texts of the marks.
    fn axis(
        &self,
        axis: &PathAxis<'_>,
        value: impl Fn(&(f64, f64)) -> f64,
        count: usize,
    ) -> PlotAxis {
        let lines = self.paths.iter().flat_map(|path| path.points.iter());
        let values = lines.map(value).chain(axis.includes.iter().copied());
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let room = 0.09 * (high - low);
        let low = if low == 0.0 { low } else { low - 0.5 * room };
        PlotAxis::between(axis.unit.of(low), axis.unit.of(high + room), count)
    }
}

fn is_finite(point: &&(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}
