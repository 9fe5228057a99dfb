//! The residual axial capacity: a static push-down of a column at rest, undamaged or with the plastic strains of an impact.
//!
//! The column gets a bow `e0` as stress-free strains, starts without axial force, and is then shortened quasi-statically
//! with plastic flow. `N_u` is the largest force at its top; the spring there takes no part. The strength of the hinges is the
//! static one, without strain rate, after all of their accumulated rotation; the webs have their undamaged resistance.
//!
//! A bumper is gone by then: both bars have their whole lengths again, and their plastic rotations are reduced so that the
//! impact point stays where it is.
//!
//! `u2` alone would not do as the control: a nearly straight column snaps back, which means that behind the largest force
//! both the force and `u2` decrease. An increment therefore prescribes a positive combination of `u2` and `v1`. The normal
//! forces push the impact point outwards, and a slope `dN/dv1` steeper than `-N/v1` would need a moment that increases while
//! the hinges flow: with the weights of [`PathStep`] the combination increases through any snap-back. It may decrease before
//! the largest force: where a hinge at an end yields first, `v1` decreases faster than `u2` grows. There `u2` alone is
//! prescribed.

use std::cell::Cell;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::bar::{BarForces, PerBar, PlasticFlow};
use super::bumper::plastic_before_bumper;
use super::fracture::share_until_fracture;
use super::frame;
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::motion::collapse_of;
use super::push_down_equations::{
    Control, Equations, Flowing, HingeCourse, LastRow, MAX_ROTATION, PathStep, Solved,
};
use super::shear::SliderStrength;
use super::state::State;

/// Largest bow that is accepted, relative to the height.
pub const MAX_IMPERFECTION: f64 = 0.1;

/// Bound of the attempted increments of one push-down; 50 to 300 are usual.
pub const MAX_PUSH_DOWN_INCREMENTS: u32 = 3_000;

/// Bound of the evaluations of the forces in one push-down, which is what it costs: 0.2 to 2.5 microseconds each, so that no
/// push-down takes longer than about 15 ms. 200 to 1 000 are usual. The last increment may exceed the bound.
pub const MAX_PUSH_DOWN_EVALUATIONS: u32 = 6_000;

/// The push-down ends when the force has fallen to this share of its largest value: the hinges have then formed a
/// mechanism, whose force `2 M(N) / w` decreases with its displacement `w`.
const FALLEN: f64 = 0.8;

/// The share at which a curve for a figure ends.
const CURVE_FALLEN: f64 = 0.4;

/// Largest increment while no hinge flows, on the scale of [`PathStep`].
const MAX_ELASTIC_INCREMENT: f64 = 0.1;

/// Largest increment while hinges flow: the error of `N_u` is proportional to it, at most 1e-4 for the reference columns.
const MAX_INCREMENT: f64 = 0.004;

/// Largest increment after it.
const MAX_INCREMENT_AFTER: f64 = 0.3;

/// Increments that must succeed after one that could not be solved before their size grows again: a failure costs as much
/// as a hundred of them.
const INCREMENTS_BEFORE_GROWTH: u32 = 16;

/// Smallest increment.
const MIN_INCREMENT: f64 = 1e-9;

/// An increment over which the force decreases is repeated with half of it until the force changes by less than this
/// share of its largest value.
const RESOLUTION: f64 = 1e-5;

/// The force has reached a plateau when it has not increased by this share of itself over a path of [`PLATEAU`].
const PLATEAU_RISE: f64 = 2e-5;

/// Length of a plateau on the scale of [`PathStep`]: twice the shortening at the squash load.
const PLATEAU: f64 = 2.0;

/// Bound of the parts in which the load is removed before the push-down.
const MAX_UNLOADING_PARTS: u32 = 64;

/// Why a push-down ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CapacityEnd {
    /// The force passed its largest value and fell: `N_u` is found.
    ForceFell,
    /// The force no longer changes: the column is squashed, practically without bending. `N_u` is found.
    Plateau,
    /// The column folded while the force still increased: it is elastic far beyond the range of the model.
    Folded,
    /// A hinge reached its ultimate rotation before the force fell.
    Fractured,
    /// The column has no equilibrium without load: it has collapsed, or it cannot be followed. The capacity is 0.
    NoEquilibrium,
    /// The path could not be followed any further. The largest force up to there is a lower bound.
    NotFollowed,
    /// The bound of the increments or of the evaluations was reached. The largest force up to there is a lower bound.
    BoundReached,
}

