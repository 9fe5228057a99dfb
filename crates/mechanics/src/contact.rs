//! Unilateral contact and Newton's impact law (Eqs 33-38).
//!
//! Sign: the paper's gap `g_N = v_c - v_1` (Eq 33) opens when an impactor with a positive velocity approaches. Here `v`
//! is positive in the impactor's direction of travel and the gap is `v_1 - v_c`: positive while open, closing while
//! `v_c' > v_1'`.
//!
//! The schemes know what strikes the column only by the methods of [`Impactor`]: its gap, its closing speed and energy,
//! what it adds to the equation of motion of the impact point ([`Coupling`], [`ChainPart`]), touch, impact impulse and release.
//! A deformable vehicle strikes without an impact impulse: its front spring transmits a force that begins at zero.

use serde::{Deserialize, Serialize};

use super::chain::{Chain, ChainPart, ChainPoint, Crushed};
use super::impact::Impact;
use super::model::Model;
use super::properties::is_zero;
use super::vehicle::Vehicle;

/// A closing speed whose rebound is below this fraction of the impactor's speed of arrival does not rebound: contact is
/// taken as persistent from there on, because rebounds with restitution accumulate, infinitely many in finite time.
pub const PERSISTENT_CONTACT_FRACTION: f64 = 1e-4;

/// Impact impulses of one response that follow Newton's law with the restitution given; those after them are perfectly
/// inelastic. A restitution near 1 lets the light impact point rattle before a heavy impactor, tens of times per step and
/// without end, which is persistent contact in all but name. With a restitution of 0.9 one closing of contact makes 90
/// impact impulses.
pub const MAX_ELASTIC_IMPACT_IMPULSES: u32 = 2_000;

/// What strikes the column, on its way: a rigid mass or a deformable vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Impactor {
    /// The impact as it was at the event.
    pub impact: Impact,
    /// `v_c` \[m\]; of a deformable vehicle the contact face.
    pub position: f64,
    /// Its rate \[m/s\]; of a deformable vehicle the velocity of the centre of mass.
    pub velocity: f64,
    /// Whether contact is closed: a deformable vehicle transmits a force.
    pub closed: bool,
    /// First touch, since the event \[s\].
    pub touched_at: Option<f64>,
    /// Last separation, since the event \[s\].
    pub released_at: Option<f64>,
    /// Where and when its free flight began: positions in flight are computed from here, not accumulated.
    flight: Flight,
    /// Masses and springs of a deformable vehicle, if the impact has one.
    chain: Option<Chain>,
}

/// Beginning of a free flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Flight {
    position: f64,
    step: u64,
    offset_secs: f64,
    /// Velocity at its beginning where a transverse force changes it; otherwise 0, and the velocity of the impactor holds
    /// throughout \[m/s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    velocity: f64,
}

impl Flight {
    fn new(impact: &Impact, position: f64, velocity: f64, step: u64, offset_secs: f64) -> Self {
        let is_pushed = impact.transverse_force != 0.0;
        Self {
            position,
            step,
            offset_secs,
            velocity: if is_pushed { velocity } else { 0.0 },
        }
    }
}

/// What an impactor adds to the equation of motion of the impact point over one part of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Coupling {
    /// Mass that moves with the impact point \[kg\].
    pub mass: f64,
    /// Constant force on it \[N\].
    pub force: f64,
}

impl Impactor {
    /// An impactor at its gap from a column at `v1` \[m\], at the beginning of step 0.
    pub(crate) fn new(impact: Impact, v1: f64) -> Self {
        let position = v1 - impact.gap;
        Self {
            impact,
            position,
            velocity: impact.velocity,
            closed: false,
            touched_at: None,
            released_at: None,
            flight: Flight::new(&impact, position, impact.velocity, 0, 0.0),
            chain: impact
                .vehicle
                .as_ref()
                .map(|vehicle| Chain::new(vehicle, impact.velocity, impact.gap)),
        }
    }

