//! A copy of the column that runs ahead of the clock until its response is over; then what the response leaves behind: the
//! residual capacity, and the error that the time step makes.

use crate::column::{Progress, Report, error_estimate};
use crate::twin::assessed::{Capacities, PushDowns, UndamagedCapacity};
use crate::twin::plant::{Plant, Struck, condition_after};

/// Most steps of one forecast: minutes of computing. `solver.dt` and `response.duration` together could ask for hours.
pub const MAX_LOOK_AHEAD_STEPS: u64 = 50_000_000;

/// A copy of the column on its way ahead.
#[derive(Debug)]
pub struct LookAhead {
    plant: Struck,
    /// Half the step from the same beginning; `None` where the step cannot be halved.
    refined: Option<Struck>,
    stage: Stage,
    /// `e0` of the push-downs \[m\].
    imperfection: f64,
    undamaged: Option<UndamagedCapacity>,
    advances: u64,
    compute_nanos: u64,
}

#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one per response")]
enum Stage {
    Responding,
    PushingDown {
        report: Report,
        has_residual: bool,
        push_downs: PushDowns,
    },
    /// The response with half the step.
    Refining {
        /// Of the response with the whole step.
        report: Report,
    },
    Complete,
}

/// How far a forecast has come.
#[derive(Debug)]
#[allow(clippy::large_enum_variant)] // lives for one call
pub enum Outlook {
    /// It is not complete.
    Running,
    /// The response and its residual capacity are known.
    Over {
        report: Report,
        /// The column at rest after it.
        at_rest: Plant,
        /// Whether the response leaves an equilibrium behind.
        has_residual: bool,
        /// `None` if the column cannot be computed any further.
        capacities: Option<Capacities>,
        /// For the next forecast of the same column.
        undamaged: Option<UndamagedCapacity>,
    },
    /// The error that the time step makes is known, or why it is not; nothing remains to be computed.
    Refined(Result<f64, String>),
    /// It cannot be completed, for this reason.
    Failed(String),
    /// Nothing remains to be computed.
    Complete,
}

impl LookAhead {
    pub fn new(plant: Struck, imperfection: f64, undamaged: Option<UndamagedCapacity>) -> Self {
        Self {
            plant,
            refined: plant.with_half_the_step(),
            stage: Stage::Responding,
            imperfection,
            undamaged,
            advances: 0,
            compute_nanos: 0,
        }
    }

    /// Runs ahead until there is news, or until `budget` steps and increments are made, which are taken from it. `stopwatch`
    /// gives monotonic nanoseconds.
    pub fn run(&mut self, budget: &mut u64, stopwatch: &dyn Fn() -> u64) -> Outlook {
        let started = stopwatch();
        let outlook = self.advance(budget);
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

    fn advance(&mut self, budget: &mut u64) -> Outlook {
        loop {
            match &mut self.stage {
                Stage::Complete => return Outlook::Complete,
                _ if *budget == 0 => return Outlook::Running,
                Stage::Responding => {
                    *budget -= 1;
                    if let Some(failed) = self.respond() {
                        return failed;
                    }
                }
                Stage::PushingDown {
                    report,
                    has_residual,
                    push_downs,
                } => {
                    let Some(capacities) = push_downs.advance(budget) else {
                        continue;
                    };
                    let over = Outlook::Over {
                        report: *report,
                        at_rest: push_downs.at_rest().clone(),
                        has_residual: *has_residual,
                        capacities,
                        undamaged: push_downs.undamaged(),
                    };
                    self.stage = Stage::Refining { report: *report };
                    return over;
                }
                Stage::Refining { report } => {
                    *budget -= 1;
                    let report = *report;
                    if let Some(estimate) = self.refine(&report) {
                        self.stage = Stage::Complete;
                        return Outlook::Refined(estimate);
                    }
                }
            }
        }
    }

    /// A step of the response; `Some` if it cannot be made.
    fn respond(&mut self) -> Option<Outlook> {
        if self.advances == MAX_LOOK_AHEAD_STEPS {
            self.stage = Stage::Complete;
            return Some(Outlook::Failed(format!(
                "the response takes more than {MAX_LOOK_AHEAD_STEPS} steps; \
                 choose a longer solver.dt or a shorter response.duration"
            )));
        }
        self.advances += 1;
        match self.plant.advance(u64::MAX) {
            Ok(Progress::Running) => None,
            Ok(Progress::Over(end)) => {
                let report = self.plant.report(end);
                let residual = self.plant.residual();
                let condition = condition_after(report.end, residual.as_ref());
                let at_rest = self.plant.settled(residual, condition);
                self.stage = Stage::PushingDown {
                    report,
                    has_residual: residual.is_some(),
                    push_downs: PushDowns::new(at_rest, self.imperfection, self.undamaged.as_ref()),
                };
                None
            }
            Err(error) => {
                self.stage = Stage::Complete;
                Some(Outlook::Failed(error.to_string()))
            }
        }
    }

    /// A step of the response with half the step. `Some` once the error is known, or known to be unknown: the response cannot
    /// be computed with half the step, or takes too long.
    fn refine(&mut self, report: &Report) -> Option<Result<f64, String>> {
        let Some(refined) = &mut self.refined else {
            return Some(Err("the time step cannot be halved".to_owned()));
        };
        if self.advances == MAX_LOOK_AHEAD_STEPS {
            return Some(Err(format!(
                "both responses together take more than {MAX_LOOK_AHEAD_STEPS} steps"
            )));
        }
        self.advances += 1;
        match refined.advance(u64::MAX) {
            Ok(Progress::Running) => None,
            Ok(Progress::Over(end)) => {
                let finer = refined.report(end);
                let ends_otherwise = || {
                    format!(
                        "the response with half the time step ends otherwise ({:?} instead of {:?}), or without a displacement",
                        finer.outcome, report.outcome
                    )
                };
                Some(error_estimate(report, &finer).ok_or_else(ends_otherwise))
            }
            Err(error) => Some(Err(format!(
                "the response with half the time step cannot be computed: {error}"
            ))),
        }
    }
}
