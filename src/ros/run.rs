//! `column-twin run` and `column-twin fleet`: run a node from its arguments to a clean stop.

use std::path::PathBuf;
use std::sync::Arc;

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use signal_hook::consts::SIGTERM;

#[cfg(feature = "record")]
use crate::endpoints::{Endpoint, NodeKind};
use crate::live::LiveOptions;
use crate::outgoing::RecordingTap;
use crate::parameters::{
    Fault, FleetColumns, FleetSources, NodeName, ParameterFaults, Parameters, RecordMode, Settings,
    Source, parse_override,
};
#[cfg(feature = "record")]
use crate::recording::{RecorderOptions, RecorderReport, RecordingError, ReportLevel};
use crate::state_home;

use super::NODE_NAME;
use super::address_space::{TooLittleAddressSpace, check_address_space};
use super::dds_threads::DdsThreads;
use super::live_columns::{LiveColumns, StartError};
use super::node::{NodeError, check_transport};
use super::qos::check_types;
use super::qos_overrides::{OverrideError, check_overrides};
use super::twin_node::{StartOptions, TwinNode};
use ros_node::arguments::{GivenParameters, RosArguments};
use ros_node::environment::{DiscoveryRange, Environment, Transport};
use ros_node::names::{NameError, Names};
use ros_node::rosout::start_logging;
use ros_node::security::{SecurityError, protection};
use ros_node::signals::StopSignals;

/// Files that a fleet may have open: those of the shared endpoints and of all columns that may have topics of their own.
const WANTED_FILES: u64 = 4096;

/// The command line and the environment of a run.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// The arguments after `--ros-args`.
    pub ros: RosArguments,
    /// The settings in environment variables.
    pub environment: Environment,
    /// Parameter files, which the table of the columns and ROS arguments override.
    pub parameter_files: Vec<PathBuf>,
    /// The table of the columns of a fleet.
    pub columns: Option<PathBuf>,
    /// Whether the node is a managed one, which starts unconfigured.
    pub managed: bool,
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

impl From<OverrideError> for RunError {
    fn from(error: OverrideError) -> Self {
        match error {
            OverrideError::Name(error) => Self::Name(error),
            OverrideError::Parameters(faults) => Self::Parameters(faults),
        }
    }
}

/// What is to be run.
enum Loaded {
    One(Box<Parameters>),
    Many(Box<FleetColumns>),
}

impl Loaded {
    #[cfg(feature = "record")]
    fn kind(&self) -> NodeKind {
        match self {
            Self::One(_) => NodeKind::Single,
            Self::Many(_) => NodeKind::Fleet,
        }
    }

    /// The parameters of the node.
    fn node(&self) -> &Parameters {
        match self {
            Self::One(parameters) => parameters,
            Self::Many(fleet) => &fleet.node,
        }
    }

    /// The settings of the columns.
    fn columns(&self) -> Vec<&Settings> {
        match self {
            Self::One(parameters) => vec![parameters.settings()],
            Self::Many(fleet) => {
                let columns = fleet.columns.iter();
                columns.map(|it| it.parameters.settings()).collect()
            }
        }
    }
}

/// Runs the node of a single twin until SIGINT or SIGTERM, or that of a fleet if the parameter files name several columns.
///
/// # Errors
/// Names or parameters are not valid, or the node, the twin or the recording cannot be started.
pub fn run(options: &RunOptions) -> Result<RunEnd, RunError> {
    run_loaded(options, |names| load(options, names))
}

/// The node's name for parameter files and overrides.
fn for_parameters(names: &Names) -> NodeName {
    NodeName::new(names.namespace(), names.node())
}

/// What an argument gives parameters by.
fn source(given: &GivenParameters) -> Source {
    match given {
        GivenParameters::Override(text) => Source::Override(parse_override(text)),
        GivenParameters::File(path) => Source::File(path.clone()),
    }
}

