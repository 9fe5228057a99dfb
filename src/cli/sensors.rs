//! `column-twin sensors check`: the sensors on the column at commissioning, against what the model says of its vibration.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde_json::{Value as Json, json};

use super::failure::{Exit, Failure, printed};
use super::recorded_readings::RecordedReadingsArgs;
use column_twin::commissioning::{
    CheckError, CheckedSensor, Explanation, SensorCheck, SensorFault, SupportStiffness,
    check_sensors,
};
use column_twin::second_opinion::{NoSecondOpinion, beam_column};
use column_twin::sensors::Sensor;
use column_twin::whole_file;

/// Arguments of `column-twin sensors`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct SensorsArgs {
    #[command(subcommand)]
    command: SensorsCommand,
}

#[derive(Debug, Subcommand)]
enum SensorsCommand {
    /// Compare readings of the vibrating column with what the model says about frequencies, signs and amplitudes
    Check(CheckArgs),
}

/// Arguments of `column-twin sensors check`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct CheckArgs {
    #[command(flatten)]
    recorded: RecordedReadingsArgs,
    /// Write the stiffness of the supports that fits, where it differs, as a parameter file; an existing file is replaced
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Print the result as JSON (SI units) and nothing else
    #[arg(long)]
    json: bool,
}

const EXAMPLE: &str = "\
Record the sensors while the column vibrates: from a few taps with a soft hammer across the column, in
the direction in which a vehicle would hit it, or for some minutes from traffic and wind. Nothing is
changed: the command prints the stiffness that fits. docs/commissioning.md describes the method and its limits.

Example: the sensors of a column, with a recording of three taps
  column-twin sensors check --config garage.yaml --readings taps.csv --write supports.yaml

Exit codes: 0 all sensors that can be tested are consistent, 1 a sensor is wrong, or failed, 2 bad input or
usage, 3 not checked: the column moved too little.";

/// Why nothing was checked.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum SensorsCommandError {
    #[error("no sensors are declared; expected sensors.names in a parameter file")]
    #[diagnostic(help("config/sensors_industrial.yaml is an example"))]
    NoSensors,
    #[error("the check computes the vibration of the column with the fibre beam: {0}")]
    NoBeam(NoSecondOpinion),
    #[error("cannot check the sensors with the readings of {}: {fault}", path.display())]
    #[diagnostic(help("{remedy}"))]
    Check {
        path: PathBuf,
        fault: CheckError,
        remedy: &'static str,
    },
    #[error("cannot write the parameters to {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    Write { path: PathBuf, reason: io::Error },
}

impl From<SensorsCommandError> for Failure {
    fn from(fault: SensorsCommandError) -> Self {
        let exit = match &fault {
            SensorsCommandError::Check {
                fault: CheckError::NotEnoughMotion { .. },
                ..
            } => Exit::Lossy,
            SensorsCommandError::Write { .. } => Exit::Failed,
            _ => Exit::BadInput,
        };
        Self::new(exit, fault)
    }
}

/// Checks the sensors and prints what was found.
pub(super) fn run(arguments: &SensorsArgs, output: &mut dyn Write) -> Result<(), Failure> {
    let SensorsCommand::Check(arguments) = &arguments.command;
    let parameters = arguments.recorded.parameters()?;
    let sensors = parameters.sensors();
    if sensors.is_empty() {
        return Err(SensorsCommandError::NoSensors.into());
    }
    let readings = arguments.recorded.read(&sensors)?;
    let column = beam_column(&parameters).map_err(SensorsCommandError::NoBeam)?;
    let check = check_sensors(&column, &sensors, &readings).map_err(|fault| {
        SensorsCommandError::Check {
            path: arguments.recorded.path().to_owned(),
            remedy: remedy(&fault),
            fault,
        }
    })?;
    let text = match arguments.json {
        true => format!("{:#}\n", fields(&check, &sensors)),
        false => summary(&check, &sensors),
    };
    printed(
        output
            .write_all(text.as_bytes())
            .and_then(|()| output.flush()),
    )?;
    if let Some(path) = &arguments.write {
        match parameter_lines(&check) {
            Some(lines) => whole_file::write(path, lines.as_bytes()).map_err(|reason| {
                let path = path.clone();
                SensorsCommandError::Write { path, reason }
            })?,
            None => tell!(
                "{} is not written: no support differs from the parameters by more than the readings leave open",
                path.display()
            ),
        }
    }
    let wrong: Vec<&str> = check
        .sensors
        .iter()
        .filter(|it| !it.faults.is_empty())
        .map(|it| it.name.as_str())
        .collect();
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(Failure::plain(
            Exit::Failed,
            format!(
                "expected readings that agree with the model and with one another; the check doubts {}; examine the sensors that the table \
                 names, correct them, and check again",
                wrong.join(", ")
            ),
        )),
    }
}

