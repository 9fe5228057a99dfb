//! Strain rate and hardening of the hinges: the factors by which they enlarge the yield surfaces.
//!
//! The rate is kinematic. The outer fibre of hinge 3 is strained at `(h/2) |theta_3'| / L_h`, that of hinge 2 at
//! `(h/2) |theta_2'| / L_h`, those of 1a and 1b at `(h/2) |theta_2' + theta_3'| / (2 L_h)`. It passes the low-pass filter
//! `tau r' = rate - r`, which is integrated exactly for a rate that is constant over a part of a step; the dynamic increase
//! factor `D` is a function of `r`. `D` multiplies both resistances of its hinge.
//!
//! The accumulated plastic rotation of a hinge enlarges its whole surface by `H`, too: `backbone.rs`.
//!
//! `D` is predicted before the equations of a part are solved and held while they are; the filter then advances with the true
//! increments. A web that yields in shear has the strain rate `|theta'| / sqrt 3` of its bar's chord, and its hardening
//! grows linearly with its plastic shear angle, up to a cap.

use serde::{Deserialize, Serialize};

use super::backbone::{Backbone, HingeFactors, StaticStrength};
use super::bar::{BarForces, PerBar, PlasticFlow};
use super::bar_strength::BarStrength;
use super::base_resistance::BaseResistance;
use super::geometry::Chord;
use super::properties::{ColumnProperties, RateLaw, RateProperties};
use super::shear::{SliderStrength, axial_share};
use super::web_strength::{LEAST_RESISTANCE, WebLaw, WebState, web_rate};
use super::yield_surface::YieldSurface;

/// What the strength of one hinge remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeStrength {
    /// `r`: filtered strain rate of the outer fibre \[1/s\], >= 0.
    pub strain_rate: f64,
    /// `theta_p`: sum of the absolute plastic rotations since the column was new \[rad\].
    pub accumulated_rotation: f64,
    /// Its mean rate over the last part of a step \[rad/s\].
    pub(crate) flow_rate: f64,
    /// The factors with which the last stress was returned.
    pub factors: HingeFactors,
}

impl HingeStrength {
    /// Adds a plastic rotation \[rad\].
    pub(crate) fn accumulate(&mut self, rotation: f64) {
        self.accumulated_rotation += rotation.abs();
    }

    /// At the event of an impact the filter starts from zero.
    pub(crate) fn begin(&mut self) {
        self.strain_rate = 0.0;
        self.flow_rate = 0.0;
    }
}

/// The webs of both bars.
pub(crate) type Webs = PerBar<WebState>;

/// The strength of all hinges, per bar: at the impact point, at the other end.
pub(crate) type Strengths = PerBar<[HingeStrength; 2]>;

/// The factors of all hinges.
pub(crate) type Factors = PerBar<[HingeFactors; 2]>;

/// The strength of all hinges over one part of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prediction {
    /// The factors before any flow.
    factors: Factors,
    /// Growth of the moments, relative to them, with the plastic rotation of the part \[1/rad\].
    growth: PerBar<[f64; 2]>,
    /// The dynamic increase factors of the webs, and their strength before any flow.
    webs: PerBar<(f64, SliderStrength)>,
    /// What the webs are held at, as [`WebState::held`].
    held: PerBar<f64>,
    /// Whether a hinge of the bar has flowed over the last part of a step.
    hinges_flow: PerBar<bool>,
    /// Whether the base slips before the web of the lower bar yields, towards a positive and a negative sum of the moments.
    slips: [bool; 2],
}

/// At which instant of a part of a step the stress is returned to the yield surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Collocation {
    Middle,
    End,
}

/// Constants of the strength of a column's hinges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StrengthLaw {
    rate: Option<RateFilter>,
    /// Undamaged surface of all hinges.
    surface: YieldSurface,
    /// Of the hinges of each bar.
    backbones: PerBar<Backbone>,
    /// Of the web of each bar; `None` where they do not yield and no base slips.
    webs: Option<PerBar<WebLaw>>,
    /// What caps the moment of hinge 3 and the shear of the lower bar.
    connection: Option<BaseResistance>,
}

