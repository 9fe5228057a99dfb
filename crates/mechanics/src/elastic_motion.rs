//! The elastic motion of a column in long explicit steps, for studies: between two plastic flows, before a deformable vehicle
//! or without contact.
//!
//! The scheme is Störmer's, `U_{n+1} - 2 U_n + U_{n-1} = h^2 M*^{-1} f_n`, with one evaluation of the forces per step and
//! no iteration but that of a massless top. A free vibration of circular frequency `omega` has in it the frequency
//! `2/h asin(omega* h/2)`; the mass `M* = M (x / sin x)^2` with `x = omega h/2` makes that `omega` again, so that the phase
//! is right after any number of periods, whatever the step. Slow motions are hardly affected.
//!
//! It begins from and ends in a displacement with its true velocity: `U_1 = U_0 + h V_0 + h^2 (2 A_0 + A_1)/6` and
//! `V_n = (U_n - U_{n-1})/h + h (2 A_n + A_{n-1})/6`, with the true accelerations `A`, both of third order.

use nalgebra::Vector3;

use super::backbone::HingeFactors;
use super::bar::{BarForces, PerBar};
use super::base_reactions::base_forces;
use super::chain::Chain;
use super::frame;
use super::geometry::Displacement;
use super::model::Model;
use super::motion::collapse_of;
use super::rate::{Collocation, HingeStrength};
use super::sample::BaseForces;
use super::shear::SliderStrength;
use super::state::{State, Velocity};
use super::statics::{self, Settled};
use super::vehicle::Vehicle;
use super::web_strength::WebState;

/// Steps per period of the transverse vibration. The kinks of a vehicle's crush curve limit them: the peak `v1` is within
/// 8e-4 of that of the plain response on the maps of the tests.
const STEPS_PER_PERIOD: f64 = 31.0;

/// The same where the strength of the hinges depends on the strain rate: it decides how far a column yields that does so barely.
const STEPS_PER_PERIOD_WITH_RATE: f64 = 36.0;

/// Longest step relative to the reciprocal of the largest circular frequency; at 2 an uncorrected scheme is unstable.
const MAX_FREQUENCY_STEP: f64 = 1.4;

/// Size of a stress, `m + n` in terms of the resistances, below which neither the yield surface nor the distance to it needs
/// to be evaluated: with exponents of at least 1 no utilisation exceeds it.
const CLEARLY_ELASTIC: f64 = 0.9;

/// Most shorter steps by which a yield is approached.
const MAX_APPROACHES: u32 = 4;

/// The constants of long elastic steps of one column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ElasticMotion {
    /// Length of a step, in steps of the model.
    pub steps: u32,
    /// The same \[s\].
    secs: f64,
    /// `1/M` of `v1, u1, u2`; 0 for a massless `u2` \[1/kg\].
    per_mass: Vector3<f64>,
    /// `1/M*`.
    per_scaled_mass: Vector3<f64>,
}

/// What ends a sequence of elastic steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interruption {
    /// The next step would yield, or it cannot be made this way.
    Yield,
    /// The observer has seen enough.
    Observer,
}

/// What an observer sees of each step.
pub(crate) struct Glimpse<'a> {
    /// Steps of the model since the event.
    pub step: u64,
    pub displacement: &'a Displacement,
    /// Peak `v1` since the last step \[m\].
    pub peak_v1: f64,
    /// \[N\]
    pub contact_force: f64,
    /// Position of the impactor \[m\], 0 without one.
    pub impactor_position: f64,
    /// Largest utilisation, as the sum of the yield function, if it is worth a look; otherwise [`CLEARLY_ELASTIC`].
    pub utilisation_sum: f64,
    /// What acts on the base.
    pub base: BaseForces,
}

/// A column in motion at one instant.
struct MotionState {
    settled: Settled,
    chain: Option<Chain>,
    /// True acceleration of `v1, u1, u2` \[m/s²\].
    acceleration: Vector3<f64>,
}

