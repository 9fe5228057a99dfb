//! `column-twin demo`: one impact from the event to the verified recording, on this machine and with nothing installed.
//!
//! The node runs as a process of its own; the demonstration talks to it over real DDS on loopback, as any client does.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - detected.rs: `column-twin demo --sensors`: the node receives no event and detects the impact with its sensors
// - signal.rs: The signal that the demonstration with sensors plays: `tests/data/signals/README.md` says where it comes from
// - stage.rs: What the demonstrations share: a folder, processes of this program in a domain of their own, and the verified
//   recording
// - texts.rs: Bounds and texts that both demonstrations use

mod detected;
mod signal;
mod stage;
mod texts;

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use self::stage::{Stage, new_folder};
use self::texts::{TIMEOUT, action_text, outcome_text};
use super::failure::{Exit, Failure, LinePrinter};
use super::summary::wrapped;
use column_twin::assessment::{ImpactEvaluation, respond_and_rest};
use column_twin::column::{HINGES, ImpactSpecification, WEBS};
use column_twin::messages::column_twin_msgs::{ColumnState, HingeForces, ImpactReport};
use column_twin::observables::{HINGE_PLACES, WEB_PLACES};
use column_twin::parameters::{Parameters, Value};
use column_twin::ros::{
    Environment, ImpactOptions, ImpactRequest, Seen, StopSignals, follow_impact, range_of,
};

/// Arguments of `column-twin demo`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct DemoArgs {
    /// Folder for all files; if it exists, a number is appended to its name
    #[arg(long, short, value_name = "FOLDER", default_value = "column_twin_demo")]
    output: PathBuf,
    /// Vehicle that hits the column at its own height: one of `column-twin vehicles`
    #[arg(long, value_name = "NAME", default_value = CAR)]
    vehicle: String,
    /// Mass of the vehicle [kg]; default: the vehicle's own
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Speed of the vehicle [m/s]
    #[arg(long, value_name = "M/S", default_value = "10")]
    velocity: f64,
    /// Send readings of sensors instead of an event; the node detects the impact
    #[arg(long, conflicts_with_all = ["vehicle", "mass", "velocity"])]
    sensors: bool,
}

const EXAMPLE: &str = "\
Starts the node on 127.0.0.1 in an unused DDS domain, sends it an impact, shows the response as it
arrives, records it, draws the figures, verifies the recording by recomputation, and exits. Nothing
leaves this machine.

With --sensors the node receives no impact event: the readings of three sensors are played to
it, with noise, from a signal of an independently written fibre-beam model (1.5 t at 36 km/h).
The node detects the impact, estimates vehicle and outcome with 90 % intervals while the data
arrive, and converts the estimate into an impact event once it is reliable enough.

Examples: a lorry; an impact that only the sensors detect
  column-twin demo --vehicle lorry_8t --velocity 8
  column-twin demo --sensors

Exit codes: 0 done, 1 failed, 2 bad input or usage.";

/// A real column.
const COLUMN: &str = include_str!("../../../config/heb220_s355.yaml");

/// Its `column_id`.
const COLUMN_ID: &str = "heb220_s355";

/// The vehicle that hits it unless another one is asked for.
const CAR: &str = "suv";

impl DemoArgs {
    /// The parameters of the hit. The column is given by its height, so that the vehicle strikes at its own.
    fn changes(&self) -> Vec<(&'static str, Value)> {
        let mut changes = vec![
            ("vehicle.name", Value::from(self.vehicle.as_str())),
            ("impact.velocity", self.velocity.into()),
        ];
        changes.extend(self.mass.map(|mass| ("impact.mass", mass.into())));
        changes
    }
}

/// Time of the response between two lines \[s\].
const LINE_PERIOD: f64 = 2e-3;

/// Length of the bar at the peak of the forecast, in characters.
const BAR: usize = 40;

/// Runs the demonstration.
pub fn run(arguments: &DemoArgs, out: &mut impl io::Write) -> Result<(), Failure> {
    // Ctrl-C also stops the programs that the demonstration has started; that is not a failure of theirs.
    let signals = StopSignals::listen().map_err(|error| Failure::plain(Exit::Failed, error))?;
    let lines = LinePrinter::new(out);
    let folder = new_folder(&arguments.output)?;
    let demonstrated = Stage::set(&folder, &signals, &lines).and_then(|stage| {
        if arguments.sensors {
            detected::demonstrate(&stage)
        } else {
            demonstrate(arguments, &stage)
        }
    });
    match demonstrated {
        Err(_) if signals.asked() => Err(Failure::plain(
            Exit::Failed,
            format!(
                "interrupted; the files written so far are in {}",
                folder.display()
            ),
        )),
        Err(failure) => Err(failure),
        Ok(()) => lines.end(),
    }
}

