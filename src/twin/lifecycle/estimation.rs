//! From an estimate to an impact: acceptance, following, and events that are the same impact.

use std::sync::Arc;

use super::Twin;
use crate::column::Phase;
use crate::estimation::{EstimateRecord, EventEvidence};
use crate::parameters::{AcceptEstimates, CatalogueVehicle, EstimationSettings, RIGID};
use crate::time::Nanos;
use crate::twin::command::{Accepted, EstimateDecision};
use crate::twin::course::ActiveResponse;
use crate::twin::estimates::{Decision, Sequence, contact, is_sure_enough};
use crate::twin::output::{EstimateOutput, MergedEvent, NoticeLevel, Output, Outputs};
use crate::twin::plant::Struck;
use crate::twin::registry::{PendingImpact, check_not_ahead};
use crate::twin::rejection::{Rejection, RejectionCode};
use crate::twin::striking::Striking;

impl Twin {
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
        let struck = snapshot.strike(striking.impact, height)?;
        let pending = PendingImpact {
            event_id: Arc::clone(&record.event_id),
            stamp,
            striking,
            height,
        };
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
        let struck = snapshot.strike(striking.impact, height)?;
        let pending = PendingImpact {
            event_id: Arc::clone(&record.event_id),
            stamp,
            striking,
            height,
        };
        Ok(Some((pending, struck)))
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
        self.begin_once_more(pending, struck, out);
    }

    // Events that are the same impact

    /// Whether an event is the same impact as an accepted one that the sensors have detected. It counts as evidence for later
    /// estimates then; its mass does if its sender has given one.
    pub(super) fn merge(
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

    /// An event was accepted: it is the impact that the sensors have detected or may still report.
    pub(super) fn link(
        &mut self,
        event_id: &Arc<str>,
        contact: Nanos,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        self.estimates.remember(Arc::clone(event_id), contact);
        self.link_with_event(now, out);
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

/// That the sensors have detected an impact, and what follows.
fn first_in_words(record: &EstimateRecord, accept: AcceptEstimates) -> String {
    let next = match accept {
        AcceptEstimates::Never => "it is only published (estimation.accept is never)",
        AcceptEstimates::Confirmation => "it becomes an impact when ~/confirm_estimate accepts it",
        AcceptEstimates::Automatic => {
            "it becomes an impact when its estimate is reliable enough, at the latest with the final one"
        }
    };
    let id = &record.event_id;
    format!("the sensors have detected an impact, \"{id}\"; {next}")
}

/// What hits the column according to an estimate, in the plane of the two bars, which is all that the sensors say.
fn striking_of(record: &EstimateRecord) -> Striking {
    Striking {
        vehicle: vehicle_name(record),
        impact: record.best,
        travel: None,
    }
}

/// The name of the vehicle that follows an estimate: the most probable one that is no rigid mass; empty where it is none of
/// the catalogue.
pub(crate) fn vehicle_name(record: &EstimateRecord) -> Arc<str> {
    if record.best.vehicle.is_none() {
        return RIGID.into();
    }
    let names = record.estimate.vehicle_probabilities.iter();
    let mut names = names
        .map(|(name, _)| name.as_str())
        .filter(|it| *it != RIGID);
    let name = names.next().and_then(CatalogueVehicle::named);
    name.map_or("", |it| it.name.as_str()).into()
}
