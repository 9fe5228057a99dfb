//! The timeline of one response: from the clock to steps, and back to earlier steps. Knows no identifiers. The look-ahead
//! follows a copy of the column ahead of the clock.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - history.rs: Snapshots of a response, from which an earlier step is reached again
// - look_ahead.rs: A copy of the column that runs ahead of the clock until its response is over; then what the response leaves
//   behind: the residual capacity, and the error that the time step makes

mod history;
mod look_ahead;

use super::plant::Struck;
use crate::column::{End, Progress, Sample, StepError};
use crate::time::Nanos;
pub(super) use history::History;
pub use look_ahead::MAX_LOOK_AHEAD_STEPS;
pub(super) use look_ahead::{LookAhead, Outlook};

/// Longest time that is stepped over at once.
const MAX_NANOS_PER_TURN: u64 = 1_000_000;

/// Of the steps from one sample to the next, one in this many is left for the instant when the sample is due: a sample
/// leaves earlier by what the others take, as long as a step takes at most a fifth of its own time.
const LAST_SHARE: u64 = 5;

/// A response under way, stepped with the clock.
#[derive(Debug)]
pub(super) struct Timeline {
    /// Instant of step 0.
    origin: Nanos,
    plant: Struck,
    /// Steps from one sample to the next.
    steps_per_sample: u64,
    /// Step of the next sample.
    next_sample: u64,
    /// Impact impulse since the last sample \[N s\].
    impact_impulse: f64,
    /// What the steps have taken \[ns\].
    compute_nanos: u64,
    /// Step of the last state, once it is known from the look-ahead.
    last_step: Option<u64>,
    history: History,
}

/// What one advance has led to.
#[derive(Debug)]
pub(super) enum Advanced {
    Running,
    Over(End),
    Failed(StepError),
}

impl Timeline {
    /// Begins at `origin` with a sample at step 0. `history` is that of an earlier response, for its memory.
    pub fn begin(
        origin: Nanos,
        plant: Struck,
        steps_per_sample: u64,
        mut history: History,
    ) -> Self {
        history.restart(&plant);
        Self {
            origin,
            plant,
            steps_per_sample,
            next_sample: 0,
            impact_impulse: plant.state.impact_impulse,
            compute_nanos: 0,
            last_step: None,
            history,
        }
    }

    pub fn into_history(self) -> History {
        self.history
    }

    /// The column now.
    pub fn plant(&self) -> &Struck {
        &self.plant
    }

    /// Instant of step 0.
    pub fn origin(&self) -> Nanos {
        self.origin
    }

    /// The present step.
    pub fn step(&self) -> u64 {
        self.plant.state.step
    }

    /// Number of the last step at or before an instant; `None` before step 0.
    pub fn step_at(&self, instant: Nanos) -> Option<u64> {
        let since = u64::try_from(instant.checked_sub(self.origin)?).ok()?;
        Some(since / self.plant.model.properties.step_nanos)
    }

    /// Instant of the beginning of a step.
    pub fn instant_of(&self, step: u64) -> Nanos {
        let nanos = step.saturating_mul(self.plant.model.properties.step_nanos);
        self.origin.saturating_add_unsigned(nanos)
    }

    /// How often it is to be advanced \[ns\], > 0: once per sample, or more often where samples are rare.
    pub fn period(&self) -> u64 {
        self.steps_per_turn() * self.plant.model.properties.step_nanos
    }

    /// Instant at which it is to be advanced next; not after `now` where it is behind.
    pub fn next_deadline(&self, now: Nanos) -> Nanos {
        let is_behind = self
            .step_at(now)
            .is_some_and(|step| step > self.step() + self.steps_per_turn());
        match is_behind {
            true => now,
            false => self.instant_of(self.next_turn()),
        }
    }

    /// Steps that are made at a time, so that few are left to make when a sample is due.
    fn steps_per_turn(&self) -> u64 {
        let max = (MAX_NANOS_PER_TURN / self.plant.model.properties.step_nanos).max(1);
        self.steps_per_sample.min(max)
    }

    /// The step that the next turn is to reach: the next sample, and before it one that leaves little to compute when it
    /// is due. The last state is a sample that leaves when it is due, whatever the period of the others.
    fn next_turn(&self) -> u64 {
        let last = self.last_step.filter(|last| *last > self.step());
        let due = self.next_sample.min(last.unwrap_or(u64::MAX));
        let shortly_before = due.saturating_sub(self.steps_per_sample / LAST_SHARE);
        let wanted = match self.step() < shortly_before {
            true => shortly_before,
            false => due,
        };
        wanted.min(self.step() + self.steps_per_turn())
    }

    /// Advances towards a step, but never past the next sample.
    pub fn advance(&mut self, target: u64) -> Advanced {
        let stride = target.min(self.next_sample).saturating_sub(self.step());
        if stride == 0 {
            return Advanced::Running;
        }
        let made = self.plant.advance(stride);
        self.impact_impulse += self.plant.state.impact_impulse;
        match made {
            Ok(Progress::Running) => {
                self.history.keep(&self.plant);
                Advanced::Running
            }
            Ok(Progress::Over(end)) => Advanced::Over(end),
            Err(error) => Advanced::Failed(error),
        }
    }

    pub fn is_sample_due(&self) -> bool {
        self.step() >= self.next_sample
    }

    /// The sample of the present step, with the impact impulses since the sample before.
    pub fn take_sample(&mut self) -> Sample {
        self.next_sample = self.step() + self.steps_per_sample;
        let mut sample = self.plant.state.sample(&self.plant.model);
        sample.impact_impulse = std::mem::take(&mut self.impact_impulse);
        sample
    }

    /// Goes back to an earlier step.
    pub fn rewind(&mut self, step: u64) {
        if step >= self.step() {
            return;
        }
        let (state, response) = *self.history.latest_until(step);
        self.plant.state = state;
        self.plant.response = response;
        while self.step() < step {
            let stride = step - self.step();
            // It went well the first time.
            let Ok(Progress::Running) = self.plant.advance(stride) else {
                return;
            };
        }
    }

    /// Adds to the time that the steps have taken \[ns\].
    pub fn add_compute_time(&mut self, nanos: u64) {
        self.compute_nanos = self.compute_nanos.saturating_add(nanos);
    }

    /// What the steps have taken \[ns\].
    pub fn compute_nanos(&self) -> u64 {
        self.compute_nanos
    }

    /// Takes note of the last step of the response, which is known in advance.
    pub fn set_last_step(&mut self, last_step: u64) {
        self.last_step = Some(last_step);
    }
}
