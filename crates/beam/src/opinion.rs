//! The second opinion: an impact on a column, computed as a beam.

use column_mechanics::{Impact, Support};
use serde::{Deserialize, Serialize};

use super::beam::{Beam, State};
use super::column::{BeamColumn, BeamError, BowAxes};
use super::contact::touches;
use super::damage::Damage;
use super::mesh::{self, nearest};
use super::movement::{Movement, Recorder, Steps, Watch};
use super::newton::Solver;
use super::outcome::{BeamOutcome, Outcome, PLASTIC_ZONE};
use super::pair::{InTurn, Pair, both};
use super::remains::{Remains, largest_distance, largest_kink};
use super::response::{Course, DESCENDED, MAX_FIBRE_UPDATES, MAX_STEPS, MOVING, Run};
use super::statics::{
    come_to_rest, let_go, load_in_steps, push_down, push_sideways, settle, settle_elastically,
};

/// Step of a response with a rigid vehicle \[ns\]: a fifth of the period of the contact. Twice as long a step needs more than
/// twice the iterations.
const RIGID_STEP: u64 = 40_000;

/// The same for a hit in space, which costs more and is compared within 3 %.
const RIGID_STEP_IN_SPACE: u64 = 50_000;

/// Step with a vehicle that crushes \[ns\]: a fiftieth of the period of a column of 4 m. Half of it moves the peak by 0.1 %.
const DEFORMABLE_STEP: u64 = 200_000;

/// Factor of the elements and of the step of the coarser run that estimates the error.
const COARSER: f64 = 2.0;

/// Share of the velocity at right angles to the plane of the web that is round-off of a direction in that plane.
const ROUND_OFF_OF_DIRECTION: f64 = 1e-9;

/// Whether a vehicle that travels in this direction \[rad\] stays in the plane of the web.
#[must_use]
pub fn is_in_plane(direction: f64) -> bool {
    libm::sin(direction).abs() < ROUND_OFF_OF_DIRECTION
}

/// A hit from a direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hit {
    /// The vehicle and its speed.
    pub impact: Impact,
    /// Direction of travel \[rad\]: 0 bends the column about its strong axis; positive turns towards positive z.
    pub direction: f64,
}

/// All that the beam computes of a hit.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamOpinion {
    /// The response, and the capacities about each axis.
    pub outcome: BeamOutcome,
    /// Largest axial force that the undamaged column bears, and the one that the impact leaves \[N\], bowed about the axes of
    /// [`BeamColumn::bow_axes`]: about both at once, or held about the other one.
    pub capacity: [f64; 2],
    /// The damage that remains; `None` after a collapse.
    pub damage: Option<Damage>,
    /// What the undamaged column bears.
    pub undamaged: Undamaged,
}

/// What an undamaged column bears, whatever hits it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undamaged {
    /// Bowed about the strong and about the weak axis \[N\].
    capacities: [f64; 2],
    /// Bowed about both at once \[N\], where the column is.
    bowed: Option<f64>,
}

/// A column prepared for hits.
#[derive(Debug, Clone)]
pub struct BeamModel {
    column: BeamColumn,
    undamaged: Option<Undamaged>,
}

/// What one run has left.
struct Passed {
    course: Course,
    before: [f64; 2],
    residual: Option<Remains>,
    elements: usize,
}

/// A column at rest under its load.
struct Standing<const D: usize, const R: usize, const Q: usize> {
    beam: Beam<D, R, Q>,
    state: State<D, R>,
    solver: Solver<D, R>,
}

/// A response that found no end, or none to begin with.
enum Stopped {
    Unstable,
    Budget,
    NotSolved { time: f64 },
}

impl BeamModel {
    /// Checks a column.
    ///
    /// # Errors
    /// Numbers out of range, or a load that the column does not bear, bowed about its axes.
    pub fn new(column: &BeamColumn) -> Result<Self, BeamError> {
        column.check()?;
        let model = Self {
            column: *column,
            undamaged: None,
        };
        if !model.stands_in_plane() {
            return Err(model.error(&Stopped::Unstable));
        }
        if !model.stands_in_space(None) {
            return Err(BeamError::WeakAxis {
                load: column.top_load,
            });
        }
        Ok(model)
    }

