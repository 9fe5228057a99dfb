//! The motion of a deformable vehicle: a chain of masses over one part of a step.
//!
//! With a given increment of `v1`, the midpoint rule for the masses and the mean forces of the springs determine the
//! increments of the masses. They are condensed inside each evaluation of the column's equations, which see the mean
//! contact force alone. Unknown are the deviations from free flight, not positions.

use serde::{Deserialize, Serialize};

use super::crush::{MeanForce, SpringState, Stretch};
use super::vehicle::{MAX_MASSES, Vehicle};

/// Bound of the iterations for the chain; two are usual.
const MAX_ITERATIONS: u32 = 40;

/// Bound of the halvings of a correction that does not lower the residual.
const MAX_SHORTENINGS: u32 = 8;

/// Relative residual at which the iteration ends: round-off.
const BALANCED: f64 = 2e-15;

/// Relative residual that is accepted once a correction no longer halves it.
const STAGNATED: f64 = 1e-12;

/// State of a deformable vehicle; arrays over its masses and the springs in front of them, front first.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Chain {
    /// State of each spring.
    pub springs: [SpringState; MAX_MASSES],
    /// Velocity of each mass \[m/s\].
    pub velocity: [f64; MAX_MASSES],
}

impl Chain {
    /// A new vehicle that moves with `velocity` \[m/s\] at a `gap` from the column \[m\].
    pub fn new(vehicle: &Vehicle, velocity: f64, gap: f64) -> Self {
        let mut chain = Self::default();
        for (index, spring) in vehicle.springs().iter().enumerate() {
            let open_by = if index == 0 { gap } else { spring.slack };
            chain.springs[index] = SpringState::open_by(open_by);
            chain.velocity[index] = velocity;
        }
        chain
    }

    /// Shortens the gap in front of a vehicle that has not touched yet to `gap` \[m\].
    pub(crate) fn come_near(&mut self, gap: f64) {
        self.springs[0] = SpringState::open_by(gap);
    }

    /// How far the centre of mass has come nearer to the column since all springs were uncrushed, less the gap then \[m\].
    pub(crate) fn mean_crush(&self, vehicle: &Vehicle) -> f64 {
        let (mut moment, mut crush) = (0.0, 0.0);
        for (mass, spring) in vehicle.masses().iter().zip(&self.springs) {
            crush += spring.crush;
            moment += mass * crush;
        }
        moment / vehicle.total_mass()
    }

    /// Force between vehicle and column \[N\], >= 0.
    pub fn contact_force(&self, vehicle: &Vehicle) -> f64 {
        self.springs[0].force(&vehicle.springs()[0])
    }

    /// Distance between the contact face and the column \[m\], >= 0.
    pub(crate) fn gap(&self) -> f64 {
        let front = &self.springs[0];
        (front.permanent - front.crush).max(0.0)
    }

    /// Velocity of the centre of mass \[m/s\].
    pub fn mean_velocity(&self, vehicle: &Vehicle) -> f64 {
        let momentum: f64 = self
            .velocity
            .iter()
            .zip(vehicle.masses())
            .map(|(v, m)| m * v)
            .sum();
        momentum / vehicle.total_mass()
    }

    /// Kinetic energy of all masses \[J\].
    pub fn kinetic_energy(&self, vehicle: &Vehicle) -> f64 {
        let terms = self.velocity.iter().zip(vehicle.masses());
        terms.map(|(v, m)| 0.5 * m * v * v).sum()
    }

    /// Elastic energy of all springs \[J\].
    pub fn elastic_energy(&self, vehicle: &Vehicle) -> f64 {
        let terms = self.springs.iter().zip(vehicle.springs());
        terms
            .map(|(state, spring)| state.elastic_energy(spring))
            .sum()
    }

    /// Gives the masses the impulses of the spring forces over `secs` \[s\].
    pub(crate) fn kick(&mut self, vehicle: &Vehicle, secs: f64) {
        let mut behind = 0.0;
        let links = vehicle.masses().iter().zip(vehicle.springs()).enumerate();
        for (index, (mass, spring)) in links.rev() {
            let own = self.springs[index].force(spring);
            self.velocity[index] += secs * (behind - own) / mass;
            behind = own;
        }
    }

