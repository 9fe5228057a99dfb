//! The response to an impact under way: its outputs, what is predicted of its end, and its end.

use std::sync::Arc;

use super::assessed::{Assessed, LastImpact, assess_at_once, assessed_again};
use super::begun_impact::BegunImpact;
use super::column_at_rest::{BeforeResponse, ColumnAtRest, Verdict};
use super::forecast::{Completed, Forecast};
use super::opinion::{OpinionTask, Seen};
use super::opinion_state::{BeamResult, KnownBeamDamage, OpinionState};
use super::output::{Output, Outputs, ReportOutput, StateOutput, StrikingVehicle, Verdicts};
use super::plant::{Plant, Struck, condition_after};
use super::range::{Judged, RangeTask, has_range};
use super::registry::PendingImpact;
use super::status::{Lengths, TwinPhase};
use super::timeline::{Advanced, History, LookAhead, Timeline};
use crate::assessment::{EarlierImpacts, VerdictRange, imperfection};
use crate::column::End;
use crate::standing::StandingColumn;
use crate::time::Nanos;

/// The response to an impact.
#[derive(Debug)]
pub(super) struct ActiveResponse {
    impact: BegunImpact,
    /// The column without the impact: at rest, or in motion after an earlier one.
    before: Plant,
    timeline: Timeline,
    forecast: Forecast,
    /// Until this instant its samples are not given out, because an earlier estimate of the same impact has given out some.
    silent_until: Option<Nanos>,
    /// The range of the verdict in the forecast, once it is known.
    range: Option<Arc<VerdictRange>>,
    /// The damage that the beam leaves, once it is known.
    beam_after: Option<KnownBeamDamage>,
}

/// What follows where a response has come to a step.
pub(super) enum Arrived {
    /// It goes on to this step.
    GoesOn(u64),
    /// The next impact meets the column at this step, which it has reached.
    NextImpact(u64),
}

impl ActiveResponse {
    /// Begins the response of `struck`; `before` is the column without the impact, and `history` that of an earlier response, for
    /// its memory.
    pub fn begin(
        pending: PendingImpact,
        before: Plant,
        struck: Struck,
        column: &mut ColumnAtRest,
        history: History,
        silent_until: Option<Nanos>,
    ) -> Self {
        let PendingImpact {
            event_id,
            stamp,
            striking,
            ..
        } = pending;
        let parameters = Arc::clone(column.parameters());
        let step_nanos = struck.model.properties.step_nanos;
        let period = 1e9 / parameters.settings().publish_rate;
        let steps = period / step_nanos as f64;
        let steps_per_sample = steps.round().max(1.0) as u64;
        let ahead = LookAhead::new(struck, imperfection(&parameters), *column.undamaged());
        Self {
            impact: BegunImpact {
                opinion: column.opinion_on(&before, &struck, &striking),
                stamp,
                event_id,
                striking,
                parameters,
                step_nanos,
                base_before: column.life().base_before(),
            },
            before,
            timeline: Timeline::begin(stamp, struck, steps_per_sample, history),
            forecast: Forecast::new(ahead),
            silent_until,
            range: None,
            beam_after: None,
        }
    }

    pub fn impact(&self) -> &BegunImpact {
        &self.impact
    }

    /// The column without the impact.
    pub fn before(&self) -> &Plant {
        &self.before
    }

    pub fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    pub fn forecast(&self) -> &Forecast {
        &self.forecast
    }

    /// The column now.
    pub fn plant(&self) -> &Struck {
        self.timeline.plant()
    }

    /// The instant that it has reached.
    pub fn reached(&self) -> Nanos {
        self.timeline.instant_of(self.timeline.step())
    }

    pub fn newton_iterations(&self) -> u64 {
        self.plant().state.newton_iterations
    }

    // The course of time

    /// Does what is due where it is on its way to an instant: its sample. `None` where the instant is not beyond this step, and
    /// neither is the next impact.
    pub fn arrive(
        &mut self,
        instant: Nanos,
        next_impact: Option<Nanos>,
        out: &mut impl Outputs,
    ) -> Option<Arrived> {
        let now_step = self.timeline.step_at(instant)?;
        let next_impact = next_impact.and_then(|stamp| self.timeline.step_at(stamp));
        let target = next_impact.unwrap_or(u64::MAX).min(now_step);
        if self.timeline.is_sample_due() {
            self.put_due_state(out);
        }
        if self.timeline.step() < target {
            return Some(Arrived::GoesOn(target));
        }
        let is_due = next_impact.is_some_and(|step| step <= now_step);
        is_due.then_some(Arrived::NextImpact(target))
    }

