//! Strain rate and hardening of the hinges: the factors by which they enlarge the yield surfaces.
//!
//! The rate is kinematic. The outer fibre of hinge 3 is strained at `(h/2) |theta_3'| / L_h`, that of hinge 2 at
//! `(h/2) |theta_2'| / L_h`, those of 1a and 1b at `(h/2) |theta_2' + theta_3'| / (2 L_h)`. It passes the low-pass filter
//! `tau r' = rate - r`, which is integrated exactly for a rate that is constant over a part of a step; the dynamic increase
//! factor `D` is a function of `r`. `D` multiplies both resistances of its hinge.
//!
//! Yielding that spreads along a bar of length `L` with a linear moment and the slope `b E` after yield lets the moment grow
//! with the accumulated plastic rotation, `H = 1 + sqrt(4 b EI theta_p / (L M^p))`. `H` multiplies the moment alone.
//!
//! `D` is predicted before the equations of a part are solved and held while they are; the filter then advances with the true
//! increments. `H` grows within the part along its secant over the rotation that is expected, which settles in what
//! proportion two hinges in series (1a and 1b) share a rotation.

use serde::{Deserialize, Serialize};

use super::bar::{PerBar, PlasticFlow};
use super::properties::{ColumnProperties, RateLaw, RateProperties};
use super::strength::BarStrength;

/// Factors of the resistances of one hinge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HingeFactors {
    /// `D`: dynamic increase factor of `M^p` and `N^p`, >= 1.
    pub dynamic: f64,
    /// `H`: hardening factor of `M^p`, >= 1.
    pub hardening: f64,
}

impl Default for HingeFactors {
    fn default() -> Self {
        Self {
            dynamic: 1.0,
            hardening: 1.0,
        }
    }
}

impl HingeFactors {
    /// Moment \[N m\] and normal force \[N\] that use the virgin surface as much as the given ones use the enlarged one.
    pub(crate) fn reduced(&self, moment: f64, normal_force: f64) -> (f64, f64) {
        let moment = moment / (self.dynamic * self.hardening);
        (moment, normal_force / self.dynamic)
    }

    fn largest(&self, other: &Self) -> Self {
        Self {
            dynamic: self.dynamic.max(other.dynamic),
            hardening: self.hardening.max(other.hardening),
        }
    }
}

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

/// The strength of all hinges, per bar: at the impact point, at the other end.
pub(crate) type Strengths = PerBar<[HingeStrength; 2]>;

/// The factors of all hinges.
pub(crate) type Factors = PerBar<[HingeFactors; 2]>;

/// The strength of all hinges over one part of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prediction {
    /// The factors before any flow.
    factors: Factors,
    /// Growth of the hardening factor with the plastic rotation of the part \[1/rad\].
    slopes: PerBar<[f64; 2]>,
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
    /// `4 b EI / (L M^p)` of each bar \[1/rad\].
    hardening: PerBar<f64>,
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
    /// A whole step \[s\], and by how much the filter follows the rate in half of it and in all of it.
    step_secs: f64,
    followed: [f64; 2],
}

impl StrengthLaw {
    /// The law of a column; `None` where the resistances are constant.
    pub fn new(p: &ColumnProperties, step_secs: f64) -> Option<Self> {
        if p.rate.is_none() && p.hardening_ratio == 0.0 {
            return None;
        }
        let hardening = |length: f64| {
            4.0 * p.hardening_ratio * p.bending_stiffness / (length * p.resistance_moment)
        };
        Some(Self {
            rate: p.rate.as_ref().map(|rate| RateFilter::new(rate, step_secs)),
            hardening: PerBar {
                below: hardening(p.length_below),
                above: hardening(p.length_above),
            },
        })
    }

