//! The second opinion on the present or the last impact: asked for, taken, and corrected.

use std::sync::Arc;

use super::Twin;
use crate::second_opinion::{Movement, SecondOpinion};
use crate::time::Nanos;
use crate::twin::assessed::{LastImpact, assessed_again};
use crate::twin::command::Accepted;
use crate::twin::damage_correction::ResidualMeasurement;
use crate::twin::opinion::{OpinionTask, Seen};
use crate::twin::opinion_state::{BeamResult, KnownBeamDamage, MOVING, OpinionState};
use crate::twin::output::{NoticeLevel, Output, Outputs, SupplementedReport, Verdicts};
use crate::twin::plant::{Plant, Struck};
use crate::twin::striking::Striking;

impl Twin {
    /// Whether there is an [`opinion_task`](Self::opinion_task), without making it.
    #[must_use]
    pub fn awaits_opinion(&self) -> bool {
        match (&self.response, &self.judged) {
            (Some(response), _) => response.awaits_opinion(),
            (None, Some(judged)) => {
                judged.impact.opinion == OpinionState::Awaited && self.assessed.is_some()
            }
            (None, None) => false,
        }
    }

    /// What is to be computed before [`Command::SecondOpinion`](super::Command::SecondOpinion) can be given: the second opinion on the
    /// present or the last impact is not known, and its forecast is complete.
    #[must_use]
    pub fn opinion_task(&self) -> Option<OpinionTask> {
        match &self.response {
            Some(response) => {
                response.opinion_task(self.journal.responses, &self.registry.life.beam)
            }
            None => self
                .opinion_task_at_rest()
                .filter(|_| self.awaits_opinion()),
        }
    }

    /// The hit of the last impact for the beam, whether its answer is known or not; `None` where there is none.
    #[must_use]
    pub fn opinion_task_at_rest(&self) -> Option<OpinionTask> {
        let judged = &self.judged.as_ref()?.impact;
        OpinionTask::new(
            self.journal.responses,
            self.parameters.current(),
            &self.at_rest.model.properties,
            &judged.striking(),
            &judged.beam_before,
        )
        .ok()
    }

    /// What the twin keeps of the last impact by this result of its [`opinion_task_at_rest`](Self::opinion_task_at_rest): the opinion
    /// and the damage of the beam.
    #[must_use]
    pub fn kept_at_rest(
        &self,
        found: &BeamResult,
    ) -> Option<(Option<Arc<SecondOpinion>>, KnownBeamDamage)> {
        let impact = &self.judged.as_ref()?.impact;
        let seen = Seen {
            striking: &impact.striking(),
            parameters: self.parameters.current(),
            report: &impact.report,
            left: &self.at_rest,
            before: &impact.beam_before,
        };
        Some(seen.kept(found))
    }

    /// Where the second opinion on an impact stands that begins now, on the column `before` it.
    pub(super) fn opinion_at_the_beginning(
        &self,
        before: &Plant,
        struck: &Struck,
        striking: &Striking,
    ) -> OpinionState {
        if before.state.impactor.is_some() {
            return OpinionState::None(MOVING.into());
        }
        let task = OpinionTask::new(
            0,
            self.parameters.current(),
            &struck.model.properties,
            striking,
            &self.registry.life.beam,
        );
        match task {
            Ok(_) => OpinionState::Awaited,
            Err(reason) => OpinionState::None(reason),
        }
    }

    /// Takes what the beam has found of the present or the last impact. If nothing is awaited by now, it is left aside.
    pub(super) fn take_opinion(&mut self, found: &BeamResult) -> Accepted {
        if !self.awaits_opinion() {
            return Accepted::Unchanged;
        }
        match &mut self.response {
            Some(response) => {
                let impact = &mut response.impact;
                let Some(predicted) = response.forecast.predicted_mut() else {
                    return Accepted::Unchanged;
                };
                let seen = Seen {
                    striking: &impact.striking,
                    parameters: &impact.parameters,
                    report: &predicted.report,
                    left: &predicted.at_rest,
                    before: &self.registry.life.beam,
                };
                let (opinion, beam) = seen.kept(found);
                if opinion.is_some() {
                    let last = LastImpact {
                        second_opinion: opinion,
                        ..LastImpact::new(
                            &impact.striking,
                            &predicted.report,
                            predicted.error_estimate,
                            impact.base_before.as_ref(),
                        )
                    };
                    let assessed = predicted.assessed.as_ref();
                    predicted.assessed = assessed.map(|it| {
                        assessed_again(it, &impact.parameters, &predicted.at_rest, &last)
                    });
                }
                impact.opinion = OpinionState::after(found);
                response.beam_after = Some(beam);
            }
            None => self.take_opinion_at_rest(found),
        }
        self.status.set_changed();
        Accepted::Applied
    }

    fn take_opinion_at_rest(&mut self, found: &BeamResult) {
        let Some(((opinion, beam), judged)) = self.kept_at_rest(found).zip(self.judged.as_mut())
        else {
            return;
        };
        let life = &mut self.registry.life;
        life.beam = beam;
        judged.impact.opinion = OpinionState::after(found);
        if let Some(last) = life.last_impact.as_mut().filter(|_| opinion.is_some()) {
            last.second_opinion = opinion;
            let parameters = self.parameters.current();
            let assessed = self.assessed.as_ref();
            self.assessed = assessed.map(|it| assessed_again(it, parameters, &self.at_rest, last));
        }
        // A recording that begins at rest begins with the last checkpoint, and needs no command before it.
        self.journal.set_checkpoint_due();
    }

    /// Gives out the forecast or the report of the impact once more, with the second opinion and with how the beam moves by it.
    pub(super) fn put_opinion(
        &self,
        movement: Option<Arc<Movement>>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(again) = self.supplemented() else {
            return;
        };
        let again = SupplementedReport { movement, ..again };
        let event_id = &again.report.event_id;
        if let OpinionState::None(reason) = &again.report.opinion {
            out.notice(
                NoticeLevel::Warning,
                now,
                format!("impact \"{event_id}\": {reason}"),
            );
        }
        if let Some(opinion) = self.known_opinion() {
            let text = format!("second opinion on impact \"{event_id}\": {opinion}");
            out.notice(NoticeLevel::Info, now, text);
            if opinion.decides {
                let assessed = again.report.assessed.as_deref();
                out.verdict("second opinion", event_id, assessed, now);
            }
        }
        if again.is_result {
            // The damage that the beam leaves, and its verdict.
            self.save(now, out);
        }
        out.put(Output::Supplemented(again));
    }

    /// The second opinion on the present or the last impact, if it is known.
    fn known_opinion(&self) -> Option<&Arc<SecondOpinion>> {
        let assessed = match &self.response {
            Some(response) => response.forecast.predicted()?.assessed.as_ref(),
            None => self.assessed.as_ref(),
        };
        assessed?.second_opinion.as_ref()
    }

    /// The beam corrects its damage by this measurement before it computes the next hit; its opinion on the last one no longer holds.
    pub(super) fn correct_beam(&mut self, measured: &ResidualMeasurement) {
        let life = &mut self.registry.life;
        life.beam = life.beam.corrected_by(measured);
        if let Some(last) = &mut life.last_impact {
            last.second_opinion = None;
        }
    }
}
