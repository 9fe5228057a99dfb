//! The paper's midpoint rule (Eqs 40, 44-46): equations of motion and flow rule at `n + 1/2`.
//!
//! Its artefacts are kept as they are: after the velocity jump a penetration of `dt |gamma_0| (1 - eps)/2` remains; the
//! stress at the end of a step may overshoot the yield surface by O(dt); energy is conserved to O(dt^2) only.

use nalgebra::{Matrix4, Vector4};

use super::bar::{BarForces, PerBar};
use super::bracketing::{self, Solver};
use super::chain::ChainPoint;
use super::contact::Coupling;
use super::frame;
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::{Motion, Rejected, check_part};
use super::newton::NonlinearSystem;
use super::rate::{Collocation, Prediction};
use super::state::{State, Velocity};
use super::statics::{self, Settled};
use super::strength::BarStress;

/// A closing speed above this fraction of the impactor's speed of arrival is an impact, below it round-off of
/// persistent contact.
const IMPACT_FRACTION: f64 = 1e-9;

/// Equations of one part of a step, in the increment of `U` over it.
struct Midpoint<'a> {
    model: &'a Model,
    from: &'a State,
    motion: Motion<'a>,
}

/// What was evaluated at `n + 1/2`.
#[derive(Default)]
struct Point {
    chords: PerBar<Chord>,
    below: BarStress,
    above: BarStress,
    contact: ChainPoint,
}

impl Point {
    fn forces(&self) -> PerBar<BarForces> {
        PerBar {
            below: self.below.returned.forces,
            above: self.above.returned.forces,
        }
    }
}

impl NonlinearSystem for Midpoint<'_> {
    type Point = Point;

    fn evaluate(&self, increment: &Displacement, point: &mut Point) -> Vector4<f64> {
        let (frame, plastic) = (&self.model.frame, &self.from.plastic);
        let middle = self.from.displacement.plus(0.5, *increment);
        point.chords = frame.chords(&middle);
        let total = frame::strains(&point.chords, &frame::angles(&point.chords), middle.beta1);
        let (below, above) = (&plastic.below, &plastic.above);
        point.below.update(&frame.below, total.below.minus(below));
        point.above.update(&frame.above, total.above.minus(above));
        let gradients = frame::gradients(&point.chords);
        self.motion.residual(increment, &mut point.contact)
            + frame.internal_forces(&gradients, &point.forces(), middle.u2)
    }

    fn jacobian(&self, point: &mut Point) -> Matrix4<f64> {
        let frame = &self.model.frame;
        let tangents = PerBar {
            below: point.below.linearise(&frame.below),
            above: point.above.linearise(&frame.above),
        };
        let gradients = frame::gradients(&point.chords);
        let stiffness = frame.stiffness(&gradients, &point.chords, &point.forces(), &tangents);
        let mut jacobian = stiffness * 0.5;
        self.motion.add_jacobian(&mut jacobian, &point.contact);
        jacobian
    }

    fn scale(&self) -> Vector4<f64> {
        self.motion.scale()
    }

    fn model(&self) -> &Model {
        self.model
    }

    fn tolerance(&self) -> f64 {
        // Four orders below the energy that the scheme itself loses.
        1e-11
    }
}

/// A solved part of a step that has not changed the state yet.
struct Trial {
    increment: Displacement,
    velocity: Velocity,
    damping_work: f64,
    newton_iterations: u32,
}

