//! A damage map in the viewer: an image of its classes with one pixel per cell, the boundaries, the axes and a legend.
//!
//! Every variant has views of its own. One unit of a view is one cell; the vertical axis of a view points down.

use std::fs;
use std::path::Path;

use rerun::{
    Color, Image, LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamBuilder,
    RecordingStreamResult, TextDocument,
};

use super::colour;
use super::error::ViewerError;
use super::file::{WRITE_TIMEOUT, unfinished};
use super::map_blueprint;
use super::rerun_types::color;
use crate::assessment::Action;
use crate::shape::{action_colour, round_number};
use crate::study::{ACTIONS, DamageMap, MapAxis, MapGrid, RefinedMap};

/// Name of this application in the viewer; the layout of the column does not apply to it.
const APPLICATION: &str = "column_twin_map";
/// Cells that were not computed.
const NOT_COMPUTED: [u8; 3] = [60, 60, 60];
/// Boundaries, on the colours of all classes.
const BOUNDARY: [u8; 3] = [20, 20, 20];
/// Points of a boundary.
const BOUNDARY_POINTS: u32 = 400;
/// Number of ticks of an axis, approximately.
const TICKS: f64 = 6.0;

/// Writes a file for the viewer, which gets its name when it is complete.
///
/// # Errors
/// The file cannot be written.
pub fn write_map_rrd(
    path: &Path,
    map: &DamageMap,
    grid: Option<&MapGrid>,
    refined: Option<&RefinedMap>,
) -> Result<(), ViewerError> {
    let unfinished = unfinished(path);
    let written = || -> Result<(), String> {
        let stream = RecordingStreamBuilder::new(APPLICATION)
            .enabled(true)
            .save(&unfinished)
            .map_err(|error| error.to_string())?;
        send(&stream, map, grid, refined).map_err(|error| error.to_string())?;
        stream
            .flush_with_timeout(WRITE_TIMEOUT)
            .map_err(|error| error.to_string())
    };
    // `written` drops the stream, which writes the footer of the file, before the file gets its name.
    let outcome =
        written().and_then(|()| fs::rename(&unfinished, path).map_err(|error| error.to_string()));
    if outcome.is_err() {
        let _ = fs::remove_file(&unfinished); // it may not exist
    }
    outcome.map_err(|reason| ViewerError::File {
        path: path.to_owned(),
        reason,
    })
}

fn send(
    stream: &RecordingStream,
    map: &DamageMap,
    grid: Option<&MapGrid>,
    refined: Option<&RefinedMap>,
) -> RecordingStreamResult<()> {
    for (variant, it) in map.variants().iter().enumerate() {
        // A label may contain what separates the parts of a path.
        let root = format!("map_{variant}");
        if let Some(grid) = grid {
            let image = Image::from_rgb24(
                pixels(grid, variant),
                [grid.rows().len() as u32, grid.columns().len() as u32],
            );
            stream.log_static(format!("{root}/classes"), &image)?;
        }
        let plane = Plane::of(map, grid);
        if let Some(refined) = refined {
            plane.boundaries(stream, &root, map, refined, variant)?;
        }
        plane.axes(stream, &root, map)?;
        let legend = legend(map, &it.label);
        stream.log_static(
            format!("legend_{variant}"),
            &TextDocument::from_markdown(legend),
        )?;
    }
    let labels: Vec<_> = map.variants().iter().map(|it| it.label.as_str()).collect();
    map_blueprint::send(stream, APPLICATION, &labels, Plane::of(map, grid).size)
}

/// The classes as red, green, blue, row by row of the picture, the highest value of the columns first.
fn pixels(grid: &MapGrid, variant: usize) -> Vec<u8> {
    let columns = (0..grid.columns().len()).rev();
    columns
        .flat_map(|column| {
            (0..grid.rows().len()).flat_map(move |row| {
                let cell = grid.cell(variant, row, column);
                cell.map_or(NOT_COMPUTED, |cell| action_colour(cell.action))
            })
        })
        .collect()
}

/// The plane of a view.
struct Plane {
    /// Width and height.
    size: [f64; 2],
}

impl Plane {
    fn of(map: &DamageMap, grid: Option<&MapGrid>) -> Self {
        let size = match grid {
            Some(grid) => [grid.rows().len() as f64, grid.columns().len() as f64],
            None => [map.rows().len() as f64, map.columns().len() as f64],
        };
        Self { size }
    }

    /// The place of a value on an axis, as a part of its extent; of a name, that of its number.
    fn part(axis: &MapAxis, value: f64) -> f64 {
        let [from, to] = axis.ends().unwrap_or([0.0, (axis.len() - 1) as f64]);
        (value - from) / (to - from)
    }

    /// The place of two values in the view; the first and the last ones are in the middle of a cell.
    fn place(&self, map: &DamageMap, row: f64, column: f64) -> [f32; 2] {
        let [width, height] = self.size;
        let x = 0.5 + Self::part(map.rows(), row) * (width - 1.0);
        let y = height - 0.5 - Self::part(map.columns(), column) * (height - 1.0);
        [x as f32, y as f32]
    }