    /// A column whose capacities an earlier opinion has computed: the same model as by [`BeamModel::new`], without computing them
    /// again.
    #[must_use]
    pub fn known(column: &BeamColumn, undamaged: Undamaged) -> Self {
        Self {
            column: *column,
            undamaged: Some(undamaged),
        }
    }

    /// What the undamaged column bears.
    fn bears_undamaged(&self) -> Undamaged {
        let about_both = self.column.bow_axes == BowAxes::Both;
        self.undamaged.unwrap_or_else(|| Undamaged {
            capacities: self.undamaged_capacity(),
            bowed: about_both.then(|| self.capacity_bowed(self.column.bows())),
        })
    }

    /// Largest axial force that the undamaged column bears, bowed about the strong and about the weak axis \[N\].
    #[must_use]
    pub fn undamaged_capacity(&self) -> [f64; 2] {
        self.capacities(None)
    }

    /// The same with these bows along y and z at once \[m\].
    #[must_use]
    pub fn capacity_bowed(&self, bows: [f64; 2]) -> f64 {
        self.pushed::<6, 6, 9>(bows, None)
    }

    /// The same of a column that impacts have left with this damage, bowed towards the side to which it is bent \[N\].
    #[must_use]
    pub fn capacity_left(&self, bows: [f64; 2], damage: &Damage) -> f64 {
        self.pushed::<6, 6, 9>(sided(bows, damage), Some(damage))
    }

    /// The largest static force with which the column resists at the edges of the bumper, or at the impact point, while it is
    /// pushed by `way` \[m\] in the plane of its web \[N\]; `None` where there is no equilibrium.
    #[must_use]
    pub fn lateral_resistance(&self, way: f64) -> Option<f64> {
        let column = &self.column;
        let heights = column.heights(column.elements, mesh::FINE);
        let beam: Beam<3, 3, 4> = column.beam(&heights, column.bows());
        let mut state = beam.undamaged();
        let mut solver = Solver::new(&beam);
        if !settle(&beam, &mut state, &mut solver) {
            return None;
        }
        let half = 0.5 * column.bumper_height;
        let low = nearest(&heights, column.length_below - half);
        let high = nearest(&heights, column.length_below + half);
        let nodes = [low, high];
        push_sideways(
            &beam,
            &state,
            &nodes[..1 + usize::from(low != high)],
            way,
            &mut solver,
        )
    }

    /// Computes a hit on a column that may be damaged; returns what the beam says and the damage then.
    ///
    /// # Errors
    /// As [`BeamModel::opinion`].
    pub fn simulate(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
    ) -> Result<(BeamOutcome, Option<Damage>), BeamError> {
        let opinion = self.opinion(hit, damage, &InTurn)?;
        Ok((opinion.outcome, opinion.damage))
    }

    /// Computes a hit on a column that may be damaged, and what the column bears before and after it. `pair` decides which parts of
    /// the computation run at once; the result is the same.
    ///
    /// # Errors
    /// A direction or an impact out of range, no equilibrium before it, damage of another mesh, no end within the budget.
    pub fn opinion(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        pair: &dyn Pair,
    ) -> Result<BeamOpinion, BeamError> {
        let respond = || Ok((self.respond_to(hit, damage, &mut ())?, ()));
        Ok(self.opinion_on(hit, damage, pair, respond)?.0)
    }

    /// The same opinion to the last bit, with how the column moves, for drawings.
    ///
    /// # Errors
    /// As [`BeamModel::opinion`].
    pub fn opinion_and_movement(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        pair: &dyn Pair,
    ) -> Result<(BeamOpinion, Movement), BeamError> {
        self.opinion_on(hit, damage, pair, || self.follow(hit, damage))
    }

