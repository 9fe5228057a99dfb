//! The rigid vehicle that explains the readings by the fibre beam: when it is looked for, and what an estimate takes from it.

use crate::column::Outcome;
use crate::estimation::inference::beam_error::Read;
use crate::estimation::inference::estimate::Spread;
use crate::estimation::inference::estimator::Estimator;
use crate::estimation::inference::event_evidence::EventEvidence;
use crate::estimation::inference::hypothesis::Front;
use crate::estimation::inference::rigid_fit::RigidFit;

/// Probability that the rigid vehicle has struck that explains all readings by the fibre beam \[A\].
pub(super) const RIGID_BY_BEAM: f64 = 0.99;

/// Share of the responses that are to have a hard front of which the beam knows more than the bars, so that it is asked \[A\].
const ASKED_FROM: f64 = 0.1;

/// Standard deviations of the logarithms of mass and speed by the beam, and of the momentum, beside what the readings leave open \[A\].
/// Masses of made impacts are found 4 % too large, because the steps of the beam are long.
const ERROR_BY_BEAM: [f64; 2] = [0.07, 0.05];

/// Deviations by which an event may miss what the readings say; beyond, it is wrong.
const WRONG_EVENT: f64 = 3.7;

/// Logarithms of mass and speed of a rigid vehicle, and their covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidVehicle {
    pub mean: [f64; 2],
    pub covariance: [[f64; 2]; 2],
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
        let [of_share, of_momentum] = ERROR_BY_BEAM;
        let is_share = powers.contains(&0.0);
        let error = if is_share { of_share } else { of_momentum };
        Spread {
            mean,
            deviation: libm::hypot(variance.sqrt(), error),
            weight: RIGID_BY_BEAM,
        }
    }

    /// The same with what an event says, unless it contradicts it.
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

impl Estimator {
    /// The search for a rigid vehicle that explains all readings by the fibre beam. `None` where a sensor is in doubt, and where the readings
    /// or the beam do not suffice, or where the bars know as much.
    pub(crate) fn rigid_fit(&self) -> Option<RigidFit> {
        let beam = self.beam.as_ref()?;
        let is_in_doubt = self.in_doubt().contains(&true) || self.failed.contains(&true);
        let mut hypotheses = self.population.hypotheses.iter();
        let rigid = hypotheses.find(|it| it.front == Front::Rigid)?;
        let read = Read {
            sensors: &self.sensors,
            means: &self.short_means,
            yield_strain: self.yield_strain,
            contact_deviation: self.contact[1],
        };
        match is_in_doubt || !self.asks_beam() {
            true => None,
            false => RigidFit::begin(beam, rigid, &read, self.population.events()),
        }
    }

    /// Looks for it at once.
    pub(crate) fn fit_rigid_vehicle(&mut self) {
        if let Some(mut fit) = self.rigid_fit() {
            while !fit.is_over() {
                fit.step();
            }
            self.rigid_vehicle = fit.found();
        }
    }

    /// Whether the beam may know more of what has struck than the bars: a hard front that is light, or leaves the column elastic.
    fn asks_beam(&self) -> bool {
        let weights = self.weights();
        let asked = self.weighted(&weights).filter(|(member, _)| {
            let hypothesis = &self.population.hypotheses[member.hypothesis];
            let is_hard = hypothesis.hard_mass(&member.unknowns).is_some();
            let is_elastic = member.prediction.report.outcome == Outcome::Elastic;
            self.lightness(member) > 0.0 || (is_hard && is_elastic)
        });
        asked.fold(0.0, |sum, (_, weight)| sum + weight) >= ASKED_FROM
    }
}