fn demonstrate(arguments: &DemoArgs, stage: &Stage<'_, '_>) -> Result<(), Failure> {
    let out = stage.out;
    stage.write("column.yaml", COLUMN)?;
    let mut node = stage.start_node(&["column.yaml"], &[])?;
    let followed = follow(&stage.environment, arguments, stage.signals, out);
    let ended = stage.stop_node(&mut node);
    stage.unless_asked()?;
    let (forecast, outcome) = followed.map_err(|failure| node.explain(failure))?;
    print_outcome(&forecast, &outcome, out);
    print_comparison(arguments, out)?;
    stage.unless_asked()?;
    ended?;
    draw(arguments, stage)?;
    let (recording, _) = stage.verify()?;
    let shown = recording.display();
    stage.print_end(
        &recording,
        &[[
            "figures",
            "figures of the paper, energy ledger, paths of the hinges (SVG and PNG)",
        ]],
        &[
            format!("column-twin info {shown}"),
            format!("column-twin export {shown} --csv"),
            "column-twin demo --sensors".to_owned(),
        ],
    );
    Ok(())
}

/// Sends the impact, shows the response, and returns forecast and outcome.
fn follow(
    environment: &Environment,
    arguments: &DemoArgs,
    signals: &StopSignals,
    out: &LinePrinter<'_>,
) -> Result<(ImpactReport, ImpactReport), Failure> {
    let options = ImpactOptions {
        column_id: Some(COLUMN_ID.to_owned()),
        request: ImpactRequest {
            event_id: Some("demo-1".to_owned()),
            vehicle: arguments.vehicle.clone(),
            impact: ImpactSpecification {
                mass: arguments.mass.unwrap_or(f64::NAN),
                velocity: arguments.velocity,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout: TIMEOUT,
            answer_timeout: TIMEOUT,
        },
    };
    let mut narration = Narration::new(out);
    follow_impact(
        environment,
        &options,
        signals,
        &mut |line| out.print(format_args!("{line}\n")),
        &mut |seen, since| narration.take(seen, since),
    )
    .map_err(|error| Failure::plain(Exit::Failed, error))?;
    match (narration.forecast, narration.outcome) {
        (Some(forecast), Some(outcome)) => Ok((forecast, outcome)),
        _ => Err(Failure::plain(
            Exit::Failed,
            "the report arrived without a forecast",
        )),
    }
}

/// Whether the largest of the displacements so far, after which `v1` has fallen, is the peak of the response and no earlier maximum,
/// which only the forecast knows. States are published 1 ms apart, so that the peak itself may be missed by a little.
fn has_peaked(largest: f64, v1: f64, forecast: Option<f64>) -> bool {
    const NEARLY: f64 = 0.99;
    v1 < largest && forecast.is_some_and(|peak| largest >= NEARLY * peak)
}

/// Narrates the response from the messages of the node.
struct Narration<'a, 'b> {
    out: &'a LinePrinter<'b>,
    forecast: Option<ImpactReport>,
    outcome: Option<ImpactReport>,
    /// Peak `v1` so far, and whether the peak has been announced.
    largest: f64,
    peak_announced: bool,
    phase: Option<u8>,
    yielded: [bool; HINGES],
    sheared: [bool; WEBS],
    next_line: f64,
    /// Stamp of the first state, which is that of the event \[ns\].
    event: Option<i64>,
}

impl<'a, 'b> Narration<'a, 'b> {
    fn new(out: &'a LinePrinter<'b>) -> Self {
        Self {
            out,
            forecast: None,
            outcome: None,
            largest: 0.0,
            peak_announced: false,
            phase: None,
            yielded: [false; HINGES],
            sheared: [false; WEBS],
            next_line: 0.0,
            event: None,
        }
    }

    fn take(&mut self, seen: &Seen, since: Duration) {
        match seen {
            Seen::Forecast(report)
                if matches!(
                    report.kind,
                    ImpactReport::WITHDRAWN | ImpactReport::NO_FORECAST
                ) =>
            {
                self.out.print(format_args!(
                    "  no result will follow: {}\n",
                    report.action_reason
                ));
            }
            // The forecast is published again with the range of its verdict.
            Seen::Forecast(report) if let Some(range) = range_of(report) => {
                let mut text = String::new();
                let _ = wrapped(&mut text, "  range", &range); // writing to a String cannot fail
                self.out.print(format_args!("{text}"));
                self.forecast = Some(report.clone());
            }
            // The forecast is published again with the error of its time step.
            Seen::Forecast(report) if self.forecast.is_some() => {
                self.out.print(format_args!(
                    "  the time step makes an error of about {:.1e} of the peak\n",
                    report.error_estimate
                ));
                self.forecast = Some(report.clone());
            }
            Seen::Forecast(report) => {
                self.out.print(format_args!(
                    "  forecast after {:.1} ms ({:.1} ms of computing): peak v1 {:.1} mm, residual {:.1} mm; {}\n{}",
                    1e3 * since.as_secs_f64(),
                    1e3 * report.compute_time,
                    1e3 * report.max_v1,
                    1e3 * report.residual_v1,
                    outcome_text(report),
                    action_text(report)
                ));
                self.forecast = Some(report.clone());
            }
            Seen::Report(report) => self.outcome = Some(report.clone()),
            Seen::State(state) => self.state(state),
            Seen::Forces(forces) => self.forces(forces),
            Seen::Status(_) | Seen::Estimate(_) | Seen::Fleet(_) | Seen::Missed { .. } => {}
        }
    }

    fn state(&mut self, state: &ColumnState) {
        if self.event.is_none() {
            self.event = state.header.stamp.to_nanos();
        }
        let phase_change = match (self.phase.replace(state.phase), state.phase) {
            (Some(before), now) if before == now => None,
            (_, ColumnState::CONTACT) => Some("contact begins"),
            (Some(_), ColumnState::FREE) => Some("separation"),
            (_, ColumnState::REST) => Some("at rest"),
            (_, ColumnState::COLLAPSED) => Some("COLLAPSE"),
            (_, ColumnState::FRACTURED) => Some("FRACTURED"),
            _ => None,
        };
        let expected = self.forecast.as_ref().map(|it| it.max_v1);
        if !self.peak_announced && has_peaked(self.largest, state.v1, expected) {
            self.peak_announced = true;
            self.out.print(format_args!(
                "  {:>8} | {:BAR$} | peak v1: {:.1} mm",
                "",
                "",
                1e3 * self.largest
            ));
        }
        self.largest = self.largest.max(state.v1);
        if phase_change.is_none() && state.time < self.next_line {
            return;
        }
        self.next_line = state.time + LINE_PERIOD - 1e-9;
        let forecast = self.forecast.as_ref().map_or(0.1, |it| it.max_v1);
        let part = (state.v1 / forecast).clamp(0.0, 1.0);
        let bar = "#".repeat((part * BAR as f64).round() as usize);
        self.out.print(format_args!(
            "  {:5.1} ms | {bar:BAR$} | v1 {:6.1} mm  contact {:6.1} kN{}{}",
            1e3 * state.time,
            1e3 * state.v1,
            1e-3 * state.contact_force,
            phase_change.map_or("", |_| "  "),
            phase_change.unwrap_or_default()
        ));
    }

    /// Hinge forces arrive on a topic of their own; their stamp gives their time.
    fn forces(&mut self, forces: &HingeForces) {
        let (Some(event), Some(stamp)) = (self.event, forces.header.stamp.to_nanos()) else {
            return;
        };
        let time = 1e-6 * (stamp - event) as f64;
        let yields = |what: std::fmt::Arguments<'_>| {
            self.out.print(format_args!(
                "  {:>8} | {:BAR$} | {what} at {time:.1} ms",
                "", ""
            ));
        };
        for (hinge, place) in HINGE_PLACES.iter().enumerate() {
            if forces.state.get_or(hinge, HingeForces::ELASTIC) == HingeForces::PLASTIC
                && !self.yielded[hinge]
            {
                self.yielded[hinge] = true;
                yields(format_args!("hinge {place} is yielding"));
            }
        }
        for (web, place) in WEB_PLACES.iter().enumerate() {
            if forces.web_state.get_or(web, HingeForces::ELASTIC) == HingeForces::PLASTIC
                && !self.sheared[web]
            {
                self.sheared[web] = true;
                yields(format_args!("the web {} is shearing", place.words));
            }
        }
    }
}