    fn boundaries(
        &self,
        stream: &RecordingStream,
        root: &str,
        map: &DamageMap,
        refined: &RefinedMap,
        variant: usize,
    ) -> RecordingStreamResult<()> {
        let Some([from, to]) = map.rows().ends() else {
            return Ok(());
        };
        for action in ACTIONS {
            let places: Vec<_> = (0..=BOUNDARY_POINTS)
                .map(|point| {
                    let row = from + (to - from) * f64::from(point) / f64::from(BOUNDARY_POINTS);
                    let column = refined.value_at(map, variant, action, row)?;
                    Some(self.place(map, row, column))
                })
                .collect();
            let lines: Vec<Vec<[f32; 2]>> = places
                .split(Option::is_none)
                .map(|line| line.iter().flatten().copied().collect())
                .filter(|line: &Vec<_>| line.len() > 1)
                .collect();
            let colours = [Color::from_rgb(BOUNDARY[0], BOUNDARY[1], BOUNDARY[2])];
            let lines = LineStrips2D::new(lines)
                .with_colors(colours)
                .with_radii([Radius::new_ui_points(1.5)]);
            let entity = format!("{root}/boundary_{}", action.name());
            stream.log_static(entity, &lines)?;
        }
        Ok(())
    }

    /// Ticks with their numbers or names, on the left and below.
    fn axes(
        &self,
        stream: &RecordingStream,
        root: &str,
        map: &DamageMap,
    ) -> RecordingStreamResult<()> {
        let [width, height] = self.size.map(|it| it as f32);
        let tick = 0.012 * width.max(height);
        let low = |axis: &MapAxis| axis.ends().map_or(0.0, |ends| ends[0]);
        let mut lines = vec![vec![[0.0, 0.0], [0.0, height], [width, height]]];
        let mut texts = Vec::new();
        for (value, text) in ticks(map.rows()) {
            let [x, _] = self.place(map, value, low(map.columns()));
            lines.push(vec![[x, height], [x, height + tick]]);
            texts.push(([x, height + 2.5 * tick], text));
        }
        for (value, text) in ticks(map.columns()) {
            let [_, y] = self.place(map, low(map.rows()), value);
            lines.push(vec![[0.0, y], [-tick, y]]);
            texts.push(([-4.0 * tick, y], text));
        }
        let lines = LineStrips2D::new(lines)
            .with_colors([color(colour::AXIS)])
            .with_radii([Radius::new_ui_points(0.7)]);
        stream.log_static(format!("{root}/axes"), &lines)?;
        let texts = Points2D::new(texts.iter().map(|(place, _)| *place))
            .with_labels(texts.iter().map(|(_, text)| text.as_str()))
            .with_colors([color(colour::SURFACE)])
            .with_radii([Radius::new_ui_points(0.0)])
            .with_show_labels(true);
        stream.log_static(format!("{root}/numbers"), &texts)
    }
}

/// Round numbers of an axis with their units, or its names.
fn ticks(axis: &MapAxis) -> Vec<(f64, String)> {
    let Some([from, to]) = axis.ends() else {
        let names = (0..axis.len()).map(|index| (index as f64, axis.value(index).to_string()));
        return names.collect();
    };
    let step = round_number((to - from) / TICKS);
    let first = (from / step - 1e-6).ceil();
    let count = ((to - first * step) / step + 1e-6).floor().clamp(0.0, 20.0) as u32;
    let unit = axis.quantity().unit();
    (0..=count)
        .map(|tick| {
            let value = (first + f64::from(tick)) * step;
            let text = crate::parameters::readable((value * 1e9).round() / 1e9);
            (value, format!("{text} {unit}").trim_end().to_owned())
        })
        .collect()
}

/// The name of the colour of an action: Markdown in the viewer has no colours.
fn colour_name(action: Action) -> &'static str {
    match action {
        Action::None => "pale green",
        Action::Inspect => "light blue",
        Action::Restrict => "amber",
        Action::Shore => "orange",
        Action::Evacuate => "dark red",
    }
}

/// What the colours and the axes mean, as Markdown.
fn legend(map: &DamageMap, label: &str) -> String {
    let axis = |axis: &MapAxis| {
        let quantity = axis.quantity();
        match quantity.unit() {
            "" => quantity.title().to_owned(),
            unit => format!("{} [{unit}]", quantity.title()),
        }
    };
    let mut text = format!(
        "**{label}**: action over {} (across) and {} (upwards).\n\n",
        axis(map.rows()),
        axis(map.columns())
    );
    for action in [Action::None].into_iter().chain(ACTIONS) {
        text.push_str(&format!("- {}: {}\n", action.name(), colour_name(action)));
    }
    text.push_str("\nLines are the boundaries of the classes, to 1 %.\n");
    text
}
