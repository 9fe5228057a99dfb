//! One impact from its event to rest: when a response is over, and its summary.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::bar::{BarForces, PerBar, PlasticFlow};
use super::base_reactions::{BaseHistory, BaseInstant};
use super::elastic_motion::Glimpse;
use super::fracture::{Strained, base_at_end, is_torn_off};
use super::geometry::Displacement;
use super::impact::{Impact, ImpactError};
use super::ledger::Ledger;
use super::model::{Model, ModelError};
use super::modes;
use super::motion::StepError;
use super::properties::{is_default, is_zero};
use super::report::{BaseReport, End, HingeReport, Outcome, Report, VehicleReport, WebReport};
use super::sample::{HINGES, WEBS};
use super::state::{State, Velocity};
use super::statics;
use super::stepping;
use super::web_strength::WebState;
use super::yield_surface::YieldSurface;
use super::yielding::{over_hinges, share_until_shear, share_until_yield, yield_sums};

/// Kinetic energy, relative to the impactor's, below which a column and an impactor in contact are at rest.
const REST_FRACTION: f64 = 1e-9;

/// Contact force, relative to the largest of the response, below which a column and an impactor in contact may be at rest:
/// about the root of [`REST_FRACTION`]. Nothing but the column pushes an impactor that stands against it, so that its
/// resting force is 0; at the turning point of an elastic push both stand still under the largest force.
const REST_FORCE_FRACTION: f64 = 1e-4;

/// Share of the energies that a column takes elastically or holds at the event (`M_p^2 L / EI`, elastic energy, work of the
/// load) below which the input of an impact is no measure of the ledger's residual: that has the round-off of those
/// energies, however small the input is.
const LEDGER_FLOOR: f64 = 1e-5;

/// Periods of the slowest mode without flow or contact after which a response is over. One is the minimum, but a column
/// vibrates in two modes, and in the paper's example with the exponents of Duan and Chen it yields again at every second
/// crest: after one quiet period 3.4e-5 of the plastic work is still to come, after two and a quarter 1e-6.
const QUIET_PERIODS: f64 = 2.25;

/// Longest approach to a moving column that does not count as part of its response \[s\]: unlike in an approach to a
/// column at rest, every step of it is computed.
pub const MAX_APPROACH_TO_MOVING: f64 = 60.0;

/// Whether a response goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// It goes on.
    Running,
    /// It is over.
    Over(End),
}

/// Follows one response step by step. Plain data that can be copied together with the state: a response continued from
/// copies of both equals the uninterrupted one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Response {
    max_duration: f64,
    /// Instant from which `max_duration` counts: the end of the approach \[s\].
    counted_from: f64,
    /// Until when an approach to a column that moved at the event does not count: when the impactor would touch it if it
    /// stayed where it was then; 0 for a column at rest \[s\].
    approach_until: f64,
    max_v1: f64,
    max_v1_time: f64,
    max_u2: f64,
    peak_force: f64,
    peak_force_time: Option<f64>,
    worst_residual: f64,
    /// Last instant of contact \[s\].
    last_contact: f64,
    /// Last instant at which a hinge flowed \[s\].
    last_flow: f64,
    /// Time for which an impactor with a transverse force has pressed on the column since a hinge last flowed \[s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pressed: f64,
    /// Period of the slowest mode about the residual state, once it was needed after the last flow \[s\].
    residual_period: Option<f64>,
    /// First plastic flow of each hinge \[s\].
    first_yield: [Option<f64>; HINGES],
    /// Largest `|M/M^p|^alpha + |N/N^p|^beta` of each hinge.
    max_sum: [f64; HINGES],
    /// Largest dynamic increase factor of each hinge.
    max_dynamic_factor: [f64; HINGES],
    /// What has become of the webs, the values at the end not filled in.
    #[serde(default, skip_serializing_if = "is_default")]
    webs: [WebReport; WEBS],
    /// The reactions of the base.
    #[serde(default)]
    base: BaseHistory,
}

