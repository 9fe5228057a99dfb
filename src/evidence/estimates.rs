//! The estimates of a recording: each is a command in its journal, and is computed again from the recorded measurements.

use std::collections::VecDeque;
use std::sync::Arc;

use super::comparison::{Difference, Place};
use super::measured::Measured;
use super::verification::Verification;
use crate::estimation::{
    EstimateRecord, EventEvidence, NotRecomputed, Recomputation, SensorComparison,
    SharedPreparations,
};
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::twin::{Command, MergedEvent};

/// Checks the estimates of a recording.
#[derive(Debug, Default)]
pub(super) struct EstimateCheck {
    pub measured: Measured,
    /// What is prepared for all columns.
    shared: SharedPreparations,
    /// The parameters of the twin, and those before them: the estimator may not have followed the last change yet when an
    /// impact came.
    parameters: [Option<Arc<Parameters>>; 2],
    /// The recomputation of the present impact.
    recomputation: Option<(Arc<Parameters>, Recomputation)>,
    /// The impact whose last estimate was computed again.
    compared: Option<Arc<str>>,
    /// Whether that estimate equals the recorded one, and its predictions have not been returned yet.
    is_new: bool,
    unchecked: Option<Unchecked>,
}

/// Estimates that were not computed again: of one impact, or for one reason.
#[derive(Debug)]
struct Unchecked {
    /// The impact of the first of them.
    event_id: Arc<str>,
    count: u64,
    /// Why the first of them was not.
    why: String,
}

impl EstimateCheck {
    /// Keeps measurements for this time \[ns\], and shares what is prepared with the checks of other columns.
    pub fn new(kept_for: Nanos, shared: SharedPreparations) -> Self {
        Self {
            measured: Measured::kept_for(kept_for),
            shared,
            ..Self::default()
        }
    }

    /// Takes the parameters that hold from now on.
    pub fn parameters(&mut self, parameters: &Arc<Parameters>) {
        let [now, before] = &mut self.parameters;
        if now.as_ref().is_none_or(|it| !Arc::ptr_eq(it, parameters)) {
            *before = now.replace(Arc::clone(parameters));
        }
    }

    /// Takes an estimate of the journal; the command with which the recomputed twin goes on.
    pub fn command(
        &mut self,
        recorded: &Arc<EstimateRecord>,
        merged: &VecDeque<MergedEvent>,
        place: &Place<'_>,
        found: &mut Verification,
    ) -> Command {
        found.estimates.recorded += 1;
        self.is_new = false;
        let is_continued = self.compared.take().as_ref() == Some(&recorded.event_id);
        let outcome = match self.measured.unknown() {
            Some(why) => Err(Why::Unknown(why.to_owned())),
            None => self.repeat(recorded, is_continued),
        };
        match outcome {
            Ok(computed) => {
                found.estimates.compared += 1;
                self.compared = Some(Arc::clone(&recorded.event_id));
                let computed = EstimateRecord {
                    events: events(recorded, merged),
                    ..computed
                };
                let difference = place.first_difference(&**recorded, &computed);
                self.is_new = difference.is_none();
                if let Some(difference) = difference {
                    found.estimates.differing += 1;
                    let field = format!("recorded estimate: {}", difference.field);
                    found.note_difference(Difference {
                        field,
                        ..difference
                    });
                }
            }
            Err(Why::Impossible(why)) => {
                found.estimates.compared += 1;
                found.estimates.differing += 1;
                let field = "recorded estimate";
                found.note_difference(place.difference(field, why, "one that can be computed"));
            }
            Err(Why::Unknown(why)) => {
                found.estimates.unchecked += 1;
                self.note_unchecked(&recorded.event_id, why, found);
            }
        }
        Command::Estimate(Arc::clone(recorded))
    }

