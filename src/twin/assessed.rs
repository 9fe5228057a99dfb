//! The residual capacity of the column at rest, and its assessment.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::plant::{Condition, Plant};
use super::striking::Striking;
use crate::assessment::{
    AssessedImpact, Assessment, AssessmentInput, BaseDemand, ResidualCapacity, Utilisation, assess,
    imperfection,
};
use crate::column::{Capacity, CapacityEnd, End, Model, PushDown, Report, State, VehicleReport};
use crate::parameters::Parameters;
use crate::second_opinion::SecondOpinion;

/// Increments of a push-down between two looks at the budget.
const INCREMENTS: u64 = 16;

/// The last impact, as far as the assessment of the column at rest and the status need it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LastImpact {
    /// What hit the column.
    pub impact: AssessedImpact,
    /// Peak `v1` of its response \[m\].
    pub max_v1: f64,
    /// `v1` that its response has left \[m\], before the bumper, as in its report; `None` where there is no equilibrium, and after
    /// a correction of the damage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_v1: Option<f64>,
    /// Which part of the column came closest to its strength.
    // Absent in recordings and states of programs that do not keep it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub utilisation: Option<Utilisation>,
    /// The vehicle after the response.
    pub vehicle: VehicleReport,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// What it and the impacts before it have put into the base; `None` in states of programs that know no connections.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<BaseDemand>,
    /// What the beam says of it; `None` where there is no second opinion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_opinion: Option<Arc<SecondOpinion>>,
    /// Whether its response was computed to its end. Otherwise the damage may be more than is known, and nothing is assessed.
    pub is_complete: bool,
}

impl LastImpact {
    /// The impact of a response that has ended with this report, after impacts that have put `base_before` into the base.
    pub(super) fn new(
        striking: &Striking,
        report: &Report,
        error_estimate: Option<f64>,
        base_before: Option<&BaseDemand>,
    ) -> Self {
        Self {
            impact: AssessedImpact {
                direction: striking.direction(),
                ..AssessedImpact::from(&striking.impact)
            },
            max_v1: report.max_v1,
            residual_v1: report.residual_v1,
            utilisation: Some(Utilisation::of_report(report)),
            vehicle: report.vehicle,
            error_estimate,
            base: Some(BaseDemand::of(report).after(base_before)),
            second_opinion: None,
            is_complete: report.end != End::NotConverged,
        }
    }
}

/// The assessment of the column at rest, with the capacity behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessed {
    /// Undamaged and present capacity, and what they mean for the load.
    pub remaining: ResidualCapacity,
    /// Action and criteria, by both models where there is a second opinion.
    pub assessment: Assessment,
    /// The second opinion with its verdict; `None` where there is none, or not yet.
    pub second_opinion: Option<Arc<SecondOpinion>>,
}

/// Capacities of a column: undamaged, and as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Capacities {
    pub undamaged: Capacity,
    pub now: Capacity,
}

/// An undamaged capacity with all that it depends on, so that it is computed once per column.
#[derive(Debug, Clone, Copy)]
pub(super) struct UndamagedCapacity {
    model: Model,
    imperfection: f64,
    capacity: Capacity,
}

impl UndamagedCapacity {
    /// The capacity, if it is that of this column.
    fn of(&self, model: &Model, imperfection: f64) -> Option<Capacity> {
        let is_same = self.model == *model && self.imperfection == imperfection;
        is_same.then_some(self.capacity)
    }
}

/// The push-downs of a column at rest, advanced in slices.
#[derive(Debug)]
pub(super) struct PushDowns {
    at_rest: Plant,
    imperfection: f64,
    undamaged: Option<Capacity>,
    under_way: Option<PushDown>,
}

impl PushDowns {
    /// `known` is an undamaged capacity that may be that of this column.
    pub fn new(at_rest: Plant, imperfection: f64, known: Option<&UndamagedCapacity>) -> Self {
        let undamaged = known.and_then(|known| known.of(&at_rest.model, imperfection));
        Self {
            at_rest,
            imperfection,
            undamaged,
            under_way: None,
        }
    }

    /// The column.
    pub fn at_rest(&self) -> &Plant {
        &self.at_rest
    }