/// Constants of the dynamic increase factor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RateFilter {
    law: RateLaw,
    max_factor: f64,
    /// `1/tau` \[1/s\].
    per_time_constant: f64,
    /// Strain of the outer fibre per rotation of a hinge at an end of the column, `h / (2 L_h)` \[1/rad\].
    strain_at_end: f64,
    /// How the gain of a web follows from that of the hinge at the end of its bar: times the first, plus the second.
    web_gain: [f64; 2],
    /// A whole step \[s\], and by how much the filter follows the rate in half of it and in all of it.
    step_secs: f64,
    followed: [f64; 2],
}

impl StrengthLaw {
    /// The law of a column; `None` where the resistances are constant.
    pub fn new(p: &ColumnProperties, step_secs: f64) -> Option<Self> {
        let web_hardens = p.shear.is_some_and(|shear| shear.hardening > 0.0);
        if p.rate.is_none()
            && p.hardening_ratio == 0.0
            && p.softening.is_none()
            && p.base_connection.is_none()
            && !web_hardens
        {
            return None;
        }
        let [below, above] = p.clear_lengths();
        Some(Self {
            rate: p.rate.as_ref().map(|rate| RateFilter::new(rate, step_secs)),
            surface: YieldSurface::new(p.resistance_moment, p.resistance_axial, p.yield_surface),
            backbones: PerBar {
                below: Backbone::new(p, below),
                above: Backbone::new(p, above),
            },
            webs: match (&p.shear, &p.base_connection) {
                (Some(shear), _) => Some(PerBar {
                    below: WebLaw::new(shear, below),
                    above: WebLaw::new(shear, above),
                }),
                (None, Some(connection)) => Some(PerBar {
                    below: WebLaw::unyielding(connection.anchor_shear, below),
                    above: WebLaw::unyielding(connection.anchor_shear, above),
                }),
                (None, None) => None,
            },
            connection: p.base_connection,
        })
    }

    /// The factors with which a stress is returned in a part of `secs` \[s\] that begins with the forces `forces` and the chord
    /// `below` of the lower bar, for the turns of the chords \[rad\] that are expected over it.
    pub fn predict(
        &self,
        (from, webs, forces): (&Strengths, &Webs, &PerBar<BarForces>),
        (below, turns): (&Chord, &PerBar<f64>),
        secs: f64,
        collocation: Collocation,
    ) -> Prediction {
        let share = match collocation {
            Collocation::Middle => 0.5,
            Collocation::End => 1.0,
        };
        let free = match &self.rate {
            None => [1.0; 3],
            Some(rate) => {
                let followed = rate.followed(secs, collocation);
                let rates = rate.rates(turns, secs);
                [
                    (from.below[0].strain_rate, rates.joint),
                    (from.below[1].strain_rate, rates.base),
                    (from.above[1].strain_rate, rates.top),
                ]
                .map(|(filtered, rate_now)| {
                    rate.law.factor(filtered + followed * (rate_now - filtered))
                })
            }
        };
        let [joint, base, top] = match &self.rate {
            None => free,
            Some(rate) => free.map(|factor| factor.min(rate.max_factor)),
        };
        let factors = |dynamic: [f64; 2], backbone: &Backbone, hinges: &[HingeStrength; 2]| {
            [0, 1].map(|k| {
                let goes_on = share * secs * hinges[k].flow_rate;
                backbone.factors(dynamic[k], hinges[k].accumulated_rotation, goes_on)
            })
        };
        let factors = PerBar {
            below: factors([joint, base], &self.backbones.below, &from.below),
            above: factors([joint, top], &self.backbones.above, &from.above),
        };
        let growth = |backbone: &Backbone,
                      hinges: &[HingeStrength; 2],
                      factors: &[HingeFactors; 2],
                      turn: f64,
                      normal: f64| {
            [0, 1].map(|k| {
                // A hinge that is about to flow rotates by some part of the turn of its bar.
                let expected = share * (secs * hinges[k].flow_rate).max(0.5 * turn.abs());
                backbone.growth(
                    hinges[k].accumulated_rotation,
                    expected,
                    (&self.surface, normal),
                    &factors[k],
                )
            })
        };
        let mut prediction = Prediction {
            growth: PerBar {
                below: growth(
                    &self.backbones.below,
                    &from.below,
                    &factors.below,
                    turns.below,
                    forces.below.normal,
                ),
                above: growth(
                    &self.backbones.above,
                    &from.above,
                    &factors.above,
                    turns.above,
                    forces.above.normal,
                ),
            },
            factors,
            webs: self.web_strengths((webs, turns), (secs, collocation), [free[1], free[2]]),
            held: PerBar::default(),
            hinges_flow: PerBar {
                below: from.below.iter().any(|hinge| hinge.flow_rate > 0.0),
                above: from.above.iter().any(|hinge| hinge.flow_rate > 0.0),
            },
            slips: [false; 2],
        };
        let base = &mut prediction.factors.below[1];
        if self.cap_base(base, forces) {
            prediction.growth.below[1] = 0.0;
        }
        let web = &mut prediction.webs.below.1;
        prediction.slips = self.cap_slip(web, &forces.below, below);
        prediction
    }