/// Makes one part of a step, `offset_secs` into it and `secs` long.
///
/// # Errors
/// A part that is rejected; the state is then unchanged.
pub(crate) fn part(
    model: &Model,
    state: &mut State,
    [offset_secs, secs]: [f64; 2],
    solver: Solver,
) -> Result<(), Rejected> {
    let mut solver = Part {
        model,
        solver,
        offset_secs,
        secs,
        point: Point::default(),
        prediction: None,
    };
    // Eq 46: contact transmits a force if without one xi_N would be negative, and then xi_N = 0. Of the two cases the
    // one that held in the last step is tried first; the problem is monotone, so the consistent case is the solution.
    let touching = state.impactor.as_ref();
    let Some(impactor) = touching.filter(|it| !it.is_deformable() && state.gap() <= 0.0) else {
        return solver.free(state);
    };
    let closing_speed = impactor.closing_speed(state.velocity.v1);
    let rebound = impactor.impact.restitution * closing_speed;
    let pressing = impactor.rebound_coupling(closing_speed, secs);
    // What it has at the end if the column does not press on it.
    let velocity = impactor.velocity + impactor.impact.acceleration() * secs;
    if impactor.closed {
        let pressed = solver.attempt(state, pressing)?;
        if velocity >= pressed.velocity.v1 - rebound {
            solver.press(state, closing_speed, &pressed)
        } else {
            solver.free(state)
        }
    } else {
        let free = solver.attempt(state, Coupling::default())?;
        let after = velocity - free.velocity.v1;
        if -after - rebound >= 0.0 {
            solver.fly(state, &free)
        } else {
            // Eqs 45-46: the contact force that makes gamma^{n+1} + eps gamma^n = 0.
            let pressed = solver.attempt(state, pressing)?;
            solver.press(state, closing_speed, &pressed)
        }
    }
}

/// What the trials of one part share.
struct Part<'a> {
    model: &'a Model,
    solver: Solver,
    offset_secs: f64,
    secs: f64,
    /// The last evaluation of the last trial.
    point: Point,
    /// Its resistances up to `n + 1/2` where they are not constant, and the chords at its start.
    prediction: Option<(Prediction, PerBar<Chord>)>,
}

