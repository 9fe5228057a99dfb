//! The push-down curves: axial force over shortening, undamaged and now.

use plotters::element::PathElement;
use plotters::style::{Color, RGBColor};

use super::axis::PlotAxis;
use super::chart::axes;
use super::page::{self, Drawn, LegendKey, Stroke, colour};
use super::units::{Unit, significant};
use super::{FigureError, drawn};
use crate::assessment::ResidualCapacity;
use crate::column::{Capacity, PushDownPoint};

/// Most points of a drawn curve.
const MAX_POINTS: usize = 2_000;

/// Size of the label of a peak, with the space around it \[pixels\].
const LABEL_SIZE: (u32, u32) = (280, 90);

/// What the figure of a push-down shows.
#[derive(Debug, Clone, Copy)]
pub struct PushDownCurves<'a> {
    /// One line that describes the column.
    pub title: &'a str,
    /// The curve of the undamaged column.
    pub undamaged: &'a [PushDownPoint],
    /// The curve of the column as it is; empty if it carries nothing, or if it is undamaged.
    pub now: &'a [PushDownPoint],
    /// Capacities, resistances and the carried load.
    pub remaining: &'a ResidualCapacity,
}

/// The figure as SVG.
///
/// # Errors
/// No curve has a point, or the plotting library fails.
pub fn push_down_svg(curves: &PushDownCurves<'_>) -> Result<String, FigureError> {
    if curves.undamaged.is_empty() && curves.now.is_empty() {
        return Err(FigureError::NoSamples);
    }
    drawn("push_down", curves.draw())
}

/// A horizontal line at a force.
struct Level {
    name: String,
    force: f64,
    stroke: Stroke,
}

impl PushDownCurves<'_> {
    fn draw(&self) -> Drawn<String> {
        let points = || self.undamaged.iter().chain(self.now);
        let largest = |value: fn(&PushDownPoint) -> f64| {
            let finite = points().map(value).filter(|value| value.is_finite());
            finite.fold(0.0, f64::max)
        };
        let levels = self.levels();
        let highest = levels
            .iter()
            .fold(largest(|point| point.force), |high, level| {
                high.max(level.force)
            });
        let force = Unit::force(highest);
        let length = Unit::length(largest(|point| point.shortening));
        let shortening = PlotAxis::between(0.0, length.of(largest(|point| point.shortening)), 10);
        let height = PlotAxis::between(0.0, force.of(1.1 * highest), 8);
        page::draw(|page| {
            let lines = [self.title, &self.key(force)];
            let title = "Axial force over shortening (static push-down)";
            let top = page::heading(page, title, lines, &self.legend(&levels))?;
            let (_, below) = page.split_vertically(top + 40);
            let names = [
                &*format!("shortening of the column [{}]", length.symbol),
                &*format!("compressive force at the top [{}]", force.symbol),
            ];
            let plot = axes(&below, &shortening, &height, names)?;
            let place = |x: f64, y: f64| plot.backend_coord(&(length.of(x), force.of(y)));
            for level in &levels {
                let (left, right) = (length.of(0.0), shortening.to);
                let y = force.of(level.force);
                let line = vec![
                    plot.backend_coord(&(left, y)),
                    plot.backend_coord(&(right, y)),
                ];
                level.stroke.draw(page, line)?;
            }
            let drawn = [
                (self.undamaged, colour::FAINT, &self.remaining.undamaged),
                (self.now, colour::IMPACT_POINT, &self.remaining.now),
            ];
            let mut last_label: Option<(i32, i32)> = None;
            for (curve, colour, capacity) in drawn {
                let every = curve.len().div_ceil(MAX_POINTS).max(1);
                let line: Vec<_> = curve
                    .iter()
                    .step_by(every)
                    .map(|point| place(point.shortening, point.force))
                    .collect();
                page.draw(&PathElement::new(line, colour.stroke_width(12)))?;
                if !curve.is_empty() {
                    let peak = place(capacity.shortening, capacity.force);
                    page::dot(page, peak, colour)?;
                    let (range, _) = plot.plotting_area().get_pixel_range();
                    let text = force.show(capacity.force);
                    let mut at = (peak.0, peak.1 - 30);
                    if last_label.is_some_and(|last| {
                        at.0.abs_diff(last.0) < LABEL_SIZE.0 && at.1.abs_diff(last.1) < LABEL_SIZE.1
                    }) {
                        // A column with little damage has its peak next to that of the undamaged one.
                        at.0 += LABEL_SIZE.0 as i32;
                    }
                    last_label = Some(at);
                    page::label(page, &text, at, (range.start, range.end), colour)?;
                }
            }
            Ok(())
        })
    }

    /// The carried load and the weak-axis resistance, as far as there are any.
    fn levels(&self) -> Vec<Level> {
        let level = |name: &str, force: Option<f64>, colour: RGBColor| {
            force.filter(|force| *force > 0.0).map(|force| Level {
                name: name.to_owned(),
                force,
                stroke: Stroke::dashed(colour, 8),
            })
        };
        let remaining = self.remaining;
        [
            level(
                "applied load N",
                Some(remaining.carried_load),
                colour::IMPACTOR,
            ),
            level(
                "weak-axis resistance when undamaged (EN 1993-1-1)",
                remaining.weak.map(|weak| weak.force),
                colour::TOP,
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn legend(&self, levels: &[Level]) -> Vec<(LegendKey, String)> {
        let curve = |colour, name: &str| (LegendKey::Line(Stroke::solid(colour, 12)), name.into());
        let mut entries = vec![curve(colour::FAINT, "undamaged column")];
        if !self.now.is_empty() {
            entries.push(curve(colour::IMPACT_POINT, "column as it is"));
        }
        let levels = levels
            .iter()
            .map(|level| (LegendKey::Line(level.stroke), level.name.clone()));
        entries.extend(levels);
        entries
    }

    fn key(&self, unit: Unit) -> String {
        let remaining = self.remaining;
        let bound = |capacity: &Capacity| {
            if capacity.is_lower_bound() {
                "at least "
            } else {
                ""
            }
        };
        let reserve = remaining
            .reserve
            .map_or("no load".to_owned(), |it| significant(it, 3));
        format!(
            "push-down undamaged {}{}, now {}{}, ratio {}; N_u / N = {reserve}; bow {}",
            bound(&remaining.undamaged),
            unit.show(remaining.undamaged.force),
            bound(&remaining.now),
            unit.show(remaining.now.force),
            significant(remaining.ratio, 3),
            Unit::length(remaining.undamaged.imperfection).show(remaining.undamaged.imperfection),
        )
    }
}
