//! Snapshots of a response, from which an earlier step is reached again.

use crate::column::{Response, State};
use crate::twin::plant::Struck;

/// Steps from one recent snapshot to the next: the most that the twin steps again for a second impact that is a little
/// late.
const SNAPSHOT_STEPS: u64 = 256;

/// Recent snapshots that are kept; the oldest are overwritten.
const RECENT_SNAPSHOTS: usize = 64;

/// Snapshots that are kept of the whole response, an even number. When there are too many, every second one is dropped
/// and their distance doubles. At least half of them remain, so that for an impact that is very late the twin steps at
/// most this fraction of the response again: two divided by their number.
const SPREAD_SNAPSHOTS: usize = 128;

/// The column at a step.
type Snapshot = (State, Response);

/// Earlier states of a response, so that an impact that arrives late can meet the column as it was then.
#[derive(Debug, Default)]
pub struct History {
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
    pub fn restart(&mut self, plant: &Struck) {
        self.recent.clear();
        self.recent.reserve_exact(RECENT_SNAPSHOTS);
        self.next = 0;
        self.spread.clear();
        self.spread.reserve_exact(SPREAD_SNAPSHOTS);
        self.spread.push((plant.state, plant.response));
        self.spacing = SNAPSHOT_STEPS;
        self.last_step = plant.state.step;
    }

    pub fn keep(&mut self, plant: &Struck) {
        let Struck {
            state, response, ..
        } = plant;
        if state.step < self.last_step + SNAPSHOT_STEPS {
            return;
        }
        self.last_step = state.step;
        match self.recent.get_mut(self.next) {
            Some(oldest) => *oldest = (*state, *response),
            None => self.recent.push((*state, *response)),
        }
        self.next = (self.next + 1) % RECENT_SNAPSHOTS;
        if !self.is_spread_until(state.step) {
            return;
        }
        if self.spread.len() == SPREAD_SNAPSHOTS {
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

    /// Whether the last of the spread snapshots lies its distance before a step.
    fn is_spread_until(&self, step: u64) -> bool {
        let last = self.spread.last().map_or(0, |(state, _)| state.step);
        step >= last + self.spacing
    }

    pub fn latest_until(&self, step: u64) -> &Snapshot {
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
    use crate::twin::plant::Plant;
    use crate::twin::timeline::{Advanced, Timeline};

    fn timeline() -> Timeline {
        let fine = [("solver.dt", 1e-6.into())];
        let parameters = Parameters::from_values(fine).expect("admissible");
        let properties = parameters.column_properties();
        let impact = Impact {
            mass: 1500.0,
            velocity: 10.0,
            gap: 0.0,
            restitution: 0.0,
            vehicle: None,
            bumper_height: 0.0,
            transverse_force: 0.0,
        };
        let struck = Plant::undamaged(&properties)
            .expect("stands")
            .strike(&properties, impact, 2.0)
            .expect("hits");
        Timeline::begin(0, struck, 50, History::default())
    }

    fn go_to(timeline: &mut Timeline, step: u64) {
        while timeline.step() < step {
            if timeline.is_sample_due() {
                timeline.take_sample();
            }
            let advanced = timeline.advance(step);
            assert!(matches!(advanced, Advanced::Running), "{advanced:?}");
        }
    }

    /// However long a response is, what is kept of it is bounded, and so is what a late impact costs.
    #[test]
    fn no_step_is_far_from_a_snapshot() {
        const STEPS: u64 = 3_000_000;
        let timeline = timeline();
        let mut plant = *timeline.plant();
        let mut history = timeline.into_history();
        let memory = allocation_counter::measure(|| {
            for step in 1..=STEPS {
                plant.state.step = step;
                history.keep(&plant);
            }
        });
        assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
        let most = STEPS * 2 / SPREAD_SNAPSHOTS as u64 + SNAPSHOT_STEPS;
        for step in (0..=STEPS).step_by(997) {
            let (found, _) = history.latest_until(step);
            let again = step - found.step;
            let recent = (RECENT_SNAPSHOTS as u64 - 1) * SNAPSHOT_STEPS;
            let most = if STEPS - step < recent {
                SNAPSHOT_STEPS
            } else {
                most
            };
            assert!(again <= most, "{again} steps from step {step}");
        }
    }

    #[test]
    fn a_column_that_is_taken_back_far_is_the_same() {
        let (mut early, mut late) = (timeline(), timeline());
        go_to(&mut early, 1_000);
        go_to(&mut late, 20_000);
        late.rewind(1_000);
        let (late, early) = (late.plant(), early.plant());
        assert_eq!((late.state, late.response), (early.state, early.response));
    }
}
