//! The state of the twin itself, and when to report it.

use std::sync::Arc;

use super::STATUS_PERIOD;
use super::assessed::Assessed;
use super::damage_correction::DamageCorrection;
use super::life::Life;
use super::plant::{Condition, Plant, Struck};
use super::registry::{Counts, LastRejection, Registry};
use super::rejection::RejectionCode;
use crate::assessment::VerdictRange;
use crate::column::{HINGES, Phase, Sample, VehicleReport, WEBS};
use crate::study::VehicleLimits;
use crate::time::Nanos;

/// Undeformed lengths of the two bars \[m\], and what holds the upper one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Of the lower one: the height of hinges 1a and 1b above the base.
    pub below: f64,
    /// Of the upper one.
    pub above: f64,
    /// Whether nothing holds the top, so that the upper bar goes on straight.
    pub top_is_free: bool,
}

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
    /// They have separated and the column vibrates.
    Free,
    /// The response is over: only in the last sample of a response.
    Rest,
    /// The column has lost its shape or its equilibrium; the twin waits for a reset.
    Collapsed,
    /// A hinge of the column is fractured; the twin waits for a reset.
    Fractured,
    /// The twin cannot continue and waits for a reset.
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

impl Condition {
    /// The phase of the last sample of a response that leaves the column in this condition.
    pub(super) fn final_phase(&self) -> TwinPhase {
        match self {
            Self::Standing => TwinPhase::Rest,
            Self::Collapsed => TwinPhase::Collapsed,
            Self::Fractured => TwinPhase::Fractured,
            Self::Faulted(_) => TwinPhase::Faulted,
        }
    }
}

/// The state of the twin itself: what it has accepted and rejected, and the damage of the column. A copy costs no memory:
/// its texts are shared.
#[derive(Debug, Clone, PartialEq)]
pub struct Status {
    /// When it was taken.
    pub stamp: Nanos,
    /// Where column and twin are.
    pub phase: TwinPhase,
    /// The present impact, or the last one; empty before the first.
    pub event_id: Arc<str>,
    /// Counts since the start of the program.
    pub counts: Counts,
    /// Why the last event or change of parameters was rejected, for programs; `None` if none was.
    pub last_rejection_code: Option<RejectionCode>,
    /// The same in words; empty if none was.
    pub last_rejection_reason: Arc<str>,
    /// Identifier of the last rejected event; empty if none was, or if it was a change of parameters.
    pub last_rejection_event_id: Arc<str>,
    /// Why the twin cannot continue; empty unless `phase` is `Faulted`.
    pub fault: Arc<str>,
    /// The impact that the sensors have detected and that waits for somebody to confirm it; empty if there is none.
    pub waiting_estimate: Arc<str>,
    /// Accepted impacts since the last reset.
    pub impacts_since_reset: u32,
    /// Measurements by which the damage was corrected or confirmed since the last reset.
    pub corrections_since_reset: u32,
    /// The last of them; `None` without one.
    pub last_correction: Option<DamageCorrection>,
    /// Whether the column may have a damage that the twin does not know, because its state file could not be used.
    pub is_damage_unknown: bool,
    /// `v1` of the column at rest: the visible damage \[m\].
    pub residual_v1: f64,
    /// `u2` of the column at rest \[m\].
    pub residual_u2: f64,
    /// Work dissipated in the hinges since the last reset \[J\].
    pub plastic_work_since_reset: f64,
    /// Plastic rotation of each hinge since the last reset \[rad\].
    pub plastic_rotation: [f64; HINGES],
    /// Plastic elongation of each hinge since the last reset \[m\].
    pub plastic_elongation: [f64; HINGES],
    /// Plastic shear angle of the web of each bar since the last reset \[rad\].
    pub shear_angle: [f64; WEBS],
    /// The assessment of the column at rest, without the present impact; `None` if the column cannot be computed.
    pub assessed: Option<Arc<Assessed>>,
    /// The critical velocities of the column at rest; `None` if they are not known, and during a response.
    pub critical_velocities: Option<Arc<[VehicleLimits]>>,
    /// The range of the verdict on the last impact that has ended; `None` if it is not known.
    pub range: Option<Arc<VerdictRange>>,
    /// The vehicle of the last response that has ended.
    pub vehicle: VehicleReport,
    /// Estimated relative error of the peak `v1` of the last response; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// Undeformed lengths of the bars: those of the response, or of the column at rest.
    pub lengths: Lengths,
    /// The column, for displays; `None` during a response.
    pub at_rest: Option<RestingColumn>,
}

/// The column at rest, as a display needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct RestingColumn {
    /// The values.
    pub sample: Sample,
    /// Undeformed lengths of the bars.
    pub lengths: Lengths,
    /// Whether no response has shown the column since the start of the program or the last reset.
    pub is_unseen: bool,
}

