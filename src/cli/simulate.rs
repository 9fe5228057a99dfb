//! `column-twin simulate`: one impact, and what it does to the column.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
#[cfg(feature = "viewer")]
use std::sync::Arc;
use std::time::Instant;
#[cfg(feature = "viewer")]
use std::time::SystemTime;

use clap::Args;

use super::{Exit, Failure, HistoryWriter, Summary, unless_closed};
use crate::column::{
    ColumnProperties, Impact, Report, Sample, SimulationError, respond, simulate,
};
#[cfg(feature = "record")]
use crate::evidence::SimulatedRecordingError;
use crate::figures::units::significant;
use crate::figures::{self, FigureError, Thinning};
use crate::parameters::{Parameters, parse_override};
#[cfg(feature = "record")]
use crate::recording::RecordingError;
#[cfg(feature = "viewer")]
use crate::viewer::{self, ViewerError};
use crate::whole_file::WholeFile;

/// What `column-twin simulate` is told.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct SimulateArgs {
    /// Parameter file (ROS 2 YAML); several are read in turn, none gives the default column
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
    /// Mass of the impactor [kg]; default: impact.mass
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Speed of the impactor over the ground [m/s]; default: impact.velocity
    #[arg(long, value_name = "M/S")]
    velocity: Option<f64>,
    /// Distance of the impactor from the column at the start [m]; default: impact.gap
    #[arg(long, value_name = "M")]
    gap: Option<f64>,
    /// Coefficient of restitution [-], 0 to 1; default: impact.restitution
    #[arg(long, value_name = "E")]
    restitution: Option<f64>,
    /// Height of the impact point above the base [m]; default: geometry.length_below
    #[arg(long, value_name = "M")]
    height: Option<f64>,
    /// Any parameter, as ROS 2 writes it: -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// Print the summary as JSON (SI units) and nothing else
    #[arg(long)]
    json: bool,
    /// Write the history, one row per step, as CSV; - is the standard output, the summary then goes to the standard
    /// error
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the figures as SVG and PNG into this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Record what a node would publish into this new folder, as an MCAP recording that ROS tools read
    #[cfg(feature = "record")]
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Instant of the event in the recording [s since 1970]
    #[cfg(feature = "record")]
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "record")]
    record_stamp: f64,
    /// Write what the Rerun viewer shows into this file: the deforming column, its curves and yield surfaces
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE")]
    rrd: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example: what a car of 1.5 t at 36 km/h does to the paper's column, with figures
  column-twin simulate --config config/heb220_paper.yaml --mass 1500 --velocity 10 --plots plots
Example: the same as a recording, and the proof of it
  column-twin simulate --mass 1500 --velocity 10 --record impact && column-twin verify impact

Exit codes: 0 done (a collapse is a result), 1 failed, 2 bad input or usage.";

