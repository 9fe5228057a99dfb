//! The paper's midpoint rule (Eqs 40, 44-46): equations of motion and flow rule at `n + 1/2`.
//!
//! Its artefacts are kept as they are: after the velocity jump a penetration of `dt |gamma_0| (1 - eps)/2` remains; the
//! stress at the end of a step may overshoot the yield surface by O(dt); energy is conserved to O(dt^2) only.

use nalgebra::{Matrix4, Vector4};

use super::assembly::{self, PerBar, Tangents};
use super::bar::{Bar, Returned};
use super::contact::percussion;
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::Motion;
use super::newton::{self, NonlinearSystem};
use super::state::State;
use super::statics;
use super::stepping::Part;

/// A closing speed above this fraction of the impactor's first speed is an impact, below it round-off of
/// persistent contact.
const IMPACT_FRACTION: f64 = 1e-9;

/// Equations of one part of a step, in the increment of `U` over it.
struct Midpoint<'a> {
    model: &'a Model,
    from: &'a State,
    motion: Motion,
    /// Expected normal forces \[N\].
    near: PerBar<f64>,
}

/// What was evaluated at `n + 1/2`.
struct Point {
    chords: PerBar<Chord>,
    returned: PerBar<Returned>,
}

impl NonlinearSystem for Midpoint<'_> {
    type Point = Point;

    fn evaluate(&self, increment: &Displacement) -> (Point, Vector4<f64>) {
        let model = self.model;
        let middle = self.from.displacement.plus(0.5, *increment);
        let chords = assembly::chords(model, &middle);
        let elastic = assembly::elastic_strains(&chords, &middle, &self.from.plastic);
        let back = |bar: &Bar, strain, near| bar.return_stress(bar.elastic(strain), near);
        let returned = PerBar {
            below: back(&model.below, &elastic.below, self.near.below),
            above: back(&model.above, &elastic.above, self.near.above),
        };
        let gradients = assembly::gradients(&chords);
        let forces = forces_of(&returned);
        let internal = assembly::internal_forces(model, &gradients, &forces, middle.u2);
        let residual = self.motion.residual(increment) + internal;
        (Point { chords, returned }, residual)
    }

    fn jacobian(&self, point: &Point) -> Matrix4<f64> {
        let model = self.model;
        let tangents = Tangents {
            below: model.below.tangent(&point.returned.below),
            above: model.above.tangent(&point.returned.above),
        };
        let forces = forces_of(&point.returned);
        let k = assembly::stiffness(
            model,
            &assembly::gradients(&point.chords),
            &point.chords,
            &forces,
            &tangents,
        );
        self.motion.jacobian() + k * 0.5
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

fn forces_of(returned: &PerBar<Returned>) -> PerBar<super::bar::BarForces> {
    PerBar {
        below: returned.below.forces,
        above: returned.above.forces,
    }
}

/// What contact does in one part.
struct Contact {
    /// Mass that moves along \[kg\].
    mass: f64,
    closing_speed: f64,
    restitution: f64,
}

/// One part of a step, `offset_secs` into it.
pub(crate) fn part(model: &Model, from: &State, offset_secs: f64, secs: f64) -> Option<Part> {
    let contact = from
        .impactor
        .filter(|_| from.gap() <= 0.0)
        .map(|i| Contact {
            mass: i.impact.mass,
            closing_speed: i.closing_speed(from.velocity.v1),
            restitution: i.impact.restitution,
        });
    // Eq 46: contact transmits a force if without one xi_N would be negative, and then xi_N = 0. Of the two cases the
    // one that held in the last step is tried first; the problem is monotone, so whichever is consistent is the one.
    let state = match contact {
        None => free(model, from, offset_secs, secs)?,
        Some(contact) if from.impactor.is_some_and(|i| i.closed) => {
            let pressed = pressed(model, from, &contact, offset_secs, secs)?;
            if pressed.impulse - from.impulse >= 0.0 {
                pressed
            } else {
                free(model, from, offset_secs, secs)?
            }
        }
        Some(contact) => {
            let free = free(model, from, offset_secs, secs)?;
            let after = free.impactor?.closing_speed(free.velocity.v1);
            if -after - contact.restitution * contact.closing_speed >= 0.0 {
                free
            } else {
                pressed(model, from, &contact, offset_secs, secs)?
            }
        }
    };
    Some(Part { state, secs })
}

/// Without contact force.
fn free(model: &Model, from: &State, offset_secs: f64, secs: f64) -> Option<State> {
    let mut state = advance(model, from, 0.0, 0.0, secs)?;
    if let Some(mut impactor) = from.impactor {
        if impactor.closed {
            impactor.release(model, from.step, offset_secs);
        }
        impactor.position = impactor.position_in_flight(model, from.step, offset_secs + secs);
        state.impactor = Some(impactor);
    }
    state.contact_force = 0.0;
    Some(state)
}

/// With the contact force that makes `gamma^{n+1} + eps gamma^n = 0` (Eqs 45-46).
fn pressed(
    model: &Model,
    from: &State,
    contact: &Contact,
    offset_secs: f64,
    secs: f64,
) -> Option<State> {
    let Contact {
        mass,
        closing_speed,
        restitution,
    } = *contact;
    let push = mass * (1.0 + restitution) * closing_speed / secs;
    let mut state = advance(model, from, mass, push, secs)?;
    let mut impactor = from.impactor?;
    let before = impactor.velocity;
    impactor.velocity = state.velocity.v1 - restitution * closing_speed;
    impactor.position += 0.5 * secs * (before + impactor.velocity);
    impactor.closed = true;
    impactor.touch(model, from.step, offset_secs);
    let impulse = mass * (before - impactor.velocity);
    let mut hit = 0.0;
    if closing_speed > IMPACT_FRACTION * impactor.impact.velocity {
        hit = percussion(mass, model.impact_point_mass, closing_speed, restitution)
            .impulse
            .min(impulse);
        state.percussion += hit;
        state.percussion_impulse += hit;
        state.percussions += 1;
    }
    state.impulse += impulse;
    state.contact_force = (impulse - hit) / secs;
    state.ledger.impact_loss += impulse * 0.5 * (1.0 - restitution) * closing_speed;
    state.impactor = Some(impactor);
    Some(state)
}

/// Moves the column.
fn advance(model: &Model, from: &State, added_mass: f64, push: f64, secs: f64) -> Option<State> {
    let motion = Motion::new(model, from, added_mass, push, secs);
    let stage = Midpoint {
        model,
        from,
        motion,
        near: from.predictor.normal(&from.forces),
    };
    let solved = newton::solve(&stage, first_guess(model, from, secs))?;
    let mut state = *from;
    state.corrections += u64::from(solved.corrections);
    let PerBar { below, above } = solved.point.returned;
    // Plastic strains are extrapolated from n + 1/2 to n + 1.
    state.plastic.below = state.plastic.below.plus(2.0, &below.flow);
    state.plastic.above = state.plastic.above.plus(2.0, &above.flow);
    for k in 0..2 {
        state.flowing.below[k] |= model.below.flows(&below.flow, k);
        state.flowing.above[k] |= model.above.flows(&above.flow, k);
    }
    state.ledger.plastic_work +=
        2.0 * (below.forces.work(&below.flow) + above.forces.work(&above.flow));
    state.ledger.damping_work += motion.damping_work(&solved.increment);
    state.velocity = motion.end_velocity(model, &solved.increment);
    let middle = from.displacement.plus(0.5, solved.increment);
    let forces = forces_of(&solved.point.returned);
    state
        .predictor
        .learn(&solved.increment, secs, middle, &forces);
    // beta1 and a massless u2 are collocated at n + 1/2; extrapolated they would ring for ever, so at n + 1 they are
    // solved for.
    let end = from.displacement.plus(1.0, solved.increment);
    // Where they have no elastic equilibrium there (the stress overshoots the yield surface), extrapolation it is.
    (state.displacement, state.forces) = statics::settle_massless(model, end, &state.plastic)
        .unwrap_or_else(|| {
            let chords = assembly::chords(model, &end);
            let forces = assembly::elastic_forces(model, &chords, &end, &state.plastic);
            (end, forces)
        });
    Some(state)
}

/// Expected increment of `U`. The massless unknowns go from one `n + 1/2` to the next, past their values at `n`; in a
/// part of a step they hardly go anywhere.
fn first_guess(model: &Model, from: &State, secs: f64) -> Displacement {
    let mut guess = from.predictor.increment(&from.velocity, secs);
    let now = &from.displacement;
    let expected = from.predictor.stage().filter(|_| secs == model.step_secs);
    let middle = expected.unwrap_or(*now);
    guess.beta1 = 2.0 * (middle.beta1 - now.beta1);
    if model.top_is_massless() {
        guess.u2 = 2.0 * (middle.u2 - now.u2);
    }
    guess
}
