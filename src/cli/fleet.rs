//! `column-twin fleet`: runs many columns as one ROS 2 node.

use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure};
use super::run::{end_of_run, environment, failure_of_run};
use super::transport::TransportArgs;
use column_twin::ros::{GivenParameters, RosArguments, RunOptions, run_fleet};

/// Arguments of `column-twin fleet`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct FleetArgs {
    /// Parameter file (ROS 2 YAML), may be repeated, later files win: a section without a wildcard, such as /garage/a3, is a
    /// column, and a section with one, such as /** or /garage/*, is for every column that it matches
    #[arg(long, value_name = "FILE")]
    params_file: Vec<PathBuf>,

    /// Table of columns (CSV): namespace, column_id and names of parameters in the first row, one column of the fleet in every
    /// further row; wins over the parameter files
    #[arg(long, value_name = "FILE")]
    columns: Option<PathBuf>,

    /// Columns that the viewer always shows in full, besides the one that was hit last: values of column_id, or names with the
    /// wildcards of parameter files (/garage/*); the same as -p viewer.select:=[...]
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',', num_args = 1..)]
    select: Vec<String>,

    /// Start as a managed node (lifecycle node): unconfigured, without inputs, until ~/change_state or `ros2 lifecycle set`
    /// configures and activates it; impacts before that are rejected
    #[arg(long)]
    managed: bool,

    #[command(flatten)]
    transport: TransportArgs,
}

const EXAMPLE: &str = "\
Example: the columns of a table, with their common parameters in a file, on this machine only
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin fleet --params-file config/fleet.yaml \\
    --columns config/fleet.csv --ros-args -r __ns:=/garage

The arguments after --ros-args are the same as for every ROS 2 node; -p changes a parameter of
every column. With -p viewer.mode:=serve (save, connect, spawn) the Rerun viewer shows the plan
of all columns. A fleet has at most 2000 columns. With -p record.mode:=events one recording has
all of them, and `column-twin verify` verifies it column by column.
Exit codes: 0 stopped by SIGINT or SIGTERM, 1 failed, 2 bad input or usage, 3 stopped by SIGINT
or SIGTERM, but messages are missing in the recordings, or damage could not be saved.";

/// Runs the node until SIGINT or SIGTERM.
pub fn run(arguments: &FleetArgs, mut ros: RosArguments) -> Result<(), Failure> {
    if arguments.params_file.is_empty() && arguments.columns.is_none() && ros.parameters.is_empty()
    {
        return Err(Failure::plain(
            Exit::BadInput,
            "a fleet needs columns: give --params-file FILE, --columns FILE, or both",
        ));
    }
    let environment = arguments.transport.apply(environment(&ros)?);
    if !arguments.select.is_empty() {
        // A list in JSON is one in YAML.
        let selected = serde_json::to_string(&arguments.select).expect("texts");
        let selected = format!("viewer.select:={selected}");
        ros.parameters.push(GivenParameters::Override(selected));
    }
    let options = RunOptions {
        environment,
        ros,
        parameter_files: arguments.params_file.clone(),
        columns: arguments.columns.clone(),
        managed: arguments.managed,
    };
    end_of_run(run_fleet(&options).map_err(failure_of_run)?)
}
