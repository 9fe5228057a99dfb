//! A copy of the column that runs ahead until its response is over.

use super::present::Met;
use super::seconds;
use crate::column::{Model, Progress, Report, Response, State, residual_state};

/// Most steps of one look ahead: minutes of computing. `solver.dt` and `response.duration` together could ask for
/// hours.
pub const MAX_LOOK_AHEAD_STEPS: u64 = 50_000_000;

/// A copy of the column under way.
#[derive(Debug)]
pub(super) struct LookAhead {
    model: Model,
    state: State,
    response: Response,
    advances: u64,
    nanos: u64,
}

/// How far a look ahead has come.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // lives for one call
pub(super) enum Outlook {
    /// Not to the end.
    Running,
    /// To the end; `residual` is the equilibrium that it leaves behind, if there is one.
    Over {
        report: Report,
        residual: Option<State>,
    },
    /// It cannot be followed any further.
    Failed(String),
}

impl LookAhead {
    pub fn new(met: Met) -> Self {
        let Met {
            model,
            state,
            response,
        } = met;
        Self {
            model,
            state,
            response,
            advances: 0,
            nanos: 0,
        }
    }

    /// Runs ahead by `most_steps` at the most.
    pub fn run(&mut self, most_steps: u64, stopwatch: &dyn Fn() -> u64) -> Outlook {
        let started = stopwatch();
        let outlook = self.advance(most_steps);
        self.nanos = self
            .nanos
            .saturating_add(stopwatch().saturating_sub(started));
        outlook
    }

    /// The step that it has come to.
    pub fn step(&self) -> u64 {
        self.state.step
    }

    /// \[s\]
    pub fn compute_time(&self) -> f64 {
        seconds(self.nanos)
    }

    fn advance(&mut self, most_steps: u64) -> Outlook {
        for _ in 0..most_steps {
            if self.advances == MAX_LOOK_AHEAD_STEPS {
                return Outlook::Failed(format!(
                    "the response takes more than {MAX_LOOK_AHEAD_STEPS} steps; \
                     take a longer solver.dt or a shorter response.duration"
                ));
            }
            self.advances += 1;
            match self
                .response
                .advance(&self.model, &mut self.state, u64::MAX)
            {
                Ok(Progress::Running) => {}
                Ok(Progress::Over(end)) => {
                    let report = self.response.report(&self.model, &self.state, end);
                    let residual = residual_state(&self.model, &self.state);
                    return Outlook::Over { report, residual };
                }
                Err(error) => return Outlook::Failed(error.to_string()),
            }
        }
        Outlook::Running
    }
}
