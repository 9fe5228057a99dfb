//! The work on an estimate in slices of a few milliseconds, so that a thread can take new data between them.
//!
//! How many responses are drawn is all that depends on time; with the same numbers the result has the same bits.

use crate::estimation::inference::estimate::ImpactEstimate;
use crate::estimation::inference::estimator::{ASSESSED, Estimator};
use crate::estimation::inference::round::Round;

/// Responses weighed in one slice.
const WEIGHED: usize = 64;

/// Responses that are assessed for an estimate in haste, when new ones have been drawn: actions come in steps of 4 % then.
pub(super) const ASSESSED_IN_HASTE: usize = 24;

/// Responses that get a first impression in one slice.
const PREFILTERED: usize = 512;

/// Responses of a round of refinement.
const ROUND: usize = 20;

/// New responses where the weights are, round by round.
#[derive(Debug, Clone)]
pub(crate) struct Refinement {
    stage: Stage,
    drawn: u32,
    /// Responses that it draws in any case.
    least: u32,
    most: u32,
    /// Whether it ends when the estimate rests on enough responses.
    until_settled: bool,
    /// Whether it looks for the most likely impacts first, if that is worth it.
    searches: bool,
}

#[derive(Debug, Clone)]
enum Stage {
    Plan,
    Compute(Box<Round>),
    Weigh,
    Over,
}

impl Refinement {
    /// Draws as many responses as are useful, at most `most`.
    pub fn at_most(most: u32) -> Self {
        Self {
            stage: Stage::Plan,
            drawn: 0,
            least: 0,
            most,
            until_settled: true,
            searches: false,
        }
    }

    /// The same between two estimates, when there may be time to look for the most likely impacts.
    pub fn between(most: u32) -> Self {
        Self {
            searches: true,
            ..Self::at_most(most)
        }
    }

    /// The same before the final estimate, and one round in any case: responses that explain the data may be found far from those that do
    /// so far.
    pub fn at_last(most: u32) -> Self {
        Self {
            least: ROUND as u32,
            ..Self::between(most)
        }
    }

    /// The same with exactly as many responses as it may draw.
    pub fn exactly(self) -> Self {
        Self {
            until_settled: false,
            ..self
        }
    }

    /// Draws no more responses.
    pub fn end_soon(&mut self) {
        self.most = self.drawn;
    }

    /// Responses drawn so far.
    pub fn drawn(&self) -> u32 {
        self.drawn
    }

    pub fn is_over(&self) -> bool {
        matches!(self.stage, Stage::Over)
    }

    /// The next slice, unless it is over.
    pub fn step(&mut self, estimator: &mut Estimator) {
        let may_draw = self.drawn < self.most;
        let may_settle = self.until_settled && self.drawn >= self.least;
        self.stage = match std::mem::replace(&mut self.stage, Stage::Over) {
            Stage::Plan if may_draw && self.searches => {
                // What changes the estimator is counted, so that it can be repeated.
                if estimator.search_on() {
                    self.drawn += 1;
                    Stage::Plan
                } else if let Some(mut round) = estimator.plan_found() {
                    estimator.compute_next(&mut round);
                    self.drawn += 1;
                    Stage::Compute(Box::new(round))
                } else {
                    self.searches = false;
                    Stage::Plan
                }
            }
            Stage::Plan if may_draw && !(may_settle && estimator.is_settled()) => {
                let round = estimator.plan(ROUND);
                if round.is_complete() {
                    // There is nothing to draw from.
                    Stage::Over
                } else {
                    Stage::Compute(Box::new(round))
                }
            }
            Stage::Compute(mut round) if may_draw && !round.is_complete() => {
                estimator.compute_next(&mut round);
                self.drawn += 1;
                Stage::Compute(round)
            }
            Stage::Compute(round) => {
                estimator.add(*round);
                Stage::Weigh
            }
            Stage::Weigh => match estimator.weigh_some(WEIGHED) {
                true => Stage::Weigh,
                false => Stage::Plan,
            },
            Stage::Plan | Stage::Over => Stage::Over,
        };
    }
}

/// Everything between new data and the next estimate.
#[derive(Debug, Clone)]
pub(crate) struct Update {
    refinement: Refinement,
    /// Whether sensors are looked for that contradict the others.
    judges: bool,
    /// Whether it is the final estimate, which waits for the answer of the fibre beam.
    is_final: bool,
    /// Whether the fibre beam has answered before: what it says later does not count for this estimate.
    counts_beam: bool,
    until: f64,
    /// Responses that are assessed.
    assessed: usize,
    task: Task,
}