impl ElasticMotion {
    /// The constants of a column, with steps that are shorter by `fineness`; `None` if long steps are none, because damping or high frequencies ask for others.
    pub fn new(model: &Model, transverse_stiffness: f64, fineness: f64) -> Option<Self> {
        if model.damping.is_some() {
            return None;
        }
        let (frame, mass) = (&model.frame, model.impact_point_mass);
        let top_mass = model.top_mass();
        let (below, above, spring) = (
            frame.below.axial,
            frame.above.axial,
            frame.top_spring_stiffness,
        );
        let transverse = (transverse_stiffness / mass).sqrt();
        let (axial, top) = if top_mass > 0.0 {
            // Of the two coupled modes the sum of both squares is a bound.
            let square = (below + above) / mass + (above + spring) / top_mass;
            (square.sqrt(), square.sqrt())
        } else {
            let series = above * (spring / (above + spring));
            (((below + series) / mass).sqrt(), 0.0)
        };
        let per_period = match model.strength {
            None => STEPS_PER_PERIOD,
            Some(_) => STEPS_PER_PERIOD_WITH_RATE,
        };
        let longest = (std::f64::consts::TAU / (per_period * fineness * transverse))
            .min(MAX_FREQUENCY_STEP / axial.max(top));
        let steps = (longest / model.step_secs).min(1e6) as u32;
        let secs = f64::from(steps) * model.step_secs;
        let scale = |frequency: f64| {
            let x = 0.5 * frequency * secs;
            let ratio = libm::sin(x) / x;
            ratio * ratio
        };
        let per_top = if top_mass > 0.0 { 1.0 / top_mass } else { 0.0 };
        let per_mass = Vector3::new(1.0 / mass, 1.0 / mass, per_top);
        // The modes of a column with a mass at its top are no multiples of either mass: their phase is left as it is.
        let axial_scale = if top_mass > 0.0 { 1.0 } else { scale(axial) };
        (steps >= 2).then(|| Self {
            steps,
            secs,
            per_mass,
            per_scaled_mass: Vector3::new(
                per_mass[0] * scale(transverse),
                per_mass[1] * axial_scale,
                per_mass[2],
            ),
        })
    }

    /// Whether a state can move this way: no rigid impactor presses on the column.
    pub fn applies_to(state: &State) -> bool {
        state.impactor.as_ref().is_none_or(|impactor| {
            impactor.is_deformable() || (!impactor.closed && impactor.touched_at.is_some())
        })
    }

    /// Moves the state in long steps until a hinge would yield or `observe` answers no, and then, if it was the yield, in one
    /// shorter step close to it.
    pub fn advance(
        &self,
        model: &Model,
        state: &mut State,
        mut observe: impl FnMut(&Glimpse<'_>) -> bool,
    ) -> Interruption {
        let Some(mut run) = Run::begin(model, state) else {
            return Interruption::Yield;
        };
        let share = match run.long_steps(self, &mut observe) {
            Ended::Observer => {
                run.end();
                return Interruption::Observer;
            }
            Ended::Yield(share) => share,
        };
        run.approach(self.steps, share, &mut observe);
        run.end();
        Interruption::Yield
    }
}

enum Ended {
    Observer,
    /// The share of the next step after which a hinge yields.
    Yield(f64),
}

/// A sequence of elastic steps.
struct Run<'a> {
    model: &'a Model,
    state: &'a mut State,
    vehicle: Option<Vehicle>,
    now: MotionState,
    velocity: Vector3<f64>,
    /// Largest sum of the yield function at `now`.
    sum: f64,
    /// Steps made.
    made: u64,
}