fn print_outcome(forecast: &ImpactReport, outcome: &ImpactReport, out: &LinePrinter<'_>) {
    out.print(format_args!(
        "\n  {:22}{:>14}{:>14}",
        "", "forecast", "outcome"
    ));
    let row = |name: &str, unit: &str, of: fn(&ImpactReport) -> f64| {
        out.print(format_args!(
            "  {name:22}{:>11.3} {unit:2}{:>11.3} {unit:2}",
            of(forecast),
            of(outcome)
        ));
    };
    row("peak v1", "mm", |it| 1e3 * it.max_v1);
    row("residual v1", "mm", |it| 1e3 * it.residual_v1);
    row("last separation", "ms", |it| 1e3 * it.release_time);
    row("peak contact force", "kN", |it| {
        1e-3 * it.peak_contact_force
    });
    row("plastic work", "kJ", |it| 1e-3 * it.plastic_work);
    out.print("");
}

/// Prints what the paper's model, which only bends, says of the same hit.
fn print_comparison(arguments: &DemoArgs, out: &LinePrinter<'_>) -> Result<(), Failure> {
    let column = Parameters::from_yaml(Path::new("column.yaml"), COLUMN)?;
    let struck = column.with_changes(arguments.changes())?;
    let evaluated = |shear: &str| -> Result<ImpactEvaluation, Failure> {
        let parameters = struck.with_changes([("shear.model", Value::from(shear))])?;
        let (properties, impact) = (parameters.column_properties(), parameters.impact());
        respond_and_rest(&properties, &impact, parameters.response_duration())
            .and_then(|ended| ImpactEvaluation::complete(&parameters, &properties, &impact, ended))
            .map_err(|error| Failure::plain(Exit::Failed, error))
    };
    let both = [evaluated("none")?, evaluated("web")?];
    out.print(format_args!(
        "  The column was hit near its base, where its web yields in shear before it bends.\n  \
         The paper's model has no shear. The same hit without and with it:\n"
    ));
    let row = |name: &str, words: fn(&ImpactEvaluation) -> String| {
        let [bending, sheared] = both.each_ref().map(words);
        out.print(format_args!("  {name:26}{bending:>20}{sheared:>20}"));
    };
    out.print(format_args!(
        "  {:26}{:>20}{:>20}",
        "", "bending only", "with shear"
    ));
    row("peak v1", |it| format!("{:.2} mm", 1e3 * it.report.max_v1));
    row("residual v1", |it| {
        let residual = it.report.residual_v1;
        residual.map_or("none".to_owned(), |v1| format!("{:.2} mm", 1e3 * v1))
    });
    row("hinges that yield", |it| {
        let hinges = it.report.hinges.iter();
        format!(
            "{} of {HINGES}",
            hinges.filter(|it| it.first_yield.is_some()).count()
        )
    });
    row("shear angle of the web", |it| {
        format!("{:.3} rad", it.report.webs[0].plastic_angle)
    });
    row("crush of the front", |it| match it.report.vehicle.masses {
        0 => "none".to_owned(),
        _ => format!("{:.0} mm", 1e3 * it.report.vehicle.max_crush[0]),
    });
    row("absorbed by the vehicle", |it| {
        let absorbed: f64 = it.report.vehicle.dissipated.iter().sum();
        format!("{:.0} %", 100.0 * absorbed / it.report.input_energy)
    });
    row("action", |it| {
        let assessment = it.assessment.as_ref();
        assessment.map_or("not assessed".to_owned(), |it| it.action.to_string())
    });
    row("decided by", |it| {
        let assessment = it.assessment.as_ref();
        assessment
            .map_or("nothing", |it| it.deciding_criterion)
            .to_owned()
    });
    out.print("");
    Ok(())
}

