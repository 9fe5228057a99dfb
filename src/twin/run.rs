//! A response under way, step by step with the clock.

use std::sync::Arc;

use super::input::Nanos;
use super::present::Met;
use super::status::TwinPhase;
use crate::column::{End, Model, Progress, Response, Sample, State, StepError};

/// Steps from one checkpoint to the next: the most that a late second impact makes the twin step anew, unless it is
/// later than all checkpoints.
const CHECKPOINT_STEPS: u64 = 256;

/// Longest time that is stepped over at once.
const MOST_NANOS_PER_TURN: u64 = 1_000_000;

/// Of the steps from one sample to the next, one in so many is left for the instant when the sample is due: a sample
/// leaves earlier by what the others take, as long as a step takes a fifth of its own time at the most.
const LAST_SHARE: u64 = 5;

/// Checkpoints that are kept, the oldest are overwritten.
const CHECKPOINTS: usize = 64;

/// A response under way.
#[derive(Debug)]
pub(super) struct Run {
    pub event_id: Arc<str>,
    /// Instant of step 0.
    pub stamp: Nanos,
    pub model: Model,
    pub state: State,
    pub response: Response,
    /// Steps from one sample to the next.
    pub steps_per_sample: u64,
    /// Step of the next sample.
    pub next_sample: u64,
    /// Since the last sample \[N s\].
    percussion: f64,
    /// What the steps have taken \[ns\].
    pub nanos: u64,
    /// The damage that it will leave has been kept, as it is forecast.
    pub is_kept: bool,
    history: History,
}

/// What one advance has led to.
#[derive(Debug)]
pub(super) enum Advanced {
    Running,
    Over(End),
    Failed(StepError),
}

impl Run {
    /// `history` is that of the run before, for its memory.
    pub fn new(
        event_id: Arc<str>,
        stamp: Nanos,
        met: Met,
        steps_per_sample: u64,
        mut history: History,
    ) -> Self {
        let Met {
            model,
            state,
            response,
        } = met;
        history.restart(&state, &response);
        Self {
            event_id,
            stamp,
            model,
            state,
            response,
            steps_per_sample,
            next_sample: 0,
            percussion: state.percussion,
            nanos: 0,
            is_kept: false,
            history,
        }
    }

    pub fn into_history(self) -> History {
        self.history
    }

    /// Number of the last step at or before an instant; `None` before the event.
    pub fn step_at(&self, instant: Nanos) -> Option<u64> {
        let since = u64::try_from(instant.checked_sub(self.stamp)?).ok()?;
        Some(since / self.model.properties.step_nanos)
    }

    /// Instant of the beginning of a step.
    pub fn instant_of(&self, step: u64) -> Nanos {
        let nanos = step.saturating_mul(self.model.properties.step_nanos);
        self.stamp.saturating_add_unsigned(nanos)
    }

    /// Steps that are made at a time, so that few are left to make when a sample is due.
    pub fn steps_per_turn(&self) -> u64 {
        let most = (MOST_NANOS_PER_TURN / self.model.properties.step_nanos).max(1);
        self.steps_per_sample.min(most)
    }

    /// The step that the next turn is to reach: the next sample, and before it one that leaves little to compute when it
    /// is due.
    pub fn next_turn(&self) -> u64 {
        let shortly_before = self
            .next_sample
            .saturating_sub(self.steps_per_sample / LAST_SHARE);
        let wanted = match self.state.step < shortly_before {
            true => shortly_before,
            false => self.next_sample,
        };
        wanted.min(self.state.step + self.steps_per_turn())
    }

    /// Advances towards a step, past the next sample's never.
    pub fn advance(&mut self, target: u64) -> Advanced {
        let target = target.min(self.next_sample);
        let stride = target.saturating_sub(self.state.step);
        if stride == 0 {
            return Advanced::Running;
        }
        let made = self.response.advance(&self.model, &mut self.state, stride);
        self.percussion += self.state.percussion;
        match made {
            Ok(Progress::Running) => {
                self.history.keep(&self.state, &self.response);
                Advanced::Running
            }
            Ok(Progress::Over(end)) => Advanced::Over(end),
            Err(error) => Advanced::Failed(error),
        }
    }

    /// The sample of the present step, with the percussions since the sample before.
    pub fn sample(&mut self) -> Sample {
        self.next_sample = self.state.step + self.steps_per_sample;
        let mut sample = self.state.sample(&self.model);
        sample.percussion = std::mem::take(&mut self.percussion);
        sample
    }

    /// Where the column is in the course of the impact.
    pub fn phase(&self) -> TwinPhase {
        self.state.sample(&self.model).phase.into()
    }

    /// Goes back to an earlier step.
    pub fn rewind(&mut self, step: u64) {
        if step >= self.state.step {
            return;
        }
        (self.state, self.response) = *self.history.latest_until(step);
        while self.state.step < step {
            let stride = step - self.state.step;
            // It went well the first time.
            let Ok(Progress::Running) = self.response.advance(&self.model, &mut self.state, stride)
            else {
                return;
            };
        }
    }
}

/// Earlier states of a response, so that an impact that arrives late can meet the column as it was.
#[derive(Debug, Default)]
pub(super) struct History {
    /// The first is that of step 0, the others are overwritten in turn.
    checkpoints: Vec<(State, Response)>,
    next: usize,
    last_step: u64,
}

impl History {
    fn restart(&mut self, state: &State, response: &Response) {
        self.checkpoints.clear();
        self.checkpoints.reserve_exact(1 + CHECKPOINTS);
        self.checkpoints.push((*state, *response));
        self.next = 1;
        self.last_step = state.step;
    }

    fn keep(&mut self, state: &State, response: &Response) {
        if state.step < self.last_step + CHECKPOINT_STEPS {
            return;
        }
        self.last_step = state.step;
        match self.checkpoints.get_mut(self.next) {
            Some(oldest) => *oldest = (*state, *response),
            None => self.checkpoints.push((*state, *response)),
        }
        self.next = 1 + self.next % CHECKPOINTS;
    }

    fn latest_until(&self, step: u64) -> &(State, Response) {
        self.checkpoints
            .iter()
            .filter(|(state, _)| state.step <= step)
            .max_by_key(|(state, _)| state.step)
            .unwrap_or(&self.checkpoints[0])
    }
}
