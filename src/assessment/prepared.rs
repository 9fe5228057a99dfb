//! The assessment of many impacts on one column: what does not depend on the impact is computed once, and only the
//! criteria that decide are evaluated, without their texts.

use super::criteria::{DEFINITIONS, Definition};
use super::remaining::{RemainingCapacity, buckling_resistances, imperfection};
use super::{AssessedImpact, AssessmentInput, Choice, Severity, decides, measured};
use crate::column::{
    BucklingResistance, Capacity, CapacityEnd, CapacityError, HINGES, Impact, Model, Outcome,
    State, capacity, carried_load, plastic_plateau,
};
use crate::parameters::Parameters;

/// The assessment of one column, prepared for many impacts.
#[derive(Debug, Clone)]
pub struct PreparedAssessment {
    /// Of the virgin column, without an impact and without names of criteria.
    virgin: AssessmentInput,
    resistances: [Option<BucklingResistance>; 2],
    imperfection: f64,
    /// The criteria that decide, by their index.
    deciding: Vec<usize>,
}

/// The part of an [`Assessment`](super::Assessment) that a study needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// What has to be done.
    pub severity: Severity,
    /// Name of the criterion that decides.
    pub deciding_criterion: &'static str,
    /// Smallest distance of a criterion that decides to its limit, relative to that, on either side.
    pub least_margin: f64,
}

/// What the criteria need of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssessedResponse {
    /// Whether the column yields, collapses or tears.
    pub outcome: Outcome,
    /// Plastic rotations of the hinges 1a, 1b, 2, 3 \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// Largest `v1` \[m\].
    pub max_v1: f64,
}

impl PreparedAssessment {
    /// Prepares the assessment of a column.
    ///
    /// # Errors
    /// An imperfection out of its range, which validation of the parameters excludes.
    pub fn new(parameters: &Parameters, model: &Model) -> Result<Self, CapacityError> {
        let state = State::at_rest(model);
        let remaining = RemainingCapacity::compute(parameters, model, Some(&state))?;
        let virgin = AssessmentInput::of_state(parameters, model, &state, remaining);
        let chosen = &virgin.deciding;
        let indices = 0..DEFINITIONS.len();
        Ok(Self {
            deciding: indices
                .filter(|&index| decides(&DEFINITIONS[index], chosen))
                .collect(),
            virgin: AssessmentInput {
                deciding: Vec::new(),
                ..virgin
            },
            resistances: buckling_resistances(parameters),
            imperfection: imperfection(parameters),
        })
    }

    /// As [`RemainingCapacity::compute`]. A column without plastic deformation has the capacity of the virgin one.
    ///
    /// # Errors
    /// As [`RemainingCapacity::compute`].
    pub fn remaining(
        &self,
        model: &Model,
        state: Option<&State>,
    ) -> Result<RemainingCapacity, CapacityError> {
        let RemainingCapacity {
            virgin,
            carried_load: virgin_load,
            ..
        } = self.virgin.remaining;
        let (now, carried) = match state {
            Some(state) if state.plastic == Default::default() => (virgin, virgin_load),
            Some(state) => (
                capacity(model, state, self.imperfection)?,
                carried_load(model, state),
            ),
            None => (Capacity::none(CapacityEnd::NoEquilibrium), virgin_load),
        };
        Ok(RemainingCapacity::with_resistances(
            self.resistances,
            virgin,
            now,
            carried,
        ))
    }

    /// The verdict of [`assess`](super::assess) after a response.
    #[must_use]
    pub fn verdict(
        &self,
        model: &Model,
        impact: &Impact,
        response: &AssessedResponse,
        remaining: RemainingCapacity,
    ) -> Verdict {
        let input = AssessmentInput {
            collapsed: response.outcome == Outcome::Collapsed,
            severed: response.outcome == Outcome::Severed,
            plastic_rotation: response.plastic_rotation,
            max_v1: response.max_v1.abs(),
            impact: Some(AssessedImpact::from(impact)),
            plateau: plastic_plateau(model, remaining.carried_load),
            remaining,
            // Empty: nothing is allocated.
            ..self.virgin.clone()
        };
        let mut choice = Choice::default();
        let mut least_margin = f64::INFINITY;
        for &index in &self.deciding {
            if let Ok(measured) = measured(&DEFINITIONS[index], &input) {
                choice.consider(index, &measured);
                if measured.limit != 0.0 {
                    least_margin = least_margin.min(measured.margin.abs());
                }
            }
        }
        let Definition { name, .. } = DEFINITIONS[choice.deciding()];
        Verdict {
            severity: choice.severity(),
            deciding_criterion: name,
            least_margin,
        }
    }
}
