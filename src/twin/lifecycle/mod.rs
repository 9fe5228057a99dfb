//! The twin: the order in which its parts act on a command and on the clock.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - background.rs: What another thread has to compute for the twin now
// - critical_velocities.rs: The critical velocities of the column at rest: asked for, taken, and forgotten
// - damage_correction.rs: Corrects the damage by a measurement on the column at rest
// - estimation.rs: From an estimate to an impact: acceptance, following, and events that are the same impact
// - fleet_member.rs: What a twin needs as one of many: it is made from an equal one, says when it has nothing to do, and keeps
//   no more than it needs
// - forecasting.rs: Carries the forecasts of a twin on, and withdraws those that no longer hold
// - impacts.rs: How an impact meets the column: at rest, in motion, or in a response that is over
// - reconfiguration.rs: Changes of the parameters, and the reset
// - reproduction.rs: A twin that continues from a checkpoint and follows a recorded one without a clock
// - second_opinion.rs: The second opinion on the present or the last impact: asked for, taken, and corrected
// - verdict_range.rs: The range of the verdict on the present or the last impact: asked for, taken, given out, and forgotten

mod background;
mod critical_velocities;
mod damage_correction;
mod estimation;
mod fleet_member;
mod forecasting;
mod impacts;
mod reconfiguration;
mod reproduction;
mod second_opinion;
mod verdict_range;

#[cfg(feature = "record")]
pub(crate) use estimation::vehicle_name;

use std::sync::Arc;

use super::active_response::{ActiveResponse, BeforeResponse, LastResponse};
use super::assessed::{Assessed, LastImpact, UndamagedCapacity, assess_at_once};
use super::command::{Accepted, Command};
use super::critical::KnownCriticalVelocities;
use super::estimates::Estimates;
use super::forecast::{Predicted, SupersededForecasts};
use super::journal::{Journal, JournalClock, StatusRecord};
use super::opinion_state::{KnownBeamDamage, MOVING, OpinionState};
use super::output::{NoticeLevel, Output, Outputs, ReportOutput, Verdicts};
use super::parameter_set::ParameterSet;
use super::plant::{Condition, Plant, Struck, condition_after};
use super::range::Judged;
use super::registry::{Registry, RejectedInput};
use super::rejection::Rejection;
use super::saved_state::SavedState;
use super::status::{Judgement, Status, StatusClock, TwinPhase};
use super::timeline::Advanced;
use super::what_if::ColumnSnapshot;
use super::{MAX_STEPS_PER_CALL, STATUS_PERIOD};
use crate::column::{End, ModelError, StepError};
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::time::seconds;

/// What becomes of the report of an impact whose response another impact ends.
const NO_REPORT: &str = "for which no report will follow";

/// Gives monotonic nanoseconds; used only to measure compute times.
pub type Stopwatch = Box<dyn Fn() -> u64 + Send>;

/// One column over its life.
pub struct Twin {
    registry: Registry,
    parameters: ParameterSet,
    /// The column at rest, as the last response or a reset left it.
    at_rest: Plant,
    /// Its assessment; `None` if it cannot be computed.
    assessed: Option<Arc<Assessed>>,
    /// Undamaged capacity of the last column that was assessed.
    undamaged: Option<UndamagedCapacity>,
    /// Its critical velocities; `None` until they are computed.
    critical: Option<KnownCriticalVelocities>,
    /// The last impact with the range of its verdict, if that has one.
    judged: Option<Box<Judged>>,
    /// In memory of its own, because most columns of a fleet have none.
    response: Option<Box<ActiveResponse>>,
    /// The clock has jumped back during the present response, which no longer waits for it.
    is_completing: bool,
    /// Forecasts of responses that have ended before their time.
    superseded: SupersededForecasts,
    /// The last response that is over.
    last: Option<LastResponse>,
    journal: JournalClock,
    /// What the sensors have detected.
    estimates: Estimates,
    status: StatusClock,
    solver: SolverStatistics,
    stopwatch: Stopwatch,
}