    /// See [`Timeline::advance`].
    pub fn advance(&mut self, target: u64) -> Advanced {
        self.timeline.advance(target)
    }

    /// See [`Timeline::rewind`].
    pub fn rewind(&mut self, step: u64) {
        self.timeline.rewind(step);
    }

    /// See [`Timeline::add_compute_time`].
    pub fn add_compute_time(&mut self, nanos: u64) {
        self.timeline.add_compute_time(nanos);
    }

    /// Its memory, for another response.
    pub fn into_history(self) -> History {
        self.timeline.into_history()
    }

    /// Gives out the sample that is due, unless it is to be silent.
    fn put_due_state(&mut self, out: &mut impl Outputs) {
        let instant = self.reached();
        match self.silent_until.is_some_and(|until| instant <= until) {
            true => drop(self.timeline.take_sample()),
            false => self.put_state(None, out),
        }
    }

    /// Gives out the state of the present step; `phase` where it is not that of the sample.
    fn put_state(&mut self, phase: Option<TwinPhase>, out: &mut impl Outputs) {
        let sample = self.timeline.take_sample();
        let lengths = Lengths::from(&self.plant().model.properties);
        let BegunImpact {
            event_id, striking, ..
        } = &self.impact;
        out.put(Output::State(StateOutput {
            stamp: self.reached(),
            event_id: Arc::clone(event_id),
            phase: phase.unwrap_or(sample.phase.into()),
            sample,
            lengths: Some(lengths),
            vehicle: Some(StrikingVehicle {
                name: Arc::clone(&striking.vehicle),
                mass: striking.impact.mass,
                direction: striking.direction(),
            }),
        }));
    }

