//! How an impact meets the column: at rest, in motion, or in a response that is over.

use std::sync::Arc;

use super::{NO_REPORT, Twin};
use crate::time::Nanos;
use crate::time::seconds;
use crate::twin::command::{Accepted, ImpactCommand};
use crate::twin::output::{ForecastEnd, NoticeLevel, Output, Outputs};
use crate::twin::plant::{Plant, Struck};
use crate::twin::registry::{PendingImpact, RejectedInput, check_column_id, check_stamp};
use crate::twin::rejection::{Rejection, RejectionCode};
use crate::twin::striking::Striking;

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
        check_column_id(self.column.id(), column_id)?;
        self.registry.check_event_id(event_id)?;
        check_stamp(*stamp, now, self.parameters())?;
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
        check_column_id(self.column.id(), &command.column_id)?;
        self.registry.check_event_id(&command.event_id)?;
        check_stamp(command.stamp.min(now), now, self.parameters())?;
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
        let timeline = self.course.present().map(|it| it.timeline());
        match timeline.map(|it| (it.origin(), it.step_at(stamp), it.step())) {
            None => match self.course.step_to_resume(stamp, &struck.model) {
                Some(step) => {
                    if let Some(before) = self.course.take_back() {
                        self.column.resume(&before);
                        self.journal.note_taken_back();
                    }
                    self.hit_moving_column(pending, step, OBSOLETE_REPORT, now, out);
                }
                None => self.begin(pending, self.column.plant().clone(), struck, now, out),
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
        self.column.count_impact();
        self.journal.note_impact(impact);
        self.status.set_changed();
        Ok(())
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
        let Some(response) = self.course.rewind(step) else {
            return;
        };
        let Struck { model, state, .. } = *response.plant();
        self.column.add_plastic_work(state.ledger.plastic_work);
        let since = seconds(pending.stamp.abs_diff(response.timeline().origin()));
        let text = format!(
            "impact \"{}\" hits the column {since} s after impact \"{}\", {earlier_report}",
            pending.event_id,
            response.impact().event_id,
        );
        out.notice(NoticeLevel::Info, now, text.clone());
        self.course.end_early(ForecastEnd::Superseded, text);
        let plant = Plant {
            model,
            state,
            ..self.column.plant().clone()
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
                self.column.discount_impact();
                let reason = rejection.tagged();
                self.course
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
        self.column.count_rejection();
        let rejected = self.registry.reject_impact(event_id, rejection, now);
        out.put(Output::Rejected(rejected));
    }

    /// Rejects a request whose sender gets an answer.
    pub(super) fn reject_request(
        &mut self,
        what: RejectedInput,
        rejection: Rejection,
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Rejection {
        self.status.set_changed();
        let rejected = self
            .registry
            .reject_request(what, rejection.clone(), source, now);
        out.put(Output::Rejected(rejected));
        rejection
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
        self.course
            .begin(pending, before, struck, &mut self.column, None);
        self.status.set_changed();
    }

    /// Replaces the impact of the present response, which begins once more. Its samples are not given out until the instant that
    /// it had reached.
    pub(super) fn begin_once_more(
        &mut self,
        pending: PendingImpact,
        struck: Struck,
        out: &mut impl Outputs,
    ) {
        let Some((before, reached)) = self.course.set_aside() else {
            return;
        };
        out.put(Output::Replaced(Arc::clone(&pending.event_id)));
        self.journal.note_impact(pending.striking.impact);
        self.course
            .begin(pending, before, struck, &mut self.column, Some(reached));
        self.status.set_changed();
    }
}
