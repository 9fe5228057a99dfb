//! One impact, followed only as closely as a study needs it.
//!
//! A study compares thousands of impacts by a few numbers. It does not need the energy balance of every step, and it may end
//! a response as soon as nothing can change any more. Compared with [`Response`](super::Response):
//!
//! - While hinges flow, or a rigid impactor presses on the column, several steps are made as one (a *macro-step*).
//! - While the column is elastic, before a deformable vehicle or without contact, it moves in long explicit steps
//!   (`elastic_motion.rs`).
//! - Without contact the response ends once the energy that is left can neither reach a yield surface nor the impactor
//!   (`elastic_reach.rs`).
//! - A vehicle on which a transverse force acts is followed with the steps of the model alone, to the end of its response.
//! - A collapse or a fracture is followed again with the steps of the model, from the beginning of the macro-step in which it lies.

use super::bar::PerBar;
use super::elastic_motion::{ElasticMotion, Interruption};
use super::elastic_reach::{self, Polygon};
use super::impact::Impact;
use super::model::{Model, ModelError};
use super::modes;
use super::motion::StepError;
use super::properties::{ColumnProperties, Scheme};
use super::report::{BaseReport, End, Outcome};
use super::response::{Progress, Response, SimulationError};
use super::sample::{HINGES, WEBS};
use super::state::State;
use super::statics;

/// How long macro-steps are.
#[derive(Debug, Clone, Copy)]
struct MacroStepsPerPeriod {
    /// Per slowest period while the plastic rotations are small beside [`FAR_ROTATION`]: the column vibrates.
    near: f64,
    /// Beyond it: the column moves on as a mechanism.
    far: f64,
}

/// While a deformable vehicle pushes.
const OF_DEFORMABLE: MacroStepsPerPeriod = MacroStepsPerPeriod {
    near: 50.0,
    far: 16.0,
};

/// With a rigid impactor, whose impact impulse makes the column vibrate more.
const OF_RIGID: MacroStepsPerPeriod = MacroStepsPerPeriod {
    near: 70.0,
    far: 70.0,
};

/// Where the strength of the hinges depends on the strain rate, which has to be followed all the time.
const WITH_RATE: MacroStepsPerPeriod = MacroStepsPerPeriod {
    near: 50.0,
    far: 50.0,
};

/// Where it grows with the plastic rotation, which it does fastest as a hinge begins to flow.
const WITH_HARDENING: MacroStepsPerPeriod = MacroStepsPerPeriod {
    near: 70.0,
    far: 50.0,
};

/// Plastic rotation of a hinge, or plastic shear angle of a web, beyond which the motion of the column is large beside its vibration \[rad\].
const FAR_ROTATION: f64 = 0.01;

/// A column prepared for the responses of a study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyModel {
    model: Model,
    /// With a deformable vehicle.
    with_deformable: MacroSteps,
    /// With a rigid impactor.
    with_rigid: MacroSteps,
    motion: Option<ElasticMotion>,
    polygons: PerBar<Polygon>,
}

/// What a study needs of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyResponse {
    /// Whether the column yields, collapses or fractures.
    pub outcome: Outcome,
    /// Why the response ended.
    pub end: End,
    /// Whether it ended because nothing could change any more, before it was quiet.
    pub ended_early: bool,
    /// Peak displacement of the impact point \[m\].
    pub max_v1: f64,
    /// Largest contact force \[N\].
    pub peak_contact_force: f64,
    /// Plastic rotations of the hinges 1a, 1b, 2, 3 \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// Plastic shear angles of the webs of the bars below and above the impact point \[rad\].
    pub plastic_shear: [f64; WEBS],
    /// The equilibrium in which the column comes to rest; `None` if there is none.
    pub rest: Option<State>,
    /// The state at the end.
    pub last: State,
    /// How close an elastic column came to yielding: largest `|M/M^p|^alpha + |N/N^p|^beta`, if it is worth a look.
    pub utilisation_sum: f64,
    /// The reactions of the base.
    pub base: BaseReport,
    /// Macro-steps and steps of the model.
    pub macro_steps: u32,
    /// Long elastic steps.
    pub elastic_steps: u32,
}

impl StudyModel {
    /// Prepares a column. With `fineness` 1 the steps are those of a study; they are shorter by a larger one.
    ///
    /// # Errors
    /// Properties that make no column.
    pub fn new(properties: &ColumnProperties, fineness: f64) -> Result<Self, ModelError> {
        Ok(Self::of_model(Model::new(properties)?, fineness))
    }