/// The axial capacity of a column in its plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Capacity {
    /// `N_u`: the largest compressive force at the top, without the share of the spring \[N\], >= 0.
    pub force: f64,
    /// Shortening of the column at `N_u`, counted from the unloaded column \[m\].
    pub shortening: f64,
    /// `v1` at `N_u`, bow included \[m\].
    pub v1: f64,
    /// `v1` of the unloaded column, bow included \[m\].
    pub unloaded_v1: f64,
    /// Largest utilisation of a hinge in the unloaded column; above 1 its plastic strains lie outside the static surface,
    /// and it flows before it is loaded.
    pub unloaded_utilisation: f64,
    /// `e0` \[m\].
    pub imperfection: f64,
    /// Why the push-down ended.
    pub end: CapacityEnd,
    /// Increments tried.
    pub increments: u32,
    /// Evaluations of the forces: what the push-down has cost.
    pub evaluations: u32,
}

impl Capacity {
    /// A column that carries nothing: collapsed or fractured.
    #[must_use]
    pub fn none(end: CapacityEnd) -> Self {
        Self {
            force: 0.0,
            shortening: 0.0,
            v1: 0.0,
            unloaded_v1: 0.0,
            unloaded_utilisation: 0.0,
            imperfection: 0.0,
            end,
            increments: 0,
            evaluations: 0,
        }
    }

    /// Whether `N_u` is a lower bound only, because the path could not be followed to its end.
    #[must_use]
    pub fn is_lower_bound(&self) -> bool {
        matches!(
            self.end,
            CapacityEnd::NotFollowed | CapacityEnd::BoundReached
        )
    }
}

/// One point of the push-down curve.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PushDownPoint {
    /// Shortening counted from the unloaded column \[m\].
    pub shortening: f64,
    /// Compressive force at the top, without the share of the spring \[N\].
    pub force: f64,
    /// `v1`, bow included \[m\].
    pub v1: f64,
}

/// Why a push-down was rejected.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum CapacityError {
    /// A load on a free top would sway with it.
    #[error(
        "the axial capacity is not evaluated: the top is free, and the model does not follow a load that sways with it; \
         hold the top if the column carries one"
    )]
    FreeTop,
    /// The bow is not a length of the right size.
    #[error(
        "the imperfection is {found} m; expected a length > 0 and at most {max} m, a tenth of the height. \
         A column without any imperfection has a bifurcation instead of a limit load"
    )]
    Imperfection {
        /// As given \[m\].
        found: f64,
        /// Largest that is accepted \[m\].
        max: f64,
    },
}

/// A push-down that is advanced in slices. It owns a copy of the column and does not allocate.
#[derive(Debug, Clone, Copy)]
pub struct PushDown {
    model: Model,
    /// Sign of the bow.
    sign: f64,
    /// Strains without stress: plastic strains and bow.
    offset: PerBar<PlasticFlow>,
    hinges: HingeCourse,
    /// The part of them that is the bow.
    bow: PerBar<PlasticFlow>,
    /// By how much the plastic strains of the steel were larger on the clear lengths of the bars before a bumper.
    before_bumper: PerBar<PlasticFlow>,
    displacement: Displacement,
    forces: PerBar<BarForces>,
    force: f64,
    unloaded: Displacement,
    /// Increments of the displacements and their sizes on the scale of [`PathStep`], the last one first, for the prediction of
    /// the next one.
    last: [Option<(Displacement, f64)>; 2],
    increment: f64,
    /// What led to the last increment.
    control: Control,
    flowing: Flowing,
    /// How many increments must succeed before their size grows again.
    until_growth: u32,
    /// `dN` over the size of the last increment \[N\].
    slope: f64,
    /// The force that a plateau starts from, and the length of the path since then.
    plateau: (f64, f64),
    fallen: f64,
    capacity: Capacity,
    done: bool,
}