    /// The dynamic factors of the webs and their strength before any flow, as [`StrengthLaw::predict`]. `ends` are the dynamic
    /// factors, without an upper limit, of the hinges at the ends of the column.
    fn web_strengths(
        &self,
        (webs, turns): (&Webs, &PerBar<f64>),
        (secs, collocation): (f64, Collocation),
        ends: [f64; 2],
    ) -> PerBar<(f64, SliderStrength)> {
        let Some(laws) = &self.webs else {
            let undamaged = (1.0, SliderStrength::UNDAMAGED);
            return PerBar {
                below: undamaged,
                above: undamaged,
            };
        };
        let strength = |law: &WebLaw, web: &WebState, turn: f64, end: f64| {
            let dynamic = self.rate.as_ref().map_or(1.0, |rate| {
                if end > 1.0 {
                    return rate.factor_of_web(end);
                }
                let followed = rate.followed(secs, collocation);
                let rate_now = web_rate(turn, secs);
                rate.factor(web.strain_rate + followed * (rate_now - web.strain_rate))
            });
            (dynamic, law.strength(web, dynamic))
        };
        PerBar {
            below: strength(&laws.below, &webs.below, turns.below, ends[0]),
            above: strength(&laws.above, &webs.above, turns.above, ends[1]),
        }
    }

    /// Advances the filter over a part of `secs` \[s\] in which the chords turned by `turns` \[rad\], and records the factors
    /// with which it ended and `factor` times the flow of its bars.
    pub fn advance(
        &self,
        (strengths, webs): (&mut Strengths, &mut Webs),
        turns: &PerBar<f64>,
        secs: f64,
        prediction: &Prediction,
        flow: PerBar<&PlasticFlow>,
        factor: f64,
    ) {
        let per_sec = factor / secs;
        let Prediction {
            factors,
            growth,
            webs: predicted,
            held,
            slips,
            ..
        } = prediction;
        let slips =
            flow.below.shear_angle != 0.0 && slips[usize::from(flow.below.shear_angle < 0.0)];
        for (hinges, factors, growth, flow) in [
            (
                &mut strengths.below,
                &factors.below,
                &growth.below,
                flow.below,
            ),
            (
                &mut strengths.above,
                &factors.above,
                &growth.above,
                flow.above,
            ),
        ] {
            for k in 0..2 {
                let rotation = flow.rotation[k].abs();
                hinges[k].factors = factors[k];
                hinges[k].factors.moment *= 1.0 + growth[k] * rotation;
                hinges[k].flow_rate = per_sec * rotation;
            }
        }
        if let Some(laws) = &self.webs {
            for (web, law, (dynamic, strength), held, flow, is_slip) in [
                (
                    &mut webs.below,
                    &laws.below,
                    predicted.below,
                    held.below,
                    flow.below,
                    slips,
                ),
                (
                    &mut webs.above,
                    &laws.above,
                    predicted.above,
                    held.above,
                    flow.above,
                    false,
                ),
            ] {
                web.dynamic_gain = dynamic - 1.0;
                web.held = match held > 0.0 && flow.shear_angle != 0.0 {
                    true => strength.hardened(flow.shear_angle),
                    false => held,
                };
                if !is_slip {
                    law.harden(web, factor * flow.shear_angle);
                    continue;
                }
                web.slip += factor * flow.shear_angle * law.length;
                // Whether it was more than round-off is known.
                web.slipping |= std::mem::take(&mut web.flowing);
            }
        }
        self.follow((strengths, webs), turns, secs);
    }

