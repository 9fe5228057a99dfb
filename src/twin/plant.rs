//! The plant: the column, and what strikes it. Knows neither the clock nor identifiers nor names of parameters.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::rejection::{Rejection, RejectionCode};
use crate::column::{
    ColumnProperties, End, Impact, Model, ModelError, PerBar, Phase, Progress, Report, Response,
    Scheme, ShearProperties, State, StepError, carried_over, residual_state,
    residual_without_bumper, with_half_the_step,
};
use crate::standing::{StandingColumn, is_same_height, with_impact_height};

/// Why a damaged column keeps its properties.
pub(super) const OF_ITS_MAKE: &str = "the column is damaged, and the damage belongs to its lengths, section, steel, resistances, \
                                      hinges and supports; reset the twin before changing them (~/reset)";

/// Whether the column can take an impact.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// It is in equilibrium, or responding to an impact.
    Standing,
    /// It has collapsed.
    Collapsed,
    /// A hinge of it is fractured.
    Fractured,
    /// It cannot be computed any further, for this reason.
    Faulted(Arc<str>),
}

/// The column at one instant: at rest with its damage, or in motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plant {
    pub model: Model,
    pub state: State,
    pub condition: Condition,
}

/// A column that is responding to an impact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Struck {
    pub model: Model,
    pub state: State,
    pub response: Response,
    /// The column without the bumper of the vehicle, as it comes to rest.
    at_rest: Model,
}

impl Plant {
    /// The undamaged column at rest under its load.
    ///
    /// # Errors
    /// The column is impossible, or does not stand under its load.
    pub fn undamaged(properties: &ColumnProperties) -> Result<Self, ModelError> {
        Model::new(properties).map(Self::undamaged_of)
    }

    /// The undamaged column of a model at rest under its load.
    pub fn undamaged_of(model: Model) -> Self {
        Self {
            model,
            state: State::at_rest(&model),
            condition: Condition::Standing,
        }
    }

    /// The column with a damage that was saved; under another load than then it is in its new equilibrium.
    ///
    /// # Errors
    /// The column is impossible.
    pub fn restored(
        properties: &ColumnProperties,
        standing: &StandingColumn,
        condition: Condition,
    ) -> Result<Self, ModelError> {
        let model = Model::new(&with_impact_height(properties, standing.impact_height))?;
        let state = standing.settled(&model);
        let mut restored = Self {
            model,
            state,
            condition,
        };
        if restored.condition != Condition::Standing {
            return Ok(restored);
        }
        let is_unchanged = residual_state(&model, &state)
            .is_some_and(|residual| is_same_equilibrium(&residual, &state));
        match equilibrium(&model, &state) {
            _ if is_unchanged => {}
            Some(residual) => restored.state = residual,
            None => restored.condition = no_equilibrium(),
        }
        Ok(restored)
    }

    /// Height of hinges 1a and 1b above the base \[m\].
    pub fn impact_height(&self) -> f64 {
        self.model.properties.length_below
    }

    /// Whether any hinge has flowed.
    pub fn is_damaged(&self) -> bool {
        is_damaged(&self.state)
    }