/// Why an impact could not be simulated.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SimulationError {
    /// The properties do not make a column.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The impact is out of range.
    #[error(transparent)]
    Impact(#[from] ImpactError),
    /// The equations did not converge.
    #[error(transparent)]
    Step(#[from] StepError),
}

impl Response {
    /// Begins an impact on `state`, which keeps its motion and its plastic deformation. The response is followed for
    /// at most `max_duration` \[s\].
    ///
    /// # Errors
    /// An impact that is out of range; the state is then unchanged.
    pub fn begin(
        model: &Model,
        state: &mut State,
        impact: Impact,
        max_duration: f64,
    ) -> Result<Self, ImpactError> {
        stepping::begin_impact(model, state, impact)?;
        let moves = state.velocity != Velocity::default();
        let mut response = Self {
            max_duration,
            counted_from: 0.0,
            approach_until: match moves {
                true => impact.approach_secs().min(MAX_APPROACH_TO_MOVING),
                false => 0.0,
            },
            max_v1: state.displacement.v1,
            max_v1_time: 0.0,
            max_u2: state.displacement.u2,
            peak_force: 0.0,
            peak_force_time: None,
            worst_residual: 0.0,
            last_contact: 0.0,
            last_flow: 0.0,
            pressed: 0.0,
            residual_period: None,
            first_yield: [None; HINGES],
            max_sum: [0.0; HINGES],
            max_dynamic_factor: [1.0; HINGES],
            webs: [WebReport::default(); WEBS],
            base: BaseHistory::begin(state.displacement.v1, state.base_forces(model)),
        };
        response.record_extremes(&Extremes::of(state), 0.0);
        response.record_residual_and_sums(model, state);
        Ok(response)
    }

    /// Advances the state by one step, or, while an impactor approaches a column at rest, by at most `max_coasting` steps.
    ///
    /// # Errors
    /// A step that does not converge. A collapse is no error: the response is then over.
    pub fn advance(
        &mut self,
        model: &Model,
        state: &mut State,
        max_coasting: u64,
    ) -> Result<Progress, StepError> {
        self.observed_advance::<true>(model, state, 1, max_coasting)
    }

    /// As [`Response::advance`], for one of thousands of responses, with `steps` steps that are made as one: with one, the states are
    /// the same. The residual of the ledger, the utilisations and the dynamic factors of the report are not followed.
    ///
    /// # Errors
    /// As [`Response::advance`].
    pub fn advance_unobserved(
        &mut self,
        model: &Model,
        state: &mut State,
        steps: u32,
        max_coasting: u64,
    ) -> Result<Progress, StepError> {
        self.observed_advance::<false>(model, state, steps, max_coasting)
    }

    #[inline]
    fn observed_advance<const IN_FULL: bool>(
        &mut self,
        model: &Model,
        state: &mut State,
        steps: u32,
        max_coasting: u64,
    ) -> Result<Progress, StepError> {
        if let Some(steps) = state.steps_to_contact(model).filter(|&steps| steps > 0) {
            state.coast(model, steps.min(max_coasting));
            self.counted_from = model.time_of_step(state.step);
            self.base.wait(self.counted_from);
            return Ok(Progress::Running);
        }
        self.observed_macro_step::<IN_FULL>(model, state, steps)
    }

    /// As [`Response::advance_unobserved`], but without an approach to a column at rest.
    ///
    /// # Errors
    /// As [`Response::advance`].
    pub(crate) fn macro_step(
        &mut self,
        model: &Model,
        state: &mut State,
        steps: u32,
    ) -> Result<Progress, StepError> {
        self.observed_macro_step::<false>(model, state, steps)
    }

    #[inline]
    fn observed_macro_step<const IN_FULL: bool>(
        &mut self,
        model: &Model,
        state: &mut State,
        steps: u32,
    ) -> Result<Progress, StepError> {
        let before = StepStart {
            step: state.step,
            secs: f64::from(steps) * model.step_secs,
            displacement: state.displacement,
            v1_rate: state.velocity.v1,
            contact_force: state.contact_force,
            forces: state.forces,
            plastic: state.plastic,
            strained: Strained::of(model, state),
        };
        let made = stepping::macro_step(model, state, steps);
        let fractured_after = made
            .ok()
            .and_then(|()| before.strained.share_until_fracture(model, state));
        self.record::<IN_FULL>(model, &before, state, fractured_after);
        match made {
            Ok(()) if fractured_after.is_some() => Ok(Progress::Over(End::Fractured)),
            Ok(()) => Ok(self.progress(model, state)),
            Err(StepError::Collapsed(_)) => Ok(Progress::Over(End::Collapsed)),
            Err(error) => Err(error),
        }
    }

    fn progress(&mut self, model: &Model, state: &State) -> Progress {
        let now = model.time_of_step(state.step);
        let approaches = state
            .impactor
            .as_ref()
            .is_some_and(|it| it.touched_at.is_none());
        if approaches && now <= self.approach_until {
            self.counted_from = now;
        }
        if is_torn_off(model, self.base.tension()) {
            Progress::Over(End::Fractured)
        } else if self.is_settled(model, state, now) {
            Progress::Over(End::AtRest)
        } else if now - self.counted_from >= self.max_duration {
            Progress::Over(End::DurationReached)
        } else {
            Progress::Running
        }
    }

    /// Whether the impactor has left for good or rests, and no hinge has flowed for long enough.
    fn is_settled(&mut self, model: &Model, state: &State, now: f64) -> bool {
        let touched = state
            .impactor
            .as_ref()
            .is_none_or(|i| i.touched_at.is_some());
        // The period of the undamaged column is known; that of the deformed column is computed only after it has passed.
        if !touched || now - self.last_flow < QUIET_PERIODS * model.slowest_period {
            return false;
        }
        let period = *self.residual_period.get_or_insert_with(|| {
            statics::residual_state(model, state)
                .and_then(|rest| {
                    let masses = model.masses();
                    modes::slowest_period(&model.frame, &masses, &rest.displacement, &rest.plastic)
                })
                .unwrap_or(model.slowest_period)
        });
        if let Some(impactor) = &state.impactor
            && impactor.impact.transverse_force > 0.0
        {
            // It comes back until it rests. The column vibrates beneath it, without damping for ever, and more slowly with
            // its mass.
            let own = model.impact_point_mass;
            let period = period * ((own + impactor.impact.mass) / own).sqrt();
            return self.pressed >= QUIET_PERIODS * period;
        }
        let quiet = |since: f64| now - since >= QUIET_PERIODS * period;
        quiet(self.last_flow)
            && state.impactor.as_ref().is_none_or(|impactor| {
                if impactor.closed && impactor.is_deformable() {
                    // Its front pushes itself away.
                    false
                } else if impactor.closed {
                    let energies = state.energies(model);
                    state.contact_force <= REST_FORCE_FRACTION * self.peak_force
                        && energies.column_kinetic + energies.impactor_kinetic
                            <= REST_FRACTION * impactor.impact.energy()
                } else {
                    // Once it recedes and the column has not reached it for a whole period, it never will.
                    impactor.recedes_for_good() && quiet(self.last_contact)
                }
            })
    }

    /// Takes what a step led to. Of a step in which a hinge fractures only the share `fractured_after` counts for the extremes: the model
    /// does not know how the column moves without that hinge.
    fn record<const IN_FULL: bool>(
        &mut self,
        model: &Model,
        before: &StepStart,
        state: &State,
        fractured_after: Option<f64>,
    ) {
        let now = model.time_of_step(state.step);
        let touching = state.impactor.as_ref().is_some_and(|i| i.closed);
        if touching || state.impact_impulse > 0.0 {
            self.last_contact = now;
        }
        if touching
            && state
                .impactor
                .as_ref()
                .is_some_and(|i| i.impact.transverse_force > 0.0)
        {
            self.pressed += before.secs;
        }
        self.record_peak_between(model, before, state, fractured_after.unwrap_or(1.0));
        match fractured_after {
            None => self.record_extremes(&Extremes::of(state), now),
            Some(share) => {
                let instant = model.time_of_step(before.step) + share * before.secs;
                self.record_extremes(&before.extremes_after(share, state), instant);
            }
        }
        // However many macro-steps the approach takes, the windows of the base begin where it ends.
        match state.is_waiting() {
            true => self.base.wait(now),
            false => self
                .base
                .take(&state.base_instant(model, now, self.last_contact)),
        }
        if IN_FULL {
            self.record_residual_and_sums(model, state);
        }
        if IN_FULL && model.strength.is_some() {
            let factors = over_hinges(&state.strength, |hinge| hinge.factors.dynamic);
            for (max, factor) in self.max_dynamic_factor.iter_mut().zip(factors) {
                *max = max.max(factor);
            }
        }
        if IN_FULL && model.properties.shear.is_some() {
            let states = [&state.webs.below, &state.webs.above];
            for (web, state) in self.webs.iter_mut().zip(states) {
                web.max_dynamic_factor = web.max_dynamic_factor.max(state.dynamic_factor());
            }
        }
        if state.is_flowing() {
            self.last_flow = now;
            self.pressed = 0.0;
            self.residual_period = None;
            if self.first_yield.contains(&None) {
                self.record_yield(model, before, state);
            }
            self.record_shear(model, before, state);
        }
    }

    /// Both schemes move with the mean of the velocities at both ends of a step: between them `v1` is a parabola, of which the
    /// share `until` counts.
    fn record_peak_between(
        &mut self,
        model: &Model,
        before: &StepStart,
        state: &State,
        until: f64,
    ) {
        let (rate, next_rate) = (before.v1_rate, state.velocity.v1);
        if state.impact_impulse > 0.0 || !(rate > 0.0 && next_rate < 0.0) {
            return;
        }
        let share = rate / (rate - next_rate);
        let secs = share * before.secs;
        let peak = before.displacement.v1 + 0.5 * rate * secs;
        if peak > self.max_v1 && share <= until {
            self.max_v1 = peak;
            self.max_v1_time = model.time_of_step(before.step) + secs;
        }
    }

    /// Takes what is true at the instant `now` \[s\].
    fn record_extremes(&mut self, found: &Extremes, now: f64) {
        if found.v1 > self.max_v1 {
            self.max_v1 = found.v1;
            self.max_v1_time = now;
        }
        self.max_u2 = self.max_u2.max(found.u2);
        if found.contact_force > self.peak_force {
            self.peak_force = found.contact_force;
            self.peak_force_time = Some(now);
        }
    }

    fn record_residual_and_sums(&mut self, model: &Model, state: &State) {
        self.worst_residual = self.worst_residual.max(state.ledger_residual(model).abs());
        let strengths = model.strength.as_ref().map(|_| &state.strength);
        for (max, sum) in
            self.max_sum
                .iter_mut()
                .zip(yield_sums(&model.frame, &state.forces, strengths))
        {
            *max = max.max(sum);
        }
        if model.properties.shear.is_some() {
            for (web, used) in self.webs.iter_mut().zip(state.web_utilisations(model)) {
                web.max_utilisation = web.max_utilisation.max(used);
            }
        }
    }

    /// As [`Response::record_yield`], of the webs.
    fn record_shear(&mut self, model: &Model, before: &StepStart, state: &State) {
        let (frame, webs, hinges) = (&model.frame, &state.webs, &state.strength);
        let [first, second] = &mut self.webs;
        for (web, bar, own, hinges, start, end, flow) in [
            (
                first,
                &frame.below,
                &webs.below,
                &hinges.below,
                &before.forces.below,
                &state.forces.below,
                state.plastic.below.plus(-1.0, &before.plastic.below),
            ),
            (
                second,
                &frame.above,
                &webs.above,
                &hinges.above,
                &before.forces.above,
                &state.forces.above,
                state.plastic.above.plus(-1.0, &before.plastic.above),
            ),
        ] {
            if own.flowing && web.first_yield.is_none() {
                let share = share_until_shear(bar, own, hinges, start, end, &flow);
                web.first_yield = Some(model.time_of_step(before.step) + share * before.secs);
            }
        }
    }

    /// A hinge that flows for the first time reached its yield surface inside the step; the elastic trial stress shows
    /// when.
    fn record_yield(&mut self, model: &Model, before: &StepStart, state: &State) {
        let (frame, strength) = (&model.frame, &state.strength);
        let below = |k: usize| {
            let flow = state.plastic.below.plus(-1.0, &before.plastic.below);
            let (start, end) = (&before.forces.below, &state.forces.below);
            share_until_yield(&frame.below, k, &strength.below[k], start, end, &flow)
        };
        let above = |k: usize| {
            let flow = state.plastic.above.plus(-1.0, &before.plastic.above);
            let (start, end) = (&before.forces.above, &state.forces.above);
            share_until_yield(&frame.above, k, &strength.above[k], start, end, &flow)
        };
        let share = |hinge: usize| match hinge {
            0 => below(0),
            1 => above(0),
            2 => above(1),
            _ => below(1),
        };
        let flows = over_hinges(&state.flowing, |&flows| flows);
        for (hinge, first) in self.first_yield.iter_mut().enumerate() {
            if first.is_none() && flows[hinge] {
                *first = Some(model.time_of_step(before.step) + share(hinge) * before.secs);
            }
        }
    }

    /// Takes what an observer sees of a long elastic step.
    pub(crate) fn take(&mut self, model: &Model, seen: &Glimpse<'_>) {
        let now = model.time_of_step(seen.step);
        self.base.take(&BaseInstant {
            time: now,
            v1: seen.displacement.v1,
            forces: seen.base,
            slides: false,
            last_contact: (self.last_contact > 0.0).then_some(self.last_contact),
            model,
            strength: [1.0; 2],
        });
        if seen.peak_v1 > self.max_v1 {
            self.max_v1 = seen.peak_v1;
            self.max_v1_time = now;
        }
        self.max_u2 = self.max_u2.max(seen.displacement.u2);
        if seen.contact_force > 0.0 {
            self.last_contact = now;
            if seen.contact_force > self.peak_force {
                self.peak_force = seen.contact_force;
                self.peak_force_time = Some(now);
            }
        }
    }

    /// Whether the response is over where the state is.
    pub(crate) fn progress_at(&mut self, model: &Model, state: &State) -> Progress {
        self.progress(model, state)
    }

    /// Instant at which it is over at the latest, and the earliest one at which the column may have settled \[s\].
    pub(crate) fn deadlines(&self, model: &Model) -> [f64; 2] {
        let last = self.last_flow.max(self.last_contact);
        [
            self.counted_from + self.max_duration,
            last + QUIET_PERIODS * self.residual_period.unwrap_or(model.slowest_period),
        ]
    }

    /// Peak `v1` so far \[m\].
    pub(crate) fn max_v1(&self) -> f64 {
        self.max_v1
    }

    /// Largest contact force so far \[N\].
    pub(crate) fn peak_force(&self) -> f64 {
        self.peak_force
    }

    /// Whether a hinge or a web has flowed, or the base has slipped.
    pub(crate) fn has_yielded(&self) -> bool {
        self.first_yield.iter().any(Option::is_some)
            || self.webs.iter().any(|web| web.first_yield.is_some())
            || self.base.has_slid()
    }

    /// The summary of a response that is over, or of what has happened so far.
    pub fn report(&self, model: &Model, state: &State, end: End) -> Report {
        let energies = state.energies(model);
        let stands = !matches!(end, End::Collapsed | End::Fractured);
        let residual = stands
            .then(|| statics::residual_state(model, state))
            .flatten();
        let yielded = self.has_yielded();
        let end_time = model.time_of_step(state.step);
        let impactor = state.impactor.as_ref();
        let touched = impactor.and_then(|i| i.touched_at);
        let released = impactor.and_then(|i| if i.closed { None } else { i.released_at });
        let ledger = &state.ledger;
        let PerBar { below, above } = &state.plastic_of_steel(model);
        let (lower, upper) = (&model.frame.below.surface, &model.frame.above.surface);
        let hinge =
            |index: usize, surface: &YieldSurface, plastic: &PlasticFlow, k: usize| HingeReport {
                first_yield: self.first_yield[index],
                max_utilisation: surface.utilisation_of_sum(self.max_sum[index]),
                plastic_rotation: plastic.rotation[k],
                plastic_elongation: plastic.elongation[k],
            };
        let hinges = [
            hinge(0, lower, below, 0),
            hinge(1, upper, above, 0),
            hinge(2, upper, above, 1),
            hinge(3, lower, below, 1),
        ];
        Report {
            outcome: match end {
                End::Collapsed => Outcome::Collapsed,
                End::Fractured => Outcome::Fractured,
                End::AtRest | End::DurationReached | End::NotConverged if yielded => {
                    Outcome::Plastic
                }
                End::AtRest | End::DurationReached | End::NotConverged => Outcome::Elastic,
            },
            end,
            end_time,
            max_v1: self.max_v1,
            max_v1_time: self.max_v1_time,
            residual_v1: residual.map(|r| r.displacement.v1),
            max_u2: self.max_u2,
            residual_u2: residual.map(|r| r.displacement.u2),
            first_contact_time: touched,
            release_time: released,
            contact_duration: touched.map_or(0.0, |from| released.unwrap_or(end_time) - from),
            impactor_velocity: impactor.map_or(0.0, |i| i.velocity),
            peak_contact_force: self.peak_force,
            peak_contact_force_time: self.peak_force_time,
            impact_impulses: state.impact_impulses,
            total_impact_impulse: state.total_impact_impulse,
            impulse: state.impulse,
            input_energy: ledger.input,
            column_kinetic_energy: energies.column_kinetic,
            impactor_kinetic_energy: energies.impactor_kinetic,
            elastic_energy_change: energies.elastic - ledger.initial_elastic,
            plastic_work: ledger.plastic_work,
            impact_loss: ledger.impact_loss,
            damping_work: ledger.damping_work,
            load_work: energies.load_work - ledger.initial_load_work,
            ledger_residual: self.worst_residual / ledger_measure(model, ledger),
            max_dynamic_factor: self.max_dynamic_factor,
            steps: state.step,
            hinges,
            vehicle: vehicle_report(state),
            webs: match model.properties.shear {
                Some(_) => [
                    web_report(&self.webs[0], below, &state.webs.below),
                    web_report(&self.webs[1], above, &state.webs.above),
                ],
                None => [WebReport::default(); WEBS],
            },
            base: self.base_at_end(model, state, end),
        }
    }

    /// The reactions of the base, and what has become of its anchors.
    pub(crate) fn base_at_end(&self, model: &Model, state: &State, end: End) -> BaseReport {
        base_at_end(model, state, end, self.base.report())
    }
}

/// The energy to which the residual of the ledger is relative: the input, or the floor of a very small one \[J\].
fn ledger_measure(model: &Model, ledger: &Ledger) -> f64 {
    let p = &model.properties;
    let height = p.length_below + p.length_above;
    let elastic = p.resistance_moment * p.resistance_moment * height / p.bending_stiffness;
    let held = ledger.initial_elastic.abs() + ledger.initial_load_work.abs();
    ledger.input.max(LEDGER_FLOOR * (elastic + held))
}

/// The history of a web with its values at the end.
fn web_report(history: &WebReport, plastic: &PlasticFlow, web: &WebState) -> WebReport {
    WebReport {
        plastic_angle: plastic.shear_angle,
        work: web.work,
        ..*history
    }
}

/// What has become of a deformable vehicle.
fn vehicle_report(state: &State) -> VehicleReport {
    let impactor = state.impactor.as_ref();
    let Some((vehicle, chain)) = impactor.and_then(|i| i.vehicle()) else {
        return VehicleReport::default();
    };
    VehicleReport {
        masses: vehicle.masses().len(),
        max_crush: chain.springs.map(|spring| spring.largest),
        permanent_crush: chain.springs.map(|spring| spring.permanent),
        dissipated: state.ledger.vehicle_dissipated,
        velocity: chain.velocity,
        elastic_energy: chain.elastic_energy(vehicle),
    }
}

/// What is kept of the state before a step.
struct StepStart {
    step: u64,
    secs: f64,
    displacement: Displacement,
    v1_rate: f64,
    contact_force: f64,
    forces: PerBar<BarForces>,
    plastic: PerBar<PlasticFlow>,
    strained: Strained,
}

/// The quantities whose largest values a response keeps.
struct Extremes {
    v1: f64,
    u2: f64,
    contact_force: f64,
}

impl Extremes {
    fn of(state: &State) -> Self {
        Self {
            v1: state.displacement.v1,
            u2: state.displacement.u2,
            contact_force: state.contact_force,
        }
    }
}

impl StepStart {
    /// After a share of the step that ends in `end`: `v1` on the parabola of its rates, the others on a straight line, and so is
    /// `v1` over an impact impulse.
    fn extremes_after(&self, share: f64, end: &State) -> Extremes {
        let between = |from: f64, to: f64| from + share * (to - from);
        let Displacement { v1, u2, .. } = self.displacement;
        Extremes {
            v1: match end.impact_impulse > 0.0 {
                true => between(v1, end.displacement.v1),
                false => {
                    let mean_rate = self.v1_rate + 0.5 * share * (end.velocity.v1 - self.v1_rate);
                    v1 + share * self.secs * mean_rate
                }
            },
            u2: between(u2, end.displacement.u2),
            contact_force: between(self.contact_force, end.contact_force),
        }
    }
}
