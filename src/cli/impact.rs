//! `column-twin impact`: publishes one impact event, as a sensor would.

use std::io::Write;
use std::time::Duration;

use clap::Args;

use super::failure::{Exit, Failure, LinePrinter};
use super::impact_args::ImpactSpecificationArgs;
use super::run::client_environment;
use column_twin::ros::{
    ClientError, ImpactOptions, ImpactOutcome, RosArguments, report_line, send_impact,
};

/// Arguments of `column-twin impact`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
#[command(mut_arg("mass", |it| it.required_unless_present("vehicle")), mut_arg("velocity", |it| it.required(true)))]
pub struct ImpactArgs {
    #[command(flatten)]
    impact: ImpactSpecificationArgs,
    /// Parameter column_id of the column that is hit; default: that of the only twin
    #[arg(long, value_name = "ID")]
    column: Option<String>,
    /// Identifier of the event; default: a new one
    #[arg(long, value_name = "ID")]
    event: Option<String>,
    /// Maximum wait for a twin, and for its forecast [s]
    #[arg(long, value_name = "S", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=3600))]
    timeout: u16,
}

const EXAMPLE: &str = "\
The parameters named as defaults are those of the twin.

Example: 1.5 t of the twin's vehicle at 36 km/h
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --mass 1500 --velocity 10
Example: a van of its own mass at 50 km/h
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --vehicle van --velocity 13.9

Exit codes: 0 accepted, 1 rejected or no answer from a twin, 2 bad input or usage.";

/// Publishes the event and prints the forecast.
pub fn run(
    arguments: &ImpactArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let timeout = Duration::from_secs(u64::from(arguments.timeout));
    let options = ImpactOptions {
        column_id: arguments.column.clone(),
        event_id: arguments.event.clone(),
        vehicle: arguments.impact.vehicle().unwrap_or_default().to_owned(),
        impact: arguments.impact.specification(),
        match_timeout: timeout,
        answer_timeout: timeout,
    };
    let lines = LinePrinter::new(out);
    let mut say = |line: &str| lines.print(line);
    let outcome = send_impact(
        &client_environment(ros)?,
        &ros.remap_rules,
        &options,
        &mut say,
    )
    .map_err(|error| {
        let exit = match error {
            ClientError::Name(_) | ClientError::SeveralColumns(_) => Exit::BadInput,
            _ => Exit::Failed,
        };
        Failure::plain(exit, error)
    })?;
    match outcome {
        ImpactOutcome::Forecast(report) => {
            lines.print(report_line("forecast", &report));
            lines.end()
        }
        ImpactOutcome::NoForecast(reason) => {
            lines.print(format_args!("accepted, without a forecast: {reason}"));
            lines.end()
        }
        ImpactOutcome::Refused(reason) => Err(Failure::plain(
            Exit::Failed,
            format!("the twin rejected the event: {reason}"),
        )),
    }
}
