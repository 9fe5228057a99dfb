//! The command line.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - alarm.rs: `column-twin alarm`: tries whether alarms arrive
// - capacity.rs: `column-twin capacity`: the axial capacity of the column, undamaged and as it is, and what follows for its
//   load
// - demo/: `column-twin demo`: one impact from the event to the verified recording, on this machine and with nothing installed
// - estimate.rs: `column-twin estimate`: what struck the column and what remains of it, from the readings of its sensors
// - export.rs: `column-twin export`: exports the messages of a recording as tables or as JSON
// - failure.rs: How a command ends: exit codes, failures, and printing
// - fleet.rs: `column-twin fleet`: runs many columns as one ROS 2 node
// - fleet_study.rs: The columns of a fleet as the object of a study
// - history.rs: The history of a response as a table
// - idl.rs: `column-twin idl`: the topics of the node for DDS programs without ROS
// - impact.rs: `column-twin impact`: publishes one impact event, as a sensor would
// - impact_args.rs: The options that specify an impact
// - info.rs: `column-twin info`: summarises a recording
// - interruption.rs: A study on a terminal: progress while it runs, and Ctrl-C
// - keystore.rs: `column-twin keystore`: keys, certificates and permissions for DDS security
// - keystore_absent.rs: `column-twin keystore` in a program without DDS security: explains how to build one with it
// - map/: `column-twin map`: what impacts on a column lead to, over a plane of two quantities
// - measure.rs: `column-twin measure`: publishes readings of sensors, as the drivers of the sensors would
// - recorded_detected.rs: What the sensors of a recorded twin have detected, for the viewer: its measurements, and its
//   estimates with their records
// - recorded_items.rs: The items of a recording for the viewer: states with their hinges, reports, and the parameters of the
//   column
// - recorded_readings.rs: The arguments of the commands that look at recorded readings, and the table that they name
// - repair.rs: `column-twin repair`: repairs a recording that was cut off or damaged
// - replay.rs: `column-twin replay`: publishes a recording over DDS, or shows it in the viewer
// - report.rs: `column-twin report`: a report about the impacts of a recording, for people
// - risk/: `column-twin risk`: how often vehicles that leave the road damage the column, and how severely
// - run.rs: `column-twin run`: runs the twin as a ROS 2 node
// - sensors.rs: `column-twin sensors check`: the sensors on the column at commissioning, against what the model says of its
//   vibration
// - simulate.rs: `column-twin simulate`: the response of the column to one impact
// - summary.rs: The summary of one impact, for a person and for programs
// - tell.rs: Lines on standard error, which may be closed: the exit code stays what it is
// - threads.rs: The option `--threads` of the studies
// - transport.rs: The option `--transport` of the commands that take part in ROS 2
// - vehicles.rs: `column-twin vehicles`: the catalogue of vehicles with the source of every number
// - verify.rs: `column-twin verify`: verifies a recording by recomputation
// - watch.rs: `column-twin watch`: prints what a running twin or a fleet publishes

#[macro_use]
mod tell;

#[cfg(feature = "alarm")]
mod alarm;
mod capacity;
#[cfg(test)]
mod capacity_tests;
#[cfg(all(feature = "ros", feature = "record"))]
mod demo;
mod estimate;
#[cfg(feature = "record")]
mod export;
mod failure;
#[cfg(feature = "ros")]
mod fleet;
mod fleet_study;
mod history;
#[cfg(feature = "ros")]
mod idl;
#[cfg(feature = "ros")]
mod impact;
mod impact_args;
#[cfg(feature = "record")]
mod info;
mod interruption;
#[cfg_attr(not(feature = "security"), path = "keystore_absent.rs")]
mod keystore;
mod map;
#[cfg(feature = "ros")]
mod measure;
#[cfg(all(feature = "ros", feature = "record", feature = "viewer"))]
mod recorded_detected;
#[cfg(all(feature = "ros", feature = "record", feature = "viewer"))]
mod recorded_items;
mod recorded_readings;
#[cfg(test)]
#[path = "../figures/reference.rs"]
#[expect(dead_code, reason = "the tests of the figures use more of it")]
mod reference;
#[cfg(feature = "record")]
mod repair;
#[cfg(all(feature = "ros", feature = "record"))]
mod replay;
#[cfg(feature = "record")]
mod report;
mod risk;
#[cfg(feature = "ros")]
mod run;
mod sensors;
mod simulate;
#[cfg(test)]
mod simulate_tests;
mod summary;
mod threads;
#[cfg(feature = "ros")]
mod transport;
mod vehicles;
#[cfg(feature = "record")]
mod verify;
#[cfg(feature = "ros")]
mod watch;

