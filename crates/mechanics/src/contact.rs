//! Unilateral contact and Newton's impact law (Eqs 33-38).
//!
//! Sign: the paper's gap `g_N = v_c - v_1` (Eq 33) opens when an impactor with a positive velocity approaches. Here `v`
//! is positive in the impactor's direction of travel and the gap is `v_1 - v_c`: positive while open, closing while
//! `v_c' > v_1'`.

use serde::{Deserialize, Serialize};

use super::impact::Impact;
use super::model::Model;

/// A closing speed whose rebound is below this fraction of the impactor's first speed does not rebound: contact is
/// taken as persistent from there, since rebounds with restitution pile up infinitely many in finite time.
pub const PERSISTENT_CONTACT_FRACTION: f64 = 1e-4;

/// The impactor under way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Impactor {
    /// What it began as.
    pub impact: Impact,
    /// `v_c` \[m\].
    pub position: f64,
    /// Its rate \[m/s\].
    pub velocity: f64,
    /// Contact is closed.
    pub closed: bool,
    /// First touch, since the event \[s\].
    pub touched_at: Option<f64>,
    /// Last parting, since the event \[s\].
    pub released_at: Option<f64>,
    /// Where and when its free flight began: positions in flight are computed from here, not summed up.
    flight: Flight,
}

/// Beginning of a free flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Flight {
    position: f64,
    step: u64,
    offset_secs: f64,
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
            flight: Flight {
                position,
                step: 0,
                offset_secs: 0.0,
            },
        }
    }

    /// Notes a touch `offset_secs` into step `step` \[s\].
    pub(crate) fn touch(&mut self, model: &Model, step: u64, offset_secs: f64) {
        self.touched_at
            .get_or_insert(model.time_of_step(step) + offset_secs);
    }

    /// Parts from the column `offset_secs` into step `step` \[s\] and begins a free flight.
    pub(crate) fn release(&mut self, model: &Model, step: u64, offset_secs: f64) {
        self.closed = false;
        self.released_at = Some(model.time_of_step(step) + offset_secs);
        self.flight = Flight {
            position: self.position,
            step,
            offset_secs,
        };
    }

    /// Where the free flight has led `offset_secs` into step `step` \[m\].
    pub(crate) fn position_in_flight(&self, model: &Model, step: u64, offset_secs: f64) -> f64 {
        let steps = model.time_of_step(step - self.flight.step);
        self.flight.position + self.velocity * (steps + (offset_secs - self.flight.offset_secs))
    }

    /// Closing speed against a column that moves at `v1_rate` \[m/s\]; negative: parting.
    pub(crate) fn closing_speed(&self, v1_rate: f64) -> f64 {
        self.velocity - v1_rate
    }

    /// Kinetic energy \[J\].
    pub(crate) fn kinetic_energy(&self) -> f64 {
        0.5 * self.impact.mass * self.velocity * self.velocity
    }

    /// Restitution that a closing speed meets: Newton's, or 0 where its rebound would be too small to follow.
    pub(crate) fn effective_restitution(&self, closing_speed: f64) -> f64 {
        let rebound = self.impact.restitution * closing_speed;
        if rebound < PERSISTENT_CONTACT_FRACTION * self.impact.velocity {
            0.0
        } else {
            self.impact.restitution
        }
    }
}

/// A percussion between `m_c` and `m_1` by Newton's law (Eq 36).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Percussion {
    /// `Lambda_N` \[N s\].
    pub impulse: f64,
    /// Energy lost \[J\].
    pub loss: f64,
}

/// The percussion of two masses \[kg\] that close at `closing_speed` \[m/s\].
pub(crate) fn percussion(
    impactor_mass: f64,
    column_mass: f64,
    closing_speed: f64,
    restitution: f64,
) -> Percussion {
    let reduced = impactor_mass * column_mass / (impactor_mass + column_mass);
    Percussion {
        impulse: (1.0 + restitution) * reduced * closing_speed,
        loss: 0.5 * (1.0 - restitution * restitution) * reduced * closing_speed * closing_speed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_first_percussion() {
        let p = percussion(1500.0, 70.1 * 4.0 / 3.0, 10.0, 0.0);
        assert!((p.impulse - 879.842691).abs() < 1e-5, "{}", p.impulse);
        assert!((p.loss - 4399.213454941).abs() < 1e-6, "{}", p.loss);
    }

    #[test]
    fn an_elastic_percussion_loses_nothing_and_turns_the_speed_round() {
        let (mc, m1, w) = (3.0, 2.0, 5.0);
        let p = percussion(mc, m1, w, 1.0);
        assert_eq!(p.loss, 0.0);
        assert!((w - p.impulse / mc - p.impulse / m1 + w).abs() < 1e-14);
    }
}
