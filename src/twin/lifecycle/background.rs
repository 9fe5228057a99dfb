//! What another thread has to compute for the twin now.

use super::Twin;
use crate::twin::background::BackgroundTask;

impl Twin {
    /// What is to be computed in the background, the most urgent first.
    pub fn background_tasks(&self) -> impl Iterator<Item = BackgroundTask> {
        let range = self.range_task().map(Box::new).map(BackgroundTask::Range);
        let critical = || self.critical_velocity_task();
        let critical = std::iter::once_with(critical).flatten();
        range.into_iter().chain(
            critical
                .map(Box::new)
                .map(BackgroundTask::CriticalVelocities),
        )
    }

    /// Whether this is still to be computed.
    #[must_use]
    pub fn awaits(&self, task: &BackgroundTask) -> bool {
        match task {
            // One response has one range.
            BackgroundTask::Range(task) => {
                self.awaits_range() && self.journal.responses == task.response
            }
            BackgroundTask::CriticalVelocities(task) => {
                self.critical_velocity_task().is_some_and(|it| it == **task)
            }
        }
    }
}
