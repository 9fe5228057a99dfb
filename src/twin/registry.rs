//! The registry: identifiers and stamps of impacts, what was accepted and rejected, and impacts that are still to come. Knows
//! nothing of the mechanics.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::rejection::{Rejection, RejectionCode, truncated};
use super::seen_ids::SeenIds;
use super::striking::Striking;
use super::withdrawn_impact::WithdrawnImpact;
use crate::parameters::Parameters;
use crate::time::seconds;
use crate::time::{INVALID_STAMP, INVALID_STAMP_REASON, Nanos};
use printable::{Printable, is_printable};

/// Longest identifier of an event in characters.
pub const MAX_EVENT_ID_CHARS: usize = 255;

/// Most accepted impacts that may be still to come while the column is responding to another one.
pub const MAX_IMPACTS_AHEAD: usize = 8;

const CHECK_CLOCKS: &str = "check that the sender and the twin have the same clock";

/// What was accepted and rejected since the start of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Impact events accepted, and impacts accepted that the sensors have detected.
    pub events_accepted: u64,
    /// Impact events that are the same impact as one that the sensors have detected: neither accepted nor rejected.
    pub events_merged: u64,
    /// Impact events rejected.
    pub events_rejected: u64,
    /// Changes of parameters accepted.
    pub parameters_accepted: u64,
    /// Changes of parameters rejected.
    pub parameters_rejected: u64,
}

/// The last rejection since the start of the program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LastRejection {
    /// Why.
    pub rejection: Rejection,
    /// Identifier of the rejected impact, shortened where it is too long; empty for a change of parameters.
    pub event_id: Arc<str>,
}

/// Which kind of command was rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedInput {
    /// An impact event.
    Impact,
    /// A change of parameters.
    Parameters,
    /// A decision about an impact that the sensors have detected. It is not counted.
    Estimate,
    /// A correction of the damage. It is not counted.
    DamageCorrection,
}

/// A command that was rejected and has changed nothing.
#[derive(Debug, Clone)]
pub struct Rejected {
    /// When.
    pub stamp: Nanos,
    /// What.
    pub what: RejectedInput,
    /// Why, for its sender.
    pub rejection: Rejection,
    /// Identifier of a rejected impact, shortened where it is too long; otherwise empty.
    pub event_id: Arc<str>,
    /// The sender of anything but an impact; otherwise empty.
    pub source: Arc<str>,
}

/// An accepted impact that has not begun.
#[derive(Debug)]
pub(super) struct PendingImpact {
    pub event_id: Arc<str>,
    pub stamp: Nanos,
    pub striking: Striking,
    /// Above the base \[m\]; `None`: where the parameters have it.
    pub height: Option<f64>,
}

impl From<&PendingImpact> for WithdrawnImpact {
    fn from(impact: &PendingImpact) -> Self {
        Self {
            stamp: impact.stamp,
            event_id: Arc::clone(&impact.event_id),
            striking: impact.striking.clone(),
        }
    }
}

#[derive(Debug)]
pub(super) struct Registry {
    seen: SeenIds,
    /// In the order of their stamps.
    pending: Vec<PendingImpact>,
    counts: Counts,
    last_rejection: Option<LastRejection>,
}

impl Registry {
    /// With the identifiers of accepted impacts, and what was accepted and rejected since the start of the program.
    pub fn new(
        seen_ids: &[Arc<str>],
        counts: Counts,
        last_rejection: Option<LastRejection>,
    ) -> Self {
        Self {
            seen: SeenIds::of(seen_ids),
            pending: Vec::new(),
            counts,
            last_rejection,
        }
    }

    /// What was accepted and rejected since the start of the program.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The last rejection since the start of the program.
    pub fn last_rejection(&self) -> Option<&LastRejection> {
        self.last_rejection.as_ref()
    }

    /// Identifiers of accepted impacts, the oldest first.
    pub fn seen_ids(&self) -> Vec<Arc<str>> {
        self.seen.to_vec()
    }

