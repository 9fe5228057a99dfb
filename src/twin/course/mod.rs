//! The course of the responses: the present one, the last one, which a late impact may resume, and the forecasts of those that
//! something else has ended.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - active_response.rs: The response to an impact under way: its outputs, what is predicted of its end, and its end

mod active_response;

use std::sync::Arc;

use super::begun_impact::BegunImpact;
use super::column_at_rest::{BeforeResponse, ColumnAtRest, Verdict};
use super::forecast::{Completed, Forecast, SupersededForecasts};
use super::journal::Position;
use super::opinion_state::BeamResult;
use super::output::{ForecastEnd, Outputs};
use super::plant::{Plant, Struck};
use super::registry::PendingImpact;
use super::timeline::{Advanced, History, LookAhead, Timeline};
use super::withdrawn_impact::WithdrawnImpact;
use crate::assessment::{VerdictRange, imperfection};
use crate::column::{End, Model};
use crate::time::Nanos;
pub(super) use active_response::ActiveResponse;

/// Most steps with which the forecasts of responses that have ended before their time are completed when the column comes to
/// rest: some 0.1 s of computing.
const MAX_STEPS_AT_REST: u64 = 200_000;

/// Gives monotonic nanoseconds; used only to measure compute times.
pub type Stopwatch = Box<dyn Fn() -> u64 + Send>;

/// What the solver has done since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SolverStatistics {
    /// Steps of the responses that were followed with the clock.
    pub steps: u64,
    /// Newton iterations of these steps.
    pub newton_iterations: u64,
}

/// The responses of a column, one after the other.
pub(super) struct Course {
    /// In memory of its own, because most columns of a fleet have none.
    present: Option<Box<ActiveResponse>>,
    /// The clock has jumped back during the present response, which no longer waits for it.
    is_completing: bool,
    /// The last response that is over.
    last: Option<LastResponse>,
    /// Forecasts of responses that have ended before their time.
    superseded: SupersededForecasts,
    /// Responses that have begun.
    responses: u64,
    solver: SolverStatistics,
    stopwatch: Stopwatch,
}

/// What follows where a response has come to a step.
pub(super) enum Arrived {
    /// The response continues up to this step.
    GoesOn(u64),
    /// The next impact meets the column at this step, which it has reached.
    NextImpact(u64),
}

/// A response that is over.
#[derive(Debug)]
struct LastResponse {
    response: Box<ActiveResponse>,
    /// The column before it, as long as it can be resumed; in memory of its own, because most columns of a fleet have none.
    before: Option<Box<BeforeResponse>>,
}

impl Course {
    /// After `responses` that have begun, and are over.
    pub fn new(responses: u64, stopwatch: Stopwatch) -> Self {
        Self {
            present: None,
            is_completing: false,
            last: None,
            superseded: SupersededForecasts::default(),
            responses,
            solver: SolverStatistics::default(),
            stopwatch,
        }
    }

    /// The response under way.
    pub fn present(&self) -> Option<&ActiveResponse> {
        self.present.as_deref()
    }

    /// The last response that is over.
    pub fn last(&self) -> Option<&ActiveResponse> {
        self.last.as_ref().map(|it| &*it.response)
    }

    /// The response that a later estimate of its impact replaces: the present one, or the last one while it can be resumed.
    pub fn replaceable(&self) -> Option<&ActiveResponse> {
        let last = self.last.as_ref().filter(|it| it.before.is_some());
        self.present().or(last.map(|it| &*it.response))
    }

    /// Responses that have begun since the start of the program.
    pub fn responses(&self) -> u64 {
        self.responses
    }

    pub fn position(&self) -> Position {
        Position {
            response: self.responses,
            step: self.present().map(|it| it.timeline.step()),
        }
    }

    pub fn statistics(&self) -> SolverStatistics {
        let iterations = self.present().map_or(0, ActiveResponse::newton_iterations);
        SolverStatistics {
            newton_iterations: self.solver.newton_iterations + iterations,
            ..self.solver
        }
    }

    /// Monotonic nanoseconds.
    pub fn stopwatch(&self) -> u64 {
        (self.stopwatch)()
    }

    /// Adds what steps have taken since then to the compute time of the present response.
    pub fn add_compute_time(&mut self, started: u64) {
        if let Some(response) = &mut self.present {
            let taken = (self.stopwatch)().saturating_sub(started);
            response.timeline.add_compute_time(taken);
        }
    }

    // The clock

    /// Whether the present response is carried to its end without waiting for the clock.
    pub fn is_completing(&self) -> bool {
        self.is_completing && self.present.is_some()
    }

