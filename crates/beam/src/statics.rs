//! Equilibrium: under the load before an impact, after it, and while the top is pushed down.

use super::beam::{Beam, Kind, State};
use super::newton::{Push, Solver};

/// Stiffness of what pushes over that of the column along its axis.
const STIFFER: f64 = 1e5;

/// Increments of a push-down.
const MAX_INCREMENTS: usize = 400;

/// Halvings of an increment.
const MAX_HALVINGS: usize = 12;

/// Fall of the force below its maximum at which a push-down ends.
const FALLEN: f64 = 0.97;

/// Brings a state to rest; whether there is an equilibrium near it.
pub(crate) fn settle<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
) -> bool {
    rest(beam, state, solver, 1.0)
}

/// Least and first share of the load by which it grows in steps.
const LOAD_STEPS: [f64; 2] = [1.0 / 1024.0, 0.5];

/// Most steps in which a load grows.
const MAX_LOAD_STEPS: usize = 100;

/// Brings a state to rest under a load that grows in steps; whether the column bears all of it.
pub(crate) fn load_in_steps<const D: usize, const R: usize, const Q: usize>(
    beam: &mut Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
) -> bool {
    let whole = beam.top_load;
    let [least, mut step] = LOAD_STEPS;
    let mut borne = 0.0;
    for _ in 0..MAX_LOAD_STEPS {
        let share = f64::min(borne + step, 1.0);
        beam.top_load = share * whole;
        let before = state.clone();
        if settle(beam, state, solver) && solver.negative_pivots == 0 {
            borne = share;
        } else {
            *state = before;
            step *= 0.5;
        }
        if borne == 1.0 || step < least {
            break;
        }
    }
    beam.top_load = whole;
    borne == 1.0
}

/// Brings a state to rest without any flow: for plastic strains that came from other nodes.
pub(crate) fn settle_elastically<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
) -> bool {
    rest(beam, state, solver, 1e6)
}

fn rest<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
    strength: f64,
) -> bool {
    solver.begin();
    solver.energy_tolerance = f64::INFINITY;
    solver.tolerance = 1e-7 * beam.section.steel.yield_strength * beam.section.area;
    state.velocity.fill([0.0; 6]);
    state.rates.fill([0.0, strength]);
    if !solver.solve(beam, state, Kind::Equilibrium, None) {
        return false;
    }
    beam.commit(state, solver.increment(), Kind::Equilibrium, &solver.work);
    true
}

/// The largest force \[N\] that a column at rest bears while its top is pushed down; `None` where it finds no maximum.
pub(crate) fn push_down<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    from: &State<D, R>,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    let mut pushed = beam.clone();
    pushed.top_spring = 0.0;
    pushed.top_load = 0.0;
    let top = beam.places.len() - 1;
    let steel = &beam.section.steel;
    let squash = steel.yield_strength * beam.section.area;
    solver.tolerance = 1e-7 * squash;
    let unit = steel.yield_strength / steel.young_modulus * beam.places[top][0];
    let step = 0.05 * unit;
    solver.pushes.push(Push {
        node: top,
        unknown: 0,
        stiffness: STIFFER * steel.young_modulus * beam.section.area / beam.places[top][0],
        target: 0.0,
        force: -(beam.top_load + beam.top_spring * from.moved[top][0]),
    });
    let most = descend(&pushed, from.clone(), step, solver);
    solver.pushes.clear();
    most
}

/// Pushes down to the maximum of the force.
fn descend<const D: usize, const R: usize, const Q: usize>(
    pushed: &Beam<D, R, Q>,
    mut state: State<D, R>,
    mut step: f64,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    // Descent and force of the last three states.
    let mut last: Vec<[f64; 2]> = Vec::new();
    let mut descent = 0.0;
    let mut halvings = 0;
    let mut refined = 0;
    let mut best: f64 = 0.0;
    let mut before: Option<(State<D, R>, [f64; 2])> = None;
    for _ in 0..MAX_INCREMENTS {
        solver.begin();
        let force_before = solver.pushes[0].force;
        solver.pushes[0].aim(-step);
        let saved = state.clone();
        if !solver.solve(pushed, &state, Kind::Equilibrium, None) || solver.negative_pivots > 0 {
            if halvings == MAX_HALVINGS {
                return (best > 0.0).then_some(best);
            }
            halvings += 1;
            step *= 0.5;
            solver.pushes[0].force = force_before;
            continue;
        }
        pushed.commit(
            &mut state,
            solver.increment(),
            Kind::Equilibrium,
            &solver.work,
        );
        descent += step;
        let force = -solver.pushes[0].force;
        // The peak lies between the steps: go back and pass it with finer ones.
        if let Some((earlier, at)) = before.take()
            && last.last().is_some_and(|point| force < point[1])
            && refined < 3
        {
            refined += 1;
            state = earlier;
            [descent, solver.pushes[0].force] = at;
            step *= 0.25;
            let keep = last.len().saturating_sub(1);
            last.truncate(keep);
            continue;
        }
        before = Some((saved, [descent - step, force_before]));
        best = best.max(force);
        last.push([descent, force]);
        // A column that hangs from its spring is in tension at first.
        if best > 0.0 && force < FALLEN * best {
            break;
        }
        if refined == 3 && last.len() > 2 && force < best {
            break;
        }
    }
    (best > 0.0).then_some(best)
}

/// Increments of a push from the side.
const SIDEWAYS_INCREMENTS: usize = 60;

/// The largest force \[N\] with which these nodes resist while they are pushed by `way` \[m\] along y.
pub(crate) fn push_sideways<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    from: &State<D, R>,
    nodes: &[usize],
    way: f64,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    let steel = &beam.section.steel;
    let stiffness =
        STIFFER * steel.young_modulus * beam.section.area / beam.places[beam.places.len() - 1][0];
    solver.pushes.extend(nodes.iter().map(|&node| Push {
        node,
        unknown: 1,
        stiffness,
        target: 0.0,
        force: 0.0,
    }));
    let most = sideways(beam, from.clone(), way, solver);
    solver.pushes.clear();
    most
}

fn sideways<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    mut state: State<D, R>,
    way: f64,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    let (mut most, mut gone) = (0.0_f64, 0.0);
    let mut step = way / SIDEWAYS_INCREMENTS as f64;
    for _ in 0..MAX_INCREMENTS {
        solver.begin();
        let before: Vec<Push> = solver.pushes.clone();
        for push in &mut solver.pushes {
            push.aim(step);
        }
        if !solver.solve(beam, &state, Kind::Equilibrium, None) {
            solver.pushes = before;
            step *= 0.5;
            if step < 1e-4 * way {
                return None;
            }
            continue;
        }
        beam.commit(
            &mut state,
            solver.increment(),
            Kind::Equilibrium,
            &solver.work,
        );
        most = most.max(solver.pushes.iter().map(|push| push.force).sum());
        gone += step;
        if gone >= way {
            break;
        }
    }
    Some(most)
}