    /// Advances the filter alone.
    pub fn follow(
        &self,
        (strengths, webs): (&mut Strengths, &mut Webs),
        turns: &PerBar<f64>,
        secs: f64,
    ) {
        let Some(rate) = &self.rate else { return };
        let followed = rate.followed(secs, Collocation::End);
        let rates = rate.rates(turns, secs);
        let follow = |hinge: &mut HingeStrength, rate: f64| {
            hinge.strain_rate += followed * (rate - hinge.strain_rate);
        };
        follow(&mut strengths.below[0], rates.joint);
        follow(&mut strengths.above[0], rates.joint);
        follow(&mut strengths.below[1], rates.base);
        follow(&mut strengths.above[1], rates.top);
        if self.webs.is_some() {
            for (web, turn) in [
                (&mut webs.below, turns.below),
                (&mut webs.above, turns.above),
            ] {
                web.strain_rate += followed * (web_rate(turn, secs) - web.strain_rate);
            }
        }
    }

    /// The factors of hinges that do not flow under the forces `forces`, with the strain rate to which the filter has come.
    pub fn refresh(&self, strengths: &mut Strengths, webs: &mut Webs, forces: &PerBar<BarForces>) {
        for (backbone, hinges) in [
            (&self.backbones.below, &mut strengths.below),
            (&self.backbones.above, &mut strengths.above),
        ] {
            for hinge in hinges {
                let rate = self.rate.as_ref();
                hinge.flow_rate = 0.0;
                let dynamic = rate.map_or(1.0, |rate| rate.factor(hinge.strain_rate));
                hinge.factors = backbone.factors(dynamic, hinge.accumulated_rotation, 0.0);
            }
        }
        self.cap_base(&mut strengths.below[1].factors, forces);
        if self.webs.is_some() {
            for web in [&mut webs.below, &mut webs.above] {
                let rate = self.rate.as_ref();
                web.dynamic_gain = rate.map_or(0.0, |rate| rate.factor(web.strain_rate) - 1.0);
                web.held = 0.0;
            }
        }
    }

    /// Webs that have sheared to these plastic angles \[rad\] at once.
    pub fn harden(&self, webs: &mut Webs, angles: &PerBar<f64>) {
        let Some(laws) = &self.webs else { return };
        laws.below.harden(&mut webs.below, angles.below);
        laws.above.harden(&mut webs.above, angles.above);
    }

    /// The strength of hinges without strain rate over an increment in which they are expected to rotate by `expected` \[rad\],
    /// after the accumulated rotations `accumulated` \[rad\] and under the forces `forces`; `None` where it is that of an undamaged
    /// column whatever they have rotated.
    pub fn at_rest(
        &self,
        accumulated: &PerBar<[f64; 2]>,
        expected: &PerBar<[f64; 2]>,
        forces: &PerBar<BarForces>,
    ) -> Option<PerBar<StaticStrength>> {
        let PerBar { below, above } = &self.backbones;
        if below.is_constant() && self.connection.is_none() {
            return None;
        }
        let mut strength = PerBar {
            below: below.at_rest(
                accumulated.below,
                expected.below,
                (&self.surface, forces.below.normal),
            ),
            above: above.at_rest(
                accumulated.above,
                expected.above,
                (&self.surface, forces.above.normal),
            ),
        };
        if self.cap_base(&mut strength.below.factors[1], forces) {
            strength.below.growth[1] = 0.0;
        }
        Some(strength)
    }