    /// The clock has jumped back: the present response no longer waits for it, and what follows has stamps of the time after that.
    pub fn clock_jumped_back(&mut self) {
        self.is_completing = self.present.is_some();
        self.forbid_resuming();
    }

    /// Lets the response that has begun after the end of one that did not wait for the clock not wait for it either.
    pub fn go_on_completing(&mut self) {
        if self.is_completing {
            self.clock_jumped_back();
        }
    }

    /// Does what is due where the column is on its way to an instant: its sample. `None` where the instant is not beyond this step,
    /// and neither is the next impact.
    pub fn arrive(
        &mut self,
        instant: Nanos,
        next_impact: Option<Nanos>,
        out: &mut impl Outputs,
    ) -> Option<Arrived> {
        let response = self.present.as_mut()?;
        let now_step = response.timeline.step_at(instant)?;
        let next_impact = next_impact.and_then(|stamp| response.timeline.step_at(stamp));
        let target = next_impact.unwrap_or(u64::MAX).min(now_step);
        if response.timeline.is_sample_due() {
            response.put_due_state(out);
        }
        if response.timeline.step() < target {
            return Some(Arrived::GoesOn(target));
        }
        let is_due = next_impact.is_some_and(|step| step <= now_step);
        is_due.then_some(Arrived::NextImpact(target))
    }

    /// Advances the present response towards a step, but never past the next sample.
    pub fn advance(&mut self, target: u64) -> Option<Advanced> {
        let timeline = &mut self.present.as_mut()?.timeline;
        let before = timeline.step();
        let advanced = timeline.advance(target);
        self.solver.steps += timeline.step() - before;
        Some(advanced)
    }

    // Beginning and end

    /// Begins the response of `struck` to an impact; `before` is the column without it. Its samples are not given out until
    /// `silent_until`.
    pub fn begin(
        &mut self,
        pending: PendingImpact,
        before: Plant,
        struck: Struck,
        column: &mut ColumnAtRest,
        silent_until: Option<Nanos>,
    ) {
        column.begin_impact(&pending.event_id);
        self.responses += 1;
        let parameters = Arc::clone(column.parameters());
        let step_nanos = struck.model.properties.step_nanos;
        let period = 1e9 / parameters.settings().publish_rate;
        let steps = period / step_nanos as f64;
        let steps_per_sample = steps.round().max(1.0) as u64;
        let ahead = LookAhead::new(struck, imperfection(&parameters), *column.undamaged());
        let last = self.last.take();
        let history = last.map_or_else(History::default, |it| it.response.timeline.into_history());
        self.present = Some(Box::new(ActiveResponse {
            timeline: Timeline::begin(pending.stamp, struck, steps_per_sample, history),
            impact: BegunImpact {
                opinion: column.opinion_on(&before, &struck, &pending.striking),
                stamp: pending.stamp,
                event_id: pending.event_id,
                striking: pending.striking,
                parameters,
                step_nanos,
                base_before: column.life().base_before(),
            },
            before,
            forecast: Forecast::new(ahead),
            silent_until,
            range: None,
            beam_after: None,
        }));
    }

