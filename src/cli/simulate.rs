//! `column-twin simulate`: the response of the column to one impact.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
#[cfg(feature = "viewer")]
use std::sync::Arc;
use std::time::Instant;
#[cfg(feature = "viewer")]
use std::time::SystemTime;

use clap::Args;

use super::failure::{Exit, Failure, unless_closed};
use super::history::HistoryWriter;
use super::impact_args::{ImpactSpecificationArgs, yaml};
use super::summary::Summary;
use column_twin::assessment::{ImpactEvaluation, respond_and_rest};
use column_twin::column::{
    ColumnProperties, ForceSpectrum, Impact, Report, Sample, SimulationError, simulate,
};
use column_twin::estimation::simulate_sensors;
#[cfg(feature = "record")]
use column_twin::evidence::SimulatedRecordingError;
#[cfg(feature = "viewer")]
use column_twin::figures::HistoryThinning;
use column_twin::figures::{self, FigureError};
#[cfg(feature = "viewer")]
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::parameters::{
    Fault, NodeName, ParameterFaults, Parameters, Source, parse_override,
};
#[cfg(feature = "record")]
use column_twin::recording::{RecordingError, SealKey, WriterOptions};
use column_twin::report::{
    Origin, ReportDetails, ReportDetailsError, ReportDocument, ReportedImpact, parameters_path,
    title,
};
use column_twin::results::Travel;
#[cfg(feature = "viewer")]
use column_twin::second_opinion::BeamTask;
use column_twin::second_opinion::SecondOpinion;
#[cfg(feature = "viewer")]
use column_twin::viewer::{self, ViewerError, ViewerItem};
use column_twin::whole_file::{self, WholeFile};

/// Arguments of `column-twin simulate`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct SimulateArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win; default: the built-in column
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
    #[command(flatten)]
    impact: ImpactSpecificationArgs,
    /// Any parameter in the notation of ROS 2, for example -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// Print the summary as JSON (SI units), and nothing else
    #[arg(long)]
    json: bool,
    /// Write the history as CSV, one row per step; with -, the history goes to the standard output and the summary to
    /// the standard error
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the readings of the sensors of sensors.names, with their errors, as CSV; docs/estimation.md describes them
    #[arg(long, value_name = "FILE")]
    readings: Option<PathBuf>,
    /// Seed of the errors of the sensors; the same seed gives the same readings
    #[arg(long, value_name = "N", default_value_t = 1, requires = "readings")]
    sensor_seed: u64,
    /// Draw the figures into this folder, as SVG and PNG
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// Write an HTML report: the verdict on four pages of A4, and an annex; all parameters go to a JSON file next to it
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// File with project, site, author and other details for the title block of the report
    #[arg(long, value_name = "FILE", requires = "report")]
    report_details: Option<PathBuf>,
    /// Record the messages that a node would publish, in this new folder, as an MCAP recording that ROS tools can read
    #[cfg(feature = "record")]
    #[arg(long, value_name = "FOLDER")]
    record: Option<PathBuf>,
    /// Time of the event in the recording [s since 1970]
    #[cfg(feature = "record")]
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "record", value_parser = stamp)]
    record_stamp: f64,
    /// Write a file for the Rerun viewer: the deforming column, its curves and its yield surfaces
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE")]
    rrd: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Without an option, the parameter of its name applies: vehicle.name, impact.mass, impact.velocity.

Example: the paper's rigid mass of 1.5 t hits the paper's column at 36 km/h; with figures
  column-twin simulate --config config/heb220_paper.yaml --mass 1500 --velocity 10 --figures figures
Example: a real car hits a real column at the same speed
  column-twin simulate --config config/heb220_s355.yaml --vehicle mid_car --velocity 10
Example: record an impact, and verify the recording by recomputation
  column-twin simulate --mass 1500 --velocity 10 --record impact && column-twin verify impact

Exit codes: 0 done (a collapse is a result), 1 failed, 2 bad input or usage.";