/// A single twin, or a fleet if the parameter files name several columns.
fn load(options: &RunOptions, names: &NodeName) -> Result<(Loaded, Vec<Fault>), ParameterFaults> {
    let files = options.parameter_files.iter().cloned().map(Source::File);
    let sources: Vec<_> = files
        .chain(options.ros.parameters.iter().map(source))
        .collect();
    let files = sources.iter().filter_map(|source| match source {
        Source::File(path) => Some(path.as_path()),
        Source::Override(_) | Source::Value(..) => None,
    });
    if FleetColumns::are_named_in(names, files) {
        return load_fleet(options, names);
    }
    let (parameters, warnings) = Parameters::load_in_order(names, sources)?;
    Ok((Loaded::One(Box::new(parameters)), warnings))
}

/// Sends a message of the state `test` by each way of delivery that the parameters ask for, without a node; `None` if they
/// ask for none.
///
/// # Errors
/// Names or parameters are not valid, or the delivery cannot be used.
#[cfg(feature = "alarm")]
pub fn try_alarms(options: &RunOptions) -> Result<Option<Vec<column_alarm::Tried>>, RunError> {
    let names = Names::new(
        &options.environment.namespace,
        NODE_NAME,
        &options.ros.remap_rules,
    )?;
    let (loaded, _) = load(options, &for_parameters(&names))?;
    let alarm = &loaded.node().settings().alarm;
    let tried = super::alarms::try_out(alarm, &names.fully_qualified());
    Ok(tried?)
}

/// Runs the node of a fleet until SIGINT or SIGTERM.
///
/// # Errors
/// Names or parameters are not valid, or the node, the fleet or the recording cannot be started.
pub fn run_fleet(options: &RunOptions) -> Result<RunEnd, RunError> {
    run_loaded(options, |names| load_fleet(options, names))
}

fn load_fleet(
    options: &RunOptions,
    names: &NodeName,
) -> Result<(Loaded, Vec<Fault>), ParameterFaults> {
    raise_file_limit();
    let sources = FleetSources {
        files: options.parameter_files.clone(),
        table: options.columns.clone(),
        arguments: options.ros.parameters.iter().map(source).collect(),
    };
    let mut columns = FleetColumns::load(names, &sources)?;
    let warnings = std::mem::take(&mut columns.warnings);
    Ok((Loaded::Many(Box::new(columns)), warnings))
}

fn run_loaded(
    options: &RunOptions,
    load: impl FnOnce(&NodeName) -> Result<(Loaded, Vec<Fault>), ParameterFaults>,
) -> Result<RunEnd, RunError> {
    let RunOptions {
        ros, environment, ..
    } = options;
    let mut signals = StopSignals::listen().map_err(|error| RunError::Process(error.into()))?;
    let names = Names::new(&environment.namespace, NODE_NAME, &ros.remap_rules)?;
    check_types(&names)?;
    let (loaded, mut warnings) = load(&for_parameters(&names))?;
    warnings.extend(check_overrides(loaded.node(), loaded.columns(), &names)?);
    // Before anything starts or is written.
    check_address_space()?;
    check_transport(environment)?;
    if environment.transport == Transport::Dds {
        protection(&environment.security, environment.domain_id)?;
    }
    let log = start_logging(ros, &names.logger(), env!("CARGO_CRATE_NAME"))
        .map_err(|error| RunError::Process(error.into()))?;
    for warning in &environment.warnings {
        tracing::warn!("{warning}");
    }
    for argument in &ros.without_effect {
        tracing::warn!("{argument} has no effect on this node");
    }
    for warning in &warnings {
        tracing::warn!("{warning}");
    }
    log_folders(loaded.node().settings());
    let dds_threads = DdsThreads::stop_on_panic();
    let recording = RunRecording::start(&loaded, &names)?;
    let started = match loaded {
        Loaded::One(parameters) => LiveColumns::start_one(*parameters, LiveOptions::default())
            .map_err(|error| RunError::Start("twin", error)),
        Loaded::Many(columns) => {
            LiveColumns::start_fleet(&columns).map_err(|error| RunError::Start("fleet", error))
        }
    };
    let (columns, outputs) = started.map_err(|error| match error {
        RunError::Start(_, StartError::Parameters(faults)) => RunError::Parameters(faults),
        error => error,
    })?;
    let (live, tap) = (Arc::clone(&columns), recording.tap());
    let start = StartOptions {
        managed: options
            .managed
            .then(|| Box::new(stop_process) as Box<dyn Fn() + Send>),
        ..StartOptions::default()
    };
    let node = TwinNode::start_with(environment, names, live, outputs, log, tap, start)?;
    let reach = match (environment.transport, environment.discovery_range) {
        (Transport::Zenoh, _) => "over Zenoh",
        (Transport::Dds, DiscoveryRange::Localhost) => "on this machine only",
        (Transport::Dds, DiscoveryRange::Subnet) => "on every network of this machine",
    };
    let what = match columns.face().is_fleet() {
        false => String::new(),
        true => format!(
            ", with {} columns on {} solver threads",
            columns.face().ids().len(),
            columns.threads()
        ),
    };
    let state = match options.managed {
        true => "; it is managed and unconfigured, and rejects impacts until it is active",
        false => "",
    };
    tracing::info!(
        "{} is ready in domain {}, {reach}{what}{state}",
        node.names(),
        environment.domain_id
    );
    signals.wait();
    tracing::info!("stopping");
    node.stop();
    let health = columns.health();
    Ok(RunEnd {
        lost_in_recording: recording.stop(health.dropped_recording),
        unsaved_states: health.unsaved_states,
        has_panicked: health.has_panicked || dds_threads.has_panicked(),
    })
}