    /// The column at rest with other properties than those that it has had so far.
    ///
    /// # Errors
    /// The new column does not stand, or this one has a damage that belongs to the old properties.
    pub fn with_properties(
        &self,
        from: &ColumnProperties,
        to: &ColumnProperties,
    ) -> Result<Self, Rejection> {
        if self.condition != Condition::Standing {
            if from == to {
                return Ok(self.clone());
            }
            if self.condition == Condition::Fractured {
                let reason = "a hinge, a web or the base of the column is fractured; reset the twin first (~/reset)";
                return Err(Rejection::new(RejectionCode::ColumnFractured, reason));
            }
            let reason =
                "the column has collapsed or cannot be computed; reset the twin first (~/reset)";
            return Err(Rejection::new(RejectionCode::ColumnCollapsed, reason));
        }
        if !self.is_damaged() {
            return Self::undamaged(to).map_err(impossible);
        }
        if make_of(from) != make_of(to) {
            return Err(Rejection::new(RejectionCode::ColumnDamaged, OF_ITS_MAKE));
        }
        let model =
            Model::new(&with_impact_height(to, self.impact_height())).map_err(impossible)?;
        let mut changed = Self {
            model,
            ..self.clone()
        };
        // The factors of the strain rate are those of the new model; the accumulated rotations remain.
        let accumulated = changed.state.accumulated_rotation();
        changed.state.set_accumulated_rotation(&model, &accumulated);
        let statics = |it: &Model| (it.properties.top_spring_stiffness, it.properties.top_load);
        if statics(&model) != statics(&self.model) {
            changed.state = equilibrium(&model, &self.state).ok_or_else(|| {
                let reason = "with these values the damaged column has no equilibrium";
                Rejection::new(RejectionCode::NoEquilibrium, reason)
            })?;
        }
        Ok(changed)
    }

    /// A copy of the column with an impactor on its way. `properties` have hinges 1a and 1b at the height of the impact and the
    /// bumper of its vehicle, `max_duration` \[s\] bounds the response. A column that is in motion keeps the bumper of the
    /// vehicle that set it in motion.
    ///
    /// # Errors
    /// The column cannot take an impact, or not at this height.
    pub fn strike(
        &self,
        properties: &ColumnProperties,
        impact: Impact,
        max_duration: f64,
    ) -> Result<Struck, Rejection> {
        self.check_standing()?;
        let (model, mut state) = self.with_hinges_at_impact(properties)?;
        let at_rest = match bumper_of(&model.properties) > 0.0 {
            true => Model::new(&ColumnProperties {
                step_nanos: properties.step_nanos,
                ..with_bumper(&model.properties, 0.0)
            })
            .map_err(impossible)?,
            false => model,
        };
        let response = Response::begin(&model, &mut state, impact, max_duration)
            .map_err(|error| Rejection::new(RejectionCode::ImpactOutOfRange, error))?;
        Ok(Struck {
            model,
            state,
            response,
            at_rest,
        })
    }

    /// # Errors
    /// The column does not stand.
    pub fn check_standing(&self) -> Result<(), Rejection> {
        let (code, reason) = match &self.condition {
            Condition::Standing => return Ok(()),
            Condition::Collapsed => (
                RejectionCode::ColumnCollapsed,
                "the column has collapsed; reset the twin first (~/reset)".to_owned(),
            ),
            Condition::Fractured => (
                RejectionCode::ColumnFractured,
                "a hinge, a web or the base of the column is fractured; reset the twin first (~/reset)"
                    .to_owned(),
            ),
            Condition::Faulted(fault) => (
                RejectionCode::TwinFaulted,
                format!("the twin cannot continue ({fault}); reset it first (~/reset)"),
            ),
        };
        Err(Rejection::new(code, reason))
    }

    /// The column at rest with the plastic deformation of all hinges multiplied by a factor, in the equilibrium that this
    /// gives; `None` if there is none in which no hinge yields any further.
    pub fn with_damage_scaled(&self, factor: f64) -> Option<Self> {
        let mut state = self.state;
        state.scale_damage(&self.model, factor);
        Some(Self {
            state: equilibrium(&self.model, &state)?,
            ..self.clone()
        })
    }