    /// The factors of hinges at rest under the forces `forces` that have rotated by these accumulated plastic rotations \[rad\].
    pub fn settle(&self, strengths: &mut Strengths, webs: &mut Webs, forces: &PerBar<BarForces>) {
        for (backbone, hinges) in [
            (&self.backbones.below, &mut strengths.below),
            (&self.backbones.above, &mut strengths.above),
        ] {
            for hinge in hinges {
                hinge.factors = backbone.factors(1.0, hinge.accumulated_rotation, 0.0);
            }
        }
        self.cap_base(&mut strengths.below[1].factors, forces);
        for web in [&mut webs.below, &mut webs.above] {
            web.dynamic_gain = 0.0;
            web.held = 0.0;
        }
    }
}

impl StrengthLaw {
    /// Caps the moment of hinge 3 by that of its connection, and tells whether it does: then nothing hardens within a part of a
    /// step. As softening does, it changes the moment alone, which is held over the part, at the normal force of its beginning.
    fn cap_base(&self, factors: &mut HingeFactors, forces: &PerBar<BarForces>) -> bool {
        let Some(connection) = &self.connection else {
            return false;
        };
        let normal = forces.below.normal;
        let most = connection.moment(normal);
        let capped = factors.capped(&self.surface, normal, most);
        let is_capped = capped != *factors;
        *factors = capped;
        is_capped
    }

    /// Caps the resistance of the web of the lower bar by that of the base against slipping, `|(M_1a + M_3)/l + N v_1/l| <= V_R(N)`
    /// on its chord, and tells in which directions it does, as [`StrengthLaw::cap_base`]. Both are in series and turn the bar alike,
    /// so that the weaker one flows.
    fn cap_slip(&self, web: &mut SliderStrength, forces: &BarForces, chord: &Chord) -> [bool; 2] {
        let (Some(connection), Some(laws)) = (&self.connection, &self.webs) else {
            return [false; 2];
        };
        let normal = forces.normal;
        // The share that the normal force leaves to a web that yields multiplies its factor once more.
        let share = match laws.below.yields() {
            true => axial_share(self.surface.relative_axial(normal).abs()),
            false => 1.0,
        };
        let gradient = chord.gradient();
        let of_web = laws.below.force * share * laws.below.length * gradient.angle_v;
        // Along the undeformed column it presses on the foundation, which makes the friction.
        let most = connection.shear(gradient.forces(forces).x);
        let leaning = normal * gradient.length_v;
        let limits = [most - leaning, most + leaning];
        let mut slips = [false; 2];
        for (k, limit) in limits.into_iter().enumerate() {
            let factor = (limit / of_web).max(LEAST_RESISTANCE);
            // A chord across the column leaves the moments no shear.
            slips[k] = of_web > 0.0 && factor < web.factor[k];
            if slips[k] {
                web.factor[k] = factor;
                web.growth[k] = 0.0;
            }
        }
        slips
    }
}

/// Strain rates of the outer fibres \[1/s\]; 1a and 1b share one.
struct Rates {
    joint: f64,
    base: f64,
    top: f64,
}

impl RateFilter {
    fn new(rate: &RateProperties, step_secs: f64) -> Self {
        let mut filter = Self {
            law: rate.law,
            max_factor: rate.max_factor,
            per_time_constant: 1.0 / rate.time_constant,
            strain_at_end: 0.5 * rate.section_height / rate.hinge_length,
            web_gain: [1.0, 0.0],
            step_secs,
            followed: [0.0; 2],
        };
        // Both turn with the chord of the bar and pass the same linear filter, so that the strain rate of the web is a constant
        // multiple of that of the hinge.
        let times = web_rate(1.0, 1.0) / filter.strain_at_end;
        filter.web_gain = match rate.law {
            RateLaw::CowperSymonds { q, .. } => [libm::pow(times, 1.0 / q), 0.0],
            RateLaw::Logarithmic { c, .. } => [1.0, c * libm::log(times)],
        };
        filter.followed = [0.5, 1.0].map(|share| filter.followed_over(share * step_secs));
        filter
    }

