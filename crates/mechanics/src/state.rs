//! The state of a column under impact.

use serde::{Deserialize, Serialize};

use super::bar::{Bar, BarForces, BarStrain, PerBar, PerBarHinges, PlasticFlow};
use super::base_reactions::{BaseInstant, base_forces};
use super::chain::{Chain, ChainPoint};
use super::contact::Impactor;
use super::frame;
use super::geometry::Displacement;
use super::impact::time_of_travel;
use super::ledger::{Energies, Ledger};
use super::model::Model;
use super::properties::is_default;
use super::rate::{HingeStrength, Strengths, Webs};
use super::sample::{BaseForces, HINGES, HingeSample, HingeState, Phase, Sample, VehicleSample};
use super::vehicle::MAX_MASSES;
use super::web_strength::WebState;

/// Relative to the angle that a bar owes to a slip of its base: less is the round-off of their difference, and no shear of its web.
const SLIP_ROUND_OFF: f64 = 1e-9;

/// Rates of the displacements that can carry mass \[m/s\]; for a massless `u2` its last mean rate.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity {
    /// Of `v1`.
    pub v1: f64,
    /// Of `u1`.
    pub u1: f64,
    /// Of `u2`.
    pub u2: f64,
}

/// The complete state of a column under impact: plain data that can be copied as a snapshot. A run continued from a copy
/// equals the uninterrupted run bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Steps since the event.
    pub step: u64,
    /// `U`.
    pub displacement: Displacement,
    /// Its rates.
    pub velocity: Velocity,
    /// Plastic deformation of the hinges, since the column was new.
    pub plastic: PerBar<PlasticFlow>,
    /// Strain rate and hardening of the hinges.
    #[serde(default)]
    pub strength: PerBar<[HingeStrength; 2]>,
    /// Strength and flow of the webs; not written where they have never been strained.
    #[serde(default, skip_serializing_if = "is_default")]
    pub webs: PerBar<WebState>,
    /// Forces of the bars at the end of the step.
    pub forces: PerBar<BarForces>,
    /// Which hinges flowed in the last step, per bar.
    pub flowing: PerBar<[bool; 2]>,
    /// What strikes the column.
    pub impactor: Option<Impactor>,
    /// Smooth contact force \[N\].
    pub contact_force: f64,
    /// Impact impulse in the last step \[N s\].
    pub impact_impulse: f64,
    /// Impact impulses since the event \[N s\].
    pub total_impact_impulse: f64,
    /// Number of impact impulses since the event.
    pub impact_impulses: u32,
    /// Impulse since the event, impact impulses included \[N s\].
    pub impulse: f64,
    /// Newton iterations since the event: what the steps have cost.
    pub newton_iterations: u64,
    /// Dissipation since the event.
    pub ledger: Ledger,
    /// Extrapolation to the next step.
    pub(crate) predictor: Predictor,
}

/// The last two whole steps. Their extrapolation starts the iteration of the next step so close to the solution that one
/// iteration is usually enough.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Predictor {
    last: Course,
    before_last: Course,
    /// How many of the two belong to the present motion; a velocity jump invalidates both.
    known: u8,
}

/// Course of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Course {
    /// Mean rate of `U`.
    rate: Displacement,
    /// `U` where the equations were satisfied.
    solution: Displacement,
    /// Normal forces there \[N\].
    normal: PerBar<f64>,
}

impl Predictor {
    /// Expected increment of a step of `secs` seconds that begins with `velocity`.
    pub fn increment(&self, velocity: &Velocity, secs: f64) -> Displacement {
        let rate = match self.known {
            0 => Displacement {
                v1: velocity.v1,
                u1: velocity.u1,
                beta1: 0.0,
                u2: velocity.u2,
            },
            1 => self.last.rate,
            _ => self.last.rate.times(2.0).minus(self.before_last.rate),
        };
        rate.times(secs)
    }

    /// Expected `U` where the next step's equations are satisfied, if two steps are known.
    pub fn solution(&self) -> Option<Displacement> {
        (self.known >= 2).then(|| {
            self.last
                .solution
                .times(2.0)
                .minus(self.before_last.solution)
        })
    }