    /// The deformable vehicle and its state; `None` for a rigid mass.
    pub fn vehicle(&self) -> Option<(&Vehicle, &Chain)> {
        self.impact.vehicle.as_ref().zip(self.chain.as_ref())
    }

    /// Whether it is a deformable vehicle.
    pub(crate) fn is_deformable(&self) -> bool {
        self.chain.is_some()
    }

    /// A deformable vehicle over a part of a step of `secs` seconds; `None` for a rigid mass.
    #[inline]
    pub(crate) fn chain_part(&self, secs: f64) -> Option<ChainPart<'_>> {
        let (vehicle, chain) = self.vehicle()?;
        Some(ChainPart::new(
            vehicle,
            chain,
            self.impact.acceleration(),
            secs,
        ))
    }

    /// Moves a deformable vehicle to the end of a part of a step that has been solved, which began `offset_secs` into step
    /// `step` and took `secs` \[s\], where the column is at `v1` \[m\].
    pub(crate) fn follow(
        &mut self,
        model: &Model,
        (step, offset_secs, secs): (u64, f64, f64),
        v1: f64,
        point: &ChainPoint,
    ) -> Crushed {
        let (Some(vehicle), Some(chain)) = (&self.impact.vehicle, &mut self.chain) else {
            return Crushed::default();
        };
        let crushed = chain.follow(vehicle, self.impact.acceleration(), secs, point);
        self.velocity = chain.mean_velocity(vehicle);
        self.position = v1 - chain.gap();
        self.closed = chain.contact_force(vehicle) > 0.0;
        let instant = |share: f64| model.time_of_step(step) + (offset_secs + share * secs);
        self.touched_at = self.touched_at.or(crushed.touched.map(instant));
        self.released_at = crushed.released.map(instant).or(self.released_at);
        crushed
    }

    /// Takes the state in which long elastic steps have left it at the beginning of step `step`, where the column is at `v1`
    /// \[m\]: `chain` of a deformable vehicle, the free flight of a rigid mass.
    pub(crate) fn arrive(&mut self, model: &Model, step: u64, v1: f64, chain: Option<Chain>) {
        let (Some(vehicle), Some(chain)) = (&self.impact.vehicle, chain) else {
            self.fly(model, step, 0.0);
            return;
        };
        self.velocity = chain.mean_velocity(vehicle);
        self.position = v1 - chain.gap();
        let closed = chain.contact_force(vehicle) > 0.0;
        let now = model.time_of_step(step);
        if chain.springs[0].largest > 0.0 {
            self.touched_at.get_or_insert(now);
        }
        if self.closed && !closed {
            self.released_at = Some(now);
        }
        self.closed = closed;
        self.chain = Some(chain);
    }

    /// Distance to a column at `v1` \[m\].
    pub(crate) fn gap(&self, v1: f64) -> f64 {
        match &self.chain {
            Some(chain) => chain.gap(),
            None => v1 - self.position,
        }
    }

    /// Work that the transverse force does on its way to where it is, from where its centre of mass would be at the undeformed
    /// column, where the column is at `v1` \[m\] \[J\].
    pub(crate) fn transverse_work(&self, v1: f64) -> f64 {
        if self.impact.transverse_force == 0.0 {
            return 0.0;
        }
        let position = match self.vehicle() {
            Some((vehicle, chain)) => v1 + chain.mean_crush(vehicle),
            None => self.position,
        };
        self.impact.transverse_force * position
    }

    /// Whether it will never touch a column at rest again.
    pub(crate) fn recedes_for_good(&self) -> bool {
        if self.impact.transverse_force > 0.0 {
            // It comes back.
            return false;
        }
        match self.vehicle() {
            Some((vehicle, chain)) => chain.recedes_for_good(vehicle),
            None => self.velocity <= 0.0,
        }
    }

    /// Closing speed against a column that moves at `v1_rate` \[m/s\]; negative while they separate.
    pub(crate) fn closing_speed(&self, v1_rate: f64) -> f64 {
        self.velocity - v1_rate
    }

    /// Kinetic energy, and the elastic energy of a deformable vehicle \[J\].
    #[inline]
    pub(crate) fn energies(&self) -> (f64, f64) {
        match self.vehicle() {
            Some((vehicle, chain)) => {
                (chain.kinetic_energy(vehicle), chain.elastic_energy(vehicle))
            }
            None => (0.5 * self.impact.mass * self.velocity * self.velocity, 0.0),
        }
    }

    /// Contact force of a deformable vehicle \[N\]; 0 for a rigid mass.
    pub(crate) fn crush_force(&self) -> f64 {
        self.vehicle()
            .map_or(0.0, |(vehicle, chain)| chain.contact_force(vehicle))
    }

    /// In persistent contact a rigid impactor moves with the impact point as one mass.
    pub(crate) fn coupling(&self) -> Coupling {
        let moves_along = self.closed && self.chain.is_none();
        let (mass, force) = match moves_along {
            true => (self.impact.mass, self.impact.transverse_force),
            false => (0.0, 0.0),
        };
        Coupling { mass, force }
    }

    /// The coupling that reverses the closing speed to `-restitution` times its value within `secs`.
    pub(crate) fn rebound_coupling(&self, closing_speed: f64, secs: f64) -> Coupling {
        let Impact {
            mass,
            restitution,
            transverse_force,
            ..
        } = self.impact;
        Coupling {
            mass,
            force: mass * (1.0 + restitution) * closing_speed / secs + transverse_force,
        }
    }

    /// Force of persistent contact \[N\], where the column resists with `resistance` \[N\]: both masses share the
    /// acceleration that it and the transverse force give them. Negative where they would separate.
    pub(crate) fn contact_force(&self, model: &Model, resistance: f64) -> f64 {
        if !self.closed {
            return 0.0;
        }
        let (mass, own) = (self.impact.mass, model.impact_point_mass);
        (resistance * mass + self.impact.transverse_force * own) / (mass + own)
    }

    /// Takes a new velocity \[m/s\] after `secs` \[s\] and returns the impulse that the column took from the impactor
    /// \[N s\].
    pub(crate) fn slow_down(&mut self, velocity: f64, secs: f64) -> f64 {
        let Impact {
            mass,
            transverse_force,
            ..
        } = self.impact;
        let impulse = mass * (self.velocity - velocity) + transverse_force * secs;
        self.velocity = velocity;
        impulse
    }

    /// Takes an impulse \[N s\] against its direction of travel.
    pub(crate) fn push_back(&mut self, impulse: f64) {
        self.velocity -= impulse / self.impact.mass;
    }

    /// The impact impulse of an impact with the impact point at `closing_speed` \[m/s\].
    pub(crate) fn impact_impulse(
        &self,
        model: &Model,
        closing_speed: f64,
        restitution: f64,
    ) -> ImpactImpulse {
        let mass = self.impact.mass;
        impact_impulse(mass, model.impact_point_mass, closing_speed, restitution)
    }

    /// Moves it by the little by which it lies away from the column at `v1` \[m\]: the round-off of the instant of an event, or
    /// what it penetrates after the last event of a step. The work of the transverse force on that way changes its velocity.
    pub(crate) fn reach(&mut self, v1: f64) {
        let square = self.velocity * self.velocity;
        let work = 2.0 * self.impact.acceleration() * (v1 - self.position);
        if work != 0.0 {
            self.velocity = (square + work).max(0.0).sqrt().copysign(self.velocity);
        }
        self.position = v1;
    }

    /// Records a touch `offset_secs` into step `step` \[s\].
    pub(crate) fn touch(&mut self, model: &Model, step: u64, offset_secs: f64) {
        self.touched_at
            .get_or_insert(model.time_of_step(step) + offset_secs);
    }

    /// Separates from the column `offset_secs` into step `step` \[s\] and begins a free flight.
    pub(crate) fn release(&mut self, model: &Model, step: u64, offset_secs: f64) {
        self.closed = false;
        self.released_at = Some(model.time_of_step(step) + offset_secs);
        self.flight = Flight::new(
            &self.impact,
            self.position,
            self.velocity,
            step,
            offset_secs,
        );
    }

    /// Position in free flight `offset_secs` into step `step` \[m\].
    pub(crate) fn position_in_flight(&self, model: &Model, step: u64, offset_secs: f64) -> f64 {
        let secs = self.secs_of_flight(model, step, offset_secs);
        if self.impact.transverse_force == 0.0 {
            return self.flight.position + self.velocity * secs;
        }
        let mean = self.flight.velocity + 0.5 * self.impact.acceleration() * secs;
        self.flight.position + mean * secs
    }

    fn secs_of_flight(&self, model: &Model, step: u64, offset_secs: f64) -> f64 {
        let steps = model.time_of_step(step - self.flight.step);
        steps + (offset_secs - self.flight.offset_secs)
    }

    /// Moves a rigid impactor in free flight to `offset_secs` into step `step` \[s\].
    pub(crate) fn fly(&mut self, model: &Model, step: u64, offset_secs: f64) {
        self.position = self.position_in_flight(model, step, offset_secs);
        self.velocity = self.velocity_in_flight(model, step, offset_secs);
    }

    /// Velocity in free flight `offset_secs` into step `step` \[m/s\].
    pub(crate) fn velocity_in_flight(&self, model: &Model, step: u64, offset_secs: f64) -> f64 {
        if self.impact.transverse_force == 0.0 {
            return self.velocity;
        }
        let secs = self.secs_of_flight(model, step, offset_secs);
        self.flight.velocity + self.impact.acceleration() * secs
    }

    /// Lets it fly freely to the beginning of step `step`, towards a column that rests at `v1` \[m\].
    pub(crate) fn coast(&mut self, model: &Model, step: u64, v1: f64) {
        self.fly(model, step, 0.0);
        if let Some(chain) = &mut self.chain {
            chain.come_near(v1 - self.position);
            if self.impact.transverse_force != 0.0 {
                chain.velocity = chain.velocity.map(|_| self.velocity);
            }
        }
    }

    /// Restitution at a closing speed: Newton's, or 0 where the rebound would be too small to follow.
    pub(crate) fn effective_restitution(&self, closing_speed: f64) -> f64 {
        let rebound = self.impact.restitution * closing_speed;
        if rebound < PERSISTENT_CONTACT_FRACTION * self.impact.arrival_velocity() {
            0.0
        } else {
            self.impact.restitution
        }
    }
}

