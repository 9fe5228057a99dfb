//! `column-twin impact`: publishes one impact event, as a sensor would.

use std::io::Write;
use std::time::Duration;

use clap::Args;

use super::failure::{Exit, Failure, LinePrinter};
use super::impact_args::ImpactSpecificationArgs;
use super::run::client_environment;
use super::transport::TransportArgs;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::ros::{
    ClientError, ImpactOptions, ImpactOutcome, ImpactRequest, RosArguments, RowImpactOptions,
    report_line, send_impact, send_row_impact,
};
use column_twin::twin::event_id_fault;

/// Arguments of `column-twin impact`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
#[command(mut_arg("mass", |it| it.help(MASS)), mut_arg("velocity", |it| it.required(true)))]
pub struct ImpactArgs {
    #[command(flatten)]
    impact: ImpactSpecificationArgs,
    /// Parameter column_id of the column that is hit; default: the only twin
    #[arg(long, value_name = "ID")]
    column: Option<String>,
    /// Columns of a fleet that the vehicle hits one after another, in their order, separated by commas
    #[arg(
        long,
        value_name = "ID,ID",
        value_delimiter = ',',
        conflicts_with = "column"
    )]
    row: Vec<String>,
    /// Distance from each column of --row to the next [m], one for all or one for each; the vehicle hits the next column with its residual motion
    #[arg(
        long,
        value_name = "M",
        value_delimiter = ',',
        requires = "row",
        conflicts_with = "offsets"
    )]
    distance: Vec<f64>,
    /// Times of the impacts on the columns of --row after the first one [s], such as 0,0.4,0.8
    #[arg(long, value_name = "S,S", value_delimiter = ',', requires = "row")]
    offsets: Vec<f64>,
    /// Identifier of the event; default: a new one
    #[arg(long, value_name = "ID")]
    event: Option<String>,
    /// Maximum wait for a twin, and for its forecast [s]
    #[arg(long, value_name = "S", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=3600))]
    timeout: u16,
    #[command(flatten)]
    transport: TransportArgs,
}

/// What an event without a mass means; the help of other commands has the parameters of a file in mind.
const MASS: &str =
    "Total mass of the vehicle [kg]; default: its own mass, which a rigid vehicle does not have";

const EXAMPLE: &str = "\
The defaults are parameters of the twin.

Example: 1.5 t of the twin's vehicle at 36 km/h
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --mass 1500 --velocity 10
Example: a van of its own mass at 50 km/h
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --vehicle van --velocity 13.9
Example: a lorry along a row of columns of a fleet, 5 m from one another, as far as it gets
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin impact --row b1,b2,b3 --distance 5 --vehicle lorry_16t --velocity 20

Exit codes: 0 accepted, 1 rejected or no answer from a twin, 2 bad input or usage.";

/// Publishes the event and prints the forecast.
pub fn run(
    arguments: &ImpactArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    if let Some(reason) = arguments.event.as_deref().and_then(event_id_fault) {
        return Err(Failure::plain(Exit::BadInput, format!("--event: {reason}")));
    }
    if !arguments.row.is_empty() {
        return run_row(arguments, ros, out);
    }
    let options = ImpactOptions {
        column_id: arguments.column.clone(),
        request: request(arguments)?,
    };
    let lines = LinePrinter::new(out);
    let mut say = |line: &str| lines.print(line);
    let outcome = send_impact(
        &client_environment(ros, arguments.transport)?,
        &ros.remap_rules,
        &options,
        &mut say,
    )
    .map_err(failure)?;
    match outcome {
        ImpactOutcome::Forecast(report) => {
            lines.print(report_line("forecast", &report));
            lines.end()
        }
        ImpactOutcome::NoForecast(reason) => {
            lines.print(format_args!("accepted, without a forecast: {reason}"));
            lines.end()
        }
        ImpactOutcome::Rejected(reason) => Err(Failure::plain(
            Exit::Failed,
            format!("the twin rejected the event: {reason}"),
        )),
    }
}

fn request(arguments: &ImpactArgs) -> Result<ImpactRequest, Failure> {
    let timeout = Duration::from_secs(u64::from(arguments.timeout));
    Ok(ImpactRequest {
        event_id: arguments.event.clone(),
        vehicle: arguments.impact.vehicle().unwrap_or_default().to_owned(),
        impact: arguments.impact.specification()?,
        match_timeout: timeout,
        answer_timeout: timeout,
    })
}

fn failure(error: ClientError) -> Failure {
    let exit = match error {
        ClientError::Name(_) | ClientError::SeveralColumns(_) => Exit::BadInput,
        _ => Exit::Failed,
    };
    Failure::plain(exit, error)
}

/// Publishes the event for several columns and prints the answer of each.
fn run_row(
    arguments: &ImpactArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let options = RowImpactOptions {
        column_ids: arguments.row.clone(),
        offsets: arguments.offsets.clone(),
        distances: distances(arguments)?,
        request: request(arguments)?,
    };
    let lines = LinePrinter::new(out);
    let mut say = |line: &str| lines.print(line);
    let environment = client_environment(ros, arguments.transport)?;
    let answers =
        send_row_impact(&environment, &ros.remap_rules, &options, &mut say).map_err(failure)?;
    let is_rejected = |it: &ImpactReport| {
        (it.kind, it.end) == (ImpactReport::NO_FORECAST, ImpactReport::END_REJECTED)
    };
    // An event that is rejected as a whole has one reason for all columns; several reasons are told below.
    if answers.iter().all(is_rejected)
        && let Some((first, others)) = answers.split_first()
        && others
            .iter()
            .all(|it| it.action_reason == first.action_reason)
    {
        let text = format!("the fleet rejected the event: {}", first.action_reason);
        return Err(Failure::plain(Exit::Failed, text));
    }
    let mut rejected = Vec::new();
    for report in answers {
        let column = &report.column_id;
        match (report.kind, report.end) {
            (ImpactReport::NO_FORECAST, ImpactReport::END_REJECTED) => {
                rejected.push(report.action_reason);
            }
            (ImpactReport::NO_FORECAST, ImpactReport::END_NOT_HIT) => {
                lines.print(format_args!("{column}: not hit: {}", report.action_reason))
            }
            (ImpactReport::NO_FORECAST | ImpactReport::WITHDRAWN, _) => lines.print(format_args!(
                "{column}: without a forecast: {}",
                report.action_reason
            )),
            _ => lines.print(format_args!(
                "{column}: {}",
                report_line("forecast", &report)
            )),
        }
    }
    match rejected[..] {
        [] => lines.end(),
        _ => Err(Failure::plain(Exit::Failed, rejected.join("; "))),
    }
}

/// The distance of each column from the one before, NaN for the first.
fn distances(arguments: &ImpactArgs) -> Result<Vec<f64>, Failure> {
    let further = arguments.row.len() - 1;
    let given = &arguments.distance;
    let of_each = match given[..] {
        [] if further == 0 || !arguments.offsets.is_empty() => return Ok(Vec::new()),
        [one] => vec![one; further],
        _ if given.len() == further => given.clone(),
        _ => {
            let text = format!(
                "--row names {} columns and --distance {} distances; give one distance for all, one from each column to the next, or \
                 the times of the impacts with --offsets",
                arguments.row.len(),
                given.len()
            );
            return Err(Failure::plain(Exit::BadInput, text));
        }
    };
    Ok(std::iter::once(f64::NAN).chain(of_each).collect())
}
