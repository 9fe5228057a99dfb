//! `column-twin estimate`: what struck the column and what remains of it, from the readings of its sensors.

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value as Json, json};

use super::failure::{Exit, Failure, unless_closed};
use super::recorded_readings::RecordedReadingsArgs;
use column_twin::assessment::Action;
use column_twin::estimation::{
    CredibleInterval, EstimatorError, FEWEST_RESPONSES, ImpactEstimate, MASS_OPEN_BEYOND,
    MOMENTUM_OPEN_BEYOND, Readings, RecordedImpact, VELOCITY_OPEN_BEYOND, estimate_recorded,
};
use column_twin::figures::{EstimateFigures, FigureError, draw_estimate};
use column_twin::parameters::Parameters;
use column_twin::report::{EstimateDocument, parameters_path};
use column_twin::sensors::Sensor;
use column_twin::whole_file;
use printable::Printable;

/// Arguments of `column-twin estimate`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct EstimateArgs {
    #[command(flatten)]
    recorded: RecordedReadingsArgs,
    /// Write a report in HTML; an existing file is replaced
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Draw the forecast and, for each sensor, the readings and their prediction, as SVG and PNG
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// Print the estimate as JSON (SI units), with its history, and nothing else
    #[arg(long)]
    json: bool,
    /// Seed of the random numbers; the same seed gives the same estimate
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

const EXAMPLE: &str = "\
The column is assumed to be undamaged before the impact. docs/estimation.md describes the method
and its limits.

Example: simulate the readings of sensors when a car hits the column, and estimate the car from that
  column-twin simulate --config config/heb220_s355.yaml --config config/sensors_industrial.yaml \\
    --vehicle mid_car --velocity 12 --readings readings.csv
  column-twin estimate --config config/heb220_s355.yaml --config config/sensors_industrial.yaml \\
    --readings readings.csv --figures figures --report estimate.html

Exit codes: 0 done (also if no impact was detected), 1 failed, 2 bad input or usage.";

/// Why nothing can be estimated.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum EstimateCommandError {
    #[error(transparent)]
    #[diagnostic(help(
        "declare the sensors in a parameter file: config/sensors_industrial.yaml is an example"
    ))]
    Estimator(#[from] EstimatorError),
    #[error("cannot write the report to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    Report { path: PathBuf, reason: io::Error },
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
}

impl From<EstimateCommandError> for Failure {
    fn from(fault: EstimateCommandError) -> Self {
        let exit = match &fault {
            EstimateCommandError::Output(_) | EstimateCommandError::Report { .. } => Exit::Failed,
            _ => Exit::BadInput,
        };
        Self::new(exit, fault)
    }
}

/// Reads the readings, estimates, and prints the result to `output`.
pub(super) fn run(arguments: &EstimateArgs, output: &mut dyn Write) -> Result<(), Failure> {
    let parameters = arguments.recorded.parameters()?;
    let sensors = parameters.sensors();
    if sensors.is_empty() {
        return Err(EstimateCommandError::from(EstimatorError::NoSensors).into());
    }
    let readings = arguments.recorded.read(&sensors)?;
    let bar = progress_bar();
    let estimated = estimate_recorded(
        &parameters,
        &sensors,
        &readings,
        arguments.seed,
        &mut |share| bar.set_position((100.0 * share) as u64),
    );
    bar.finish_and_clear();
    let estimated = estimated.map_err(EstimateCommandError::from)?;
    let text = if arguments.json {
        let fields = fields(estimated.as_ref());
        serde_json::to_string_pretty(&fields)
            .map_err(|fault| EstimateCommandError::Output(fault.into()))?
            + "\n"
    } else {
        match &estimated {
            Some(impact) => summary(impact, &sensors[impact.detection.sensor].name),
            None => nothing(&readings),
        }
    };
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    unless_closed(written).map_err(EstimateCommandError::Output)?;
    // A file that cannot be written does not take the result away.
    match &estimated {
        Some(impact) => write_files(arguments, &parameters, &sensors, impact),
        None => {
            if arguments.report.is_some() || arguments.figures.is_some() {
                tell!("no impact was detected: neither a report nor figures are written");
            }
            Ok(())
        }
    }
}