impl<'a> Run<'a> {
    fn begin(model: &'a Model, state: &'a mut State) -> Option<Self> {
        let deformable = state.impactor.as_ref().and_then(|i| i.vehicle());
        let (vehicle, chain) = match deformable {
            Some((vehicle, chain)) => (Some(*vehicle), Some(*chain)),
            None => (None, None),
        };
        let settled = statics::settle_massless(model, state.displacement, &state.plastic)?;
        let Velocity { v1, u1, u2 } = state.velocity;
        let mut run = Self {
            model,
            vehicle,
            now: MotionState {
                settled,
                chain,
                acceleration: Vector3::zeros(),
            },
            velocity: Vector3::new(v1, u1, if model.top_is_massless() { 0.0 } else { u2 }),
            sum: 0.0,
            made: 0,
            state,
        };
        let forces = run.forces(&run.now.settled, run.now.chain.as_ref());
        run.now.acceleration = forces.component_mul(&run.per_mass());
        Some(run)
    }

    fn per_mass(&self) -> Vector3<f64> {
        let top = self.model.top_mass();
        let per = 1.0 / self.model.impact_point_mass;
        Vector3::new(per, per, if top > 0.0 { 1.0 / top } else { 0.0 })
    }

    /// Forces on `v1, u1, u2` \[N\].
    fn forces(&self, settled: &Settled, chain: Option<&Chain>) -> Vector3<f64> {
        let frame = &self.model.frame;
        let gradients = frame::gradients(&settled.chords);
        let internal = frame.internal_forces(&gradients, &settled.forces, settled.displacement.u2);
        let contact = self.contact_force(chain);
        Vector3::new(
            contact - internal[0],
            -internal[1],
            self.model.properties.top_load - internal[3],
        )
    }

    fn contact_force(&self, chain: Option<&Chain>) -> f64 {
        match (&self.vehicle, chain) {
            (Some(vehicle), Some(chain)) => chain.contact_force(vehicle),
            _ => 0.0,
        }
    }

    /// Puts the column displaced by `increment` of `v1, u1, u2` \[m\] into `next`, whose vehicle moves on with its velocities for
    /// `secs`; `None` if there is no elastic equilibrium of the massless unknowns. In place, because the copies of states took a
    /// sixth of a response.
    fn displace(
        &self,
        increment: &Vector3<f64>,
        massless: &Displacement,
        secs: f64,
        next: &mut MotionState,
    ) -> Option<()> {
        let mut u = self.now.settled.displacement;
        u.v1 += increment[0];
        u.u1 += increment[1];
        u.u2 += increment[2] + massless.u2;
        next.settled = statics::settle_massless(self.model, u, &self.state.plastic)?;
        if let (Some(vehicle), Some(chain)) = (&self.vehicle, &mut next.chain) {
            chain.drift(vehicle, secs, increment[0]);
        }
        Some(())
    }

    /// The first step of `secs`, or a single one: by Taylor's series, with the acceleration at its end for the next term.
    fn taylor_step(&self, secs: f64) -> Option<(Vector3<f64>, MotionState)> {
        let from = &self.now;
        let mut chain = from.chain;
        if let (Some(vehicle), Some(chain)) = (&self.vehicle, &mut chain) {
            chain.kick(vehicle, 0.5 * secs);
        }
        let still = Displacement::default();
        let first = self.velocity * secs + from.acceleration * (0.5 * secs * secs);
        let mut next = MotionState {
            settled: from.settled,
            chain,
            acceleration: from.acceleration,
        };
        self.displace(&first, &still, secs, &mut next)?;
        let acceleration = self
            .forces(&next.settled, next.chain.as_ref())
            .component_mul(&self.per_mass());
        let increment =
            self.velocity * secs + (from.acceleration * 2.0 + acceleration) * (secs * secs / 6.0);
        next.chain = chain;
        self.displace(&increment, &still, secs, &mut next)?;
        next.acceleration = self
            .forces(&next.settled, next.chain.as_ref())
            .component_mul(&self.per_mass());
        Some((increment, next))
    }

