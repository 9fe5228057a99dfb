//! The assessment of many impacts on one column: what does not depend on the impact is computed once, and only the
//! criteria that decide are evaluated, without their texts.

use std::sync::OnceLock;

use super::base::{BaseDemand, ConnectedBase};
use super::criteria::DEFINITIONS;
use super::criterion::PART_OF_LENGTH;
use super::definition::Definition;
use super::remaining::{ResidualCapacity, VerdictBasis, imperfection};
use super::{
    Action, AssessedImpact, AssessedShear, AssessmentInput, Choice, VerdictLoad, decides, measured,
};
use crate::column::{
    BaseReport, Capacity, CapacityEnd, CapacityError, HINGES, Impact, KnownCapacity, Model,
    Outcome, PerBar, PushDown, State, WEBS, capacity, capacity_up_to, plastic_plateau,
};
use crate::parameters::Parameters;

/// Bound of the capacity of any column, relative to its squash load, which the normal force in no hinge can exceed.
const MAX_CAPACITY: f64 = 1.01;

/// Steps of the search for the capacity that decides an action, each of which halves its bracket.
const CAPACITY_HALVINGS: u32 = 10;

/// The assessment of one column, prepared for many impacts.
#[derive(Debug, Clone)]
pub struct PreparedAssessment {
    /// Of the undamaged column, without an impact, without names of criteria and without its capacities.
    input: AssessmentInput,
    basis: VerdictBasis,
    imperfection: f64,
    /// The criteria that decide, by their index.
    deciding: Vec<usize>,
    /// The capacity of the undamaged column, once an impact has needed it.
    undamaged: OnceLock<Capacity>,
    /// Whether the steel of the column has the largest strength that it may have, so that the forces into the base contain its
    /// overstrength.
    has_overstrength: bool,
    /// What earlier impacts have put into the base.
    base_before: Option<BaseDemand>,
}

/// The part of an [`Assessment`](super::Assessment) that a study needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// What has to be done.
    pub action: Action,
    /// Name of the criterion that decides.
    pub deciding_criterion: &'static str,
    /// Smallest distance of a criterion that decides to its limit, relative to that, on either side; that of a residual bow
    /// relative to the largest one where that is larger, because it has the error of the peak displacement.
    pub least_margin: f64,
}

/// What the criteria need of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssessedResponse {
    /// Whether the column yields, collapses or fractures.
    pub outcome: Outcome,
    /// Plastic rotations of the hinges 1a, 1b, 2, 3 \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// Plastic shear angles of the webs of the bars below and above the impact point \[rad\].
    pub plastic_shear: [f64; WEBS],
    /// `v1` of the residual equilibrium \[m\]; `None` if there is none.
    pub residual_v1: Option<f64>,
    /// Peak `v1` \[m\].
    pub max_v1: f64,
    /// The reactions of the base.
    pub base: BaseReport,
}

impl PreparedAssessment {
    /// Prepares the assessment of a column.
    ///
    /// # Errors
    /// An imperfection out of its range, which validation of the parameters excludes.
    pub fn new(parameters: &Parameters, model: &Model) -> Result<Self, CapacityError> {
        let state = State::at_rest(model);
        let imperfection = imperfection(parameters);
        // Finds an imperfection that is out of range before the first impact does.
        PushDown::new(model, &state, imperfection)?;
        let basis = VerdictBasis::of(parameters);
        let unknown = Capacity::none(CapacityEnd::NoEquilibrium);
        let loads = basis.loads(model, Some(&state));
        let remaining = ResidualCapacity::with(&basis, loads, unknown, unknown);
        let input = AssessmentInput::of_state(parameters, model, &state, remaining);
        let chosen = &input.deciding;
        let indices = 0..DEFINITIONS.len();
        Ok(Self {
            deciding: indices
                .filter(|&index| decides(&DEFINITIONS[index], chosen))
                .collect(),
            input: AssessmentInput {
                deciding: Vec::new(),
                no_base: None,
                // Empty but for the load: nothing is allocated.
                load: VerdictLoad {
                    top_load: input.load.top_load,
                    ..VerdictLoad::default()
                },
                assumed: Vec::new(),
                ..input
            },
            basis,
            imperfection,
            undamaged: OnceLock::new(),
            has_overstrength: false,
            base_before: None,
        })
    }

    /// The same, where the steel has the largest strength that it may have: the forces into the base are not multiplied by the
    /// overstrength once more, and the base bears no more than that of these parameters with the nominal strength.
    #[must_use]
    pub fn with_overstrength(mut self, nominal: &Parameters) -> Self {
        self.input.base = ConnectedBase::of(nominal).ok();
        self.has_overstrength = true;
        self
    }

    /// The same after impacts that have put this into the base.
    #[must_use]
    pub fn with_base_before(self, base_before: Option<BaseDemand>) -> Self {
        Self {
            base_before,
            ..self
        }
    }

    /// What earlier impacts have put into the base.
    #[must_use]
    pub fn base_before(&self) -> Option<&BaseDemand> {
        self.base_before.as_ref()
    }

    /// Whether the base is checked.
    #[must_use]
    pub fn has_base(&self) -> bool {
        self.input.base.is_some()
    }

    /// The largest utilisation of the base in a response, by shear, moment or uplift: above 1 its connection fails. `None` where
    /// the base is not known.
    #[must_use]
    pub fn base_utilisation(&self, response: &AssessedResponse) -> Option<f64> {
        let base = self.input.base.as_ref()?;
        Some(base.utilisation(&self.demand(response)))
    }

    /// What the base has had to bear after this response.
    #[must_use]
    pub fn demand(&self, response: &AssessedResponse) -> BaseDemand {
        let demand = BaseDemand {
            report: response.base,
            has_flowed: response.outcome != Outcome::Elastic && !self.has_overstrength,
        };
        demand.after(self.base_before.as_ref())
    }

