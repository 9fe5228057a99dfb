//! `column-twin alarm`: tries whether alarms arrive.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::failure::{Exit, Failure, LinePrinter};
use super::run::{environment, failure_of_run};
use column_twin::ros::{RosArguments, RunOptions, try_alarms};

/// Arguments of `column-twin alarm`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct AlarmArgs {
    #[command(subcommand)]
    command: AlarmCommand,
}

#[derive(Debug, Subcommand)]
enum AlarmCommand {
    /// Send a test message by each way that the parameters alarm.* describe, and tell which arrived
    Test(TestArgs),
}

/// Arguments of `column-twin alarm test`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct TestArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: the files with which the node runs
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
}

const EXAMPLE: &str = "\
Example: the receivers of a parameter file, with another broker
  column-twin alarm test --config garage.yaml --ros-args -p alarm.mqtt.broker:=mqtts://broker.example:8883

The message has the state \"test\", so that nobody takes it for an alarm. A node may run meanwhile.
Exit codes: 0 every receiver has acknowledged it, 1 a receiver has not, 2 bad input or usage.";

/// Sends the messages and prints what became of them.
pub fn run(arguments: &AlarmArgs, ros: RosArguments, out: &mut dyn Write) -> Result<(), Failure> {
    let AlarmCommand::Test(arguments) = &arguments.command;
    let options = RunOptions {
        environment: environment(&ros)?,
        ros,
        parameter_files: arguments.config.clone(),
        columns: None,
        managed: false,
    };
    let tried = try_alarms(&options).map_err(failure_of_run)?;
    let Some(tried) = tried else {
        return Err(Failure::plain(
            Exit::BadInput,
            "no receiver of alarms is given; set alarm.mqtt.broker or alarm.webhook.url (docs/alarms.md)",
        ));
    };
    let printer = LinePrinter::new(out);
    for (name, result) in &tried {
        match result {
            Ok(()) => printer.print(format_args!("{name}: acknowledged")),
            Err(fault) => printer.print(format_args!("{name}: failed: {fault}")),
        }
    }
    printer.end()?;
    match tried.iter().filter(|(_, result)| result.is_err()).count() {
        0 => Ok(()),
        failed => Err(Failure::plain(
            Exit::Failed,
            format!(
                "{failed} of {} receivers did not take the message",
                tried.len()
            ),
        )),
    }
}