/// What to do where nothing can be checked.
fn remedy(fault: &CheckError) -> &'static str {
    match fault {
        CheckError::Beam(_) => "correct the geometry, the supports or the load of the column",
        CheckError::NoSensor { .. } => "declare at least one of these sensors, and record it",
        CheckError::NoReadings { .. } => {
            "examine the sensors, their cables and their ranges, and record again"
        }
        CheckError::Short { .. } => "record for longer, with several taps",
        CheckError::Sparse { .. } => "record without gaps, at the declared rates",
        CheckError::Slow { .. } => {
            "record at least one sensor at a higher rate, and declare it as sensors.<name>.rate"
        }
        CheckError::NotEnoughMotion { .. } => {
            "tap the column harder with a soft hammer, or record for longer"
        }
    }
}

/// The result for a person.
fn summary(check: &SensorCheck, sensors: &[Sensor]) -> String {
    let mut text = "Natural frequency   by the parameters   supports may give   found\n".to_owned();
    for (name, mode) in ["first", "second"].into_iter().zip(&check.modes) {
        let found = mode
            .found
            .map_or_else(|| "not found".to_owned(), |it| format!("{it:.1} Hz"));
        let _ = writeln!(
            text,
            "{name:<20}{:<20}{:<20}{found}",
            format!("{:.1} Hz", mode.declared),
            format!("{:.0} to {:.0} Hz", mode.band[0], mode.band[1]),
        );
    }
    let widest = check.sensors.iter().map(|it| it.name.len()).max();
    let width = widest.unwrap_or(0).max(6) + 2;
    let _ = writeln!(
        text,
        "\n{:<width$}{:<17}{:<12}{:<12}{:<8}verdict",
        "sensor", "quantity", "expected", "found", "unit"
    );
    for (checked, sensor) in check.sensors.iter().zip(sensors) {
        let (unit, factor) = sensor.quantity.shown_unit();
        let [expected, found] = match checked.amplitudes {
            Some(both) => both.map(|it| format!("{:.3}", factor * it)),
            None => ["-", "-"].map(str::to_owned),
        };
        let _ = writeln!(
            text,
            "{:<width$}{:<17}{expected:<12}{found:<12}{unit:<8}{}",
            checked.name,
            sensor.quantity.word(),
            verdict(checked, sensor, sensors),
        );
    }
    text += "\nexpected: the amplitude at the first natural frequency that follows from the other sensors\n\n";
    for support in &check.supports {
        let [mean, low, high] = support.stiffness.map(|it| match it {
            _ if it.is_infinite() => "built in".to_owned(),
            _ if it == 0.0 => "a hinge".to_owned(),
            _ => format!("{it:.2e} N m/rad"),
        });
        let _ = match support.is_known() {
            true => writeln!(
                text,
                "Stiffness of the {}: {mean}, 90 % interval {low} to {high}; {}",
                support.end,
                match support.is_as_declared() {
                    true => "the parameters agree",
                    false => "the parameters differ",
                }
            ),
            false => writeln!(
                text,
                "Stiffness of the {}: not known from these readings, 90 % interval {low} to {high}",
                support.end
            ),
        };
    }
    if let Some(lines) = parameter_lines(check) {
        text += "\nThese parameters fit the readings; they are not applied. Change the column only if an engineer can explain them:\n";
        text += &lines;
    }
    text
}

/// What is wrong with a sensor, in words.
fn verdict(checked: &CheckedSensor, sensor: &Sensor, sensors: &[Sensor]) -> String {
    if checked.faults.is_empty() {
        return match checked.untested {
            Some(reason) => format!("not tested: {reason}"),
            None => "consistent".to_owned(),
        };
    }
    let mut certain = Vec::new();
    let mut possible = Vec::new();
    for fault in &checked.faults {
        let words = in_words(fault, sensor, sensors);
        match fault {
            SensorFault::Explained(_) => possible.push(words),
            // Without a majority, any of them may be right.
            SensorFault::OutOfPhase(..) if !checked.or.is_empty() => possible.push(words),
            _ => certain.push(words),
        }
    }
    if !checked.or.is_empty() {
        possible.push(format!("{} is wrong instead", checked.or.join(" or ")));
    }
    if !possible.is_empty() {
        certain.push(possible.join(", or "));
    }
    certain.join("; ")
}

