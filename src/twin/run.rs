//! A response under way, step by step with the clock.

use std::sync::Arc;

use super::input::Nanos;
use super::present::Met;
use super::status::TwinPhase;
use crate::column::{End, Model, Progress, Response, Sample, State, StepError};

/// Steps from one recent checkpoint to the next: the most that a second impact that is a little late makes the twin
/// step anew.
const CHECKPOINT_STEPS: u64 = 256;

/// Longest time that is stepped over at once.
const MAX_NANOS_PER_TURN: u64 = 1_000_000;

/// Of the steps from one sample to the next, one in so many is left for the instant when the sample is due: a sample
/// leaves earlier by what the others take, as long as a step takes a fifth of its own time at the most.
const LAST_SHARE: u64 = 5;

/// Recent checkpoints that are kept, the oldest are overwritten.
const RECENT_CHECKPOINTS: usize = 64;

/// Checkpoints that are kept of the whole response, an even number. With the more distant ones they are twice as far
/// apart each time they have become too many: never fewer than half of them, so that an impact that is very late makes
/// the twin step at most this fraction of the response anew: two by their number.
const SPREAD_CHECKPOINTS: usize = 128;

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
    /// Step of the last state, once the forecast is complete; from then on the damage that it leaves is kept.
    pub last_step: Option<u64>,
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
            last_step: None,
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
        let most = (MAX_NANOS_PER_TURN / self.model.properties.step_nanos).max(1);
        self.steps_per_sample.min(most)
    }

    /// The step that the next turn is to reach: the next sample, and before it one that leaves little to compute when it
    /// is due. The last state is a sample that comes when it is due, whatever the others' period.
    pub fn next_turn(&self) -> u64 {
        let last = self.last_step.filter(|last| *last > self.state.step);
        let due = self.next_sample.min(last.unwrap_or(u64::MAX));
        let shortly_before = due.saturating_sub(self.steps_per_sample / LAST_SHARE);
        let wanted = match self.state.step < shortly_before {
            true => shortly_before,
            false => due,
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

/// The column at a step.
type Snapshot = (State, Response);

/// Earlier states of a response, so that an impact that arrives late can meet the column as it was.
#[derive(Debug, Default)]
pub(super) struct History {
    /// Of the last steps, overwritten in turn.
    recent: Vec<Snapshot>,
    next: usize,
    /// Of the whole response, in their order, step 0 first.
    spread: Vec<Snapshot>,
    /// Steps from one of them to the next, at least.
    spacing: u64,
    last_step: u64,
}

impl History {
    fn restart(&mut self, state: &State, response: &Response) {
        self.recent.clear();
        self.recent.reserve_exact(RECENT_CHECKPOINTS);
        self.next = 0;
        self.spread.clear();
        self.spread.reserve_exact(SPREAD_CHECKPOINTS);
        self.spread.push((*state, *response));
        self.spacing = CHECKPOINT_STEPS;
        self.last_step = state.step;
    }

    fn keep(&mut self, state: &State, response: &Response) {
        if state.step < self.last_step + CHECKPOINT_STEPS {
            return;
        }
        self.last_step = state.step;
        match self.recent.get_mut(self.next) {
            Some(oldest) => *oldest = (*state, *response),
            None => self.recent.push((*state, *response)),
        }
        self.next = (self.next + 1) % RECENT_CHECKPOINTS;
        if !self.is_spread_until(state.step) {
            return;
        }
        if self.spread.len() == SPREAD_CHECKPOINTS {
            let mut stays = false;
            self.spread.retain(|_| {
                stays = !stays;
                stays
            });
            self.spacing *= 2;
        }
        if self.is_spread_until(state.step) {
            self.spread.push((*state, *response));
        }
    }

    /// Whether the last of the spread checkpoints lies its distance before a step.
    fn is_spread_until(&self, step: u64) -> bool {
        let last = self.spread.last().map_or(0, |(state, _)| state.step);
        step >= last + self.spacing
    }

    fn latest_until(&self, step: u64) -> &Snapshot {
        self.recent
            .iter()
            .chain(&self.spread)
            .filter(|(state, _)| state.step <= step)
            .max_by_key(|(state, _)| state.step)
            .unwrap_or(&self.spread[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::Impact;
    use crate::parameters::Parameters;

    fn run() -> Run {
        let fine = [("solver.dt", 1e-6.into())];
        let parameters = Parameters::from_values(fine).expect("admissible");
        let model = Model::new(&parameters.column_properties()).expect("stands");
        let mut state = State::at_rest(&model);
        let impact = Impact {
            mass: 1500.0,
            velocity: 10.0,
            gap: 0.0,
            restitution: 0.0,
        };
        let response = Response::begin(&model, &mut state, impact, 2.0).expect("hits");
        let met = Met {
            model,
            state,
            response,
        };
        Run::new("a".into(), 0, met, 50, History::default())
    }

    fn go_to(run: &mut Run, step: u64) {
        while run.state.step < step {
            if run.state.step >= run.next_sample {
                run.sample();
            }
            let advanced = run.advance(step);
            assert!(matches!(advanced, Advanced::Running), "{advanced:?}");
        }
    }

    /// However long a response is, what is kept of it is bounded, and so is what a late impact costs.
    #[test]
    fn no_step_is_far_from_a_checkpoint() {
        const STEPS: u64 = 3_000_000;
        let Run {
            mut state,
            response,
            mut history,
            ..
        } = run();
        let memory = allocation_counter::measure(|| {
            for step in 1..=STEPS {
                state.step = step;
                history.keep(&state, &response);
            }
        });
        assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
        let most = STEPS * 2 / SPREAD_CHECKPOINTS as u64 + CHECKPOINT_STEPS;
        for step in (0..=STEPS).step_by(997) {
            let (found, _) = history.latest_until(step);
            let anew = step - found.step;
            let recent = (RECENT_CHECKPOINTS as u64 - 1) * CHECKPOINT_STEPS;
            let most = if STEPS - step < recent {
                CHECKPOINT_STEPS
            } else {
                most
            };
            assert!(anew <= most, "{anew} steps from step {step}");
        }
    }

    #[test]
    fn a_column_that_is_taken_back_far_is_the_same() {
        let (mut early, mut late) = (run(), run());
        go_to(&mut early, 1_000);
        go_to(&mut late, 20_000);
        late.rewind(1_000);
        assert_eq!((late.state, late.response), (early.state, early.response));
    }
}
