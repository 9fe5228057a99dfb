//! `column-twin run`: runs the node from its arguments to a clean stop.

use std::path::PathBuf;
use std::sync::Arc;

use crate::live::LiveOptions;
use crate::outgoing::RecordingTap;
use crate::parameters::{Fault, FleetColumns, ParameterFaults, Parameters, Source};
#[cfg(feature = "record")]
use crate::recording::{RecorderOptions, RecorderReport, RecordingError, ReportLevel};

use super::NODE_NAME;
use super::address_space::{TooLittleAddressSpace, check_address_space};
use super::arguments::RosArguments;
use super::dds_threads::DdsThreads;
use super::environment::{DiscoveryRange, Environment};
use super::live_columns::{LiveColumns, StartError};
use super::names::{NameError, Names};
use super::node::NodeError;
use super::rosout::start_logging;
use super::security::{SecurityError, protection};
use super::signals::StopSignals;
use super::twin_node::TwinNode;

/// The command line and the environment of a run.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// The arguments after `--ros-args`.
    pub ros: RosArguments,
    /// The settings in environment variables.
    pub environment: Environment,
    /// Parameter files of `--config`, which ROS arguments override.
    pub parameter_files: Vec<PathBuf>,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunEnd {
    /// Messages missing in its recordings.
    pub lost_in_recording: u64,
    /// Writes of a state file that failed.
    pub unsaved_states: u64,
    /// A thread of the twin or of the DDS library panicked.
    pub has_panicked: bool,
}