/// What the solver has done since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SolverStatistics {
    /// Steps of the responses that were followed with the clock.
    pub steps: u64,
    /// Newton iterations of these steps.
    pub newton_iterations: u64,
}

impl Twin {
    /// The twin of the column with these parameters: undamaged, or with the damage that [`state_file::load`](super::state_file::load) returned for
    /// the same parameters.
    ///
    /// # Errors
    /// The column is impossible, or does not stand under its load.
    pub fn new(
        parameters: impl Into<Arc<Parameters>>,
        saved: Option<&SavedState>,
        stopwatch: Stopwatch,
        now: Nanos,
    ) -> Result<Self, ModelError> {
        let parameters: Arc<Parameters> = parameters.into();
        let mut registry = Registry::new(&parameters.settings().column_id);
        let properties = parameters.column_properties();
        let at_rest = match saved {
            None => Plant::undamaged(&properties)?,
            Some(saved) => {
                registry.restore_seen_ids(&saved.seen_ids);
                registry.life = saved.life();
                saved.plant(&properties)?
            }
        };
        let mut twin = Self {
            registry,
            parameters: ParameterSet::new(parameters),
            at_rest,
            assessed: None,
            undamaged: None,
            critical: None,
            judged: None,
            response: None,
            is_completing: false,
            superseded: SupersededForecasts::new(),
            last: None,
            journal: JournalClock::new(now),
            estimates: Estimates::default(),
            status: StatusClock::new(now),
            solver: SolverStatistics::default(),
            stopwatch,
        };
        twin.assess();
        Ok(twin)
    }

    /// The column may have a damage that this twin does not know, because its state file could not be used: its status says so,
    /// and calls for an inspection, until a reset. To be called before the first command.
    pub fn note_unknown_damage(&mut self) {
        self.registry.life.is_damage_unknown = true;
        self.status.set_changed();
    }

    /// Assesses the column at rest at once: after a start, a reset or a change of parameters. After a response, the look-ahead
    /// has done it in slices.
    pub(super) fn assess(&mut self) {
        self.assessed = assess_at_once(
            self.parameters.current(),
            &self.at_rest,
            self.registry.life.last_impact.as_ref(),
            &mut self.undamaged,
        );
    }

    /// The column's name.
    pub fn column_id(&self) -> &Arc<str> {
        self.registry.column_id()
    }

    /// The parameters that hold now.
    pub fn parameters(&self) -> &Arc<Parameters> {
        self.parameters.current()
    }

    /// What the solver has done since the start.
    pub fn statistics(&self) -> SolverStatistics {
        let iterations = self
            .response
            .as_ref()
            .map_or(0, |response| response.newton_iterations());
        SolverStatistics {
            newton_iterations: self.solver.newton_iterations + iterations,
            ..self.solver
        }
    }

    /// Whether the column is responding to an impact.
    pub fn is_responding(&self) -> bool {
        self.response.is_some()
    }

    /// What is lost if the program ends now, in words: damage that is not saved, impacts that have not begun.
    #[must_use]
    pub fn lost_by_a_stop(&self) -> Vec<String> {
        let unsaved = self
            .response
            .as_ref()
            .filter(|response| !response.forecast.is_known())
            .map(|response| {
                format!(
                    "the damage of impact \"{}\", to which the column is responding and whose forecast is not complete",
                    response.impact.event_id
                )
            });
        unsaved
            .into_iter()
            .chain(self.registry.pending_in_words())
            .collect()
    }

    /// The column as it is now, for [`ColumnSnapshot::predict`] in any thread.
    pub fn snapshot(&self) -> ColumnSnapshot {
        let mut plant = self.at_rest.clone();
        if let Some(response) = &self.response {
            let Struck { model, state, .. } = *response.timeline.plant();
            plant.model = model;
            plant.state = state;
        }
        self.snapshot_of(plant)
    }

    pub(super) fn snapshot_of(&self, plant: Plant) -> ColumnSnapshot {
        ColumnSnapshot {
            column_id: Arc::clone(self.registry.column_id()),
            parameters: Arc::clone(self.parameters.current()),
            plant,
            undamaged: self.undamaged,
            base_before: self.registry.life.base_before(),
            beam: match self.response {
                Some(_) => KnownBeamDamage::Unknown(MOVING.into()),
                None => self.registry.life.beam.clone(),
            },
        }
    }

