//! The response to an impact under way: its outputs, and what is predicted of its end.

use std::sync::Arc;

use super::assessed::{Assessed, LastImpact};
use super::begun_impact::BegunImpact;
use super::forecast::Forecast;
use super::opinion_state::KnownBeamDamage;
use super::output::{Output, Outputs, StateOutput, StrikingVehicle};
use super::plant::Plant;
use super::status::{Lengths, TwinPhase};
use super::timeline::Timeline;
use crate::assessment::VerdictRange;
use crate::time::Nanos;

/// The response to an impact.
#[derive(Debug)]
pub(super) struct ActiveResponse {
    pub impact: BegunImpact,
    /// The column without the impact: at rest, or in motion after an earlier one.
    pub before: Plant,
    pub timeline: Timeline,
    pub forecast: Forecast,
    /// Until this instant its samples are not given out, because an earlier estimate of the same impact has given out some.
    pub silent_until: Option<Nanos>,
    /// The range of the verdict in the forecast, once it is known.
    pub range: Option<Arc<VerdictRange>>,
    /// The damage that the beam leaves, once it is known.
    pub beam_after: Option<KnownBeamDamage>,
}

/// A response that is over.
#[derive(Debug)]
pub(super) struct LastResponse {
    pub response: Box<ActiveResponse>,
    /// The twin before it, as long as it can be resumed; in memory of its own, because most columns of a fleet have none.
    pub before: Option<Box<BeforeResponse>>,
}

/// What a response that is over has changed in the twin.
#[derive(Debug)]
pub(super) struct BeforeResponse {
    /// Work dissipated before it since the last reset \[J\].
    pub plastic_work: f64,
    /// The column at rest.
    pub at_rest: Plant,
    /// Its assessment.
    pub assessed: Option<Arc<Assessed>>,
    /// The impact before.
    pub last_impact: Option<LastImpact>,
    /// The damage as the beam knew it.
    pub beam: KnownBeamDamage,
}

impl ActiveResponse {
    pub fn newton_iterations(&self) -> u64 {
        self.timeline.plant().state.newton_iterations
    }

    /// Gives out the sample that is due, unless it is to be silent.
    pub fn put_due_state(&mut self, out: &mut impl Outputs) {
        let instant = self.timeline.instant_of(self.timeline.step());
        match self.silent_until.is_some_and(|until| instant <= until) {
            true => drop(self.timeline.take_sample()),
            false => self.put_state(None, out),
        }
    }

    /// Gives out the state of the present step; `phase` where it is not that of the sample.
    pub fn put_state(&mut self, phase: Option<TwinPhase>, out: &mut impl Outputs) {
        let sample = self.timeline.take_sample();
        let properties = &self.timeline.plant().model.properties;
        let lengths = Lengths::from(properties);
        let BegunImpact {
            event_id, striking, ..
        } = &self.impact;
        out.put(Output::State(StateOutput {
            stamp: self.timeline.instant_of(self.timeline.step()),
            event_id: Arc::clone(event_id),
            phase: phase.unwrap_or(sample.phase.into()),
            sample,
            lengths: Some(lengths),
            vehicle: Some(StrikingVehicle {
                name: Arc::clone(&striking.vehicle),
                mass: striking.impact.mass,
                direction: striking.direction(),
            }),
        }));
    }
}
