//! The energy-conserving sibling of the midpoint rule.
//!
//! Discrete gradient, mean of the stresses at both ends of the step, stresses returned to the yield surface at the
//! end: `S_m . Delta E = Delta(stored energy) + S_m . Delta E^p` holds identically and the dissipation is never
//! negative. Closing and release of contact are located inside the step; the percussion obeys Newton's law there,
//! and in persistent contact both masses move as one.

use nalgebra::{Matrix4, Vector4};

use super::assembly::{self, PerBar, Tangents};
use super::bar::{Bar, BarForces, Returned};
use super::geometry::{Chord, ChordGradient, Displacement};
use super::model::Model;
use super::motion::Motion;
use super::newton::{self, NonlinearSystem};
use super::state::State;
use super::stepping::{NEGLIGIBLE_PART, Part};

/// Most closings and releases in one step; past them contact stays as it is to the step's end.
pub const MAX_EVENTS_PER_STEP: u32 = 64;

/// Bound of the search for the instant of an event.
const MAX_EVENT_ITERATIONS: u32 = 60;

/// An event's instant is known to this fraction of the part it lies in.
const EVENT_TOLERANCE: f64 = 1e-12;

/// A gap above this is open, one below minus this a penetration \[m\]; between lies round-off.
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
    motion: Motion,
    /// Expected normal forces \[N\].
    near: PerBar<f64>,
}

/// What was evaluated at `n + 1`.
struct Point {
    chords: PerBar<Chord>,
    gradients: PerBar<ChordGradient>,
    returned: PerBar<Returned>,
    mean: PerBar<BarForces>,
}

impl NonlinearSystem for Conserving<'_> {
    type Point = Point;

    fn evaluate(&self, increment: &Displacement) -> (Point, Vector4<f64>) {
        let (model, from) = (self.model, self.from);
        let end = from.displacement.plus(1.0, *increment);
        let chords = assembly::chords(model, &end);
        let elastic = assembly::elastic_strains(&chords, &end, &from.plastic);
        let back = |bar: &Bar, strain, near| bar.return_stress(bar.elastic(strain), near);
        let returned = PerBar {
            below: back(&model.below, &elastic.below, self.near.below),
            above: back(&model.above, &elastic.above, self.near.above),
        };
        let gradients = PerBar {
            below: self.start.below.discrete_gradient(&chords.below),
            above: self.start.above.discrete_gradient(&chords.above),
        };
        let mean = PerBar {
            below: from.forces.below.mean(returned.below.forces),
            above: from.forces.above.mean(returned.above.forces),
        };
        let spring_u2 = from.displacement.mean(end).u2;
        let internal = assembly::internal_forces(model, &gradients, &mean, spring_u2);
        let residual = self.motion.residual(increment) + internal;
        let point = Point {
            chords,
            gradients,
            returned,
            mean,
        };
        (point, residual)
    }

    fn jacobian(&self, point: &Point) -> Matrix4<f64> {
        let model = self.model;
        let tangents = Tangents {
            below: model.below.tangent(&point.returned.below),
            above: model.above.tangent(&point.returned.above),
        };
        // The discrete gradient's own derivative is half the curvature of the chord, but for O(dt).
        let k = assembly::stiffness(
            model,
            &point.gradients,
            &point.chords,
            &point.mean,
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
        // The energy balance is as exact as the equations are solved.
        1e-13
    }
}

/// One part of a step, `offset_secs` into it: to its end, or to the first contact event.
pub(crate) fn part(
    model: &Model,
    from: &State,
    offset_secs: f64,
    secs: f64,
    events: &mut Events,
) -> Option<Part> {
    let Some(impactor) = from.impactor else {
        let state = advance(model, from, offset_secs, secs)?;
        return Some(Part { state, secs });
    };
    if impactor.closed {
        return closed_part(model, from, offset_secs, secs, events);
    }
    if from.gap() <= GAP_TOLERANCE && impactor.closing_speed(from.velocity.v1) > 0.0 {
        return Some(strike(model, *from, offset_secs, 0.0, events));
    }
    open_part(model, from, offset_secs, secs, events)
}

/// With both masses moving as one, until the contact force falls to zero.
fn closed_part(
    model: &Model,
    from: &State,
    offset_secs: f64,
    secs: f64,
    events: &mut Events,
) -> Option<Part> {
    let end = advance(model, from, offset_secs, secs)?;
    if end.contact_force >= 0.0 || events.exhausted() {
        let contact_force = end.contact_force.max(0.0);
        let state = State {
            contact_force,
            ..end
        };
        return Some(Part { state, secs });
    }
    let (mut state, secs) = if from.contact_force <= 0.0 {
        (*from, 0.0)
    } else {
        locate(
            from,
            from.contact_force,
            (&end, end.contact_force),
            secs,
            |secs| {
                let state = advance(model, from, offset_secs, secs)?;
                Some((state, state.contact_force))
            },
        )?
    };
    events.count += 1;
    state.contact_force = 0.0;
    if let Some(impactor) = &mut state.impactor {
        impactor.release(model, state.step, offset_secs + secs);
    }
    Some(Part { state, secs })
}

