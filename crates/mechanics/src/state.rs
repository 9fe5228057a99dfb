//! What changes while a column is stepped.

use serde::{Deserialize, Serialize};

use super::assembly::{self, PerBar};
use super::bar::{Bar, BarForces, BarStrain, PlasticFlow};
use super::contact::{Impactor, percussion};
use super::energy;
use super::geometry::Displacement;
use super::impact::{Impact, ImpactError};
use super::ledger::{self, Ledger};
use super::model::Model;
use super::properties::Scheme;
use super::sample::{HINGES, HingeSample, HingeState, Phase, Sample};

/// Rates of the displacements that can carry mass \[m/s\]; of a massless `u2` its last mean rate.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Velocity {
    /// Of `v1`.
    pub v1: f64,
    /// Of `u1`.
    pub u1: f64,
    /// Of `u2`.
    pub u2: f64,
}

/// The whole state of a column under impact: plain data, copied as a snapshot. A run continued from a copy equals the
/// uninterrupted one bit for bit.
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
    /// Forces of the bars at the end of the step.
    pub forces: PerBar<BarForces>,
    /// Which hinges flowed in the last step, per bar.
    pub flowing: PerBar<[bool; 2]>,
    /// What hits the column.
    pub impactor: Option<Impactor>,
    /// Smooth contact force \[N\].
    pub contact_force: f64,
    /// Percussion in the last step \[N s\].
    pub percussion: f64,
    /// Percussions since the event \[N s\].
    pub percussion_impulse: f64,
    /// Number of percussions since the event.
    pub percussions: u32,
    /// Impulse since the event, percussions included \[N s\].
    pub impulse: f64,
    /// Newton corrections since the event: what the steps have cost.
    pub corrections: u64,
    /// Dissipation since the event.
    pub ledger: Ledger,
    /// What the next step is expected to look like.
    pub(crate) predictor: Predictor,
}

/// The last two whole steps: extrapolated, they begin the next step's iteration where one correction is enough.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Predictor {
    last: Course,
    before_last: Course,
    /// How many of the two are of the present motion (a velocity jump makes them worthless).
    known: u8,
}