impl PushDown {
    /// Prepares the push-down of a column at rest: `state` is its static equilibrium under the load, such as
    /// [`State::at_rest`] or [`residual_state`](super::residual_state) gives; its plastic strains and displacements are
    /// used. `imperfection` is the bow `e0` \[m\], > 0 and at most [`MAX_IMPERFECTION`] of the height; it points to the
    /// side of `v1`.
    ///
    /// # Errors
    /// An imperfection out of its range, or a free top.
    pub fn new(model: &Model, state: &State, imperfection: f64) -> Result<Self, CapacityError> {
        if model.frame.top_is_free {
            return Err(CapacityError::FreeTop);
        }
        let height = model.frame.below.length + model.frame.above.length;
        let max = MAX_IMPERFECTION * height;
        if !(imperfection > 0.0 && imperfection <= max) {
            return Err(CapacityError::Imperfection {
                found: imperfection,
                max,
            });
        }
        // Without plastic strains it is the undamaged column, whatever its equilibrium was found from: the same bits.
        let undamaged;
        let state = if state.plastic == PerBar::default() {
            undamaged = State::at_rest(model);
            &undamaged
        } else {
            state
        };
        let loaded = force_on_top(model, &state.displacement, &state.forces);
        let mut whole = model.without_bumper();
        if whole.properties.shear.is_none() {
            // A foot does not slip under a column that is only pressed.
            whole.frame.below.slider = None;
        }
        let plastic = plastic_before_bumper(model, &whole, &state.plastic);
        let steel = state.plastic_of_steel(model);
        let model = &whole;
        let sign = if state.displacement.v1 < 0.0 {
            -1.0
        } else {
            1.0
        };
        let bow = stress_free_bow(model, sign * imperfection);
        let mut push_down = Self {
            model: *model,
            sign,
            offset: plastic,
            hinges: HingeCourse::new(state.accumulated_rotation()),
            bow,
            before_bumper: plus(&steel, -1.0, &plastic),
            displacement: state.displacement,
            forces: PerBar::default(),
            force: 0.0,
            unloaded: Displacement::default(),
            last: [None; 2],
            increment: MAX_ELASTIC_INCREMENT,
            control: Control::Both,
            flowing: Flowing::ANY,
            until_growth: 0,
            slope: f64::INFINITY,
            plateau: (0.0, 0.0),
            fallen: FALLEN,
            capacity: Capacity {
                imperfection,
                ..Capacity::none(CapacityEnd::NoEquilibrium)
            },
            done: false,
        };
        push_down.unload(state, loaded);
        Ok(push_down)
    }

    /// Makes at most `max_increments` attempts at an increment; the capacity once it is known.
    pub fn advance(&mut self, max_increments: u32) -> Option<Capacity> {
        for _ in 0..max_increments {
            if self.done {
                break;
            }
            self.try_increment();
        }
        self.done.then_some(self.capacity)
    }

    /// Where the push-down has come to.
    #[must_use]
    pub fn point(&self) -> PushDownPoint {
        PushDownPoint {
            shortening: self.displacement.u2 - self.unloaded.u2,
            force: self.force,
            v1: self.displacement.v1,
        }
    }

    /// Removes the load and adds the bow, with the plastic strains frozen: in one part, or in smaller ones.
    fn unload(&mut self, state: &State, loaded: f64) {
        let (model, plastic) = (self.model, self.offset);
        let (mut share, mut part) = (0.0_f64, 1.0_f64);
        let mut u = state.displacement;
        let evaluations = Cell::new(0);
        for _ in 0..MAX_UNLOADING_PARTS {
            let next = (share + part).min(1.0);
            let offset = plus(&plastic, next, &self.bow);
            let equations = Equations {
                model: &model,
                offset: &offset,
                strength: &PerBar::default(),
                elastic: true,
                evaluations: &evaluations,
                last: LastRow::Force((1.0 - next) * loaded),
            };
            let solved = equations
                .solve(u, &state.forces, Flowing::ANY)
                .map(|(solved, _)| solved)
                .filter(|solved| collapse_of(&model, &solved.displacement).is_none());
            let Some(solved) = solved else {
                part *= 0.5;
                continue;
            };
            share = next;
            u = solved.displacement;
            if share >= 1.0 {
                self.begin(&solved, offset);
                if self.fractured_after(&self.offset).is_some() {
                    self.finish(CapacityEnd::Fractured);
                }
                return;
            }
        }
        self.finish(CapacityEnd::NoEquilibrium);
    }

