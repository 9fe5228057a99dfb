//! The figures of one impact: the paper's Figures 5 to 8, the energy ledger, the contact force and the path of
//! every hinge in its yield surface, each as SVG and, made from that very SVG, as PNG.
//!
//! The font is embedded, so that a figure looks alike on every machine and needs nothing installed.

mod axis;
mod chart;
mod energy_ledger;
mod histories;
mod page;
mod raster;
mod thinning;
pub mod units;
mod yield_path;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::column::{HINGE_NAMES, HINGES, Outcome, Report, Sample, YieldExponents};
use crate::whole_file;

pub use thinning::Thinning;
use units::Unit;

/// What the figures are drawn from.
#[derive(Debug, Clone, Copy)]
pub struct Response<'a> {
    /// One line that says which column was hit by what.
    pub title: &'a str,
    /// The history, in the order of time.
    pub samples: &'a [Sample],
    /// Its outcome.
    pub report: &'a Report,
    /// Shape of the hinges' yield surface.
    pub yield_surface: YieldExponents,
    /// `M^p` \[N m\].
    pub resistance_moment: f64,
    /// `N^p` \[N\].
    pub resistance_axial: f64,
}

/// Why there are no figures.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FigureError {
    /// The history has no sample.
    #[error("the response has no samples, so there is nothing to draw")]
    #[diagnostic(help("draw a response of at least one sample"))]
    NoSamples,
    /// The folder cannot be made.
    #[error("cannot make the folder {} for the figures: {reason}", folder.display())]
    #[diagnostic(help("name a folder that can be written to"))]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write the figure {}: {reason}", path.display())]
    #[diagnostic(help("name a folder that can be written to and has room for about 2 MB"))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// A fault of this program or its plotting library.
    #[error("cannot draw the figure {figure}: {reason}")]
    #[diagnostic(help("this is a fault of column_twin: please report it with the command line"))]
    Draw {
        /// Name of the figure.
        figure: String,
        /// What the library says.
        reason: String,
    },
}

/// Draws every figure into `folder`, which is made if it is missing; the files written, SVG and PNG in turn.
///
/// A figure appears under its name when it is complete. Histories of any length are thinned to what can be seen.
///
/// # Errors
/// See [`FigureError`].
pub fn draw_all(folder: &Path, response: &Response<'_>) -> Result<Vec<PathBuf>, FigureError> {
    let drawings = svg_figures(response)?;
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

/// Every figure as SVG, by its name.
fn svg_figures(response: &Response<'_>) -> Result<Vec<(String, String)>, FigureError> {
    if response.samples.is_empty() {
        return Err(FigureError::NoSamples);
    }
    let thinned = thinned(response.samples);
    let response = &Response {
        samples: &thinned,
        ..*response
    };
    let mut figures = vec![
        (
            "fig5_horizontal_displacement".to_owned(),
            histories::horizontal_displacement(response),
        ),
        (
            "fig6_vertical_displacement".to_owned(),
            histories::vertical_displacement(response),
        ),
        (
            "fig7_normal_forces".to_owned(),
            histories::normal_forces(response),
        ),
        (
            "fig8_bending_moments".to_owned(),
            histories::bending_moments(response),
        ),
        (
            "contact_force".to_owned(),
            histories::contact_force(response),
        ),
        (
            "energy_ledger".to_owned(),
            energy_ledger::energy_ledger(response),
        ),
    ];
    for (hinge, name) in HINGE_NAMES.iter().enumerate() {
        let name = format!("mn_path_{name}");
        figures.push((name, yield_path::yield_path(response, hinge)));
    }
    figures
        .into_iter()
        .map(|(figure, svg)| match svg {
            Ok(svg) => Ok((figure, svg)),
            Err(fault) => Err(FigureError::Draw {
                figure,
                reason: fault.to_string(),
            }),
        })
        .collect()
}

fn thinned(samples: &[Sample]) -> Vec<Sample> {
    let duration = samples
        .last()
        .map_or(0.0, |last| last.time - samples[0].time);
    let mut thinning = Thinning::new(samples.len() as u64, duration);
    samples.iter().for_each(|sample| thinning.push(sample));
    thinning.finish()
}

impl Response<'_> {
    /// First and last time of the history \[s\].
    fn span(&self) -> (f64, f64) {
        let time = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time);
        (time(self.samples.first()), time(self.samples.last()))
    }

    /// A quantity over time.
    fn over_time(&self, quantity: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
        self.samples
            .iter()
            .map(|sample| (sample.time, quantity(sample)))
            .collect()
    }

    /// Largest magnitude of some quantities.
    fn largest<const N: usize>(&self, quantities: impl Fn(&Sample) -> [f64; N]) -> f64 {
        self.samples
            .iter()
            .flat_map(|sample| quantities(sample).map(f64::abs))
            .filter(|value| value.is_finite())
            .fold(0.0, f64::max)
    }

    /// First touch, last parting and collapse.
    fn events(&self) -> Vec<(f64, &'static str)> {
        let report = self.report;
        let collapse = (report.outcome == Outcome::Collapsed).then_some(report.end_time);
        [
            (report.first_contact_time, "contact"),
            (report.release_time, "release"),
            (collapse, "collapse"),
        ]
        .into_iter()
        .filter_map(|(time, name)| Some((time?, name)))
        .collect()
    }

    /// How the response ended, in a few words.
    fn outcome(&self) -> &'static str {
        match self.report.outcome {
            Outcome::Elastic => "stays elastic",
            Outcome::Plastic => "deforms plastically and stands",
            Outcome::Collapsed => "collapses",
        }
    }

    fn time_unit(&self) -> Unit {
        let (from, to) = self.span();
        Unit::time(from.abs().max(to.abs()))
    }
}

/// Where each hinge is, in the order of [`HINGE_NAMES`].
pub(crate) const HINGE_PLACES: [&str; HINGES] =
    ["below the impact", "above the impact", "top", "base"];

#[cfg(test)]
pub(crate) mod reference;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod validation;