/// Writes the report and the figures, as far as they are wanted.
fn write_files(
    arguments: &EstimateArgs,
    parameters: &Parameters,
    sensors: &[Sensor],
    impact: &RecordedImpact,
) -> Result<(), Failure> {
    let failed = |fault: FigureError| Failure::new(Exit::Failed, fault);
    let source = match arguments.recorded.path() {
        path if path == Path::new("-") => "the standard input".to_owned(),
        path => Printable(&path.to_string_lossy()).to_string(),
    };
    if let Some(folder) = &arguments.figures {
        let column = &parameters.settings().column_id;
        let figures = EstimateFigures {
            title: &format!("column {column}, readings of {source}"),
            sensors,
            impact,
        };
        draw_estimate(folder, &figures).map_err(failed)?;
    }
    if let Some(path) = &arguments.report {
        let document = EstimateDocument {
            parameters,
            sensors,
            impact,
            source: &source,
            seed: arguments.seed,
        };
        let html = document.html().map_err(failed)?;
        let beside = parameters_path(path);
        for (path, text) in [(path, html), (&beside, document.parameters_json())] {
            whole_file::write(path, text.as_bytes()).map_err(|reason| {
                let path = path.clone();
                EstimateCommandError::Report { path, reason }
            })?;
        }
    }
    Ok(())
}

fn progress_bar() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {percent} % of the responses computed");
    let bar = ProgressBar::new(100);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// The result in SI units.
fn fields(impact: Option<&RecordedImpact>) -> Json {
    let Some(impact) = impact else {
        return json!({ "detected": false });
    };
    let last = impact.estimates.last().map(estimate_fields);
    let mut all = last.unwrap_or_default();
    all.insert("detected".into(), true.into());
    all.insert("further_impact_s".into(), impact.further.into());
    all.insert(
        "history".into(),
        impact.estimates.iter().map(estimate_fields).collect(),
    );
    Json::Object(all)
}

fn estimate_fields(estimate: &ImpactEstimate) -> Map<String, Json> {
    let named = |pairs: &mut dyn Iterator<Item = (String, f64)>| -> Json {
        Json::Object(pairs.map(|(name, value)| (name, value.into())).collect())
    };
    let action = |(action, probability): &(Action, f64)| (action.to_string(), *probability);
    let fields = json!({
        "data_until_s": estimate.data_until,
        "contact_time_s": estimate.contact_time.mean,
        "contact_time_interval_s": interval(&estimate.contact_time),
        "mass_kg": interval(&estimate.mass),
        "velocity_m_s": interval(&estimate.velocity),
        "momentum_n_s": interval(&estimate.momentum),
        "not_known": estimate.not_known(),
        "mass_velocity_correlation": estimate.mass_velocity_correlation,
        "peak_v1_m": interval(&estimate.peak_v1),
        "residual_v1_m": interval(&estimate.residual_v1),
        "capacity_ratio": interval(&estimate.capacity_ratio),
        "yielded": estimate.yielded,
        "collapsed": estimate.collapsed,
        "collapse_told": estimate.tells_collapse(),
        "action": named(&mut estimate.action.iter().map(action)),
        "vehicle_probabilities": named(&mut estimate.vehicle_probabilities.iter().cloned()),
        "effective_sample_size": estimate.effective_sample_size,
        "doubtful_sensors": estimate.doubtful_sensors,
        "scale_not_confirmed": estimate.scale_not_confirmed,
        "vehicle_by_beam": estimate.vehicle_by_beam,
    });
    match fields {
        Json::Object(fields) => fields,
        _ => Map::new(),
    }
}

fn interval(interval: &CredibleInterval) -> Json {
    json!({ "mean": interval.mean, "low": interval.low, "high": interval.high })
}

fn nothing(readings: &Readings) -> String {
    let first = readings.times.first().copied().unwrap_or_default();
    let last = readings.times.last().copied().unwrap_or_default();
    format!("No impact was detected between {first} s and {last} s.\n")
}

