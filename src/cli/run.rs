//! `column-twin run`: runs the twin as a ROS 2 node.

use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure};
use super::transport::TransportArgs;
use column_twin::ros::security::protection;
use column_twin::ros::{
    self, Environment, NodeError, RosArguments, RunEnd, RunError, RunOptions, StartError,
    Transport, check_transport,
};

/// Arguments of `column-twin run`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct RunArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win, and --params-file and -p win over all of them
    #[arg(long, short, value_name = "FILE")]
    config: Vec<PathBuf>,

    /// Start as a managed node (lifecycle node): unconfigured, without inputs, until ~/change_state or `ros2 lifecycle set`
    /// configures and activates it; impacts before that are rejected
    #[arg(long)]
    managed: bool,

    #[command(flatten)]
    transport: TransportArgs,
}

const EXAMPLE: &str = "\
Example: the column of a parameter file, in a namespace, on this machine only
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin run --config config/heb220_s355.yaml \\
    --ros-args -r __ns:=/garage -p top.load:=4.0e5

The arguments after --ros-args are the same as for every ROS 2 node: -r, -p, --params-file,
--log-level. Parameter files that name several columns and not this node make a fleet: see
column-twin fleet. With -p record.mode:=always the node records everything that it receives and
sends, in the directory given by -p record.directory:=DIR. Recordings are sealed with the key of
-p record.seal_key:=FILE, or with a fresh one, whose public part the log shows.
Exit codes: 0 stopped by SIGINT or SIGTERM, 1 failed, 2 bad input or usage, 3 messages are
missing in a recording, or damage could not be saved.";

/// Runs the node until SIGINT or SIGTERM.
pub fn run(arguments: &RunArgs, ros: RosArguments) -> Result<(), Failure> {
    let options = RunOptions {
        environment: arguments.transport.apply(environment(&ros)?),
        ros,
        parameter_files: arguments.config.clone(),
        columns: None,
        managed: arguments.managed,
    };
    end_of_run(ros::run(&options).map_err(failure_of_run)?)
}

/// The failure of a node that cannot start.
pub(super) fn failure_of_run(error: RunError) -> Failure {
    match error {
        RunError::Parameters(faults) => faults.into(),
        error @ (RunError::SealKey(_)
        | RunError::Start(
            _,
            StartError::Selection(_) | StartError::SensorTopics { .. } | StartError::Columns(_),
        )) => Failure::plain(Exit::BadInput, error),
        error @ RunError::Node(
            NodeError::Alarms(_)
            | NodeError::Metrics(_)
            | NodeError::Foxglove(_)
            | NodeError::Zenoh(_),
        ) => Failure::plain(Exit::BadInput, error),
        RunError::Name(error) => Failure::plain(Exit::BadInput, error),
        RunError::Security(error) => Failure::plain(Exit::BadInput, error),
        error => Failure::plain(Exit::Failed, error),
    }
}

/// How the program ends after the node.
pub(super) fn end_of_run(end: RunEnd) -> Result<(), Failure> {
    if end.has_panicked {
        return Err(Failure::plain(
            Exit::Failed,
            "a thread of the twin panicked; restart the node, and report its output",
        ));
    }
    let mut lost = Vec::new();
    if end.lost_in_recording > 0 {
        lost.push(format!(
            "{} messages are missing in the recordings; see the log for when and why, and `column-twin info` for the contents",
            end.lost_in_recording
        ));
    }
    if end.unsaved_states > 0 {
        lost.push(format!(
            "{} writes of a state file failed, so that damage may be missing after a restart; see the log for when and why",
            end.unsaved_states
        ));
    }
    match lost.is_empty() {
        true => Ok(()),
        false => Err(Failure::plain(Exit::Lossy, lost.join("; "))),
    }
}

/// The settings in the environment variables of ROS 2, with the enclave of `--enclave`.
pub(super) fn environment(ros: &RosArguments) -> Result<Environment, Failure> {
    let environment = Environment::of_process();
    let environment = environment.map_err(|error| Failure::plain(Exit::BadInput, error))?;
    Ok(Environment {
        security: environment.security.with_enclave(ros.enclave.as_deref()),
        ..environment
    })
}

/// As [`environment`], for a client with this transport, which has no log: rejects what [`check_transport`] does, and an enclave that
/// cannot be used, and warns on the terminal if the client runs unprotected.
pub(super) fn client_environment(
    ros: &RosArguments,
    transport: TransportArgs,
) -> Result<Environment, Failure> {
    let environment = transport.apply(environment(ros)?);
    check_transport(&environment).map_err(|error| Failure::plain(Exit::BadInput, error))?;
    if environment.transport == Transport::Zenoh {
        return Ok(environment);
    }
    let protection = protection(&environment.security, environment.domain_id)
        .map_err(|error| Failure::plain(Exit::BadInput, error))?;
    if let Some(warning) = protection.warning() {
        tell!("warning: {warning}");
    }
    Ok(environment)
}