/// Course of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Course {
    /// Mean rate of `U`.
    rate: Displacement,
    /// `U` where the equations were satisfied.
    stage: Displacement,
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
    pub fn stage(&self) -> Option<Displacement> {
        (self.known >= 2).then(|| self.last.stage.times(2.0).minus(self.before_last.stage))
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

    /// Takes note of a step: its increment, and displacements and forces where its equations were satisfied.
    pub fn learn(
        &mut self,
        increment: &Displacement,
        secs: f64,
        stage: Displacement,
        forces: &PerBar<BarForces>,
    ) {
        self.before_last = self.last;
        self.last = Course {
            rate: increment.times(1.0 / secs),
            stage,
            normal: PerBar {
                below: forces.below.normal,
                above: forces.above.normal,
            },
        };
        self.known = (self.known + 1).min(2);
    }

    /// Forgets what a velocity jump or a change of step length has made worthless.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

impl State {
    /// The virgin column at rest under its load.
    pub fn at_rest(model: &Model) -> Self {
        Self::settled(model, model.rest_displacement(), PerBar::default())
    }

    /// A column without motion or impactor; `displacement` should be its static equilibrium.
    pub fn settled(
        model: &Model,
        displacement: Displacement,
        plastic: PerBar<PlasticFlow>,
    ) -> Self {
        let chords = assembly::chords(model, &displacement);
        let mut state = Self {
            step: 0,
            displacement,
            velocity: Velocity::default(),
            plastic,
            forces: assembly::elastic_forces(model, &chords, &displacement, &plastic),
            flowing: PerBar::default(),
            impactor: None,
            contact_force: 0.0,
            percussion: 0.0,
            percussion_impulse: 0.0,
            percussions: 0,
            impulse: 0.0,
            corrections: 0,
            ledger: Ledger::default(),
            predictor: Predictor::default(),
        };
        state.ledger = Ledger::open(&ledger::energies(model, &state), 0.0);
        state
    }

    /// Begins an impact: the column keeps its motion and its plastic deformation, the clock and the ledger start
    /// anew, an earlier impactor is gone. With the energy scheme an impactor without a gap strikes at once.
    ///
    /// # Errors
    /// An impact that is out of range; the state is then unchanged.
    pub fn begin_impact(&mut self, model: &Model, impact: Impact) -> Result<(), ImpactError> {
        impact.check()?;
        *self = Self {
            step: 0,
            impactor: Some(Impactor::new(impact, self.displacement.v1)),
            flowing: PerBar::default(),
            contact_force: 0.0,
            percussion: 0.0,
            percussion_impulse: 0.0,
            percussions: 0,
            impulse: 0.0,
            corrections: 0,
            ..*self
        };
        self.ledger = Ledger::open(&ledger::energies(model, self), impact.energy());
        if model.scheme() == Scheme::Energy && impact.gap == 0.0 {
            // On a bent column contact begins with a force.
            *self = energy::strike(model, *self, 0.0, 0.0, &mut energy::Events::default()).state;
        }
        Ok(())
    }

    /// `v1 - v_c` \[m\]; 0 without an impactor. In contact it is 0 with the energy scheme; with the paper's
    /// midpoint rule the penetration of the step that closed it remains.
    pub fn gap(&self) -> f64 {
        self.impactor
            .map_or(0.0, |impactor| self.displacement.v1 - impactor.position)
    }

    /// What the ledger fails to close by \[J\].
    pub fn ledger_residual(&self, model: &Model) -> f64 {
        self.ledger.residual(&ledger::energies(model, self))
    }

    /// Newton's impact law, `offset_secs` into the step, on an impactor that touches and closes; `rebound` false makes
    /// it perfectly inelastic.
    pub(crate) fn strike(&mut self, model: &Model, offset_secs: f64, rebound: bool) {
        let Some(mut impactor) = self.impactor else {
            return;
        };
        let speed = impactor.closing_speed(self.velocity.v1);
        let mass = impactor.impact.mass;
        impactor.touch(model, self.step, offset_secs);
        impactor.position = self.displacement.v1;
        let mut restitution = 0.0;
        if speed > 0.0 {
            if rebound {
                restitution = impactor.effective_restitution(speed);
            }
            let hit = percussion(mass, model.impact_point_mass, speed, restitution);
            self.velocity.v1 += hit.impulse / model.impact_point_mass;
            impactor.velocity -= hit.impulse / mass;
            self.percussion += hit.impulse;
            self.percussion_impulse += hit.impulse;
            self.impulse += hit.impulse;
            self.percussions += 1;
            self.ledger.impact_loss += hit.loss;
            self.predictor.forget();
        }
        if restitution > 0.0 || speed < 0.0 {
            // Rebound, or a graze: at the end of a part the two may touch and part already.
            impactor.release(model, self.step, offset_secs);
        } else {
            impactor.closed = true;
            impactor.velocity = self.velocity.v1;
        }
        self.impactor = Some(impactor);
    }

    /// Whole steps for which an impactor still flies towards a column at rest; `None` if the column moves or has been
    /// touched.
    pub fn steps_to_contact(&self, model: &Model) -> Option<u64> {
        let impactor = self.impactor?;
        if impactor.touched_at.is_some() || self.velocity != Velocity::default() {
            return None;
        }
        // One step less than the quotient: its rounding must not let the impactor through.
        let steps = self.gap() / impactor.velocity / model.step_secs;
        Some((steps.floor() as u64).saturating_sub(1))
    }

    /// Lets `steps` of [`State::steps_to_contact`] pass: nothing but the impactor moves.
    pub(crate) fn coast(&mut self, model: &Model, steps: u64) {
        self.step += steps;
        self.percussion = 0.0;
        if let Some(impactor) = &mut self.impactor {
            impactor.position = impactor.position_in_flight(model, self.step, 0.0);
        }
    }

    /// Whether any hinge flowed in the last step.
    pub fn is_flowing(&self) -> bool {
        let PerBar { below, above } = self.flowing;
        below[0] || below[1] || above[0] || above[1]
    }

    /// A hash over the bits of what can be seen of the motion: equal states have equal hashes on every machine. What
    /// else the next steps depend on (flow and contact flags, times of touch and flight, the predictor) is not in it; a
    /// difference there shows in the hash a step later.
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
        let impactor = self.impactor.map_or([0.0; 2], |i| [i.position, i.velocity]);
        let ledger = &self.ledger;
        let numbers = [v1, u1, beta1, u2]
            .into_iter()
            .chain([self.velocity.v1, self.velocity.u1, self.velocity.u2])
            .chain(bar(&self.plastic.below, &self.forces.below))
            .chain(bar(&self.plastic.above, &self.forces.above))
            .chain(impactor)
            .chain([self.contact_force, self.impulse, self.percussion_impulse])
            .chain([ledger.plastic_work, ledger.impact_loss, ledger.damping_work]);
        std::iter::once(self.step)
            .chain(numbers.map(f64::to_bits))
            .flat_map(u64::to_le_bytes)
            .fold(OFFSET, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(PRIME)
            })
    }

    /// Everything that can be seen of this state.
    pub fn sample(&self, model: &Model) -> Sample {
        let energies = ledger::energies(model, self);
        let impactor = self.impactor;
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
            percussion: self.percussion,
            impulse: self.impulse,
            kinetic_energy: energies.column_kinetic + energies.impactor_kinetic,
            elastic_energy: energies.elastic,
            plastic_work: self.ledger.plastic_work,
            impact_loss: self.ledger.impact_loss,
            damping_work: self.ledger.damping_work,
            load_work: energies.load_work,
            ledger_residual: self.ledger.residual(&energies),
            hinges: self.hinges(model),
        }
    }

    fn phase(&self) -> Phase {
        match self.impactor {
            None => Phase::Idle,
            Some(impactor) if impactor.closed => Phase::Contact,
            Some(impactor) if impactor.touched_at.is_some() => Phase::Free,
            Some(_) => Phase::Approach,
        }
    }

    fn hinges(&self, model: &Model) -> [HingeSample; HINGES] {
        let chords = assembly::chords(model, &self.displacement);
        let total = assembly::strains(&chords, self.displacement.beta1);
        let elastic = assembly::elastic_strains(&chords, &self.displacement, &self.plastic);
        let hinge = |bar: &Bar,
                     forces: &BarForces,
                     plastic: &PlasticFlow,
                     total: &BarStrain,
                     elastic: &BarStrain,
                     flowing: &[bool; 2],
                     k: usize| HingeSample {
            moment: forces.moment[k],
            normal_force: forces.normal,
            rotation: total.rotation[k],
            elongation: 0.5 * elastic.elongation + plastic.elongation[k],
            plastic_rotation: plastic.rotation[k],
            plastic_elongation: plastic.elongation[k],
            utilisation: bar.surface.utilisation(forces.moment[k], forces.normal),
            state: hinge_state(flowing[k], bar.flows(plastic, k)),
        };
        let Self {
            forces: f,
            plastic: p,
            flowing: w,
            ..
        } = self;
        let below = |k| {
            hinge(
                &model.below,
                &f.below,
                &p.below,
                &total.below,
                &elastic.below,
                &w.below,
                k,
            )
        };
        let above = |k| {
            hinge(
                &model.above,
                &f.above,
                &p.above,
                &total.above,
                &elastic.above,
                &w.above,
                k,
            )
        };
        [below(0), above(0), above(1), below(1)]
    }
}

fn hinge_state(flowing: bool, has_flowed: bool) -> HingeState {
    match (flowing, has_flowed) {
        (true, _) => HingeState::Plastic,
        (false, true) => HingeState::Unloaded,
        (false, false) => HingeState::Elastic,
    }
}