use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
#[cfg(any(feature = "ros", feature = "record"))]
use printable::PrintableWriter;

use capacity::CapacityArgs;
#[cfg(feature = "ros")]
use failure::Exit;
use simulate::SimulateArgs;

/// Digital twin of a steel column hit by a vehicle.
#[derive(Debug, Parser)]
#[command(name = "column-twin", version, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: CliCommand,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 bad input or usage, 3 done in part: data were lost, the command was
interrupted, or a part could not be computed or verified. Each command states the details.";

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Demonstrate everything on this machine: node, impact, forecast, recording, figures, verification
    #[cfg(all(feature = "ros", feature = "record"))]
    Demo(demo::DemoArgs),
    /// Simulate one impact without ROS and summarise the response of the column
    Simulate(SimulateArgs),
    /// Compute the axial capacity of the column, undamaged and damaged, and assess the remainder
    Capacity(CapacityArgs),
    /// Estimate the vehicle and the damage of the column from the readings of its sensors
    Estimate(estimate::EstimateArgs),
    /// Check the sensors at commissioning: signs, gains, heights, exchanges, rates; fit the stiffness of the supports
    Sensors(sensors::SensorsArgs),
    /// Map the effects of impacts over two quantities, such as mass and velocity: action, displacement, capacity
    Map(map::MapArgs),
    /// Compute how often vehicles that leave the road damage the column, and how severely: probabilities with intervals
    Risk(risk::RiskArgs),
    /// List the vehicles of the catalogue with the source of every number
    Vehicles(vehicles::VehiclesArgs),
    /// Run the twin as a ROS 2 node, until Ctrl-C
    #[cfg(feature = "ros")]
    Run(run::RunArgs),
    /// Run many columns as one ROS 2 node, until Ctrl-C
    #[cfg(feature = "ros")]
    Fleet(fleet::FleetArgs),
    /// Publish one impact event and print the forecast of the twin
    #[cfg(feature = "ros")]
    Impact(impact::ImpactArgs),
    /// Publish a table of readings as the sensors on the column would, in real time
    #[cfg(feature = "ros")]
    Measure(measure::MeasureArgs),
    /// Publish the messages of a recording over DDS with their recorded timing
    #[cfg(all(feature = "ros", feature = "record"))]
    Replay(replay::ReplayArgs),
    /// Verify a recording by recomputation, bit for bit
    #[cfg(feature = "record")]
    Verify(verify::VerifyArgs),
    /// Print the messages of a running twin, until Ctrl-C
    #[cfg(feature = "ros")]
    Watch(watch::WatchArgs),
    /// Print the topics and messages of the node as OMG IDL, for DDS programs without ROS
    #[cfg(feature = "ros")]
    Idl(idl::IdlArgs),
    /// Try whether alarms arrive
    #[cfg(feature = "alarm")]
    Alarm(alarm::AlarmArgs),
    /// Make and maintain keys, certificates and permissions for DDS security
    Keystore(keystore::KeystoreArgs),
    /// Summarise a recording: topics, impacts with their outcomes, losses
    #[cfg(feature = "record")]
    Info(info::InfoArgs),
    /// Write an HTML report about the impacts of a recording, verified by recomputation
    #[cfg(feature = "record")]
    Report(report::ReportArgs),
    /// Repair a recording that was cut off or damaged; the original is kept
    #[cfg(feature = "record")]
    Repair(repair::RepairArgs),
    /// Export the messages of a recording as CSV or JSON
    #[cfg(feature = "record")]
    Export(export::ExportArgs),
}

