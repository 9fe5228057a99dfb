//! `column-twin fleet`: runs the node of a fleet from its arguments to a clean stop.

use std::path::PathBuf;
use std::sync::Arc;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::parameters::{FleetColumns, FleetSources};

use crate::ros::NODE_NAME;
use crate::ros::address_space::check_address_space;
use crate::ros::arguments::RosArguments;
use crate::ros::dds_threads::DdsThreads;
use crate::ros::environment::{DiscoveryRange, Environment};
use crate::ros::live_columns::{LiveColumns, StartError};
use crate::ros::names::Names;
use crate::ros::rosout::start_logging;
use crate::ros::run::{RunEnd, RunError, RunRecording};
use crate::ros::security::protection;
use crate::ros::signals::StopSignals;
use crate::ros::twin_node::TwinNode;

/// Files that a fleet may have open: those of the shared endpoints and of all columns that may have topics of their own.
const WANTED_FILES: u64 = 4096;

/// The command line and the environment of a fleet.
#[derive(Debug, Clone, Default)]
pub struct FleetRunOptions {
    /// The arguments after `--ros-args`.
    pub ros: RosArguments,
    /// The settings in environment variables.
    pub environment: Environment,
    /// Parameter files of `--params-file`, which the table and ROS arguments override.
    pub parameter_files: Vec<PathBuf>,
    /// The table of `--columns`.
    pub columns: Option<PathBuf>,
}

/// Runs the node of a fleet until SIGINT or SIGTERM.
///
/// # Errors
/// Names or parameters are not valid, or the node or the fleet cannot be started.
pub fn run_fleet(options: &FleetRunOptions) -> Result<RunEnd, RunError> {
    let FleetRunOptions {
        ros, environment, ..
    } = options;
    raise_file_limit();
    let mut signals = StopSignals::listen().map_err(|error| RunError::Process(error.into()))?;
    let names = Names::new(&environment.namespace, NODE_NAME, &ros.remap_rules)?;
    let sources = FleetSources {
        files: options.parameter_files.clone(),
        table: options.columns.clone(),
        arguments: ros.parameters.clone(),
    };
    let columns = FleetColumns::load(&names.for_parameters(), &sources)?;
    // Before anything starts or is written.
    protection(&environment.security, environment.domain_id)?;
    let log =
        start_logging(ros, &names.logger()).map_err(|error| RunError::Process(error.into()))?;
    for warning in &environment.warnings {
        tracing::warn!("{warning}");
    }
    for argument in &ros.without_effect {
        tracing::warn!("{argument} has no effect on this node");
    }
    for warning in &columns.warnings {
        tracing::warn!("{warning}");
    }
    check_address_space()?;
    let dds_threads = DdsThreads::stop_on_panic();
    let recording = RunRecording::start_of_fleet(&columns, &names)?;
    let (fleet, outputs) = LiveColumns::start_fleet(&columns).map_err(|error| match error {
        StartError::Parameters(faults) => RunError::Parameters(faults),
        error => RunError::Start("fleet", error),
    })?;
    let count = columns.columns.len();
    drop(columns);
    let node = TwinNode::start(
        environment,
        names,
        Arc::clone(&fleet),
        outputs,
        log,
        recording.tap(),
    )?;
    let reach = match environment.discovery_range {
        DiscoveryRange::Localhost => "this machine only",
        DiscoveryRange::Subnet => "every network of this machine",
    };
    tracing::info!(
        "{} is ready in domain {}, on {reach}, with {count} columns on {} solver threads",
        node.names(),
        environment.domain_id,
        fleet.threads(),
    );
    signals.wait();
    tracing::info!("stopping");
    node.stop();
    let health = fleet.health();
    Ok(RunEnd {
        lost_in_recording: recording.stop(health.dropped_recording),
        unsaved_states: health.unsaved_states,
        has_panicked: health.has_panicked || dds_threads.has_panicked(),
    })
}

/// Lets the process open as many files as [`WANTED_FILES`], if the system allows it: each endpoint takes two, and many columns may
/// have topics of their own.
fn raise_file_limit() {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let wanted = maximum.map_or(WANTED_FILES, |it| it.min(WANTED_FILES));
    if current.is_some_and(|it| it < wanted) {
        let raised = Rlimit {
            current: Some(wanted),
            maximum,
        };
        // Without it, an endpoint that cannot be created is an error that names the limit.
        let _ = setrlimit(Resource::Nofile, raised);
    }
}
