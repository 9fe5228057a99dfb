//! The response with the clock: steps, samples, its end.

use std::sync::Arc;

use super::impacts::NO_REPORT;
use super::input::Nanos;
use super::output::{Lengths, Output, Outputs, ReportOutput, Severity, StateOutput};
use super::parameter_change::AtRest;
use super::present::{Condition, is_damaged};
use super::run::{Advanced, Run};
use super::status::TwinPhase;
use super::{Last, MAX_STEPS_PER_CALL, Twin, seconds};
use crate::column::{End, Report, State, StepError, residual_state};

impl Twin {
    pub(super) fn step_to(&mut self, now: Nanos, out: &mut impl Outputs) {
        for _ in 0..MAX_STEPS_PER_CALL {
            let Some(target) = self.arrive(now, out) else {
                return;
            };
            let Some(run) = &mut self.run else {
                return;
            };
            let before = run.state.step;
            let advanced = run.advance(target);
            self.steps += run.state.step - before;
            match advanced {
                Advanced::Running => {}
                Advanced::Over(end) => self.end(end, now, out),
                Advanced::Failed(error) => self.fail(&error, now, out),
            }
        }
        // Whoever looks between two calls finds all done that belongs to the step that was reached.
        self.arrive(now, out);
    }

    /// Does what is due where the column is: its sample, the impacts that meet it here. The step to go to from here;
    /// `None` where `now` does not lie beyond it.
    fn arrive(&mut self, now: Nanos, out: &mut impl Outputs) -> Option<u64> {
        loop {
            let run = self.run.as_mut()?;
            let now_step = run.step_at(now)?;
            let next_impact = self
                .impacts_ahead
                .first()
                .and_then(|next| run.step_at(next.stamp));
            let target = next_impact.unwrap_or(u64::MAX).min(now_step);
            if run.state.step >= run.next_sample {
                put_state(run, None, out);
            }
            if run.state.step < target {
                return Some(target);
            }
            if next_impact.is_none_or(|step| step > now_step) {
                return None;
            }
            // There are few of them, and each goes: the loop ends.
            let next = self.impacts_ahead.remove(0);
            self.hit_moving_column(next, target, NO_REPORT, now, out);
        }
    }

    pub(super) fn end(&mut self, end: End, now: Nanos, out: &mut impl Outputs) {
        self.run_ahead(u64::MAX, now, out); // a forecast never comes after its report
        let Some(mut run) = self.run.take() else {
            return;
        };
        let report = run.response.report(&run.model, &run.state, end);
        let residual = residual_state(&run.model, &run.state);
        self.condition = condition_after(&report, residual.as_ref());
        put_state(&mut run, Some(phase_after(&self.condition)), out);
        out.put(Output::Report(ReportOutput {
            stamp: run.stamp,
            event_id: Arc::clone(&run.event_id),
            report,
            compute_time: seconds(run.nanos),
        }));
        self.settle(run, residual, now, out);
    }

    pub(super) fn fail(&mut self, error: &StepError, now: Nanos, out: &mut impl Outputs) {
        self.run_ahead(u64::MAX, now, out);
        let Some(mut run) = self.run.take() else {
            return;
        };
        let text = format!(
            "the response to impact \"{}\" cannot be computed: {error}",
            run.event_id
        );
        self.condition = Condition::Faulted(text.as_str().into());
        put_state(&mut run, Some(TwinPhase::Faulted), out);
        self.notice(Severity::Error, text, now, out);
        self.settle(run, None, now, out);
    }

    /// Back to rest after a response; what has waited for it comes to its turn.
    pub(super) fn settle(
        &mut self,
        run: Run,
        residual: Option<State>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let plastic_work = self.life.plastic_work;
        self.life.plastic_work += run.state.ledger.plastic_work;
        self.corrections += run.state.newton_iterations;
        let state = match residual {
            // The same bits as if there had been no impact.
            Some(residual) if !is_damaged(&residual) => State::at_rest(&run.model),
            Some(residual) => residual,
            // There is no equilibrium: what can be seen of the column is where it was last.
            None => run.state,
        };
        self.at_rest = AtRest {
            model: run.model,
            state,
        };
        self.last = Some(Last {
            run,
            resumable: Some(plastic_work),
        });
        self.reported.due = true;
        self.journal.due = true;
        self.apply_waiting_parameters(now, out);
        self.save(now, out);
        while self.run.is_none() && !self.impacts_ahead.is_empty() {
            let next = self.impacts_ahead.remove(0);
            self.begin_arriving(&self.present(), next, now, out);
            if self.run.is_none() {
                self.save(now, out); // it was refused: fewer impacts than were kept
            }
        }
    }
}

pub(super) fn put_state(run: &mut Run, phase: Option<TwinPhase>, out: &mut impl Outputs) {
    let sample = run.sample();
    out.put(Output::State(StateOutput {
        stamp: run.instant_of(run.state.step),
        event_id: Arc::clone(&run.event_id),
        phase: phase.unwrap_or(sample.phase.into()),
        sample,
        lengths: Some(Lengths {
            below: run.model.properties.length_below,
            above: run.model.properties.length_above,
        }),
    }));
}

pub(super) fn condition_after(report: &Report, residual: Option<&State>) -> Condition {
    match (report.end, residual) {
        (End::Collapsed, _) => Condition::Collapsed,
        (_, Some(_)) => Condition::Standing,
        (_, None) => no_equilibrium(),
    }
}

pub(super) fn no_equilibrium() -> Condition {
    Condition::Faulted("the damaged column finds no equilibrium under its load".into())
}

pub(super) fn phase_after(condition: &Condition) -> TwinPhase {
    match condition {
        Condition::Standing => TwinPhase::Rest,
        Condition::Collapsed => TwinPhase::Collapsed,
        Condition::Faulted(_) => TwinPhase::Faulted,
    }
}