impl Part<'_> {
    /// Solves a part with the impactor's share `coupling`.
    fn attempt(&mut self, from: &State, coupling: Coupling) -> Result<Trial, Rejected> {
        let model = self.model;
        let impactor = from.impactor.as_ref();
        let chain = impactor.and_then(|i| i.chain_part(self.secs));
        let system = Midpoint {
            model,
            from,
            motion: Motion::new(model, from, coupling, chain.as_ref(), self.secs),
        };
        let guess = first_guess(model, from, self.secs);
        if let Some(law) = &model.strength {
            let start = model.frame.chords(&from.displacement);
            let turns = model.frame.turns(&start, &guess);
            let prediction = law.predict(
                (&from.strength, &from.webs, &from.forces),
                (&start.below, &turns),
                self.secs,
                Collocation::Middle,
            );
            let strengths = prediction.strengths();
            self.point.below.set_strength(strengths.below);
            self.point.above.set_strength(strengths.above);
            self.prediction = Some((prediction, start));
        }
        let near = from.predictor.normal(&from.forces);
        self.point.below.expect(near.below);
        self.point.above.expect(near.above);
        let solved = bracketing::solve_part(&system, guess, self.solver, &mut self.point)?;
        let increment = solved.increment;
        Ok(Trial {
            increment,
            velocity: system.motion.end_velocity(model, &increment),
            damping_work: system.motion.damping_work(&increment),
            newton_iterations: solved.iterations,
        })
    }

    /// Without the contact force of a rigid impactor.
    fn free(&mut self, state: &mut State) -> Result<(), Rejected> {
        let trial = self.attempt(state, Coupling::default())?;
        self.fly(state, &trial)
    }

    /// Accepts a trial without the contact force of a rigid impactor.
    fn fly(&self, state: &mut State, trial: &Trial) -> Result<(), Rejected> {
        self.accept(state, trial)?;
        state.contact_force = 0.0;
        if let Some(impactor) = &mut state.impactor {
            if impactor.is_deformable() {
                let part = (self.offset_secs, self.secs);
                state.follow(self.model, part, &self.point.contact);
                return Ok(());
            }
            if impactor.closed {
                impactor.release(self.model, state.step, self.offset_secs);
            }
            impactor.fly(self.model, state.step, self.offset_secs + self.secs);
        }
        Ok(())
    }

    /// Accepts a trial with contact force.
    fn press(&self, state: &mut State, closing_speed: f64, trial: &Trial) -> Result<(), Rejected> {
        self.accept(state, trial)?;
        let Some(impactor) = &mut state.impactor else {
            return Ok(());
        };
        let restitution = impactor.impact.restitution;
        let before = impactor.velocity;
        let end = state.velocity.v1 - restitution * closing_speed;
        let impulse = impactor.slow_down(end, self.secs);
        impactor.position += 0.5 * self.secs * (before + impactor.velocity);
        impactor.closed = true;
        impactor.touch(self.model, state.step, self.offset_secs);
        let mut impact_impulse = 0.0;
        if closing_speed > IMPACT_FRACTION * impactor.impact.arrival_velocity() {
            impact_impulse = impactor
                .impact_impulse(self.model, closing_speed, restitution)
                .impulse
                .min(impulse);
            state.count_impact_impulse(impact_impulse);
        }
        state.impulse += impulse;
        state.contact_force = (impulse - impact_impulse) / self.secs;
        state.ledger.impact_loss += impulse * 0.5 * (1.0 - restitution) * closing_speed;
        Ok(())
    }

    /// Moves the column to the end of the last trial.
    fn accept(&self, state: &mut State, trial: &Trial) -> Result<(), Rejected> {
        let (below, above) = (&self.point.below.returned, &self.point.above.returned);
        // Plastic strains are extrapolated from n + 1/2 to n + 1.
        let plastic = PerBar {
            below: state.plastic.below.plus(2.0, &below.flow),
            above: state.plastic.above.plus(2.0, &above.flow),
        };
        // beta1 and a massless u2 are collocated at n + 1/2. Extrapolated they would ring for ever, so at n + 1 they are
        // solved for; where they have no elastic equilibrium there (the stress overshoots the yield surface), they are
        // extrapolated after all.
        let extrapolated = state.displacement.plus(1.0, trial.increment);
        let settled = statics::settle_massless(self.model, extrapolated, &plastic);
        let end = settled.unwrap_or_else(|| {
            let frame = &self.model.frame;
            let chords = frame.chords(&extrapolated);
            Settled {
                displacement: extrapolated,
                chords,
                forces: frame.elastic_forces(&chords, &extrapolated, &plastic),
            }
        });
        check_part(self.model, &state.displacement, &end.displacement)?;
        state.newton_iterations += u64::from(trial.newton_iterations);
        state.flow(self.model, &below.flow, &above.flow, 2.0);
        if let (Some(law), Some((prediction, from))) = (&self.model.strength, &self.prediction) {
            let turns = PerBar {
                below: from.below.discrete_gradient(&end.chords.below).1,
                above: from.above.discrete_gradient(&end.chords.above).1,
            };
            let flow = PerBar {
                below: &below.flow,
                above: &above.flow,
            };
            let strength = (&mut state.strength, &mut state.webs);
            law.advance(strength, &turns, self.secs, prediction, flow, 2.0);
        }
        state.dissipate(
            (&below.forces, &below.flow),
            (&above.forces, &above.flow),
            2.0,
        );
        state.ledger.damping_work += trial.damping_work;
        state.velocity = trial.velocity;
        let middle = state.displacement.plus(0.5, trial.increment);
        state
            .predictor
            .learn(&trial.increment, self.secs, middle, &self.point.forces());
        state.displacement = end.displacement;
        state.forces = end.forces;
        Ok(())
    }
}

/// Expected increment of `U`. The massless unknowns go from one `n + 1/2` to the next, past their values at `n`; in a
/// part of a step they hardly move.
fn first_guess(model: &Model, from: &State, secs: f64) -> Displacement {
    let mut guess = from.predictor.increment(&from.velocity, secs);
    let now = &from.displacement;
    let expected = from
        .predictor
        .solution()
        .filter(|_| secs == model.step_secs);
    let middle = expected.unwrap_or(*now);
    guess.beta1 = 2.0 * (middle.beta1 - now.beta1);
    if model.top_is_massless() {
        guess.u2 = 2.0 * (middle.u2 - now.u2);
    }
    guess
}