    fn long_steps(
        &mut self,
        motion: &ElasticMotion,
        observe: &mut impl FnMut(&Glimpse<'_>) -> bool,
    ) -> Ended {
        let secs = motion.secs;
        let ratio = motion
            .per_scaled_mass
            .component_div(&motion.per_mass.map(|it| it.max(f64::MIN_POSITIVE)));
        let Some((mut increment, mut next)) = self.taylor_step(secs) else {
            return Ended::Yield(0.0);
        };
        let mut massless = Displacement::default();
        loop {
            if let Some(share) = self.rejected(&next, motion.steps) {
                return Ended::Yield(share);
            }
            massless.u2 = if self.model.top_is_massless() {
                next.settled.displacement.u2 - self.now.settled.displacement.u2
            } else {
                0.0
            };
            let peak_v1 = self.arrive(&mut next, increment, secs);
            if !self.accept(motion.steps, peak_v1, observe) {
                return Ended::Observer;
            }
            next.chain = self.now.chain;
            if let (Some(vehicle), Some(chain)) = (&self.vehicle, &mut next.chain) {
                // On to the middle of the next step.
                chain.kick(vehicle, 0.5 * secs);
            }
            increment += self.now.acceleration.component_mul(&ratio) * (secs * secs);
            let displaced = self.displace(&increment, &massless, secs, &mut next);
            if displaced.is_none() {
                return Ended::Yield(0.0);
            }
            next.acceleration = self
                .forces(&next.settled, next.chain.as_ref())
                .component_mul(&motion.per_mass);
        }
    }

    /// Moves up to the last whole step of the model before the yield, which lies about `share` of `steps` ahead. The sum of
    /// the yield function is convex, so that a secant falls short of it: the next one begins where the last has led.
    fn approach(
        &mut self,
        mut steps: u32,
        mut share: f64,
        observe: &mut impl FnMut(&Glimpse<'_>) -> bool,
    ) {
        for _ in 0..MAX_APPROACHES {
            let near = (share * f64::from(steps)) as u32;
            if near == 0 || near >= steps || !self.short_step(near, observe) {
                return;
            }
            steps -= near;
            let secs = f64::from(steps) * self.model.step_secs;
            let Some((_, next)) = self.taylor_step(secs) else {
                return;
            };
            match self.yield_share(&next, secs) {
                Some(next_share) => share = next_share,
                None => return,
            }
        }
    }

    /// One step of a few steps of the model; whether it could be made.
    fn short_step(&mut self, steps: u32, observe: &mut impl FnMut(&Glimpse<'_>) -> bool) -> bool {
        let secs = f64::from(steps) * self.model.step_secs;
        let Some((increment, mut next)) = self.taylor_step(secs) else {
            return false;
        };
        if self.rejected(&next, steps).is_some() {
            return false;
        }
        let peak_v1 = self.arrive(&mut next, increment, secs);
        self.accept(steps, peak_v1, observe)
    }

    /// Takes the end of a step of `secs` seconds with this increment of `v1, u1, u2`; the vehicle, too, is then at its end.
    /// Returns the peak `v1` of the step; the state at its beginning is in `next` then.
    fn arrive(&mut self, next: &mut MotionState, increment: Vector3<f64>, secs: f64) -> f64 {
        let before = self.now.acceleration;
        let v1_before = self.now.settled.displacement.v1;
        let rate_before = self.velocity[0];
        self.velocity =
            increment * (1.0 / secs) + (next.acceleration * 2.0 + before) * (secs / 6.0);
        let peak_v1 = peak(
            v1_before,
            rate_before,
            next.settled.displacement.v1,
            self.velocity[0],
            secs,
        );
        std::mem::swap(&mut self.now, next);
        if let (Some(vehicle), Some(chain)) = (&self.vehicle, &mut self.now.chain) {
            chain.kick(vehicle, 0.5 * secs);
        }
        peak_v1
    }

    /// If a step to `next` must not be made this way: the share of it after which it yields, or 0.
    fn rejected(&mut self, next: &MotionState, steps: u32) -> Option<f64> {
        let model = self.model;
        let displacement = &next.settled.displacement;
        if collapse_of(model, displacement).is_some() {
            return Some(0.0);
        }
        // A rigid impactor in flight must not be reached.
        if let Some(impactor) = self
            .state
            .impactor
            .as_ref()
            .filter(|it| !it.is_deformable())
        {
            let step = self.state.step + self.made + u64::from(steps);
            if displacement.v1 <= impactor.position_in_flight(model, step, 0.0) {
                return Some(0.0);
            }
        }
        let secs = f64::from(steps) * model.step_secs;
        if let Some(share) = self.yield_share(next, secs) {
            return Some(share);
        }
        if let Some(law) = &model.strength {
            let (before, after) = (&self.now.settled.chords, &next.settled.chords);
            let turns = PerBar {
                below: before.below.discrete_gradient(&after.below).1,
                above: before.above.discrete_gradient(&after.above).1,
            };
            let strength = (&mut self.state.strength, &mut self.state.webs);
            law.follow(strength, &turns, secs);
        }
        None
    }

    /// The share of a step of `secs` to `next` after which a hinge yields, if one does; otherwise its sum is noted.
    fn yield_share(&mut self, next: &MotionState, secs: f64) -> Option<f64> {
        let sum = self.largest_sum(next, secs, CLEARLY_ELASTIC);
        if sum <= 1.0 {
            self.sum = sum;
            return None;
        }
        let before = self.largest_sum(&self.now, secs, 0.0);
        let share = (1.0 - before) / (sum - before);
        Some(if share.is_nan() {
            0.0
        } else {
            share.clamp(0.0, 1.0)
        })
    }

    /// Largest sum of the yield function, against resistances that grow with the strain rate and have hardened; `floor` if it
    /// is below that.
    fn largest_sum(&self, next: &MotionState, secs: f64, floor: f64) -> f64 {
        let model = self.model;
        let frame = &model.frame;
        let forces = &next.settled.forces;
        let size = |bar: &super::bar::Bar,
                    forces: &BarForces,
                    web: &WebState,
                    hinges: &[HingeStrength; 2]| {
            let moment = forces.moment[0].abs().max(forces.moment[1].abs());
            let softest = HingeFactors::softest([&hinges[0].factors, &hinges[1].factors]);
            let size = bar.surface.relative_moment(moment) / softest
                + bar.surface.relative_axial(forces.normal).abs();
            match &bar.slider {
                None => size,
                Some(slider) => {
                    let least = SliderStrength {
                        factor: [web.least(); 2],
                        ..SliderStrength::UNDAMAGED
                    };
                    let n = bar.surface.relative_axial(forces.normal).abs();
                    size.max(slider.utilisation(forces.moment, &least, n))
                }
            }
        };
        let sizes = [
            size(
                &frame.below,
                &forces.below,
                &self.state.webs.below,
                &self.state.strength.below,
            ),
            size(
                &frame.above,
                &forces.above,
                &self.state.webs.above,
                &self.state.strength.above,
            ),
        ];
        // What the connection of the base leaves to hinge 3 follows its normal force.
        if sizes[0].max(sizes[1]) < floor && model.properties.base_connection.is_none() {
            return floor;
        }
        let factors = model.strength.as_ref().map(|law| {
            let (before, after) = (&self.now.settled.chords, &next.settled.chords);
            let turns = PerBar {
                below: before.below.discrete_gradient(&after.below).1,
                above: before.above.discrete_gradient(&after.above).1,
            };
            let strength = (&self.state.strength, &self.state.webs, forces);
            law.predict(strength, (&before.below, &turns), secs, Collocation::End)
        });
        let webs = factors.as_ref().map(|it| it.webs());
        let factors = factors.map(|it| it.factors());
        let mut largest = floor;
        let mut look =
            |bar: &super::bar::Bar, forces: &BarForces, factors: Option<&[HingeFactors; 2]>| {
                for k in 0..2 {
                    let (moment, normal) = match factors {
                        Some(factors) => factors[k].reduced(forces.moment[k], forces.normal),
                        None => (forces.moment[k], forces.normal),
                    };
                    let sum = bar.surface.sum(moment, normal);
                    if sum > largest || sum.is_nan() {
                        largest = sum;
                    }
                }
            };
        look(
            &frame.below,
            &forces.below,
            factors.as_ref().map(|it| &it.below),
        );
        look(
            &frame.above,
            &forces.above,
            factors.as_ref().map(|it| &it.above),
        );
        for (bar, forces, factors, web) in [
            (
                &frame.below,
                &forces.below,
                factors.as_ref().map(|it| &it.below),
                webs.as_ref().map(|it| &it.below),
            ),
            (
                &frame.above,
                &forces.above,
                factors.as_ref().map(|it| &it.above),
                webs.as_ref().map(|it| &it.above),
            ),
        ] {
            let weakest = factors.map_or(1.0, |[a, b]| HingeFactors::weakest([a, b]));
            let undamaged = &SliderStrength::UNDAMAGED;
            let used = bar.web_utilisation(forces, web.unwrap_or(undamaged), weakest);
            if used > largest || used.is_nan() {
                largest = used;
            }
        }
        if largest.is_nan() {
            f64::INFINITY
        } else {
            largest
        }
    }

    fn accept(
        &mut self,
        steps: u32,
        peak_v1: f64,
        observe: &mut impl FnMut(&Glimpse<'_>) -> bool,
    ) -> bool {
        self.made += u64::from(steps);
        let displacement = &self.now.settled.displacement;
        let step = self.state.step + self.made;
        let impactor_position = match (&self.state.impactor, &self.now.chain) {
            (_, Some(chain)) => displacement.v1 - chain.gap(),
            (Some(impactor), None) => impactor.position_in_flight(self.model, step, 0.0),
            (None, None) => 0.0,
        };
        let contact_force = self.contact_force(self.now.chain.as_ref());
        let base = base_forces(
            self.model,
            displacement,
            &self.now.settled.forces,
            // Long steps are those of a column without damping.
            (0.0, contact_force),
            0.0,
        );
        observe(&Glimpse {
            base,
            step,
            displacement,
            peak_v1,
            contact_force,
            impactor_position,
            utilisation_sum: self.sum,
        })
    }

    /// Leaves the state where the steps have led.
    fn end(self) {
        let Self {
            model,
            state,
            now,
            velocity,
            made,
            ..
        } = self;
        if made == 0 {
            return;
        }
        state.step += made;
        state.displacement = now.settled.displacement;
        state.forces = now.settled.forces;
        state.velocity = Velocity {
            v1: velocity[0],
            u1: velocity[1],
            u2: velocity[2],
        };
        state.rest_hinges();
        state.impact_impulse = 0.0;
        state.contact_force = 0.0;
        state.predictor.forget();
        if let Some(law) = &model.strength {
            law.refresh(&mut state.strength, &mut state.webs, &state.forces);
        }
        let step = state.step;
        if let Some(impactor) = &mut state.impactor {
            impactor.arrive(model, step, state.displacement.v1, now.chain);
            state.contact_force = impactor.crush_force();
        }
    }
}

/// Peak `v1` of the cubic between two instants \[m\]: the parabola of its rates.
fn peak(v1: f64, rate: f64, next: f64, next_rate: f64, secs: f64) -> f64 {
    if !(rate > 0.0 && next_rate < 0.0) {
        return next;
    }
    // Where the rate vanishes; from the nearer end.
    let share = rate / (rate - next_rate);
    let from_start = v1 + 0.5 * rate * share * secs;
    let from_end = next - 0.5 * next_rate * (1.0 - share) * secs;
    (0.5 * (from_start + from_end)).max(next)
}
