//! The response to an impact under way: its outputs, what is predicted of its end, and its end.

use std::sync::Arc;

use crate::assessment::{EarlierImpacts, VerdictRange};
use crate::column::End;
use crate::standing::StandingColumn;
use crate::time::Nanos;
use crate::twin::assessed::{Assessed, LastImpact, assess_at_once, assessed_again};
use crate::twin::begun_impact::BegunImpact;
use crate::twin::column_at_rest::{BeforeResponse, ColumnAtRest, Verdict};
use crate::twin::forecast::Forecast;
use crate::twin::opinion::{OpinionTask, Seen};
use crate::twin::opinion_state::{BeamResult, KnownBeamDamage, OpinionState};
use crate::twin::output::{Output, Outputs, ReportOutput, StateOutput, StrikingVehicle, Verdicts};
use crate::twin::plant::{Plant, Struck, condition_after};
use crate::twin::range::{Judged, RangeTask, has_range};
use crate::twin::status::{Lengths, TwinPhase};
use crate::twin::timeline::Timeline;

/// The response to an impact.
#[derive(Debug)]
pub struct ActiveResponse {
    pub(super) impact: BegunImpact,
    /// The column without the impact: at rest, or in motion after an earlier one.
    pub(super) before: Plant,
    pub(super) timeline: Timeline,
    pub(super) forecast: Forecast,
    /// Until this instant its samples are not given out, because an earlier estimate of the same impact has given out some.
    pub(super) silent_until: Option<Nanos>,
    /// The range of the verdict in the forecast, once it is known.
    pub(super) range: Option<Arc<VerdictRange>>,
    /// The damage that the beam leaves, once it is known.
    pub(super) beam_after: Option<KnownBeamDamage>,
}

impl ActiveResponse {
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

    /// Gives out the sample that is due, unless it is to be silent.
    pub(super) fn put_due_state(&mut self, out: &mut impl Outputs) {
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
        let striking = &self.impact.striking;
        out.put(Output::State(StateOutput {
            stamp: self.reached(),
            event_id: Arc::clone(&self.impact.event_id),
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

    /// Gives out the last state and the report of a response that has ended, and brings the column to rest.
    pub(super) fn end(
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
        let mut last = self.impact.last_impact(&report, error_estimate);
        let parameters = &self.impact.parameters;
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
        let (impact, struck) = (&self.impact, &self.plant().model.properties);
        let (parameters, striking) = (&impact.parameters, &impact.striking);
        OpinionTask::new(response, parameters, struck, striking, before).ok()
    }

    /// Takes what the beam has found, if it is awaited.
    pub(super) fn take_opinion(&mut self, found: &BeamResult, before: &KnownBeamDamage) -> bool {
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
                ..impact.last_impact(&predicted.report, predicted.error_estimate)
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
        let impact = &self.impact;
        Some(RangeTask::new(
            response,
            &impact.parameters,
            &self.plant().model.properties,
            &impact.striking,
            self.earlier_impacts().as_ref(),
            (&impact.opinion, beam),
            assessed,
        ))
    }

    /// Takes the range, if it is awaited.
    pub(super) fn take_range(&mut self, range: &Arc<VerdictRange>) -> bool {
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
