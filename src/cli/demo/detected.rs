//! `column-twin demo --sensors`: the node receives no event and detects the impact with its sensors.

use std::cell::RefCell;
use std::fs::File;
use std::io::BufWriter;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::signal::{self, Truth};
use super::stage::{ChildProcess, Stage};
use super::texts::{TIMEOUT, action_text, outcome_text};
use crate::cli::failure::{Exit, Failure, LinePrinter};
use column_twin::estimation::Readings;
use column_twin::messages::column_twin_msgs::{ImpactEstimate, ImpactReport, TwinStatus};
use column_twin::parameters::Parameters;
use column_twin::ros::{Seen, actions_in_words, decision_word, follow_sensors, in_unit};
use column_twin::sensors::Sensor;

/// The parameter files of the demonstration, and what is in them.
const FILES: [(&str, &str); 3] = [
    (
        "column.yaml",
        include_str!("../../../config/heb220_s355.yaml"),
    ),
    (
        "sensors.yaml",
        include_str!("../../../config/sensors_industrial.yaml"),
    ),
    ("signal.yaml", signal::PARAMETERS),
];

/// The table that is played.
const READINGS: &str = "readings.csv";

/// The report of the recording.
const REPORT: &str = "report.html";

/// Statuses of a twin at rest, after the final estimate, that show that no response follows from it.
const STATUSES_AT_REST: u32 = 2;

/// Maximum wait for the next message about the impact after the first one. The final estimate is made without haste.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs the demonstration.
pub(super) fn demonstrate(stage: &Stage<'_, '_>) -> Result<(), Failure> {
    let out = stage.out;
    for (name, content) in FILES {
        stage.write(name, content)?;
    }
    let truth = signal::truth()?;
    let sensors = Parameters::load(&FILES.map(|(name, _)| stage.folder.join(name)), &[])?.sensors();
    let readings = signal::readings(&sensors)?;
    write_table(stage, &readings, &sensors)?;
    let mut node = stage.start_node(&FILES.map(|(name, _)| name), &[])?;
    let detected = follow(stage, &readings);
    let ended = stage.stop_node(&mut node);
    stage.unless_asked()?;
    let detected = detected.map_err(|failure| node.explain(failure))?;
    print_outcome(&detected, &truth, out);
    ended?;
    let (recording, found) = stage.verify()?;
    out.print(format_args!(
        "{} of {} estimates were computed again from the recorded measurements.",
        found.estimates.compared, found.estimates.recorded
    ));
    let inside = |name: &str| stage.folder.join(name).display().to_string();
    let shown = recording.display();
    let command = [
        "report".to_owned(),
        shown.to_string(),
        "-o".to_owned(),
        inside(REPORT),
    ];
    stage.run("report", &command, "the report")?;
    let configs = FILES.map(|(name, _)| format!("--config {}", inside(name)));
    stage.print_end(
        &recording,
        &[
            [REPORT, "detection, estimates and decision, for a browser"],
            [READINGS, "readings of the sensors"],
        ],
        &[
            format!("column-twin info {shown}"),
            format!(
                "column-twin estimate {} --readings {} --figures {}",
                configs.join(" "),
                inside(READINGS),
                inside("figures")
            ),
        ],
    );
    Ok(())
}

fn write_table(
    stage: &Stage<'_, '_>,
    readings: &Readings,
    sensors: &[Sensor],
) -> Result<(), Failure> {
    let path = stage.folder.join(READINGS);
    let unwritable = |reason: String| {
        let path = path.display();
        Failure::plain(Exit::Failed, format!("cannot write {path}: {reason}"))
    };
    let file = File::create(&path).map_err(|error| unwritable(error.to_string()))?;
    readings
        .write_csv(BufWriter::new(file), sensors)
        .map_err(|error| unwritable(error.to_string()))
}

/// What was detected, and what it has become.
struct Detected {
    estimate: ImpactEstimate,
    report: ImpactReport,
}

