//! Where the second opinion on an impact stands, and the damage of the column as the beam knows it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::damage_correction::{CORRECTION_FACTORS, ResidualMeasurement};
use super::plant::Plant;
use crate::second_opinion::{
    BeamAnswer, BeamDamage, BeamDamageBefore, BeamMeasurement, Movement, NoSecondOpinion,
};
use crate::sensors::Quantity;

/// Why an impact on a moving column has no second opinion.
pub(super) const MOVING: &str =
    "no second opinion: the column was still moving after an earlier impact";

/// Where the second opinion on an impact stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OpinionState {
    /// It is being computed, or will be.
    Awaited,
    /// It is known: the assessment has it.
    Known,
    /// There is none, for this reason, in words.
    None(Arc<str>),
}

/// The damage of the column as the beam knows it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KnownBeamDamage {
    /// No impact has damaged the column.
    #[default]
    Undamaged,
    /// What the impacts so far have left.
    Damaged(Arc<BeamDamage>),
    /// The same, and what was measured afterwards on the column at rest, by which the damage is corrected before the next hit.
    Corrected(Arc<BeamDamage>, ResidualMeasurement),
    /// The column has, or may have, a damage that the beam has not computed, for this reason, in words.
    Unknown(Arc<str>),
}

/// What the beam has found: a command carries it to the twin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BeamResult {
    /// Its answer.
    Answer(Box<BeamAnswer>),
    /// It has none, for this reason, in words.
    None(Arc<str>),
}

impl BeamResult {
    /// How the column has moved by its answer, for drawings; not known of an answer that was read.
    #[must_use]
    pub fn movement(&self) -> Option<Arc<Movement>> {
        match self {
            Self::Answer(answer) => answer.movement.clone(),
            Self::None(_) => None,
        }
    }
}

impl OpinionState {
    /// After this result.
    pub(super) fn after(found: &BeamResult) -> Self {
        match found {
            BeamResult::None(reason) => Self::None(Arc::clone(reason)),
            BeamResult::Answer(_) => Self::Known,
        }
    }
}

impl KnownBeamDamage {
    /// Whether no impact has damaged the column.
    #[must_use]
    pub fn is_undamaged(&self) -> bool {
        *self == Self::Undamaged
    }

    /// What the next hit finds; `None` of an undamaged column.
    ///
    /// # Errors
    /// Why the damage is not known.
    pub fn before(&self) -> Result<Option<BeamDamageBefore>, Arc<str>> {
        let known = |damage: &Arc<BeamDamage>, measured| {
            Ok(Some(BeamDamageBefore {
                damage: Arc::clone(damage),
                measured,
            }))
        };
        match self {
            Self::Undamaged => Ok(None),
            Self::Damaged(damage) => known(damage, None),
            Self::Corrected(damage, measured) => {
                let measured = BeamMeasurement {
                    is_rotation: measured.quantity == Quantity::Rotation,
                    height: measured.height,
                    value: measured.value,
                    deviation: measured.deviation,
                    factors: CORRECTION_FACTORS,
                };
                known(damage, Some(measured))
            }
            Self::Unknown(reason) => Err(Arc::clone(reason)),
        }
    }

    /// What is to be assumed until the beam has computed the impact that has left this column.
    pub(super) fn while_awaited(&self, left: &Plant) -> Self {
        match left.is_damaged() {
            true => Self::Unknown(
                "no second opinion: the fibre beam was not done with an earlier impact when the program was stopped or the next \
                 impact came"
                    .into(),
            ),
            false => self.clone(),
        }
    }

    /// After an impact on which there is no second opinion, for this reason, and that has left this column.
    pub(super) fn without_opinion(&self, left: &Plant, reason: &str) -> Self {
        match (left.is_damaged(), self) {
            (true, Self::Undamaged | Self::Damaged(_) | Self::Corrected(..)) => Self::Unknown(
                format!(
                    "no second opinion: the fibre beam did not compute an earlier impact ({reason})"
                )
                .into(),
            ),
            (true, Self::Unknown(_)) | (false, _) => self.clone(),
        }
    }

    /// After a measurement on the column at rest that has corrected the damage of the two bars. Of several the last one counts: each
    /// is met by one factor on the whole damage.
    pub(super) fn corrected_by(&self, measured: &ResidualMeasurement) -> Self {
        match self {
            Self::Damaged(damage) | Self::Corrected(damage, _) => {
                Self::Corrected(Arc::clone(damage), measured.clone())
            }
            Self::Undamaged => Self::Unknown(
                "no second opinion: a measurement has corrected the damage, and the fibre beam has none that could be corrected"
                    .into(),
            ),
            Self::Unknown(_) => self.clone(),
        }
    }

    /// Of a damaged column whose state file says nothing of the beam.
    pub(super) fn not_saved() -> Self {
        Self::Unknown(
            "no second opinion: the state file has no damage of the fibre beam; it was written by a program without one".into(),
        )
    }

    /// After an impact to which the beam gave this answer.
    pub(super) fn after(answer: &BeamAnswer) -> Self {
        match &answer.damage {
            Some(damage) => Self::Damaged(Arc::clone(damage)),
            None => Self::Unknown(NoSecondOpinion::Collapsed.to_string().into()),
        }
    }
}
