//! Forecasts: that of the present response, and those of earlier ones that something else has ended before their forecasts
//! were complete. Every accepted impact has a forecast, or an output that tells why it has none.

use std::collections::VecDeque;
use std::sync::Arc;

use super::assessed::{Assessed, LastImpact, UndamagedCapacity, assessed};
use super::begun_impact::BegunImpact;
use super::output::{
    ForecastEnd, NoticeLevel, Output, Outputs, ReportOutput, Verdicts, WithdrawnForecast,
};
use super::plant::Plant;
use super::timeline::{LookAhead, Outlook};
use super::withdrawn_impact::WithdrawnImpact;
use crate::column::Report;
use crate::time::Nanos;

/// Most forecasts of responses that have ended early which are still being computed. When more impacts follow one another
/// faster than forecasts can be computed, the oldest one is abandoned.
pub const MAX_SUPERSEDED_FORECASTS: usize = 16;

/// The forecast of one impact. By default nothing remains to be computed or withdrawn.
#[derive(Debug, Default)]
pub(super) struct Forecast {
    /// The copy that runs ahead, until nothing remains to be computed.
    ahead: Option<LookAhead>,
    /// What it has found, for the report.
    predicted: Option<Predicted>,
    was_given_out: bool,
    error_estimate: Option<f64>,
    /// Something else has ended the response.
    is_superseded: bool,
}

/// The end of a response, known in advance.
#[derive(Debug)]
pub(super) struct Predicted {
    pub report: Report,
    /// The column at rest after it.
    pub at_rest: Plant,
    pub assessed: Option<Arc<Assessed>>,
    pub error_estimate: Option<f64>,
    /// What computing it took.
    pub compute_nanos: u64,
}

/// The response is known to its end.
pub(super) struct Completed {
    /// The step of the last state.
    pub last_step: u64,
    /// The column at rest after it.
    pub at_rest: Plant,
    /// Whether the response leaves an equilibrium behind.
    pub has_residual: bool,
    pub last: LastImpact,
    pub plastic_work: f64,
}

impl Forecast {
    pub fn new(ahead: LookAhead) -> Self {
        Self {
            ahead: Some(ahead),
            ..Self::default()
        }
    }

    /// Whether something remains to be computed.
    pub fn is_running(&self) -> bool {
        self.ahead.is_some()
    }

    /// Whether it was given out.
    pub fn is_known(&self) -> bool {
        self.was_given_out
    }

    /// The step that it has reached; `None` if nothing remains to be computed.
    pub fn step(&self) -> Option<u64> {
        self.ahead.as_ref().map(LookAhead::step)
    }

    /// What it has found.
    pub fn predicted(&self) -> Option<&Predicted> {
        self.predicted.as_ref()
    }

    pub fn predicted_mut(&mut self) -> Option<&mut Predicted> {
        self.predicted.as_mut()
    }

    pub fn take_predicted(&mut self) -> Option<Predicted> {
        self.predicted.take()
    }

    /// Gives it out, now that the response and the residual capacity are known.
    pub fn give_out(&mut self, impact: &BegunImpact, now: Nanos, out: &mut impl Outputs) {
        let Some(predicted) = &self.predicted else {
            return;
        };
        put_forecast(impact, predicted, self.is_superseded, out);
        let assessed = predicted.assessed.as_deref();
        out.verdict("forecast", &impact.event_id, assessed, now);
        self.was_given_out = true;
    }