    /// Ends: gives out the last state and the report, and leaves the column at rest.
    pub fn end(
        &mut self,
        end: End,
        column: &mut ColumnAtRest,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> (Verdict, Box<BeforeResponse>) {
        let plant = *self.plant();
        let report = plant.report(end);
        let residual = plant.residual();
        let condition = condition_after(report.end, residual.as_ref());
        self.put_state(Some(condition.final_phase()), out);
        let settled = plant.settled(residual, condition);
        // The look-ahead followed the same response. Without a forecast, because of its length, the assessment is made here.
        let predicted = self.forecast.take_predicted();
        let predicted = predicted.filter(|it| it.report == report);
        let error_estimate = predicted.as_ref().and_then(|it| it.error_estimate);
        let BegunImpact {
            parameters,
            striking,
            base_before,
            ..
        } = &self.impact;
        let mut last = LastImpact::new(striking, &report, error_estimate, base_before.as_ref());
        let assessed = match predicted {
            Some(predicted) => {
                let opinion = predicted.assessed.as_ref();
                last.second_opinion = opinion.and_then(|it| it.second_opinion.clone());
                predicted.assessed
            }
            None => assess_at_once(parameters, &settled, Some(&last), column.undamaged()),
        };
        let output = ReportOutput {
            range: self.range.clone(),
            ..self.impact.report_output(
                report,
                assessed.clone(),
                error_estimate,
                self.timeline.compute_nanos(),
            )
        };
        let beam_before = &column.life().beam;
        let has_range = has_range(&self.before);
        let earlier = has_range.then(|| self.earlier_impacts()).flatten();
        let verdict = Verdict {
            parameters: Arc::clone(parameters),
            assessed: assessed.clone(),
            judged: Judged::new(&output, has_range, earlier, beam_before),
        };
        let beam = self.beam_after.clone();
        let beam = beam.unwrap_or_else(|| match &self.impact.opinion {
            OpinionState::None(reason) => beam_before.without_opinion(&settled, reason),
            OpinionState::Awaited | OpinionState::Known => beam_before.while_awaited(&settled),
        });
        out.put(Output::Report(output));
        let event_id = &self.impact.event_id;
        out.verdict("result", event_id, assessed.as_deref(), now);
        let added = plant.state.ledger.plastic_work;
        (verdict, column.settle(settled, last, beam, added))
    }

    // The forecast

    /// Whether its forecast was not given out yet, and is still being computed.
    pub fn awaits_forecast(&self) -> bool {
        self.forecast.is_running() && !self.forecast.is_known()
    }

    /// Carries its forecast on by at most `budget` steps, see [`Forecast::advance`].
    pub fn advance_forecast(
        &mut self,
        column: &mut ColumnAtRest,
        budget: &mut u64,
        stopwatch: &dyn Fn() -> u64,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Option<Completed> {
        let (impact, undamaged) = (&self.impact, column.undamaged());
        let completed = self
            .forecast
            .advance(impact, undamaged, budget, stopwatch, now, out)?;
        self.timeline.set_last_step(completed.last_step);
        Some(completed)
    }

    /// Gives its forecast out.
    pub fn give_out_forecast(&mut self, now: Nanos, out: &mut impl Outputs) {
        self.forecast.give_out(&self.impact, now, out);
    }

    /// Its forecast, which no longer is one of it.
    pub fn take_forecast(&mut self) -> Forecast {
        std::mem::replace(&mut self.forecast, Forecast::none())
    }

    /// The forecast with what was computed behind it.
    pub fn supplemented_forecast(&self) -> Option<ReportOutput> {
        let predicted = self.forecast.predicted()?;
        Some(ReportOutput {
            range: self.range.clone(),
            ..self.impact.report_output(
                predicted.report,
                predicted.assessed.clone(),
                predicted.error_estimate,
                predicted.compute_nanos,
            )
        })
    }

    // The second opinion, for which `before` is the damage of the beam before the impact

    /// Whether the second opinion is to be computed now: it follows the complete forecast.
    pub fn awaits_opinion(&self) -> bool {
        self.impact.opinion == OpinionState::Awaited
            && !self.forecast.is_running()
            && self.forecast.predicted().is_some()
    }

    pub fn opinion_task(&self, response: u64, before: &KnownBeamDamage) -> Option<OpinionTask> {
        if !self.awaits_opinion() {
            return None;
        }
        let BegunImpact {
            parameters,
            striking,
            ..
        } = &self.impact;
        let struck = &self.plant().model.properties;
        OpinionTask::new(response, parameters, struck, striking, before).ok()
    }

    /// Takes what the beam has found, if it is awaited.
    pub fn take_opinion(&mut self, found: &BeamResult, before: &KnownBeamDamage) -> bool {
        if !self.awaits_opinion() {
            return false;
        }
        let impact = &mut self.impact;
        let Some(predicted) = self.forecast.predicted_mut() else {
            return false;
        };
        let seen = Seen {
            striking: &impact.striking,
            parameters: &impact.parameters,
            report: &predicted.report,
            left: &predicted.at_rest,
            before,
        };
        let (opinion, beam) = seen.kept(found);
        if opinion.is_some() {
            let last = LastImpact {
                second_opinion: opinion,
                ..LastImpact::new(
                    &impact.striking,
                    &predicted.report,
                    predicted.error_estimate,
                    impact.base_before.as_ref(),
                )
            };
            let assessed = predicted.assessed.as_ref();
            predicted.assessed = assessed
                .map(|it| assessed_again(it, &impact.parameters, &predicted.at_rest, &last));
        }
        impact.opinion = OpinionState::after(found);
        self.beam_after = Some(beam);
        true
    }

    // The range of the verdict

    /// The assessment in the complete forecast, if the range of that is not known yet.
    pub fn assessed_without_range(&self) -> Option<&Arc<Assessed>> {
        let is_ready = self.impact.opinion != OpinionState::Awaited && !self.forecast.is_running();
        if self.range.is_some() || !is_ready || !has_range(&self.before) {
            return None;
        }
        self.forecast.predicted()?.assessed.as_ref()
    }

    /// `beam` is the damage of the beam before the impact.
    pub fn range_task(&self, response: u64, beam: &KnownBeamDamage) -> Option<RangeTask> {
        let assessed = self.assessed_without_range()?;
        let BegunImpact {
            parameters,
            striking,
            ..
        } = &self.impact;
        let struck = &self.plant().model.properties;
        Some(RangeTask::new(
            response,
            parameters,
            struck,
            striking,
            self.earlier_impacts().as_ref(),
            (&self.impact.opinion, beam),
            assessed,
        ))
    }

    /// Takes the range, if it is awaited.
    pub fn take_range(&mut self, range: &Arc<VerdictRange>) -> bool {
        let is_awaited = self.assessed_without_range().is_some();
        if is_awaited {
            self.range = Some(Arc::clone(range));
        }
        is_awaited
    }

    /// What the impacts before this one have left; `None` where they have left nothing.
    fn earlier_impacts(&self) -> Option<Arc<EarlierImpacts>> {
        let base = self.impact.base_before;
        if base.is_none() && !self.before.is_damaged() {
            return None;
        }
        // As it was when the impact began, which has succeeded.
        let struck = &self.plant().model.properties;
        let (model, state) = self.before.with_hinges_at_impact(struck).ok()?;
        Some(Arc::new(EarlierImpacts {
            column: StandingColumn::new(&model, &state),
            base,
        }))
    }
}
