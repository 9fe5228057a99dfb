//! The critical velocities of the column at rest: how fast each vehicle may hit it next. The twin tells what is to be computed
//! and keeps the result; another thread computes it.

use std::sync::Arc;

use super::command::Accepted;
use super::lifecycle::Twin;
use super::plant::Plant;
use crate::assessment::Action;
use crate::column::ColumnProperties;
use crate::parameters::Parameters;
use crate::standing::{is_same_height, with_impact_height};
use crate::study::{StudyColumn, VehicleLimits, vehicle_limits_on};

/// All on which the critical velocities of the column at rest depend, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalVelocityTask {
    pub(super) parameters: Arc<Parameters>,
    pub(super) at_rest: Plant,
    pub(super) action: Action,
}

impl CriticalVelocityTask {
    /// Computes the critical velocities, see [`vehicle_limits_on`]; `go_on` is asked before each response, and `None` is the
    /// result once it returns false. Where the hinges at the impact point are not damaged, each vehicle strikes where it does if
    /// the column is given by its height, otherwise at the height of the parameters; hinges that are damaged take all impacts.
    /// Empty for a column that cannot be computed.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Arc<[VehicleLimits]>> {
        let properties = self.parameters.column_properties();
        let struck_at = |properties: &ColumnProperties| {
            let moved = self.at_rest.with_hinges_at_impact(properties);
            let (model, rest) = moved.unwrap_or((self.at_rest.model, self.at_rest.state));
            StudyColumn::at_rest(&self.parameters, model, rest)
        };
        let Ok(column) = struck_at(&properties) else {
            return Some(Arc::default());
        };
        // By height; the catalogue has few.
        let mut others: Vec<(f64, Arc<StudyColumn>)> = Vec::new();
        let mut elsewhere = |vehicle: &str| {
            let height = self.parameters.impact_height_of(vehicle)?;
            if is_same_height(height, properties.length_below) {
                return None;
            }
            let known = others.iter().find(|(known, _)| *known == height);
            if let Some((_, known)) = known {
                return Some(Arc::clone(known));
            }
            let there = struck_at(&with_impact_height(&properties, height)).ok()?;
            let there = Arc::new(there);
            others.push((height, Arc::clone(&there)));
            Some(there)
        };
        vehicle_limits_on(&column, &mut elsewhere, self.action, go_on).map(Arc::from)
    }
}

/// Critical velocities, and the column to which they belong.
#[derive(Debug)]
pub(super) struct KnownCriticalVelocities {
    task: CriticalVelocityTask,
    pub vehicles: Arc<[VehicleLimits]>,
}

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
