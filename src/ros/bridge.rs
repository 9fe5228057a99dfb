//! What the node needs of a twin. The node knows nothing else of it, and the twin knows nothing of ROS.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use crate::column::{Report, Sample};
use crate::messages::column_twin::{ImpactEvent, ImpactReport, PredictImpactRequest, TwinStatus};
use crate::parameters::{Parameters, Value};

/// A twin that runs in threads of its own. Called from the node's threads, never from the solver's.
pub trait Twin: Send + Sync + 'static {
    /// Hands an event over and returns at once; what becomes of it comes with the outputs.
    ///
    /// # Errors
    /// When the queue is full: the event is refused, for this reason.
    fn submit_impact(&self, event: ImpactEvent) -> Result<(), String>;

    /// Changes parameters, all or nothing, and waits for the twin's decision.
    ///
    /// # Errors
    /// The reason why nothing was changed; it has been said to all who listen.
    fn set_parameters(&self, change: ParameterChange) -> Result<(), String>;

    /// Notes that a change of parameters was refused before the twin could be asked, so that it is counted and said as
    /// those that the twin refuses itself.
    fn refuse_parameters(&self, source: &'static str, reason: &str);

    /// The parameters that hold.
    fn parameters(&self) -> Arc<Parameters>;

    /// Back to the virgin column, waits until it is done; gives what there is to say.
    ///
    /// # Errors
    /// The reason why it was not done.
    fn reset(&self) -> Result<String, String>;

    /// What if; computes in the caller's thread. Header and column are the node's to fill in.
    ///
    /// # Errors
    /// The reason why there is no report.
    fn predict(&self, request: &PredictImpactRequest) -> Result<ImpactReport, String>;

    /// How the twin's threads and queues are.
    fn health(&self) -> Health;

    /// The time that the twin lives in, nanoseconds since the epoch.
    fn now(&self) -> i64;

    /// The time that `/clock` says, nanoseconds since the epoch; only called under `use_sim_time`.
    fn set_clock(&self, now: i64);
}

/// A set of parameters to change, all or nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterChange {
    /// The column that is meant; `None`: the twin's own.
    pub column_id: Option<String>,
    /// Names and values.
    pub values: Vec<(String, Value)>,
    /// Who asked, for the log.
    pub source: &'static str,
}

/// What leaves the twin. Stamps are nanoseconds since the epoch.
#[derive(Debug, Clone)]
pub enum Output {
    /// The column at one instant.
    State {
        /// The instant.
        stamp: i64,
        /// The impact that is going on.
        event_id: Arc<str>,
        /// The values.
        sample: Sample,
        /// Code of `ColumnState`: more than the column alone knows (REST, COLLAPSED, FAULTED).
        phase: u8,
    },
    /// What will come of an impact.
    Forecast(ReportOutput),
    /// What came of it.
    Report(ReportOutput),
    /// The twin's state, on every change and at 1 Hz. Header and column are the node's to fill in.
    Status {
        /// When it was taken.
        stamp: i64,
        /// The rest.
        status: Box<TwinStatus>,
    },
    /// Something was refused; it stands in the next status too.
    Refused {
        /// What it was.
        what: String,
        /// Why.
        reason: String,
    },
    /// A line for the log.
    Notice {
        /// How much it matters.
        severity: Severity,
        /// What there is to say.
        text: Arc<str>,
    },
    /// Other parameters hold now.
    ParametersChanged(Arc<Parameters>),
}

/// How much a notice matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// Something is not as it should be.
    Warning,
    /// Something was lost, or the twin cannot go on.
    Error,
}

/// A report with what it is for.
#[derive(Debug, Clone)]
pub struct ReportOutput {
    /// The event's stamp.
    pub stamp: i64,
    /// The event.
    pub event_id: Arc<str>,
    /// The report.
    pub report: Report,
    /// How long the computation took \[s\].
    pub compute_time: f64,
}

/// Where the twin's outputs are taken from, in their order.
pub trait Outputs: Send + 'static {
    /// The next output, waiting for it for at most `timeout`.
    ///
    /// # Errors
    /// Nothing came in that time, or nothing will ever come.
    fn receive(&mut self, timeout: Duration) -> Result<Output, RecvTimeoutError>;
}

impl Outputs for Receiver<Output> {
    fn receive(&mut self, timeout: Duration) -> Result<Output, RecvTimeoutError> {
        self.recv_timeout(timeout)
    }
}

/// How the twin's threads and queues are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Health {
    /// Periods of the solver that were skipped because it was late.
    pub overruns: u64,
    /// Largest lateness of the solver after its deadline \[s\].
    pub worst_lateness: f64,
    /// Events and parameters that found their queue full.
    pub dropped_inputs: u64,
    /// Samples that were not published.
    pub dropped_states: u64,
    /// Messages that are missing in the recording.
    pub dropped_recording: u64,
    /// Frames that the viewer did not show.
    pub dropped_viewer: u64,
    /// All queues.
    pub queues: Vec<QueueHealth>,
    /// Statistics of the solver, for people.
    pub statistics: Vec<(String, String)>,
    /// What of the real-time set-up was not granted, with what to do about it.
    pub hints: Vec<String>,
}

/// How a queue is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueHealth {
    /// Its name.
    pub name: String,
    /// Most entries.
    pub capacity: usize,
    /// Entries now.
    pub len: usize,
    /// What happens when it is full.
    pub policy: &'static str,
    /// Entries since the start.
    pub pushed: u64,
    /// Entries lost since the start.
    pub dropped: u64,
}