    /// The capacity of the undamaged column, computed when it is needed for the first time.
    fn undamaged(&self, model: &Model) -> Result<Capacity, CapacityError> {
        if let Some(undamaged) = self.undamaged.get() {
            return Ok(*undamaged);
        }
        let undamaged = capacity(model, &State::at_rest(model), self.imperfection)?;
        Ok(*self.undamaged.get_or_init(|| undamaged))
    }

    /// As [`ResidualCapacity::compute`]. A column without plastic deformation has the capacity of the undamaged one.
    ///
    /// # Errors
    /// As [`ResidualCapacity::compute`].
    pub fn remaining(
        &self,
        model: &Model,
        state: Option<&State>,
    ) -> Result<ResidualCapacity, CapacityError> {
        let undamaged = self.undamaged(model)?;
        let (now, loaded) = match state {
            Some(state) if state.plastic == PerBar::default() => (undamaged, None),
            Some(state) => (capacity(model, state, self.imperfection)?, Some(state)),
            None => (Capacity::none(CapacityEnd::NoEquilibrium), None),
        };
        let loads = self.basis.loads(model, loaded);
        Ok(ResidualCapacity::with(&self.basis, loads, undamaged, now))
    }

    /// The action of the verdict after a response that leaves the column at rest in `state`, without more of the push-downs
    /// than it takes: the capacities enter all criteria such that less of them is not less severe, so that a lower bound
    /// decides where the greatest capacity that a column can have leads to the same action. `None` where a criterion that
    /// may decide is closer to its limit than `margin`, relative to it.
    ///
    /// # Errors
    /// As [`ResidualCapacity::compute`].
    pub fn action(
        &self,
        model: &Model,
        impact: &Impact,
        response: &AssessedResponse,
        state: &State,
        margin: f64,
    ) -> Result<Option<Action>, CapacityError> {
        let is_undamaged = state.plastic == PerBar::default();
        let highest = MAX_CAPACITY * model.properties.resistance_axial;
        let loads = self.basis.loads(model, Some(state));
        let known = |undamaged: f64, now: f64| {
            let [undamaged, now] = [undamaged, now].map(|force| Capacity {
                force,
                ..Capacity::none(CapacityEnd::NoEquilibrium)
            });
            let remaining = ResidualCapacity::with(&self.basis, loads, undamaged, now);
            self.verdict(model, impact, response, remaining)
        };
        // The least favourable verdict with this capacity, whatever that of the undamaged column is.
        let worst = |now: f64| known(if is_undamaged { now } else { highest }, now);
        let best = worst(highest);
        // Whether the capacity of the undamaged column is known already must not decide how, or threads would.
        if best.least_margin > margin {
            let (mut too_low, mut enough) = (0.0, highest);
            for _ in 0..CAPACITY_HALVINGS {
                let middle = 0.5 * (too_low + enough);
                if worst(middle).action == best.action {
                    enough = middle;
                } else {
                    too_low = middle;
                }
            }
            let enough = (1.0 + 2.0 * margin) * enough;
            match capacity_up_to(model, state, self.imperfection, enough)? {
                KnownCapacity::Enough => return Ok(Some(best.action)),
                KnownCapacity::Found(now) => {
                    let undamaged = match is_undamaged {
                        true => *self.undamaged.get_or_init(|| now),
                        false => self.undamaged(model)?,
                    };
                    let verdict = known(undamaged.force, now.force);
                    return Ok((verdict.least_margin > margin).then_some(verdict.action));
                }
            }
        }
        let remaining = self.remaining(model, Some(state))?;
        let verdict = self.verdict(model, impact, response, remaining);
        Ok((verdict.least_margin > margin).then_some(verdict.action))
    }

    /// The verdict of [`assess`](super::assess) after a response.
    #[must_use]
    pub fn verdict(
        &self,
        model: &Model,
        impact: &Impact,
        response: &AssessedResponse,
        remaining: ResidualCapacity,
    ) -> Verdict {
        let input = AssessmentInput {
            collapsed: response.outcome == Outcome::Collapsed,
            fractured: response.outcome == Outcome::Fractured,
            plastic_rotation: response.plastic_rotation,
            shear: AssessedShear::of(model, response.plastic_shear),
            residual_v1: response.residual_v1,
            max_v1: response.max_v1.abs(),
            impact: Some(AssessedImpact::from(impact)),
            base_demand: Some(self.demand(response)),
            plateau: plastic_plateau(model, remaining.carried_load),
            remaining,
            // Empty: nothing is allocated.
            ..self.input.clone()
        };
        let mut choice = Choice::default();
        let mut least_margin = f64::INFINITY;
        for &index in &self.deciding {
            let definition = &DEFINITIONS[index];
            if let Ok(measured) = measured(definition, &input) {
                choice.consider(index, &measured);
                if measured.limit != 0.0 {
                    let share = share_of_limit(definition, &input, measured.limit);
                    least_margin = least_margin.min(measured.margin.abs() * share);
                }
            }
        }
        let Definition { name, .. } = DEFINITIONS[choice.deciding()];
        Verdict {
            action: choice.action(),
            deciding_criterion: name,
            least_margin,
        }
    }
}

/// How much smaller the margin of a criterion is relative to the quantity that is computed with a certain relative error than
/// relative to its limit: a residual bow is a small part of the peak displacement, whose relative error is known.
fn share_of_limit(definition: &Definition, input: &AssessmentInput, limit: f64) -> f64 {
    if definition.unit != PART_OF_LENGTH {
        return 1.0;
    }
    (limit / input.bow_of_kink(input.max_v1)).min(1.0)
}
