//! Computes recorded critical velocities again, once for columns that differ by their names only.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::study::VehicleLimits;
use crate::twin::{Command, CriticalVelocityTask};

/// Results that are kept for other columns of a fleet; the oldest is dropped.
const MAX_KNOWN: usize = 64;

/// What was computed, and the result.
type Known = (CriticalVelocityTask, Arc<[VehicleLimits]>);

/// Critical velocities that were computed for some column of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownResults(Rc<RefCell<VecDeque<Known>>>);

impl KnownResults {
    /// Compares recorded critical velocities with those of the task that the recomputed twin has; the command that gives it its own.
    pub fn check(
        &self,
        recorded: &Arc<[VehicleLimits]>,
        task: Option<CriticalVelocityTask>,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> Command {
        let computed = task.and_then(|task| self.of(task));
        if let Some(difference) = place.first_difference(&Some(recorded), &computed.as_ref()) {
            found.note_difference(Difference {
                field: format!("critical velocities{}", difference.field),
                ..difference
            });
        }
        Command::CriticalVelocities {
            vehicles: computed.unwrap_or_default(),
        }
    }

    fn of(&self, task: CriticalVelocityTask) -> Option<Arc<[VehicleLimits]>> {
        let same = |(it, _): &&Known| task.has_the_result_of(it);
        let known = self.0.borrow().iter().find(same).cloned();
        if let Some((_, vehicles)) = known {
            return Some(vehicles);
        }
        let vehicles = task.compute(&mut || true)?;
        let mut known = self.0.borrow_mut();
        if known.len() == MAX_KNOWN {
            known.pop_front();
        }
        known.push_back((task, Arc::clone(&vehicles)));
        Some(vehicles)
    }
}
