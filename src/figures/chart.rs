//! Plots on a page: the axes of a plot, and the chart of quantities against time.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{PathElement, Polygon};
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::axis::PlotAxis;
use super::page::{
    self, Area, BOTTOM, CANVAS, Drawn, LEFT, LegendKey, RIGHT, SMALL, Stroke, TEXT, colour,
};
use super::thinning::thin_curve;
use super::units::Unit;

pub(super) type PlotArea<'a, 'b> =
    ChartContext<'b, SVGBackend<'a>, Cartesian2d<PlotAxis, PlotAxis>>;

/// Draws axes with marks, names and a light grid; the left and bottom edges of the area are kept free for the marks.
pub(super) fn axes<'a, 'b>(
    area: &'b Area<'a>,
    x: &PlotAxis,
    y: &PlotAxis,
    names: [&str; 2],
) -> Drawn<PlotArea<'a, 'b>> {
    let mut plot = ChartBuilder::on(area)
        .margin_left(EDGE)
        .margin_bottom(EDGE)
        .margin_right(RIGHT)
        .x_label_area_size(BOTTOM - EDGE)
        .y_label_area_size(LEFT - EDGE)
        .build_cartesian_2d(x.clone(), y.clone())?;
    plot.configure_mesh()
        .bold_line_style(colour::GRID.stroke_width(4))
        .axis_style(colour::INK.stroke_width(6))
        .x_desc(names[0])
        .y_desc(names[1])
        .label_style(page::text_style(
            SMALL,
            colour::INK,
            HPos::Center,
            VPos::Center,
        ))
        .axis_desc_style(page::text_style(
            TEXT,
            colour::INK,
            HPos::Center,
            VPos::Center,
        ))
        .set_all_tick_mark_size(24)
        .draw()?;
    Ok(plot)
}

/// Distance between the name of an axis and the edge of the page.
const EDGE: i32 = 28;

/// A curve over time, in SI units.
pub(super) struct Curve {
    /// Name in the legend; empty: not in the legend.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub stroke: Stroke,
    /// Colour of the area between the curve and zero, if it is filled.
    pub fill: Option<RGBColor>,
}

impl Curve {
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>, stroke: Stroke) -> Self {
        Self {
            name: name.into(),
            points,
            stroke,
            fill: None,
        }
    }
}

/// An area between two values over time, in SI units.
pub(super) struct Band {
    /// Name in the legend.
    pub name: String,
    /// Time, lower and upper value.
    pub points: Vec<(f64, f64, f64)>,
    pub colour: RGBColor,
}

/// How much of what is below a band it covers.
const BAND_OPACITY: f64 = 0.7;

/// A mark on a curve.
pub(super) struct Mark {
    pub time: f64,
    pub value: f64,
    pub colour: RGBColor,
    /// Text above a dot; without text the mark is a ring.
    pub text: Option<String>,
}

/// An upright arrow from zero for an instantaneous event.
pub(super) struct ImpulseArrow {
    pub time: f64,
    /// Height relative to the highest arrow, 0 to 1.
    pub height: f64,
    pub text: Option<String>,
}

