//! What the beam computes of one hit: all that takes time, as plain data that another thread can compute.

use std::sync::Arc;

use column_beam::{
    BeamColumn, BeamError, BeamModel, BeamOpinion, BeamOutcome, Damage, Hit, InTurn, Measurement,
    Movement,
};
use serde::{Deserialize, Serialize};

use super::beam::{NoSecondOpinion, beam_column};
use super::known_columns;
use super::two_threads::TwoThreads;
use crate::column::Impact;
use crate::parameters::{BeamMode, Parameters};

/// A hit on a column that is to be computed with the beam.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamTask {
    column: BeamColumn,
    hit: Hit,
    before: Option<BeamDamageBefore>,
}

/// The damage of earlier hits, as the beam knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamDamageBefore {
    /// What the hits have left.
    pub damage: Arc<Damage>,
    /// What was measured afterwards on the column at rest, by which the damage is to be corrected.
    pub measured: Option<Measurement>,
}

impl From<Arc<Damage>> for BeamDamageBefore {
    /// As the hits have left it, without a measurement.
    fn from(damage: Arc<Damage>) -> Self {
        Self {
            damage,
            measured: None,
        }
    }
}

/// What the beam has computed of a hit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamAnswer {
    /// Response and capacities.
    pub beam: BeamOutcome,
    /// Largest axial force that the undamaged column bears, and the one that the impact leaves \[N\], bowed about the axes of
    /// `beam.bow_axes`: about both at once, or held about the other one.
    pub capacity: [f64; 2],
    /// The damage that remains; `None` after a collapse.
    pub damage: Option<Arc<Damage>>,
    /// How the column has moved, for drawings; not stored, so that an answer that was read has none.
    #[serde(skip)]
    pub movement: Option<Arc<Movement>>,
}

/// A hit that a column has had, with all that the beam needs to compute it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarlierHit {
    /// Lengths of the column below and above the impact point \[m\].
    pub lengths: [f64; 2],
    /// With the whole speed of the vehicle.
    pub impact: Impact,
    /// Direction in which the vehicle travelled \[rad\].
    pub direction: f64,
}

/// The damage that these hits have left in the beam of the column of the parameters, the first one first; `None` without a hit.
///
/// # Errors
/// Why there is no second opinion on one of them, or that the column does not stand after it by the beam.
pub fn beam_damage_after(
    parameters: &Parameters,
    hits: &[EarlierHit],
) -> Result<Option<Arc<Damage>>, NoSecondOpinion> {
    let mut damage = None;
    for hit in hits {
        let before = damage.map(BeamDamageBefore::from);
        let task = BeamTask::new(parameters, hit.lengths, hit.impact, hit.direction, before)?;
        let left = task.compute()?.damage;
        damage = Some(left.ok_or(NoSecondOpinion::Collapsed)?);
    }
    Ok(damage)
}

