//! How the twin itself is.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::input::Nanos;
use super::journal::{Journal, StatusTaken};
use super::output::{Notice, Output, Outputs, Severity};
use super::present::Condition;
use super::{Reported, STATUS_PERIOD, Twin};
use crate::column::{HINGES, Phase};

/// Where column and twin are in the course of an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TwinPhase {
    /// At rest, waiting for an impact.
    #[default]
    Idle,
    /// The impactor has not touched the column yet.
    Approach,
    /// Impactor and column move together.
    Contact,
    /// They have parted and the column vibrates.
    Free,
    /// The response is over: only in the last sample of a response.
    Rest,
    /// The column has lost its shape or its equilibrium; it waits for a reset.
    Collapsed,
    /// The twin cannot go on; it waits for a reset.
    Faulted,
}

impl From<Phase> for TwinPhase {
    fn from(phase: Phase) -> Self {
        match phase {
            Phase::Idle => Self::Idle,
            Phase::Approach => Self::Approach,
            Phase::Contact => Self::Contact,
            Phase::Free => Self::Free,
        }
    }
}

/// How the twin itself is: what it accepted and refused, and the damage that the column carries. A copy costs no
/// memory: its texts are shared.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// When it was taken.
    pub stamp: Nanos,
    /// Where column and twin are.
    pub phase: TwinPhase,
    /// The impact that is going on, or the last one; empty before the first.
    pub event_id: Arc<str>,
    /// Counts since the start of the program.
    pub counts: Counts,
    /// Why the last event or change of parameters was refused; empty if none was.
    pub last_refusal_reason: Arc<str>,
    /// Identifier of the last refused event; empty if none was, or if it was a change of parameters.
    pub last_refusal_event_id: Arc<str>,
    /// Why the twin cannot go on; empty unless `phase` is `Faulted`.
    pub fault: Arc<str>,
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// `v1` of the column at rest: the damage that can be seen \[m\].
    pub residual_v1: f64,
    /// `u2` of the column at rest \[m\].
    pub residual_u2: f64,
    /// Work dissipated in the hinges since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// Plastic rotation of each hinge since the last reset \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// Plastic elongation of each hinge since the last reset \[m\].
    pub plastic_elongation: [f64; HINGES],
}

/// What was accepted and refused since the start of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Impact events accepted.
    pub events_accepted: u64,
    /// Impact events refused.
    pub events_refused: u64,
    /// Changes of parameters accepted.
    pub parameters_accepted: u64,
    /// Changes of parameters refused.
    pub parameters_refused: u64,
}

impl Twin {
    pub(super) fn notice(
        &self,
        severity: Severity,
        text: String,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        out.put(Output::Notice(Notice {
            stamp: now,
            severity,
            text: text.into(),
        }));
    }

    pub(super) fn phase(&self) -> TwinPhase {
        match (&self.condition, &self.run) {
            (Condition::Collapsed, _) => TwinPhase::Collapsed,
            (Condition::Faulted(_), _) => TwinPhase::Faulted,
            (Condition::Standing, Some(run)) => run.phase(),
            (Condition::Standing, None) => TwinPhase::Idle,
        }
    }

    /// How the twin is now.
    pub fn status(&self, now: Nanos) -> Status {
        let present = self.at_rest.state.sample(&self.at_rest.model);
        let plastic_work = self
            .run
            .as_ref()
            .map_or(0.0, |run| run.state.ledger.plastic_work);
        let hinges = match &self.run {
            Some(run) => run.state.sample(&run.model).hinges,
            None => present.hinges,
        };
        let mut plastic_rotation = [0.0; HINGES];
        let mut plastic_elongation = [0.0; HINGES];
        for (index, hinge) in hinges.iter().enumerate() {
            plastic_rotation[index] = hinge.plastic_rotation;
            plastic_elongation[index] = hinge.plastic_elongation;
        }
        Status {
            stamp: now,
            phase: self.phase(),
            event_id: Arc::clone(&self.life.last_event_id),
            counts: self.counts,
            last_refusal_reason: Arc::clone(&self.last_refusal_reason),
            last_refusal_event_id: Arc::clone(&self.last_refusal_event_id),
            fault: match &self.condition {
                Condition::Faulted(reason) => Arc::clone(reason),
                Condition::Standing | Condition::Collapsed => Arc::default(),
            },
            impacts_since_reset: self.life.impacts,
            residual_v1: present.v1,
            residual_u2: present.u2,
            plastic_work_since_reset: self.life.plastic_work + plastic_work,
            plastic_rotation,
            plastic_elongation,
        }
    }

    pub(super) fn report_status(&mut self, now: Nanos, out: &mut impl Outputs) {
        let phase = self.phase();
        let Reported {
            at,
            phase: last,
            due,
        } = self.reported;
        // A clock that was set back must not silence the twin.
        let long_ago = now < at || now.saturating_sub(at) >= STATUS_PERIOD;
        if due || long_ago || phase != last {
            out.put(Output::Journal(Journal::Status(StatusTaken {
                next_number: self.journal.next_number(),
                stamp: now,
                position: self.position(),
            })));
            out.put(Output::Status(self.status(now)));
            self.reported = Reported {
                at: now,
                phase,
                due: false,
            };
        }
    }
}
