//! The energy-conserving midpoint rule.
//!
//! Discrete gradient, mean of the stresses at both ends of the step, stresses returned to the yield surface at the
//! end: `S_m . Delta E = Delta(stored energy) + S_m . Delta E^p` holds identically and the dissipation is never
//! negative. Closing and release of contact are located inside the step; the impact impulse obeys Newton's law there,
//! and in persistent contact both masses move as one.

use nalgebra::{Matrix4, Vector4};

use super::bar::{Bar, BarForces, BarStrain, PerBar, PlasticFlow};
use super::bracketing::{self, Solver};
use super::chain::ChainPoint;
use super::contact::MAX_ELASTIC_IMPACT_IMPULSES;
use super::frame;
use super::geometry::{Chord, ChordGradient, Displacement};
use super::model::Model;
use super::motion::{Motion, NEGLIGIBLE_PART, Rejected, check_part};
use super::newton::{self, NonlinearSystem};
use super::rate::{Collocation, Prediction};
use super::state::{State, Velocity};
use super::strength::BarStress;

/// Most closings and releases in one step; after them contact stays as it is to the end of the step.
pub const MAX_EVENTS_PER_STEP: u32 = 64;

/// Bound of the search for the instant of an event.
const MAX_EVENT_ITERATIONS: u32 = 60;

/// Tolerance of the instant of an event, relative to the part of the step in which it lies.
const EVENT_TOLERANCE: f64 = 1e-12;

/// A gap above this is open, one below minus this a penetration \[m\]; anything between is round-off.
const GAP_TOLERANCE: f64 = 1e-14;

/// Contact events of one step.
#[derive(Debug, Default)]
pub(crate) struct Events {
    count: u32,
}

impl Events {
    fn exhausted(&self) -> bool {
        self.count >= MAX_EVENTS_PER_STEP
    }
}

/// Equations of one part of a step, in the increment of `U` over it.
struct Conserving<'a> {
    model: &'a Model,
    from: &'a State,
    start: PerBar<Chord>,
    start_angles: PerBar<f64>,
    motion: Motion<'a>,
}

/// One bar at `n + 1`.
#[derive(Default)]
struct BarPoint {
    chord: Chord,
    gradient: ChordGradient,
    stress: BarStress,
    mean: BarForces,
    /// Angle by which the chord has turned \[rad\].
    turn: f64,
}

/// What was evaluated at `n + 1`.
#[derive(Default)]
struct Point {
    below: BarPoint,
    above: BarPoint,
    contact: ChainPoint,
}

impl BarPoint {
    /// `turn` is the rotation of the hinge at the impact point in addition to the chord.
    fn update(
        &mut self,
        bar: &Bar,
        (start, start_angle): (&Chord, f64),
        chord: Chord,
        turn: f64,
        (plastic, forces): (&PlasticFlow, &BarForces),
    ) {
        // The angle by which the chord turns comes with the discrete gradient, without another inverse tangent.
        let (gradient, chord_turn) = start.discrete_gradient(&chord);
        let total = BarStrain::of_chord(chord.elongation, start_angle + chord_turn, turn);
        self.stress.update(bar, total.minus(plastic));
        self.mean = forces.mean(&self.stress.returned.forces);
        self.chord = chord;
        self.gradient = gradient;
        self.turn = chord_turn;
    }
}

impl BarPoint {
    /// Moves the stress by a small change of the extents of the chord along the column and across it \[m\], and by a turn
    /// of the hinge at the impact point in addition to the chord \[rad\]; `false` if it does not move along its tangent.
    fn follow(&mut self, bar: &Bar, [x, v]: [f64; 2], turn: f64, from: &BarForces) -> bool {
        let gradient = self.chord.gradient();
        let elongation = gradient.length_x * x + gradient.length_v * v;
        let angle = gradient.angle_x * x + gradient.angle_v * v;
        let followed = self
            .stress
            .follow(bar, &BarStrain::of_chord(elongation, angle, turn));
        self.mean = from.mean(&self.stress.returned.forces);
        followed
    }
}