    /// Expected normal forces there; `otherwise` where no two steps are known.
    pub fn normal(&self, otherwise: &PerBar<BarForces>) -> PerBar<f64> {
        if self.known < 2 {
            return PerBar {
                below: otherwise.below.normal,
                above: otherwise.above.normal,
            };
        }
        let (last, before) = (&self.last.normal, &self.before_last.normal);
        PerBar {
            below: 2.0 * last.below - before.below,
            above: 2.0 * last.above - before.above,
        }
    }

    /// Records a step: its increment, and the displacements and forces where its equations were satisfied.
    pub fn learn(
        &mut self,
        increment: &Displacement,
        secs: f64,
        solution: Displacement,
        forces: &PerBar<BarForces>,
    ) {
        self.before_last = self.last;
        self.last = Course {
            rate: increment.times(1.0 / secs),
            solution,
            normal: PerBar {
                below: forces.below.normal,
                above: forces.above.normal,
            },
        };
        self.known = (self.known + 1).min(2);
    }

    /// Discards what a velocity jump or a change of step length has invalidated.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

impl State {
    /// The undamaged column at rest under its load.
    pub fn at_rest(model: &Model) -> Self {
        Self::settled(model, model.rest.displacement(), PerBar::default())
    }

    /// A column without motion or impactor; `displacement` should be its static equilibrium.
    pub fn settled(
        model: &Model,
        displacement: Displacement,
        plastic: PerBar<PlasticFlow>,
    ) -> Self {
        let chords = model.frame.chords(&displacement);
        let mut state = Self {
            step: 0,
            displacement,
            velocity: Velocity::default(),
            plastic,
            strength: Strengths::default(),
            webs: Webs::default(),
            forces: model.frame.elastic_forces(&chords, &displacement, &plastic),
            flowing: PerBar::default(),
            impactor: None,
            contact_force: 0.0,
            impact_impulse: 0.0,
            total_impact_impulse: 0.0,
            impact_impulses: 0,
            impulse: 0.0,
            newton_iterations: 0,
            ledger: Ledger::default(),
            predictor: Predictor::default(),
        };
        state.ledger = Ledger::open(&state.energies(model), 0.0);
        state.set_accumulated_rotation(
            model,
            &PerBar {
                below: plastic.below.rotation.map(f64::abs),
                above: plastic.above.rotation.map(f64::abs),
            },
        );
        if let Some(law) = &model.strength {
            law.harden(
                &mut state.webs,
                &PerBar {
                    below: plastic.below.shear_angle,
                    above: plastic.above.shear_angle,
                },
            );
        }
        state
    }

    /// Sets what the webs of a column at rest remember. [`State::settled`] takes their plastic shear angles as sheared at
    /// once, which is right unless a web has sheared to and fro.
    pub fn set_webs(&mut self, model: &Model, webs: &PerBar<WebState>) {
        self.webs = *webs;
        for web in [&mut self.webs.below, &mut self.webs.above] {
            web.begin();
        }
        if let Some(law) = &model.strength {
            law.settle(&mut self.strength, &mut self.webs, &self.forces);
        }
    }

    /// What the webs remember; `None` where none of them has yielded.
    pub fn sheared_webs(&self) -> Option<PerBar<WebState>> {
        let PerBar { below, above } = &self.plastic;
        (below.has_sheared() || above.has_sheared()).then_some(self.webs)
    }

    /// Sets the accumulated plastic rotations \[rad\] of a column at rest, per bar: at the impact point, at the other end.
    /// [`State::settled`] takes the absolute plastic rotations, which is right unless a hinge has turned back.
    pub fn set_accumulated_rotation(&mut self, model: &Model, accumulated: &PerBarHinges) {
        for (hinges, accumulated) in [
            (&mut self.strength.below, accumulated.below),
            (&mut self.strength.above, accumulated.above),
        ] {
            *hinges = accumulated.map(|accumulated_rotation| HingeStrength {
                accumulated_rotation,
                ..HingeStrength::default()
            });
        }
        if let Some(law) = &model.strength {
            law.settle(&mut self.strength, &mut self.webs, &self.forces);
        }
    }