    fn begin(&mut self, unloaded: &Solved, offset: PerBar<PlasticFlow>) {
        self.offset = offset;
        self.displacement = unloaded.displacement;
        self.unloaded = unloaded.displacement;
        self.forces = unloaded.forces();
        self.force = 0.0;
        let strength = self.hinges.strength(&self.model, 0.0, &self.forces);
        let PerBar { below, above } = &self.forces;
        let mut utilisation = 0.0_f64;
        for (bar, forces, strength) in [
            (&self.model.frame.below, below, &strength.below),
            (&self.model.frame.above, above, &strength.above),
        ] {
            let weakest = strength.weakest();
            utilisation = utilisation
                .max(strength.utilisation(bar, forces))
                .max(bar.web_utilisation(forces, &SliderStrength::UNDAMAGED, weakest));
        }
        self.capacity.unloaded_v1 = self.unloaded.v1;
        self.capacity.v1 = self.unloaded.v1;
        self.capacity.unloaded_utilisation = utilisation;
    }

    fn finish(&mut self, end: CapacityEnd) {
        self.capacity.end = end;
        self.done = true;
    }

    /// One increment: accepted, or repeated later with half its size.
    fn try_increment(&mut self) {
        if self.capacity.increments >= MAX_PUSH_DOWN_INCREMENTS
            || self.capacity.evaluations >= MAX_PUSH_DOWN_EVALUATIONS
        {
            return self.finish(CapacityEnd::BoundReached);
        }
        self.capacity.increments += 1;
        let model = self.model;
        let evaluations = Cell::new(self.capacity.evaluations);
        let predicted = self.predicted();
        let strength = self.hinges.strength(&model, self.increment, &self.forces);
        let along = |control: Control| {
            let path = PathStep::new(
                &model,
                control,
                self.sign,
                self.displacement,
                self.increment,
            );
            let equations = Equations {
                model: &model,
                offset: &self.offset,
                strength: &strength,
                elastic: false,
                evaluations: &evaluations,
                last: LastRow::Path(path),
            };
            let solve = |guess| {
                let solved = equations.solve(guess, &self.forces, self.flowing);
                solved.filter(|(it, _)| {
                    path.reaches(&it.displacement) && self.is_near(&it.displacement)
                })
            };
            let (solved, flowing) = solve(predicted).or_else(|| solve(self.displacement))?;
            Some((solved, control, flowing))
        };
        let found = along(self.control).or_else(|| along(self.control.other()));
        self.capacity.evaluations = evaluations.get();
        let Some((solved, control, flowing)) = found else {
            return self.halve(CapacityEnd::NotFollowed);
        };
        if collapse_of(&model, &solved.displacement).is_some() {
            return self.halve(CapacityEnd::Folded);
        }
        if self.increment > MAX_INCREMENT && self.force >= self.capacity.force && solved.flows() {
            self.increment = MAX_INCREMENT.max(0.25 * self.increment);
            return;
        }
        let change = solved.force - self.force;
        let resolution = RESOLUTION * self.capacity.force.max(solved.force);
        let before_peak = self.force >= self.capacity.force;
        if change < 0.0 && before_peak && self.capacity.force > 0.0 {
            // The largest force lies within this increment, not higher than the last slope leads to.
            let missed = self.slope.max(0.0) * self.increment;
            if missed.min(MAX_INCREMENT * model.properties.resistance_axial) > resolution
                && self.increment > MIN_INCREMENT
            {
                self.increment *= 0.5;
                return;
            }
        }
        (self.control, self.flowing) = (control, flowing);
        self.accept(&solved, change);
    }

    /// Where the next increment is expected to end: the rate of the displacements along the path goes on as it has changed.
    fn predicted(&self) -> Displacement {
        let [Some((step, size)), before] = self.last else {
            return self.displacement;
        };
        let rate = step.times(1.0 / size);
        let rate = before.map_or(rate, |(step, size_before)| {
            // The rates are those in the middles of the increments.
            let change = rate.minus(step.times(1.0 / size_before));
            rate.plus((size + self.increment) / (size + size_before), change)
        });
        self.displacement.plus(self.increment, rate)
    }