    /// Executes a command at the instant `now`. What follows from it in time is left to [`Twin::advance_to`] and
    /// [`Twin::run_ahead`].
    ///
    /// # Errors
    /// The command is rejected and has changed nothing; the rejection has been counted and given out.
    pub fn handle(
        &mut self,
        command: Command,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        self.report_checkpoint(now, out);
        let position = self.position();
        let result = match &command {
            Command::Impact(impact) => {
                self.take_impact(impact, now, out).inspect_err(|rejection| {
                    let rejection = rejection.clone();
                    self.reject_impact(&impact.event_id, rejection, now, out);
                })
            }
            Command::SetParameters { changes, source } => self
                .set_parameters(changes, source, now, out)
                .map_err(|rejection| self.reject_change(rejection, source, now, out)),
            Command::RejectedChange { rejection, source } => {
                Err(self.reject_change(rejection.clone(), source, now, out))
            }
            Command::Reset { source } => {
                self.reset(source, now, out);
                Ok(Accepted::Applied)
            }
            Command::ClockJumpedBack { by } => {
                self.clock_jumped_back(*by, now, out);
                Ok(Accepted::Applied)
            }
            Command::CriticalVelocities { vehicles } => Ok(self.take_critical_velocities(vehicles)),
            Command::SecondOpinion(found) => Ok(self.take_opinion(found)),
            Command::VerdictRange(range) => Ok(self.take_range(range)),
            Command::Estimate(record) => Ok(self.take_estimate(record, now, out)),
            Command::DecideEstimate(decision) => {
                self.decide_estimate(decision, now, out)
                    .map_err(|rejection| {
                        let what = RejectedInput::Estimate;
                        self.reject_request(what, rejection, &decision.source, now, out)
                    })
            }
            Command::CorrectDamage(measured) => {
                self.correct_damage(measured, now, out)
                    .map_err(|rejection| {
                        let what = RejectedInput::DamageCorrection;
                        self.reject_request(what, rejection, &measured.source, now, out)
                    })
            }
        };
        let rejection = result.as_ref().err().cloned();
        let is_applied = result.as_ref().is_ok_and(|it| *it == Accepted::Applied);
        let opinion = match &command {
            Command::SecondOpinion(found) if is_applied => Some(Arc::clone(found)),
            _ => None,
        };
        let has_range = is_applied && matches!(command, Command::VerdictRange(_));
        out.put(Output::Journal(
            self.journal.command(command, rejection, position, now),
        ));
        self.superseded.put_withdrawn(out);
        self.put_estimate(out);
        if let Some(found) = opinion {
            self.put_opinion(found.movement(), now, out);
        }
        if has_range {
            self.put_ranged(now, out);
        }
        result
    }

    /// Steps the column to the instant `now`, by at most [`MAX_STEPS_PER_CALL`] steps: a twin that is further behind has
    /// its [`Twin::next_deadline`] in the past. Samples that are due are given out, then what has changed.
    pub fn advance_to(&mut self, now: Nanos, out: &mut impl Outputs) {
        let started = (self.stopwatch)();
        match self.is_completing() {
            true => self.step_to(Nanos::MAX, now, out),
            false => self.step_to(now, now, out),
        }
        if let Some(response) = &mut self.response {
            let taken = (self.stopwatch)().saturating_sub(started);
            response.timeline.add_compute_time(taken);
        }
        self.report_checkpoint(now, out);
        self.report_status(now, out);
    }

    /// Whether the present response is carried to its end without waiting for the clock, because that has jumped back. The
    /// caller calls [`Twin::advance_to`] at once again, and better submits no impact, which would be earlier than the present one.
    pub fn is_completing(&self) -> bool {
        self.is_completing && self.response.is_some()
    }

