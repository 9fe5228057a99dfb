//! One impact, from the touch to the peak displacement, and what remains after it.

use column_mechanics::{Impact, MIN_EXTENT};

use super::beam::{BARS, Beam, Kind, State};
use super::contact::Striker;
use super::movement::Watch;
use super::newton::Solver;

/// Halvings of a step that does not converge.
const MAX_HALVINGS: u32 = 10;

/// Time over which shear and moment of the base are averaged \[s\].
const WINDOW: f64 = 1e-3;

/// Displacement over the length of the column beyond which a column at rest has lost its shape: this is a collapse, whatever it bears.
const COLLAPSED: f64 = 0.5;

/// Displacement over the length without which a step that does not converge is an error and no collapse.
const CONFIRMED: f64 = 0.08;

/// Descent of the top over the length beyond which it has lost its shape, too.
pub(crate) const DESCENDED: f64 = 0.25;

/// Factor of these limits beyond which a column has collapsed before it is at rest, as the two bars whose top descends by half the
/// height: up to there the spring at the top, or its elasticity, may lift it back.
pub(crate) const MOVING: f64 = 2.0;

/// Most steps of a response.
pub(crate) const MAX_STEPS: u64 = 200_000;

/// Most updates of a fibre that a response takes, which bounds its time whatever mesh and step are given. With the finest mesh of the
/// parameters and a step chosen by itself, an oblique hit by a lorry takes a sixth of them.
pub(crate) const MAX_FIBRE_UPDATES: u64 = 2_000_000_000;

/// Energy that the steps of a response may lose together, over the energy put in: half of what its ledger is promised to close to.
const ENERGY_BUDGET: f64 = 5e-9;

/// Share of what is left of it that one step may lose.
const BUDGET_OF_A_STEP: f64 = 0.02;

/// Evaluations of a step beyond which the column rings faster than its steps can follow.
const USUAL_EVALUATIONS: u64 = 2;

/// Share of the increment before the last one in the start of a step then, because the increments alternate. Of 0.5 to 1, it takes the fewest
/// evaluations in most cases.
const SHARE_OF_ALTERNATION: f64 = 0.9;

/// Share of the peak displacement by which the column comes back before a response ends.
const BACK: f64 = 0.02;

/// What a response has found.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Course {
    /// Peak displacement along and at right angles to the direction \[m\], and when the first \[s\].
    pub largest: [f64; 2],
    pub time: f64,
    pub yielded: bool,
    pub collapsed: bool,
    /// It did not converge, and the column has not moved far enough to have collapsed.
    pub stuck: bool,
    pub base_shear: f64,
    /// Moment of the base that bends the column along the hit \[N m\], as the shear is averaged.
    pub base_moment: f64,
    pub steps: u64,
    pub evaluations: u64,
    pub halvings: u64,
    pub secs: f64,
    /// Energy of vehicle and column that the equations have lost \[J\], and energy put in.
    pub energy_error: f64,
    pub energy_in: f64,
    pub impulse: f64,
}

/// An increment of a step that has been solved, and the time of this step \[s\].
struct Past<const D: usize> {
    nodes: Vec<[f64; D]>,
    shear: [f64; BARS],
    secs: f64,
}

impl<const D: usize> Past<D> {
    fn none(nodes: usize) -> Self {
        Self {
            nodes: vec![[0.0; D]; nodes],
            shear: [0.0; BARS],
            secs: 1.0,
        }
    }
}

/// A running response.
pub(crate) struct Run<'a, const D: usize, const R: usize, const Q: usize> {
    pub beam: &'a Beam<D, R, Q>,
    pub state: State<D, R>,
    pub solver: Solver<D, R>,
    pub striker: Striker,
    pub normal: [f64; 2],
    /// Node of the impact point.
    pub node: usize,
    pub course: Course,
    internal: f64,
    /// The last increment and the one before it, each with its time \[s\].
    last: Past<D>,
    older: Past<D>,
    /// Whether the last step took more than the usual evaluations.
    rings: bool,
    /// Sums of shear and moment over time, and that time \[s\].
    window: [f64; 3],
}