    /// A column that makes the steps of its model and no longer ones: those of [`Response`], bit for bit, but the response ends
    /// as soon as nothing can change any more.
    #[must_use]
    pub fn stepwise(model: Model) -> Self {
        Self {
            polygons: elastic_reach::polygons(&model.frame),
            model,
            with_deformable: MacroSteps::SINGLE,
            with_rigid: MacroSteps::SINGLE,
            motion: None,
        }
    }

    /// As [`new`](Self::new), of a column whose model is known.
    #[must_use]
    pub fn of_model(mut model: Model, fineness: f64) -> Self {
        let plain = Self::stepwise(model);
        if model.scheme() == Scheme::Midpoint {
            // The penetration that a step of the paper's scheme leaves behind is part of its result.
            return plain;
        }
        model = model.solved_roughly();
        let stiffness = modes::transverse_stiffness(&model.frame, &model.rest.displacement());
        let macro_steps = |per_period: MacroStepsPerPeriod| {
            let per_period = match model.strength {
                Some(_) if model.properties.hardening_ratio > 0.0 => WITH_HARDENING,
                Some(_) => WITH_RATE,
                None => per_period,
            };
            let steps = |per_period: f64| {
                let longest = model.slowest_period / (per_period * fineness);
                (longest / model.step_secs).clamp(1.0, 1e6) as u32
            };
            MacroSteps {
                near: steps(per_period.near),
                far: steps(per_period.far),
            }
        };
        Self {
            with_deformable: macro_steps(OF_DEFORMABLE),
            with_rigid: macro_steps(OF_RIGID),
            model,
            motion: ElasticMotion::new(&model, stiffness, fineness),
            ..plain
        }
    }

    /// Whether it makes the steps of its model and no longer ones.
    fn is_stepwise(&self) -> bool {
        let single = MacroSteps::SINGLE;
        self.motion.is_none() && self.with_deformable == single && self.with_rigid == single
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Follows one impact on the column `rest`, at most `max_duration` \[s\] after first contact.
    ///
    /// # Errors
    /// An impact that is out of range, or a step that does not converge.
    pub fn respond(
        &self,
        rest: &State,
        impact: &Impact,
        max_duration: f64,
    ) -> Result<StudyResponse, SimulationError> {
        if impact.transverse_force > 0.0 && !self.is_stepwise() {
            // The long elastic steps and the bound of the energy know no force on the vehicle.
            return Self::stepwise(self.model.solved_exactly()).respond(rest, impact, max_duration);
        }
        let mut state = *rest;
        let response = Response::begin(&self.model, &mut state, *impact, max_duration)?;
        let mut course = Course {
            study: self,
            lengths: match impact.vehicle {
                Some(_) => self.with_deformable,
                None => self.with_rigid,
            },
            state,
            response,
            reach: Reach::Unknown,
            utilisation_sum: 0.0,
            macro_steps: 0,
            elastic_steps: 0,
        };
        let end = course.follow()?;
        Ok(course.result(end))
    }
}

/// A response under way.
struct Course<'a> {
    study: &'a StudyModel,
    lengths: MacroSteps,
    state: State,
    response: Response,
    reach: Reach,
    utilisation_sum: f64,
    macro_steps: u32,
    elastic_steps: u32,
}

/// How many steps are made as one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MacroSteps {
    near: u32,
    far: u32,
}

impl MacroSteps {
    const SINGLE: Self = Self { near: 1, far: 1 };

    fn of(&self, state: &State) -> u32 {
        let PerBar { below, above } = &state.plastic;
        let sheared = [&below.shear_angle, &above.shear_angle];
        let mut rotations = below.rotation.iter().chain(&above.rotation).chain(sheared);
        match rotations.any(|rotation| rotation.abs() > FAR_ROTATION) {
            true => self.far,
            false => self.near,
        }
    }
}

/// What is known of a column without contact since its last flow.
enum Reach {
    Unknown,
    /// It may yield again.
    Unbounded,
    /// Between which `v1` it stays \[m\].
    Bounded([f64; 2]),
}