    /// When [`Twin::advance_to`] is to be called again: the instant of the next sample or status; not after `now` where
    /// the twin is behind.
    pub fn next_deadline(&self, now: Nanos) -> Nanos {
        let status = self.status.next_deadline(now);
        let Some(response) = &self.response else {
            return status;
        };
        if self.is_completing {
            return now;
        }
        let next_impact = self.registry.next_pending().unwrap_or(Nanos::MAX);
        let next_turn = response.timeline.next_deadline(now);
        status.min(next_turn).min(next_impact)
    }

    /// How often [`Twin::advance_to`] is to be called \[ns\], > 0: once per sample during a response, or more often where
    /// samples are rare; otherwise once per status.
    pub fn period(&self) -> u64 {
        self.response
            .as_ref()
            .map_or(STATUS_PERIOD.unsigned_abs(), |response| {
                response.timeline.period()
            })
    }

    /// The state of the twin now.
    pub fn status(&self, now: Nanos) -> Status {
        let struck = self.response.as_ref().map(|it| it.timeline.plant());
        Status::new(
            now,
            self.phase(),
            &self.registry,
            &self.at_rest,
            &Judgement {
                assessed: self.assessed.as_ref(),
                critical: self.critical_velocities(),
                range: self.known_range(),
                waiting_estimate: self.waiting_estimate(),
            },
            struck,
            self.journal.responses,
        )
    }

    /// The damage to be saved, without what the present response will add.
    pub fn saved_state(&self, now: Nanos) -> SavedState {
        self.saved_state_of(&self.at_rest, now)
    }

    pub(super) fn saved_state_of(&self, plant: &Plant, now: Nanos) -> SavedState {
        SavedState::new(&self.registry, self.parameters.fingerprint(), plant, now)
    }

    fn phase(&self) -> TwinPhase {
        match (&self.at_rest.condition, &self.response) {
            (Condition::Collapsed, _) => TwinPhase::Collapsed,
            (Condition::Fractured, _) => TwinPhase::Fractured,
            (Condition::Faulted(_), _) => TwinPhase::Faulted,
            (Condition::Standing, None) => TwinPhase::Idle,
            (Condition::Standing, Some(response)) => {
                let Struck { model, state, .. } = response.timeline.plant();
                state.sample(model).phase.into()
            }
        }
    }

    fn report_status(&mut self, now: Nanos, out: &mut impl Outputs) {
        let phase = self.phase();
        if self.status.is_due(now, phase) {
            out.put(Output::Journal(Journal::Status(StatusRecord {
                next_number: self.journal.next_number(),
                stamp: now,
                position: self.position(),
            })));
            out.put(Output::Status(self.status(now)));
        }
    }

    pub(super) fn save(&self, now: Nanos, out: &mut impl Outputs) {
        out.put(Output::Save(Arc::new(self.saved_state(now))));
    }

    // The response with the clock

    fn clock_jumped_back(&mut self, by: u64, now: Nanos, out: &mut impl Outputs) {
        let by = seconds(by);
        let text = match &self.response {
            None => format!("the clock has jumped back by {by} s"),
            Some(response) => format!(
                "the clock has jumped back by {by} s during the response to impact \"{}\", which is carried to its end without \
                 waiting for the clock",
                response.impact.event_id
            ),
        };
        out.notice(NoticeLevel::Warning, now, text);
        self.is_completing = self.response.is_some();
        self.forbid_resuming();
        self.status.set_changed();
    }

    /// Steps the column to an instant, by at most [`MAX_STEPS_PER_CALL`] steps; `now` is the time of the clock.
    pub(super) fn step_to(&mut self, instant: Nanos, now: Nanos, out: &mut impl Outputs) {
        self.make_steps_to(instant, now, out);
        self.superseded.put_withdrawn(out);
    }

    fn make_steps_to(&mut self, instant: Nanos, now: Nanos, out: &mut impl Outputs) {
        for _ in 0..MAX_STEPS_PER_CALL {
            let Some(target) = self.arrive(instant, now, out) else {
                return;
            };
            let Some(response) = &mut self.response else {
                return;
            };
            let timeline = &mut response.timeline;
            let before = timeline.step();
            let advanced = timeline.advance(target);
            self.solver.steps += timeline.step() - before;
            match advanced {
                Advanced::Running => {}
                Advanced::Over(end) => self.end(end, now, out),
                Advanced::Failed(error) => self.fail(&error, now, out),
            }
        }
        // Between two calls everything that belongs to the step that was reached has been done.
        self.arrive(instant, now, out);
    }