    /// The opinion on a response that `respond` computes, and what else this has seen.
    fn opinion_on<T: Send>(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        pair: &dyn Pair,
        respond: impl FnOnce() -> Result<(Passed, T), BeamError> + Send,
    ) -> Result<(BeamOpinion, T), BeamError> {
        self.check_hit(hit, damage)?;
        let (column, bows) = (&self.column, self.column.bows());
        let step = self.step(hit, Self::is_plane(hit, damage));
        let about_both = column.bow_axes == BowAxes::Both;
        let (responded, (known, coarser)) = both(pair, respond, || {
            let coarser = self.coarser_peak(hit, damage, step);
            (self.bears_undamaged(), coarser)
        });
        let Undamaged {
            capacities: undamaged,
            bowed,
        } = known;
        let (passed, seen) = responded?;
        let Passed {
            course,
            before,
            residual,
            elements,
        } = passed;
        let error_estimate = match (coarser, course.largest[0]) {
            // The error falls with the square of the length of an element.
            (Some(other), fine) if !course.collapsed => {
                ((other - fine) / fine).abs() / (COARSER * COARSER - 1.0)
            }
            _ => f64::NAN,
        };
        let damage_after = residual.as_ref().map(|it| &it.damage);
        let (left, (stands, bowed_left)) = both(
            pair,
            || match damage_after {
                Some(after) if course.yielded => self.capacities(Some(after)),
                Some(_) => undamaged,
                None => [0.0; 2],
            },
            || match damage_after {
                Some(after) if course.yielded => {
                    // A hit in the plane of the web says nothing of the weak axis.
                    if about_both {
                        let left =
                            self.pushed_if_standing::<6, 6, 9>(sided(bows, after), Some(after));
                        (left.is_some(), left)
                    } else {
                        (self.stands_in_space(Some(after)), None)
                    }
                }
                _ => (true, bowed),
            },
        );
        let residual = residual.filter(|_| stands);
        let left = if residual.is_some() { left } else { [0.0; 2] };
        let capacity = match column.bow_axes {
            BowAxes::Strong => [undamaged[0], left[0]],
            BowAxes::Weak => [undamaged[1], left[1]],
            BowAxes::Both => {
                [bowed, bowed_left.filter(|_| residual.is_some())].map(|force| force.unwrap_or(0.0))
            }
        };
        let nothing = [f64::NAN; 2];
        let (remains, bow, kink, shear, beyond, damage) = match residual {
            Some(it) => (
                it.displacement,
                it.bow,
                it.kink,
                it.shear,
                it.yielded_beyond_residual_stress,
                Some(it.damage),
            ),
            None => (nothing, nothing, f64::NAN, nothing, true, None),
        };
        let outcome = BeamOutcome {
            max_displacement_m: course.largest[0],
            max_sideways_m: course.largest[1].abs(),
            residual_displacement_m: remains[0],
            residual_sideways_m: remains[1].abs(),
            displaced_before_m: before,
            residual_bow_m: bow[0],
            residual_bow_height_m: bow[1],
            residual_kink_rad: kink,
            residual_shear_angle_rad: shear,
            max_displacement_time_s: course.time,
            outcome: match (damage.is_none(), course.yielded) {
                (true, _) => Outcome::Collapse,
                (false, true) => Outcome::Plastic,
                (false, false) => Outcome::Elastic,
            },
            yielded_beyond_residual_stress: beyond,
            undamaged_capacity_n: undamaged,
            residual_capacity_n: left,
            base_shear_n: course.base_shear,
            base_moment_n_m: course.base_moment,
            error_estimate,
            elements,
            steps: course.steps,
            evaluations: course.evaluations,
            energy_error: course.energy_error / course.energy_in,
        };
        let opinion = BeamOpinion {
            outcome,
            capacity,
            damage,
            undamaged: known,
        };
        Ok((opinion, seen))
    }

    /// The peak displacement by a run with fewer elements and longer steps \[m\]; `None` where it has no end.
    fn coarser_peak(&self, hit: &Hit, damage: Option<&Damage>, step: f64) -> Option<f64> {
        let heights = self.heights(hit, self.column.elements, Self::is_plane(hit, damage));
        let elements = (((heights.len() - 1) as f64 / COARSER) as usize).max(4);
        let coarser = self.pass(hit, damage, elements, COARSER * step, &mut ());
        coarser.ok().map(|coarser| coarser.course.largest[0])
    }

    /// How the column moves during a hit that [`BeamModel::simulate`] computes, without the error estimate and the push-downs: for
    /// drawings.
    ///
    /// # Errors
    /// As [`BeamModel::simulate`].
    pub fn movement(&self, hit: &Hit, damage: Option<&Damage>) -> Result<Movement, BeamError> {
        self.check_hit(hit, damage)?;
        Ok(self.follow(hit, damage)?.1)
    }