    /// # Errors
    /// The identifier is not a valid one, or was used before.
    pub fn check_event_id(&self, id: &str) -> Result<(), Rejection> {
        if let Some(reason) = event_id_fault(id) {
            return Err(Rejection::new(RejectionCode::EventIdInvalid, reason));
        }
        if self.seen.contains(id) {
            let reason = "an impact with this event_id was accepted before; give every impact its own identifier";
            return Err(Rejection::new(RejectionCode::EventIdRepeated, reason));
        }
        Ok(())
    }

    /// Takes note of an accepted impact.
    pub fn accept(&mut self, event_id: Arc<str>) {
        self.seen.remember(event_id);
        self.counts.events_accepted += 1;
    }

    /// Takes note of an event that is the same impact as one that the sensors have detected.
    pub fn merge(&mut self, event_id: Arc<str>) {
        self.seen.remember(event_id);
        self.counts.events_merged += 1;
    }

    /// Takes an acceptance back: the impact was still to come and is rejected after all, so that no impact is counted
    /// twice.
    pub fn withdraw(&mut self) {
        let accepted = &mut self.counts.events_accepted;
        *accepted = accepted.saturating_sub(1);
    }

    /// Counts an accepted change of parameters.
    pub fn accept_change(&mut self) {
        self.counts.parameters_accepted += 1;
    }

    /// Counts a rejected impact.
    pub fn reject_impact(&mut self, event_id: &str, rejection: Rejection, now: Nanos) -> Rejected {
        self.counts.events_rejected += 1;
        let event_id = printable(event_id).into();
        self.reject(RejectedInput::Impact, rejection, event_id, "".into(), now)
    }

    /// Keeps a rejected request, whose sender has an answer, as the last rejection, and counts a change of parameters.
    pub fn reject_request(
        &mut self,
        what: RejectedInput,
        rejection: Rejection,
        source: &Arc<str>,
        now: Nanos,
    ) -> Rejected {
        self.counts.parameters_rejected += u64::from(what == RejectedInput::Parameters);
        self.reject(what, rejection, "".into(), Arc::clone(source), now)
    }

    fn reject(
        &mut self,
        what: RejectedInput,
        rejection: Rejection,
        event_id: Arc<str>,
        source: Arc<str>,
        now: Nanos,
    ) -> Rejected {
        self.last_rejection = Some(LastRejection {
            rejection: rejection.clone(),
            event_id: Arc::clone(&event_id),
        });
        Rejected {
            stamp: now,
            what,
            rejection,
            event_id,
            source,
        }
    }

    /// Keeps an impact until the column gets there.
    ///
    /// # Errors
    /// Too many are kept already.
    pub fn keep_pending(&mut self, impact: PendingImpact) -> Result<(), Rejection> {
        if self.pending.len() == MAX_IMPACTS_AHEAD {
            let reason = format!(
                "{MAX_IMPACTS_AHEAD} accepted impacts are still to come; send impacts when they happen"
            );
            return Err(Rejection::new(RejectionCode::TooManyImpactsAhead, reason));
        }
        let place = self
            .pending
            .partition_point(|other| other.stamp <= impact.stamp);
        self.pending.insert(place, impact);
        Ok(())
    }

    /// Stamp of the next impact to come.
    pub fn next_pending(&self) -> Option<Nanos> {
        self.pending.first().map(|next| next.stamp)
    }

    /// The impacts that are still to come, in the order of their stamps.
    pub fn pending(&self) -> impl Iterator<Item = &PendingImpact> {
        self.pending.iter()
    }

    /// The impact with this identifier, if it is still to come.
    pub fn pending_mut(&mut self, event_id: &str) -> Option<&mut PendingImpact> {
        let mut pending = self.pending.iter_mut();
        pending.find(|it| *it.event_id == *event_id)
    }

    pub fn take_pending(&mut self) -> Option<PendingImpact> {
        (!self.pending.is_empty()).then(|| self.pending.remove(0))
    }

