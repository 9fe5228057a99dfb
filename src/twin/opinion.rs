//! The second opinion on an impact: what the fibre beam says beside the two bars. The twin tells what is to be computed once the
//! forecast is complete, and publishes forecast or report once more with the result, by which the action is the more severe one of
//! both models; another thread computes it.
//!
//! The beam has a damage of its own, which each second opinion carries on. An impact that the beam does not see through to its end,
//! for whatever reason, leaves a damage that the beam does not know: from then on there is none until a reset.

use std::sync::Arc;

use super::opinion_state::{BeamResult, KnownBeamDamage};
use super::plant::Plant;
use super::striking::Striking;
use crate::column::{ColumnProperties, Report};
use crate::parameters::Parameters;
use crate::second_opinion::{BeamTask, Movement, NoSecondOpinion, SecondOpinion};

/// A hit that is to be computed with the beam, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub struct OpinionTask {
    /// Number of the response.
    pub(super) response: u64,
    task: BeamTask,
}

impl OpinionTask {
    /// Computes it.
    #[must_use]
    pub fn compute(&self) -> Arc<BeamResult> {
        Arc::new(match self.task.compute() {
            Ok(answer) => BeamResult::Answer(Box::new(answer)),
            Err(reason) => BeamResult::None(reason.to_string().into()),
        })
    }

    /// How the column moves, for drawings; `None` where there is no second opinion.
    #[must_use]
    pub fn movement(&self) -> Option<Movement> {
        self.task.movement().ok()
    }

    /// Whether the result is that of another task.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        self.task == other.task
    }

    /// # Errors
    /// Why there is no second opinion, in words.
    pub(super) fn new(
        response: u64,
        parameters: &Parameters,
        struck: &ColumnProperties,
        striking: &Striking,
        before: &KnownBeamDamage,
    ) -> Result<Self, Arc<str>> {
        let lengths = [struck.length_below, struck.length_above];
        let impact = parameters.whole_impact_of(striking.impact, striking.velocity());
        let in_words = |reason: NoSecondOpinion| Arc::from(reason.to_string());
        let task = BeamTask::new(
            parameters,
            lengths,
            impact,
            striking.direction(),
            before.before()?,
        )
        .map_err(in_words)?;
        Ok(Self { response, task })
    }
}

/// An impact that the beam has looked at: with its report by the two bars, and the column that it has left.
pub(super) struct Seen<'a> {
    pub striking: &'a Striking,
    pub parameters: &'a Parameters,
    pub report: &'a Report,
    pub left: &'a Plant,
    /// The damage of the beam before it.
    pub before: &'a KnownBeamDamage,
}

impl Seen<'_> {
    /// What is kept of this result: the opinion, and the damage of the beam.
    pub fn kept(&self, found: &BeamResult) -> (Option<Arc<SecondOpinion>>, KnownBeamDamage) {
        match found {
            BeamResult::None(reason) => (None, self.before.without_opinion(self.left, reason)),
            BeamResult::Answer(answer) => {
                let direction = self.striking.direction();
                let opinion = SecondOpinion::new(answer, direction, self.parameters, self.report);
                (Some(Arc::new(opinion)), KnownBeamDamage::after(answer))
            }
        }
    }
}