    /// Ends the present response, see [`ActiveResponse::end`].
    pub fn end(
        &mut self,
        end: End,
        column: &mut ColumnAtRest,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Option<Verdict> {
        let mut response = self.present.take()?;
        let (verdict, before) = response.end(end, column, now, out);
        self.keep(response, Some(before));
        Some(verdict)
    }

    /// Goes back to an earlier step of the present response.
    pub fn rewind(&mut self, step: u64) {
        if let Some(response) = &mut self.present {
            response.timeline.rewind(step);
        }
    }

    /// Ends the present response before its time. Its forecast is completed nevertheless.
    pub fn end_early(&mut self, end: ForecastEnd, reason: String) {
        if let Some(mut response) = self.present.take() {
            let forecast = std::mem::take(&mut response.forecast);
            self.superseded
                .take(response.impact.clone(), forecast, end, reason);
            self.keep(response, None);
        }
    }

    /// Ends the present response, which is to begin once more with another impact. Returns the column before it, and the instant that
    /// it has reached.
    pub fn set_aside(&mut self) -> Option<(Plant, Nanos)> {
        let response = self.present.take()?;
        let found = (response.before.clone(), response.reached());
        self.keep(response, None);
        Some(found)
    }

    fn keep(&mut self, response: Box<ActiveResponse>, before: Option<Box<BeforeResponse>>) {
        self.solver.newton_iterations += response.newton_iterations();
        self.last = Some(LastResponse { response, before });
    }

    // The last response

    /// The step of the last response at which an impact on a column of this model is so late that it belongs there.
    pub fn step_to_resume(&self, stamp: Nanos, struck: &Model) -> Option<u64> {
        let response = self.replaceable()?;
        let step = response.timeline.step_at(stamp)?;
        let is_there = step < response.timeline.step() && response.plant().model == *struck;
        is_there.then_some(step)
    }

    /// Makes the last response the present one again, if it can be resumed, and returns what it has changed in the column.
    pub fn take_back(&mut self) -> Option<Box<BeforeResponse>> {
        if self.present.is_some() {
            return None;
        }
        let last = self.last.take_if(|it| it.before.is_some())?;
        self.solver.newton_iterations -= last.response.newton_iterations();
        self.present = Some(last.response);
        last.before
    }

    /// The column has changed since the last response.
    pub fn forbid_resuming(&mut self) {
        if let Some(last) = &mut self.last {
            last.before = None;
        }
    }

    /// Frees the memory of the last response.
    pub fn forget_last(&mut self) {
        self.last = None;
    }

    // Forecasts

    /// Whether a forecast is being computed.
    pub fn is_looking_ahead(&self) -> bool {
        let present = self.present();
        present.is_some_and(|it| it.forecast.is_running()) || !self.superseded.is_empty()
    }

    /// Carries the forecast of the present response on, see [`Forecast::advance`].
    pub fn advance_forecast(
        &mut self,
        column: &mut ColumnAtRest,
        budget: &mut u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Option<Completed> {
        let response = self.present.as_mut()?;
        let (impact, undamaged, stopwatch) =
            (&response.impact, column.undamaged(), &self.stopwatch);
        let forecast = &mut response.forecast;
        let completed = forecast.advance(impact, undamaged, budget, stopwatch, now, out)?;
        response.timeline.set_last_step(completed.last_step);
        Some(completed)
    }

    /// Gives out the forecast of the present response.
    pub fn give_out_forecast(&mut self, now: Nanos, out: &mut impl Outputs) {
        if let Some(response) = &mut self.present {
            response.forecast.give_out(&response.impact, now, out);
        }
    }

    /// Carries the forecasts of responses on that have ended before their time.
    pub fn carry_superseded(
        &mut self,
        column: &mut ColumnAtRest,
        budget: &mut u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let (undamaged, stopwatch) = (column.undamaged(), &self.stopwatch);
        self.superseded
            .advance(undamaged, budget, stopwatch, now, out);
        self.superseded.put_withdrawn(out);
    }

    /// At rest no forecast is under way: what cannot be completed with [`MAX_STEPS_AT_REST`] is given up.
    pub fn finish_superseded(
        &mut self,
        column: &mut ColumnAtRest,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        self.carry_superseded(column, &mut MAX_STEPS_AT_REST.clone(), now, out);
        self.superseded.abandon();
        self.superseded.put_withdrawn(out);
    }

    /// Gives up all forecasts that are not complete, and those of impacts that are still to come.
    pub fn give_up_forecasts<'a>(
        &mut self,
        to_come: impl Iterator<Item = &'a PendingImpact>,
        end: ForecastEnd,
        reason: &str,
    ) {
        self.superseded.abandon();
        let present = self.present.as_ref();
        let unknown = present
            .filter(|it| it.awaits_forecast())
            .map(|it| (&it.impact).into());
        for impact in unknown.into_iter().chain(to_come.map(Into::into)) {
            self.superseded.take_none(impact, end, reason);
        }
    }

    /// Takes note that an impact will have no forecast.
    pub fn take_none(&mut self, impact: WithdrawnImpact, end: ForecastEnd, reason: &str) {
        self.superseded.take_none(impact, end, reason);
    }

    /// Gives out which forecasts no longer hold.
    pub fn put_withdrawn(&mut self, out: &mut impl Outputs) {
        self.superseded.put_withdrawn(out);
    }

    // What was computed behind the forecast

    /// Takes what the beam has found of the impact, if it is awaited: by the present response, or by the column at rest.
    pub fn take_opinion(&mut self, found: &BeamResult, column: &mut ColumnAtRest) -> bool {
        match &mut self.present {
            Some(response) => response.take_opinion(found, &column.life().beam),
            None => column.take_opinion(found),
        }
    }

    /// Takes the range of the verdict on the impact, if it is awaited: by the present response, or by the column at rest.
    pub fn take_range(&mut self, range: &Arc<VerdictRange>, column: &mut ColumnAtRest) -> bool {
        match &mut self.present {
            Some(response) => response.take_range(range),
            None => column.take_range(range),
        }
    }
}
