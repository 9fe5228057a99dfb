//! By which model a study judges an impact, and what the fibre beam says of it.

use serde::Serialize;

use super::study_column::{Evaluation, StudyError};
use crate::assessment::{Action, Assessment, largest_plastic_rotation};
use crate::parameters::{BeamMode, Parameters};
use crate::second_opinion::{JointVerdict, JudgeError, NoSecondOpinion, SecondOpinion};

/// By which model a study judges an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VerdictModel {
    /// The two bars.
    #[default]
    Bars,
    /// The fibre beam alone.
    Beam,
    /// The more severe verdict of both where that of the beam counts, otherwise that of the two bars, as in a node.
    Both,
}

/// A model other than the two bars that the parameters switch off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the model {} needs the fibre beam, which beam.mode: off switches off; set beam.mode to second_opinion or governing, or judge by the bars",
    .0.name()
)]
pub struct BeamSwitchedOff(pub VerdictModel);

/// What the fibre beam says of an impact, as far as a study compares it.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyOpinion {
    /// Its response and capacities, and why its verdict counts; without the texts of its verdict.
    pub opinion: SecondOpinion,
    /// The action by the beam alone; `None` without the capacities of the two bars.
    pub action: Option<Action>,
}

impl VerdictModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Bars, Self::Beam, Self::Both];

    /// Its name in options and files: `bars`, `beam` or `both`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bars => "bars",
            Self::Beam => "beam",
            Self::Both => "both",
        }
    }

    /// The model of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }

    /// By what it judges, as a part of a sentence; `None` for the two bars alone.
    #[must_use]
    pub fn in_words(self) -> Option<&'static str> {
        match self {
            Self::Bars => None,
            Self::Beam => Some("by the fibre beam"),
            Self::Both => Some(
                "by the two bars and the fibre beam, the more severe one where that of the beam counts",
            ),
        }
    }

    /// # Errors
    /// The model needs the beam, and these parameters switch it off.
    pub fn check_on(self, parameters: &Parameters) -> Result<(), BeamSwitchedOff> {
        let is_off = parameters.settings().beam.mode == BeamMode::Off;
        match is_off && self != Self::Bars {
            true => Err(BeamSwitchedOff(self)),
            false => Ok(()),
        }
    }

    /// What a verdict of both models says by this model, and what the beam says. By the two bars and by both, the numbers are those
    /// of the two bars; by the beam, action, criterion, outcome, displacements in any direction and capacities are its own.
    ///
    /// # Errors
    /// The model is the beam, and there is no second opinion.
    pub(super) fn evaluation(
        self,
        joint: JointVerdict,
    ) -> Result<(Evaluation, Result<StudyOpinion, NoSecondOpinion>), NoSecondOpinion> {
        let JointVerdict {
            report,
            input,
            assessment,
            second_opinion,
        } = joint;
        let shear = report.webs.iter().map(|web| web.plastic_angle.abs());
        let by = |assessment: &Assessment| (assessment.action, assessment.deciding_criterion);
        let (action, deciding_criterion) = by(&assessment);
        let remaining = &input.remaining;
        let mut evaluation = Evaluation {
            action,
            deciding_criterion,
            outcome: report.outcome,
            max_v1: report.max_v1,
            residual_v1: report.residual_v1,
            peak_contact_force: report.peak_contact_force,
            residual_capacity: remaining.now.force,
            capacity_ratio: remaining.ratio,
            reserve: remaining.reserve,
            max_plastic_rotation: largest_plastic_rotation(&input.plastic_rotation),
            max_plastic_shear: shear.fold(0.0, f64::max),
            base_utilisation: input.base_utilisation(),
        };
        let opinion = match (self, second_opinion) {
            (Self::Beam, Err(reason)) => return Err(reason),
            (_, Err(reason)) => return Ok((evaluation, Err(reason))),
            (_, Ok(opinion)) => opinion,
        };
        if self == Self::Beam {
            let seen = opinion.seen_by_the_beam(&input);
            if let Some(own) = &opinion.assessment {
                (evaluation.action, evaluation.deciding_criterion) = by(own);
            }
            evaluation.outcome = opinion.outcome();
            evaluation.max_v1 = seen.max_v1;
            evaluation.residual_v1 = seen.residual_v1;
            evaluation.residual_capacity = seen.remaining.now.force;
            evaluation.capacity_ratio = seen.remaining.ratio;
            evaluation.reserve = seen.remaining.reserve;
            evaluation.base_utilisation = seen.base_utilisation();
        }
        let action = opinion.action();
        let opinion = SecondOpinion {
            assessment: None,
            ..opinion
        };
        Ok((evaluation, Ok(StudyOpinion { opinion, action })))
    }
}

impl From<JudgeError> for StudyError {
    fn from(error: JudgeError) -> Self {
        match error {
            JudgeError::Simulation(error) => Self::Simulation(error),
            JudgeError::Capacity(error) => Self::Capacity(error),
        }
    }
}