/// Why the simulation failed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum SimulateError {
    #[error("--height {height}: the impact point must be on the column, which is {total} m high")]
    #[diagnostic(help("give a height greater than 0 m and less than {total} m"))]
    Height { height: f64, total: f64 },
    #[error("--json and --csv - cannot both write to the standard output")]
    #[diagnostic(help("write the history to a file: --csv FILE"))]
    OneOutput,
    #[error("the impact cannot be simulated: {0}")]
    #[diagnostic(help("check the parameters of the column and of the impact"))]
    Simulation(#[from] SimulationError),
    #[error("cannot write the history to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    History { path: PathBuf, reason: io::Error },
    #[error("there are no sensors whose readings could be written")]
    #[diagnostic(help(
        "declare them in a parameter file: config/sensors_industrial.yaml is an example"
    ))]
    NoSensors,
    #[error("cannot write the readings to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    Readings { path: PathBuf, reason: io::Error },
    #[error("cannot write the report to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    Report { path: PathBuf, reason: io::Error },
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
    #[cfg(feature = "record")]
    #[error("the impact cannot be recorded: {0}")]
    Recording(SimulatedRecordingError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Details(#[from] ReportDetailsError),
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
            SimulateError::Height { .. }
            | SimulateError::OneOutput
            | SimulateError::NoSensors
            | SimulateError::Details(_) => Exit::BadInput,
            SimulateError::Simulation(SimulationError::Model(_) | SimulationError::Impact(_)) => {
                Exit::BadInput
            }
            #[cfg(feature = "record")]
            SimulateError::Recording(
                SimulatedRecordingError::Origin(_)
                | SimulatedRecordingError::Recording(
                    RecordingError::Exists { .. } | RecordingError::BadKey { .. },
                ),
            ) => Exit::BadInput,
            _ => Exit::Failed,
        };
        Self::new(exit, fault)
    }
}

/// An impact on a column.
struct Case {
    title: String,
    parameters: Parameters,
    properties: ColumnProperties,
    impact: Impact,
    /// Maximum duration of the response \[s\].
    max_duration: f64,
}

/// Simulates the impact and writes the requested files; the summary or the history goes to `output`.
pub(super) fn run(arguments: &SimulateArgs, output: &mut dyn Write) -> Result<(), Failure> {
    let history_to_output = arguments.csv.as_deref().is_some_and(is_standard_output);
    if arguments.json && history_to_output {
        return Err(SimulateError::OneOutput.into());
    }
    let case = Case::from_arguments(arguments)?;
    let details = match &arguments.report_details {
        Some(path) => ReportDetails::read(path).map_err(SimulateError::from)?,
        None => ReportDetails::default(),
    };
    // The first run is timed and writes nothing; histories come from further runs, which are equal bit for bit. Their length
    // is known by then, so that a history of any length fits in a bounded memory.
    let start = Instant::now();
    let ended = respond_and_rest(&case.properties, &case.impact, case.max_duration)
        .map_err(SimulateError::from)?;
    let solve_time = start.elapsed();
    let mut evaluation =
        ImpactEvaluation::complete(&case.parameters, &case.properties, &case.impact, ended)
            .map_err(SimulateError::from)?;
    let start = Instant::now();
    let opinion = SecondOpinion::beside(&case.parameters, &evaluation.report, evaluation.remaining);
    let second_opinion_time = start.elapsed();
    let second_opinion =
        opinion.map(|opinion| opinion.taken_into(&case.parameters, &mut evaluation));

    let mut files = String::new();
    if history_to_output {
        unless_closed(case.write_history(&mut *output).map(drop)).map_err(SimulateError::Output)?;
    } else if let Some(path) = &arguments.csv {
        case.write_history_file(path)?;
        files += &format!("History    {}\n", path.display());
    }
    if let Some(path) = &arguments.readings {
        case.write_readings(path, arguments.sensor_seed)?;
        files += &format!("Readings   {}\n", path.display());
    }
    #[cfg(feature = "record")]
    if let Some(directory) = &arguments.record {
        let key = case.record(directory, arguments.record_stamp)?;
        files += &format!("Recording  {}\n", directory.display());
        if let Some(key) = key {
            let line = sealed_by(&key);
            files += &line;
            // A fresh key is worth nothing to those who do not know its public part.
            if arguments.json && key.is_fresh() {
                tell!("{}", line.trim_end());
            }
        }
    }
    if let Some(folder) = &arguments.figures {
        let count = case.draw(folder)?.len();
        files += &format!("Figures    {count} files in {}\n", folder.display());
    }
    if let Some(path) = &arguments.report {
        case.write_report(path, details)?;
        files += &format!("Report     {}\n", path.display());
    }
    #[cfg(feature = "viewer")]
    if let Some(path) = &arguments.rrd {
        case.write_rrd(&evaluation, path)?;
        files += &format!("Viewer     rerun {}\n", path.display());
    }
    let spectrum = match arguments.json {
        true => Some(case.spectrum()?),
        false => None,
    };
    let summary = Summary {
        title: &case.title,
        vehicle_name: &case.parameters.settings().vehicle.name,
        travel: Travel {
            velocity: case.parameters.whole_impact().velocity,
            direction: case.parameters.direction(),
            in_plane: case.impact.velocity,
        },
        evaluation: &evaluation,
        solve_time,
        second_opinion: Some((&second_opinion, second_opinion_time)),
        spectrum: spectrum.as_ref(),
    };
    let text = match arguments.json {
        true => summary
            .json()
            .map(|json| json + "\n")
            .map_err(|fault| SimulateError::Output(fault.into()))?,
        false => format!("{summary}{files}"),
    };
    if history_to_output {
        tell!("{}", text.trim_end());
        return Ok(());
    }
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    Ok(unless_closed(written).map_err(SimulateError::Output)?)
}