    /// The column with its hinges 1a and 1b where `properties` have them.
    ///
    /// # Errors
    /// They cannot be there.
    pub fn with_hinges_at_impact(
        &self,
        properties: &ColumnProperties,
    ) -> Result<(Model, State), Rejection> {
        let (present, wanted) = (self.impact_height(), properties.length_below);
        if is_same_height(wanted, present) {
            return self.before_bumper(properties);
        }
        let rejected = |why: &str| {
            let reason = format!(
                "the impact is {wanted} m above the base, but hinges 1a and 1b are at {present} m, {why}"
            );
            Err(Rejection::new(RejectionCode::HeightNotPossible, reason))
        };
        if self.state.sample(&self.model).phase != Phase::Idle {
            return rejected("where they stay while the column is responding to an impact");
        }
        if is_impact_point_damaged(&self.state) {
            return rejected(
                "where they are damaged; send impacts at that height, or reset the twin (~/reset)",
            );
        }
        let model = Model::new(properties).map_err(impossible)?;
        let mut state = State::at_rest(&model);
        if self.is_damaged() {
            // Only hinges at the ends are damaged, which stay where they are.
            state.plastic = self.state.plastic;
            state.set_accumulated_rotation(&model, &self.state.accumulated_rotation());
            match equilibrium(&model, &state) {
                Some(residual) => state = residual,
                None => return rejected("and the damaged column has no equilibrium if they move"),
            }
        }
        Ok((model, state))
    }

    /// The column with its hinges where they are, before the bumper of `properties`.
    ///
    /// # Errors
    /// The bumper leaves too little of a bar clear, or the damaged column has no equilibrium before it.
    fn before_bumper(&self, properties: &ColumnProperties) -> Result<(Model, State), Rejection> {
        let own = &self.model.properties;
        if bumper_of(own) == bumper_of(properties)
            || self.state.sample(&self.model).phase != Phase::Idle
        {
            return Ok((self.model, self.state));
        }
        let model = Model::new(&ColumnProperties {
            step_nanos: properties.step_nanos,
            ..with_bumper(own, bumper_of(properties))
        })
        .map_err(impossible)?;
        let moved = carried_over(&self.model, &self.state, &model);
        let equilibrium = match self.is_damaged() {
            true => equilibrium(&model, &moved),
            false => Some(moved),
        };
        match equilibrium {
            Some(state) => Ok((model, state)),
            None => {
                let reason = "the damaged column has no equilibrium before the bumper of this vehicle; reset the twin \
                              (~/reset)";
                Err(Rejection::new(RejectionCode::NoEquilibrium, reason))
            }
        }
    }
}

/// Height of the bumper before a column \[m\].
fn bumper_of(properties: &ColumnProperties) -> f64 {
    properties.shear.map_or(0.0, |shear| shear.bumper_height)
}

/// The same column before a bumper of this height \[m\].
fn with_bumper(properties: &ColumnProperties, bumper_height: f64) -> ColumnProperties {
    let shear = properties.shear.map(|shear| ShearProperties {
        bumper_height,
        ..shear
    });
    ColumnProperties {
        shear,
        ..*properties
    }
}

fn impossible(error: ModelError) -> Rejection {
    Rejection::new(RejectionCode::ColumnImpossible, error)
}

impl Struck {
    /// The same impact with half the time step, before any step was made; `None` where the step cannot be halved.
    pub fn with_half_the_step(&self) -> Option<Self> {
        let properties = with_half_the_step(&self.model.properties)?;
        Some(Self {
            model: Model::new(&properties).ok()?,
            ..*self
        })
    }

    /// Advances by at most `max_steps`; more than one at a time only while an impactor approaches a column at rest.
    ///
    /// # Errors
    /// A step that does not converge.
    pub fn advance(&mut self, max_steps: u64) -> Result<Progress, StepError> {
        #[cfg(test)]
        let max_steps = failing_step::steps_before(&mut self.state, max_steps)?;
        self.response
            .advance(&self.model, &mut self.state, max_steps)
    }

    /// The summary of the response, which has ended like this.
    pub fn report(&self, end: End) -> Report {
        self.response.report(&self.model, &self.state, end)
    }

    /// The equilibrium that the response leaves behind once the vehicle and its bumper are gone, if there is one.
    pub fn residual(&self) -> Option<State> {
        residual_without_bumper(&self.model, &self.state, &self.at_rest)
    }

    /// The column at rest after the response, without the bumper: in its residual equilibrium, or where it was last if there is
    /// none.
    pub fn settled(&self, residual: Option<State>, condition: Condition) -> Plant {
        let model = self.at_rest;
        let state = match residual {
            // The same bits as if there had been no impact.
            Some(residual) if !is_damaged(&residual) => State::at_rest(&model),
            Some(residual) => residual,
            None => self.state,
        };
        Plant {
            model,
            state,
            condition,
        }
    }
}

