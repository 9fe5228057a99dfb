//! A copy of the column that runs ahead of the clock until its response is over.

use crate::column::{Progress, Report, State};
use crate::twin::plant::Struck;

/// Most steps of one forecast: minutes of computing. `solver.dt` and `response.duration` together could ask for hours.
pub const MAX_LOOK_AHEAD_STEPS: u64 = 50_000_000;

/// A copy of the column on its way ahead.
#[derive(Debug)]
pub struct LookAhead {
    plant: Struck,
    advances: u64,
    compute_nanos: u64,
}

/// How far a forecast has come.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // lives for one call
pub enum Outlook {
    /// It is not complete.
    Running,
    /// It is complete; `residual` is the equilibrium that the response leaves behind, if there is one.
    Over {
        report: Report,
        residual: Option<State>,
    },
    /// It cannot be completed, for this reason.
    Failed(String),
}

impl LookAhead {
    pub fn new(plant: Struck) -> Self {
        Self {
            plant,
            advances: 0,
            compute_nanos: 0,
        }
    }

    /// Runs ahead by at most `max_steps`. `stopwatch` gives monotonic nanoseconds.
    pub fn run(&mut self, max_steps: u64, stopwatch: &dyn Fn() -> u64) -> Outlook {
        let started = stopwatch();
        let outlook = self.advance(max_steps);
        let taken = stopwatch().saturating_sub(started);
        self.compute_nanos = self.compute_nanos.saturating_add(taken);
        outlook
    }

    /// The step that it has reached.
    pub fn step(&self) -> u64 {
        self.plant.state.step
    }

    /// What computing has taken \[ns\].
    pub fn compute_nanos(&self) -> u64 {
        self.compute_nanos
    }

    fn advance(&mut self, max_steps: u64) -> Outlook {
        for _ in 0..max_steps {
            if self.advances == MAX_LOOK_AHEAD_STEPS {
                return Outlook::Failed(format!(
                    "the response takes more than {MAX_LOOK_AHEAD_STEPS} steps; \
                     choose a longer solver.dt or a shorter response.duration"
                ));
            }
            self.advances += 1;
            match self.plant.advance(u64::MAX) {
                Ok(Progress::Running) => {}
                Ok(Progress::Over(end)) => {
                    return Outlook::Over {
                        report: self.plant.report(end),
                        residual: self.plant.residual(),
                    };
                }
                Err(error) => return Outlook::Failed(error.to_string()),
            }
        }
        Outlook::Running
    }
}
