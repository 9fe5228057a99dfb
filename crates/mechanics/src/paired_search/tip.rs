//! The tip of the weaker of two yield surfaces: whether a return ends there, and how hinges and web share what it asks for.

use super::{PairSearch, PairedState};
use crate::bar::Returned;

impl<const HARDENS: bool, const SHEARS: bool> PairSearch<'_, HARDENS, SHEARS> {
    /// `-dm_k/dn` of both hinges at the tip of the weaker surface, 0 where it is infinite.
    fn tip_slopes(&self) -> [f64; 2] {
        let (surface, strength) = (&self.bar.surface, self.strength);
        [0, 1].map(|k| {
            if self.lead.rest == 0.0 || k == strength.weaker {
                self.bar.tip_slope()
            } else {
                surface.slope_beyond_tip(&self.lead)
            }
        })
    }

    /// Whether the optimum is the tip of the weaker surface.
    pub(super) fn is_at_tip(&self, state: &PairedState) -> bool {
        let slopes = self.tip_slopes();
        let is_free = |k: usize| slopes[k] > 0.0 || state.capped.rotation[k] == 0.0;
        let taken = |k: usize| self.scale[k] * self.integral(state, k) * slopes[k];
        let mut sum = 1.0 - self.relative + taken(0) + taken(1);
        if SHEARS {
            sum += self.web_scale() * self.web_integral(state) * self.bar.web_tip_slope();
        }
        is_free(0) && is_free(1) && sum <= 0.0
    }

    /// At the tip, where neither the weaker hinge nor the web bears anything, the web takes as much of the rotations as makes the elongation that
    /// normality asks for least. A slider that is none bears what it always does, and takes what it took.
    pub(super) fn divide_at_tip(&self, state: &mut PairedState) {
        if self.bar.web_tip_slope() == 0.0 {
            return;
        }
        let slopes = self.tip_slopes();
        let rotation = state.capped.rotation.map(|it| it + state.web.angle);
        let bears = [0, 1].map(|k| self.bears(k));
        let left = |angle: f64| [0, 1].map(|k| if bears[k] { rotation[k] - angle } else { 0.0 });
        let asked = |angle: f64| {
            let of_hinge = |k: usize| match left(angle)[k].abs() {
                0.0 => 0.0,
                _ if slopes[k] == 0.0 => f64::INFINITY,
                p => slopes[k] * self.moment[k] * p,
            };
            let own = self.strength.slider.integral(angle);
            of_hinge(0) + of_hinge(1) + self.bar.web_tip_slope() * self.web * own
        };
        let stronger = 1 - self.strength.weaker;
        let mut least = 0.0;
        if self.lead.rest > 0.0 && bears[stronger] {
            // The stronger hinge alone bears a moment there, which it cannot have without the others.
            least = rotation[stronger];
        } else {
            for k in 0..2 {
                if bears[k] && asked(rotation[k]) < asked(least) {
                    least = rotation[k];
                }
            }
        }
        state.capped.rotation = left(least);
        state.web.angle = least;
        state.web.together = None;
    }

    /// The stress at the tip of the weaker surface. Its hinge takes what is left of the elongation after each hinge has taken
    /// what normality to its curve asks of its rotation.
    pub(super) fn at_tip(&self, state: &PairedState) -> Returned {
        let (slopes, strength) = (self.tip_slopes(), self.strength);
        let normal = self.sign * self.axial;
        let total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        let mut elongation = [0, 1]
            .map(|k| self.sign * self.integral(state, k) * slopes[k] * self.moment[k] / self.axial);
        let rest =
            total - self.web_elongation(state, normal, total) - elongation[0] - elongation[1];
        if self.lead.rest == 0.0 {
            elongation = elongation.map(|own| own + 0.5 * rest);
        } else {
            elongation[strength.weaker] += rest;
        }
        self.held(normal, state, elongation)
    }
}