    /// Multiplies the plastic deformation of a column at rest, and the accumulated plastic rotations, by a factor.
    pub fn scale_damage(&mut self, model: &Model, factor: f64) {
        let accumulated = self.accumulated_rotation();
        self.plastic = PerBar {
            below: self.plastic.below.scaled(factor),
            above: self.plastic.above.scaled(factor),
        };
        let scaled = PerBar {
            below: accumulated.below.map(|it| factor * it),
            above: accumulated.above.map(|it| factor * it),
        };
        self.set_accumulated_rotation(model, &scaled);
    }

    /// The plastic deformation of the steel since the column was new: without the slip of the base, which turns the lower bar as
    /// a shear of its web does.
    #[must_use]
    pub fn plastic_of_steel(&self, model: &Model) -> PerBar<PlasticFlow> {
        let mut plastic = self.plastic;
        let slip = self.webs.below.slip / model.frame.below.length;
        let web = &mut plastic.below.shear_angle;
        *web -= slip;
        if web.abs() < SLIP_ROUND_OFF * slip.abs() {
            *web = 0.0;
        }
        plastic
    }

    /// Accumulated plastic rotations \[rad\], per bar.
    pub fn accumulated_rotation(&self) -> PerBarHinges {
        let of = |hinges: &[HingeStrength; 2]| hinges.map(|hinge| hinge.accumulated_rotation);
        PerBar {
            below: of(&self.strength.below),
            above: of(&self.strength.above),
        }
    }

    /// Receives an impactor: the column keeps its motion and its plastic deformation, the clock, the ledger and the filter of
    /// the strain rate restart, and an earlier impactor is gone.
    pub(crate) fn receive(&mut self, model: &Model, impactor: Impactor) {
        self.step = 0;
        self.flowing = PerBar::default();
        self.contact_force = 0.0;
        self.impact_impulse = 0.0;
        self.total_impact_impulse = 0.0;
        self.impact_impulses = 0;
        self.impulse = 0.0;
        self.newton_iterations = 0;
        for hinge in self
            .strength
            .below
            .iter_mut()
            .chain(&mut self.strength.above)
        {
            hinge.begin();
        }
        self.webs.below.begin();
        self.webs.above.begin();
        self.impactor = Some(impactor);
        let energies = self.energies(model);
        self.ledger = Ledger::open(&energies, energies.impactor_kinetic);
    }

    /// `v1 - v_c` \[m\]; 0 without an impactor. In contact it is 0 with the conserving midpoint rule; with the paper's
    /// midpoint rule the penetration of the step in which contact closed remains.
    pub fn gap(&self) -> f64 {
        self.impactor
            .as_ref()
            .map_or(0.0, |impactor| impactor.gap(self.displacement.v1))
    }

    /// The energies of this state, the elastic energy from the forces of the bars.
    pub fn energies(&self, model: &Model) -> Energies {
        let square = |x: f64| x * x;
        let (velocity, u2, frame) = (&self.velocity, self.displacement.u2, &model.frame);
        let (impactor_kinetic, vehicle_elastic) =
            self.impactor.as_ref().map_or((0.0, 0.0), |i| i.energies());
        Energies {
            column_kinetic: 0.5
                * (model.impact_point_mass * (square(velocity.v1) + square(velocity.u1))
                    + model.top_mass() * square(velocity.u2)),
            impactor_kinetic,
            elastic: frame.below.elastic_energy(&self.forces.below)
                + frame.above.elastic_energy(&self.forces.above)
                + 0.5 * frame.top_spring_stiffness * square(u2),
            vehicle_elastic,
            load_work: model.properties.top_load * u2
                + self
                    .impactor
                    .as_ref()
                    .map_or(0.0, |i| i.transverse_work(self.displacement.v1)),
        }
    }

    /// The error of the energy balance \[J\].
    pub fn ledger_residual(&self, model: &Model) -> f64 {
        self.ledger.residual(&self.energies(model))
    }