impl<'a, const D: usize, const R: usize, const Q: usize> Run<'a, D, R, Q> {
    pub fn new(
        beam: &'a Beam<D, R, Q>,
        state: State<D, R>,
        impact: &Impact,
        direction: f64,
        touches: &[(usize, f64)],
        node: usize,
    ) -> Self {
        let mut solver = Solver::new(beam);
        let nodes = solver.increments.len();
        let striker = Striker::new(impact, touches);
        let energy_in = 0.5 * impact.mass * impact.velocity * impact.velocity;
        solver.tolerance = 3e-5 * energy_in / (0.001 + 0.01 * impact.velocity);
        let squash = beam.section.steel.yield_strength * beam.section.area;
        solver.tolerance = solver.tolerance.min(1e-5 * squash).max(1e-11 * squash);
        Self {
            beam,
            state,
            solver,
            striker,
            normal: [libm::cos(direction), libm::sin(direction)],
            node,
            course: Course {
                energy_in,
                ..Course::default()
            },
            internal: 0.0,
            last: Past::none(nodes),
            older: Past::none(nodes),
            rings: false,
            window: [0.0; 3],
        }
    }

    /// One step, in halves where it does not converge; whether it succeeded.
    pub fn advance(&mut self, secs: f64, depth: u32) -> bool {
        let kind = Kind::Motion { secs };
        // The last movement continues. The velocity at its end would lead further away where the column rings faster than the
        // steps can follow.
        let (last, older) = (&self.last, &self.older);
        let ratio = secs / last.secs;
        let alternates = self.rings && secs == last.secs && secs == older.secs;
        let share = if alternates {
            SHARE_OF_ALTERNATION
        } else {
            0.0
        };
        let start = |last: f64, older: f64| ratio * last + share * (older - last);
        let pasts = last.nodes.iter().zip(&older.nodes);
        for (increment, (last, older)) in self.solver.increments.iter_mut().zip(pasts) {
            *increment = std::array::from_fn(|k| start(last[k], older[k]));
        }
        self.solver.shear = std::array::from_fn(|bar| start(last.shear[bar], older.shear[bar]));
        let evaluations = self.solver.evaluations;
        // What is held does not move: a node that turns about y and z would otherwise begin with a turn about x as well.
        for (increment, held) in self.solver.increments.iter_mut().zip(&self.beam.held) {
            for (value, held) in increment.iter_mut().zip(held) {
                if *held {
                    *value = 0.0;
                }
            }
        }
        self.striker.begin(secs);
        let left = ENERGY_BUDGET * self.course.energy_in - self.solver.energy_lost;
        self.solver.energy_tolerance = BUDGET_OF_A_STEP * left;
        let contact = Some((&mut self.striker, self.normal));
        if self.solver.solve(self.beam, &self.state, kind, contact) {
            self.internal += self.beam.commit(
                &mut self.state,
                self.solver.increment(),
                kind,
                &self.solver.work,
            );
            std::mem::swap(&mut self.last, &mut self.older);
            self.last.nodes.copy_from_slice(&self.solver.increments);
            self.last.shear = self.solver.shear;
            self.last.secs = secs;
            self.rings = self.solver.evaluations - evaluations > USUAL_EVALUATIONS;
            self.striker.commit(secs);
            self.course.impulse += secs * self.striker.force();
            self.course.secs += secs;
            self.record(secs);
            return true;
        }
        self.course.halvings += 1;
        depth < MAX_HALVINGS
            && self.advance(0.5 * secs, depth + 1)
            && self.advance(0.5 * secs, depth + 1)
    }

    fn record(&mut self, secs: f64) {
        let base = &self.solver.work.base;
        let [c, s] = self.normal;
        // A hit along y bends about z, one along z about -y.
        let (shear, moment) = if D == 3 {
            (base[1] * c, base[2] * c)
        } else {
            (base[1] * c + base[2] * s, base[D - 1] * c - base[D - 2] * s)
        };
        self.window[0] += secs * shear;
        self.window[1] += secs * moment;
        self.window[2] += secs;
        if self.window[2] >= WINDOW {
            let [shear, moment, time] = self.window;
            let course = &mut self.course;
            course.base_shear = course.base_shear.max((shear / time).abs());
            course.base_moment = course.base_moment.max((moment / time).abs());
            self.window = [0.0; 3];
        }
    }

    /// Displacement of the impact point along and at right angles to the direction, from `rest` \[m\].
    pub fn displacement(&self, rest: &[f64; 3]) -> [f64; 2] {
        self.between(rest, &self.state.moved[self.node])
    }