    /// The factors with which a stress is returned in a part of `secs` \[s\], for the turns of the chords \[rad\] that are
    /// expected over it.
    pub fn predict(
        &self,
        from: &Strengths,
        turns: &PerBar<f64>,
        secs: f64,
        collocation: Collocation,
    ) -> Prediction {
        let share = match collocation {
            Collocation::Middle => 0.5,
            Collocation::End => 1.0,
        };
        // A hinge that is about to flow rotates by some part of the turn of its bar.
        let slopes = |bar: f64, hinges: &[HingeStrength; 2], turn: f64| {
            hinges.map(|hinge| {
                let expected = share * (secs * hinge.flow_rate).max(0.5 * turn.abs());
                hardening_slope(bar, hinge.accumulated_rotation, expected)
            })
        };
        let [joint, base, top] = match &self.rate {
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
                    rate.factor(filtered + followed * (rate_now - filtered))
                })
            }
        };
        let factors = |dynamic: [f64; 2], bar: f64, hinges: &[HingeStrength; 2]| {
            [0, 1].map(|k| HingeFactors {
                dynamic: dynamic[k],
                hardening: hardening_factor(bar, hinges[k].accumulated_rotation),
            })
        };
        Prediction {
            factors: PerBar {
                below: factors([joint, base], self.hardening.below, &from.below),
                above: factors([joint, top], self.hardening.above, &from.above),
            },
            slopes: PerBar {
                below: slopes(self.hardening.below, &from.below, turns.below),
                above: slopes(self.hardening.above, &from.above, turns.above),
            },
        }
    }

    /// Advances the filter over a part of `secs` \[s\] in which the chords turned by `turns` \[rad\], and records the factors
    /// with which it ended and `factor` times the flow of its bars.
    pub fn advance(
        &self,
        strengths: &mut Strengths,
        turns: &PerBar<f64>,
        secs: f64,
        prediction: &Prediction,
        flow: PerBar<&PlasticFlow>,
        factor: f64,
    ) {
        let per_sec = factor / secs;
        let Prediction { factors, slopes } = prediction;
        for (hinges, factors, slopes, flow) in [
            (
                &mut strengths.below,
                &factors.below,
                &slopes.below,
                flow.below,
            ),
            (
                &mut strengths.above,
                &factors.above,
                &slopes.above,
                flow.above,
            ),
        ] {
            for k in 0..2 {
                let rotation = flow.rotation[k].abs();
                hinges[k].factors = factors[k];
                hinges[k].factors.hardening += slopes[k] * rotation;
                hinges[k].flow_rate = per_sec * rotation;
            }
        }
        self.follow(strengths, turns, secs);
    }

    /// Advances the filter alone.
    pub fn follow(&self, strengths: &mut Strengths, turns: &PerBar<f64>, secs: f64) {
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
    }

    /// The factors of hinges that do not flow, with the strain rate to which the filter has come.
    pub fn refresh(&self, strengths: &mut Strengths) {
        for (bar, hinges) in [
            (self.hardening.below, &mut strengths.below),
            (self.hardening.above, &mut strengths.above),
        ] {
            for hinge in hinges {
                let rate = self.rate.as_ref();
                hinge.flow_rate = 0.0;
                hinge.factors = HingeFactors {
                    dynamic: rate.map_or(1.0, |rate| rate.factor(hinge.strain_rate)),
                    hardening: hardening_factor(bar, hinge.accumulated_rotation),
                };
            }
        }
    }

    /// The factors of hinges at rest that have rotated by these accumulated plastic rotations \[rad\].
    pub fn settle(&self, strengths: &mut Strengths) {
        for (bar, hinges) in [
            (self.hardening.below, &mut strengths.below),
            (self.hardening.above, &mut strengths.above),
        ] {
            for hinge in hinges {
                hinge.factors = HingeFactors {
                    dynamic: 1.0,
                    hardening: hardening_factor(bar, hinge.accumulated_rotation),
                };
            }
        }
    }
}

/// `H = 1 + sqrt(4 b EI theta_p / (L M^p))`, with `bar = 4 b EI / (L M^p)` \[1/rad\].
fn hardening_factor(bar: f64, accumulated_rotation: f64) -> f64 {
    if bar == 0.0 {
        return 1.0;
    }
    1.0 + (bar * accumulated_rotation).sqrt()
}

/// Slope of the secant of the hardening factor over an expected plastic rotation \[1/rad\]; 0 where none is expected.
fn hardening_slope(bar: f64, accumulated_rotation: f64, expected: f64) -> f64 {
    if bar == 0.0 {
        return 0.0;
    }
    // (sqrt(b (a + e)) - sqrt(b a)) / e without cancellation.
    let sum =
        (bar * (accumulated_rotation + expected)).sqrt() + (bar * accumulated_rotation).sqrt();
    if sum > 0.0 && expected > 0.0 {
        bar / sum
    } else {
        0.0
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
            step_secs,
            followed: [0.0; 2],
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

    /// `D` at a filtered strain rate \[1/s\].
    fn factor(&self, rate: f64) -> f64 {
        self.law.factor(rate).min(self.max_factor)
    }
}

impl RateLaw {
    /// Dynamic increase factor at a strain rate \[1/s\], >= 1 and without an upper limit.
    #[must_use]
    pub fn factor(&self, rate: f64) -> f64 {
        match *self {
            Self::CowperSymonds { d, q } if rate > 0.0 => 1.0 + libm::exp(libm::log(rate / d) / q),
            Self::Logarithmic { c, reference } if rate > reference => {
                1.0 + c * libm::log(rate / reference)
            }
            Self::CowperSymonds { .. } | Self::Logarithmic { .. } => 1.0,
        }
    }
}

impl Prediction {
    /// The factors of the hinges of both bars.
    pub fn factors(&self) -> PerBar<[HingeFactors; 2]> {
        self.factors
    }

    /// The strengths of both bars.
    pub fn strengths(&self) -> PerBar<Option<BarStrength>> {
        let strength = |factors: &[HingeFactors; 2], slopes: &[f64; 2]| {
            let [first, second] = factors;
            BarStrength::new(
                [first.dynamic, second.dynamic],
                [first.hardening, second.hardening],
                *slopes,
            )
        };
        PerBar {
            below: strength(&self.factors.below, &self.slopes.below),
            above: strength(&self.factors.above, &self.slopes.above),
        }
    }

    /// With no factor below that with which the last stress was returned.
    pub fn not_below(mut self, last: &Strengths) -> Self {
        for (factors, last) in [
            (&mut self.factors.below, &last.below),
            (&mut self.factors.above, &last.above),
        ] {
            for k in 0..2 {
                factors[k] = factors[k].largest(&last[k].factors);
            }
        }
        self
    }
}
