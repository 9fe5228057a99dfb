//! The figures of one impact: the paper's Figures 5 to 8, the shape of the column, the energy ledger, the contact force and its
//! equivalent static force, the crush of the vehicle, the path of every hinge in its yield surface, and the same hit by the fibre beam,
//! each as SVG and, rendered from the same SVG, as PNG.
//!
//! The figures of a damage map are drawn in the same way.
//! [`draw_risk`] draws the figures of a risk study, [`draw_estimate`] those of an estimate from the readings of sensors.
//!
//! The font is embedded, so that a figure looks the same on every machine.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - axis.rs: Axes of plots: a range and round numbers marked on it
// - beam_beside.rs: The two bars and the fibre beam beside one another: their shapes to one scale, and their displacements over
//   time
// - chart.rs: Plots on a page: the axes of a plot, and the chart of quantities against time
// - damage_map.rs: The figures of a damage map: the classes over its plane, and the boundaries of several columns in comparison
// - deformed_shape.rs: The shape of the column before the impact, at its peak displacement and at rest
// - energy_ledger.rs: The energy ledger as a stack over time
// - estimate.rs: The figures of an estimate: the forecast as the data improve it, and for each sensor what it has read against
//   what is predicted
// - force_crush.rs: The force of each spring of a deformable vehicle over its crush, with the envelope of the force
// - force_spectrum.rs: The equivalent static force of a contact over the period of what it pushes
// - histories.rs: Displacements, forces and moments over time: the paper's Figures 5 to 8, and the contact force
// - iso_lines.rs: Lines of equal value in a field on a grid, by marching squares
// - map_areas.rs: The areas of the classes of a damage map
// - map_axis.rs: An axis of a damage map as its figures show it
// - map_marks.rs: Marks of a damage map: speed limits and vehicles of the catalogue, where an axis has them
// - map_picture.rs: The plot of a damage map on its page: areas, lines with labels, marks and the frame
// - measures.rs: The figure that compares the measures of a risk study
// - page.rs: The page of every figure: canvas, font, colours, heading and legend
// - path_chart.rs: The chart of one quantity over another that is not time: paths, envelopes and shapes
// - probability_rows.rs: What figures with probabilities in rows share: a scale of powers of ten, names of the rows, colours
// - push_down.rs: The push-down curves: axial force over shortening, undamaged and now
// - raster.rs: Renders SVG as PNG
// - reference.rs: The reference responses as samples, for the tests of figures and summary
// - response_history.rs: The history of a response, from which the figures are drawn
// - risk.rs: The figures of a risk study: fragility curves, probabilities in the period, sensitivities
// - thinning.rs: Thins long histories to what the pixels of a figure can show, without losing an extreme value
// - units.rs: Units for numbers that people read
// - validation/: `docs/validation.md` and its figures: both schemes compared with the reference responses
// - yield_path.rs: The path of a hinge's moment and normal force in its yield surface

mod axis;
mod beam_beside;
mod chart;
mod damage_map;
mod deformed_shape;
mod energy_ledger;
mod estimate;
mod force_crush;
mod force_spectrum;
mod histories;
mod iso_lines;
mod map_areas;
mod map_axis;
mod map_marks;
mod map_picture;
mod measures;
mod page;
mod path_chart;
mod probability_rows;
mod push_down;
mod raster;
mod response_history;
mod risk;
mod thinning;
pub mod units;
mod yield_path;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::column::HINGE_NAMES;
use crate::whole_file;

pub use damage_map::MapFigures;
pub use estimate::{
    EstimateFigures, TimedEstimate, comparison_svg, draw_estimate, estimate_svg, forecast_svg,
};
pub use push_down::{PushDownCurves, push_down_svg};
pub use response_history::ResponseHistory;
pub use risk::{draw_risk, risk_svg};
pub use thinning::HistoryThinning;

/// Why the figures cannot be drawn.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FigureError {
    /// The history has no sample.
    #[error("the response has no samples to draw")]
    #[diagnostic(help("draw a response of at least one sample"))]
    NoSamples,
    /// The folder cannot be created.
    #[error("cannot create the folder {} for the figures: {reason}", folder.display())]
    #[diagnostic(help("name a writable folder"))]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write the figure {}: {reason}", path.display())]
    #[diagnostic(help("name a writable folder with about 2 MB of free space"))]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// An error of this program or its plotting library.
    #[error("cannot draw the figure {figure}: {reason}")]
    #[diagnostic(help("this is a bug in column_twin: please report it with the command line"))]
    Draw {
        /// Name of the figure.
        figure: String,
        /// Error of the library.
        reason: String,
    },
}

