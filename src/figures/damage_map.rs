//! The figures of a damage map: the classes over its plane, and the boundaries of several columns in comparison.

use plotters::style::RGBColor;

use super::chart::axes;
use super::iso_lines::iso_lines;
use super::map_areas::{Areas, Island, island};
use super::map_axis::ShownAxis;
use super::map_picture::{Level, NOT_COMPUTED, Picture, rgb};
use super::page::{self, CANVAS, Drawn, LegendKey, Stroke};
use super::units::{Unit, significant};
use crate::assessment::Action;
use crate::study::{
    ACTIONS, DamageMap, Limit, MapBands, MapGrid, MapQuantity, RefinedMap, RowBoundary,
};

/// Places along the axis of the rows at which a boundary is drawn.
const BOUNDARY_POINTS: usize = 240;
/// Most iso-lines of a figure.
const MAX_LEVELS: usize = 5;
/// Part of the axis of the columns above which a figure is not cut off: too little would be gained.
const LEAST_CUT: f64 = 0.85;
/// What a figure that is cut off shows beyond the last boundary.
const BEYOND: f64 = 1.15;

/// What the figures of a map show.
#[derive(Debug, Clone, Copy)]
pub struct MapFigures<'a> {
    /// The map.
    pub map: &'a DamageMap,
    /// Its cells, as far as they were computed.
    pub grid: Option<&'a MapGrid>,
    /// The boundaries of its classes.
    pub refined: Option<&'a RefinedMap>,
    /// The bands of the boundaries.
    pub bands: Option<&'a MapBands>,
    /// What the map is about, in one line.
    pub subject: &'a str,
    /// What it assumes, in one line.
    pub assumptions: &'a str,
}

/// What a line that compares columns looks like: colour, and whether it is dashed.
const COMPARED: [(RGBColor, bool); 8] = [
    (RGBColor(0, 114, 178), false),
    (RGBColor(213, 94, 0), false),
    (RGBColor(0, 158, 115), false),
    (RGBColor(204, 121, 167), false),
    (RGBColor(86, 180, 233), true),
    (RGBColor(230, 159, 0), true),
    (RGBColor(30, 30, 30), true),
    (RGBColor(150, 150, 150), true),
];

/// What the line of a limit looks like.
fn limit_stroke(limit: Limit) -> Stroke {
    match limit {
        Limit::WebYields => Stroke::dashed(RGBColor(0, 110, 60), 13),
        Limit::BaseFails => Stroke::dashed(RGBColor(170, 0, 130), 13),
    }
}

/// The colour of a boundary on the areas on both sides of it.
const BOUNDARY: RGBColor = RGBColor(30, 30, 30);