impl Course<'_> {
    fn follow(&mut self) -> Result<End, StepError> {
        let model = &self.study.model;
        loop {
            if self.state.steps_to_contact(model).is_some_and(|it| it > 0) {
                self.response.advance(model, &mut self.state, u64::MAX)?;
                continue;
            }
            if !self.state.is_flowing() {
                if self.cannot_change() {
                    return Ok(End::AtRest);
                }
                if let Some(end) = self.glide() {
                    return Ok(end);
                }
            }
            if let Some(end) = self.macro_step()? {
                return Ok(end);
            }
        }
    }

    /// Long elastic steps for as long as they are possible; the end of the response if it is over.
    fn glide(&mut self) -> Option<End> {
        let model = &self.study.model;
        let motion = self.study.motion.as_ref()?;
        loop {
            if !ElasticMotion::applies_to(&self.state) {
                return None;
            }
            let [duration, mut quiet] = self.response.deadlines(model);
            let start = self.state.step;
            // A look at the residual period may have shown that it is not over yet.
            let soonest = model.time_of_step(start) + model.slowest_period;
            let bounds = match &self.reach {
                Reach::Bounded(v1) => Some(*v1),
                _ => None,
            };
            let mut touched = self.state.contact_force > 0.0;
            let response = &mut self.response;
            let (elastic_steps, sum) = (&mut self.elastic_steps, &mut self.utilisation_sum);
            let interruption = motion.advance(model, &mut self.state, |seen| {
                *elastic_steps += 1;
                *sum = sum.max(seen.utilisation_sum);
                response.take(model, seen);
                let now = model.time_of_step(seen.step);
                let touches = seen.contact_force > 0.0;
                if touches {
                    touched = true;
                    quiet = f64::INFINITY;
                }
                let released = touched && !touches;
                let out_of_reach = bounds.is_some_and(|[least, most]| {
                    !touches && seen.impactor_position <= least && most <= response.max_v1()
                });
                !(released || out_of_reach || now >= duration || now >= quiet.max(soonest))
            });
            if touched {
                self.reach = Reach::Unknown;
            }
            if interruption == Interruption::Yield {
                return None;
            }
            if self.cannot_change() {
                return Some(End::AtRest);
            }
            if let Progress::Over(end) = self.response.progress_at(model, &self.state) {
                return Some(end);
            }
        }
    }

    /// Whether the impactor has left for good and the energy that is left in the column can change nothing.
    fn cannot_change(&mut self) -> bool {
        let Some(impactor) = self.state.impactor.as_ref() else {
            return false;
        };
        if impactor.touched_at.is_none() || impactor.closed || !impactor.recedes_for_good() {
            return false;
        }
        if matches!(self.reach, Reach::Unknown) {
            let StudyModel {
                model, polygons, ..
            } = self.study;
            self.reach = elastic_reach::elastic_reach(model, &self.state, polygons)
                .map_or(Reach::Unbounded, Reach::Bounded);
        }
        match &self.reach {
            Reach::Bounded([least, most]) => {
                impactor.position <= *least && *most <= self.response.max_v1()
            }
            _ => false,
        }
    }

    /// One macro-step; the end of the response if it is over.
    fn macro_step(&mut self) -> Result<Option<End>, StepError> {
        let model = &self.study.model;
        let macro_step = self.lengths.of(&self.state);
        let before = (self.state, self.response);
        self.macro_steps += 1;
        let made = self.response.macro_step(model, &mut self.state, macro_step);
        match made {
            Ok(Progress::Over(end @ (End::AtRest | End::DurationReached))) => return Ok(Some(end)),
            Ok(Progress::Running) => {}
            _ if macro_step == 1 => match made? {
                Progress::Over(end) => return Ok(Some(end)),
                Progress::Running => {}
            },
            _ => {
                (self.state, self.response) = before;
                for _ in 0..macro_step {
                    self.macro_steps += 1;
                    let made = self.response.macro_step(model, &mut self.state, 1)?;
                    if let Progress::Over(end) = made {
                        return Ok(Some(end));
                    }
                }
            }
        }
        if self.state.is_flowing()
            || self.state.contact_force > 0.0
            || self.state.impact_impulse > 0.0
        {
            self.reach = Reach::Unknown;
        }
        Ok(None)
    }

    fn result(&self, end: End) -> StudyResponse {
        let model = &self.study.model;
        let stands = !matches!(end, End::Collapsed | End::Fractured);
        let outcome = match end {
            End::Collapsed => Outcome::Collapsed,
            End::Fractured => Outcome::Fractured,
            _ if self.response.has_yielded() => Outcome::Plastic,
            _ => Outcome::Elastic,
        };
        let rest = stands
            .then(|| statics::residual_state(model, &self.state))
            .flatten();
        let PerBar { below, above } = &self.state.plastic_of_steel(model);
        StudyResponse {
            outcome,
            end,
            ended_early: matches!(self.reach, Reach::Bounded(_)),
            max_v1: self.response.max_v1(),
            peak_contact_force: self.response.peak_force(),
            plastic_rotation: [
                below.rotation[0],
                above.rotation[0],
                above.rotation[1],
                below.rotation[1],
            ],
            plastic_shear: [below.shear_angle, above.shear_angle],
            rest,
            last: self.state,
            utilisation_sum: self.utilisation_sum,
            base: self.response.base_at_end(model, &self.state, end),
            macro_steps: self.macro_steps,
            elastic_steps: self.elastic_steps,
        }
    }
}