impl NonlinearSystem for Conserving<'_> {
    type Point = Point;

    fn evaluate(&self, increment: &Displacement, point: &mut Self::Point) -> Vector4<f64> {
        let (frame, from) = (&self.model.frame, self.from);
        let end = from.displacement.plus(1.0, *increment);
        let chords = frame.chords(&end);
        point.below.update(
            &frame.below,
            (&self.start.below, self.start_angles.below),
            chords.below,
            -end.beta1,
            (&from.plastic.below, &from.forces.below),
        );
        point.above.update(
            &frame.above,
            (&self.start.above, self.start_angles.above),
            chords.above,
            end.beta1,
            (&from.plastic.above, &from.forces.above),
        );
        let mean = PerBar {
            below: point.below.mean,
            above: point.above.mean,
        };
        let gradients = PerBar {
            below: point.below.gradient,
            above: point.above.gradient,
        };
        let spring_u2 = from.displacement.u2 + 0.5 * increment.u2;
        self.motion.residual(increment, &mut point.contact)
            + frame.internal_forces(&gradients, &mean, spring_u2)
    }

    fn follow(
        &self,
        to: &Displacement,
        correction: &Displacement,
        point: &mut Self::Point,
    ) -> bool {
        if !self.motion.has_vehicle() || self.model.strength.is_some() {
            return false;
        }
        let (frame, forces) = (&self.model.frame, &self.from.forces);
        let Displacement { v1, u1, beta1, u2 } = correction.times(-1.0);
        let Point {
            below,
            above,
            contact,
        } = point;
        let followed = below.follow(&frame.below, [-u1, v1], -beta1, &forces.below)
            && above.follow(
                &frame.above,
                [u1 - u2, frame.across_above(v1)],
                beta1,
                &forces.above,
            );
        if followed {
            self.motion.residual(to, contact);
        }
        followed
    }

    fn jacobian(&self, point: &mut Self::Point) -> Matrix4<f64> {
        let frame = &self.model.frame;
        let Point {
            below,
            above,
            contact,
        } = point;
        let tangents = PerBar {
            below: below.stress.linearise(&frame.below),
            above: above.stress.linearise(&frame.above),
        };
        let gradients = PerBar {
            below: below.gradient,
            above: above.gradient,
        };
        let chords = PerBar {
            below: below.chord,
            above: above.chord,
        };
        let mean = PerBar {
            below: below.mean,
            above: above.mean,
        };
        // The derivative of the discrete gradient is half the curvature of the chord, except for O(dt).
        let mut jacobian = frame.stiffness(&gradients, &chords, &mean, &tangents) * 0.5;
        self.motion.add_jacobian(&mut jacobian, contact);
        jacobian
    }

    fn scale(&self) -> Vector4<f64> {
        self.motion.scale()
    }

    fn model(&self) -> &Model {
        self.model
    }

    fn tolerance(&self) -> f64 {
        self.model.tolerance
    }
}

/// A solved part of a step that has not changed the state yet.
struct Trial {
    secs: f64,
    increment: Displacement,
    /// `U` at its end.
    end: Displacement,
    velocity: Velocity,
    damping_work: f64,
    newton_iterations: u32,
    /// Contact force at its end \[N\]; negative where impactor and column would separate.
    contact_force: f64,
    /// Gap at its end \[m\], if contact is open.
    gap: f64,
}

/// Makes one part of a step, `offset_secs` into it and at most `secs` long: to its end, or to the first contact event.
/// Returns its length \[s\].
///
/// # Errors
/// A part that is rejected; the state is then unchanged.
pub(crate) fn part(
    model: &Model,
    state: &mut State,
    [offset_secs, secs]: [f64; 2],
    solver: Solver,
    events: &mut Events,
) -> Result<f64, Rejected> {
    let mut solver = Part {
        model,
        solver,
        offset_secs,
        events,
        point: Point::default(),
        prediction: None,
    };
    match &state.impactor {
        None => solver.whole(state, secs),
        Some(impactor) if impactor.is_deformable() => solver.whole(state, secs),
        Some(impactor) if impactor.closed => solver.closed(state, secs),
        Some(impactor)
            if state.gap() <= GAP_TOLERANCE && impactor.closing_speed(state.velocity.v1) > 0.0 =>
        {
            strike(model, state, offset_secs, events);
            Ok(0.0)
        }
        Some(_) => solver.open(state, secs),
    }
}