fn summary(impact: &RecordedImpact, sensor: &str) -> String {
    let mut text = String::new();
    let Some(last) = impact.estimates.last() else {
        return text;
    };
    let detection = &impact.detection;
    let milliseconds = 1e3 * (detection.confirmed_at - detection.contact.time);
    let _ = writeln!(
        text,
        "Impact at {:.4} s, confirmed {milliseconds:.0} ms later by {sensor}\n",
        detection.contact.time,
    );
    if let Some(further) = impact.further {
        let _ = writeln!(
            text,
            "The column was struck once more at {further:.3} s. The estimate rests on the readings before that; the second impact \
             is not estimated.\n"
        );
    }
    if last.tells_collapse() {
        let _ = write!(
            text,
            "The column collapses or is fractured with a probability of {:.0} %.",
            100.0 * last.collapsed
        );
        // From the first estimate on after which none has taken it back.
        let before = impact.estimates.iter().rposition(|it| !it.tells_collapse());
        let first = &impact.estimates[before.map_or(0, |it| it + 1)];
        let since = 1e3 * (first.data_until - detection.contact.time);
        let _ = writeln!(
            text,
            " The readings have told it since {since:.0} ms after contact.\n"
        );
    }
    let not_known = |interval: &CredibleInterval, open_beyond: Option<f64>| {
        open_beyond.is_some_and(|beyond| interval.is_open(beyond))
    };
    let rows = [
        ("Mass", last.mass, Some(MASS_OPEN_BEYOND), 1.0, "kg"),
        (
            "Speed",
            last.velocity,
            Some(VELOCITY_OPEN_BEYOND),
            1.0,
            "m/s",
        ),
        (
            "Momentum",
            last.momentum,
            Some(MOMENTUM_OPEN_BEYOND),
            1e-3,
            "kN s",
        ),
        ("Peak v1", last.peak_v1, None, 1e3, "mm"),
        ("Residual v1", last.residual_v1, None, 1e3, "mm"),
        (
            "Residual capacity",
            last.capacity_ratio,
            None,
            100.0,
            "% of the undamaged column's",
        ),
    ];
    for (name, interval, open_beyond, factor, unit) in rows {
        let CredibleInterval { mean, low, high } = interval;
        let [low, high] = [low, high].map(|end| short(factor * end));
        let _ = match not_known(&interval, open_beyond) {
            true => writeln!(
                text,
                "{name:<19}not known, 90 % interval {low} to {high} {unit}"
            ),
            false => writeln!(
                text,
                "{name:<19}{} {unit}, 90 % interval {low} to {high}",
                short(factor * mean)
            ),
        };
    }
    let list = |pairs: &mut dyn Iterator<Item = (String, f64)>| {
        let mut listed: Vec<_> = pairs
            .filter(|(_, probability)| *probability >= 0.005)
            .collect();
        listed.sort_by(|a, b| b.1.total_cmp(&a.1));
        let each = listed
            .iter()
            .map(|(name, probability)| format!("{name} {:.0} %", 100.0 * probability));
        each.collect::<Vec<_>>().join(", ")
    };
    let action = last
        .action
        .iter()
        .map(|(action, p)| (action.to_string(), *p));
    let _ = writeln!(text, "Action             {}", list(&mut action.into_iter()));
    let _ = writeln!(
        text,
        "Front like         {}",
        list(&mut last.vehicle_probabilities.iter().cloned())
    );
    text += "\nData until [ms]   mass [kg]              speed [m/s]            peak v1 [mm]           action\n";
    for estimate in &impact.estimates {
        let cell = |interval: &CredibleInterval, open_beyond: Option<f64>, factor: f64| {
            let CredibleInterval { mean, low, high } = interval;
            let mean = match not_known(interval, open_beyond) {
                true => "?".to_owned(),
                false => short(factor * mean),
            };
            let text = format!(
                "{mean} ({} to {})",
                short(factor * low),
                short(factor * high)
            );
            format!("{text:<23}")
        };
        let likely = estimate.action.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let _ = writeln!(
            text,
            "{:>15.0}   {}{}{}{}",
            1e3 * (estimate.data_until - detection.contact.time),
            cell(&estimate.mass, Some(MASS_OPEN_BEYOND), 1.0),
            cell(&estimate.velocity, Some(VELOCITY_OPEN_BEYOND), 1.0),
            cell(&estimate.peak_v1, None, 1e3),
            likely.map_or_else(String::new, |(action, p)| format!(
                "{action} {:.0} %",
                100.0 * p
            )),
        );
    }
    if last.effective_sample_size < FEWEST_RESPONSES {
        let _ = writeln!(
            text,
            "\nWarning: the effective sample size of the estimate is {:.0}; its intervals are unreliable.",
            last.effective_sample_size
        );
    }
    if let Some(doubt) = last.doubt_in_words() {
        let _ = writeln!(text, "\nWarning: {doubt}");
    }
    for note in last.notes() {
        let _ = writeln!(text, "\nNote: {note}");
    }
    text += "\nThe estimate includes the model's own error (docs/estimation.md), and is for the undamaged column.\n";
    text
}

/// Three significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    match size {
        _ if !size.is_finite() => "unknown".into(),
        _ if size >= 1000.0 => format!("{:.0}", (value / 10.0).round() * 10.0),
        _ if size >= 99.95 => format!("{value:.0}"),
        _ if size >= 9.995 => format!("{value:.1}"),
        _ if size < 0.005 => "0".into(),
        _ => format!("{value:.2}"),
    }
}
