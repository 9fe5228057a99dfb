//! What the sensors have detected: the newest estimate, what has become of it, and which events may be the same impact. Knows
//! nothing of the mechanics.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::estimation::{CredibleInterval, EstimateRecord, FEWEST_RESPONSES};
use crate::parameters::EstimationSettings;
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

    pub(super) fn newest_mut(&mut self) -> Option<&mut SensedImpact> {
        self.newest.as_mut()
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

    /// The newest impact that the sensors have detected, if an event with this instant of contact is the same.
    pub(super) fn same_impact(&mut self, instant: Nanos, window: f64) -> Option<&mut SensedImpact> {
        let newest = self.newest.as_mut()?;
        is_within(newest.contact(), instant, window).then_some(newest)
    }

    /// Remembers an accepted event, because an estimate of the same impact may follow.
    pub(super) fn remember(&mut self, event_id: Arc<str>, instant: Nanos) {
        if self.contacts.len() == MAX_CONTACTS {
            self.contacts.remove(0);
        }
        self.contacts.push(Contact { event_id, instant });
    }

    /// Takes the event that is the same impact as one with this instant of contact: the nearest one.
    pub(super) fn take_event(&mut self, instant: Nanos, window: f64) -> Option<Arc<str>> {
        let near = self.contacts.iter().enumerate();
        let near = near.filter(|(_, it)| is_within(it.instant, instant, window));
        let (index, _) = near.min_by_key(|(_, it)| it.instant.abs_diff(instant))?;
        Some(self.contacts.remove(index).event_id)
    }
}

fn is_within(one: Nanos, other: Nanos, window: f64) -> bool {
    seconds(one.abs_diff(other)) <= window
}
