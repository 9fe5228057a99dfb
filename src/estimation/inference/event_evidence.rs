//! What an event says about an impact that the sensors have detected: another witness, such as a camera or a person.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::estimation::inference::hypothesis::UNKNOWNS;
use crate::exact_number;

/// Most events that count for one impact.
pub const MAX_EVENTS: usize = 8;

/// Likelihood of what an event says if it is wrong, relative to that of one that is right and exact \[A\]: where an event contradicts
/// the sensors by more than about 3.7 standard deviations, they are believed, because a person may err by any factor.
const WRONG: f64 = 1e-3;

/// Mass and speed that an event reports.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventEvidence {
    /// Identifier of the event.
    pub event_id: Arc<str>,
    /// Mass of the vehicle \[kg\]; NaN if the event does not say it.
    #[serde(with = "exact_number")]
    pub mass: f64,
    /// Its standard deviation, relative to it: parameter `estimation.event_mass_deviation`.
    #[serde(with = "exact_number")]
    pub mass_deviation: f64,
    /// Speed of the vehicle \[m/s\].
    #[serde(with = "exact_number")]
    pub velocity: f64,
    /// Its standard deviation, relative to it: parameter `estimation.event_velocity_deviation`.
    #[serde(with = "exact_number")]
    pub velocity_deviation: f64,
}

impl EventEvidence {
    /// Logarithm of its likelihood if these are the logarithms of mass and speed. What it does not say does not count.
    pub(crate) fn log_likelihood(&self, log_mass: f64, log_velocity: f64) -> f64 {
        let square = |said: f64, deviation: f64, log: f64| {
            let z = (libm::log(said) - log) / deviation;
            if z.is_finite() { z * z } else { 0.0 }
        };
        let squares = square(self.mass, self.mass_deviation, log_mass)
            + square(self.velocity, self.velocity_deviation, log_velocity);
        libm::log(libm::exp(-0.5 * squares) + WRONG)
    }
}

/// Logarithm of the likelihood of what events say, if these unknowns are true.
pub(crate) fn log_events(events: &[EventEvidence], unknowns: &[f64; UNKNOWNS]) -> f64 {
    let each = events
        .iter()
        .map(|it| it.log_likelihood(unknowns[0], unknowns[1]));
    each.fold(0.0, |sum, it| sum + it)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(mass: f64) -> EventEvidence {
        EventEvidence {
            event_id: "camera".into(),
            mass,
            mass_deviation: 0.3,
            velocity: 10.0,
            velocity_deviation: 0.1,
        }
    }

    #[test]
    fn an_event_weighs_as_a_normal_law_until_it_contradicts_too_much() {
        let [mass, velocity] = [1500.0_f64, 10.0].map(f64::ln);
        let at = |m: f64, v: f64| seen(1500.0).log_likelihood(mass + m, velocity + v);
        assert!(at(0.0, 0.0).abs() < 2e-3);
        // One standard deviation of either.
        assert!((at(0.3, 0.0) + 0.5).abs() < 2e-3 && (at(0.0, -0.1) + 0.5).abs() < 2e-3);
        let wrong = WRONG.ln();
        assert!((at(3.0, 0.0) - wrong).abs() < 1e-6 && (at(30.0, 2.0) - wrong).abs() < 1e-6);
        // Without a mass only the speed counts.
        let of_speed = seen(f64::NAN).log_likelihood(mass + 5.0, velocity + 0.1);
        assert!((of_speed + 0.5).abs() < 2e-3, "{of_speed}");
    }
}