impl BeamTask {
    /// The hit of the parameters on the undamaged column.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn of_parameters(parameters: &Parameters) -> Result<Self, NoSecondOpinion> {
        let properties = parameters.column_properties();
        let lengths = [properties.length_below, properties.length_above];
        let impact = parameters.whole_impact();
        Self::new(parameters, lengths, impact, parameters.direction(), None)
    }

    /// The hit of a vehicle in this direction \[rad\] on the column of the parameters with these lengths below and above the impact
    /// point \[m\] and the damage of earlier hits. The impact has the whole speed of the vehicle.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn new(
        parameters: &Parameters,
        [length_below, length_above]: [f64; 2],
        impact: Impact,
        direction: f64,
        before: Option<BeamDamageBefore>,
    ) -> Result<Self, NoSecondOpinion> {
        if parameters.settings().beam.mode == BeamMode::Off {
            return Err(NoSecondOpinion::SwitchedOff);
        }
        Ok(Self {
            column: BeamColumn {
                length_below,
                length_above,
                bumper_height: impact.bumper_height,
                ..beam_column(parameters)?
            },
            hit: Hit { impact, direction },
            before,
        })
    }

    /// Direction in which the vehicle travels \[rad\].
    #[must_use]
    pub fn direction(&self) -> f64 {
        self.hit.direction
    }

    /// How the column moves, for drawings; it computes the response alone.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn movement(&self) -> Result<Movement, NoSecondOpinion> {
        let model = known_columns::model(&self.column)?;
        let before = self.damage_before(&model)?;
        Ok(model.movement(&self.hit, before.as_deref())?)
    }

    /// The damage of earlier hits, corrected by what was measured.
    fn damage_before(&self, model: &BeamModel) -> Result<Option<Arc<Damage>>, NoSecondOpinion> {
        let Some(BeamDamageBefore { damage, measured }) = &self.before else {
            return Ok(None);
        };
        Ok(Some(match measured {
            Some(measured) => Arc::new(model.corrected(damage, measured)?),
            None => Arc::clone(damage),
        }))
    }

    /// Computes it with two threads, and how the column moves.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn compute(&self) -> Result<BeamAnswer, NoSecondOpinion> {
        self.compute_by(|model, before| {
            let (opinion, movement) = model.opinion_and_movement(&self.hit, before, &TwoThreads)?;
            Ok((opinion, Some(Arc::new(movement))))
        })
    }

    /// Computes it with one thread, bit for bit the same but for the movement, which it leaves out: for studies, which keep all
    /// processors busy and draw no column.
    ///
    /// # Errors
    /// Why there is no second opinion.
    pub fn compute_in_turn(&self) -> Result<BeamAnswer, NoSecondOpinion> {
        self.compute_by(|model, before| Ok((model.opinion(&self.hit, before, &InTurn)?, None)))
    }

    fn compute_by(
        &self,
        opinion_of: impl FnOnce(&BeamModel, Option<&Damage>) -> Result<Drawn, BeamError>,
    ) -> Result<BeamAnswer, NoSecondOpinion> {
        let model = known_columns::model(&self.column)?;
        let before = self.damage_before(&model)?;
        let (opinion, movement) = opinion_of(&model, before.as_deref())?;
        known_columns::keep(&self.column, opinion.undamaged);
        Ok(BeamAnswer {
            beam: opinion.outcome,
            capacity: opinion.capacity,
            damage: opinion.damage.map(Arc::new),
            movement,
        })
    }
}

/// An opinion, and how the column moves where this is drawn.
type Drawn = (BeamOpinion, Option<Arc<Movement>>);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Value;

    #[test]
    fn two_threads_give_the_answer_of_one_bit_for_bit() {
        let parameters = Parameters::default()
            .with_changes([
                ("beam.elements", Value::Integer(12)),
                ("beam.bow_axes", Value::from("both")),
                ("vehicle.name", Value::from("rigid")),
                ("impact.mass", Value::from(1500.0)),
                ("impact.velocity", Value::from(5.0)),
                ("impact.direction", Value::from(0.2)),
            ])
            .expect("admissible");
        let task = BeamTask::of_parameters(&parameters).expect("a task");
        let text = |answer: Result<BeamAnswer, NoSecondOpinion>| {
            let movement = None;
            let answer = answer.expect("an answer");
            let answer = BeamAnswer { movement, ..answer };
            // Every digit of every number, also of the damage.
            (format!("{answer:?}"), answer.damage)
        };
        let [(both, damage), (one, _)] = [task.compute(), task.compute_in_turn()].map(text);
        assert_eq!(both, one);
        // The next hit begins with that damage.
        let before = damage.map(BeamDamageBefore::from);
        assert!(before.is_some());
        let task = BeamTask { before, ..task };
        let [(both, _), (one, _)] = [task.compute(), task.compute_in_turn()].map(text);
        assert_eq!(both, one);
    }
}
