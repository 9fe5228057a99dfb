//! How an impact meets the column: at rest, in motion, or in a response that is over.

use std::sync::Arc;

use super::{NO_REPORT, Twin};
use crate::assessment::imperfection;
use crate::time::Nanos;
use crate::time::seconds;
use crate::twin::active_response::{ActiveResponse, LastResponse};
use crate::twin::begun_impact::BegunImpact;
use crate::twin::command::{Accepted, ImpactCommand};
use crate::twin::forecast::Forecast;
use crate::twin::output::{ForecastEnd, NoticeLevel, Output, Outputs};
use crate::twin::plant::{Plant, Struck};
use crate::twin::registry::{PendingImpact, check_column_id, check_stamp};
use crate::twin::rejection::{Rejection, RejectionCode};
use crate::twin::striking::Striking;
use crate::twin::timeline::{History, LookAhead, Timeline};

const OBSOLETE_REPORT: &str = "whose report no longer holds";

impl Twin {
    pub(super) fn take_impact(
        &mut self,
        command: &ImpactCommand,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        let ImpactCommand {
            event_id,
            column_id,
            stamp,
            vehicle,
            impact: specification,
        } = command;
        check_column_id(self.registry.column_id(), column_id)?;
        self.registry.check_event_id(event_id)?;
        check_stamp(*stamp, now, self.parameters.current())?;
        let snapshot = self.snapshot();
        let striking = snapshot.complete(vehicle, specification)?;
        let event_id: Arc<str> = event_id.as_str().into();
        let contact = stamp.saturating_add(striking.approach_nanos());
        let has_mass = specification.mass > 0.0;
        if self.merge(&event_id, contact, &striking, has_mass, now, out) {
            return Ok(Accepted::Merged);
        }
        let height = snapshot.height_of_impact(&striking.vehicle, specification.height);
        let struck = snapshot.strike(striking.impact, height)?;
        let pending = PendingImpact {
            event_id: Arc::clone(&event_id),
            stamp: *stamp,
            striking,
            height: specification.height,
        };
        self.meet(pending, struck, now, out)?;
        self.link(&event_id, contact, now, out);
        Ok(Accepted::Applied)
    }

    /// Whether the column would take this impact now, and the impact with what its command leaves open. A stamp that is ahead of
    /// the clock is not looked at: the command may be kept back until it is due.
    ///
    /// # Errors
    /// The impact would be rejected.
    pub fn check_impact(&self, command: &ImpactCommand, now: Nanos) -> Result<Striking, Rejection> {
        check_column_id(self.registry.column_id(), &command.column_id)?;
        self.registry.check_event_id(&command.event_id)?;
        check_stamp(command.stamp.min(now), now, self.parameters.current())?;
        let snapshot = self.snapshot();
        let striking = snapshot.complete(&command.vehicle, &command.impact)?;
        let height = snapshot.height_of_impact(&striking.vehicle, command.impact.height);
        snapshot.strike(striking.impact, height)?;
        Ok(striking)
    }

    /// Lets an impact meet the column; `struck` is the column as it is now with the impactor on its way.
    ///
    /// # Errors
    /// The impact is earlier than the one to which the column is responding, or too many are still to come.
    pub(super) fn meet(
        &mut self,
        pending: PendingImpact,
        struck: Struck,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), Rejection> {
        let (stamp, impact) = (pending.stamp, pending.striking.impact);
        let event_id = Arc::clone(&pending.event_id);
        let response = self.response.as_ref().map(|response| &response.timeline);
        match response.map(|it| (it.origin(), it.step_at(stamp), it.step())) {
            None => match self.resume(stamp, &struck) {
                Some(step) => {
                    self.hit_moving_column(pending, step, OBSOLETE_REPORT, now, out);
                }
                None => self.begin(pending, self.at_rest.clone(), struck, now, out),
            },
            Some((_, Some(step), reached)) if step <= reached => {
                self.hit_moving_column(pending, step, NO_REPORT, now, out);
            }
            Some((_, Some(_), _)) => self.registry.keep_pending(pending)?,
            Some((first, None, _)) => {
                let reason = format!(
                    "the stamp is {} s before the stamp of the impact to which the column is responding; \
                     send impacts in the order of their stamps",
                    seconds(first.abs_diff(stamp))
                );
                return Err(Rejection::new(RejectionCode::StampOutOfOrder, reason));
            }
        }
        self.registry.accept(event_id);
        self.journal.impact = Some(impact);
        self.status.set_changed();
        Ok(())
    }

    /// Resumes the last response for an impact that is so late that it belongs there; the step where it does.
    fn resume(&mut self, stamp: Nanos, struck: &Struck) -> Option<u64> {
        let last = self.last.as_ref()?;
        let before = last.before.as_ref()?;
        let timeline = &last.response.timeline;
        let step = timeline
            .step_at(stamp)
            .filter(|&step| step < timeline.step())?;
        if timeline.plant().model != struck.model {
            return None;
        }
        let plastic_work = before.plastic_work;
        let response = self.last.take()?.response;
        self.take_back(response, plastic_work);
        Some(step)
    }

