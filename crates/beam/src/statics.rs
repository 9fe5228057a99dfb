//! Equilibrium: under the load before an impact, after it, and while the top is pushed down.

use super::beam::{Beam, Kind, State};
use super::newton::{Push, Solver};

/// What a displacement test says of a response that ends in a collapse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollapseTest {
    /// The largest share of the load that the column bears from where its response has ended on; below 1, there is no equilibrium.
    /// NaN where no equilibrium was found even with the top held.
    pub share_borne: f64,
    /// Whether the spring at the top takes the whole load before the column has lost a quarter of its height.
    pub hangs: bool,
    /// Whether the column has lost its shape for good: an element is crushed to nothing, or, let go from where its response has ended,
    /// it rests or falls beyond the limits of the shape. Not tested where the load is not borne.
    pub lost_shape: bool,
}

impl CollapseTest {
    /// Whether the load is borne nowhere.
    #[must_use]
    pub fn gives_way(&self) -> bool {
        self.share_borne < 1.0 && !self.hangs
    }
}

/// Stiffness of what pushes over that of the column along its axis.
const STIFFER: f64 = 1e5;

/// Increments of a push-down.
const MAX_INCREMENTS: usize = 400;

/// Halvings of an increment.
const MAX_HALVINGS: usize = 12;

/// Brings a state to rest; whether there is an equilibrium near it.
pub(crate) fn settle<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
) -> bool {
    rest(beam, state, solver, 1.0)
}

/// Step in which a column that was let go moves \[s\]: a twentieth of the period of a column of 4 m; and most steps: a second of
/// movement.
const RELEASED_STEP: f64 = 5e-4;
const MAX_RELEASED_STEPS: usize = 2000;

/// Brings a state to rest, also where its equilibrium is too far away for Newton's method: the column is then let go from where it
/// is, and stopped whenever its kinetic energy falls, so that it never swings through. Whether it stands, with its top lowered by
/// at most `lowest` \[m\].
pub(crate) fn come_to_rest<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
    lowest: f64,
) -> bool {
    let from = state.clone();
    if settle(beam, state, solver) && solver.negative_pivots == 0 {
        return true;
    }
    state.clone_from(&from);
    let_go(beam, state, solver, lowest)
}

/// The movement to rest of a column that is let go, as [`come_to_rest`] says.
pub(crate) fn let_go<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    state: &mut State<D, R>,
    solver: &mut Solver<D, R>,
    lowest: f64,
) -> bool {
    // At rest the strain rate does not count.
    let mut slow = beam.clone();
    slow.rate = None;
    let top = beam.places.len() - 1;
    let mut secs = RELEASED_STEP;
    let mut kinetic = 0.0;
    let mut stops = 0_u32;
    let mut forces = Vec::with_capacity(solver.pushes.len());
    stop(state);
    solver.begin();
    solver.remember(secs);
    for _ in 0..MAX_RELEASED_STEPS {
        solver.energy_tolerance = f64::INFINITY;
        solver.tolerance = 1e-6 * beam.section.steel.yield_strength * beam.section.area;
        solver.go_on(secs);
        forces.clear();
        forces.extend(solver.pushes.iter().map(|push| push.force));
        for push in &mut solver.pushes {
            push.aim(0.0);
        }
        let kind = Kind::Motion { secs };
        if !solver.solve(&slow, state, kind, None) {
            for (push, force) in solver.pushes.iter_mut().zip(&forces) {
                push.force = *force;
            }
            secs *= 0.5;
            if secs < RELEASED_STEP / f64::from(1_u32 << MAX_HALVINGS) {
                return false;
            }
            solver.begin();
            solver.remember(secs);
            continue;
        }
        slow.commit(state, solver.increment(), kind, &solver.work);
        solver.remember(secs);
        secs = RELEASED_STEP.min(2.0 * secs);
        if -state.moved[top][0] > lowest {
            return false;
        }
        let [now, _] = slow.energies(state);
        if now >= kinetic {
            kinetic = now;
            continue;
        }
        kinetic = 0.0;
        stop(state);
        solver.begin();
        solver.remember(secs);
        stops += 1;
        // Each trial that fails costs as much as many steps.
        if stops.is_power_of_two() {
            let mut rests = state.clone();
            for push in &mut solver.pushes {
                push.aim(0.0);
            }
            if settle(beam, &mut rests, solver) && solver.negative_pivots == 0 {
                *state = rests;
                return true;
            }
        }
    }
    false
}