/// Whether a path names the standard output, which then belongs to the history alone.
pub(super) fn is_standard_output(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
        .iter()
        .any(|name| path == Path::new(name))
}

/// Reads a time that a ROS stamp can hold \[s since 1970\].
#[cfg(feature = "record")]
fn stamp(text: &str) -> Result<f64, String> {
    let last = f64::from(i32::MAX);
    text.parse()
        .ok()
        .filter(|secs| (0.0..=last).contains(secs))
        .ok_or_else(|| format!("expected a time from 0 to {last} s"))
}

/// The line about the seal of a recording.
#[cfg(feature = "record")]
fn sealed_by(key: &SealKey) -> String {
    let public = key.public_key();
    match (key.path(), key.warning()) {
        (None, _) => format!("Sealed by  {public}, a key made for this run only\n"),
        (Some(path), None) => format!("Sealed by  {public}, the key of {}\n", path.display()),
        (Some(path), Some(warning)) => format!(
            "Sealed by  {public}, the key of {}\n           warning: {warning}\n",
            path.display()
        ),
    }
}

impl Case {
    /// Reads the parameters; options take precedence over them.
    fn from_arguments(arguments: &SimulateArgs) -> Result<Self, Failure> {
        let parameters = parameters_of(&arguments.config, &arguments.parameter, &arguments.impact)?;
        let impact = parameters.impact();
        let properties = parameters.column_properties().before(&impact);
        let vehicle = &parameters.settings().vehicle.name;
        let title = title(
            &parameters,
            vehicle,
            &parameters.whole_impact(),
            properties.length_below,
            parameters.direction(),
        );
        let max_duration = parameters.response_duration();
        Ok(Self {
            title,
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

    /// The response spectrum of the contact force.
    fn spectrum(&self) -> Result<ForceSpectrum, SimulateError> {
        let mut spectrum = ForceSpectrum::default();
        self.simulate(&mut |sample| spectrum.push(sample.time, sample.impulse))?;
        Ok(spectrum)
    }

    fn write_history_file(&self, path: &Path) -> Result<(), SimulateError> {
        let fault = |reason| SimulateError::History {
            path: path.to_path_buf(),
            reason,
        };
        let file = WholeFile::create(path).map_err(fault)?;
        let written = self.write_history(file).and_then(WholeFile::commit);
        // The file may be a pipe.
        unless_closed(written).map_err(fault)
    }

    /// Writes what the sensors read.
    fn write_readings(&self, path: &Path, seed: u64) -> Result<(), SimulateError> {
        let sensors = self.parameters.sensors();
        if sensors.is_empty() {
            return Err(SimulateError::NoSensors);
        }
        let readings = simulate_sensors(
            &self.properties,
            &self.impact,
            self.max_duration,
            &sensors,
            seed,
        )?;
        let fault = |reason| SimulateError::Readings {
            path: path.to_path_buf(),
            reason,
        };
        let mut file = WholeFile::create(path).map_err(fault)?;
        let written = readings
            .write_csv(&mut file, &sensors)
            .map_err(io::Error::other);
        unless_closed(written.and_then(|()| file.commit())).map_err(fault)
    }

    /// Writes the history and returns the target.
    fn write_history<W: Write>(&self, target: W) -> io::Result<W> {
        let masses = self.impact.vehicle.map_or(0, |it| it.masses().len());
        let mut writer = HistoryWriter::new(target, masses)?;
        let mut fault = None;
        let simulated = self.simulate(&mut |sample| {
            if fault.is_none() {
                fault = writer.write(sample).err();
            }
        });
        match (fault, simulated) {
            (Some(fault), _) => Err(fault),
            (None, Err(fault)) => Err(io::Error::other(fault)),
            (None, Ok(_)) => writer.finish(),
        }
    }

    /// Writes a recording in which the event happens at `stamp` \[s\]; returns the key with which it is sealed.
    #[cfg(feature = "record")]
    fn record(&self, directory: &Path, stamp: f64) -> Result<Option<SealKey>, SimulateError> {
        let record = &self.parameters.settings().record;
        let key = column_twin::recording::seal_key(record)
            .map_err(|error| SimulateError::Recording(error.into()))?;
        let options = WriterOptions {
            seal: key.clone(),
            ..column_twin::recording::writer_options(record.compression)
        };
        let origin = (stamp * 1e9).round() as i64;
        column_twin::evidence::record_impact(&self.parameters, origin, directory, &options)
            .map_err(SimulateError::Recording)?;
        Ok(key)
    }

    /// Writes a file for the viewer, in which the impact happens now.
    #[cfg(feature = "viewer")]
    fn write_rrd(&self, evaluation: &ImpactEvaluation, path: &Path) -> Result<(), SimulateError> {
        let report = &evaluation.report;
        let mut thinning = HistoryThinning::new(report.steps, report.end_time);
        self.simulate(&mut |sample| thinning.push(sample))?;
        let vehicle = &self.parameters.settings().vehicle.name;
        let impact = self.parameters.whole_impact();
        let direction = self.parameters.direction();
        let report = ImpactReport::evaluated(evaluation, vehicle, &impact, direction);
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let now = now.map_or(0, |now| i64::try_from(now.as_nanos()).unwrap_or(0));
        let mut items = viewer::from_samples("simulated", now, thinning.finish(), &report);
        let beam = BeamTask::of_parameters(&self.parameters).and_then(|task| task.movement());
        items.extend(beam.ok().map(|movement| ViewerItem::Beam {
            event_id: "simulated".into(),
            movement: Arc::new(movement),
        }));
        Ok(viewer::write_rrd(
            path,
            &Arc::new(self.parameters.clone()),
            items,
            false,
        )?)
    }

    fn draw(&self, folder: &Path) -> Result<Vec<PathBuf>, SimulateError> {
        let impact = ReportedImpact::simulated(&self.parameters)?;
        Ok(figures::draw_all(folder, &impact.history())?)
    }

    fn write_report(&self, path: &Path, details: ReportDetails) -> Result<(), SimulateError> {
        let document = ReportDocument {
            origin: Origin::Simulation,
            impacts: vec![ReportedImpact::simulated(&self.parameters)?],
            details,
        };
        let html = document.html()?;
        let written = |path: &Path, text: &str| {
            whole_file::write(path, text.as_bytes()).map_err(|reason| SimulateError::Report {
                path: path.to_path_buf(),
                reason,
            })
        };
        written(&parameters_path(path), &document.parameters_json())?;
        written(path, &html)
    }
}

/// The parameters of the files with the overrides and the options of an impact, which take precedence; prints warnings.
pub(super) fn parameters_of(
    files: &[PathBuf],
    overrides: &[String],
    impact: &ImpactSpecificationArgs,
) -> Result<Parameters, Failure> {
    let mut all: Vec<_> = impact.implied_override().into_iter().collect();
    all.extend(overrides.iter().cloned());
    all.extend(impact.overrides());
    let mut overrides = all;
    let (mut parameters, warnings) = load(files, &overrides)?;
    for warning in &warnings {
        tell!("Warning: {warning}");
    }
    if let Some(height) = impact.height() {
        let column = parameters.column_properties();
        let total = column.length_below + column.length_above;
        if !(height > 0.0 && height < total) {
            return Err(SimulateError::Height { height, total }.into());
        }
        overrides.push(format!("geometry.length_below:={}", yaml(height)));
        overrides.push(format!("geometry.length_above:={}", yaml(total - height)));
        (parameters, _) = load(files, &overrides)?;
    }
    Ok(parameters)
}

/// Loads the parameters of the files with the overrides.
/// The parameters, with warnings about deprecated values.
pub(super) fn load(
    files: &[PathBuf],
    overrides: &[String],
) -> Result<(Parameters, Vec<Fault>), ParameterFaults> {
    let files = files.iter().cloned().map(Source::File);
    let overrides = overrides
        .iter()
        .map(|text| Source::Override(parse_override(text)));
    Parameters::load_in_order(&NodeName::default(), files.chain(overrides))
}
