//! The second opinion on an impact as a message.

use super::assessment::action_code;
use crate::messages::column_twin_msgs::{ImpactReport, SecondOpinion};
use crate::messages::from_column::outcome_code;
use crate::second_opinion;
use crate::twin::{Assessed, OpinionState};

impl SecondOpinion {
    /// That there is none, for this reason.
    pub(super) fn none(reason: &str) -> Self {
        Self {
            text: reason.to_owned(),
            ..Self::default()
        }
    }
}

impl ImpactReport {
    /// The report with the second opinion, which the assessment has once it is known.
    pub(super) fn with_opinion(self, state: &OpinionState, assessed: Option<&Assessed>) -> Self {
        let known = assessed.and_then(|it| it.second_opinion.as_deref());
        let beam = match (state, known) {
            (OpinionState::None(reason), _) => SecondOpinion::none(reason),
            (OpinionState::Known, Some(known)) => known.into(),
            (OpinionState::Known, None) => SecondOpinion::none(NOT_ASSESSED),
            (OpinionState::Awaited, _) => SecondOpinion {
                state: SecondOpinion::PENDING,
                ..SecondOpinion::none(PENDING)
            },
        };
        Self { beam, ..self }
    }
}

const PENDING: &str = "the second opinion is being computed";
const NOT_ASSESSED: &str = "no second opinion: the column cannot be assessed";

impl From<&second_opinion::SecondOpinion> for SecondOpinion {
    fn from(opinion: &second_opinion::SecondOpinion) -> Self {
        let beam = &opinion.beam;
        Self {
            state: Self::KNOWN,
            text: opinion.to_string(),
            outcome: outcome_code(opinion.outcome()),
            max_displacement: beam.max_displacement_m,
            max_sideways: beam.max_sideways_m,
            max_displacement_time: beam.max_displacement_time_s,
            residual_displacement: beam.residual_displacement_m,
            residual_sideways: beam.residual_sideways_m,
            undamaged_capacity: beam.undamaged_capacity_n,
            residual_capacity: beam.residual_capacity_n,
            base_shear: beam.base_shear_n,
            base_moment: beam.base_moment_n_m,
            error_estimate: beam.error_estimate,
            ratio_to_two_bars: opinion.ratio_to_two_bars.unwrap_or(f64::NAN),
            action: opinion
                .action()
                .map_or(ImpactReport::ACTION_UNKNOWN, action_code),
            counts: !opinion.counts.is_empty(),
            decides: opinion.decides,
        }
    }
}