    /// Makes the last response the present one again.
    pub(super) fn take_back(&mut self, response: Box<ActiveResponse>, plastic_work: f64) {
        self.journal.taken_back = true;
        self.registry.life.plastic_work_since_reset = plastic_work;
        self.solver.newton_iterations -= response.newton_iterations();
        self.response = Some(response);
    }

    /// The response to another impact ends where the column was at `step`.
    pub(super) fn hit_moving_column(
        &mut self,
        pending: PendingImpact,
        step: u64,
        earlier_report: &str,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(mut response) = self.response.take() else {
            return;
        };
        response.timeline.rewind(step);
        let Struck { model, state, .. } = *response.timeline.plant();
        self.registry.life.plastic_work_since_reset += state.ledger.plastic_work;
        self.solver.newton_iterations += response.newton_iterations();
        let since = seconds(pending.stamp.abs_diff(response.timeline.origin()));
        let text = format!(
            "impact \"{}\" hits the column {since} s after impact \"{}\", {earlier_report}",
            pending.event_id, response.impact.event_id,
        );
        out.notice(NoticeLevel::Info, now, text.clone());
        self.end_early(response, ForecastEnd::Superseded, text);
        let plant = Plant {
            model,
            state,
            ..self.at_rest.clone()
        };
        // Its height was found to be that of these hinges when it was accepted.
        let pending = PendingImpact {
            height: Some(plant.impact_height()),
            ..pending
        };
        self.begin_pending(plant, pending, now, out);
    }

    pub(super) fn begin_pending(
        &mut self,
        plant: Plant,
        pending: PendingImpact,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let snapshot = self.snapshot_of(plant);
        let height = snapshot.height_of_impact(&pending.striking.vehicle, pending.height);
        match snapshot.strike(pending.striking.impact, height) {
            Ok(struck) => self.begin(pending, snapshot.plant, struck, now, out),
            Err(rejection) => {
                self.registry.withdraw();
                let reason = rejection.tagged();
                self.superseded
                    .take_none((&pending).into(), ForecastEnd::Rejected, &reason);
                self.reject_impact(&pending.event_id, rejection, now, out);
            }
        }
    }

    pub(super) fn reject_impact(
        &mut self,
        event_id: &str,
        rejection: Rejection,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        self.status.set_changed();
        let rejected = self.registry.reject_impact(event_id, rejection, now);
        out.put(Output::Rejected(rejected));
    }

    /// Begins the response of `struck` to an impact; `before` is the column without it.
    fn begin(
        &mut self,
        pending: PendingImpact,
        before: Plant,
        struck: Struck,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let text = format!("impact \"{}\" accepted", pending.event_id);
        out.notice(NoticeLevel::Info, now, text);
        self.respond(pending, before, struck);
    }

    /// As [`begin`](Self::begin), without a word.
    pub(super) fn respond(&mut self, pending: PendingImpact, before: Plant, struck: Struck) {
        let PendingImpact {
            event_id,
            stamp,
            striking,
            ..
        } = pending;
        self.withdraw_unknown_range();
        let opinion = self.opinion_at_the_beginning(&before, &struck, &striking);
        self.registry.life.last_event_id = Arc::clone(&event_id);
        self.journal.responses += 1;
        let period = 1e9 / self.parameters.current().settings().publish_rate;
        let steps = period / struck.model.properties.step_nanos as f64;
        let steps_per_sample = steps.round().max(1.0) as u64;
        let history = self.last.take().map_or_else(History::default, |last| {
            last.response.timeline.into_history()
        });
        let parameters = Arc::clone(self.parameters.current());
        let ahead = LookAhead::new(struck, imperfection(&parameters), self.undamaged);
        self.response = Some(Box::new(ActiveResponse {
            impact: BegunImpact {
                stamp,
                event_id,
                striking,
                parameters,
                step_nanos: struck.model.properties.step_nanos,
                base_before: self.registry.life.base_before(),
                opinion,
            },
            before,
            timeline: Timeline::begin(stamp, struck, steps_per_sample, history),
            forecast: Forecast::new(ahead),
            silent_until: None,
            range: None,
            beam_after: None,
        }));
        self.status.set_changed();
    }

    /// Replaces the impact of a response that begins once more. Its samples are not given out until the instant that the
    /// response before had reached.
    pub(super) fn begin_once_more(
        &mut self,
        response: Box<ActiveResponse>,
        pending: PendingImpact,
        struck: Struck,
        out: &mut impl Outputs,
    ) {
        let reached = response.timeline.instant_of(response.timeline.step());
        let (before, impact) = (response.before.clone(), pending.striking.impact);
        self.solver.newton_iterations += response.newton_iterations();
        out.put(Output::Replaced(Arc::clone(&pending.event_id)));
        self.last = Some(LastResponse {
            response,
            before: None,
        });
        self.respond(pending, before, struck);
        if let Some(response) = &mut self.response {
            response.silent_until = Some(reached);
        }
        self.journal.impact = Some(impact);
    }
}
