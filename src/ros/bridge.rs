//! What the node needs of a twin. The node knows nothing else of it, and the twin knows nothing of ROS.

use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use crate::endpoints::Endpoint;
use crate::live::{QueueStats, WhenFull};
use crate::messages::column_twin::{ImpactEvent, ImpactReport, PredictImpactRequest};
use crate::parameters::{Parameters, Value};
use crate::twin::{Journal, Output};

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
    fn set_parameters(&self, change: ParameterChange) -> Result<(), NotChanged>;

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

/// Why parameters were not changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotChanged {
    /// For people.
    pub reason: String,
    /// Whether the twin was given the change: then its journal says what became of it.
    pub is_in_journal: bool,
}

/// Where the twin's outputs are taken from, in their order.
pub trait Outputs: Send + 'static {
    /// The next output, waiting for it for at most `timeout`.
    ///
    /// # Errors
    /// Nothing came in that time, or nothing will ever come.
    fn receive(&mut self, timeout: Duration) -> Result<Output, RecvTimeoutError>;
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
    /// Outputs that the queues to the node have dropped: they are not published, and in no recording either.
    pub dropped_recording: u64,
    /// Frames that the viewer did not show.
    pub dropped_viewer: u64,
    /// A thread of the twin has ended by a panic: nothing is computed any more, or no damage kept.
    pub solver_ended: bool,
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

impl From<QueueStats> for QueueHealth {
    fn from(queue: QueueStats) -> Self {
        Self {
            name: queue.name,
            capacity: queue.capacity,
            len: queue.len,
            policy: match queue.when_full {
                WhenFull::Refuse => "refused and said so",
                WhenFull::DropOldest => "oldest dropped",
                WhenFull::DropNewest => "newest dropped",
            },
            pushed: queue.pushed,
            dropped: queue.dropped,
        }
    }
}

/// Takes a copy of everything that the node receives and sends. Called from the node's threads: nothing of it waits.
pub trait Recording: Send + Sync + 'static {
    /// These bytes were sent, encapsulation header included.
    fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>);

    /// These bytes were received; `source_stamp` is its sender's, nanoseconds since the epoch.
    fn received(&self, endpoint: &Endpoint, bytes: Vec<u8>, source_stamp: Option<i64>);

    /// Something that was received did not come to the twin.
    fn not_taken(&self, endpoint: &Endpoint, what: &str, reason: &str);

    /// An entry of the twin's journal.
    fn journal(&self, entry: &Journal);

    /// How the recording does.
    fn health(&self) -> RecordingHealth;
}

/// How a recording does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingHealth {
    /// Its queue.
    pub queue: QueueHealth,
    /// Messages that are in no file.
    pub lost: u64,
    /// What keeps it from writing; `None`: nothing does.
    pub problem: Option<String>,
    /// What else there is to know, for people.
    pub values: Vec<(String, String)>,
}