/// Plays the table and shows what the node makes of it.
fn follow(stage: &Stage<'_, '_>, readings: &Readings) -> Result<Detected, Failure> {
    let out = stage.out;
    let measuring: RefCell<Option<Result<ChildProcess, Failure>>> = RefCell::new(None);
    let mut told = Told::new(out);
    let duration = readings.times.last().copied().unwrap_or_default();
    let mut deadline = Instant::now() + TIMEOUT + Duration::from_secs_f64(duration) + PATIENCE;
    let mut fault = None;
    let ready = || {
        let named: String = FILES.map(|(name, _)| format!(" --config {name}")).concat();
        out.print(format_args!(
            "Sensors started: column-twin measure {READINGS}{named}\nThey read a column at rest; the node learns their noise and \
             prepares its responses.\n"
        ));
        *measuring.borrow_mut() = Some(measure(stage));
    };
    let mut hear = |seen: Option<&Seen>| {
        if let Some(seen) = seen
            && told.take(seen)
        {
            deadline = Instant::now() + PATIENCE;
        }
        fault = fault_of(measuring.borrow_mut().as_mut(), deadline);
        match fault.is_some() || told.is_complete() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    follow_sensors(&stage.environment, stage.signals, TIMEOUT, ready, &mut hear)
        .map_err(|error| Failure::plain(Exit::Failed, error))?;
    match (fault, told.newest, told.report) {
        (Some(fault), ..) => Err(fault),
        (None, Some(estimate), Some(report)) => Ok(Detected { estimate, report }),
        _ => Err(Failure::plain(
            Exit::Failed,
            "the impact that was detected has not become one of the twin",
        )),
    }
}

/// Publishes the readings, in a process of its own as the drivers of the sensors would.
fn measure(stage: &Stage<'_, '_>) -> Result<ChildProcess, Failure> {
    let inside = |name: &str| stage.folder.join(name).display().to_string();
    let mut arguments = vec!["measure".to_owned(), inside(READINGS)];
    for (name, _) in FILES {
        arguments.extend(["--config".to_owned(), inside(name)]);
    }
    stage.start("measure", &arguments)
}

/// Why it cannot go on.
fn fault_of(
    measuring: Option<&mut Result<ChildProcess, Failure>>,
    deadline: Instant,
) -> Option<Failure> {
    match measuring {
        Some(Err(failure)) => Some(Failure::plain(failure.exit, &failure.report)),
        Some(Ok(process)) => match process.ended() {
            Err(failure) => Some(failure),
            Ok(Some(status)) if !status.success() => {
                Some(process.explain(Failure::plain(Exit::Failed, "the readings were not sent")))
            }
            Ok(_) if Instant::now() >= deadline => Some(Failure::plain(
                Exit::Failed,
                format!("the node has reported no impact for {PATIENCE:?}"),
            )),
            Ok(_) => None,
        },
        None => None,
    }
}

/// Tells what the messages of the node say.
struct Told<'a, 'b> {
    out: &'a LinePrinter<'b>,
    newest: Option<ImpactEstimate>,
    report: Option<ImpactReport>,
    /// Statuses at rest since the final estimate.
    at_rest: u32,
}

impl<'a, 'b> Told<'a, 'b> {
    fn new(out: &'a LinePrinter<'b>) -> Self {
        Self {
            out,
            newest: None,
            report: None,
            at_rest: 0,
        }
    }

    /// Tells a message; whether it is about the impact.
    fn take(&mut self, seen: &Seen) -> bool {
        match seen {
            Seen::Estimate(estimate) => self.estimate(estimate),
            Seen::Report(report) => {
                self.report = Some(report.clone());
                self.at_rest = 0;
            }
            Seen::Status(status) if self.newest.as_ref().is_some_and(|it| it.is_final) => {
                let responds = (TwinStatus::IDLE + 1..TwinStatus::REST).contains(&status.phase);
                self.at_rest = if responds { 0 } else { self.at_rest + 1 };
            }
            _ => return false,
        }
        true
    }

    fn estimate(&mut self, it: &ImpactEstimate) {
        let last = self.newest.replace(it.clone());
        if last.is_none() {
            self.out.print(format_args!(
                "The sensors have detected an impact. Vehicle and residual damage, with 90 % intervals:\n"
            ));
        }
        if last.as_ref().is_none_or(|last| last.update != it.update) {
            self.numbers(it);
        }
        let decision = |it: &ImpactEstimate| it.decision;
        let before = last
            .as_ref()
            .map_or(ImpactEstimate::DECISION_PENDING, decision);
        if before != it.decision {
            self.out.print(format_args!(
                "  {:>9} | {} (estimation.accept is automatic), with data until {:.0} ms after contact",
                "",
                decision_word(it.decision).to_uppercase(),
                1e3 * it.data_until
            ));
        }
        if it.is_final && !last.is_some_and(|last| last.is_final) {
            self.out
                .print(format_args!("  {:>9} | this estimate is final", ""));
        }
    }

    fn numbers(&self, it: &ImpactEstimate) {
        let print = |time: &str, left: String, right: String| {
            self.out
                .print(format_args!("  {time:>9} | {left:<36} {right}"));
        };
        print(
            &format!("{:.1} ms", 1e3 * it.data_until),
            format!("momentum {}", in_unit(&it.momentum, 1e-3, "kN s")),
            format!("peak {}", in_unit(&it.peak_v1, 1e3, "mm")),
        );
        print(
            "",
            format!("mass {}", in_unit(&it.mass, 1.0, "kg")),
            format!("remains {}", in_unit(&it.residual_v1, 1e3, "mm")),
        );
        print(
            "",
            format!("speed {}", in_unit(&it.velocity, 1.0, "m/s")),
            actions_in_words(it),
        );
    }

    /// Whether the twin has said everything about the impact.
    fn is_complete(&self) -> bool {
        let estimate = self.newest.as_ref().filter(|it| it.is_final);
        estimate.is_some_and(|estimate| {
            let is_accepted = estimate.decision == ImpactEstimate::DECISION_ACCEPTED;
            self.at_rest >= STATUSES_AT_REST && (self.report.is_some() || !is_accepted)
        })
    }
}

/// The final estimate beside the truth of the signal, and what the twin has made of it.
fn print_outcome(detected: &Detected, truth: &Truth, out: &LinePrinter<'_>) {
    let Detected { estimate, report } = detected;
    out.print(format_args!(
        "\n  {:14}{:>16}   final estimate, 90 % interval",
        "", "in the signal"
    ));
    let row = |name: &str, truth: f64, factor: f64, unit: &str, estimated| {
        let exact = column_twin::figures::units::significant(factor * truth, 3);
        out.print(format_args!(
            "  {name:14}{:>16}   {}",
            format!("{exact} {unit}"),
            in_unit(estimated, factor, unit)
        ));
    };
    let momentum = truth.mass * truth.velocity;
    row("momentum", momentum, 1e-3, "kN s", &estimate.momentum);
    row("mass", truth.mass, 1.0, "kg", &estimate.mass);
    row("speed", truth.velocity, 1.0, "m/s", &estimate.velocity);
    row("peak v1", truth.peak_v1, 1e3, "mm", &estimate.peak_v1);
    row(
        "residual v1",
        truth.residual_v1,
        1e3,
        "mm",
        &estimate.residual_v1,
    );
    out.print(format_args!(
        "\n  The twin follows the response that explains the data best: {:.0} kg, {:.1} m/s; peak v1\n  {:.1} mm, residual \
         {:.1} mm; {}\n{}",
        report.mass,
        report.velocity,
        1e3 * report.max_v1,
        1e3 * report.residual_v1,
        outcome_text(report),
        action_text(report)
    ));
}