    /// Moves the masses with their velocities over `secs` \[s\], while the column moves by `v1_increment` \[m\].
    pub(crate) fn drift(&mut self, vehicle: &Vehicle, secs: f64, v1_increment: f64) {
        let mut before = v1_increment;
        for (index, spring) in vehicle.springs().iter().enumerate() {
            let moved = secs * self.velocity[index];
            (self.springs[index], _) = self.springs[index].crushed_by(spring, moved - before);
            before = moved;
        }
    }

    /// Moves the vehicle, on which a force acts that alone would give it `acceleration` \[m/s²\], to the end of a part of a step
    /// of `secs` seconds that has been solved.
    pub fn follow(
        &mut self,
        vehicle: &Vehicle,
        acceleration: f64,
        secs: f64,
        point: &ChainPoint,
    ) -> Crushed {
        let start = self.springs[0];
        let mut crushed = Crushed {
            impulse: secs * point.force(),
            ..Crushed::default()
        };
        let links = vehicle.masses().iter().zip(vehicle.springs());
        for (index, (mass, spring)) in links.enumerate() {
            (self.springs[index], crushed.dissipated[index]) =
                self.springs[index].crushed_by(spring, point.increment[index]);
            let behind = point.mean.get(index + 1).map_or(0.0, |mean| mean.force);
            self.velocity[index] += secs * (behind - point.mean[index].force) / mass;
            self.velocity[index] += secs * acceleration;
        }
        let end = &self.springs[0];
        // The crush grows or shrinks evenly over the part.
        let passes = |at: f64| ((at - start.crush) / (end.crush - start.crush)).clamp(0.0, 1.0);
        if start.largest == 0.0 && end.largest > 0.0 {
            crushed.touched = Some(passes(0.0));
        }
        if !start.is_open() && end.is_open() {
            crushed.released = Some(passes(end.permanent));
        }
        crushed
    }

    /// All its numbers, for a digest.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        let springs = self.springs.into_iter();
        springs
            .flat_map(|spring| [spring.crush, spring.largest])
            .chain(self.velocity)
    }

    /// Whether a vehicle out of contact can never touch a column at rest again: its front recedes, and either no spring
    /// will ever act again, or all the energy that its masses have relative to each other does not suffice to turn the
    /// front round.
    pub fn recedes_for_good(&self, vehicle: &Vehicle) -> bool {
        let count = vehicle.masses().len();
        let velocity = &self.velocity[..count];
        let springs = &self.springs[..count];
        if !springs[0].is_open() || velocity[0] > 0.0 {
            return false;
        }
        let separates = velocity.windows(2).all(|pair| pair[0] >= pair[1]);
        if separates && springs.iter().all(SpringState::is_open) {
            return true;
        }
        // The front is fastest when it has all of that energy and the other masses move as one.
        let (total, front) = (vehicle.total_mass(), vehicle.masses()[0]);
        let mean = self.mean_velocity(vehicle);
        let relative: f64 = velocity
            .iter()
            .zip(vehicle.masses())
            .map(|(v, m)| 0.5 * m * (v - mean) * (v - mean))
            .sum();
        let internal = relative + self.elastic_energy(vehicle);
        mean < 0.0 && 2.0 * internal * (total - front) <= mean * mean * front * total
    }
}

/// A vehicle over one part of a step.
#[derive(Debug, Clone, Copy)]
pub struct ChainPart<'a> {
    count: usize,
    springs: [Stretch<'a>; MAX_MASSES],
    /// `2 M / h^2` of each mass \[N/m\].
    inertia: [f64; MAX_MASSES],
    /// Increment of each crush in free flight \[m\], for the first spring against a column at rest.
    free: [f64; MAX_MASSES],
    secs: f64,
}

/// A solution for one increment of `v1`.
#[derive(Debug, Clone, Copy, Default)]
pub struct ChainPoint {
    /// By how much each mass deviates from its free flight \[m\], once there is a solution.
    deviation: [f64; MAX_MASSES],
    is_solved: bool,
    /// Increment of `v1` of that solution \[m\].
    v1_increment: f64,
    /// The elimination with the last slopes.
    elimination: Option<Elimination>,
    /// Mean force of each spring.
    mean: [MeanForce; MAX_MASSES],
    /// Increment of each crush \[m\].
    increment: [f64; MAX_MASSES],
}

/// The elimination of the masses from the rear to the front.
#[derive(Debug, Clone, Copy)]
struct Elimination {
    /// Slopes of the springs \[N/m\].
    slopes: [f64; MAX_MASSES],
    /// What resists each mass if all behind it follows \[N/m\].
    pivots: [f64; MAX_MASSES],
    /// The slopes relative to them: by which share of the motion in front of its spring a mass follows.
    shares: [f64; MAX_MASSES],
}

