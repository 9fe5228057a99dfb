//! The plot of a damage map on its page: areas, lines with labels, marks and the frame.

use plotters::element::{PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axis::PlotAxis;
use super::chart::PlotArea;
use super::map_marks::Mark;
use super::page::{self, Area, Drawn, SMALL, Stroke, colour};
use crate::assessment::Action;
use crate::shape::action_colour;

/// Height and least distance of the labels on lines.
const LABEL: i32 = 88;
pub(super) const NOT_COMPUTED: RGBColor = RGBColor(235, 235, 235);
/// The colour of iso-lines.
const ISO_LINE: RGBColor = RGBColor(20, 60, 110);

/// A level in words, and its lines in the units of the figure.
pub(super) type Level = (String, Vec<Vec<(f64, f64)>>);

/// The colour of a class.
pub(super) fn rgb(action: Action) -> RGBColor {
    let [red, green, blue] = action_colour(action);
    RGBColor(red, green, blue)
}

/// A plot on the page.
pub(super) struct Picture<'p, 'a, 'b> {
    pub page: &'p Area<'a>,
    pub plot: &'p PlotArea<'a, 'b>,
    pub x: &'p PlotAxis,
    pub y: &'p PlotAxis,
}

impl Picture<'_, '_, '_> {
    /// Fills the whole plot.
    pub fn background(&self, action: Action) -> Drawn<()> {
        self.patch(
            (self.x.from, self.x.to),
            (self.y.from, self.y.to),
            Some(action),
        )
    }

    /// Fills a rectangle; grey, where nothing was computed.
    pub fn patch(&self, x: (f64, f64), y: (f64, f64), action: Option<Action>) -> Drawn<()> {
        let y = (self.clamped(y.0), self.clamped(y.1));
        let lower = self.plot.backend_coord(&(x.0, y.0));
        let upper = self.plot.backend_coord(&(x.1, y.1));
        let colour = action.map_or(NOT_COMPUTED, rgb);
        self.page
            .draw(&Rectangle::new([lower, upper], colour.filled()))
    }

    /// Fills what lies above a line.
    pub fn above(&self, line: &[(f64, f64)], action: Action) -> Drawn<()> {
        let (Some(first), Some(last)) = (line.first(), line.last()) else {
            return Ok(());
        };
        let corners = [(last.0, self.y.to), (first.0, self.y.to)];
        let points = line
            .iter()
            .chain(&corners)
            .map(|(x, y)| self.plot.backend_coord(&(*x, self.clamped(*y))));
        self.page.draw(&Polygon::new(
            points.collect::<Vec<_>>(),
            rgb(action).filled(),
        ))
    }

    /// Shades what lies between two lines with the same values along the axis of the rows.
    pub fn between(&self, lines: &[(f64, [f64; 2])], tone: RGBColor) -> Drawn<()> {
        let place = |x: f64, y: f64| self.plot.backend_coord(&(x, self.clamped(y)));
        let lower = lines.iter().map(|(x, [low, _])| place(*x, *low));
        let upper = lines.iter().rev().map(|(x, [_, high])| place(*x, *high));
        let corners: Vec<_> = lower.chain(upper).collect();
        match corners.len() {
            0..4 => Ok(()),
            _ => self
                .page
                .draw(&Polygon::new(corners, tone.mix(0.45).filled())),
        }
    }

    fn clamped(&self, y: f64) -> f64 {
        y.clamp(self.y.from, self.y.to)
    }

    /// Draws a line through points in the units of the figure, as far as they are in the plot.
    pub fn line(&self, points: &[(f64, f64)], stroke: Stroke) -> Drawn<()> {
        let room = 1e-9 * (self.y.to - self.y.from);
        let is_outside =
            |point: &(f64, f64)| !(self.y.from - room..=self.y.to + room).contains(&point.1);
        for points in points.split(is_outside) {
            let mut line: Vec<_> = points
                .iter()
                .map(|point| self.plot.backend_coord(point))
                .collect();
            line.dedup();
            if line.len() > 1 {
                stroke.draw(self.page, line)?;
            }
        }
        Ok(())
    }

    /// As [`line`](Self::line), with a white edge on both sides, so that it stays visible on every area and beside other lines.
    pub fn edged_line(&self, points: &[(f64, f64)], stroke: Stroke) -> Drawn<()> {
        self.line(points, Stroke::solid(WHITE, stroke.width + 6))?;
        self.line(points, stroke)
    }

    /// Draws iso-lines.
    pub fn iso_lines(&self, levels: &[Level]) -> Drawn<()> {
        let mut lines = levels.iter().flat_map(|(_, lines)| lines);
        lines.try_for_each(|line| self.edged_line(line, Stroke::solid(ISO_LINE, 8)))
    }

    /// Labels iso-lines where there is room for it.
    pub fn iso_labels(&self, levels: &[Level]) -> Drawn<()> {
        let style = page::text_style(SMALL, ISO_LINE, HPos::Center, VPos::Center);
        let mut taken: Vec<[i32; 4]> = Vec::new();
        let (horizontal, vertical) = self.plot.plotting_area().get_pixel_range();
        for (text, lines) in levels {
            let width = page::width(self.page, text, &style)?;
            let longest = lines.iter().max_by_key(|line| line.len());
            let Some(line) = longest.filter(|line| line.len() > 4) else {
                continue;
            };
            for part in [0.5, 0.35, 0.65, 0.25, 0.75, 0.15, 0.85] {
                let place = line[((line.len() - 1) as f64 * part) as usize];
                let (x, y) = self.plot.backend_coord(&place);
                let (half_width, half_height) = (width / 2 + 24, LABEL / 2);
                let label = [
                    x - half_width,
                    y - half_height,
                    x + half_width,
                    y + half_height,
                ];
                let fits = label[0] >= horizontal.start
                    && label[2] <= horizontal.end
                    && label[1] >= vertical.start
                    && label[3] <= vertical.end;
                let overlaps = taken.iter().any(|other| {
                    label[0] < other[2] + 40
                        && label[2] + 40 > other[0]
                        && label[1] < other[3] + 20
                        && label[3] + 20 > other[1]
                });
                if fits && !overlaps {
                    let [left, top, right, bottom] = label;
                    self.page.draw(&Rectangle::new(
                        [(left, top), (right, bottom)],
                        WHITE.mix(0.8).filled(),
                    ))?;
                    self.page.draw_text(text, &style, (x, y))?;
                    taken.push(label);
                    break;
                }
            }
        }
        Ok(())
    }

    /// Draws dashed lines across the plot at marks of its axes, in their units, with their names.
    pub fn mark(&self, along_x: &[Mark], along_y: &[Mark]) -> Drawn<()> {
        let (horizontal, vertical) = self.plot.plotting_area().get_pixel_range();
        let stroke = Stroke::dashed(colour::FAINT, 5);
        let range = (horizontal.start, horizontal.end);
        let in_plot = |mark: &&Mark| (self.y.from..=self.y.to).contains(&mark.value);
        for mark in along_y.iter().filter(in_plot) {
            self.line(
                &[(self.x.from, mark.value), (self.x.to, mark.value)],
                stroke,
            )?;
            let (_, y) = self.plot.backend_coord(&(self.x.to, mark.value));
            page::label(
                self.page,
                &mark.name,
                (horizontal.end, y),
                range,
                colour::FAINT,
            )?;
        }
        for mark in along_x {
            self.line(
                &[(mark.value, self.y.from), (mark.value, self.y.to)],
                stroke,
            )?;
            let (x, _) = self.plot.backend_coord(&(mark.value, self.y.from));
            page::label(
                self.page,
                &mark.name,
                (x, vertical.end - 20),
                range,
                colour::FAINT,
            )?;
        }
        Ok(())
    }

    /// Writes a name into the upper left corner of the plot.
    pub fn name(&self, text: &str) -> Drawn<()> {
        let (horizontal, vertical) = self.plot.plotting_area().get_pixel_range();
        let place = (horizontal.start + 200, vertical.start + 130);
        page::label(
            self.page,
            text,
            place,
            (horizontal.start, horizontal.end),
            colour::INK,
        )
    }

    /// Draws the frame of the plot over what was filled.
    pub fn frame(&self) -> Drawn<()> {
        let (from, to) = ((self.x.from, self.y.from), (self.x.to, self.y.to));
        let corners = [from, (to.0, from.1), to, (from.0, to.1), from];
        let corners: Vec<_> = corners
            .iter()
            .map(|it| self.plot.backend_coord(it))
            .collect();
        self.page
            .draw(&PathElement::new(corners, colour::INK.stroke_width(6)))
    }
}