/// Quantities of one kind against time.
#[derive(Default)]
pub(super) struct TimeChart<'a> {
    pub title: &'a str,
    pub lines: [&'a str; 2],
    /// Name of the vertical axis, without unit.
    pub quantity: &'a str,
    pub unit: Unit,
    /// First and last time \[s\].
    pub span: (f64, f64),
    /// Areas behind the curves.
    pub bands: Vec<Band>,
    pub curves: Vec<Curve>,
    pub marks: Vec<Mark>,
    pub arrows: Vec<ImpulseArrow>,
    /// Additional entries of the legend.
    pub keys: Vec<(LegendKey, String)>,
    /// Events named above the plot, with their times \[s\].
    pub events: Vec<(f64, &'a str)>,
}

impl TimeChart<'_> {
    /// The figure as SVG.
    pub fn draw(&self) -> Drawn<String> {
        page::draw(|page| {
            let top = page::heading(page, self.title, self.lines, &self.legend())?;
            let unit = Unit::time(self.span.0.abs().max(self.span.1.abs()));
            let time = PlotAxis::between(unit.of(self.span.0), unit.of(self.span.1), 10);
            let events = self.placed_events(page, &time, unit)?;
            let rows = events.iter().map(|event| event.row + 1).max().unwrap_or(0);
            let plot_top = top + 40 + rows * EVENT_ROW;
            let (_, below) = page.split_vertically(plot_top);
            let value = self.value_axis();
            let names = [
                &*format!("time t [{}]", unit.symbol),
                &*format!("{} [{}]", self.quantity, self.unit.symbol),
            ];
            let plot = axes(&below, &time, &value, names)?;
            let frame = Frame {
                page,
                plot: &plot,
                time: unit,
                value: self.unit,
            };
            draw_events(page, &plot, &events, plot_top)?;
            frame.zero_line(&time, &value)?;
            for band in &self.bands {
                frame.band(band)?;
            }
            for curve in &self.curves {
                frame.curve(curve)?;
            }
            for arrow in &self.arrows {
                frame.arrow(arrow, &value)?;
            }
            // Texts are drawn over rings.
            for ring in self.marks.iter().filter(|mark| mark.text.is_none()) {
                frame.mark(ring)?;
            }
            for mark in self.marks.iter().filter(|mark| mark.text.is_some()) {
                frame.mark(mark)?;
            }
            Ok(())
        })
    }

    fn legend(&self) -> Vec<(LegendKey, String)> {
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        let curves = named.map(|curve| {
            let key = match curve.fill {
                Some(colour) if curve.stroke.width == 0 => LegendKey::Fill(colour),
                _ => LegendKey::Line(curve.stroke),
            };
            (key, curve.name.clone())
        });
        let bands = self.bands.iter();
        let bands = bands.map(|band| (LegendKey::Fill(band.colour), band.name.clone()));
        curves
            .chain(bands)
            .chain(self.keys.iter().cloned())
            .collect()
    }

    /// An axis that contains every curve and zero, with room for the texts of the marks.
    fn value_axis(&self) -> PlotAxis {
        let values = self
            .curves
            .iter()
            .flat_map(|curve| curve.points.iter().map(|point| point.1));
        let bands = self.bands.iter().flat_map(|band| &band.points);
        let values = values.chain(bands.flat_map(|&(_, low, high)| [low, high]));
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((0.0, 0.0), |(low, high): (f64, f64), value| {
                (low.min(value), high.max(value))
            });
        let texts = self.marks.iter().any(|mark| mark.text.is_some());
        let room = if texts {
            0.09 * (high - low)
        } else {
            0.04 * (high - low)
        };
        let bottom = if low < 0.0 {
            low - 0.04 * (high - low)
        } else {
            0.0
        };
        let top = if high > 0.0 { high + room } else { 0.0 };
        PlotAxis::between(self.unit.of(bottom), self.unit.of(top), 8)
    }

    /// Places each event in the first row in which its text does not overlap another.
    fn placed_events(
        &self,
        page: &Area<'_>,
        time: &PlotAxis,
        unit: Unit,
    ) -> Drawn<Vec<PlacedEvent>> {
        let style = page::text_style(SMALL, colour::FAINT, HPos::Left, VPos::Center);
        let (left, right) = (LEFT, CANVAS.0 as i32 - RIGHT);
        let mut row_ends = [i32::MIN; 3];
        let mut placed = Vec::new();
        let mut events = self.events.clone();
        events.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (instant, name) in events {
            let part = (unit.of(instant) - time.from) / (time.to - time.from);
            // The last sample may be one step before the end time of the report.
            if !(0.0..=1.001).contains(&part) {
                continue;
            }
            let text = format!("{name} {}", unit.show(instant));
            let length = page::width(page, &text, &style)?;
            let x = left + (part * f64::from(right - left)) as i32;
            let start = (x - length / 2).min(right - length).max(LEFT + 20);
            let Some(row) = row_ends.iter().position(|end| *end + 80 < start) else {
                continue;
            };
            row_ends[row] = start + length;
            placed.push(PlacedEvent {
                time: unit.of(instant),
                text,
                start,
                row: row as i32,
            });
        }
        Ok(placed)
    }
}

const EVENT_ROW: i32 = 96;

struct PlacedEvent {
    /// In the unit of the axis.
    time: f64,
    text: String,
    start: i32,
    row: i32,
}