/// The condition of a column whose response has ended.
pub(super) fn condition_after(end: End, residual: Option<&State>) -> Condition {
    match (end, residual) {
        (End::Collapsed, _) => Condition::Collapsed,
        (End::Fractured, _) => Condition::Fractured,
        (_, Some(_)) => Condition::Standing,
        (_, None) => no_equilibrium(),
    }
}

fn no_equilibrium() -> Condition {
    Condition::Faulted("the damaged column has no equilibrium under its load".into())
}

/// The part of the properties to which a damage belongs: without the load, what stands on the column, what a damage does not
/// depend on, and how it is computed.
pub(super) fn make_of(properties: &ColumnProperties) -> ColumnProperties {
    ColumnProperties {
        top_spring_stiffness: 0.0,
        top_mass: 0.0,
        top_load: 0.0,
        damping_ratio: 0.0,
        scheme: Scheme::ConservingMidpoint,
        step_nanos: 1,
        rate: None,
        // The rotations are the damage; the strength that they leave follows from them.
        hardening_ratio: 0.0,
        softening: None,
        base_connection: None,
        ultimate_rotation: 0.0,
        shear: properties.shear.map(|shear| ShearProperties {
            hardening: 0.0,
            max_hardening: 0.0,
            ultimate_angle: 0.0,
            ..shear
        }),
        ..with_bumper(properties, 0.0)
    }
}

fn is_impact_point_damaged(state: &State) -> bool {
    let PerBar { below, above } = &state.plastic;
    below.has_flowed(0) || above.has_flowed(0) || below.has_sheared() || above.has_sheared()
}

fn is_damaged(state: &State) -> bool {
    state.plastic != PerBar::default()
}

/// The equilibrium of a damaged column under another load, or with its hinges elsewhere, provided that no hinge yields
/// any further.
fn equilibrium(model: &Model, state: &State) -> Option<State> {
    const ROUND_OFF: f64 = 1e-9;
    let residual = residual_state(model, state)?;
    let sample = residual.sample(model);
    let mut used = sample.hinges.iter().map(|hinge| hinge.utilisation);
    let mut of_webs = sample.webs.iter().map(|web| web.utilisation);
    let yields = |utilisation: f64| utilisation > 1.0 + ROUND_OFF;
    (!used.any(yields) && !of_webs.any(yields)).then_some(residual)
}

/// Whether two equilibria are the same one, found twice: they are closer than anybody can measure.
fn is_same_equilibrium(a: &State, b: &State) -> bool {
    const NEAR: f64 = 1e-9; // m and rad
    let (a, b) = (&a.displacement, &b.displacement);
    [a.v1 - b.v1, a.u1 - b.u1, a.beta1 - b.beta1, a.u2 - b.u2]
        .iter()
        .all(|off| off.abs() < NEAR)
}

/// No impact is known any more with a step that does not converge; tests of what follows choose the step here.
#[cfg(test)]
pub mod failing_step {
    use std::cell::Cell;

    use crate::column::{State, StepError};

    thread_local! {
        static FAILING: Cell<Option<u64>> = const { Cell::new(None) };
    }

    /// From now on no response in this thread gets beyond this step.
    #[cfg(feature = "record")]
    pub fn set(step: Option<u64>) {
        FAILING.set(step);
    }

    /// The number of steps of at most `max_steps` that come before the one that fails.
    pub(super) fn steps_before(state: &mut State, max_steps: u64) -> Result<u64, StepError> {
        match FAILING.get() {
            Some(step) if step == state.step => {
                state.impact_impulse = 0.0;
                Err(StepError::NotConverged {
                    step,
                    part_secs: 1e-9,
                })
            }
            Some(step) if step > state.step => Ok(max_steps.min(step - state.step)),
            _ => Ok(max_steps),
        }
    }
}