    /// Adds the plastic flow of a part of a step.
    pub(crate) fn flow(
        &mut self,
        model: &Model,
        below: &PlasticFlow,
        above: &PlasticFlow,
        factor: f64,
    ) {
        self.plastic.below = self.plastic.below.plus(factor, below);
        self.plastic.above = self.plastic.above.plus(factor, above);
        for k in 0..2 {
            self.flowing.below[k] |= model.frame.below.flows(below, k);
            self.flowing.above[k] |= model.frame.above.flows(above, k);
            self.strength.below[k].accumulate(factor * below.rotation[k]);
            self.strength.above[k].accumulate(factor * above.rotation[k]);
        }
        for (web, bar, flow) in [
            (&mut self.webs.below, &model.frame.below, below),
            (&mut self.webs.above, &model.frame.above, above),
        ] {
            if flow.shear_angle != 0.0 {
                web.flowing |= bar.shears(flow);
            }
        }
    }

    /// Books the work of the hinges and of the webs on `factor` times the flow of a part of a step, under the forces at work.
    pub(crate) fn dissipate(
        &mut self,
        below: (&BarForces, &PlasticFlow),
        above: (&BarForces, &PlasticFlow),
        factor: f64,
    ) {
        for (web, (forces, flow)) in [(&mut self.webs.below, below), (&mut self.webs.above, above)]
        {
            if flow.shear_angle != 0.0 && !web.slipping {
                web.work += factor * forces.shear_work(flow);
            }
        }
        self.ledger.plastic_work += factor * (below.0.work(below.1) + above.0.work(above.1));
    }

    /// Forgets which hinges and webs have flowed: a step begins.
    pub(crate) fn rest_hinges(&mut self) {
        self.flowing = PerBar::default();
        self.webs.below.flowing = false;
        self.webs.above.flowing = false;
        self.webs.below.slipping = false;
    }

    /// Moves a deformable vehicle to the end of a part of a step, `(offset, length)` \[s\], whose column has already arrived.
    pub(crate) fn follow(
        &mut self,
        model: &Model,
        (offset_secs, secs): (f64, f64),
        point: &ChainPoint,
    ) {
        let part = (self.step, offset_secs, secs);
        let v1 = self.displacement.v1;
        if let Some(impactor) = &mut self.impactor {
            let crushed = impactor.follow(model, part, v1, point);
            self.contact_force = impactor.crush_force();
            self.impulse += crushed.impulse;
            let dissipated = &mut self.ledger.vehicle_dissipated;
            for (total, part) in dissipated.iter_mut().zip(crushed.dissipated) {
                *total += part;
            }
        }
    }

    /// Records an impact impulse with this impulse \[N s\].
    pub(crate) fn count_impact_impulse(&mut self, impulse: f64) {
        self.impact_impulse += impulse;
        self.total_impact_impulse += impulse;
        self.impact_impulses += 1;
    }

    /// Number of whole steps for which an impactor still approaches a column at rest; `None` if the column moves or has
    /// been touched.
    pub fn steps_to_contact(&self, model: &Model) -> Option<u64> {
        let impactor = self.impactor.as_ref().filter(|_| self.is_waiting())?;
        // One step less than the quotient: its rounding must not let the impactor through.
        let acceleration = impactor.impact.acceleration();
        let steps = time_of_travel(self.gap(), impactor.velocity, acceleration) / model.step_secs;
        Some((steps.floor() as u64).saturating_sub(1))
    }

    /// Whether the column is at rest and waits for an impactor that has not touched it yet.
    pub(crate) fn is_waiting(&self) -> bool {
        let is_coming = |impactor: &Impactor| impactor.touched_at.is_none();
        self.impactor.as_ref().is_some_and(is_coming) && self.velocity == Velocity::default()
    }

    /// Lets `steps` of [`State::steps_to_contact`] pass, during which only the impactor moves.
    pub(crate) fn coast(&mut self, model: &Model, steps: u64) {
        self.step += steps;
        self.impact_impulse = 0.0;
        if let Some(impactor) = &mut self.impactor {
            impactor.coast(model, self.step, self.displacement.v1);
        }
    }

