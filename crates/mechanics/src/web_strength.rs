//! The strength of the web of one bar over a response: what it remembers, and how it hardens.

use serde::{Deserialize, Serialize};

use super::properties::{ShearProperties, is_default, is_zero};
use super::shear::SliderStrength;

/// Least resistance of a web relative to that of an undamaged one, in the direction in which kinematic hardening weakens it: an
/// unloaded web never yields.
pub(crate) const LEAST_RESISTANCE: f64 = 0.01;

/// What the web of one bar remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WebState {
    /// Filtered equivalent strain rate \[1/s\], >= 0.
    pub strain_rate: f64,
    /// Kinematic hardening relative to the resistance of an undamaged web: what it has gained against positive shear and lost
    /// against negative shear.
    pub back: f64,
    /// Dynamic increase factor with which the last stress was returned less 1, >= 0.
    pub dynamic_gain: f64,
    /// Resistance relative to that of an undamaged web that the last part of a step kept in both directions, because its beginning
    /// had used it; 0 as a rule.
    pub held: f64,
    /// Whether it flowed in the last step.
    pub flowing: bool,
    /// Work dissipated in it since the event \[J\].
    pub work: f64,
    /// Of the lower bar: how far its base has slipped since the column was new \[m\], a part of its plastic shear angle times its
    /// clear length.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub slip: f64,
    /// Whether it slipped in the last step.
    #[serde(default, skip_serializing_if = "is_default")]
    pub slipping: bool,
}

impl WebState {
    /// At the event of an impact the filter and the count of the work start from zero.
    pub(crate) fn begin(&mut self) {
        self.strain_rate = 0.0;
        self.work = 0.0;
        self.flowing = false;
        self.slipping = false;
    }

    /// Dynamic increase factor with which the last stress was returned.
    #[must_use]
    pub fn dynamic_factor(&self) -> f64 {
        1.0 + self.dynamic_gain
    }

    /// The resistance in the direction in which it is smaller, at rest and relative to that of an undamaged web.
    pub(crate) fn least(&self) -> f64 {
        (1.0 - self.back.abs()).max(LEAST_RESISTANCE)
    }

    /// The strength that bore the last stress.
    pub(crate) fn strength(&self) -> SliderStrength {
        let dynamic = self.dynamic_factor();
        SliderStrength {
            factor: [self.back, -self.back]
                .map(|back| (dynamic * (1.0 + back).max(LEAST_RESISTANCE)).max(self.held)),
            ..SliderStrength::UNDAMAGED
        }
    }
}

/// Resistance of a web that does not yield, relative to [`WebLaw::force`]: more than any bar brings upon it, and finite, so that the
/// return of a stress may multiply it.
const UNYIELDING: f64 = 1e9;

/// How the web of a bar hardens: by `growth` over the plastic shear angle, at most to `most`, relative to an undamaged one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WebLaw {
    /// \[1/rad\]
    growth: f64,
    most: f64,
    /// Resistance of an undamaged web, relative to `force`.
    undamaged: f64,
    /// `V_s` \[N\], or the scale of the slider of a bar whose web does not yield.
    pub force: f64,
    /// Clear length of the bar \[m\].
    pub length: f64,
}

impl WebLaw {
    /// Of a bar of clear length `length` \[m\].
    pub fn new(shear: &ShearProperties, length: f64) -> Self {
        let force = shear.resistance(length);
        Self {
            growth: shear.hardening / force,
            // The cap is that of the web; the flanges do not harden.
            most: match shear.max_hardening {
                0.0 => f64::INFINITY,
                most => 1.0 + (most - 1.0) * shear.web_resistance / force,
            },
            undamaged: 1.0,
            force,
            length,
        }
    }

    /// Of a bar of clear length `length` \[m\] whose web does not yield, with a slider of the scale `force` \[N\] that its base needs.
    pub fn unyielding(force: f64, length: f64) -> Self {
        Self {
            growth: 0.0,
            most: f64::INFINITY,
            undamaged: UNYIELDING,
            force,
            length,
        }
    }

    /// Whether the web yields at all.
    pub fn yields(&self) -> bool {
        self.undamaged == 1.0
    }

    /// The strength of a web before any flow.
    pub fn strength(&self, web: &WebState, dynamic: f64) -> SliderStrength {
        let hardens = self.growth > 0.0;
        let growth = dynamic * self.growth;
        // As long as only the least resistance is left, it does not grow.
        let growths = [web.back, -web.back].map(|back| match 1.0 + back >= LEAST_RESISTANCE {
            true => growth,
            false => 0.0,
        });
        let own = WebState {
            dynamic_gain: dynamic - 1.0,
            held: 0.0,
            ..*web
        }
        .strength();
        SliderStrength {
            factor: own.factor.map(|factor| self.undamaged * factor),
            growth: growths,
            most: if hardens {
                dynamic * self.most
            } else {
                f64::INFINITY
            },
        }
    }

    /// Hardens a web by a plastic shear angle \[rad\].
    pub fn harden(&self, web: &mut WebState, angle: f64) {
        let most = self.most - 1.0;
        web.back = (web.back + self.growth * angle).clamp(-most, most);
    }
}

/// Equivalent strain rate \[1/s\] after von Mises of a web that shears by all of the turn \[rad\] of its bar.
pub(crate) fn web_rate(turn: f64, secs: f64) -> f64 {
    turn.abs() / (3.0_f64.sqrt() * secs)
}