/// Takes the velocity from a state.
fn stop<const D: usize, const R: usize>(state: &mut State<D, R>) {
    state.velocity.fill([0.0; 6]);
    state.rates.fill([0.0, 1.0]);
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
    from: State<D, R>,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    let mut pushed = beam.clone();
    pushed.top_spring = 0.0;
    pushed.top_load = 0.0;
    let top = beam.places.len() - 1;
    let steel = &beam.section.steel;
    let squash = steel.yield_strength * beam.section.area;
    solver.tolerance = 1e-7 * squash;
    let length = beam.places[top][0];
    let unit = steel.yield_strength / steel.young_modulus * length;
    let [strong, weak] = beam.section.second_moment;
    let bends = if D == 3 { strong } else { strong.min(weak) };
    let pi = core::f64::consts::PI;
    let elastic = ELASTIC_STEP * unit.min(pi * pi * bends / (beam.section.area * length));
    solver.pushes.push(Push {
        node: top,
        unknown: 0,
        stiffness: STIFFER * steel.young_modulus * beam.section.area / beam.places[top][0],
        target: 0.0,
        force: -(beam.top_load + beam.top_spring * from.moved[top][0]),
    });
    let most = descend(&pushed, from, unit, elastic, solver);
    solver.pushes.clear();
    most
}

/// Increments of a push-down before any fibre flows and from then on, and where it ends without a maximum, over the shortening at
/// which a short column yields. Before any fibre flows it is also over the shortening at which the pinned column buckles elastically:
/// an increment of twice this finds the equilibrium with the opposite bow. Where fibres flow, longer increments change the maximum by
/// 0.3 %.
const ELASTIC_STEP: f64 = 0.2;
const STEP: f64 = 0.05;
const LONGEST: f64 = 20.0;

/// How often the increments become shorter at the maximum, and by which factor: the parabola through the last three points finds the
/// rest.
const REFINEMENTS: usize = 1;
const FINER: f64 = 0.25;

/// A state of a push-down, with its descent \[m\] and its force \[N\].
struct Reached<const D: usize, const R: usize> {
    state: State<D, R>,
    descent: f64,
    force: f64,
}

/// Pushes down to the maximum of the force, at first in increments of `elastic` \[m\].
fn descend<const D: usize, const R: usize, const Q: usize>(
    pushed: &Beam<D, R, Q>,
    mut state: State<D, R>,
    unit: f64,
    elastic: f64,
    solver: &mut Solver<D, R>,
) -> Option<f64> {
    let mut step = elastic;
    // Descent and force of the states since the last refinement.
    let mut last: Vec<[f64; 2]> = Vec::new();
    let mut descent = 0.0;
    let mut halvings = 0;
    let mut refined = 0;
    // A column that hangs from its spring is in tension at first.
    let mut best: f64 = 0.0;
    let mut before: Option<Reached<D, R>> = None;
    let mut saved = state.clone();
    solver.begin();
    solver.remember(step);
    for _ in 0..MAX_INCREMENTS {
        // The last movement continues.
        solver.go_on(step);
        let force_before = solver.pushes[0].force;
        solver.pushes[0].aim(-step);
        if !solver.solve(pushed, &state, Kind::Equilibrium, None)
            || solver.is_unstable(pushed, &state)
        {
            if halvings == MAX_HALVINGS {
                return (best > 0.0).then_some(best);
            }
            halvings += 1;
            step *= 0.5;
            solver.pushes[0].force = force_before;
            solver.begin();
            solver.remember(step);
            continue;
        }
        if step > STEP * unit && solver.work.flows() {
            step = STEP * unit;
            solver.pushes[0].force = force_before;
            continue;
        }
        solver.remember(step);
        saved.clone_from(&state);
        pushed.commit(
            &mut state,
            solver.increment(),
            Kind::Equilibrium,
            &solver.work,
        );
        descent += step;
        let force = -solver.pushes[0].force;
        let falls = last.last().is_some_and(|point| force < point[1]);
        // The peak lies between the steps: go back and pass it with finer ones.
        if let Some(earlier) = before.take()
            && falls
            && refined < REFINEMENTS
        {
            refined += 1;
            state.clone_from(&earlier.state);
            (descent, solver.pushes[0].force) = (earlier.descent, earlier.force);
            step *= FINER;
            // The last movement was one beyond the peak.
            solver.begin();
            solver.remember(step);
            last.clear();
            last.push([descent, -earlier.force]);
            continue;
        }
        before = Some(Reached {
            state: saved.clone(),
            descent: descent - step,
            force: force_before,
        });
        best = best.max(force);
        last.push([descent, force]);
        if refined == REFINEMENTS && falls || descent > LONGEST * unit {
            break;
        }
    }
    if let [.., one, two, three] = last.as_slice()
        && two[1] > one[1]
        && two[1] > three[1]
    {
        best = best.max(top_of_parabola([*one, *two, *three]));
    }
    (best > 0.0).then_some(best)
}

