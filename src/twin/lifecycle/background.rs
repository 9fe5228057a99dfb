//! What another thread has to compute for the twin now.

use super::Twin;
use crate::twin::background::BackgroundTask;

impl Twin {
    /// What is to be computed in the background, the most urgent first.
    pub fn background_tasks(&self) -> impl Iterator<Item = BackgroundTask> {
        let opinion = self.opinion_task().map(Box::new);
        let opinion = opinion.map(BackgroundTask::SecondOpinion);
        let range = self.range_task().map(Box::new).map(BackgroundTask::Range);
        let critical = || self.critical_velocity_task();
        let critical = std::iter::once_with(critical).flatten();
        opinion.into_iter().chain(range).chain(
            critical
                .map(Box::new)
                .map(BackgroundTask::CriticalVelocities),
        )
    }

    /// Whether this is still to be computed.
    #[must_use]
    pub fn awaits(&self, task: &BackgroundTask) -> bool {
        match task {
            // One response has one second opinion and one range.
            BackgroundTask::SecondOpinion(task) => {
                self.awaits_opinion() && self.journal.responses == task.response
            }
            BackgroundTask::Range(task) => {
                self.awaits_range() && self.journal.responses == task.response
            }
            BackgroundTask::CriticalVelocities(task) => {
                self.critical_velocity_task().is_some_and(|it| it == **task)
            }
        }
    }
}