    /// The response, with how the column moves.
    fn follow(&self, hit: &Hit, damage: Option<&Damage>) -> Result<(Passed, Movement), BeamError> {
        let mut recorder = Recorder::new();
        let passed = self.respond_to(hit, damage, &mut recorder)?;
        let plane = Self::is_plane(hit, damage);
        let heights = self.heights(hit, self.column.elements, plane);
        Ok((passed, recorder.finish(hit.direction, &heights)))
    }

    /// The response, shown to `watch`.
    fn respond_to(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        watch: &mut impl Watch,
    ) -> Result<Passed, BeamError> {
        let step = self.step(hit, Self::is_plane(hit, damage));
        let passed = self.pass(hit, damage, self.column.elements, step, watch);
        passed.map_err(|stopped| self.error(&stopped))
    }

    /// The response alone, without the error estimate and the push-downs: peak and residual displacement along the hit \[m\], NaN
    /// for the residual one after a collapse, and the time of the peak \[s\].
    ///
    /// # Errors
    /// As [`BeamModel::simulate`].
    pub fn respond(&self, hit: &Hit) -> Result<[f64; 3], BeamError> {
        self.respond_in_steps(hit, |_| {})
    }

    /// The same. `step` is called after each step of time and receives whether the impact point is further along the hit than
    /// before: for benchmarks, which read a clock.
    ///
    /// # Errors
    /// As [`BeamModel::simulate`].
    pub fn respond_in_steps(
        &self,
        hit: &Hit,
        step: impl FnMut(bool),
    ) -> Result<[f64; 3], BeamError> {
        let passed = self.respond_to(hit, None, &mut Steps(step))?;
        let residual = passed.residual.map_or(f64::NAN, |it| it.displacement[0]);
        Ok([passed.course.largest[0], residual, passed.course.time])
    }

    /// Whether a hit and the damage before it are in range.
    pub(crate) fn check_hit(&self, hit: &Hit, damage: Option<&Damage>) -> Result<(), BeamError> {
        hit.impact.check()?;
        let pi = std::f64::consts::PI;
        if !(hit.direction > -pi && hit.direction <= pi) {
            return Err(BeamError::Direction {
                found: hit.direction,
            });
        }
        damage.map_or(Ok(()), |damage| self.check_damage(damage))
    }

    fn error(&self, stopped: &Stopped) -> BeamError {
        match stopped {
            Stopped::Unstable => BeamError::Unstable {
                load: self.column.top_load,
            },
            Stopped::NotSolved { time } => BeamError::NotSolved { time: *time },
            Stopped::Budget => BeamError::Budget {
                steps: MAX_STEPS,
                updates: MAX_FIBRE_UPDATES as f64,
            },
        }
    }

    pub(crate) fn step(&self, hit: &Hit, plane: bool) -> f64 {
        let nanos = match (self.column.step_nanos, hit.impact.vehicle) {
            (0, Some(_)) => DEFORMABLE_STEP,
            (0, None) if plane => RIGID_STEP,
            (0, None) => RIGID_STEP_IN_SPACE,
            (given, _) => given,
        };
        nanos as f64 * 1e-9
    }

    pub(crate) fn heights(&self, hit: &Hit, elements: usize, plane: bool) -> Vec<f64> {
        let density = match (plane, hit.impact.vehicle) {
            (false, _) => mesh::COARSEST,
            (true, None) => mesh::COARSE,
            (true, Some(_)) => mesh::FINE,
        };
        self.column.heights(elements, density)
    }

    pub(crate) fn is_plane(hit: &Hit, damage: Option<&Damage>) -> bool {
        is_in_plane(hit.direction) && damage.is_none_or(Damage::is_plane)
    }

    fn pass(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        elements: usize,
        secs: f64,
        watch: &mut impl Watch,
    ) -> Result<Passed, Stopped> {
        if Self::is_plane(hit, damage) {
            self.pass_in::<3, 3, 4, _>(hit, damage, elements, secs, watch)
        } else {
            self.pass_in::<6, 6, 9, _>(hit, damage, elements, secs, watch)
        }
    }