    /// Makes increments, which are taken from `budget`. `None` until all are made; then the capacities, `None` where there
    /// are none because the column cannot be computed.
    pub fn advance(&mut self, budget: &mut u64) -> Option<Option<Capacities>> {
        loop {
            let Plant {
                model,
                state,
                condition,
            } = &self.at_rest;
            let undamaged_state = State::at_rest(model);
            let wanted = match (self.undamaged, condition) {
                (None, _) => &undamaged_state,
                (Some(undamaged), _) => {
                    let done = |now| Some(Some(Capacities { undamaged, now }));
                    match condition {
                        Condition::Collapsed => {
                            return done(Capacity::none(CapacityEnd::NoEquilibrium));
                        }
                        Condition::Fractured => {
                            return done(Capacity::none(CapacityEnd::Fractured));
                        }
                        Condition::Faulted(_) => return Some(None),
                        Condition::Standing if *state == undamaged_state => return done(undamaged),
                        Condition::Standing => state,
                    }
                }
            };
            let push_down = match &mut self.under_way {
                Some(push_down) => push_down,
                None => match PushDown::new(model, wanted, self.imperfection) {
                    Ok(begun) => self.under_way.insert(begun),
                    // The parameters were checked against each other.
                    Err(_) => return Some(None),
                },
            };
            if *budget == 0 {
                return None;
            }
            let increments = INCREMENTS.min(*budget);
            *budget -= increments;
            let Some(capacity) = push_down.advance(increments as u32) else {
                continue;
            };
            self.under_way = None;
            match self.undamaged {
                None => self.undamaged = Some(capacity),
                Some(undamaged) => {
                    return Some(Some(Capacities {
                        undamaged,
                        now: capacity,
                    }));
                }
            }
        }
    }

    /// The undamaged capacity, for [`PushDowns::new`] of the same column.
    pub fn undamaged(&self) -> Option<UndamagedCapacity> {
        Some(UndamagedCapacity {
            model: self.at_rest.model,
            imperfection: self.imperfection,
            capacity: self.undamaged?,
        })
    }
}

/// The assessment of a column at rest after its last impact, if there was one. It depends on nothing else, so that a column
/// that was restored from a checkpoint has the same assessment.
pub(super) fn assessed(
    parameters: &Parameters,
    at_rest: &Plant,
    last: Option<&LastImpact>,
    capacities: &Capacities,
) -> Arc<Assessed> {
    let Plant {
        model,
        state,
        condition,
    } = at_rest;
    let standing = (*condition == Condition::Standing).then_some(state);
    let Capacities { undamaged, now } = *capacities;
    let remaining = ResidualCapacity::new(parameters, model, standing, undamaged, now);
    let mut input = AssessmentInput::of_state(parameters, model, state, remaining);
    input.collapsed = *condition == Condition::Collapsed;
    input.fractured = *condition == Condition::Fractured;
    if *condition != Condition::Standing {
        input.residual_v1 = None;
    }
    if let Some(last) = last {
        // Without the bumper the webs are longer, and the same angles stand for a little less: the report and the verdict give one
        // value.
        if let (Some(now), Some(left)) = (&mut input.residual_v1, last.residual_v1) {
            *now = if left.abs() > now.abs() { left } else { *now };
        }
        input.max_v1 = input.max_v1.max(last.max_v1.abs());
        input = input.struck_by(model, state, last.impact);
        input.base_demand = last.base;
        let utilisation = last.utilisation.into_iter().chain(input.utilisation);
        input.utilisation = utilisation.reduce(Utilisation::or_larger);
    }
    let mut assessment = assess(&input);
    let opinion = last.and_then(|last| last.second_opinion.as_ref());
    Arc::new(Assessed {
        remaining,
        second_opinion: opinion.map(|it| Arc::new(it.weighed(&input, &mut assessment, None))),
        assessment,
    })
}

/// The same assessment after the last impact has got its second opinion.
pub(super) fn assessed_again(
    known: &Assessed,
    parameters: &Parameters,
    at_rest: &Plant,
    last: &LastImpact,
) -> Arc<Assessed> {
    let ResidualCapacity { undamaged, now, .. } = known.remaining;
    assessed(
        parameters,
        at_rest,
        Some(last),
        &Capacities { undamaged, now },
    )
}

/// The assessment of a column at rest, computed at once; `None` if the column or its last response cannot be computed. The undamaged capacity is kept
/// in `known`.
pub(super) fn assess_at_once(
    parameters: &Parameters,
    at_rest: &Plant,
    last: Option<&LastImpact>,
    known: &mut Option<UndamagedCapacity>,
) -> Option<Arc<Assessed>> {
    if last.is_some_and(|last| !last.is_complete) {
        return None;
    }
    let imperfection = imperfection(parameters);
    let mut push_downs = PushDowns::new(at_rest.clone(), imperfection, known.as_ref());
    let capacities = push_downs.advance(&mut u64::MAX.clone())?;
    *known = push_downs.undamaged();
    Some(assessed(parameters, at_rest, last, &capacities?))
}
