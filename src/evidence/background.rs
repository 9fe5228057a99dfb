//! Computes again what a recorded twin was told by the thread in the background, once for columns that differ by their names
//! only.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::twin::{BackgroundTask, Checkpoint, Command, JudgedImpact, OpinionState, Twin};

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
        use Command::{CriticalVelocities, SecondOpinion, VerdictRange};
        let computed = task.and_then(|task| self.of(task));
        let what = match recorded {
            SecondOpinion(_) => "second opinion",
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
            (SecondOpinion(recorded), Some(SecondOpinion(own))) => {
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

    /// Compares the second opinion and the damage of the beam that a checkpoint holds with those of the last impact, where the checkpoint
    /// says what that was.
    pub fn check_opinion(
        &self,
        checkpoint: &Checkpoint,
        twin: &Twin,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let is_known = |it: &JudgedImpact| it.opinion == OpinionState::Known;
        if !checkpoint.judged.as_ref().is_some_and(is_known) {
            return;
        }
        let task = twin.opinion_task_at_rest().map(Box::new);
        let own = match task.and_then(|it| self.of(BackgroundTask::SecondOpinion(it))) {
            Some(Command::SecondOpinion(result)) => twin.kept_at_rest(&result),
            _ => None,
        };
        let life = &checkpoint.life;
        let opinion = life
            .last_impact
            .as_ref()
            .and_then(|it| it.second_opinion.clone());
        let recorded = Some((opinion, life.beam.clone()));
        if let Some(difference) = place.first_difference(&recorded, &own) {
            found.note_difference(Difference {
                field: format!("second opinion{}", difference.field),
                ..difference
            });
        }
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