/// Draws every figure into `folder`, which is created if it does not exist, and returns the files written: SVG and PNG
/// alternately.
///
/// A file gets its name when it is complete. A [`HistoryThinning`] bounds the memory that a long history takes.
///
/// # Errors
/// See [`FigureError`].
pub fn draw_all(
    folder: &Path,
    response: &ResponseHistory<'_>,
) -> Result<Vec<PathBuf>, FigureError> {
    write_all(folder, draw_svg(response)?)
}

/// Draws the figures of a damage map into `folder`, which is created if it does not exist, and returns the files written: SVG and
/// PNG alternately.
///
/// # Errors
/// See [`FigureError`].
pub fn draw_map(folder: &Path, map: &MapFigures<'_>) -> Result<Vec<PathBuf>, FigureError> {
    let figures = map.draw().into_iter();
    let figures: Result<Vec<_>, _> = figures
        .map(|(name, svg)| drawn(&name, svg).map(|svg| (name, svg)))
        .collect();
    write_all(folder, figures?)
}

/// Writes figures as SVG and as PNG.
fn write_all(folder: &Path, drawings: Vec<(String, String)>) -> Result<Vec<PathBuf>, FigureError> {
    fs::create_dir_all(folder).map_err(|reason| FigureError::Folder {
        folder: folder.to_path_buf(),
        reason,
    })?;
    let raster = raster::Raster::new();
    let mut files = Vec::new();
    for (name, svg) in drawings {
        let png = raster.png(&svg).map_err(|reason| FigureError::Draw {
            figure: name.clone(),
            reason,
        })?;
        for (ending, content) in [("svg", svg.as_bytes()), ("png", &png)] {
            let path = folder.join(format!("{name}.{ending}"));
            whole_file::write(&path, content).map_err(|reason| FigureError::Write {
                path: path.clone(),
                reason,
            })?;
            files.push(path);
        }
    }
    Ok(files)
}

type Draw<T> = fn(&ResponseHistory<'_>) -> T;

/// The figures of every response.
const FIGURES: [(&str, Draw<page::Drawn<String>>); 7] = [
    (
        "fig5_horizontal_displacement",
        histories::horizontal_displacement,
    ),
    (
        "fig6_vertical_displacement",
        histories::vertical_displacement,
    ),
    ("fig7_normal_forces", histories::normal_forces),
    ("fig8_bending_moments", histories::bending_moments),
    ("contact_force", histories::contact_force),
    ("energy_ledger", energy_ledger::energy_ledger),
    ("deformed_shape", deformed_shape::deformed_shape),
];

/// The figures of some responses.
const FIGURES_OF_SOME: [(&str, Draw<Option<page::Drawn<String>>>); 2] = [
    ("contact_force_spectrum", force_spectrum::force_spectrum),
    ("force_crush", force_crush::force_crush),
];

/// Every figure as SVG, by its name. There is no figure `force_crush` of a rigid vehicle, and no figure `contact_force_spectrum`
/// where nothing has touched the column or [`ResponseHistory::spectrum`] is `None`. The figures of the fibre beam are drawn where
/// [`ResponseHistory::beam`] is known.
///
/// # Errors
/// The history has no sample, or the plotting library fails.
pub fn draw_svg(response: &ResponseHistory<'_>) -> Result<Vec<(String, String)>, FigureError> {
    if response.samples.is_empty() {
        return Err(FigureError::NoSamples);
    }
    let mut figures: Vec<_> = FIGURES
        .map(|(name, draw)| (name.to_owned(), draw(response)))
        .into();
    for (name, draw) in FIGURES_OF_SOME {
        figures.extend(draw(response).map(|svg| (name.to_owned(), svg)));
    }
    if let Some(beam) = response.beam {
        figures.extend([
            (
                "second_opinion_shape".to_owned(),
                beam_beside::shapes(response, beam),
            ),
            (
                "second_opinion_displacement".to_owned(),
                beam_beside::displacements(response, beam),
            ),
        ]);
    }
    for (hinge, name) in HINGE_NAMES.iter().enumerate() {
        let name = format!("mn_path_{name}");
        figures.push((name, yield_path::yield_path(response, hinge)));
    }
    figures
        .into_iter()
        .map(|(figure, svg)| drawn(&figure, svg).map(|svg| (figure, svg)))
        .collect()
}

/// What was drawn, or the error of the library.
fn drawn(figure: &str, svg: page::Drawn<String>) -> Result<String, FigureError> {
    svg.map_err(|fault| FigureError::Draw {
        figure: figure.to_owned(),
        reason: fault.to_string(),
    })
}

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod validation;