    fn pass_in<const D: usize, const R: usize, const Q: usize, W: Watch>(
        &self,
        hit: &Hit,
        damage: Option<&Damage>,
        elements: usize,
        secs: f64,
        watch: &mut W,
    ) -> Result<Passed, Stopped> {
        let column = &self.column;
        let heights = self.heights(hit, elements, D == 3);
        let beam: Beam<D, R, Q> = column.beam(&heights, column.bows());
        let mut solver = Solver::new(&beam);
        let Some(mut state) = self.state(&beam, damage, &mut solver) else {
            return Err(Stopped::Unstable);
        };
        if !settle(&beam, &mut state, &mut solver) || solver.negative_pivots > 0 {
            return Err(Stopped::Unstable);
        }
        let node = nearest(&heights, column.length_below);
        let touches = touches(column, &heights);
        let undamaged = match damage {
            None => state.clone(),
            Some(_) => {
                let mut new = beam.undamaged();
                if !settle(&beam, &mut new, &mut solver) {
                    return Err(Stopped::Unstable);
                }
                new
            }
        };
        let rest = state.moved[node];
        watch.begin(&undamaged.moved, &state.moved, node);
        let mut run = Run::new(&beam, state, &hit.impact, hit.direction, &touches, node);
        if !run.follow(secs, &rest, watch) {
            return Err(Stopped::Budget);
        }
        if run.course.stuck {
            return Err(Stopped::NotSolved {
                time: run.course.secs,
            });
        }
        // Both are at rest: what lies between is what earlier impacts have left.
        let before = run.between(&undamaged.moved[node], &rest);
        let mut residual = None;
        if !run.course.collapsed {
            let lowest = MOVING * self.lowest();
            let rests = come_to_rest(&beam, &mut run.state, &mut run.solver, lowest);
            if rests && !run.is_misshapen(1.0, run.displacement(&rest)) {
                let last = match column.top {
                    Support::Free => node,
                    _ => heights.len() - 1,
                };
                residual = Some(Remains {
                    displacement: run.displacement(&rest),
                    bow: largest_distance(&run.state.moved, &undamaged.moved, &heights[..=last]),
                    kink: largest_kink(
                        &run.state.triads,
                        &undamaged.triads,
                        &heights,
                        PLASTIC_ZONE * column.depth(),
                    ),
                    shear: std::array::from_fn(|bar| {
                        (run.state.shear[bar] - undamaged.shear[bar]).abs()
                    }),
                    yielded_beyond_residual_stress: (run.state.points.iter())
                        .any(|point| beam.section.has_yielded_beyond_residual_stress(point)),
                    damage: Damage::of(&beam, &run.state),
                });
            }
        }
        watch.end(&beam, &run.state, residual.is_some());
        Ok(Passed {
            course: run.course,
            before,
            residual,
            elements: heights.len() - 1,
        })
    }

    pub(crate) fn state<const D: usize, const R: usize, const Q: usize>(
        &self,
        beam: &Beam<D, R, Q>,
        damage: Option<&Damage>,
        solver: &mut Solver<D, R>,
    ) -> Option<State<D, R>> {
        let mut state = beam.undamaged();
        if let Some(damage) = damage {
            let plane = (damage.is_plane() && D == 6).then(|| self.column.section(true));
            let same = damage.apply(beam, &mut state, plane.as_ref());
            if !same && !settle_elastically(beam, &mut state, solver) {
                return None;
            }
        }
        Some(state)
    }

    /// How far the top of a column at rest may have come down \[m\].
    pub(crate) fn lowest(&self) -> f64 {
        DESCENDED * self.column.length()
    }

    pub(crate) fn column(&self) -> &BeamColumn {
        &self.column
    }

    /// Whether damage can be that of this column.
    pub(crate) fn check_damage(&self, damage: &Damage) -> Result<(), BeamError> {
        let expected: [usize; 2] = self.column.section(damage.is_plane()).fibres();
        let found = damage.fibres();
        if found != expected {
            return Err(BeamError::Damage {
                found: found.iter().sum(),
                expected: expected.iter().sum(),
            });
        }
        let heights = damage.heights();
        let (found, expected) = (heights[heights.len() - 1], self.column.length());
        if (found - expected).abs() > 1e-9 * expected {
            return Err(BeamError::DamageLength { found, expected });
        }
        Ok(())
    }