/// Ends the process as SIGTERM does.
fn stop_process() {
    if let Err(error) = signal_hook::low_level::raise(SIGTERM) {
        tracing::error!("the process cannot stop itself: {error}; end it with SIGTERM");
    }
}

/// Says where the damage and the recordings go, and warns where that depends on the folder from which the node is started.
fn log_folders(settings: &Settings) {
    let (state, record) = (&settings.state.directory, &settings.record);
    let absolute = |folder: &str| {
        let folder = state_home::resolve(folder);
        std::path::absolute(&folder).unwrap_or(folder)
    };
    let mut used = Vec::new();
    if state.is_empty() {
        tracing::info!("the damage is lost when the node ends, because state.directory is empty");
    } else {
        tracing::info!(
            "the damage is saved in {} (state.directory)",
            absolute(state).display()
        );
        used.push(("state.directory", state));
    }
    if record.mode != RecordMode::Off {
        let directory = &record.directory;
        tracing::info!(
            "recordings are written to {} (record.directory)",
            absolute(directory).display()
        );
        used.push(("record.directory", directory));
    }
    for warning in used
        .iter()
        .filter_map(|(name, folder)| state_home::without_home(name, folder))
    {
        tracing::warn!("{warning}");
    }
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

/// The recording of a run, if there is one. Ends last, after everything has been published.
#[cfg(feature = "record")]
struct RunRecording(Option<Arc<crate::evidence::NodeRecording>>);

#[cfg(feature = "record")]
impl RunRecording {
    fn start(loaded: &Loaded, names: &Names) -> Result<Self, RunError> {
        use crate::evidence::{NodeRecording, Topics};
        let resolve = |endpoint: &Endpoint| names.resolve(endpoint.kind(), endpoint.name);
        let topics = Topics::resolved(loaded.kind(), resolve)?;
        let columns = loaded.columns();
        let ids = columns.iter().map(|it| it.column_id.as_str().into());
        let record = &loaded.node().settings().record;
        NodeRecording::start(record, &topics, ids.collect(), with_log)
            .map(Self)
            .map_err(|error| match crate::recording::with_parameter(&error) {
                reason if matches!(error, RecordingError::BadKey { .. }) => {
                    RunError::SealKey(reason)
                }
                reason => RunError::Recording(reason.into()),
            })
    }

    fn tap(&self) -> Option<Arc<dyn RecordingTap>> {
        let tap = self.0.clone()?;
        Some(tap)
    }

    /// Ends the recording, and returns the number of missing messages, including those dropped before the recorder.
    fn stop(self, dropped_before: u64) -> u64 {
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
struct RunRecording;

#[cfg(not(feature = "record"))]
impl RunRecording {
    fn start(loaded: &Loaded, _: &Names) -> Result<Self, RunError> {
        match loaded.node().settings().record.mode {
            RecordMode::Off => Ok(Self),
            _ => Err(RunError::Recording(
                "record.mode asks for a recording, but this program was built without the feature `record`; set it to off"
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
