//! Computes again what a recorded twin was told by the thread in the background, once for columns that differ by their names
//! only.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::twin::{BackgroundTask, Command};

/// Results that are kept for other columns of a fleet; the oldest is dropped.
const MAX_KNOWN: usize = 64;

/// What was computed, and the command with the result.
type Known = (BackgroundTask, Command);

/// Results that were computed for some column of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownResults(Rc<RefCell<VecDeque<Known>>>);

impl KnownResults {
    /// Compares a recorded result with that of the task that the recomputed twin has; the command that gives the twin its own.
    pub fn check(
        &self,
        recorded: &Command,
        task: Option<BackgroundTask>,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> Command {
        use Command::{CriticalVelocities, VerdictRange};
        let computed = task.and_then(|task| self.of(task));
        let what = match recorded {
            VerdictRange(_) => "range of the verdict",
            _ => "critical velocities",
        };
        let difference = match (recorded, &computed) {
            (
                CriticalVelocities { vehicles: recorded },
                Some(CriticalVelocities { vehicles: own }),
            ) => place.first_difference(recorded, own),
            (VerdictRange(recorded), Some(VerdictRange(own))) => {
                place.first_difference(recorded, own)
            }
            (recorded, own) => place.first_difference(&Some(recorded), &own.as_ref()),
        };
        if let Some(difference) = difference {
            let field = match difference.field.as_str() {
                "" => what.to_owned(),
                field if field.starts_with('[') => format!("{what}{field}"),
                field => format!("{what}.{field}"),
            };
            found.note_difference(Difference {
                field,
                ..difference
            });
        }
        // A twin that has nothing to be computed leaves the result aside.
        computed.unwrap_or_else(|| recorded.clone())
    }

    fn of(&self, task: BackgroundTask) -> Option<Command> {
        let same = |(it, _): &&Known| task.has_the_result_of(it);
        let known = self.0.borrow().iter().find(same).cloned();
        if let Some((_, command)) = known {
            return Some(command);
        }
        let command = task.compute(&mut || true)?;
        let mut known = self.0.borrow_mut();
        if known.len() == MAX_KNOWN {
            known.pop_front();
        }
        known.push_back((task, command.clone()));
        Some(command)
    }
}
