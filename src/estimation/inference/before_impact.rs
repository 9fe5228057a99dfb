//! What is known of a vehicle of any kind before anything is measured, and once only its momentum is.

use crate::estimation::inference::estimate::{CredibleInterval, Spread};
use crate::estimation::inference::hypothesis::Hypothesis;

/// Standard deviations from the mean beyond which the momentum of a vehicle is not probable, and parts of that many.
const FARTHEST: f64 = 4.0;
const MOMENTUM_PARTS: u32 = 12;

/// The interval of these powers of mass and speed, multiplied, before anything is measured.
pub(super) fn prior(hypotheses: &[Hypothesis], powers: [f64; 2]) -> CredibleInterval {
    let each = spread_before(hypotheses, powers).collect();
    CredibleInterval::of_spread(each, f64::INFINITY).map(libm::exp)
}

/// What is known of their logarithm before anything is measured.
fn spread_before(
    hypotheses: &[Hypothesis],
    [of_mass, of_velocity]: [f64; 2],
) -> impl Iterator<Item = Spread> {
    hypotheses.iter().map(move |it| Spread {
        mean: of_mass * it.mean[0] + of_velocity * it.mean[1],
        deviation: libm::hypot(of_mass * it.deviation[0], of_velocity * it.deviation[1]),
        weight: it.probability,
    })
}

/// What is known of a vehicle of any kind before anything is measured: logarithms.
pub(super) struct BeforeImpact {
    /// The largest momentum that is probable.
    pub largest_momentum: f64,
    /// Mass, speed and momentum, each with its variance.
    laws: [[f64; 2]; 3],
}

impl BeforeImpact {
    pub fn of(hypotheses: &[Hypothesis]) -> Self {
        let law = |powers| {
            let (mut first, mut second) = (0.0, 0.0);
            for it in spread_before(hypotheses, powers) {
                first += it.weight * it.mean;
                second += it.weight * (it.mean * it.mean + it.deviation * it.deviation);
            }
            [first, second - first * first]
        };
        Self {
            largest_momentum: libm::log(prior(hypotheses, [1.0, 1.0]).high),
            laws: [law([1.0, 0.0]), law([0.0, 1.0]), law([1.0, 1.0])],
        }
    }

    /// These powers of mass and speed, multiplied, of a vehicle whose momentum has this logarithm with this standard deviation: normal laws of
    /// both, given the momentum. With the weight 1.
    pub fn with_momentum(
        &self,
        [of_mass, of_velocity]: [f64; 2],
        [momentum, scatter]: [f64; 2],
    ) -> Spread {
        let [[mass, of_masses], [velocity, of_velocities], _] = self.laws;
        let total = of_masses + of_velocities + scatter * scatter;
        let shared = of_mass * of_masses + of_velocity * of_velocities;
        let own = of_mass * of_mass * of_masses + of_velocity * of_velocity * of_velocities;
        Spread {
            mean: of_mass * mass
                + of_velocity * velocity
                + shared / total * (momentum - mass - velocity),
            deviation: (own - shared * shared / total).max(0.0).sqrt(),
            weight: 1.0,
        }
    }

    /// These powers of mass and speed, multiplied, of a vehicle of which only the logarithm of the least momentum that it can have is known.
    pub fn with_momentum_of_at_least(&self, powers: [f64; 2], least: f64) -> Vec<Spread> {
        let [_, _, [mean, variance]] = self.laws;
        let deviation = variance.sqrt();
        let begin = least.max(mean - FARTHEST * deviation);
        let step = FARTHEST * deviation / f64::from(MOMENTUM_PARTS);
        // Weights are relative to that of the first part: far from the mean, all densities are too small for a number.
        let first = (begin - mean) / deviation;
        let each = (0..2 * MOMENTUM_PARTS).map(|part| {
            let momentum = begin + (f64::from(part) + 0.5) * step;
            let away = (momentum - mean) / deviation;
            Spread {
                weight: libm::exp(0.5 * (first * first - away * away)),
                ..self.with_momentum(powers, [momentum, step / 12.0_f64.sqrt()])
            }
        });
        let mut each: Vec<Spread> = each.collect();
        let total = each.iter().fold(0.0, |sum, it| sum + it.weight);
        each.iter_mut().for_each(|it| it.weight /= total);
        each
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::inference::estimate::{
        MASS_OPEN_BEYOND, MOMENTUM_OPEN_BEYOND, VELOCITY_OPEN_BEYOND,
    };
    use crate::estimation::inference::hypothesis::hypotheses;
    use crate::parameters::Parameters;

    /// An interval that counts as known is narrower than half of the one before anything is measured.
    #[test]
    fn a_quantity_is_not_known_from_about_half_of_the_interval_before_the_impact_on() {
        let hypotheses = hypotheses(&Parameters::default());
        for (powers, beyond) in [
            ([1.0, 0.0], MASS_OPEN_BEYOND),
            ([0.0, 1.0], VELOCITY_OPEN_BEYOND),
            ([1.0, 1.0], MOMENTUM_OPEN_BEYOND),
        ] {
            let before = prior(&hypotheses, powers);
            let half = (before.high / before.low).sqrt();
            assert!((0.65 * half..=half).contains(&beyond), "{half} {beyond}");
        }
    }
}
