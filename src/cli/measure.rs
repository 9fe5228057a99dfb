//! `column-twin measure`: publishes readings of sensors, as the drivers of the sensors would.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::failure::{Exit, Failure, LinePrinter};
use super::impact_args::ImpactSpecificationArgs;
use super::run::client_environment;
use super::simulate::parameters_of;
use super::transport::TransportArgs;
use column_twin::estimation::Readings;
use column_twin::ros::{ClientError, MeasureOptions, RosArguments, send_measurements};

/// Arguments of `column-twin measure`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct MeasureArgs {
    /// Table of readings in CSV, as of `column-twin simulate --readings`: time [s], then one column for each sensor
    #[arg(value_name = "READINGS.csv")]
    readings: PathBuf,
    /// Parameter file (ROS 2 YAML) that declares the sensors, may be repeated: later files win
    #[arg(long, short, value_name = "FILE", required = true)]
    config: Vec<PathBuf>,
    /// Any parameter in the notation of ROS 2, for example -p column_id:=a3; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    parameter: Vec<String>,
    /// Duration of a batch [ms]
    #[arg(long, value_name = "MS", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=1000))]
    batch: u16,
    /// Maximum wait for a twin with sensors [s]
    #[arg(long, value_name = "S", default_value = "10", value_parser = clap::value_parser!(u16).range(1..=3600))]
    timeout: u16,
    #[command(flatten)]
    transport: TransportArgs,
}

const EXAMPLE: &str = "\
The first row is published as if it were measured now, and each batch when its last sample would
have been taken. The twin needs the same sensors in its parameters.

Example: a simulated impact of 1.5 t at 36 km/h, for a twin in another terminal
  column-twin simulate --config config/heb220_s355.yaml --config config/sensors_industrial.yaml --mass 1500 --velocity 10 --readings readings.csv
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin measure readings.csv --config config/heb220_s355.yaml \\
    --config config/sensors_industrial.yaml

Exit codes: 0 sent, 1 no twin with sensors, 2 bad input or usage, 3 sent, but some batches were
lost.";

/// Publishes the readings.
pub fn run(
    arguments: &MeasureArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let parameters = parameters_of(
        &arguments.config,
        &arguments.parameter,
        &ImpactSpecificationArgs::default(),
    )?;
    let sensors = parameters.sensors();
    if sensors.is_empty() {
        return Err(Failure::plain(
            Exit::BadInput,
            "the parameters declare no sensors; give a file with sensors.names, such as config/sensors_industrial.yaml",
        ));
    }
    let path = arguments.readings.display();
    let file = File::open(&arguments.readings).map_err(|reason| {
        Failure::plain(Exit::BadInput, format!("cannot read {path}: {reason}"))
    })?;
    let readings = Readings::from_csv(BufReader::new(file), &sensors)
        .map_err(|fault| Failure::plain(Exit::BadInput, format!("{path}: {fault}")))?;
    let options = MeasureOptions {
        column_id: parameters.settings().column_id.clone(),
        sensors,
        readings,
        batch: Duration::from_millis(u64::from(arguments.batch)),
        match_timeout: Duration::from_secs(u64::from(arguments.timeout)),
    };
    let lines = LinePrinter::new(out);
    let environment = client_environment(ros, arguments.transport)?;
    let mut say = |line: &str| lines.print(line);
    let measured =
        send_measurements(&environment, &ros.remap_rules, &options, &mut say).map_err(|error| {
            let exit = match error {
                ClientError::Name(_) | ClientError::TooLong { .. } => Exit::BadInput,
                _ => Exit::Failed,
            };
            let hint = match error {
                ClientError::NoTwin { .. } => {
                    "; a twin subscribes only if its parameters declare sensors"
                }
                _ => "",
            };
            Failure::plain(exit, format!("{error}{hint}"))
        })?;
    lines.print(format_args!(
        "sent {} samples in {} batches",
        measured.samples, measured.batches
    ));
    match measured.failed {
        0 => lines.end(),
        failed => Err(Failure::plain(
            Exit::Lossy,
            format!("{failed} batches could not be sent"),
        )),
    }
}