    /// Whether the undamaged column bears its load when it can bend in the plane of its web alone.
    fn stands_in_plane(&self) -> bool {
        self.standing::<3, 3, 4>(self.column.bows(), None).is_some()
    }

    /// Whether the column bears its load when it can bend about both axes, bowed towards the side to which it is bent. One that is
    /// bowed about its strong axis alone is held about the other one.
    pub(crate) fn stands_in_space(&self, damage: Option<&Damage>) -> bool {
        let is_held = self.column.bow_axes == BowAxes::Strong;
        if is_held && damage.is_none_or(Damage::is_plane) {
            return true;
        }
        let sides = damage.map_or([1.0; 2], Damage::sides);
        let [y, z] = self.column.bows();
        let bows = [sides[0] * y, sides[1] * z];
        self.standing::<6, 6, 9>(bows, damage).is_some()
    }

    /// The column at rest under its load with these bows along y and z \[m\]; `None` where it gives way.
    fn standing<const D: usize, const R: usize, const Q: usize>(
        &self,
        bows: [f64; 2],
        damage: Option<&Damage>,
    ) -> Option<Standing<D, R, Q>> {
        let heights = match damage {
            Some(damage) => damage.heights().to_vec(),
            None => {
                let density = if D == 3 { mesh::FINE } else { mesh::COARSEST };
                self.column.heights(self.column.elements, density)
            }
        };
        let mut beam: Beam<D, R, Q> = self.column.beam(&heights, bows);
        let mut solver = Solver::new(&beam);
        let mut state = self.state(&beam, damage, &mut solver)?;
        let mut stands = settle(&beam, &mut state, &mut solver) && solver.negative_pivots == 0;
        if !stands {
            // Near its capacity the column moves far sideways, whither the damage does not lead.
            state = self.state(&beam, damage, &mut solver)?;
            stands = load_in_steps(&mut beam, &mut state, &mut solver);
        }
        if !stands && damage.is_some() {
            // The other bow, or the other load, may have moved the equilibrium too far away.
            state = self.state(&beam, damage, &mut solver)?;
            stands = let_go(&beam, &mut state, &mut solver, self.lowest());
        }
        stands.then_some(Standing {
            beam,
            state,
            solver,
        })
    }

    /// Push-downs bowed about the strong and about the weak axis, towards the side to which the column is bent.
    fn capacities(&self, damage: Option<&Damage>) -> [f64; 2] {
        let sides = damage.map_or([1.0; 2], Damage::sides);
        let [y, z] = self.column.bows();
        let (y, z) = (sides[0] * y, sides[1] * z);
        let strong = if damage.is_none_or(Damage::is_plane) {
            self.pushed::<3, 3, 4>([y, 0.0], damage)
        } else {
            self.pushed::<6, 6, 9>([y, 0.0], damage)
        };
        [strong, self.pushed::<6, 6, 9>([0.0, z], damage)]
    }

    /// The largest axial force with these bows; 0 where the column does not bear its load.
    fn pushed<const D: usize, const R: usize, const Q: usize>(
        &self,
        bows: [f64; 2],
        damage: Option<&Damage>,
    ) -> f64 {
        self.pushed_if_standing::<D, R, Q>(bows, damage)
            .unwrap_or(0.0)
    }

    /// The same; `None` where the column does not bear its load.
    pub(crate) fn pushed_if_standing<const D: usize, const R: usize, const Q: usize>(
        &self,
        bows: [f64; 2],
        damage: Option<&Damage>,
    ) -> Option<f64> {
        let Standing {
            beam,
            state,
            mut solver,
        } = self.standing::<D, R, Q>(bows, damage)?;
        let top = state.moved.len() - 1;
        let borne = beam.top_load + beam.top_spring * state.moved[top][0];
        let most = push_down(&beam, state, &mut solver);
        Some(most.unwrap_or(0.0).max(borne))
    }
}

/// Bows towards the side to which damage has bent the column.
pub(crate) fn sided(bows: [f64; 2], damage: &Damage) -> [f64; 2] {
    let [y, z] = damage.sides();
    [y * bows[0], z * bows[1]]
}
