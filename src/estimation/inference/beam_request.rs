//! When the fibre beam is asked for a rigid vehicle that explains the readings.

use crate::column::Outcome;
use crate::estimation::inference::beam_error::Read;
use crate::estimation::inference::estimator::Estimator;
use crate::estimation::inference::hypothesis::Front;
use crate::estimation::inference::rigid_fit::RigidFit;
use crate::estimation::inference::rigid_vehicle::ByBeam;

/// Share of the responses that are to have a hard front of which the beam knows more than the bars, so that it is asked \[A\].
const ASKED_FROM: f64 = 0.1;

impl Estimator {
    /// The search for a rigid vehicle that explains all readings by the fibre beam. `None` where the readings or the beam
    /// do not suffice, and where the bars know as much.
    pub(crate) fn rigid_fit(&self) -> Option<RigidFit> {
        let beam = self.beam.as_ref()?;
        let mut hypotheses = self.population.hypotheses.iter();
        let rigid = hypotheses.find(|it| it.front == Front::Rigid)?;
        let read = Read {
            sensors: &self.sensors,
            means: &self.short_means,
            failed: &self.failed,
            yield_strain: self.yield_strain,
            contact_deviation: self.contact[1],
        };
        match self.asks_beam() {
            true => RigidFit::begin(beam, rigid, &read, self.population.events()),
            false => None,
        }
    }

    /// Looks for it at once.
    pub(crate) fn fit_rigid_vehicle(&mut self) {
        if let Some(mut fit) = self.rigid_fit() {
            while !fit.is_over() {
                fit.step();
            }
            self.take(fit.found());
        }
    }

    /// Takes what the beam says. Where a rigid vehicle explains all readings, those that the bars do not explain are in no doubt.
    pub(crate) fn take(&mut self, by_beam: ByBeam) {
        if let ByBeam::Rigid(_) = by_beam {
            self.doubtful.fill(false);
        }
        self.by_beam = by_beam;
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