    /// Does what is due where the column is: its sample, and the impacts that meet it here. The step to advance to from
    /// here; `None` where `instant` is not beyond it.
    fn arrive(&mut self, instant: Nanos, now: Nanos, out: &mut impl Outputs) -> Option<u64> {
        loop {
            let next_impact = self.registry.next_pending();
            let response = self.response.as_mut()?;
            let now_step = response.timeline.step_at(instant)?;
            let next_impact = next_impact.and_then(|stamp| response.timeline.step_at(stamp));
            let target = next_impact.unwrap_or(u64::MAX).min(now_step);
            if response.timeline.is_sample_due() {
                response.put_due_state(out);
            }
            if response.timeline.step() < target {
                return Some(target);
            }
            if next_impact.is_none_or(|step| step > now_step) {
                return None;
            }
            // There are few of them, and each is taken out: the loop ends.
            let next = self.registry.take_pending()?;
            self.hit_moving_column(next, target, NO_REPORT, now, out);
        }
    }

    fn end(&mut self, end: End, now: Nanos, out: &mut impl Outputs) {
        // A forecast never comes after its report.
        self.carry_present_forecast(&mut u64::MAX.clone(), now, out);
        self.finish_superseded_forecasts(now, out);
        let Some(mut response) = self.response.take() else {
            return;
        };
        let plant = *response.timeline.plant();
        let report = plant.report(end);
        let residual = plant.residual();
        let condition = condition_after(report.end, residual.as_ref());
        response.put_state(Some(condition.final_phase()), out);
        let settled = plant.settled(residual, condition);
        // The look-ahead followed the same response. Without a forecast, because of its length, the assessment is made here.
        let predicted: Option<Predicted> = response
            .forecast
            .take_predicted()
            .filter(|it| it.report == report);
        let error_estimate = predicted.as_ref().and_then(|it| it.error_estimate);
        let mut last = LastImpact::new(
            &response.impact.striking,
            &report,
            error_estimate,
            response.impact.base_before.as_ref(),
        );
        let assessed = match predicted {
            Some(predicted) => {
                let opinion = predicted.assessed.as_ref();
                last.second_opinion = opinion.and_then(|it| it.second_opinion.clone());
                predicted.assessed
            }
            None => assess_at_once(
                &response.impact.parameters,
                &settled,
                Some(&last),
                &mut self.undamaged,
            ),
        };
        let output = ReportOutput {
            range: response.range.clone(),
            ..response.impact.report_output(
                report,
                assessed.clone(),
                error_estimate,
                response.timeline.compute_nanos(),
            )
        };
        let beam_before = &self.registry.life.beam;
        let judged = Judged::new(&response, &output, beam_before);
        response
            .beam_after
            .get_or_insert_with(|| match &response.impact.opinion {
                OpinionState::None(reason) => beam_before.without_opinion(&settled, reason),
                OpinionState::Awaited | OpinionState::Known => beam_before.while_awaited(&settled),
            });
        out.put(Output::Report(output));
        out.verdict(
            "result",
            &response.impact.event_id,
            assessed.as_deref(),
            now,
        );
        let parameters = Arc::clone(&response.impact.parameters);
        self.settle(
            response,
            settled,
            last,
            now,
            |twin| {
                // Another set of parameters may have come into force.
                match Arc::ptr_eq(&parameters, twin.parameters.current()) {
                    true => {
                        twin.assessed = assessed;
                        twin.judged = judged;
                    }
                    false => {
                        twin.assess();
                        twin.forget_range();
                    }
                }
            },
            out,
        );
    }

