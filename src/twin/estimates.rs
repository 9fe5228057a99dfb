//! What the sensors have detected: the newest estimate, what has become of it, and which events may be the same impact. Knows
//! nothing of the mechanics.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::command::EstimateDecision;
use super::registry::printable;
use super::rejection::{Rejection, RejectionCode};
use super::striking::Striking;
use crate::estimation::{CredibleInterval, EstimateRecord, FEWEST_RESPONSES};
use crate::parameters::{AcceptEstimates, CatalogueVehicle, EstimationSettings, RIGID};
use crate::time::{Nanos, seconds};

/// Events whose instants of contact are remembered, because an estimate of the same impact may follow.
const MAX_CONTACTS: usize = 16;

/// What has become of an impact that the sensors have detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    /// Nothing yet.
    Pending,
    /// It is an impact of the twin.
    Accepted,
    /// An event has reported it, and the twin follows the event.
    Merged,
    /// An operator has declined it: it is no impact.
    Declined,
    /// The column could not take it.
    Rejected,
}

/// An impact that the sensors have detected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SensedImpact {
    /// The newest estimate.
    pub record: Arc<EstimateRecord>,
    pub decision: Decision,
    /// The event that is the same impact.
    pub event_id: Option<Arc<str>>,
}

/// An event without an estimate of the same impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contact {
    event_id: Arc<str>,
    instant: Nanos,
}

/// What the sensors have detected since the last reset.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimates {
    newest: Option<SensedImpact>,
    /// The oldest first.
    contacts: Vec<Contact>,
    /// Impacts before this instant, that of the last reset, no longer count.
    forgotten_until: Nanos,
    /// The newest impact has changed, which is given out once the journal has what has changed it.
    #[serde(skip)]
    has_changed: bool,
}

/// How an estimate follows those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sequence {
    /// The first one of an impact.
    First,
    /// A later one of the same impact.
    Update,
    /// It does not: the final one or a later one is known, or the impact was before the last reset.
    Late,
}

impl SensedImpact {
    /// Its mean instant of contact.
    pub fn contact(&self) -> Nanos {
        contact(&self.record)
    }
}

/// The mean instant of contact of an estimate.
pub(super) fn contact(record: &EstimateRecord) -> Nanos {
    let since = (1e9 * record.estimate.contact_time.mean).round() as i64;
    record.origin.saturating_add(since)
}

/// Whether an estimate is sure enough to become an impact without anybody who confirms it.
pub(super) fn is_sure_enough(record: &EstimateRecord, settings: &EstimationSettings) -> bool {
    let estimate = &record.estimate;
    let CredibleInterval { mean, low, high } = estimate.momentum;
    let certainty = estimate.yielded.max(1.0 - estimate.yielded);
    // False where anything is not a number.
    high - low <= settings.momentum_width * mean
        && certainty >= settings.yield_certainty
        && estimate.effective_sample_size >= FEWEST_RESPONSES
}

impl Estimates {
    /// Forgets everything that happened before an instant.
    pub(super) fn reset(&mut self, now: Nanos) {
        *self = Self {
            forgotten_until: now,
            ..Self::default()
        };
    }

    /// The newest impact that the sensors have detected.
    pub(super) fn newest(&self) -> Option<&SensedImpact> {
        self.newest.as_ref()
    }

    /// What has become of it.
    pub(super) fn decision(&self) -> Decision {
        self.newest().map_or(Decision::Declined, |it| it.decision)
    }

    pub(super) fn decide(&mut self, decision: Decision) {
        if let Some(newest) = &mut self.newest {
            newest.decision = decision;
        }
        self.has_changed = true;
    }

    /// The impact that waits for somebody to confirm it.
    pub(super) fn waiting(&self, accept: AcceptEstimates) -> Option<&Arc<str>> {
        let waits = accept == AcceptEstimates::Confirmation && self.decision() == Decision::Pending;
        let newest = self.newest().filter(|_| waits);
        newest.map(|it| &it.record.event_id)
    }