/// What the trials of one part share.
struct Part<'a> {
    model: &'a Model,
    solver: Solver,
    offset_secs: f64,
    events: &'a mut Events,
    /// The last evaluation of the last trial.
    point: Point,
    /// Its resistances, where they are not constant.
    prediction: Option<Prediction>,
}

impl Part<'_> {
    /// Without a rigid impactor, in one go.
    fn whole(&mut self, state: &mut State, secs: f64) -> Result<f64, Rejected> {
        let trial = self.attempt(state, secs)?;
        self.accept(state, &trial)
    }

    /// With both masses moving as one, until the contact force falls to zero.
    fn closed(&mut self, state: &mut State, secs: f64) -> Result<f64, Rejected> {
        let trial = self.attempt(state, secs)?;
        if trial.contact_force >= 0.0 || self.events.exhausted() {
            self.accept(state, &trial)?;
            state.contact_force = state.contact_force.max(0.0);
            return Ok(secs);
        }
        let start = state.contact_force;
        let located = if start <= 0.0 {
            None
        } else {
            self.locate(state, start, trial, |trial| trial.contact_force)?
        };
        let secs = self.accept_event(state, located)?;
        self.events.count += 1;
        state.contact_force = 0.0;
        if let Some(impactor) = &mut state.impactor {
            impactor.release(self.model, state.step, self.offset_secs + secs);
        }
        Ok(secs)
    }

    /// With a gap, until it closes.
    fn open(&mut self, state: &mut State, secs: f64) -> Result<f64, Rejected> {
        let trial = self.attempt(state, secs)?;
        if trial.gap >= -GAP_TOLERANCE || self.events.exhausted() {
            return self.accept(state, &trial);
        }
        let start = state.gap();
        let separation = -state
            .impactor
            .as_ref()
            .map_or(0.0, |impactor| impactor.closing_speed(state.velocity.v1));
        // A gap that starts at zero (release, rebound) is divided by the time, or the search would find its start.
        let touching = start <= GAP_TOLERANCE;
        let located = if !touching {
            self.locate(state, start, trial, |trial| trial.gap)?
        } else if separation > 0.0 {
            self.locate(state, separation, trial, |trial| trial.gap / trial.secs)?
        } else {
            None
        };
        let secs = self.accept_event(state, located)?;
        strike(self.model, state, self.offset_secs + secs, self.events);
        Ok(secs)
    }

    /// Solves a part without looking for events.
    fn attempt(&mut self, from: &State, secs: f64) -> Result<Trial, Rejected> {
        let model = self.model;
        let impactor = from.impactor.as_ref();
        let coupling = impactor.map(|i| i.coupling()).unwrap_or_default();
        let chain = impactor.and_then(|i| i.chain_part(secs));
        let start = model.frame.chords(&from.displacement);
        let system = Conserving {
            model,
            from,
            start_angles: frame::angles(&start),
            start,
            motion: Motion::new(model, from, coupling, chain.as_ref(), secs),
        };
        let guess = from.predictor.increment(&from.velocity, secs);
        let solved = self.solve(&system, guess, secs)?;
        let increment = solved.increment;
        let end = from.displacement.plus(1.0, increment);
        let velocity = system.motion.end_velocity(model, &increment);
        let (mut contact_force, mut gap) = (0.0, 0.0);
        if let Some(impactor) = impactor.filter(|it| !it.is_deformable()) {
            if impactor.closed {
                let resistance = resistance(
                    model,
                    (
                        &self.point.below.chord,
                        &self.point.below.stress.returned.forces,
                    ),
                    (
                        &self.point.above.chord,
                        &self.point.above.stress.returned.forces,
                    ),
                    velocity.v1,
                );
                contact_force = impactor.contact_force(model, resistance);
            } else {
                let offset = self.offset_secs + secs;
                gap = end.v1 - impactor.position_in_flight(model, from.step, offset);
            }
        }
        Ok(Trial {
            secs,
            increment,
            end,
            velocity,
            damping_work: system.motion.damping_work(&increment),
            newton_iterations: solved.iterations,
            contact_force,
            gap,
        })
    }

    /// Solves the equations with the resistances that are expected at the end of the part.
    ///
    /// A stress of the start that lies outside of a surface that has shrunk could do negative work on a flow that reverses
    /// it, and so could the stress of a web that yields sooner in the other direction. Such a part is solved again with the
    /// surface of its start, on which that work cannot be negative.
    fn solve(
        &mut self,
        system: &Conserving<'_>,
        guess: Displacement,
        secs: f64,
    ) -> Result<newton::Solved, Rejected> {
        let (model, from) = (system.model, system.from);
        let Some(law) = &model.strength else {
            return self.solve_with(system, guess, None);
        };
        let turns = model.frame.turns(&system.start, &guess);
        let start = (&from.strength, &from.webs, &from.forces);
        let prediction = law.predict(start, (&system.start.below, &turns), secs, Collocation::End);
        let solved = self.solve_with(system, guess, Some(prediction))?;
        if !self.gains_energy() {
            return Ok(solved);
        }
        let [below, above] = from.web_uses(model);
        let used = PerBar { below, above };
        let prediction = prediction.not_below(&from.strength, &from.webs, &used);
        let again = self.solve_with(system, guess, Some(prediction))?;
        let iterations = solved.iterations + again.iterations;
        Ok(newton::Solved {
            iterations,
            ..again
        })
    }

    #[inline(always)]
    fn solve_with(
        &mut self,
        system: &Conserving<'_>,
        guess: Displacement,
        prediction: Option<Prediction>,
    ) -> Result<newton::Solved, Rejected> {
        let from = system.from;
        self.prediction = prediction;
        if let Some(prediction) = &self.prediction {
            let strengths = prediction.strengths();
            self.point.below.stress.set_strength(strengths.below);
            self.point.above.stress.set_strength(strengths.above);
        }
        let near = from.predictor.normal(&from.forces);
        self.point.below.stress.expect(near.below);
        self.point.above.stress.expect(near.above);
        bracketing::solve_part(system, guess, self.solver, &mut self.point)
    }

    /// Whether the mean stress does negative work on the flow of any hinge or web.
    fn gains_energy(&self) -> bool {
        let gains = |point: &BarPoint| {
            let flow = &point.stress.returned.flow;
            (0..2).any(|k| {
                point.mean.normal * flow.elongation[k] + point.mean.moment[k] * flow.rotation[k]
                    < 0.0
            }) || (flow.shear_angle != 0.0 && point.mean.shear_work(flow) < 0.0)
        };
        gains(&self.point.below) || gains(&self.point.above)
    }

    /// Moves the state to the end of the last trial and returns its length \[s\].
    fn accept(&self, state: &mut State, trial: &Trial) -> Result<f64, Rejected> {
        check_part(self.model, &state.displacement, &trial.end)?;
        let Point { below, above, .. } = &self.point;
        state.newton_iterations += u64::from(trial.newton_iterations);
        state.flow(
            self.model,
            &below.stress.returned.flow,
            &above.stress.returned.flow,
            1.0,
        );
        if let (Some(law), Some(prediction)) = (&self.model.strength, &self.prediction) {
            let turns = PerBar {
                below: below.turn,
                above: above.turn,
            };
            let flow = PerBar {
                below: &below.stress.returned.flow,
                above: &above.stress.returned.flow,
            };
            let strength = (&mut state.strength, &mut state.webs);
            law.advance(strength, &turns, trial.secs, prediction, flow, 1.0);
        }
        state.forces = PerBar {
            below: below.stress.returned.forces,
            above: above.stress.returned.forces,
        };
        state.dissipate(
            (&below.mean, &below.stress.returned.flow),
            (&above.mean, &above.stress.returned.flow),
            1.0,
        );
        state.ledger.damping_work += trial.damping_work;
        state.displacement = trial.end;
        state.velocity = trial.velocity;
        state
            .predictor
            .learn(&trial.increment, trial.secs, trial.end, &state.forces);
        state.contact_force = trial.contact_force;
        if let Some(impactor) = &mut state.impactor {
            if impactor.is_deformable() {
                let part = (self.offset_secs, trial.secs);
                state.follow(self.model, part, &self.point.contact);
                return Ok(trial.secs);
            }
            if impactor.closed {
                impactor.position = trial.end.v1;
                state.impulse += impactor.slow_down(trial.velocity.v1, trial.secs);
            } else {
                impactor.fly(self.model, state.step, self.offset_secs + trial.secs);
            }
        }
        Ok(trial.secs)
    }

    /// Moves the state to an event; `None` is an event at the start of the part.
    fn accept_event(&self, state: &mut State, located: Option<Trial>) -> Result<f64, Rejected> {
        located.map_or(Ok(0.0), |trial| self.accept(state, &trial))
    }

    /// The trial that ends at the instant at which a quantity passes zero that is positive at the start and negative at
    /// the end of `whole`: false position with the Illinois correction. `None` if that is the start itself.
    fn locate(
        &mut self,
        from: &State,
        at_start: f64,
        whole: Trial,
        quantity: impl Fn(&Trial) -> f64,
    ) -> Result<Option<Trial>, Rejected> {
        let secs = whole.secs;
        let (mut low, mut low_value) = (0.0, at_start);
        let (mut high, mut high_value) = (secs, quantity(&whole));
        let mut last = whole;
        let mut side = 0;
        for _ in 0..MAX_EVENT_ITERATIONS {
            let share = low_value / (low_value - high_value);
            let middle = low + share * (high - low);
            if middle <= NEGLIGIBLE_PART * secs {
                return Ok(None);
            }
            if !(middle > low && middle < high) {
                break;
            }
            let moved = (middle - last.secs).abs();
            last = self.attempt(from, middle)?;
            let value = quantity(&last);
            if value == 0.0 || moved <= EVENT_TOLERANCE * secs {
                break;
            }
            if value > 0.0 {
                (low, low_value) = (middle, value);
                if side > 0 {
                    high_value *= 0.5;
                }
                side = 1;
            } else {
                (high, high_value) = (middle, value);
                if side < 0 {
                    low_value *= 0.5;
                }
                side = -1;
            }
        }
        Ok(Some(last))
    }
}