    /// Carries it on by at most `budget` steps, which are taken from it. Returns when the response and the residual capacity are known,
    /// for the caller to [give it out](Self::give_out); it is given out again when the error of the time step is known.
    pub fn advance(
        &mut self,
        impact: &BegunImpact,
        undamaged: &mut Option<UndamagedCapacity>,
        budget: &mut u64,
        stopwatch: &dyn Fn() -> u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Option<Completed> {
        while let Some(ahead) = &mut self.ahead {
            let outlook = ahead.run(budget, stopwatch);
            let compute_nanos = ahead.compute_nanos();
            match outlook {
                Outlook::Running => return None,
                Outlook::Complete => self.ahead = None,
                Outlook::Over {
                    report,
                    at_rest,
                    has_residual,
                    capacities,
                    undamaged: found,
                } => {
                    let last_step = ahead.step();
                    *undamaged = found.or(*undamaged);
                    let last = LastImpact::new(
                        &impact.striking,
                        &report,
                        None,
                        impact.base_before.as_ref(),
                    );
                    let predicted = Predicted {
                        report,
                        at_rest: at_rest.clone(),
                        assessed: capacities
                            .map(|it| assessed(&impact.parameters, &at_rest, Some(&last), &it)),
                        error_estimate: None,
                        compute_nanos,
                    };
                    self.predicted = Some(predicted);
                    return Some(Completed {
                        last_step,
                        at_rest,
                        has_residual,
                        last,
                        plastic_work: report.plastic_work,
                    });
                }
                Outlook::Refined(estimate) => {
                    self.ahead = None;
                    self.error_estimate = estimate.as_ref().ok().copied();
                    if let Some(predicted) = &mut self.predicted {
                        predicted.error_estimate = self.error_estimate;
                        predicted.compute_nanos = compute_nanos;
                    }
                    match (estimate, &self.predicted) {
                        (Ok(_), Some(predicted)) => {
                            put_forecast(impact, predicted, self.is_superseded, out);
                        }
                        (Ok(_), None) => {}
                        (Err(reason), _) => {
                            let id = &impact.event_id;
                            let text = format!(
                                "the forecast of impact \"{id}\" has no error estimate: {reason}"
                            );
                            out.notice(NoticeLevel::Info, now, text);
                        }
                    }
                }
                Outlook::Failed(reason) => {
                    self.ahead = None;
                    let text = format!("no forecast of impact \"{}\": {reason}", impact.event_id);
                    out.notice(NoticeLevel::Warning, now, text.clone());
                    let none = none(impact.into(), ForecastEnd::NotComputed, &text);
                    out.put(Output::Withdrawn(none));
                }
            }
        }
        None
    }
}

fn put_forecast(
    impact: &BegunImpact,
    predicted: &Predicted,
    is_superseded: bool,
    out: &mut impl Outputs,
) {
    let Predicted {
        report,
        assessed,
        error_estimate,
        compute_nanos,
        ..
    } = predicted;
    let output = impact.report_output(*report, assessed.clone(), *error_estimate, *compute_nanos);
    out.put(Output::Forecast(ReportOutput {
        is_superseded,
        ..output
    }));
}

/// That there will be no forecast.
fn none(impact: WithdrawnImpact, end: ForecastEnd, reason: &str) -> WithdrawnForecast {
    WithdrawnForecast {
        impact,
        was_known: false,
        error_estimate: None,
        end,
        reason: reason.into(),
    }
}

impl From<&BegunImpact> for WithdrawnImpact {
    fn from(impact: &BegunImpact) -> Self {
        Self {
            stamp: impact.stamp,
            event_id: Arc::clone(&impact.event_id),
            striking: impact.striking.clone(),
        }
    }
}

/// The forecast of a response that has ended before its time.
#[derive(Debug)]
struct Superseded {
    impact: BegunImpact,
    forecast: Forecast,
    end: ForecastEnd,
    /// What has ended the response.
    reason: String,
}

impl Superseded {
    /// The forecast no longer holds, or there will be none. `None` if it could not be computed, which was given out.
    fn withdrawn(self) -> Option<WithdrawnForecast> {
        let was_known = self.forecast.is_known();
        if !was_known && !self.forecast.is_running() {
            return None;
        }
        let reason = match was_known {
            true => self.reason,
            false => format!("{}; there was no time to compute its forecast", self.reason),
        };
        Some(WithdrawnForecast {
            impact: (&self.impact).into(),
            was_known,
            error_estimate: self.forecast.error_estimate,
            end: self.end,
            reason: reason.into(),
        })
    }
}

/// Forecasts of responses that have ended before their time. Each is carried to its end, given out, and then withdrawn.
#[derive(Debug, Default)]
pub(super) struct SupersededForecasts {
    /// The oldest first, each in memory of its own: there are seldom any.
    waiting: VecDeque<Box<Superseded>>,
    /// To be given out once the journal has what has ended the responses.
    withdrawn: Vec<WithdrawnForecast>,
}

impl SupersededForecasts {
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Takes the forecast of a response that `end` has ended, for this reason.
    pub fn take(
        &mut self,
        impact: BegunImpact,
        mut forecast: Forecast,
        end: ForecastEnd,
        reason: String,
    ) {
        forecast.is_superseded = true;
        let superseded = Superseded {
            impact,
            forecast,
            end,
            reason,
        };
        if !superseded.forecast.is_running() {
            return self.withdrawn.extend(superseded.withdrawn());
        }
        if self.waiting.len() == MAX_SUPERSEDED_FORECASTS {
            let oldest = self.waiting.pop_front();
            self.withdrawn.extend(oldest.and_then(|it| it.withdrawn()));
        }
        self.waiting.push_back(Box::new(superseded));
    }

    /// Takes note that an impact will have no forecast.
    pub fn take_none(&mut self, impact: WithdrawnImpact, end: ForecastEnd, reason: &str) {
        self.withdrawn.push(none(impact, end, reason));
    }

    /// Carries the oldest ones on by at most `budget` steps, which are taken from it.
    pub fn advance(
        &mut self,
        undamaged: &mut Option<UndamagedCapacity>,
        budget: &mut u64,
        stopwatch: &dyn Fn() -> u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        while let Some(oldest) = self.waiting.front_mut() {
            let Superseded {
                impact, forecast, ..
            } = &mut **oldest;
            while forecast
                .advance(impact, undamaged, budget, stopwatch, now, out)
                .is_some()
            {
                forecast.give_out(impact, now, out);
            }
            if forecast.is_running() {
                return;
            }
            let complete = self.waiting.pop_front();
            self.withdrawn
                .extend(complete.and_then(|it| it.withdrawn()));
        }
    }

    /// Gives up what is not complete.
    pub fn abandon(&mut self) {
        let given_up = self.waiting.drain(..);
        self.withdrawn
            .extend(given_up.filter_map(|it| it.withdrawn()));
    }

    /// Gives out what no longer holds.
    pub fn put_withdrawn(&mut self, out: &mut impl Outputs) {
        for withdrawn in self.withdrawn.drain(..) {
            out.put(Output::Withdrawn(withdrawn));
        }
    }
}