    /// The impacts that are still to come, in words; `None` if there are none.
    pub fn pending_in_words(&self) -> Option<String> {
        let names: Vec<_> = self
            .pending
            .iter()
            .map(|pending| format!("\"{}\"", pending.event_id))
            .collect();
        (!names.is_empty()).then(|| {
            format!(
                "accepted impacts that are still to come: {}",
                names.join(", ")
            )
        })
    }

    /// Forgets everything since the last reset; the counts continue.
    pub fn reset(&mut self) {
        self.pending.clear();
        self.seen.clear();
    }
}

/// # Errors
/// Another column is meant.
pub(super) fn check_column_id(own: &str, found: &str) -> Result<(), Rejection> {
    if own == found {
        return Ok(());
    }
    let reason = format!(
        "column_id is \"{}\", but this is the twin of column \"{own}\"",
        printable(found)
    );
    Err(Rejection::new(RejectionCode::OtherColumn, reason))
}

/// Why no event can have this identifier; `None` if one can.
#[must_use]
pub fn event_id_fault(id: &str) -> Option<String> {
    let chars = id.chars().take(MAX_EVENT_ID_CHARS + 1).count();
    if chars == 0 {
        return Some("event_id is empty; give every impact its own identifier".to_owned());
    }
    let is_invalid = chars > MAX_EVENT_ID_CHARS || id.chars().any(|c| !is_printable(c));
    is_invalid.then(|| {
        format!(
            "event_id is too long or contains control characters; \
             allowed: 1 to {MAX_EVENT_ID_CHARS} characters, no control or invisible characters"
        )
    })
}

/// # Errors
/// The stamp is too old or too far ahead.
pub(super) fn check_stamp(
    stamp: Nanos,
    now: Nanos,
    parameters: &Parameters,
) -> Result<(), Rejection> {
    if stamp == INVALID_STAMP {
        return Err(Rejection::new(
            RejectionCode::ImpactOutOfRange,
            INVALID_STAMP_REASON,
        ));
    }
    let tolerance = &parameters.settings().event;
    let off = seconds(stamp.abs_diff(now));
    if stamp == 0 && now != 0 && off > tolerance.max_age {
        let reason = "the stamp is zero, as in a message in which it was not set; set header.stamp to the time of the impact \
                      (with ros2 topic pub: `stamp: now`)";
        return Err(Rejection::new(RejectionCode::StampTooOld, reason));
    }
    if stamp <= now && off > tolerance.max_age {
        let reason = format!(
            "the stamp is {off} s old; event.max_age is {} s; {CHECK_CLOCKS}",
            tolerance.max_age
        );
        return Err(Rejection::new(RejectionCode::StampTooOld, reason));
    }
    check_not_ahead(stamp, now, parameters)
}

/// # Errors
/// The stamp is too far ahead.
pub(super) fn check_not_ahead(
    stamp: Nanos,
    now: Nanos,
    parameters: &Parameters,
) -> Result<(), Rejection> {
    let tolerance = &parameters.settings().event;
    let off = seconds(stamp.abs_diff(now));
    if now == 0 && off > tolerance.max_ahead {
        let reason = "the clock of the twin is zero: use_sim_time is true, but no message on /clock has arrived";
        return Err(Rejection::new(RejectionCode::StampTooFarAhead, reason));
    }
    if stamp > now && off > tolerance.max_ahead {
        let reason = format!(
            "the stamp is {off} s ahead; event.max_ahead is {} s; {CHECK_CLOCKS}",
            tolerance.max_ahead
        );
        return Err(Rejection::new(RejectionCode::StampTooFarAhead, reason));
    }
    Ok(())
}

/// A name from outside as it may appear in a message: of bounded length, without characters that a terminal would obey.
pub(super) fn printable(name: &str) -> String {
    Printable(&truncated(name, MAX_EVENT_ID_CHARS)).to_string()
}