/// Draws the figures of the same impact with the command that a user would run.
fn draw(arguments: &DemoArgs, stage: &Stage<'_, '_>) -> Result<(), Failure> {
    let inside = |name: &str| stage.folder.join(name).display().to_string();
    let command = [
        "simulate".to_owned(),
        "--config".to_owned(),
        inside("column.yaml"),
        "--vehicle".to_owned(),
        arguments.vehicle.clone(),
        "--velocity".to_owned(),
        arguments.velocity.to_string(),
        "--figures".to_owned(),
        inside("figures"),
    ];
    let mass = arguments
        .mass
        .map(|mass| ["--mass".to_owned(), mass.to_string()]);
    let command = [&command[..], mass.as_slice().as_flattened()].concat();
    stage.run("figures", &command, "the figures")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 21 ms the demonstration announced a peak of 0.7 mm, where the front was still soft, and 39.2 mm followed.
    #[test]
    fn the_demonstration_announces_no_earlier_maximum_as_the_peak() {
        let forecast = Some(39.191e-3);
        assert!(!has_peaked(0.72e-3, 0.71e-3, forecast));
        assert!(!has_peaked(0.72e-3, 0.71e-3, None));
        assert!(!has_peaked(39.19e-3, 39.19e-3, forecast));
        assert!(has_peaked(39.16e-3, 39.1e-3, forecast));
    }
}