    fn accept(&mut self, solved: &Solved, change: f64) {
        let size = self.increment;
        let step = solved.displacement.minus(self.displacement);
        let (from, offset) = (self.displacement, self.offset);
        self.last = [Some((step, size)), self.last[0]];
        self.slope = change / size;
        self.displacement = solved.displacement;
        self.forces = solved.forces();
        self.force = solved.force;
        let stress = &solved.stress;
        let (below, above) = (&stress.below.returned.flow, &stress.above.returned.flow);
        self.offset = PerBar {
            below: offset.below.plus(1.0, below),
            above: offset.above.plus(1.0, above),
        };
        self.hinges.add(below, above, size);
        if let Some(share) = self.fractured_after(&offset) {
            self.compare(self.force - (1.0 - share) * change, from.plus(share, step));
            return self.finish(CapacityEnd::Fractured);
        }
        let increases = self.compare(self.force, self.displacement);
        if !increases && self.force <= self.fallen * self.capacity.force {
            return self.finish(CapacityEnd::ForceFell);
        }
        self.plateau.1 += size;
        let p = &self.model.properties;
        if self.force >= (1.0 - PLATEAU_RISE) * p.resistance_axial {
            if p.hardening_ratio > 0.0 {
                // Between its hinges the column has not hardened: its section is squashed.
                self.capacity.force = self.capacity.force.min(p.resistance_axial);
            }
            return self.finish(CapacityEnd::Plateau);
        }
        if self.force > self.plateau.0 * (1.0 + PLATEAU_RISE) {
            self.plateau = (self.force, 0.0);
        } else if self.force < self.plateau.0 * (1.0 - PLATEAU_RISE) {
            self.plateau.1 = 0.0;
        } else if self.plateau.1 > PLATEAU {
            return self.finish(CapacityEnd::Plateau);
        }
        let flat = change < PLATEAU_RISE * size * self.force;
        let max = if flat {
            MAX_INCREMENT_AFTER
        } else if solved.flows() {
            MAX_INCREMENT
        } else {
            MAX_ELASTIC_INCREMENT
        };
        self.increment = if self.until_growth > 0 {
            self.until_growth -= 1;
            size.min(max)
        } else {
            (2.0 * size).min(max)
        };
    }

    /// Whether this force is the largest so far, which it then becomes.
    fn compare(&mut self, force: f64, u: Displacement) -> bool {
        let is_largest = force > self.capacity.force;
        if is_largest {
            self.capacity.force = force;
            self.capacity.shortening = u.u2 - self.unloaded.u2;
            self.capacity.v1 = u.v1;
        }
        is_largest
    }

    fn halve(&mut self, reason: CapacityEnd) {
        if self.increment <= MIN_INCREMENT {
            self.finish(reason);
        } else {
            self.increment *= 0.5;
            self.until_growth = INCREMENTS_BEFORE_GROWTH;
        }
    }

    /// The share of the last increment, which began with these strains without stress, after which a hinge or web is fractured.
    fn fractured_after(&self, before: &PerBar<PlasticFlow>) -> Option<f64> {
        let plastic = |offset: &PerBar<PlasticFlow>| {
            plus(&plus(offset, -1.0, &self.bow), 1.0, &self.before_bumper)
        };
        share_until_fracture(&self.model, &plastic(before), &plastic(&self.offset))
    }

    /// Whether the solution belongs to the path: one that is much further away has leapt to another equilibrium.
    fn is_near(&self, u: &Displacement) -> bool {
        let Displacement { v1, u1, beta1, u2 } = u.minus(self.displacement);
        let reach = 0.2 * self.model.frame.shorter_bar();
        let moved = v1.abs().max(u1.abs()).max(u2.abs());
        moved < reach && beta1.abs() < MAX_ROTATION
    }
}

/// The capacity of a column at rest; see [`PushDown::new`] for the arguments.
///
/// # Errors
/// An imperfection out of its range.
pub fn capacity(
    model: &Model,
    state: &State,
    imperfection: f64,
) -> Result<Capacity, CapacityError> {
    let mut push_down = PushDown::new(model, state, imperfection)?;
    loop {
        if let Some(capacity) = push_down.advance(MAX_PUSH_DOWN_INCREMENTS + 1) {
            return Ok(capacity);
        }
    }
}

/// What a push-down that may end early knows of the capacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownCapacity {
    /// `N_u` is at least the force that was asked for.
    Enough,
    /// `N_u` is less, and this is the capacity.
    Found(Capacity),
}

/// Whether the [`capacity`] of a column at rest is at least `enough` \[N\]: the push-down ends as soon as its force has reached
/// that, which is a proof, because `N_u` is the largest force of the same push-down.
///
/// # Errors
/// An imperfection out of its range.
pub fn capacity_up_to(
    model: &Model,
    state: &State,
    imperfection: f64,
    enough: f64,
) -> Result<KnownCapacity, CapacityError> {
    let mut push_down = PushDown::new(model, state, imperfection)?;
    loop {
        if push_down.capacity.force >= enough {
            return Ok(KnownCapacity::Enough);
        }
        if let Some(capacity) = push_down.advance(1) {
            return Ok(match capacity.force >= enough {
                true => KnownCapacity::Enough,
                false => KnownCapacity::Found(capacity),
            });
        }
    }
}