    /// Whether any hinge or web flowed, or the base slipped, in the last step.
    pub fn is_flowing(&self) -> bool {
        let (PerBar { below, above }, webs) = (self.flowing, &self.webs);
        below[0]
            || below[1]
            || above[0]
            || above[1]
            || webs.below.flowing
            || webs.above.flowing
            || webs.below.slipping
    }

    /// A hash over the bits of the visible motion: equal states have equal hashes on every machine. It leaves out what else
    /// the next steps depend on (flow and contact flags, times of touch and flight, strength of the hinges, the predictor);
    /// a difference there shows in the hash one step later.
    pub fn hash(&self) -> u64 {
        // FNV-1a: a digest for comparing runs, not for security.
        const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        let Displacement { v1, u1, beta1, u2 } = self.displacement;
        let bar = |p: &PlasticFlow, f: &BarForces| {
            [
                p.elongation[0],
                p.elongation[1],
                p.rotation[0],
                p.rotation[1],
                f.normal,
                f.moment[0],
                f.moment[1],
            ]
        };
        let impactor = self.impactor.as_ref();
        let struck_by = impactor.map_or([0.0; 2], |i| [i.position, i.velocity]);
        let chain = impactor.and_then(|i| i.vehicle()).map(|(_, chain)| chain);
        let ledger = &self.ledger;
        // Zeros of a column without shear are left out, so that its hash is what it was before shear existed.
        let PerBar { below, above } = &self.plastic;
        let sheared = [below, above].into_iter().flat_map(|plastic| {
            let numbers = [plastic.shear_angle, plastic.shear_elongation];
            numbers.into_iter().filter(|number| *number != 0.0)
        });
        let numbers = [v1, u1, beta1, u2]
            .into_iter()
            .chain([self.velocity.v1, self.velocity.u1, self.velocity.u2])
            .chain(bar(&self.plastic.below, &self.forces.below))
            .chain(bar(&self.plastic.above, &self.forces.above))
            .chain(struck_by)
            .chain([self.contact_force, self.impulse, self.total_impact_impulse])
            .chain([ledger.plastic_work, ledger.impact_loss, ledger.damping_work])
            .chain(chain.into_iter().flat_map(Chain::numbers))
            .chain(sheared);
        std::iter::once(self.step)
            .chain(numbers.map(f64::to_bits))
            .flat_map(u64::to_le_bytes)
            .fold(OFFSET, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(PRIME)
            })
    }

    /// Everything that can be observed in this state.
    pub fn sample(&self, model: &Model) -> Sample {
        let energies = self.energies(model);
        let impactor = self.impactor.as_ref();
        Sample {
            time: model.time_of_step(self.step),
            phase: self.phase(),
            v1: self.displacement.v1,
            u1: self.displacement.u1,
            beta1: self.displacement.beta1,
            u2: self.displacement.u2,
            v1_rate: self.velocity.v1,
            u1_rate: self.velocity.u1,
            u2_rate: self.velocity.u2,
            impactor_position: impactor.map_or(0.0, |i| i.position),
            impactor_velocity: impactor.map_or(0.0, |i| i.velocity),
            gap: self.gap(),
            contact_force: self.contact_force,
            impact_impulse: self.impact_impulse,
            impulse: self.impulse,
            kinetic_energy: energies.column_kinetic + energies.impactor_kinetic,
            elastic_energy: energies.elastic,
            plastic_work: self.ledger.plastic_work,
            impact_loss: self.ledger.impact_loss,
            damping_work: self.ledger.damping_work,
            load_work: energies.load_work,
            ledger_residual: self.ledger.residual(&energies),
            vehicle: self.vehicle(),
            hinges: self.hinges(model),
            webs: self.web_samples(model),
            base: self.base_forces(model),
        }
    }

    /// What acts on the base, the inertia of the lower bar included.
    pub fn base_forces(&self, model: &Model) -> BaseForces {
        let web = &self.webs.below;
        base_forces(
            model,
            &self.displacement,
            &self.forces,
            (self.velocity.v1, self.contact_force),
            if web.flowing {
                web.dynamic_factor()
            } else {
                0.0
            },
        )
    }