/// What is known about the column at rest, and about what the sensors have detected.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judgement<'a> {
    /// The column.
    pub at_rest: &'a Plant,
    /// What it has been through.
    pub life: &'a Life,
    /// Its assessment.
    pub assessed: Option<&'a Arc<Assessed>>,
    /// Its critical velocities.
    pub critical: Option<&'a Arc<[VehicleLimits]>>,
    /// The range of the verdict on its last impact.
    pub range: Option<&'a Arc<VerdictRange>>,
    /// The impact that waits for somebody to confirm it.
    pub waiting_estimate: Option<&'a Arc<str>>,
}

impl Status {
    /// The status at `now`; `struck` is the column where it is responding to an impact, `responses` those that have begun since
    /// the start of the program.
    pub(super) fn new(
        now: Nanos,
        phase: TwinPhase,
        registry: &Registry,
        judgement: &Judgement<'_>,
        struck: Option<&Struck>,
        responses: u64,
    ) -> Self {
        let Judgement { at_rest, life, .. } = *judgement;
        let sample_at_rest = at_rest.state.sample(&at_rest.model);
        let (sample, plastic_work) = match struck {
            None => (sample_at_rest, 0.0),
            Some(Struck { model, state, .. }) => (state.sample(model), state.ledger.plastic_work),
        };
        let Sample { hinges, webs, .. } = sample;
        let last = life.last_impact.as_ref();
        let rejected = registry.last_rejection();
        let text = |text: fn(&LastRejection) -> &Arc<str>| {
            rejected.map(|it| Arc::clone(text(it))).unwrap_or_default()
        };
        Self {
            stamp: now,
            phase,
            event_id: Arc::clone(&life.last_event_id),
            counts: registry.counts(),
            last_rejection_code: rejected.map(|it| it.rejection.code),
            last_rejection_reason: text(|it| &it.rejection.reason),
            last_rejection_event_id: text(|it| &it.event_id),
            fault: match &at_rest.condition {
                Condition::Faulted(reason) => Arc::clone(reason),
                Condition::Standing | Condition::Collapsed | Condition::Fractured => Arc::default(),
            },
            waiting_estimate: judgement.waiting_estimate.cloned().unwrap_or_default(),
            impacts_since_reset: life.impacts_since_reset,
            corrections_since_reset: life.corrections_since_reset,
            last_correction: life.last_correction,
            is_damage_unknown: life.is_damage_unknown,
            residual_v1: sample_at_rest.v1,
            residual_u2: sample_at_rest.u2,
            plastic_work_since_reset: life.plastic_work_since_reset + plastic_work,
            plastic_rotation: hinges.map(|hinge| hinge.plastic_rotation),
            plastic_elongation: hinges.map(|hinge| hinge.plastic_elongation),
            shear_angle: webs.map(|web| web.plastic_angle),
            assessed: judgement.assessed.map(Arc::clone),
            critical_velocities: judgement.critical.map(Arc::clone),
            range: judgement.range.map(Arc::clone),
            vehicle: last.map_or_else(VehicleReport::default, |it| it.vehicle),
            error_estimate: last.and_then(|it| it.error_estimate),
            lengths: Lengths::from(&struck.map_or(&at_rest.model, |it| &it.model).properties),
            at_rest: struck.is_none().then(|| RestingColumn {
                sample: sample_at_rest,
                lengths: Lengths::from(&at_rest.model.properties),
                is_unseen: responses == 0 || life.last_event_id.is_empty(),
            }),
        }
    }
}

/// When the last status was reported, and whether another one is due.
#[derive(Debug, Clone, Copy)]
pub(super) struct StatusClock {
    last: Nanos,
    phase: TwinPhase,
    changed: bool,
}

impl StatusClock {
    pub fn new(now: Nanos) -> Self {
        Self {
            last: now,
            phase: TwinPhase::Idle,
            changed: true,
        }
    }

    /// Something has changed that a status contains.
    pub fn set_changed(&mut self) {
        self.changed = true;
    }

    /// Whether a status is due; if so, it counts as reported.
    pub fn is_due(&mut self, now: Nanos, phase: TwinPhase) -> bool {
        // A clock that was set back must not silence the twin.
        let long_ago = now < self.last || now.saturating_sub(self.last) >= STATUS_PERIOD;
        let due = self.changed || long_ago || phase != self.phase;
        if due {
            *self = Self {
                last: now,
                phase,
                changed: false,
            };
        }
        due
    }

    /// When the next status is due.
    pub fn next_deadline(&self, now: Nanos) -> Nanos {
        match self.changed {
            true => now,
            false => self
                .last
                .saturating_add(STATUS_PERIOD)
                .min(now.saturating_add(STATUS_PERIOD)),
        }
    }
}