/// An impact impulse between `m_c` and `m_1` by Newton's law (Eq 36).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImpactImpulse {
    /// `Lambda_N` \[N s\].
    pub impulse: f64,
    /// Energy lost \[J\].
    pub loss: f64,
}

/// The impact impulse of two masses \[kg\] that close at `closing_speed` \[m/s\].
fn impact_impulse(
    impactor_mass: f64,
    column_mass: f64,
    closing_speed: f64,
    restitution: f64,
) -> ImpactImpulse {
    let reduced = impactor_mass * column_mass / (impactor_mass + column_mass);
    ImpactImpulse {
        impulse: (1.0 + restitution) * reduced * closing_speed,
        loss: 0.5 * (1.0 - restitution * restitution) * reduced * closing_speed * closing_speed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_first_impact_impulse() {
        let p = impact_impulse(1500.0, 70.1 * 4.0 / 3.0, 10.0, 0.0);
        assert!((p.impulse - 879.842691).abs() < 1e-5, "{}", p.impulse);
        assert!((p.loss - 4399.213454941).abs() < 1e-6, "{}", p.loss);
    }

    #[test]
    fn an_elastic_impact_impulse_loses_nothing_and_turns_the_speed_round() {
        let (mc, m1, w) = (3.0, 2.0, 5.0);
        let p = impact_impulse(mc, m1, w, 1.0);
        assert_eq!(p.loss, 0.0);
        assert!((w - p.impulse / mc - p.impulse / m1 + w).abs() < 1e-14);
    }
}