    /// The way from one place of a node to another along and at right angles to the direction \[m\].
    pub fn between(&self, from: &[f64; 3], to: &[f64; 3]) -> [f64; 2] {
        let (y, z) = (to[1] - from[1], to[2] - from[2]);
        let [c, s] = self.normal;
        [c * y + s * z, c * z - s * y]
    }

    /// Whether the column has collapsed, after a step that was solved or not, with its impact point displaced by so much along
    /// and at right angles to the direction \[m\].
    pub fn has_collapsed(&self, solved: bool, displaced: [f64; 2]) -> bool {
        let [along, across] = displaced.map(f64::abs);
        match solved {
            true => self.is_misshapen(MOVING, displaced),
            false => along.max(across) > CONFIRMED * self.length(),
        }
    }

    /// Whether the top or the impact point, displaced as for [`Run::has_collapsed`], is beyond these times the limits of the shape of
    /// a column.
    pub fn is_misshapen(&self, limit: f64, [along, across]: [f64; 2]) -> bool {
        let length = self.length();
        let descent = -self.state.moved[self.beam.places.len() - 1][0];
        along.max(across.abs()) > limit * COLLAPSED * length || descent > limit * DESCENDED * length
    }

    /// Whether an element has lost its length, as a bar of the two bars that collapses: with little hardening, a hinge under a large
    /// load shortens until nothing of it is left, and no further step has a solution.
    pub fn is_crushed(&self) -> bool {
        let elements = self.beam.elements.iter().zip(&self.state.deformation);
        elements
            .map(|(element, deformation)| 1.0 + deformation[0] / element.length)
            .any(|left| left < MIN_EXTENT)
    }

    fn length(&self) -> f64 {
        self.beam.places[self.beam.places.len() - 1][0]
    }

    /// Follows the impact until the column comes back, and shows each step to `watch`.
    pub fn follow(&mut self, secs: f64, rest: &[f64; 3], watch: &mut impl Watch) -> bool {
        let before = self.energy();
        let (mut along_now, mut sideways_now) = (0.0_f64, 0.0_f64);
        let fibres: usize = self.beam.section.fibres().iter().sum();
        let updates_at_once = (fibres * self.state.points.len()) as u64;
        let most = MAX_FIBRE_UPDATES / updates_at_once;
        let is_within = |run: &Self| run.course.steps < MAX_STEPS && run.solver.evaluations < most;
        while is_within(self) {
            self.course.steps += 1;
            let solved = self.advance(secs, 0);
            let [along, across] = self.displacement(rest);
            if !solved {
                self.course.collapsed = self.has_collapsed(false, [along, across]);
                self.course.stuck = !self.course.collapsed;
                break;
            }
            let is_peak = along > self.course.largest[0];
            if is_peak {
                self.course.largest[0] = along;
                self.course.time = self.course.secs;
            }
            watch.step(self.course.secs, &self.state, is_peak);
            if across.abs() > self.course.largest[1].abs() {
                self.course.largest[1] = across;
            }
            let along_before = std::mem::replace(&mut along_now, along);
            let falls = across.abs() < sideways_now;
            sideways_now = across.abs();
            if self.has_collapsed(true, [along, across]) {
                self.course.collapsed = true;
                break;
            }
            if along >= self.course.largest[0] || self.striker.velocity() > 0.0 {
                continue;
            }
            // A rigid vehicle lets go soon, and what the column flings back yields once more; one that crushes unloads slowly.
            let came_back = along < (1.0 - BACK) * self.course.largest[0];
            let over = if self.striker.is_deformable() {
                self.striker.is_gone() || came_back
            } else {
                self.striker.is_gone() && along > along_before
            };
            if over && (D == 3 || falls) {
                break;
            }
        }
        self.course.yielded = self.state.yielded.iter().any(|yielded| *yielded);
        self.course.evaluations = self.solver.evaluations;
        self.course.energy_error = self.energy() - before - self.striker.pushed;
        is_within(self)
    }

    /// Energy of column and vehicle with the work done on the fibres \[J\].
    fn energy(&self) -> f64 {
        let [kinetic, outside] = self.beam.energies(&self.state);
        kinetic + outside + self.internal + self.striker.energy() + self.striker.crushed
    }
}