    /// By which share of its distance the filter approaches a constant rate within `secs` \[s\].
    fn followed_over(&self, secs: f64) -> f64 {
        -libm::expm1(-secs * self.per_time_constant)
    }

    fn followed(&self, secs: f64, collocation: Collocation) -> f64 {
        let [half, whole] = self.followed;
        match collocation {
            Collocation::Middle if secs == self.step_secs => half,
            Collocation::Middle => self.followed_over(0.5 * secs),
            Collocation::End if secs == self.step_secs => whole,
            Collocation::End => self.followed_over(secs),
        }
    }

    fn rates(&self, turns: &PerBar<f64>, secs: f64) -> Rates {
        let per_turn = self.strain_at_end / secs;
        Rates {
            joint: 0.5 * per_turn * (turns.below + turns.above).abs(),
            base: per_turn * turns.below.abs(),
            top: per_turn * turns.above.abs(),
        }
    }

    /// `D` of a web, from that of the hinge at the end of its bar, which exceeds 1 and has no upper limit.
    // Measured: without a power or a logarithm of its own a step with strain rate takes 3 % less.
    fn factor_of_web(&self, end: f64) -> f64 {
        let [times, plus] = self.web_gain;
        let gain = times * (end - 1.0) + plus;
        (1.0 + gain.max(0.0)).min(self.max_factor)
    }

    /// `D` at a filtered strain rate \[1/s\].
    fn factor(&self, rate: f64) -> f64 {
        self.law.factor(rate).min(self.max_factor)
    }
}

impl Prediction {
    /// The factors of the hinges of both bars.
    pub fn factors(&self) -> PerBar<[HingeFactors; 2]> {
        self.factors
    }

    /// The strength of the webs of both bars before any flow.
    pub fn webs(&self) -> PerBar<SliderStrength> {
        PerBar {
            below: self.webs.below.1,
            above: self.webs.above.1,
        }
    }

    /// The strengths of both bars.
    pub fn strengths(&self) -> PerBar<Option<BarStrength>> {
        let strength = |factors: &[HingeFactors; 2], growth: &[f64; 2], slider, hinges_flow| {
            let [first, second] = factors;
            let mut strength = BarStrength::new(
                [first.whole(), second.whole()],
                [first.moment, second.moment],
                *growth,
                slider,
            );
            if let Some(strength) = &mut strength {
                strength.hinges_flow = hinges_flow;
            }
            strength
        };
        let (webs, flows) = (self.webs(), &self.hinges_flow);
        PerBar {
            below: strength(
                &self.factors.below,
                &self.growth.below,
                webs.below,
                flows.below,
            ),
            above: strength(
                &self.factors.above,
                &self.growth.above,
                webs.above,
                flows.above,
            ),
        }
    }

    /// With no factor below that with which the last stress was returned.
    /// No web bears less than `used` times the resistance of an undamaged one in either direction.
    pub fn not_below(mut self, last: &Strengths, webs: &Webs, used: &PerBar<f64>) -> Self {
        for (factors, last) in [
            (&mut self.factors.below, &last.below),
            (&mut self.factors.above, &last.above),
        ] {
            for k in 0..2 {
                factors[k] = factors[k].largest(&last[k].factors);
            }
        }
        self.held = *used;
        for ((dynamic, strength), last, used) in [
            (&mut self.webs.below, &webs.below, used.below),
            (&mut self.webs.above, &webs.above, used.above),
        ] {
            let ratio = (last.dynamic_factor() / *dynamic).max(1.0);
            *dynamic *= ratio;
            strength.factor = strength.factor.map(|factor| (ratio * factor).max(used));
            strength.growth = strength.growth.map(|growth| ratio * growth);
            strength.most *= ratio;
        }
        self
    }
}