/// With a gap, until it closes.
fn open_part(
    model: &Model,
    from: &State,
    offset_secs: f64,
    secs: f64,
    events: &mut Events,
) -> Option<Part> {
    let end = advance(model, from, offset_secs, secs)?;
    if end.gap() >= -GAP_TOLERANCE || events.exhausted() {
        return Some(Part { state: end, secs });
    }
    let start = from.gap();
    // A gap that starts at zero (release, rebound) is divided by the time, or the search would find its start.
    let touching = start <= GAP_TOLERANCE;
    let parting = -from.impactor?.closing_speed(from.velocity.v1);
    if touching && parting <= 0.0 {
        return Some(strike(model, *from, offset_secs, 0.0, events));
    }
    let measure = |state: &State, secs: f64| {
        if touching {
            state.gap() / secs
        } else {
            state.gap()
        }
    };
    let at_start = if touching { parting } else { start };
    let (state, secs) = locate(from, at_start, (&end, measure(&end, secs)), secs, |secs| {
        let state = advance(model, from, offset_secs, secs)?;
        Some((state, measure(&state, secs)))
    })?;
    Some(strike(model, state, offset_secs, secs, events))
}

/// Newton's impact law at the end of a part, and the contact force that it leaves.
pub(crate) fn strike(
    model: &Model,
    mut state: State,
    offset_secs: f64,
    secs: f64,
    events: &mut Events,
) -> Part {
    events.count += 1;
    state.strike(model, offset_secs + secs, !events.exhausted());
    let chords = assembly::chords(model, &state.displacement);
    state.contact_force = contact_force(model, &state, &chords).max(0.0);
    Part { state, secs }
}

/// The instant in `[0, secs]` at which a quantity that is positive at the start and negative at the end passes zero,
/// and the state there: false position with the Illinois correction.
fn locate(
    from: &State,
    at_start: f64,
    (end, at_end): (&State, f64),
    secs: f64,
    mut at: impl FnMut(f64) -> Option<(State, f64)>,
) -> Option<(State, f64)> {
    let (mut low, mut low_value) = (0.0, at_start);
    let (mut high, mut high_value) = (secs, at_end);
    let mut best = (*end, secs);
    let mut side = 0;
    for _ in 0..MAX_EVENT_ITERATIONS {
        let share = low_value / (low_value - high_value);
        let middle = low + share * (high - low);
        if middle <= NEGLIGIBLE_PART * secs {
            return Some((*from, 0.0));
        }
        if !(middle > low && middle < high) {
            break;
        }
        let (state, value) = at(middle)?;
        let moved = (middle - best.1).abs();
        best = (state, middle);
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
    Some(best)
}

/// Moves column and impactor over `secs` without looking for events.
fn advance(model: &Model, from: &State, offset_secs: f64, secs: f64) -> Option<State> {
    let closed = from.impactor.filter(|i| i.closed);
    let added_mass = closed.map_or(0.0, |i| i.impact.mass);
    let motion = Motion::new(model, from, added_mass, 0.0, secs);
    let stage = Conserving {
        model,
        from,
        start: assembly::chords(model, &from.displacement),
        motion,
        near: from.predictor.normal(&from.forces),
    };
    let solved = newton::solve(&stage, from.predictor.increment(&from.velocity, secs))?;
    let mut state = *from;
    state.corrections += u64::from(solved.corrections);
    let PerBar { below, above } = solved.point.returned;
    state.plastic.below = state.plastic.below.plus(1.0, &below.flow);
    state.plastic.above = state.plastic.above.plus(1.0, &above.flow);
    for k in 0..2 {
        state.flowing.below[k] |= model.below.flows(&below.flow, k);
        state.flowing.above[k] |= model.above.flows(&above.flow, k);
    }
    state.forces = PerBar {
        below: below.forces,
        above: above.forces,
    };
    let mean = &solved.point.mean;
    state.ledger.plastic_work += mean.below.work(&below.flow) + mean.above.work(&above.flow);
    state.ledger.damping_work += motion.damping_work(&solved.increment);
    state.displacement = from.displacement.plus(1.0, solved.increment);
    state.velocity = motion.end_velocity(model, &solved.increment);
    state
        .predictor
        .learn(&solved.increment, secs, state.displacement, &state.forces);
    if let Some(impactor) = &mut state.impactor {
        if impactor.closed {
            let before = impactor.velocity;
            impactor.velocity = state.velocity.v1;
            impactor.position = state.displacement.v1;
            state.impulse += impactor.impact.mass * (before - impactor.velocity);
            state.contact_force = contact_force(model, &state, &solved.point.chords);
        } else {
            impactor.position = impactor.position_in_flight(model, from.step, offset_secs + secs);
            state.contact_force = 0.0;
        }
    }
    Some(state)
}

/// Smooth contact force of a state in persistent contact \[N\]: both masses share the acceleration that the column's
/// force gives them. Negative: they would part.
fn contact_force(model: &Model, state: &State, chords: &PerBar<Chord>) -> f64 {
    let Some(impactor) = state.impactor.filter(|i| i.closed) else {
        return 0.0;
    };
    let gradients = assembly::gradients(chords);
    let internal =
        assembly::internal_forces(model, &gradients, &state.forces, state.displacement.u2);
    let resisting = internal[0] + model.damping_transverse * state.velocity.v1;
    resisting * impactor.impact.mass / (impactor.impact.mass + model.impact_point_mass)
}
