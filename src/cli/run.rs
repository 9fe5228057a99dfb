//! `column-twin run`: the twin as a ROS 2 node.

use std::path::PathBuf;

use clap::Args;

use super::{Exit, Failure};
use crate::ros::{self, Environment, RosArguments, RunError, RunOptions};

/// What `column-twin run` is told besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct RunArgs {
    /// Parameter file (ROS 2 YAML), read before those of --params-file; several are read in turn
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,
}

const EXAMPLE: &str = "\
Example: the column of a file, in a namespace, on this machine only
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin run --config config/heb220_s355.yaml \\
    --ros-args -r __ns:=/garage -p top.load:=4.0e5

All that stands behind --ros-args is as in every ROS 2 node: -r, -p, --params-file, --log-level.
With -p record.mode:=always it records all that it receives and sends; -p record.directory:=DIR says where.
Exit codes: 0 stopped by SIGINT or SIGTERM, 1 failed, 2 bad input or usage, 3 messages are missing in a recording.";

/// Runs the node until SIGINT or SIGTERM.
pub fn run(arguments: &RunArgs, ros: RosArguments) -> Result<(), Failure> {
    let options = RunOptions {
        ros,
        environment: environment()?,
        parameter_files: arguments.config.clone(),
    };
    let end = ros::run(&options).map_err(|error| match error {
        RunError::Parameters(faults) => Failure {
            exit: Exit::BadInput,
            report: faults.report(),
        },
        RunError::Name(error) => Failure::plain(Exit::BadInput, error),
        error => Failure::plain(Exit::Failed, error),
    })?;
    if end.solver_ended {
        return Err(Failure::plain(
            Exit::Failed,
            "a thread of the twin has ended by a panic; restart the node and report what it wrote",
        ));
    }
    match end.lost_in_recording {
        0 => Ok(()),
        lost => Err(Failure::plain(
            Exit::Lossy,
            format!(
                "{lost} messages are missing in the recordings; the log says when and why, and `column-twin info` what is there"
            ),
        )),
    }
}

/// The environment variables that every ROS 2 program obeys.
pub(super) fn environment() -> Result<Environment, Failure> {
    Environment::of_process().map_err(|error| Failure::plain(Exit::BadInput, error))
}