    /// Ends a response whose next step cannot be computed. One impact does not take the twin out of service: it goes on with
    /// the damage that the column had by then.
    fn fail(&mut self, error: &StepError, now: Nanos, out: &mut impl Outputs) {
        if let Some(response) = &self.response {
            let text = format!(
                "the response to impact \"{}\" cannot be computed beyond {} s after it: {error}; the column keeps the damage \
                 that it had by then, which may be less than the impact has caused",
                response.impact.event_id,
                response.timeline.plant().report(End::NotConverged).end_time,
            );
            out.notice(NoticeLevel::Error, now, text);
        }
        self.end(End::NotConverged, now, out);
    }

    /// Back to rest after a response; what has waited for its end follows. `assess` gives the column its assessment.
    fn settle(
        &mut self,
        response: Box<ActiveResponse>,
        settled: Plant,
        last: LastImpact,
        now: Nanos,
        assess: impl FnOnce(&mut Self),
        out: &mut impl Outputs,
    ) {
        let added = response.timeline.plant().state.ledger.plastic_work;
        self.solver.newton_iterations += response.newton_iterations();
        let life = &mut self.registry.life;
        let beam = response.beam_after.clone();
        let beam = beam.unwrap_or_else(|| life.beam.clone());
        self.last = Some(LastResponse {
            response,
            before: Some(Box::new(BeforeResponse {
                beam: std::mem::replace(&mut life.beam, beam),
                plastic_work: self.registry.life.plastic_work_since_reset,
                at_rest: std::mem::replace(&mut self.at_rest, settled),
                assessed: self.assessed.clone(),
                last_impact: self.registry.life.last_impact.replace(last),
            })),
        });
        self.registry.life.plastic_work_since_reset += added;
        self.status.set_changed();
        self.journal.set_checkpoint_due();
        self.apply_waiting_parameters(now, out);
        assess(self);
        self.forget_other_critical_velocities();
        self.save(now, out);
        while self.response.is_none()
            && let Some(next) = self.registry.take_pending()
        {
            self.begin_pending(self.at_rest.clone(), next, now, out);
            if self.response.is_none() {
                self.save(now, out); // it was rejected: fewer impacts than were saved
            }
        }
        if self.is_completing {
            // What follows has stamps of the time after the jump.
            self.forbid_resuming();
            self.is_completing = self.response.is_some();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::command::ImpactCommand;
    use super::*;
    use crate::column::ImpactSpecification;

    const NOW: Nanos = 1_800_000_000_000_000_000;

    fn hit(twin: &mut Twin, id: &str, now: Nanos, out: &mut Vec<Output>) -> bool {
        let command = Command::Impact(ImpactCommand {
            event_id: id.to_owned(),
            column_id: twin.column_id().to_string(),
            stamp: now,
            impact: ImpactSpecification {
                mass: 1500.0,
                velocity: 10.0,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            vehicle: Default::default(),
        });
        twin.handle(command, now, out).is_ok()
    }

    /// A step that did not converge once made the twin reject everything until it was reset. No impact is known that does
    /// this any more, so the error is given here.
    #[test]
    fn a_step_that_does_not_converge_leaves_the_twin_in_service() {
        let parameters = Parameters::from_values([("solver.dt", 1e-4.into())]).expect("admissible");
        let mut twin = Twin::new(parameters, None, Box::new(|| 0), NOW).expect("a column");
        let mut out = Vec::new();
        assert!(hit(&mut twin, "first", NOW, &mut out));
        let now = NOW + 10_000_000;
        twin.advance_to(now, &mut out);
        let error = StepError::NotConverged {
            step: 100,
            part_secs: 1e-9,
        };
        twin.fail(&error, now, &mut out);
        assert!(!twin.is_responding());
        let status = twin.status(now);
        assert_eq!(status.phase, TwinPhase::Idle);
        assert!(status.fault.is_empty());
        assert!(twin.at_rest.is_damaged());
        let reports: Vec<_> = out
            .iter()
            .filter_map(|output| match output {
                Output::Report(report) => Some(report.report),
                _ => None,
            })
            .collect();
        assert!(matches!(reports[..], [report] if report.end == End::NotConverged));
        assert!(out.iter().any(|output| matches!(
            output,
            Output::Notice(notice) if notice.level == NoticeLevel::Error
        )));
        assert!(hit(&mut twin, "second", now, &mut out));
    }
}
