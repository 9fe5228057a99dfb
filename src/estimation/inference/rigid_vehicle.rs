//! What the fibre beam says of the vehicle: a rigid one explains the readings, or none does.

use crate::estimation::inference::estimate::Spread;
use crate::estimation::inference::event_evidence::EventEvidence;

/// Probability that the rigid vehicle has struck that explains all readings by the fibre beam \[A\].
pub(super) const RIGID_BY_BEAM: f64 = 0.99;

/// Probability that there is more behind a light, hard front \[A\].
const HIDDEN: f64 = 0.5;

/// The same where no rigid vehicle explains the readings by the fibre beam \[A\]: of made impacts, it explains more than 90 % of the rigid
/// vehicles, and hardly any other.
const HIDDEN_BY_BEAM: f64 = 0.9;

/// Standard deviations of the logarithms of mass and speed by the beam, and of the momentum, beside what the readings leave open \[A\].
/// Masses of made impacts are found 4 % too large, because the steps of the beam are long.
const ERROR_BY_BEAM: [f64; 2] = [0.07, 0.05];

/// The same once a gauge has left the elastic range: how the column yields where it is struck decides on how much it takes.
const ERROR_BY_YIELDING_BEAM: [f64; 2] = [0.2, 0.1];

/// Deviations by which an event may miss what the readings say; beyond, it is wrong.
const WRONG_EVENT: f64 = 3.7;

/// Logarithms of mass and speed of a rigid vehicle, and their covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidVehicle {
    pub mean: [f64; 2],
    pub covariance: [[f64; 2]; 2],
    /// Whether a gauge has left the elastic range.
    pub has_yielded_gauge: bool,
}

/// What the fibre beam says of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ByBeam {
    /// It was not asked.
    Nothing,
    /// This rigid vehicle explains all readings.
    Rigid(RigidVehicle),
    /// No rigid vehicle explains them.
    NotRigid,
}

impl ByBeam {
    /// The probability that there is more behind a hard front that is wholly light.
    pub fn hidden(self) -> f64 {
        match self {
            Self::NotRigid => HIDDEN_BY_BEAM,
            Self::Nothing | Self::Rigid(_) => HIDDEN,
        }
    }
}

impl RigidVehicle {
    /// Mean and variance of the logarithm of these powers of mass and speed, multiplied.
    fn logarithm(&self, powers: [f64; 2]) -> (f64, f64) {
        let product = |a: [f64; 2]| a[0] * powers[0] + a[1] * powers[1];
        (product(self.mean), product(self.covariance.map(product)))
    }

    /// What an estimate takes from it of these powers of mass and speed, multiplied: the logarithm, with the probability that it is right.
    pub fn spread(&self, powers: [f64; 2]) -> Spread {
        let (mean, variance) = self.logarithm(powers);
        let [of_share, of_momentum] = match self.has_yielded_gauge {
            true => ERROR_BY_YIELDING_BEAM,
            false => ERROR_BY_BEAM,
        };
        let is_share = powers.contains(&0.0);
        let error = if is_share { of_share } else { of_momentum };
        Spread {
            mean,
            deviation: libm::hypot(variance.sqrt(), error),
            weight: RIGID_BY_BEAM,
        }
    }

    /// Correlation of the logarithms of mass and speed, which makes the deviation of the momentum of theirs.
    pub fn correlation(&self) -> f64 {
        let of = |powers| self.spread(powers).deviation;
        let [mass, velocity, momentum] = [of([1.0, 0.0]), of([0.0, 1.0]), of([1.0, 1.0])];
        (momentum * momentum - mass * mass - velocity * velocity) / (2.0 * mass * velocity)
    }

    /// This vehicle with what an event says, unless it contradicts it.
    pub fn with_event(self, event: &EventEvidence) -> Self {
        let said = [
            (event.mass, event.mass_deviation),
            (event.velocity, event.velocity_deviation),
        ];
        let mut found = self;
        for (k, (value, deviation)) in said.into_iter().enumerate() {
            let away = libm::log(value) - found.mean[k];
            let variance = deviation * deviation + found.covariance[k][k];
            if !away.is_finite() || away * away > WRONG_EVENT * WRONG_EVENT * variance {
                continue;
            }
            let with = found.covariance[k];
            for (i, mean) in found.mean.iter_mut().enumerate() {
                let gain = with[i] / variance;
                *mean += gain * away;
                for (covariance, with) in found.covariance[i].iter_mut().zip(with) {
                    *covariance -= gain * with;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(mass: f64) -> EventEvidence {
        EventEvidence {
            event_id: "camera".into(),
            mass,
            mass_deviation: 0.1,
            velocity: f64::NAN,
            velocity_deviation: 0.1,
        }
    }

    #[test]
    fn an_event_narrows_the_vehicle_unless_it_contradicts_it() {
        let found = RigidVehicle {
            mean: [300.0, 5.0].map(libm::log),
            covariance: [[0.04, -0.03], [-0.03, 0.04]],
            has_yielded_gauge: false,
        };
        let (_, of_momentum) = found.logarithm([1.0, 1.0]);
        assert!((of_momentum - 0.02).abs() < 1e-12, "{of_momentum}");
        // (0.02 + 0.05^2 - 2 (0.04 + 0.07^2)) / (2 (0.04 + 0.07^2))
        assert!((found.correlation() + 0.749_443_207).abs() < 1e-8);
        let agreed = found.with_event(&said(300.0));
        // The precisions 1/0.04 and 1/0.01 add up.
        assert!(
            (agreed.covariance[0][0] - 0.008).abs() < 1e-12,
            "{agreed:?}"
        );
        assert!((agreed.mean[0] - found.mean[0]).abs() < 1e-12);
        // What is heavier is slower.
        let heavier = found.with_event(&said(330.0));
        assert!(heavier.mean[0] > found.mean[0] && heavier.mean[1] < found.mean[1]);
        assert_eq!(found.with_event(&said(3000.0)), found);
    }
}