#[derive(Debug, Clone)]
enum Task {
    Prefilter(usize),
    Weigh,
    Refine,
    /// All responses are weighed with all data, because sensors may contradict each other.
    WeighAll(usize),
    JudgeSensors,
    WeighAgain(usize),
    AwaitBeam,
    Assess(Vec<usize>),
    Over,
}

/// Responses that are assessed for the estimate with this number. Those that were prepared are assessed already, and for the final
/// estimate there is time.
pub(crate) fn assessed(estimator: &Estimator, number: u32, is_final: bool) -> usize {
    match is_final || (number == 0 && estimator.is_prepared()) {
        true => ASSESSED,
        false => ASSESSED_IN_HASTE,
    }
}

impl Update {
    /// The estimate with this number and the data until `until` \[s\], the final one or not. The first one does not judge the sensors:
    /// the responses that were prepared are too few to explain all of them.
    pub fn new(
        estimator: &mut Estimator,
        until: f64,
        number: u32,
        is_final: bool,
        refinement: Refinement,
    ) -> Self {
        estimator.note(until);
        Self {
            refinement,
            judges: number > 0,
            is_final,
            counts_beam: estimator.beam_has_answered(),
            until,
            assessed: assessed(estimator, number, is_final),
            task: Task::Prefilter(0),
        }
    }

    /// Draws no more responses.
    pub fn end_soon(&mut self) {
        self.refinement.end_soon();
    }

    /// Responses drawn so far.
    pub fn drawn(&self) -> u32 {
        self.refinement.drawn()
    }

    /// The estimate, once it is over.
    pub fn estimate(&self, estimator: &mut Estimator) -> ImpactEstimate {
        estimator.estimate_with(self.until, self.assessed)
    }

    pub fn is_over(&self) -> bool {
        matches!(self.task, Task::Over)
    }

    /// Whether the answer of the fibre beam to an earlier question counts for the estimate.
    pub fn counts_beam(&self) -> bool {
        self.counts_beam
    }

    /// What follows when all responses are weighed.
    fn weighed(&self, estimator: &mut Estimator) -> Task {
        estimator.ask_beam(self.is_final);
        if self.is_final && estimator.beam_may_help() {
            return Task::AwaitBeam;
        }
        self.assessing(estimator)
    }

    fn assessing(&self, estimator: &mut Estimator) -> Task {
        if self.is_final || self.counts_beam {
            estimator.take_answer_of_beam();
        }
        Task::Assess(estimator.unassessed(self.assessed))
    }

    /// The next slice, unless it is over.
    pub fn step(&mut self, estimator: &mut Estimator) {
        self.task = match std::mem::replace(&mut self.task, Task::Over) {
            Task::Prefilter(first) => match estimator.prefilter(first, PREFILTERED) {
                true => Task::Prefilter(first + PREFILTERED),
                false => Task::Weigh,
            },
            Task::Weigh => match estimator.weigh_some(WEIGHED) {
                true => Task::Weigh,
                false => Task::Refine,
            },
            Task::Refine if !self.refinement.is_over() => {
                self.refinement.step(estimator);
                Task::Refine
            }
            Task::Refine if self.judges && estimator.has_doubts() => Task::WeighAll(0),
            Task::Refine => self.weighed(estimator),
            Task::WeighAll(first) => match estimator.weigh_all(first, WEIGHED) {
                true => Task::WeighAll(first + WEIGHED),
                false => Task::JudgeSensors,
            },
            Task::JudgeSensors => match estimator.judge_sensors() {
                true => Task::WeighAgain(0),
                false => self.weighed(estimator),
            },
            Task::WeighAgain(first) => match estimator.weigh_all(first, WEIGHED) {
                true => Task::WeighAgain(first + WEIGHED),
                false => self.weighed(estimator),
            },
            Task::AwaitBeam => match estimator.follow_beam() {
                true => Task::AwaitBeam,
                false => self.assessing(estimator),
            },
            Task::Assess(mut left) => match left.pop() {
                Some(index) => {
                    estimator.assess_one(index);
                    Task::Assess(left)
                }
                None => Task::Over,
            },
            Task::Over => Task::Over,
        };
    }
}