    /// # Errors
    /// There is nothing to decide.
    pub(super) fn check_decision(
        &self,
        decision: &EstimateDecision,
        accept: AcceptEstimates,
    ) -> Result<(), Rejection> {
        let not_pending =
            |reason: String| Err(Rejection::new(RejectionCode::EstimateNotPending, reason));
        let wanted = decision.event_id.as_str();
        let Some(newest) = self.newest() else {
            let reason = "the sensors have detected no impact since the start or the last reset";
            return not_pending(reason.to_owned());
        };
        let id = &newest.record.event_id;
        if !wanted.is_empty() && *wanted != **id {
            return not_pending(format!(
                "the newest impact that the sensors have detected is \"{id}\", not \"{}\"; only the newest can be decided",
                printable(wanted)
            ));
        }
        match (&newest.event_id, newest.decision) {
            _ if accept == AcceptEstimates::Never => not_pending(format!(
                "the parameter estimation.accept is never, so that estimates do not become impacts; \
                 set it to confirmation to decide about \"{id}\""
            )),
            (_, Decision::Accepted) => not_pending(format!(
                "\"{id}\" is an impact of the twin already; only a reset takes it back (~/reset)"
            )),
            (event, Decision::Merged) => not_pending(format!(
                "\"{id}\" is the same impact as the event \"{}\", which the twin follows",
                event.as_deref().unwrap_or_default()
            )),
            (_, Decision::Pending | Decision::Declined | Decision::Rejected) => Ok(()),
        }
    }

    pub(super) fn set_changed(&mut self) {
        self.has_changed = true;
    }

    /// The newest impact, if it has changed since the last call.
    pub(super) fn take_changed(&mut self) -> Option<&SensedImpact> {
        let has_changed = std::mem::take(&mut self.has_changed);
        self.newest.as_ref().filter(|_| has_changed)
    }

    /// Takes an estimate; one of another impact is pending.
    pub(super) fn take(&mut self, record: &Arc<EstimateRecord>) -> Sequence {
        if contact(record) < self.forgotten_until {
            return Sequence::Late;
        }
        match &mut self.newest {
            Some(known) if known.record.event_id == record.event_id => {
                if known.record.is_final || known.record.update >= record.update {
                    return Sequence::Late;
                }
                known.record = Arc::clone(record);
                Sequence::Update
            }
            newest => {
                *newest = Some(SensedImpact {
                    record: Arc::clone(record),
                    decision: Decision::Pending,
                    event_id: None,
                });
                Sequence::First
            }
        }
    }

    /// Merges an event with this instant of contact with the newest impact, if that is the same and was accepted; its identifier.
    pub(super) fn merge(
        &mut self,
        event_id: &Arc<str>,
        instant: Nanos,
        window: f64,
    ) -> Option<Arc<str>> {
        let newest = self.newest.as_mut()?;
        let is_same = is_within(newest.contact(), instant, window);
        if !is_same || newest.decision != Decision::Accepted {
            return None;
        }
        newest.event_id = Some(Arc::clone(event_id));
        self.has_changed = true;
        Some(Arc::clone(&newest.record.event_id))
    }

    /// Remembers an accepted event, because an estimate of the same impact may follow.
    pub(super) fn remember(&mut self, event_id: Arc<str>, instant: Nanos) {
        if self.contacts.len() == MAX_CONTACTS {
            self.contacts.remove(0);
        }
        self.contacts.push(Contact { event_id, instant });
    }

    /// Merges the newest impact, if it was not decided, with the event that is the same impact, the nearest one; both, if there is one.
    pub(super) fn link(&mut self, window: f64) -> Option<&SensedImpact> {
        let newest = self.newest.as_mut()?;
        if !matches!(newest.decision, Decision::Pending | Decision::Rejected) {
            return None;
        }
        let instant = newest.contact();
        let near = self.contacts.iter().enumerate();
        let near = near.filter(|(_, it)| is_within(it.instant, instant, window));
        let (index, _) = near.min_by_key(|(_, it)| it.instant.abs_diff(instant))?;
        newest.event_id = Some(self.contacts.remove(index).event_id);
        newest.decision = Decision::Merged;
        self.has_changed = true;
        self.newest()
    }
}

fn is_within(one: Nanos, other: Nanos, window: f64) -> bool {
    seconds(one.abs_diff(other)) <= window
}

/// That the sensors have detected an impact, and what follows.
pub(super) fn first_in_words(record: &EstimateRecord, accept: AcceptEstimates) -> String {
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
pub(super) fn striking_of(record: &EstimateRecord) -> Striking {
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
