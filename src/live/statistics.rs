//! What a live twin or a fleet tells about itself.

use thiserror::Error;

use super::queue::QueueStats;
use super::real_time::RealTimeGrants;

/// A thread of the twin panicked; its message is on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("thread {0} panicked; please report its message on standard error")]
pub struct Panicked(pub(super) &'static str);

/// Statistics of a live twin, or of a fleet.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveStatistics {
    /// Jobs of the solver threads, such as a request, a slice of a forecast or the steps up to a deadline.
    pub cycles: u64,
    /// Jobs that started at least one period late.
    pub overruns: u64,
    /// Periods skipped by late jobs.
    pub skipped_periods: u64,
    /// Maximum delay of a job after its deadline \[ns\].
    pub worst_lateness: u64,
    /// Steps of all responses.
    pub steps: u64,
    /// Newton iterations of these steps.
    pub newton_iterations: u64,
    /// Locks for which a solver thread had to wait for another one; none for a single column, which has one solver thread.
    pub contended_locks: u64,
    /// State files that could not be written.
    pub state_file_failures: u64,
    /// Estimates that the twin could not take.
    pub lost_estimates: u64,
    /// All queues.
    pub queues: Vec<QueueStats>,
    /// The real-time properties that were granted.
    pub real_time: RealTimeGrants,
}