/// The maximum of the parabola through three points, the middle one of which is the highest.
fn top_of_parabola([[x, a], [y, b], [z, c]]: [[f64; 2]; 3]) -> f64 {
    let (left, right) = ((b - a) / (y - x), (c - b) / (z - y));
    let curvature = (right - left) / (z - x);
    let slope = left + curvature * (y - x);
    b - 0.25 * slope * slope / curvature
}

/// Increments in which the top of a collapsed column is lowered, and by how much of its height in all.
const LOWERINGS: usize = 40;
const LOWERED: f64 = 0.25;

/// The largest share of its load that a column bears from a state of its movement on: at rest with its top held where it is, and
/// lowered from there.
pub(crate) fn share_borne<const D: usize, const R: usize, const Q: usize>(
    beam: &Beam<D, R, Q>,
    mut state: State<D, R>,
    solver: &mut Solver<D, R>,
) -> CollapseTest {
    let mut held = beam.clone();
    (held.top_spring, held.top_load) = (0.0, 0.0);
    let top = beam.places.len() - 1;
    let steel = &beam.section.steel;
    let (squash, height) = (
        steel.yield_strength * beam.section.area,
        beam.places[top][0],
    );
    let load = |state: &State<D, R>| beam.top_load + beam.top_spring * state.moved[top][0];
    stop(&mut state);
    solver.pushes.push(Push {
        node: top,
        unknown: 0,
        stiffness: STIFFER * steel.young_modulus * beam.section.area / height,
        target: 0.0,
        force: -load(&state),
    });
    let mut found = CollapseTest {
        share_borne: f64::NAN,
        hangs: false,
        lost_shape: false,
    };
    // The first equilibrium is where the top is already.
    let (mut step, mut lowered, mut solved) = (0.0, 0.0, false);
    let least = LOWERED * height / LOWERINGS as f64 / 64.0;
    for _ in 0..3 * LOWERINGS {
        let force = solver.pushes[0].force;
        solver.tolerance = 1e-6 * squash;
        solver.energy_tolerance = f64::INFINITY;
        solver.begin();
        solver.pushes[0].aim(-step);
        if solver.solve(&held, &state, Kind::Equilibrium, None) {
            held.commit(
                &mut state,
                solver.increment(),
                Kind::Equilibrium,
                &solver.work,
            );
        } else if solved {
            solver.pushes[0].force = force;
            step *= 0.5;
            if step < least {
                break;
            }
            continue;
        } else if !let_go(&held, &mut state, solver, f64::INFINITY) {
            break;
        }
        solved = true;
        lowered += step;
        let share = -solver.pushes[0].force / load(&state);
        found.hangs = load(&state) <= 0.0;
        if found.hangs || lowered > LOWERED * height {
            break;
        }
        found.share_borne = found.share_borne.max(share);
        step = LOWERED * height / LOWERINGS as f64;
    }
    solver.pushes.clear();
    found
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
