//! When the fibre beam is asked for a rigid vehicle that explains the readings, and what counts of its answer.

use crate::column::Outcome;
use crate::estimation::inference::beam_error::Read;
use crate::estimation::inference::estimator::Estimator;
use crate::estimation::inference::hypothesis::Front;
use crate::estimation::inference::rigid_fit::RigidFit;

/// Share of the responses that are to have a hard front of which the beam knows more than the bars, so that it is asked \[A\].
const ASKED_FROM: f64 = 0.1;

impl Estimator {
    /// Begins the search for a rigid vehicle that explains all readings by the fibre beam: once, as soon as there are all readings that it
    /// uses, or for the final estimate. Not where the readings or the beam do not suffice, and where the bars know as much.
    pub(crate) fn ask_beam(&mut self, is_final: bool) {
        let has_all = || self.short_means.iter().any(|it| RigidFit::has_all(it));
        if self.rigid_fit.is_none() && (is_final || has_all()) && self.beam_may_help() {
            self.rigid_fit = self.search_for_rigid_vehicle().map(Box::new);
        }
    }

    /// The next slice of the search; returns whether there is more.
    pub(crate) fn follow_beam(&mut self) -> bool {
        self.rigid_fit.as_mut().is_some_and(|fit| {
            fit.step();
            !fit.is_over()
        })
    }

    /// All of the search that is left, on all processors.
    pub(super) fn finish_beam(&mut self) {
        if let Some(fit) = &mut self.rigid_fit {
            fit.finish();
        }
    }

    pub(crate) fn beam_has_answered(&self) -> bool {
        self.rigid_fit.as_ref().is_some_and(|it| it.is_over())
    }

    /// Takes what the beam says, if it has answered, with what events say so far.
    pub(crate) fn take_answer_of_beam(&mut self) {
        let fit = self.rigid_fit.as_ref().filter(|it| it.is_over());
        if let Some(fit) = fit
            && self.beam_may_help()
        {
            self.by_beam = fit.found(self.population.events());
        }
    }

    /// Whether the beam may know more of what has struck than the bars: a hard front that is light, or leaves the column elastic.
    pub(crate) fn beam_may_help(&self) -> bool {
        let weights = self.weights();
        let asked = self.weighted(&weights).filter(|(member, _)| {
            let is_elastic = member.prediction.report.outcome == Outcome::Elastic;
            self.lightness(member) > 0.0 || (self.is_hard(member) && is_elastic)
        });
        asked.fold(0.0, |sum, (_, weight)| sum + weight) >= ASKED_FROM
    }

    fn search_for_rigid_vehicle(&self) -> Option<RigidFit> {
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
        RigidFit::begin(beam, rigid, &read)
    }
}
