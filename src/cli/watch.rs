//! `column-twin watch`: prints what a running twin publishes.

use std::io::Write;
use std::ops::ControlFlow;

use clap::Args;

use super::failure::{Exit, Failure, printed};
use super::run::client_environment;
use column_twin::ros::{RosArguments, watch};

/// Arguments of `column-twin watch`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct WatchArgs {}

const EXAMPLE: &str = "\
Example: a twin in the namespace /garage, on this machine only
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin watch --ros-args -r __ns:=/garage

Exit codes: 0 stopped by SIGINT or SIGTERM, 1 failed, 2 bad input or usage.";

/// Prints until SIGINT or SIGTERM, or until the reader closes the pipe (`| head`).
pub fn run(_: &WatchArgs, ros: &RosArguments, out: &mut impl Write) -> Result<(), Failure> {
    let mut written = Ok(());
    watch(&client_environment(ros)?, &ros.remap_rules, &mut |line| {
        written = writeln!(out, "{line}");
        match written {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    })
    .map_err(|error| Failure::plain(Exit::Failed, error))?;
    printed(written)
}