/// The capacity of a column at rest, with every point of its push-down curve, the unloaded column first. The curve goes on
/// until the force has fallen well below its largest value.
///
/// # Errors
/// An imperfection out of its range.
pub fn push_down(
    model: &Model,
    state: &State,
    imperfection: f64,
    observe: &mut dyn FnMut(&PushDownPoint),
) -> Result<Capacity, CapacityError> {
    let mut push_down = PushDown::new(model, state, imperfection)?;
    push_down.fallen = CURVE_FALLEN;
    let mut seen = push_down.point();
    if !push_down.done {
        observe(&seen);
    }
    loop {
        let end = push_down.advance(1);
        let here = push_down.point();
        if here != seen {
            observe(&here);
            seen = here;
        }
        if let Some(capacity) = end {
            return Ok(capacity);
        }
    }
}

/// `N`: the compressive force that the column of a state carries at its top, without the share of the spring \[N\].
#[must_use]
pub fn carried_load(model: &Model, state: &State) -> f64 {
    force_on_top(model, &state.displacement, &state.forces)
}

/// `F0`: the transverse force at the impact point under which the column forms a plastic mechanism while it carries the
/// compressive force `normal_force` \[N\]. Built in at both ends it is `2 M(N) (1/L_a + 1/L_b)`; a pinned end takes its
/// share away; with a free top `M(N)/L_a` is left. With [`shear`](super::ShearProperties) the lengths are the clear ones, and each bar
/// bears no more than its web, `V_s v(N/N^p)`: the weaker mechanism of either bar counts. At the base no more counts than the moment of
/// its connection, and of the lower bar no more than the connection bears against slipping.
#[must_use]
pub fn plastic_plateau(model: &Model, normal_force: f64) -> f64 {
    let at_impact = if model.frame.top_is_free { 0.0 } else { 1.0 };
    let connection = &model.properties.base_connection;
    let most_at_base = connection.map_or(f64::INFINITY, |it| it.moment(-normal_force));
    let most_of_base = connection.map_or(f64::INFINITY, |it| it.shear(-normal_force));
    [
        (&model.frame.below, most_at_base, most_of_base),
        (&model.frame.above, f64::INFINITY, f64::INFINITY),
    ]
    .into_iter()
    .map(|(bar, most_at_end, most_shear)| {
        let at_end = if bar.rotational[1][1] > 0.0 { 1.0 } else { 0.0 };
        let resistance = bar.surface.moment_resistance(normal_force);
        let moments = at_impact * resistance + at_end * most_at_end.min(resistance);
        let n = bar.surface.relative_axial(normal_force).abs();
        let web = bar.slider.filter(|_| model.properties.shear.is_some());
        let web = web.map_or(f64::INFINITY, |web| web.limit(1.0, n));
        moments.min(web).min(most_shear * bar.length) / bar.length
    })
    .sum()
}

/// `E(U0) - E(0)` with `U0 = (bow, 0, 0, 0)`.
fn stress_free_bow(model: &Model, bow: f64) -> PerBar<PlasticFlow> {
    let of_bar = |length: f64| {
        let chord = Chord::new(length, 0.0, bow);
        PlasticFlow {
            elongation: [0.5 * chord.elongation; 2],
            rotation: [chord.angle(); 2],
            ..PlasticFlow::default()
        }
    };
    PerBar {
        below: of_bar(model.frame.below.length),
        above: of_bar(model.frame.above.length),
    }
}

fn plus(
    strains: &PerBar<PlasticFlow>,
    factor: f64,
    more: &PerBar<PlasticFlow>,
) -> PerBar<PlasticFlow> {
    PerBar {
        below: strains.below.plus(factor, &more.below),
        above: strains.above.plus(factor, &more.above),
    }
}

/// Compressive force at the top, without the share of the spring \[N\].
fn force_on_top(model: &Model, u: &Displacement, forces: &PerBar<BarForces>) -> f64 {
    let frame = &model.frame;
    let gradients = frame::gradients(&frame.chords(u));
    frame.internal_forces(&gradients, forces, 0.0)[3]
}
