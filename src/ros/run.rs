//! `column-twin run`: the node from its arguments to its clean end.

use std::path::PathBuf;
use std::sync::Arc;

use crate::live::LiveOptions;
use crate::outgoing::RecordingTap;
use crate::parameters::{Fault, ParameterFaults, Parameters, Source};

use super::NODE_NAME;
use super::arguments::RosArguments;
use super::environment::{DiscoveryRange, Environment};
use super::live_twin::{LiveTwin, LiveTwinError};
use super::names::{NameError, Names};
use super::node::NodeError;
use super::rosout::start_logging;
use super::signals::StopSignals;
use super::twin_node::TwinNode;

/// What the command line and the environment ask for.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// What stood behind `--ros-args`.
    pub ros: RosArguments,
    /// What the environment says.
    pub environment: Environment,
    /// Parameter files of the program's own flags, read before all ROS arguments.
    pub parameter_files: Vec<PathBuf>,
}

/// How a node that ran has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunEnd {
    /// Messages that are missing in its recordings.
    pub lost_in_recording: u64,
    /// A thread of the twin had ended by a panic.
    pub solver_ended: bool,
}

/// Why the node did not start.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A name that is none.
    #[error(transparent)]
    Name(#[from] NameError),
    /// Wrong parameters.
    #[error(transparent)]
    Parameters(#[from] ParameterFaults),
    /// No node.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// No twin.
    #[error("the twin cannot start: {0}")]
    Twin(#[from] LiveTwinError),
    /// No recording.
    #[error("no recording: {0}")]
    Recording(Box<dyn std::error::Error + Send + Sync>),
    /// Logging or signals.
    #[error("{0}; is the node started twice in one program?")]
    Process(Box<dyn std::error::Error + Send + Sync>),
}

/// Runs the node until SIGINT or SIGTERM.
///
/// # Errors
/// Names or parameters are wrong, or there is no participant, thread or twin to be had.
pub fn run(options: &RunOptions) -> Result<RunEnd, RunError> {
    let RunOptions {
        ros, environment, ..
    } = options;
    let mut signals = StopSignals::listen().map_err(|error| RunError::Process(error.into()))?;
    let names = Names::new(&environment.namespace, NODE_NAME, &ros.remap_rules)?;
    let (parameters, deprecated) = load_parameters(options, &names)?;
    let log =
        start_logging(ros, &names.logger()).map_err(|error| RunError::Process(error.into()))?;
    say_what_is_not_done(options);
    for warning in &deprecated {
        tracing::warn!("{warning}");
    }
    let recording = RunRecording::start(&parameters, &names)?;
    let (twin, outputs) = LiveTwin::start(parameters, LiveOptions::default())?;
    let node = TwinNode::start_recorded(
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
        solver_ended: health.solver_ended,
    })
}

/// The recording of a run, if there is one. Ends last, when all that there is has been sent.
#[cfg(feature = "record")]
struct RunRecording(Option<Arc<crate::evidence::NodeRecording>>);

#[cfg(feature = "record")]
impl RunRecording {
    fn start(parameters: &Parameters, names: &Names) -> Result<Self, RunError> {
        use crate::evidence::{NodeRecording, Topics};
        use crate::recording::{RecorderOptions, RecorderReport, ReportLevel};
        let topics = Topics::resolved(|endpoint| names.resolve(endpoint.kind(), endpoint.name))?;
        let say = |report: &RecorderReport| match report.level() {
            ReportLevel::Info => tracing::info!("{report}"),
            ReportLevel::Warning => tracing::warn!("{report}"),
            ReportLevel::Error => tracing::error!("{report}"),
        };
        let told = |options| RecorderOptions {
            on_report: Some(Arc::new(say)),
            ..options
        };
        NodeRecording::start(&parameters.settings().record, &topics, told)
            .map(Self)
            .map_err(|error| RunError::Recording(crate::recording::with_parameter(&error).into()))
    }

    fn tap(&self) -> Option<Arc<dyn RecordingTap>> {
        let tap = self.0.clone()?;
        Some(tap)
    }

    /// Messages that are missing, among them those that did not come as far as to the recording.
    fn stop(self, dropped_before: u64) -> u64 {
        let statistics = self.0.and_then(|recording| recording.stop());
        statistics.map_or(0, |it| it.lost + dropped_before)
    }
}

#[cfg(not(feature = "record"))]
struct RunRecording;

#[cfg(not(feature = "record"))]
impl RunRecording {
    fn start(parameters: &Parameters, _: &Names) -> Result<Self, RunError> {
        match parameters.settings().record.mode {
            crate::parameters::RecordMode::Off => Ok(Self),
            _ => Err(RunError::Recording(
                "record.mode asks for one, and this program was built without the feature `record`"
                    .into(),
            )),
        }
    }

    fn tap(&self) -> Option<Arc<dyn RecordingTap>> {
        None
    }

    fn stop(self, _: u64) -> u64 {
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

fn say_what_is_not_done(options: &RunOptions) {
    for warning in &options.environment.warnings {
        tracing::warn!("{warning}");
    }
    for argument in &options.ros.without_effect {
        tracing::warn!("{argument} has no effect on this node");
    }
}