impl MapFigures<'_> {
    /// The figures as SVG, by their names.
    pub(super) fn draw(&self) -> Vec<(String, Drawn<String>)> {
        let variants = self.map.variants();
        let mut figures: Vec<_> = (0..variants.len())
            .map(|variant| {
                let name = match variants {
                    [_] => "damage_map".to_owned(),
                    variants => format!("damage_map_{}", file_name(&variants[variant].label)),
                };
                (name, self.classes(variant))
            })
            .collect();
        if variants.len() > 1 && self.refined.is_some() {
            figures.push(("damage_map_comparison".to_owned(), self.comparison()));
        }
        if let (Some(refined), Some(bands), Some(_)) =
            (self.refined, self.bands, self.map.rows().ends())
        {
            for (variant, it) in variants.iter().enumerate() {
                let name = match variants {
                    [_] => "damage_map_bands".to_owned(),
                    _ => format!("damage_map_bands_{}", file_name(&it.label)),
                };
                figures.push((name, self.bands(refined, bands, variant)));
            }
        }
        figures
    }

    fn axes(&self) -> [ShownAxis<'_>; 2] {
        [self.map.rows(), self.map.columns()].map(ShownAxis::of)
    }

    /// The classes of one variant over the plane.
    fn classes(&self, variant: usize) -> Drawn<String> {
        let [rows, columns] = self.axes();
        let cut = self.cut(variant);
        let (x, y) = (rows.plot_axis(10), columns.plot_axis_to(cut, 8));
        let title = format!(
            "Action over {} and {}",
            rows.axis.quantity().name(),
            columns.axis.quantity().name()
        );
        let subject = match self.map.variants() {
            [_] => self.subject.to_owned(),
            variants => format!("{}: {}", variants[variant].label, self.subject),
        };
        let lines = self.levels(variant);
        let mut key = Vec::new();
        if self.refined.is_some() {
            key.push(match columns.axis.quantity() {
                MapQuantity::Velocity => "black lines: critical velocities, to 1 %",
                _ => "black lines: boundaries of the classes, to 1 %",
            });
        }
        if !lines.is_empty() {
            key.push("blue lines: residual displacement");
        }
        let end = cut.map(|cut| {
            let value = significant(columns.of_si(cut), 3);
            let (symbol, all) = (&columns.symbol, Action::Evacuate);
            format!("cut off at {value} {symbol}, above it all is {all}")
        });
        key.extend(end.as_deref());
        let key = key.join("; ");
        page::draw(|page| {
            let top = page::heading(
                page,
                &title,
                [&subject, self.assumptions, &key],
                &self.legend(variant),
            )?;
            let (_, below) = page.split_vertically(top + 20);
            let plot = axes(&below, &x, &y, [&rows.name(), &columns.name()])?;
            let picture = Picture {
                page,
                plot: &plot,
                x: &x,
                y: &y,
            };
            match self.grid {
                Some(grid) => self.fill_cells(&picture, grid, variant)?,
                None => self.fill_boundaries(&picture, variant)?,
            }
            for action in ACTIONS {
                self.boundary(&picture, variant, action, Stroke::solid(BOUNDARY, 12))?;
            }
            picture.iso_lines(&lines)?;
            for limit in Limit::ALL {
                self.limit(&picture, variant, limit)?;
            }
            picture.iso_labels(&lines)?;
            picture.mark(&rows.marks(), &columns.marks())?;
            picture.frame()
        })
    }

    fn legend(&self, variant: usize) -> Vec<(LegendKey, String)> {
        let actions = [Action::None].into_iter().chain(ACTIONS);
        let fill = |action| (LegendKey::Fill(rgb(action)), action.name().to_owned());
        let mut legend: Vec<_> = actions.map(fill).collect();
        let is_missing = |grid: &MapGrid| {
            let columns = 0..grid.columns().len();
            (0..grid.rows().len()).any(|row| {
                columns
                    .clone()
                    .any(|column| grid.cell(variant, row, column).is_none())
            })
        };
        if self.grid.is_some_and(is_missing) {
            legend.push((LegendKey::Fill(NOT_COMPUTED), "not computed".to_owned()));
        }
        let limits = self.refined.iter().flat_map(|refined| &refined.limits);
        let limits = limits.filter(|it| it.variant == variant);
        legend.extend(limits.map(|it| {
            let key = LegendKey::Line(limit_stroke(it.limit));
            (key, it.limit.in_words().to_owned())
        }));
        legend
    }

    /// The value on the axis of the columns at which the figure of a variant is cut off, because everything above it has the most
    /// severe class; `None` where little would be gained.
    fn cut(&self, variant: usize) -> Option<f64> {
        let refined = self.refined?;
        let [from, to] = self.map.columns().ends()?;
        let mut boundaries = refined.boundaries.iter();
        let last = boundaries.find(|it| (it.variant, it.action) == (variant, Action::Evacuate))?;
        let mut highest = from;
        for point in &last.points {
            match point.place {
                RowBoundary::Between {
                    at, rising: true, ..
                } => highest = highest.max(at),
                RowBoundary::Always => {}
                _ => return None,
            }
        }
        let limits = refined.limits.iter().filter(|it| it.variant == variant);
        let places = limits
            .flat_map(|it| &it.points)
            .filter_map(|it| it.place.value());
        let cut = BEYOND * places.fold(highest, f64::max);
        let is_trivial = |grid: &MapGrid| {
            (0..grid.columns().len()).all(|column| {
                let is_above = self.map.columns().number(grid.columns()[column]) > Some(highest);
                let evacuates = |row: usize| {
                    let cell = grid.cell(variant, row, column);
                    cell.is_some_and(|it| it.action == Action::Evacuate)
                };
                // Between two rows, the boundary may be a little higher than in them.
                !is_above || (0..grid.rows().len()).all(evacuates) || {
                    self.map.columns().number(grid.columns()[column]) < Some(cut)
                }
            })
        };
        let is_worth_it = cut - from < LEAST_CUT * (to - from) && highest > from;
        (is_worth_it && self.grid.is_none_or(is_trivial)).then_some(cut)
    }

    /// Fills the cells. Where a boundary is known more exactly than the cells show it, it is the edge.
    fn fill_cells(
        &self,
        picture: &Picture<'_, '_, '_>,
        grid: &MapGrid,
        variant: usize,
    ) -> Drawn<()> {
        let [rows, columns] = self.axes();
        let row_edges = rows.edges(grid.rows(), picture.x);
        let column_edges = columns.edges(grid.columns(), picture.y);
        let can_be_refined = self.refined.is_some() && rows.axis.ends().is_some();
        let parts = match can_be_refined {
            true => (BOUNDARY_POINTS / grid.rows().len()).clamp(1, 24),
            false => 1,
        };
        let mut areas = Areas::default();
        let mut islands: Vec<Island> = Vec::new();
        for row in 0..grid.rows().len() {
            let (left, right) = (row_edges[row], row_edges[row + 1]);
            for part in 0..parts {
                let at = |part: usize| left + (right - left) * part as f64 / parts as f64;
                let strip = (at(part), at(part + 1));
                let middle = 0.5 * (strip.0 + strip.1) / rows.per_si;
                let exact = |class: Action, column: usize| {
                    let place = grid.rows()[row] as usize;
                    let value = self.boundary_at(self.refined?, variant, class, place, middle)?;
                    let (low, high) = (
                        columns.at(grid.columns()[column - 1]),
                        columns.at(grid.columns()[column]),
                    );
                    // Within a row of cells, a boundary may run from one cell to the next.
                    let room = 1.5 * (high - low);
                    let value = columns.of_si(value);
                    (low - room..high + room).contains(&value).then_some(value)
                };
                let mut begins = [None; ACTIONS.len()];
                let mut highest = Action::None;
                for column in 0..grid.columns().len() {
                    let found = grid.cell(variant, row, column).map(|cell| cell.action);
                    let edge = column_edges[column];
                    for (class, begin) in ACTIONS.into_iter().zip(&mut begins) {
                        if begin.is_none() && found.is_some_and(|found| found >= class) {
                            let exact = if column == 0 {
                                None
                            } else {
                                exact(class, column)
                            };
                            *begin = Some(exact.unwrap_or(edge));
                        }
                    }
                    highest = highest.max(found.unwrap_or(highest));
                    // A class that is left again, and cells that were not computed.
                    if found != Some(highest) && part == 0 {
                        let range = (edge, column_edges[column + 1]);
                        island(&mut islands, (left, right), range, found);
                    }
                }
                areas.push(strip, begins);
            }
        }
        areas.fill(picture)?;
        islands
            .into_iter()
            .try_for_each(|(strip, range, found)| picture.patch(strip, range, found))
    }

    /// Fills the areas between the boundaries, where there are no cells.
    fn fill_boundaries(&self, picture: &Picture<'_, '_, '_>, variant: usize) -> Drawn<()> {
        let Some(refined) = self.refined else {
            return Ok(());
        };
        let [rows, columns] = self.axes();
        let count = match rows.axis.ends() {
            Some(_) => BOUNDARY_POINTS,
            None => rows.axis.len() as usize,
        };
        let mut areas = Areas::default();
        for strip in 0..count {
            let at = |part: usize| {
                picture.x.from + (picture.x.to - picture.x.from) * part as f64 / count as f64
            };
            let (left, right) = (at(strip), at(strip + 1));
            let middle = 0.5 * (left + right) / rows.per_si;
            let begins = ACTIONS.map(|action| {
                let value = self.boundary_at(refined, variant, action, strip, middle);
                let value = value.map(|value| columns.of_si(value));
                let is_everywhere = refined.always_at(self.map, variant, action, middle);
                value.or(is_everywhere.then_some(picture.y.from))
            });
            areas.push((left, right), begins);
        }
        areas.fill(picture)
    }

    /// A boundary at a value of the axis of the rows, or in a row that has a name.
    fn boundary_at(
        &self,
        refined: &RefinedMap,
        variant: usize,
        action: Action,
        row: usize,
        value: f64,
    ) -> Option<f64> {
        if self.map.rows().ends().is_some() {
            return refined.value_at(self.map, variant, action, value);
        }
        let boundary = refined
            .boundaries
            .iter()
            .find(|it| it.variant == variant && it.action == action)?;
        let point = boundary
            .points
            .iter()
            .find(|point| point.row == row as u64)?;
        point.place.value()
    }

    /// Draws a boundary.
    fn boundary(
        &self,
        picture: &Picture<'_, '_, '_>,
        variant: usize,
        action: Action,
        stroke: Stroke,
    ) -> Drawn<()> {
        let Some(refined) = self.refined else {
            return Ok(());
        };
        let at = |row: usize, value: f64| self.boundary_at(refined, variant, action, row, value);
        for line in self.lines(at) {
            picture.line(&line, stroke)?;
        }
        Ok(())
    }

    /// Draws the line of a limit.
    fn limit(&self, picture: &Picture<'_, '_, '_>, variant: usize, limit: Limit) -> Drawn<()> {
        let Some(refined) = self.refined else {
            return Ok(());
        };
        let at = |row: usize, value: f64| {
            if self.map.rows().ends().is_some() {
                return refined.limit_at(self.map, variant, limit, value);
            }
            let mut limits = refined.limits.iter();
            let boundary = limits.find(|it| (it.variant, it.limit) == (variant, limit))?;
            let mut points = boundary.points.iter();
            points.find(|it| it.row == row as u64)?.place.value()
        };
        for line in self.lines(at) {
            picture.edged_line(&line, limit_stroke(limit))?;
        }
        Ok(())
    }

    /// The lines, in the units of the figure, of a value that is known along the rows, by their number or their value; over rows with
    /// names a step for each.
    fn lines(&self, at: impl Fn(usize, f64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
        let [rows, columns] = self.axes();
        let Some([from, to]) = rows.axis.ends() else {
            let step = |row: usize| {
                let value = columns.of_si(at(row, 0.0)?);
                let row = row as f64;
                Some(vec![(row - 0.46, value), (row + 0.46, value)])
            };
            return (0..rows.axis.len() as usize).filter_map(step).collect();
        };
        let mut lines = vec![Vec::new()];
        for part in 0..=BOUNDARY_POINTS {
            let value = from + (to - from) * part as f64 / BOUNDARY_POINTS as f64;
            match (at(part, value), lines.last_mut()) {
                (Some(found), Some(line)) => line.push((rows.of_si(value), columns.of_si(found))),
                _ => lines.push(Vec::new()),
            }
        }
        lines
    }

    /// The bands of the boundaries of one variant, one panel for each class.
    fn bands(&self, refined: &RefinedMap, bands: &MapBands, variant: usize) -> Drawn<String> {
        let [rows, columns] = self.axes();
        let Some([from, to]) = rows.axis.ends() else {
            return page::draw(|_| Ok(()));
        };
        let names: Vec<_> = bands.varied.iter().map(|it| it.name()).collect();
        let key = format!("bands: changed one at a time: {}", names.join(", "));
        let subject = match self.map.variants() {
            [_] => self.subject.to_owned(),
            variants => format!("{}: {}", variants[variant].label, self.subject),
        };
        let legend = vec![(
            LegendKey::Line(Stroke::solid(BOUNDARY, 12)),
            "boundary of the map".to_owned(),
        )];
        let title = "Between which values each action begins";
        self.panels(
            title,
            [&subject, self.assumptions, &key],
            &legend,
            self.end_of_bands(bands, variant),
            |picture, action| {
                // The names of the marks do not hide a band.
                picture.mark(&[], &columns.marks())?;
                let values = (0..=BOUNDARY_POINTS)
                    .map(|part| from + (to - from) * part as f64 / BOUNDARY_POINTS as f64);
                let band = values.map(|value| {
                    let ends = bands.at(self.map, variant, action, value)?;
                    Some((rows.of_si(value), ends.map(|it| columns.of_si(it))))
                });
                let band: Vec<Option<(f64, [f64; 2])>> = band.collect();
                for part in band.split(Option::is_none) {
                    let part: Vec<_> = part.iter().copied().flatten().collect();
                    picture.between(&part, rgb(action))?;
                }
                let at = |_: usize, value: f64| refined.value_at(self.map, variant, action, value);
                for line in self.lines(at) {
                    picture.line(&line, Stroke::solid(BOUNDARY, 12))?;
                }
                Ok(())
            },
        )
    }

    /// The value on the axis of the columns above which there is no band; `None` where little would be gained by ending there.
    fn end_of_bands(&self, bands: &MapBands, variant: usize) -> Option<f64> {
        let [from, to] = self.map.columns().ends()?;
        let of_variant = bands.bands.iter().filter(|it| it.variant == variant);
        let ends = of_variant.flat_map(|it| &it.points).map(|it| it.high);
        let end = BEYOND * ends.fold(from, f64::max);
        (end > from && end - from < LEAST_CUT * (to - from)).then_some(end)
    }

    /// A panel for each class, with the same axes, up to a value on that of the columns where one is given.
    fn panels(
        &self,
        title: &str,
        lines: [&str; 3],
        legend: &[(LegendKey, String)],
        end: Option<f64>,
        draw: impl Fn(&Picture<'_, '_, '_>, Action) -> Drawn<()>,
    ) -> Drawn<String> {
        let [rows, columns] = self.axes();
        let (x, y) = (rows.plot_axis(6), columns.plot_axis_to(end, 5));
        page::draw(|page| {
            let top = page::heading(page, title, lines, legend)?;
            let (_, below) = page.split_vertically(top);
            let (upper, lower) = below.split_vertically((CANVAS.1 as i32 - top) / 2);
            let half = CANVAS.0 as i32 / 2 - 40;
            let ((a, b), (c, d)) = (
                upper.split_horizontally(half),
                lower.split_horizontally(half),
            );
            for (panel, action) in [a, b, c, d].iter().zip(ACTIONS) {
                let names = [rows.name(), columns.short_name()];
                let plot = axes(panel, &x, &y, [&names[0], &names[1]])?;
                let picture = Picture {
                    page,
                    plot: &plot,
                    x: &x,
                    y: &y,
                };
                draw(&picture, action)?;
                picture.name(action.name())?;
            }
            Ok(())
        })
    }

    /// The iso-lines of the residual displacement with their levels, the lowest first.
    fn levels(&self, variant: usize) -> Vec<Level> {
        let [rows, columns] = self.axes();
        let (Some(grid), Some(_), Some(_)) = (self.grid, rows.axis.ends(), columns.axis.ends())
        else {
            return Vec::new();
        };
        let residual = |row: usize, column: usize| {
            let cell = grid.cell(variant, row, column)?;
            cell.residual_v1.map(f64::abs)
        };
        let (height, width) = (grid.rows().len(), grid.columns().len());
        let all =
            (0..height).flat_map(|row| (0..width).filter_map(move |column| residual(row, column)));
        let largest = all.fold(0.0, f64::max);
        let place = |(row, column): (f64, f64)| {
            let between = |axis: &ShownAxis<'_>, places: &[u64], at: f64| {
                let low = (at.floor() as usize).min(places.len() - 2);
                let (from, to) = (axis.at(places[low]), axis.at(places[low + 1]));
                from + (at - low as f64) * (to - from)
            };
            (
                between(&rows, grid.rows(), row),
                between(&columns, grid.columns(), column),
            )
        };
        let mut levels = round_levels(largest);
        levels.reverse();
        let unit = Unit::length(0.1);
        levels
            .into_iter()
            .map(|level| {
                let mut lines = iso_lines(height, width, level, residual);
                // Next to a collapse, a line falls to pieces between cells that stand and others that do not.
                lines.retain(|line| line.len() > 5);
                let lines = lines
                    .into_iter()
                    .map(|line| line.into_iter().map(place).collect());
                (
                    format!("{} {}", unit.of(level), unit.symbol),
                    lines.collect(),
                )
            })
            .collect()
    }

    /// The boundaries of all variants, one panel for each class.
    fn comparison(&self) -> Drawn<String> {
        let [_, columns] = self.axes();
        let title = format!(
            "{} at which each action begins",
            match columns.axis.quantity() {
                MapQuantity::Velocity => "Critical velocity".to_owned(),
                quantity => format!("Value of {}", quantity.name()),
            }
        );
        let key = "one panel for each class; a line that ends leaves the range of the map";
        let stroke = |variant: usize| {
            let (colour, is_dashed) = COMPARED[variant % COMPARED.len()];
            match is_dashed {
                true => Stroke::dashed(colour, 14),
                false => Stroke::solid(colour, 14),
            }
        };
        let variants = self.map.variants();
        let legend: Vec<_> = variants
            .iter()
            .enumerate()
            .map(|(variant, it)| (LegendKey::Line(stroke(variant)), it.label.clone()))
            .collect();
        let lines = [self.subject, self.assumptions, key];
        self.panels(&title, lines, &legend, None, |picture, action| {
            for variant in 0..variants.len() {
                self.boundary(picture, variant, action, stroke(variant))?;
            }
            Ok(())
        })
    }
}

/// Round numbers up to the largest residual displacement \[m\], the largest first.
fn round_levels(largest: f64) -> Vec<f64> {
    let mut levels = Vec::new();
    // Upwards from 0.1 mm; a displacement of a column is far below 100 m.
    for decade in -4..2 {
        for mantissa in [1.0, 2.0, 5.0] {
            let level = mantissa * libm::pow(10.0, f64::from(decade));
            if level < 0.95 * largest {
                levels.push((level * 1e4).round() / 1e4);
            }
        }
    }
    levels.reverse();
    levels.truncate(MAX_LEVELS);
    levels
}

/// A name for a file, without characters that have a meaning there.
fn file_name(label: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    label
        .chars()
        .map(|c| if is_plain(c) { c } else { '_' })
        .take(80)
        .collect()
}