/// Runs the command given by the arguments, of which the first is the name of the program. Results go to the standard
/// output, errors to the standard error.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    // Lines are not wrapped, so that paths and names can be copied. A hook that is already set is kept.
    let _ = miette::set_hook(Box::new(|_| {
        Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())
    }));
    #[cfg(feature = "ros")]
    let (arguments, ros) = match column_twin::ros::RosArguments::split(arguments) {
        Ok(split) => split,
        Err(faults) => {
            for fault in faults {
                let fault = fault.to_string();
                tell!("{}", printable::PrintableLines(&fault));
            }
            return ExitCode::from(Exit::BadInput as u8);
        }
    };
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(request) => {
            // This is also how clap answers a request for help or the version. A failure to print cannot be reported.
            let _ = request.print();
            #[cfg(feature = "ros")]
            if let Some(hint) = ros_arguments_hint(&request) {
                tell!("{hint}");
            }
            return u8::try_from(request.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from);
        }
    };
    let ended = match &cli.command {
        #[cfg(all(feature = "ros", feature = "record"))]
        CliCommand::Demo(arguments) => demo::run(arguments, &mut shown()),
        CliCommand::Simulate(arguments) => simulate::run(arguments, &mut io::stdout().lock()),
        CliCommand::Capacity(arguments) => capacity::run(arguments, &mut io::stdout().lock()),
        CliCommand::Estimate(arguments) => estimate::run(arguments, &mut io::stdout().lock()),
        CliCommand::Sensors(arguments) => sensors::run(arguments, &mut io::stdout().lock()),
        CliCommand::Map(arguments) => map::run(arguments, &mut io::stdout().lock()),
        CliCommand::Risk(arguments) => risk::run(arguments, &mut io::stdout().lock()),
        CliCommand::Vehicles(arguments) => vehicles::run(arguments, &mut io::stdout().lock()),
        #[cfg(all(feature = "ros", feature = "record"))]
        CliCommand::Replay(arguments) => replay::run(arguments, &ros, &mut shown()),
        #[cfg(feature = "record")]
        CliCommand::Verify(arguments) => verify::run(arguments, &mut shown()),
        #[cfg(feature = "ros")]
        CliCommand::Run(arguments) => run::run(arguments, ros),
        #[cfg(feature = "ros")]
        CliCommand::Fleet(arguments) => fleet::run(arguments, ros),
        #[cfg(feature = "ros")]
        CliCommand::Impact(arguments) => impact::run(arguments, &ros, &mut shown()),
        #[cfg(feature = "ros")]
        CliCommand::Measure(arguments) => measure::run(arguments, &ros, &mut shown()),
        #[cfg(feature = "ros")]
        CliCommand::Watch(arguments) => watch::run(arguments, &ros, &mut shown()),
        #[cfg(feature = "ros")]
        CliCommand::Idl(arguments) => idl::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "alarm")]
        CliCommand::Alarm(arguments) => alarm::run(arguments, ros, &mut shown()),
        #[cfg(feature = "security")]
        CliCommand::Keystore(arguments) => keystore::run(arguments, &ros, &mut io::stdout().lock()),
        #[cfg(not(feature = "security"))]
        CliCommand::Keystore(arguments) => keystore::run(arguments),
        #[cfg(feature = "record")]
        CliCommand::Info(arguments) => info::run(arguments, &mut io::stdout().lock()),
        #[cfg(feature = "record")]
        CliCommand::Report(arguments) => report::run(arguments, &mut shown()),
        #[cfg(feature = "record")]
        CliCommand::Repair(arguments) => repair::run(arguments, &mut shown()),
        #[cfg(feature = "record")]
        CliCommand::Export(arguments) => export::run(arguments, &mut io::stdout().lock()),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tell!("{:?}", failure.report);
            ExitCode::from(failure.exit as u8)
        }
    }
}

/// The standard output of a command that prints names from outside for people.
#[cfg(any(feature = "ros", feature = "record"))]
fn shown() -> PrintableWriter<io::StdoutLock<'static>> {
    PrintableWriter(io::stdout().lock())
}

/// What to do about a ROS argument among the program's own arguments.
#[cfg(feature = "ros")]
fn ros_arguments_hint(error: &clap::Error) -> Option<String> {
    use clap::error::{ContextKind, ContextValue};
    let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    column_twin::ros::RosArguments::knows(argument).then(|| {
        format!(
            "\n{argument} is a ROS argument; put it after --ros-args, such as: \
             column-twin run --ros-args -p top.load:=4.0e5"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[cfg(feature = "ros")]
    #[test]
    fn a_ros_argument_without_ros_args_gets_a_hint() {
        let hint = |line: &str| {
            let error = Cli::try_parse_from(line.split(' ')).expect_err(line);
            ros_arguments_hint(&error)
        };
        for line in [
            "column-twin run -p top.load:=4.0e5",
            "column-twin run --params-file f.yaml",
            "column-twin watch -r __ns:=/garage",
            "column-twin impact --mass 1 --velocity 2 --log-level debug",
        ] {
            let hint = hint(line).expect(line);
            assert!(hint.contains("put it after --ros-args"), "{hint}");
        }
        for line in [
            "column-twin run --confg f.yaml",
            "column-twin walk",
            "column-twin run x",
        ] {
            assert_eq!(hint(line), None, "{line}");
        }
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_option_has_a_help_text() {
        for command in Cli::command().get_subcommands() {
            for option in command.get_arguments() {
                assert!(
                    option.get_help().is_some(),
                    "{} {}",
                    command.get_name(),
                    option.get_id()
                );
            }
        }
    }
}
