//! `column-twin impact`: one impact event, as a sensor would publish it.

use std::io::Write;
use std::time::Duration;

use clap::Args;

use super::{Exit, Failure, Lines, run::environment};
use crate::parameters::Parameters;
use crate::ros::{
    ClientError, ImpactOptions, ImpactOutcome, RosArguments, report_line, send_impact,
};

/// What `column-twin impact` is told.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct ImpactArgs {
    /// Mass of the vehicle [kg]
    #[arg(long, value_name = "KG")]
    mass: f64,
    /// Speed of the vehicle over the ground [m/s]
    #[arg(long, value_name = "M/S")]
    velocity: f64,
    /// Distance from the column at the instant of the event [m]; default: the twin's impact.gap
    #[arg(long, value_name = "M")]
    gap: Option<f64>,
    /// Coefficient of restitution [-], 0 to 1; default: the twin's impact.restitution
    #[arg(long, value_name = "E")]
    restitution: Option<f64>,
    /// Height of the impact point above the base [m]; default: the twin's geometry.length_below
    #[arg(long, value_name = "M")]
    height: Option<f64>,
    /// Which column is hit; default: the column_id of a twin that was not told another
    #[arg(long, value_name = "ID")]
    column: Option<String>,
    /// Name of the event; default: one that nobody has used
    #[arg(long, value_name = "ID")]
    event: Option<String>,
    /// How long to wait for a twin, and for its forecast [s]
    #[arg(long, value_name = "S", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=3600))]
    timeout: u16,
}

const EXAMPLE: &str = "\
Example: a car of 1.5 t at 36 km/h
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --mass 1500 --velocity 10

Exit codes: 0 accepted, 1 refused or no twin answered, 2 bad input or usage.";

/// Publishes the event and prints the forecast.
pub fn run(
    arguments: &ImpactArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let column_id = match &arguments.column {
        Some(id) => id.clone(),
        None => Parameters::default().settings().column_id.clone(),
    };
    let patience = Duration::from_secs(u64::from(arguments.timeout));
    let options = ImpactOptions {
        column_id,
        event_id: arguments.event.clone(),
        mass: arguments.mass,
        velocity: arguments.velocity,
        gap: arguments.gap,
        restitution: arguments.restitution,
        height: arguments.height,
        match_timeout: patience,
        answer_timeout: patience,
    };
    let lines = Lines::new(out);
    let mut say = |line: &str| lines.say(line);
    let outcome =
        send_impact(&environment()?, &ros.remap_rules, &options, &mut say).map_err(|error| {
            let exit = match error {
                ClientError::Name(_) => Exit::BadInput,
                _ => Exit::Failed,
            };
            Failure::plain(exit, error)
        })?;
    match outcome {
        ImpactOutcome::Forecast(report) => {
            lines.say(report_line("forecast", &report));
            lines.end()
        }
        ImpactOutcome::Refused(reason) => Err(Failure::plain(
            Exit::Failed,
            format!("the twin refused the event: {reason}"),
        )),
    }
}