impl ChainPoint {
    /// Mean contact force \[N\].
    pub fn force(&self) -> f64 {
        self.mean[0].force
    }

    /// Minus its derivative by the increment of `v1` \[N/m\]: the front spring and the chain behind it in series.
    pub fn stiffness(&self) -> f64 {
        self.elimination.map_or(0.0, |elimination| {
            let (pivot, front) = (elimination.pivots[0], self.mean[0].slope);
            front * (pivot - front) / pivot
        })
    }
}

/// What a vehicle has done in a part of a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Crushed {
    /// Impulse on the column \[N s\].
    pub impulse: f64,
    /// Energy dissipated in each spring \[J\].
    pub dissipated: [f64; MAX_MASSES],
    /// Share of the part after which the front touches for the first time, if it does so in this part.
    pub touched: Option<f64>,
    /// Share of the part after which the contact force falls to zero, if it does so in this part.
    pub released: Option<f64>,
}

/// The residual of the chain's equations \[N\] and its size relative to the forces.
#[derive(Clone, Copy)]
struct Residual {
    values: [f64; MAX_MASSES],
    size: f64,
}

impl<'a> ChainPart<'a> {
    /// A part of `secs` \[s\] that begins with the chain `from`; `acceleration` \[m/s²\] is that of the free flight.
    pub fn new(vehicle: &'a Vehicle, from: &Chain, acceleration: f64, secs: f64) -> Self {
        let springs = vehicle.springs();
        let mut part = Self {
            count: springs.len(),
            // Those behind the last are never used.
            springs: [Stretch::new(&springs[0], from.springs[0]); MAX_MASSES],
            inertia: [0.0; MAX_MASSES],
            free: [0.0; MAX_MASSES],
            secs,
        };
        for (index, spring) in springs.iter().enumerate().skip(1) {
            part.springs[index] = Stretch::new(spring, from.springs[index]);
        }
        let per_square = 2.0 / (secs * secs);
        let mut before = 0.0;
        for (index, &mass) in vehicle.masses().iter().enumerate() {
            part.inertia[index] = mass * per_square;
            part.free[index] = secs * (from.velocity[index] - before);
            before = from.velocity[index];
        }
        // All masses gain the same velocity, so that only the distance to the column changes.
        part.free[0] += 0.5 * acceleration * secs * secs;
        part
    }

    /// Size of the contact force \[N\] in this part, against a column that moves at `v1_rate` \[m/s\].
    pub(crate) fn force_scale(&self, v1_rate: f64) -> f64 {
        let front = &self.springs[0];
        let free = self.free[0] - self.secs * v1_rate;
        front.force_at_start() + 0.5 * front.stiffness() * free.abs()
    }

    /// Finds the mean contact force for an increment of `v1` \[m\]; NaN where the equations do not converge, so that the
    /// part is rejected and halved, which makes the inertia dominate.
    pub fn solve(&self, v1_increment: f64, point: &mut ChainPoint) {
        // Loops of a known length, measured: a step with three masses takes 5 % less.
        match self.count {
            1 => self.solve_masses::<1>(v1_increment, point),
            2 => self.solve_masses::<2>(v1_increment, point),
            _ => self.solve_masses::<MAX_MASSES>(v1_increment, point),
        }
    }

    fn solve_masses<const COUNT: usize>(&self, v1_increment: f64, point: &mut ChainPoint) {
        match &point.elimination {
            Some(elimination) if point.is_solved => {
                // Exact as long as no spring leaves its straight piece.
                let mut moved = v1_increment - point.v1_increment;
                for index in 0..COUNT {
                    moved *= elimination.shares[index];
                    point.deviation[index] += moved;
                }
            }
            _ => self.guess::<COUNT>(v1_increment, point),
        }
        let mut residual = self.evaluate::<COUNT>(v1_increment, point);
        for _ in 0..MAX_ITERATIONS {
            if residual.size <= BALANCED {
                break;
            }
            let Some(correction) = self.correction::<COUNT>(residual.values, point) else {
                break;
            };
            let from = point.deviation;
            let enough = residual.size;
            let mut share = 1.0;
            for _ in 0..MAX_SHORTENINGS {
                for index in 0..COUNT {
                    point.deviation[index] = from[index] - share * correction[index];
                }
                residual = self.evaluate::<COUNT>(v1_increment, point);
                if residual.size < enough || residual.size <= STAGNATED {
                    break;
                }
                share *= 0.5;
            }
            if residual.size.is_nan() || residual.size >= enough {
                // Round-off, or no progress.
                break;
            }
        }
        let front_pivot = self.eliminate::<COUNT>(point).pivots[0];
        point.v1_increment = v1_increment;
        point.is_solved = residual.size <= STAGNATED && front_pivot > 0.0;
        if !point.is_solved {
            point.mean[0].force = f64::NAN;
        }
    }