/// Newton's impact law on an impactor that touches and closes, `offset_secs` into the step, and the contact force that it
/// leaves behind. The last event that a step may have is perfectly inelastic, and so are impact impulses beyond
/// [`MAX_ELASTIC_IMPACT_IMPULSES`].
pub(crate) fn strike(model: &Model, state: &mut State, offset_secs: f64, events: &mut Events) {
    events.count += 1;
    let Some(mut impactor) = state.impactor else {
        return;
    };
    impactor.reach(state.displacement.v1);
    let speed = impactor.closing_speed(state.velocity.v1);
    impactor.touch(model, state.step, offset_secs);
    let mut restitution = 0.0;
    if speed > 0.0 {
        if !events.exhausted() && state.impact_impulses < MAX_ELASTIC_IMPACT_IMPULSES {
            restitution = impactor.effective_restitution(speed);
        }
        let impact_impulse = impactor.impact_impulse(model, speed, restitution);
        state.velocity.v1 += impact_impulse.impulse / model.impact_point_mass;
        impactor.push_back(impact_impulse.impulse);
        state.count_impact_impulse(impact_impulse.impulse);
        state.impulse += impact_impulse.impulse;
        state.ledger.impact_loss += impact_impulse.loss;
        state.predictor.forget();
    }
    if restitution > 0.0 || speed < 0.0 {
        // Rebound, or a graze: at the end of a part the two may touch and separate already.
        impactor.release(model, state.step, offset_secs);
    } else {
        impactor.closed = true;
        impactor.velocity = state.velocity.v1;
    }
    let chords = model.frame.chords(&state.displacement);
    let resistance = resistance(
        model,
        (&chords.below, &state.forces.below),
        (&chords.above, &state.forces.above),
        state.velocity.v1,
    );
    state.contact_force = impactor.contact_force(model, resistance).max(0.0);
    state.impactor = Some(impactor);
}

/// Force with which bars and damping resist a motion of `v1` \[N\].
fn resistance(
    model: &Model,
    below: (&Chord, &BarForces),
    above: (&Chord, &BarForces),
    v1_rate: f64,
) -> f64 {
    let transverse = |(chord, forces): (&Chord, &BarForces)| chord.gradient().forces(forces).v;
    let damping = model.damping.map_or(0.0, |damping| damping.transverse);
    transverse(below) + transverse(above) + damping * v1_rate
}
