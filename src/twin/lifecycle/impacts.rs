//! How an impact meets the column, that of an event or that of an estimate: at rest, in motion, or in a response that is over.

use std::sync::Arc;

use super::{NO_REPORT, Twin};
use crate::column::Phase;
use crate::estimation::{EstimateRecord, EventEvidence};
use crate::parameters::{AcceptEstimates, EstimationSettings};
use crate::time::Nanos;
use crate::time::seconds;
use crate::twin::command::{Accepted, EstimateDecision, ImpactCommand};
use crate::twin::course::ActiveResponse;
use crate::twin::estimates::{
    Decision, Sequence, contact, first_in_words, is_sure_enough, striking_of,
};
use crate::twin::output::{EstimateOutput, ForecastEnd, MergedEvent, NoticeLevel, Output, Outputs};
use crate::twin::plant::{Plant, Struck};
use crate::twin::registry::{
    PendingImpact, RejectedInput, check_column_id, check_not_ahead, check_stamp,
};
use crate::twin::rejection::{Rejection, RejectionCode};
use crate::twin::striking::Striking;
use crate::twin::what_if::ColumnSnapshot;

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
        // It is the impact that the sensors have detected or may still report.
        self.estimates.remember(event_id, contact);
        self.link_with_event(now, out);
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
    fn meet(
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
        self.course.rewind(step);
        let plant = self.plant_now();
        let Some(response) = self.course.present() else {
            return;
        };
        let added = plant.state.ledger.plastic_work;
        self.column.add_plastic_work(added);
        let since = seconds(pending.stamp.abs_diff(response.timeline().origin()));
        let text = format!(
            "impact \"{}\" hits the column {since} s after impact \"{}\", {earlier_report}",
            pending.event_id,
            response.impact().event_id,
        );
        out.notice(NoticeLevel::Info, now, text.clone());
        self.course.end_early(ForecastEnd::Superseded, text);
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

    // Estimates

    fn estimation(&self) -> &EstimationSettings {
        &self.parameters().settings().estimation
    }

    /// Takes an estimate. One that comes late, because a later or the final one is known, is left aside.
    pub(super) fn take_estimate(
        &mut self,
        record: &Arc<EstimateRecord>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Accepted {
        let sequence = self.estimates.take(record);
        match sequence {
            Sequence::Late => return Accepted::Unchanged,
            Sequence::First => out.notice(
                NoticeLevel::Warning,
                now,
                first_in_words(record, self.estimation().accept),
            ),
            Sequence::Update => {}
        }
        self.link_with_event(now, out);
        let (accept, is_sure) = (
            self.estimation().accept,
            is_sure_enough(record, self.estimation()),
        );
        match self.estimates.decision() {
            Decision::Accepted => self.follow(record, now, out),
            Decision::Pending
                if accept == AcceptEstimates::Automatic && (is_sure || record.is_final) =>
            {
                // A rejection was counted and given out.
                let _ = self.accept_newest(now, out);
            }
            _ => {}
        }
        self.estimates.set_changed();
        self.status.set_changed();
        if record.is_final {
            // A recording that begins at rest needs no estimate before it.
            self.journal.set_checkpoint_due();
        }
        Accepted::Applied
    }

    fn decide(&mut self, decision: Decision) {
        self.estimates.decide(decision);
        self.note_change_at_rest();
    }

    /// The impact that waits for somebody to confirm it.
    pub(super) fn waiting_estimate(&self) -> Option<&Arc<str>> {
        self.estimates.waiting(self.estimation().accept)
    }

    /// Gives out the newest estimate with what has become of it, if anything of that has changed.
    pub(super) fn put_estimate(&mut self, out: &mut impl Outputs) {
        if let Some(newest) = self.estimates.take_changed() {
            out.put(Output::Estimate(EstimateOutput {
                stamp: newest.contact(),
                record: Arc::clone(&newest.record),
                decision: newest.decision,
                merged_event_id: newest.event_id.clone(),
            }));
        }
    }

    // Acceptance

    /// Executes what an operator has decided.
    ///
    /// # Errors
    /// There is nothing to decide, or the column cannot take the impact.
    pub(super) fn decide_estimate(
        &mut self,
        decision: &EstimateDecision,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        let accept = self.estimation().accept;
        self.estimates.check_decision(decision, accept)?;
        let outcome = match decision.accept {
            true => self.accept_newest(now, out),
            false => {
                self.decide(Decision::Declined);
                Ok(())
            }
        };
        if let Some(newest) = self.estimates.newest() {
            let verdict = match (decision.accept, &outcome) {
                (true, Ok(())) => "confirmed",
                (true, Err(_)) => "confirmed, but cannot be taken,",
                (false, _) => "declined",
            };
            let id = &newest.record.event_id;
            let text = format!(
                "the impact \"{id}\" that the sensors have detected is {verdict} by {}",
                decision.source
            );
            out.notice(NoticeLevel::Info, now, text);
        }
        self.estimates.set_changed();
        outcome.map(|()| Accepted::Applied)
    }

    /// Makes the newest impact that the sensors have detected an impact of the twin, or counts and gives out why that cannot be.
    fn accept_newest(&mut self, now: Nanos, out: &mut impl Outputs) -> Result<(), Rejection> {
        let Some(newest) = self.estimates.newest() else {
            return Ok(());
        };
        let record = Arc::clone(&newest.record);
        match self.meet_estimate(&record, now, out) {
            Ok(()) => {
                self.decide(Decision::Accepted);
                Ok(())
            }
            Err(rejection) => {
                self.decide(Decision::Rejected);
                self.reject_impact(&record.event_id, rejection.clone(), now, out);
                Err(rejection)
            }
        }
    }

    fn meet_estimate(
        &mut self,
        record: &EstimateRecord,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), Rejection> {
        let stamp = contact(record);
        self.registry.check_event_id(&record.event_id)?;
        check_not_ahead(stamp, now, self.parameters())?;
        let snapshot = self.snapshot();
        let striking = snapshot.checked(striking_of(record))?;
        let height = snapshot.height_of_estimates();
        let (pending, struck) = estimated(record, stamp, striking, &snapshot, height)?;
        self.meet(pending, struck, now, out)
    }

    // Following

    /// Replaces the impact of an accepted estimate by that of a later one, as long as its response is the last one and the
    /// column has not been changed since.
    fn follow(&mut self, record: &EstimateRecord, now: Nanos, out: &mut impl Outputs) {
        let found = self.course.replaceable();
        let replaced = match found.filter(|it| it.impact().event_id == record.event_id) {
            Some(response) => self.replacement(response, record),
            None => self.replace_pending(record),
        };
        match replaced {
            Ok(Some((pending, struck))) => self.replace(pending, struck, now, out),
            Ok(None) => {}
            Err(rejection) => {
                let text = format!(
                    "a later estimate of impact \"{}\" cannot be followed: {rejection}",
                    record.event_id
                );
                out.notice(NoticeLevel::Warning, now, text);
            }
        }
    }

    /// The impact of a later estimate, and the column as it was before with it on its way; `None` if it is the same as that
    /// of the response. On a column that was moving already, the instant of contact remains: how the column moved without the
    /// impact is not known beyond it.
    fn replacement(
        &self,
        response: &ActiveResponse,
        record: &EstimateRecord,
    ) -> Result<Option<(PendingImpact, Struck)>, Rejection> {
        let (before, impact) = (response.before(), response.impact());
        let is_at_rest = before.state.sample(&before.model).phase == Phase::Idle;
        let stamp = match is_at_rest {
            true => contact(record),
            false => impact.stamp,
        };
        let snapshot = self.snapshot_of(before.clone());
        let striking = snapshot.checked(striking_of(record))?;
        if stamp == impact.stamp && striking == impact.striking {
            return Ok(None);
        }
        let properties = &response.plant().model.properties;
        let height = Some(properties.length_below);
        estimated(record, stamp, striking, &snapshot, height).map(Some)
    }

    /// Replaces the impact of an estimate that has not begun yet.
    fn replace_pending(
        &mut self,
        record: &EstimateRecord,
    ) -> Result<Option<(PendingImpact, Struck)>, Rejection> {
        let striking = self.snapshot().checked(striking_of(record))?;
        let Some(pending) = self.registry.pending_mut(&record.event_id) else {
            let reason =
                "another impact, a reset or a change of the column has come after its response";
            return Err(Rejection::new(RejectionCode::EstimateNotPending, reason));
        };
        pending.striking = striking;
        Ok(None)
    }

    fn replace(
        &mut self,
        pending: PendingImpact,
        struck: Struck,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let mut text = format!(
            "impact \"{}\" is replaced by its later estimate: {} kg, {} m/s",
            pending.event_id,
            pending.striking.impact.mass,
            pending.striking.velocity()
        );
        if let Some(before) = self.course.take_back() {
            self.column.take_back(*before);
            self.journal.note_taken_back();
            text += "; its report no longer holds";
        }
        out.notice(NoticeLevel::Info, now, text);
        // It begins once more. Its samples are not given out until the instant that it had reached.
        let Some((before, reached)) = self.course.set_aside() else {
            return;
        };
        out.put(Output::Replaced(Arc::clone(&pending.event_id)));
        self.journal.note_impact(pending.striking.impact);
        self.course
            .begin(pending, before, struck, &mut self.column, Some(reached));
        self.status.set_changed();
    }

    // Events that are the same impact

    /// Whether an event is the same impact as an accepted one that the sensors have detected. It counts as evidence for later
    /// estimates then; its mass does if its sender has given one.
    fn merge(
        &mut self,
        event_id: &Arc<str>,
        contact: Nanos,
        striking: &Striking,
        has_mass: bool,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> bool {
        let EstimationSettings {
            merge_window: window,
            event_mass_deviation: mass_deviation,
            event_velocity_deviation: velocity_deviation,
            ..
        } = *self.estimation();
        let Some(estimate_id) = self.estimates.merge(event_id, contact, window) else {
            return false;
        };
        self.registry.merge(Arc::clone(event_id));
        self.note_change_at_rest();
        let text = format!(
            "impact event \"{event_id}\" is merged with \"{estimate_id}\", the same impact, which the sensors have detected"
        );
        out.notice(NoticeLevel::Info, now, text);
        out.put(Output::Merged(MergedEvent {
            event_id: Arc::clone(event_id),
            estimate_id,
            contact,
            striking: striking.clone(),
            evidence: EventEvidence {
                event_id: Arc::clone(event_id),
                mass: if has_mass {
                    striking.impact.mass
                } else {
                    f64::NAN
                },
                mass_deviation,
                velocity: striking.impact.velocity,
                velocity_deviation,
            },
        }));
        true
    }

    /// Links an impact that the sensors have detected, and that was not decided, with the event that is the same impact, if there
    /// is one.
    fn link_with_event(&mut self, now: Nanos, out: &mut impl Outputs) {
        let window = self.estimation().merge_window;
        if let Some(linked) = self.estimates.link(window) {
            let text = format!(
                "the impact \"{}\" that the sensors have detected is the same as impact event \"{}\", which the twin follows",
                linked.record.event_id,
                linked.event_id.as_deref().unwrap_or_default()
            );
            out.notice(NoticeLevel::Info, now, text);
            self.note_change_at_rest();
        }
    }
}

/// The impact of an estimate at this instant, and the column with it on its way.
fn estimated(
    record: &EstimateRecord,
    stamp: Nanos,
    striking: Striking,
    snapshot: &ColumnSnapshot,
    height: Option<f64>,
) -> Result<(PendingImpact, Struck), Rejection> {
    let struck = snapshot.strike(striking.impact, height)?;
    let pending = PendingImpact {
        event_id: Arc::clone(&record.event_id),
        stamp,
        striking,
        height,
    };
    Ok((pending, struck))
}