    /// The solution if every spring stays on the straight piece on which it starts.
    fn guess<const COUNT: usize>(&self, v1_increment: f64, point: &mut ChainPoint) {
        let (mut unbalanced, mut behind) = ([0.0; MAX_MASSES], 0.0);
        for index in (0..COUNT).rev() {
            let free = self.free[index] - if index == 0 { v1_increment } else { 0.0 };
            let mean = self.springs[index].tangent(free);
            unbalanced[index] = mean.force - behind;
            behind = mean.force;
            point.mean[index] = mean;
        }
        let correction = self
            .correction::<COUNT>(unbalanced, point)
            .unwrap_or_default();
        point.deviation = correction.map(|correction| -correction);
    }

    /// `2 M w / h^2 + F_i - F_(i + 1)` for the deviations `w` from free flight.
    fn evaluate<const COUNT: usize>(&self, v1_increment: f64, point: &mut ChainPoint) -> Residual {
        let deviation = point.deviation;
        let mut before = v1_increment;
        for index in 0..COUNT {
            let increment = if index == 0 {
                (self.free[0] - before) + deviation[0]
            } else {
                self.free[index] + (deviation[index] - before)
            };
            point.increment[index] = increment;
            point.mean[index] = self.springs[index].mean_force(increment);
            before = deviation[index];
        }
        let mut values = [0.0; MAX_MASSES];
        let (mut unbalanced, mut terms, mut behind) = (0.0, 0.0, 0.0);
        for index in (0..COUNT).rev() {
            let own = point.mean[index].force;
            let inertia = self.inertia[index] * deviation[index];
            values[index] = inertia + own - behind;
            unbalanced += values[index].abs();
            terms += inertia.abs() + own + behind;
            behind = own;
        }
        let size = if unbalanced == 0.0 {
            0.0
        } else {
            unbalanced / terms
        };
        Residual { values, size }
    }

    /// The elimination with the slopes of the last evaluation, which are mostly those of the one before.
    fn eliminate<'p, const COUNT: usize>(&self, point: &'p mut ChainPoint) -> &'p Elimination {
        let slopes = point.mean.map(|mean| mean.slope);
        let known = point.elimination.filter(|known| known.slopes == slopes);
        point.elimination.insert(known.unwrap_or_else(|| {
            let (mut pivots, mut shares) = ([0.0; MAX_MASSES], [0.0; MAX_MASSES]);
            let mut behind = 0.0;
            for index in (0..COUNT).rev() {
                let own = slopes[index];
                let rest = self.inertia[index] + behind;
                pivots[index] = rest + own;
                behind = own * rest / pivots[index];
                shares[index] = own / pivots[index];
            }
            Elimination {
                slopes,
                pivots,
                shares,
            }
        }))
    }

    /// The correction that Newton's method subtracts; `None` where the chain has lost its stiffness.
    fn correction<const COUNT: usize>(
        &self,
        residual: [f64; MAX_MASSES],
        point: &mut ChainPoint,
    ) -> Option<[f64; MAX_MASSES]> {
        let Elimination {
            slopes,
            pivots,
            shares,
        } = self.eliminate::<COUNT>(point);
        if !pivots[..COUNT].iter().all(|&pivot| pivot > 0.0) {
            return None;
        }
        let mut right = residual;
        for index in (1..COUNT).rev() {
            right[index - 1] += shares[index] * right[index];
        }
        let mut correction = [0.0; MAX_MASSES];
        let mut before = 0.0;
        for index in 0..COUNT {
            let coupled = if index == 0 {
                0.0
            } else {
                slopes[index] * before
            };
            correction[index] = (right[index] + coupled) / pivots[index];
            before = correction[index];
        }
        Some(correction)
    }
}