/// Draws a thin vertical line through the plot for each event, with its text above.
fn draw_events(
    page: &Area<'_>,
    plot: &PlotArea<'_, '_>,
    events: &[PlacedEvent],
    top: i32,
) -> Drawn<()> {
    let style = page::text_style(SMALL, colour::FAINT, HPos::Left, VPos::Center);
    let range = plot.plotting_area().get_pixel_range().1;
    for event in events {
        let y = top - 52 - event.row * EVENT_ROW;
        let (x, _) = plot.backend_coord(&(event.time, 0.0));
        page.draw_text(&event.text, &style, (event.start, y))?;
        if (x - LEFT).abs() < 8 {
            continue; // the axis is drawn there
        }
        let stroke = Stroke {
            dashes: Some((16, 24)),
            ..Stroke::solid(colour::FAINT, 6)
        };
        stroke.draw(page, vec![(x, top - 8), (x, range.end)])?;
    }
    Ok(())
}

/// A plot with the units of its axes; everything is given in SI units.
struct Frame<'a, 'b, 'c> {
    page: &'c Area<'a>,
    plot: &'c PlotArea<'a, 'b>,
    time: Unit,
    value: Unit,
}

impl Frame<'_, '_, '_> {
    fn place(&self, time: f64, value: f64) -> (i32, i32) {
        self.plot
            .backend_coord(&(self.time.of(time), self.value.of(value)))
    }

    fn zero_line(&self, time: &PlotAxis, value: &PlotAxis) -> Drawn<()> {
        if value.from >= 0.0 || value.to <= 0.0 {
            return Ok(());
        }
        let ends = [time.from, time.to].map(|end| self.plot.backend_coord(&(end, 0.0)));
        self.page.draw(&PathElement::new(
            ends.to_vec(),
            colour::FAINT.stroke_width(6),
        ))
    }

    fn band(&self, band: &Band) -> Drawn<()> {
        let edge = |of: fn(&(f64, f64, f64)) -> f64| {
            let points = band.points.iter().map(move |point| (point.0, of(point)));
            let thinned = thin_curve(&points.collect::<Vec<_>>(), CANVAS.0 as usize / 4);
            thinned
                .into_iter()
                .map(|(time, value)| self.place(time, value))
        };
        let mut outline: Vec<_> = edge(|point| point.1).collect();
        outline.extend(edge(|point| point.2).rev());
        if let [low, high] = *outline {
            let stroke = Stroke::solid(band.colour, 24);
            return stroke.draw(self.page, vec![low, high]);
        }
        let style = band.colour.mix(BAND_OPACITY).filled();
        self.page.draw(&Polygon::new(outline, style))
    }

    fn curve(&self, curve: &Curve) -> Drawn<()> {
        let points: Vec<_> = thin_curve(&curve.points, CANVAS.0 as usize / 4)
            .into_iter()
            .map(|(time, value)| self.place(time, value))
            .collect();
        let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) else {
            return Ok(());
        };
        if let Some(fill) = curve.fill {
            let zero = self.place(0.0, 0.0).1;
            let mut outline = points.clone();
            outline.extend([(last.0, zero), (first.0, zero)]);
            self.page.draw(&Polygon::new(outline, fill.filled()))?;
        }
        if points.len() == 1 {
            return page::dot(self.page, first, curve.stroke.colour);
        }
        if curve.stroke.width > 0 {
            curve.stroke.draw(self.page, points)?;
        }
        Ok(())
    }

    fn mark(&self, mark: &Mark) -> Drawn<()> {
        if !mark.time.is_finite() || !mark.value.is_finite() {
            return Ok(());
        }
        let place = self.place(mark.time, mark.value);
        match &mark.text {
            None => page::ring(self.page, place, mark.colour),
            Some(text) => {
                page::dot(self.page, place, mark.colour)?;
                let range = self.plot.plotting_area().get_pixel_range().0;
                let above = (place.0, place.1 - 56);
                page::label(
                    self.page,
                    text,
                    above,
                    (range.start, range.end),
                    colour::INK,
                )
            }
        }
    }

    fn arrow(&self, arrow: &ImpulseArrow, value: &PlotAxis) -> Drawn<()> {
        let range = self.plot.plotting_area().get_pixel_range();
        let (x, foot) = self.place(arrow.time, 0.0);
        // The highest arrow stays below the text of the peak.
        let highest = f64::from(self.plot.backend_coord(&(0.0, value.to)).1 - foot) * 0.6;
        let head = foot + (highest * arrow.height) as i32;
        page::arrow(self.page, x, foot, head, colour::IMPACT_IMPULSE)?;
        let Some(text) = &arrow.text else {
            return Ok(());
        };
        page::label(
            self.page,
            text,
            (x, head - 16),
            (range.0.start, range.0.end),
            colour::IMPACT_IMPULSE,
        )
    }
}