/// Why the node cannot start.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A name is not valid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// Parameters are not valid.
    #[error(transparent)]
    Parameters(#[from] ParameterFaults),
    /// The enclave is missing or cannot be used.
    #[error(transparent)]
    Security(#[from] SecurityError),
    /// The node cannot be created.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// The twin or the fleet cannot be started.
    #[error("the {0} cannot start: {1}")]
    Start(&'static str, #[source] StartError),
    /// The recording cannot be started.
    #[error("the recording cannot start: {0}")]
    Recording(Box<dyn std::error::Error + Send + Sync>),
    /// The key of the seals cannot be used.
    #[error("the recording cannot start: {0}")]
    SealKey(String),
    /// The system grants too little address space.
    #[error(transparent)]
    AddressSpace(#[from] TooLittleAddressSpace),
    /// Logging or signal handling cannot be set up.
    #[error("{0}; a program can run only one node")]
    Process(Box<dyn std::error::Error + Send + Sync>),
}

/// Runs the node until SIGINT or SIGTERM.
///
/// # Errors
/// Names or parameters are not valid, or the node, the twin or the recording cannot be started.
pub fn run(options: &RunOptions) -> Result<RunEnd, RunError> {
    let RunOptions {
        ros, environment, ..
    } = options;
    let mut signals = StopSignals::listen().map_err(|error| RunError::Process(error.into()))?;
    let names = Names::new(&environment.namespace, NODE_NAME, &ros.remap_rules)?;
    let (parameters, deprecated) = load_parameters(options, &names)?;
    // Before anything starts or is written.
    check_address_space()?;
    protection(&environment.security, environment.domain_id)?;
    let log =
        start_logging(ros, &names.logger()).map_err(|error| RunError::Process(error.into()))?;
    warn_of_ignored_settings(options);
    for warning in &deprecated {
        tracing::warn!("{warning}");
    }
    let dds_threads = DdsThreads::stop_on_panic();
    let recording = RunRecording::start(&parameters, &names)?;
    let (twin, outputs) = LiveColumns::start_one(parameters, LiveOptions::default())
        .map_err(|error| RunError::Start("twin", error))?;
    let node = TwinNode::start(
        environment,
        names,
        Arc::clone(&twin),
        outputs,
        log,
        recording.tap(),
    )?;
    let reach = match environment.discovery_range {
        DiscoveryRange::Localhost => "this machine only",
        DiscoveryRange::Subnet => "every network of this machine",
    };
    tracing::info!(
        "{} is ready in domain {}, on {reach}",
        node.names(),
        environment.domain_id
    );
    signals.wait();
    tracing::info!("stopping");
    node.stop();
    let health = twin.health();
    Ok(RunEnd {
        lost_in_recording: recording.stop(health.dropped_recording),
        unsaved_states: health.unsaved_states,
        has_panicked: health.has_panicked || dds_threads.has_panicked(),
    })
}

/// The recording of a run, if there is one. Ends last, after everything has been published.
#[cfg(feature = "record")]
pub(super) struct RunRecording(Option<Arc<crate::evidence::NodeRecording>>);

#[cfg(feature = "record")]
impl RunRecording {
    fn start(parameters: &Parameters, names: &Names) -> Result<Self, RunError> {
        use crate::evidence::{NodeRecording, Topics};
        let topics = Topics::resolved(|endpoint| names.resolve(endpoint.kind(), endpoint.name))?;
        Self::started(NodeRecording::start(
            &parameters.settings().record,
            &topics,
            with_log,
        ))
    }

    /// The recording of a fleet.
    pub(super) fn start_of_fleet(fleet: &FleetColumns, names: &Names) -> Result<Self, RunError> {
        use crate::evidence::{NodeRecording, Topics};
        let topics =
            Topics::resolved_of_fleet(|endpoint| names.resolve(endpoint.kind(), endpoint.name))?;
        let columns = fleet.columns.iter();
        let columns = columns.map(|it| it.parameters.settings().column_id.as_str().into());
        Self::started(NodeRecording::start_of_fleet(
            &fleet.node.settings().record,
            &topics,
            columns.collect(),
            with_log,
        ))
    }

    fn started(
        started: Result<Option<Arc<crate::evidence::NodeRecording>>, RecordingError>,
    ) -> Result<Self, RunError> {
        started
            .map(Self)
            .map_err(|error| match crate::recording::with_parameter(&error) {
                reason if matches!(error, RecordingError::BadKey { .. }) => {
                    RunError::SealKey(reason)
                }
                reason => RunError::Recording(reason.into()),
            })
    }

    pub(super) fn tap(&self) -> Option<Arc<dyn RecordingTap>> {
        let tap = self.0.clone()?;
        Some(tap)
    }

    /// Ends the recording, and returns the number of missing messages, including those dropped before the recorder.
    pub(super) fn stop(self, dropped_before: u64) -> u64 {
        let statistics = self.0.and_then(|recording| recording.stop());
        statistics.map_or(0, |it| it.lost + dropped_before)
    }
}

/// Logs what the recorder reports.
#[cfg(feature = "record")]
fn with_log(options: RecorderOptions) -> RecorderOptions {
    let log = |report: &RecorderReport| match report.level() {
        ReportLevel::Info => tracing::info!("{report}"),
        ReportLevel::Warning => tracing::warn!("{report}"),
        ReportLevel::Error => tracing::error!("{report}"),
    };
    RecorderOptions {
        on_report: Some(Arc::new(log)),
        ..options
    }
}

#[cfg(not(feature = "record"))]
pub(super) struct RunRecording;

#[cfg(not(feature = "record"))]
impl RunRecording {
    fn start(parameters: &Parameters, _: &Names) -> Result<Self, RunError> {
        match parameters.settings().record.mode {
            crate::parameters::RecordMode::Off => Ok(Self),
            _ => Err(RunError::Recording(
                "record.mode asks for a recording, but this program was built without the feature `record`; set it to off"
                    .into(),
            )),
        }
    }

    pub(super) fn start_of_fleet(fleet: &FleetColumns, names: &Names) -> Result<Self, RunError> {
        Self::start(&fleet.node, names)
    }

    pub(super) fn tap(&self) -> Option<Arc<dyn RecordingTap>> {
        None
    }

    pub(super) fn stop(self, _: u64) -> u64 {
        0
    }
}

fn load_parameters(
    options: &RunOptions,
    names: &Names,
) -> Result<(Parameters, Vec<Fault>), ParameterFaults> {
    let files = options.parameter_files.iter().cloned().map(Source::File);
    let sources = files.chain(options.ros.parameters.iter().cloned());
    Parameters::load_in_order(&names.for_parameters(), sources)
}

fn warn_of_ignored_settings(options: &RunOptions) {
    for warning in &options.environment.warnings {
        tracing::warn!("{warning}");
    }
    for argument in &options.ros.without_effect {
        tracing::warn!("{argument} has no effect on this node");
    }
}