    /// What each sensor has read against what the last estimate predicts, with the name of the impact; once, and only if the
    /// estimate was computed again and is the recorded one.
    pub fn take_comparisons(&mut self) -> Option<(Arc<str>, Vec<SensorComparison>)> {
        let event_id = self.compared.clone().filter(|_| self.is_new)?;
        self.is_new = false;
        let (_, recomputation) = self.recomputation.as_ref()?;
        Some((event_id, recomputation.comparisons()))
    }

    fn repeat(
        &mut self,
        recorded: &EstimateRecord,
        is_continued: bool,
    ) -> Result<EstimateRecord, Why> {
        let measured = &self.measured;
        let batch = |number| measured.batch(number);
        let why = |reason: NotRecomputed| {
            let may_be = match &reason {
                NotRecomputed::Lost { .. } => true,
                NotRecomputed::NotInOrder { .. } => !is_continued,
                NotRecomputed::Missing { missing, .. } => *missing < measured.next(),
                NotRecomputed::Impossible { .. } | NotRecomputed::Estimator(_) => false,
            };
            match may_be {
                true => Why::Unknown(reason.to_string()),
                false => Why::Impossible(reason.to_string()),
            }
        };
        let is_begun = recorded.update > 0;
        if let (true, Some((_, recomputation))) = (is_begun, &mut self.recomputation) {
            return recomputation.repeat(recorded, batch).map_err(why);
        }
        let mut first = None;
        for parameters in self.parameters.iter().flatten() {
            // What was prepared for an earlier impact may hold for this one.
            let prepared = self.recomputation.take();
            let prepared = prepared.filter(|(of, _)| Arc::ptr_eq(of, parameters));
            let new = || Recomputation::sharing(parameters, self.shared.clone());
            let prepared = prepared.unwrap_or_else(|| (Arc::clone(parameters), new()));
            let (_, recomputation) = self.recomputation.insert(prepared);
            let outcome = recomputation.repeat(recorded, batch).map_err(why);
            let is_same = outcome
                .as_ref()
                .is_ok_and(|it| Place::default().first_difference(recorded, it).is_none());
            if is_same {
                return outcome;
            }
            first.get_or_insert(outcome);
        }
        let unknown = "the parameters of the twin are not known".to_owned();
        first.unwrap_or(Err(Why::Unknown(unknown)))
    }

    fn note_unchecked(&mut self, event_id: &Arc<str>, why: String, found: &mut Verification) {
        match &mut self.unchecked {
            Some(unchecked) if unchecked.event_id == *event_id || unchecked.why == why => {
                unchecked.count += 1;
            }
            _ => {
                self.tell(found);
                self.unchecked = Some(Unchecked {
                    event_id: Arc::clone(event_id),
                    count: 1,
                    why,
                });
            }
        }
    }

    fn tell(&mut self, found: &mut Verification) {
        if let Some(Unchecked {
            event_id,
            count,
            why,
        }) = self.unchecked.take()
        {
            found.note_unchecked(format!(
                "{count} of the estimates, from one of \"{event_id}\" on, were not computed again: {why}; their messages \
                 are compared with the journal"
            ));
        }
    }

    /// Tells what was not checked.
    pub fn finish(mut self, found: &mut Verification) {
        self.tell(found);
    }
}

/// What the events that count for a recorded estimate say, by the twin that repeats the recorded one. An event that is not the same
/// impact for it is not among them.
fn events(recorded: &EstimateRecord, merged: &VecDeque<MergedEvent>) -> Vec<EventEvidence> {
    let own = |wanted: &EventEvidence| {
        let mut same = merged.iter().rev();
        let same = same.find(|it| {
            it.estimate_id == recorded.event_id && it.evidence.event_id == wanted.event_id
        });
        same.map(|it| it.evidence.clone())
    };
    recorded.events.iter().filter_map(own).collect()
}

/// Why an estimate was not computed again.
#[derive(Debug)]
enum Why {
    /// What it rests on is not known.
    Unknown(String),
    /// No estimator makes such an estimate of the recorded measurements.
    Impossible(String),
}