fn in_words(fault: &SensorFault, sensor: &Sensor, sensors: &[Sensor]) -> String {
    let (unit, factor) = sensor.quantity.shown_unit();
    match fault {
        SensorFault::NoReadings => "dead: no readings".to_owned(),
        SensorFault::Stuck(value, share) => format!(
            "stuck at {:.4} {unit} in {:.0} % of its readings",
            factor * value,
            100.0 * share
        ),
        SensorFault::Saturated(value, share) => format!(
            "saturated at {:.4} {unit} in {:.1} % of its readings",
            factor * value,
            100.0 * share
        ),
        SensorFault::Rate(found) => format!(
            "rate differs: {found:.1} samples per second by the times, {:.1} declared",
            sensor.rate
        ),
        SensorFault::OutOfPhase(angle, delay) => format!(
            "clock differs: {:.0} degrees out of phase, as of {:.2} ms behind the others, or by half periods more",
            angle.to_degrees(),
            1e3 * delay
        ),
        SensorFault::Explained(explanation) => match explanation {
            Explanation::WrongSign => "wrong sign".to_owned(),
            Explanation::Gain(gain) => {
                let sign = if *gain < 0.0 { "wrong sign and " } else { "" };
                format!("{sign}gain off by {:+.0} %", 100.0 * (gain.abs() - 1.0))
            }
            Explanation::Height(height) => {
                format!(
                    "height inconsistent: {height:.2} m fits, {:.2} m declared",
                    sensor.height
                )
            }
            Explanation::Swapped(other) => format!("swapped with {}", sensors[*other].name),
            Explanation::Dead => "dead: it does not react".to_owned(),
        },
    }
}

/// The supports that differ, as a parameter file.
fn parameter_lines(check: &SensorCheck) -> Option<String> {
    let differs = |it: &&SupportStiffness| it.is_known() && !it.is_as_declared();
    let mut lines = String::new();
    for support in check.supports.iter().filter(differs) {
        let SupportStiffness { end, stiffness, .. } = support;
        let [mean, low, high] = *stiffness;
        let kind = match mean {
            _ if mean.is_infinite() => "built_in",
            0.0 => "pinned",
            _ => "semi_rigid",
        };
        let _ = writeln!(lines, "      {end}: {kind}");
        if kind == "semi_rigid" {
            let rounded: f64 = format!("{mean:.2e}").parse().unwrap_or(mean);
            let _ = writeln!(
                lines,
                "      {end}_stiffness: {rounded:.1} # [N m/rad], 90 % interval {low:.2e} to {high:.2e}"
            );
        }
    }
    (!lines.is_empty()).then(|| {
        format!(
            "# Fitted by `column-twin sensors check` to natural frequencies, amplitudes and the declared supports.\n/**:\n  ros__parameters:\n    support:\n{lines}"
        )
    })
}

/// The result in SI units. What is infinite is null.
fn fields(check: &SensorCheck, sensors: &[Sensor]) -> Json {
    let modes = check.modes.iter().map(|mode| {
        json!({
            "declared_hz": mode.declared,
            "low_hz": mode.band[0],
            "high_hz": mode.band[1],
            "found_hz": mode.found,
        })
    });
    let checked = check.sensors.iter().zip(sensors).map(|(it, sensor)| {
        let verdicts = it
            .faults
            .iter()
            .map(|fault| fault_fields(fault, sensor, sensors));
        json!({
            "name": it.name,
            "quantity": sensor.quantity.word(),
            "expected_amplitude": it.amplitudes.map(|both| both[0]),
            "found_amplitude": it.amplitudes.map(|both| both[1]),
            "consistent": it.faults.is_empty(),
            "faults": verdicts.collect::<Vec<_>>(),
            "or_wrong_instead": it.or,
            "not_tested": it.untested,
            "verdict": verdict(it, sensor, sensors),
        })
    });
    let interval = |[mean, low, high]: [f64; 3]| json!({ "mean": mean, "low": low, "high": high });
    let supports = check.supports.iter().map(|it| {
        json!({
            "end": it.end,
            "declared_fixity": it.declared,
            "fixity": interval(it.fixity),
            "stiffness_n_m_rad": interval(it.stiffness),
            "known": it.is_known(),
            "as_declared": it.is_as_declared(),
        })
    });
    json!({
        "consistent": check.is_consistent(),
        "modes": modes.collect::<Vec<_>>(),
        "sensors": checked.collect::<Vec<_>>(),
        "supports": supports.collect::<Vec<_>>(),
        "parameters": parameter_lines(check),
    })
}

fn fault_fields(fault: &SensorFault, sensor: &Sensor, sensors: &[Sensor]) -> Json {
    match fault {
        SensorFault::NoReadings => json!({ "kind": "no_readings" }),
        SensorFault::Stuck(value, share) => {
            json!({ "kind": "stuck", "value": value, "share": share })
        }
        SensorFault::Saturated(value, share) => {
            json!({ "kind": "saturated", "value": value, "share": share })
        }
        SensorFault::Rate(found) => {
            json!({ "kind": "rate", "found_hz": found, "declared_hz": sensor.rate })
        }
        SensorFault::OutOfPhase(angle, delay) => {
            json!({ "kind": "out_of_phase", "angle_rad": angle, "delay_s": delay })
        }
        SensorFault::Explained(explanation) => match explanation {
            Explanation::WrongSign => json!({ "kind": "wrong_sign" }),
            Explanation::Gain(gain) => json!({ "kind": "gain", "factor": gain }),
            Explanation::Height(height) => json!({ "kind": "height", "fits_m": height }),
            Explanation::Swapped(other) => {
                json!({ "kind": "swapped", "with": sensors[*other].name })
            }
            Explanation::Dead => json!({ "kind": "dead" }),
        },
    }
}
