//! The critical velocities of the column at rest: asked for, taken, and forgotten.

use std::sync::Arc;

use super::Twin;
use crate::study::VehicleLimits;
use crate::twin::command::Accepted;
use crate::twin::critical::{CriticalVelocityTask, KnownCriticalVelocities};

impl Twin {
    /// What is to be computed before [`Command::CriticalVelocities`](super::Command::CriticalVelocities) can be given: the
    /// column is at rest, and its critical velocities are not known. `None` while the column responds to an impact, and if
    /// it is not assessed.
    #[must_use]
    pub fn critical_velocity_task(&self) -> Option<CriticalVelocityTask> {
        let is_known = self.response.is_some() || self.critical.is_some();
        (!is_known).then(|| self.task_at_rest()).flatten()
    }

    /// All on which the critical velocities of the column at rest depend, whether they are known or not; `None` if it is not
    /// assessed.
    #[must_use]
    pub fn task_at_rest(&self) -> Option<CriticalVelocityTask> {
        Some(CriticalVelocityTask {
            parameters: Arc::clone(self.parameters.current()),
            at_rest: self.at_rest.clone(),
            action: self.assessed.as_ref()?.assessment.action,
        })
    }

    /// Takes the critical velocities of the column at rest. If it responds to an impact by now, they are left aside.
    pub(super) fn take_critical_velocities(&mut self, vehicles: &Arc<[VehicleLimits]>) -> Accepted {
        let Some(task) = self.critical_velocity_task() else {
            return Accepted::Unchanged;
        };
        self.keep_critical_velocities(task, vehicles);
        self.status.set_changed();
        // A recording that begins at rest begins with the last checkpoint, and needs no command before it.
        self.journal.set_checkpoint_due();
        Accepted::Applied
    }

    /// Continues from a checkpoint.
    pub(super) fn restore_critical_velocities(&mut self, vehicles: Option<&Arc<[VehicleLimits]>>) {
        if let (Some(vehicles), Some(task)) = (vehicles, self.task_at_rest()) {
            self.keep_critical_velocities(task, vehicles);
        }
    }

    fn keep_critical_velocities(
        &mut self,
        task: CriticalVelocityTask,
        vehicles: &Arc<[VehicleLimits]>,
    ) {
        self.critical = Some(KnownCriticalVelocities {
            task,
            vehicles: Arc::clone(vehicles),
        });
    }

    /// Forgets the critical velocities of a column that is no longer this one. Called wherever the column at rest, its
    /// assessment or the parameters have changed, so that a twin from any later checkpoint knows the same.
    pub(super) fn forget_other_critical_velocities(&mut self) {
        let task = self.task_at_rest();
        self.critical
            .take_if(|known| Some(&known.task) != task.as_ref());
    }

    /// The critical velocities, if they are known; `None` during a response.
    pub(super) fn critical_velocities(&self) -> Option<&Arc<[VehicleLimits]>> {
        let known = self.critical.as_ref();
        known
            .filter(|_| self.response.is_none())
            .map(|it| &it.vehicles)
    }
}
