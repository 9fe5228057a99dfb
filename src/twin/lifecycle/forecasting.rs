//! Carries the forecasts of a twin on, and withdraws those that no longer hold.

use std::sync::Arc;

use super::Twin;
use crate::time::Nanos;
use crate::twin::active_response::{ActiveResponse, LastResponse};
use crate::twin::begun_impact::BegunImpact;
use crate::twin::forecast::{Completed, Forecast};
use crate::twin::output::{ForecastEnd, Output, Outputs};

/// Most steps with which the forecasts of responses that have ended before their time are completed when the column comes to
/// rest: some 0.1 s of computing.
const MAX_STEPS_AT_REST: u64 = 200_000;

impl Twin {
    /// Whether a forecast is being computed: [`Twin::run_ahead`] carries it on.
    pub fn is_looking_ahead(&self) -> bool {
        let present = self.response.as_ref();
        present.is_some_and(|response| response.forecast.is_running())
            || !self.superseded.is_empty()
    }

    /// Whether the forecast of the present response was not given out yet. What remains to be computed after that, its error
    /// and forecasts of earlier responses, is not urgent.
    pub fn awaits_forecast(&self) -> bool {
        let present = self.response.as_ref();
        present.is_some_and(|it| it.forecast.is_running() && !it.forecast.is_known())
    }

    /// Most steps of the response that its forecast may still have to compute before it is given out: what `response.duration`
    /// allows. `None` if [`awaits_forecast`](Self::awaits_forecast) is false.
    pub fn forecast_steps_left(&self) -> Option<u64> {
        let response = self.response.as_ref().filter(|_| self.awaits_forecast())?;
        let BegunImpact {
            parameters,
            step_nanos,
            ..
        } = &response.impact;
        let steps = parameters.response_duration() * 1e9 / *step_nanos as f64;
        let reached = response.forecast.step()?;
        Some((steps as u64).saturating_sub(reached))
    }

    /// Carries the forecasts on by at most `max_steps`. Each is given out when the response and the residual capacity are
    /// known, and again when the error of the time step is known. The present response comes first.
    pub fn run_ahead(&mut self, max_steps: u64, now: Nanos, out: &mut impl Outputs) {
        let mut budget = max_steps;
        self.carry_present_forecast(&mut budget, now, out);
        self.carry_superseded_forecasts(&mut budget, now, out);
    }

    pub(super) fn carry_present_forecast(
        &mut self,
        budget: &mut u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        while let Some(response) = &mut self.response {
            let ActiveResponse {
                impact,
                timeline,
                forecast,
                ..
            } = &mut **response;
            let (undamaged, stopwatch) = (&mut self.undamaged, &self.stopwatch);
            let Some(completed) = forecast.advance(impact, undamaged, budget, stopwatch, now, out)
            else {
                return;
            };
            let Completed {
                last_step,
                at_rest: mut expected,
                has_residual,
                last,
                plastic_work,
            } = completed;
            timeline.set_last_step(last_step);
            // Saved now: if the machine stops before the response is over, the damage is known all the same.
            if !has_residual {
                // The damage before the response is then the last that can be saved.
                expected.state = self.at_rest.state;
            }
            let mut saved = self.saved_state_of(&expected, now);
            saved.plastic_work_since_reset += plastic_work;
            saved.last_impact = Some(last);
            saved.beam = saved.beam.while_awaited(&expected);
            // Before the forecast, so that who has it finds the damage after a crash.
            out.put(Output::Save(Arc::new(saved)));
            if let Some(response) = &mut self.response {
                response.forecast.give_out(&response.impact, now, out);
            }
        }
    }

    fn carry_superseded_forecasts(&mut self, budget: &mut u64, now: Nanos, out: &mut impl Outputs) {
        let (undamaged, stopwatch) = (&mut self.undamaged, &self.stopwatch);
        self.superseded
            .advance(undamaged, budget, stopwatch, now, out);
        self.superseded.put_withdrawn(out);
    }

    /// At rest no forecast is under way: what cannot be completed with [`MAX_STEPS_AT_REST`] is given up.
    pub(super) fn finish_superseded_forecasts(&mut self, now: Nanos, out: &mut impl Outputs) {
        self.carry_superseded_forecasts(&mut MAX_STEPS_AT_REST.clone(), now, out);
        self.superseded.abandon();
        self.superseded.put_withdrawn(out);
    }

    /// Gives out which accepted impacts will have no forecast because the twin is stopped.
    pub fn abandon_forecasts(&mut self, out: &mut impl Outputs) {
        self.superseded.abandon();
        let unknown = self
            .response
            .as_ref()
            .filter(|it| it.forecast.is_running() && !it.forecast.is_known())
            .map(|it| (&it.impact).into());
        let pending = self.registry.pending().map(Into::into);
        for impact in unknown.into_iter().chain(pending) {
            let reason = "the twin was stopped before the forecast was complete";
            self.superseded
                .take_none(impact, ForecastEnd::Stopped, reason);
        }
        self.superseded.put_withdrawn(out);
    }

    /// Takes leave of a response that something else ends. Its forecast is completed nevertheless.
    pub(super) fn end_early(
        &mut self,
        mut response: Box<ActiveResponse>,
        end: ForecastEnd,
        reason: String,
    ) {
        let forecast = std::mem::replace(&mut response.forecast, Forecast::none());
        let impact = response.impact.clone();
        self.superseded.take(impact, forecast, end, reason);
        self.last = Some(LastResponse {
            response,
            before: None,
        });
    }
}