    /// The reactions of the base at the instant `time` \[s\], for their history; `last_contact` \[s\] counts once the column has
    /// been touched.
    pub(crate) fn base_instant<'a>(
        &self,
        model: &'a Model,
        time: f64,
        last_contact: f64,
    ) -> BaseInstant<'a> {
        let touched = self.impactor.as_ref().and_then(|it| it.touched_at);
        let factors = &self.strength.below[1].factors;
        BaseInstant {
            time,
            v1: self.displacement.v1,
            forces: self.base_forces(model),
            slides: self.webs.below.flowing || self.webs.below.slipping,
            last_contact: touched.map(|_| last_contact),
            model,
            strength: [factors.dynamic, factors.hardening],
        }
    }

    fn vehicle(&self) -> VehicleSample {
        let impactor = self.impactor.as_ref();
        impactor.and_then(|i| i.vehicle()).map_or_else(
            VehicleSample::default,
            |(vehicle, chain)| {
                let mut force = [0.0; MAX_MASSES];
                for (force, (spring, state)) in force
                    .iter_mut()
                    .zip(vehicle.springs().iter().zip(&chain.springs))
                {
                    *force = state.force(spring);
                }
                VehicleSample {
                    masses: vehicle.masses().len(),
                    velocity: chain.velocity,
                    crush: chain.springs.map(|spring| spring.crush),
                    permanent_crush: chain.springs.map(|spring| spring.permanent),
                    force,
                    dissipated: self.ledger.vehicle_dissipated,
                    elastic_energy: chain.elastic_energy(vehicle),
                }
            },
        )
    }

    fn phase(&self) -> Phase {
        match &self.impactor {
            None => Phase::Idle,
            Some(impactor) if impactor.closed => Phase::Contact,
            Some(impactor) if impactor.touched_at.is_some() => Phase::Free,
            Some(_) => Phase::Approach,
        }
    }

    fn hinges(&self, model: &Model) -> [HingeSample; HINGES] {
        let chords = model.frame.chords(&self.displacement);
        let mut total = frame::strains(&chords, &frame::angles(&chords), self.displacement.beta1);
        if model.frame.top_is_free {
            // Bar b turns with the impact point.
            total.above.rotation = [0.0; 2];
        }
        let hinge = |bar: &Bar,
                     forces: &BarForces,
                     plastic: &PlasticFlow,
                     total: &BarStrain,
                     flowing: &[bool; 2],
                     strength: &[HingeStrength; 2],
                     k: usize| {
            let factors = &strength[k].factors;
            let (moment, normal_force) = factors.reduced(forces.moment[k], forces.normal);
            HingeSample {
                moment: forces.moment[k],
                normal_force: forces.normal,
                rotation: total.rotation[k],
                elongation: 0.5 * total.minus(plastic).elongation + plastic.elongation[k],
                plastic_rotation: plastic.rotation[k],
                plastic_elongation: plastic.elongation[k],
                utilisation: bar.surface.utilisation(moment, normal_force),
                dynamic_factor: factors.dynamic,
                state: hinge_state(flowing[k], bar.flows(plastic, k)),
            }
        };
        let Self {
            forces: f,
            plastic: p,
            flowing: w,
            strength: s,
            ..
        } = self;
        let below = |k| {
            hinge(
                &model.frame.below,
                &f.below,
                &p.below,
                &total.below,
                &w.below,
                &s.below,
                k,
            )
        };
        let above = |k| {
            hinge(
                &model.frame.above,
                &f.above,
                &p.above,
                &total.above,
                &w.above,
                &s.above,
                k,
            )
        };
        [below(0), above(0), above(1), below(1)]
    }
}

pub(crate) fn hinge_state(flowing: bool, has_flowed: bool) -> HingeState {
    match (flowing, has_flowed) {
        (true, _) => HingeState::Plastic,
        (false, true) => HingeState::Unloaded,
        (false, false) => HingeState::Elastic,
    }
}