/// Why there is no result.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum SimulateError {
    #[error(
        "--height {height}: the impact point must lie on the column, whose height is {total} m"
    )]
    #[diagnostic(help("give a height above 0 m and below {total} m"))]
    Height { height: f64, total: f64 },
    #[error("--json and --csv - both ask for the standard output")]
    #[diagnostic(help("write the history to a file: --csv FILE"))]
    OneOutput,
    #[error("the impact cannot be simulated: {0}")]
    #[diagnostic(help("check the column's and the impact's parameters"))]
    Simulation(#[from] SimulationError),
    #[error("cannot write the history to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in a folder that exists and can be written to"))]
    History { path: PathBuf, reason: io::Error },
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
    #[cfg(feature = "record")]
    #[error("the impact cannot be recorded: {0}")]
    Recording(SimulatedRecordingError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figures(#[from] FigureError),
    #[cfg(feature = "viewer")]
    #[error(transparent)]
    #[diagnostic(transparent)]
    Viewer(#[from] ViewerError),
}

impl From<SimulateError> for Failure {
    fn from(fault: SimulateError) -> Self {
        let exit = match &fault {
            SimulateError::Height { .. } | SimulateError::OneOutput => Exit::BadInput,
            SimulateError::Simulation(SimulationError::Model(_) | SimulationError::Impact(_)) => {
                Exit::BadInput
            }
            #[cfg(feature = "record")]
            SimulateError::Recording(
                SimulatedRecordingError::Origin(_)
                | SimulatedRecordingError::Recording(RecordingError::Exists { .. }),
            ) => Exit::BadInput,
            _ => Exit::Failed,
        };
        Self::new(exit, fault)
    }
}

/// An impact on a column, ready to be simulated.
struct Case {
    title: String,
    #[cfg(any(feature = "record", feature = "viewer"))]
    parameters: Parameters,
    properties: ColumnProperties,
    impact: Impact,
    /// Longest response \[s\].
    max_duration: f64,
}

/// Simulates the impact and writes what was asked for; the summary, or the history, goes to `output`.
pub(super) fn run(arguments: &SimulateArgs, output: &mut dyn Write) -> Result<(), Failure> {
    let history_to_output = arguments.csv.as_deref() == Some(Path::new("-"));
    if arguments.json && history_to_output {
        return Err(SimulateError::OneOutput.into());
    }
    let case = Case::from_arguments(arguments)?;
    // The first run is timed and observed by nobody; the histories come from a second, equal bit for bit. Its
    // length is known by then, so that even the longest history fits into a bounded memory.
    let start = Instant::now();
    let report = respond(&case.properties, &case.impact, case.max_duration)
        .map_err(SimulateError::from)?;
    let solve_time = start.elapsed();

    if let Some(path) = &arguments.csv {
        if history_to_output {
            unless_closed(case.write_history(&mut *output).map(drop))
                .map_err(SimulateError::Output)?;
        } else {
            case.write_history_file(path)?;
        }
    }
    #[cfg(feature = "record")]
    let recorded = case.record(arguments)?;
    #[cfg(not(feature = "record"))]
    let recorded: Option<PathBuf> = None;
    let files = match &arguments.plots {
        Some(folder) => case.draw(&report, folder)?,
        None => Vec::new(),
    };
    #[cfg(feature = "viewer")]
    if let Some(path) = &arguments.rrd {
        case.write_rrd(&report, path)?;
    }
    let summary = Summary {
        title: &case.title,
        report: &report,
        solve_time,
    };
    #[cfg(feature = "viewer")]
    let film = arguments.rrd.as_deref();
    #[cfg(not(feature = "viewer"))]
    let film = None;
    let text = if arguments.json {
        summary
            .json()
            .map_err(|fault| SimulateError::Output(fault.into()))?
            + "\n"
    } else {
        listing(
            &summary,
            arguments.csv.as_deref().filter(|_| !history_to_output),
            recorded.as_deref(),
            film,
            &files,
        )
    };
    if history_to_output {
        eprint!("{text}");
        return Ok(());
    }
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    Ok(unless_closed(written).map_err(SimulateError::Output)?)
}

/// The summary and the files written.
fn listing(
    summary: &Summary<'_>,
    history: Option<&Path>,
    recording: Option<&Path>,
    film: Option<&Path>,
    figures: &[PathBuf],
) -> String {
    let mut text = summary.to_string();
    if let Some(path) = history {
        text += &format!("History    {}\n", path.display());
    }
    if let Some(path) = recording {
        text += &format!("Recording  {}\n", path.display());
    }
    if let Some(folder) = figures.first().and_then(|first| first.parent()) {
        text += &format!(
            "Figures    {} files in {}\n",
            figures.len(),
            folder.display()
        );
    }
    if let Some(path) = film {
        text += &format!("Viewer     rerun {}\n", path.display());
    }
    text
}

impl Case {
    /// Reads the parameters, with what the options say in place of them.
    fn from_arguments(arguments: &SimulateArgs) -> Result<Self, Failure> {
        let mut overrides = arguments.parameter.clone();
        let options = [
            ("impact.mass", arguments.mass),
            ("impact.velocity", arguments.velocity),
            ("impact.gap", arguments.gap),
            ("impact.restitution", arguments.restitution),
        ];
        for (name, value) in options {
            // An option is an override, so that the one table of parameters judges it.
            overrides.extend(value.map(|value| format!("{name}:={}", yaml(value))));
        }
        let mut parameters = load(&arguments.config, &overrides)?;
        if let Some(height) = arguments.height {
            let column = parameters.column_properties();
            let total = column.length_below + column.length_above;
            if !(height > 0.0 && height < total) {
                return Err(SimulateError::Height { height, total }.into());
            }
            overrides.push(format!("geometry.length_below:={}", yaml(height)));
            overrides.push(format!("geometry.length_above:={}", yaml(total - height)));
            parameters = load(&arguments.config, &overrides)?;
        }
        let properties = parameters.column_properties();
        let impact = parameters.impact();
        let title = format!(
            "{}: {} kg at {} m/s ({} km/h), {} m above the base",
            column_name(&parameters),
            short(impact.mass),
            short(impact.velocity),
            short(3.6 * impact.velocity),
            short(properties.length_below),
        );
        let max_duration = parameters.response_duration();
        Ok(Self {
            title,
            #[cfg(any(feature = "record", feature = "viewer"))]
            parameters,
            properties,
            impact,
            max_duration,
        })
    }

    fn simulate(&self, observe: &mut dyn FnMut(&Sample)) -> Result<Report, SimulateError> {
        Ok(simulate(
            &self.properties,
            &self.impact,
            self.max_duration,
            observe,
        )?)
    }

    fn write_history_file(&self, path: &Path) -> Result<(), SimulateError> {
        let fault = |reason| SimulateError::History {
            path: path.to_path_buf(),
            reason,
        };
        let file = WholeFile::create(path).map_err(fault)?;
        self.write_history(file)
            .and_then(WholeFile::commit)
            .map_err(fault)
    }

    /// Writes the history; the target, or the first fault in writing to it.
    fn write_history<W: Write>(&self, target: W) -> io::Result<W> {
        let mut writer = HistoryWriter::new(target)?;
        let mut fault = None;
        let simulated = self.simulate(&mut |sample| {
            if fault.is_none() {
                fault = writer.write(sample).err();
            }
        });
        match (fault, simulated) {
            (Some(fault), _) => Err(fault.into()),
            (None, Err(fault)) => Err(io::Error::other(fault)),
            (None, Ok(_)) => writer.finish(),
        }
    }

    /// The recording, if one is asked for.
    #[cfg(feature = "record")]
    fn record(&self, arguments: &SimulateArgs) -> Result<Option<PathBuf>, SimulateError> {
        let Some(directory) = &arguments.record else {
            return Ok(None);
        };
        let options = crate::recording::WriterOptions {
            compression: self.parameters.settings().record.compression,
            ..crate::recording::WriterOptions::default()
        };
        // `as` saturates, and what is no instant is refused.
        let origin = (arguments.record_stamp * 1e9).round() as i64;
        crate::evidence::record_impact(&self.parameters, origin, directory, &options)
            .map_err(SimulateError::Recording)?;
        Ok(Some(directory.clone()))
    }

    /// A file for the viewer; it dates the impact now.
    #[cfg(feature = "viewer")]
    fn write_rrd(&self, report: &Report, path: &Path) -> Result<(), SimulateError> {
        let mut thinning = Thinning::new(report.steps, report.end_time);
        self.simulate(&mut |sample| thinning.push(sample))?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let now = now.map_or(0, |now| i64::try_from(now.as_nanos()).unwrap_or(0));
        let items = viewer::from_samples("simulated", now, thinning.finish(), report);
        Ok(viewer::write_rrd(
            path,
            &Arc::new(self.parameters.clone()),
            items,
            false,
        )?)
    }

    fn draw(&self, report: &Report, folder: &Path) -> Result<Vec<PathBuf>, SimulateError> {
        let mut thinning = Thinning::new(report.steps, report.end_time);
        self.simulate(&mut |sample| thinning.push(sample))?;
        let samples = thinning.finish();
        let response = figures::Response {
            title: &self.title,
            samples: &samples,
            report,
            yield_surface: self.properties.yield_surface,
            resistance_moment: self.properties.resistance_moment,
            resistance_axial: self.properties.resistance_axial,
        };
        Ok(figures::draw_all(folder, &response)?)
    }
}

/// A number of a title: four significant digits, no zeros behind them.
fn short(value: f64) -> String {
    let text = significant(value, 4);
    text.parse::<f64>()
        .map_or(text, |rounded| rounded.to_string())
}

/// A number as YAML writes it, always with a point.
fn yaml(value: f64) -> String {
    match value {
        value if value.is_nan() => ".nan".into(),
        f64::INFINITY => ".inf".into(),
        f64::NEG_INFINITY => "-.inf".into(),
        value => {
            let text = format!("{value:?}");
            // Rust writes 1e-7, which YAML 1.1 takes for text.
            match text.split_once('e') {
                Some((digits, power)) if !digits.contains('.') => format!("{digits}.0e{power}"),
                _ => text,
            }
        }
    }
}

/// The parameters of the files with the overrides.
fn load(files: &[PathBuf], overrides: &[String]) -> Result<Parameters, Failure> {
    let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
    Parameters::load(files, &overrides).map_err(|faults| Failure {
        exit: Exit::BadInput,
        report: faults.report(),
    })
}

/// The section if it is named, otherwise the column's identity.
fn column_name(parameters: &Parameters) -> &str {
    parameters
        .section()
        .name
        .unwrap_or(&parameters.settings().column_id)
}
