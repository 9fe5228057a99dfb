//! The twin: the order in which its parts act on a command and on the clock.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - background.rs: What another thread computes for the twin: asked for, taken, and given out with the forecast or the report
//   once more
// - impacts.rs: How an impact meets the column, that of an event or that of an estimate: at rest, in motion, or in a response
//   that is over
// - reconfiguration.rs: What changes the column other than an impact: other parameters, a correction of its damage, and the
//   reset
// - reproduction.rs: A twin that is made from a checkpoint or from an equal one, that follows a recorded one without a clock,
//   and that keeps no more than it needs

mod background;
mod impacts;
mod reconfiguration;
mod reproduction;

use std::sync::Arc;

use super::column_at_rest::ColumnAtRest;
use super::command::{Accepted, Command};
use super::course::{ActiveResponse, Arrived, Course, SolverStatistics, Stopwatch};
use super::estimates::Estimates;
use super::journal::{Journal, JournalClock, StatusRecord};
use super::output::{ForecastEnd, NoticeLevel, Output, Outputs};
use super::plant::{Condition, Plant, Struck};
use super::registry::{Counts, Registry, RejectedInput};
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

/// One column over its life. It decides which of its parts acts when; each of them keeps its own fields to itself.
pub struct Twin {
    column: ColumnAtRest,
    course: Course,
    registry: Registry,
    /// What the sensors have detected.
    estimates: Estimates,
    journal: JournalClock,
    status: StatusClock,
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
        let column = ColumnAtRest::new(parameters.into(), saved)?;
        let seen_ids = saved.map_or(&[][..], |it| &it.seen_ids);
        let registry = Registry::new(seen_ids, Counts::default(), None);
        Ok(Self::of(column, registry, Course::new(0, stopwatch), now))
    }

    fn of(column: ColumnAtRest, registry: Registry, course: Course, now: Nanos) -> Self {
        Self {
            column,
            course,
            registry,
            estimates: Estimates::default(),
            journal: JournalClock::new(now),
            status: StatusClock::new(now),
        }
    }

    /// The column may have a damage that this twin does not know, because its state file could not be used: its status says so,
    /// and calls for an inspection, until a reset. To be called before the first command.
    pub fn note_unknown_damage(&mut self) {
        self.column.note_unknown_damage();
        self.status.set_changed();
    }

    /// The column at rest has changed, or what is known of it.
    fn note_change_at_rest(&mut self) {
        self.status.set_changed();
        self.journal.set_checkpoint_due();
    }

    /// The column's name.
    pub fn column_id(&self) -> &Arc<str> {
        self.column.id()
    }

    /// The parameters that hold now.
    pub fn parameters(&self) -> &Arc<Parameters> {
        self.column.parameters()
    }

    /// What the solver has done since the start.
    pub fn statistics(&self) -> SolverStatistics {
        self.course.statistics()
    }

    /// Whether the column is responding to an impact.
    pub fn is_responding(&self) -> bool {
        self.course.present().is_some()
    }

    /// What is lost if the program ends now, in words: damage that is not saved, impacts that have not begun.
    #[must_use]
    pub fn lost_by_a_stop(&self) -> Vec<String> {
        let unsaved = self
            .course
            .present()
            .filter(|response| !response.forecast().is_known())
            .map(|response| {
                format!(
                    "the damage of impact \"{}\", to which the column is responding and whose forecast is not complete",
                    response.impact().event_id
                )
            });
        unsaved
            .into_iter()
            .chain(self.registry.pending_in_words())
            .collect()
    }

    /// The column as it is now, for [`ColumnSnapshot::predict`] in any thread.
    pub fn snapshot(&self) -> ColumnSnapshot {
        self.snapshot_of(self.plant_now())
    }

    fn plant_now(&self) -> Plant {
        let mut plant = self.column.plant().clone();
        if let Some(response) = self.course.present() {
            let Struck { model, state, .. } = *response.plant();
            (plant.model, plant.state) = (model, state);
        }
        plant
    }

    fn snapshot_of(&self, plant: Plant) -> ColumnSnapshot {
        self.column.snapshot_of(plant, self.is_responding())
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
                .map_err(|it| self.reject_request(RejectedInput::Parameters, it, source, now, out)),
            Command::RejectedChange { rejection, source } => {
                let (what, rejection) = (RejectedInput::Parameters, rejection.clone());
                Err(self.reject_request(what, rejection, source, now, out))
            }
            Command::Reset { source } => {
                self.reset(source, now, out);
                Ok(Accepted::Applied)
            }
            Command::ClockJumpedBack { by } => {
                self.clock_jumped_back(*by, now, out);
                Ok(Accepted::Applied)
            }
            Command::CriticalVelocities { vehicles } => {
                let task = self.critical_velocity_task();
                let taken = task.map(|it| self.column.keep_critical_velocities(it, vehicles));
                Ok(self.note_computed(taken.is_some()))
            }
            Command::SecondOpinion(found) => {
                let is_taken = self.course.take_opinion(found, &mut self.column);
                Ok(self.note_computed(is_taken))
            }
            Command::VerdictRange(range) => {
                let is_taken = self.course.take_range(range, &mut self.column);
                Ok(self.note_computed(is_taken))
            }
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
        self.course.put_withdrawn(out);
        self.put_estimate(out);
        if let Some(found) = opinion {
            self.put_opinion(&found, now, out);
        }
        if has_range {
            self.put_ranged(now, out);
        }
        result
    }

    /// Steps the column to the instant `now`, by at most [`MAX_STEPS_PER_CALL`] steps: a twin that is further behind has
    /// its [`Twin::next_deadline`] in the past. Samples that are due are given out, then what has changed.
    pub fn advance_to(&mut self, now: Nanos, out: &mut impl Outputs) {
        let started = self.course.stopwatch();
        match self.is_completing() {
            true => self.step_to(Nanos::MAX, now, out),
            false => self.step_to(now, now, out),
        }
        self.course.add_compute_time(started);
        self.report_checkpoint(now, out);
        self.report_status(now, out);
    }

    /// Whether the present response is carried to its end without waiting for the clock, because that has jumped back. The
    /// caller calls [`Twin::advance_to`] at once again, and better submits no impact, which would be earlier than the present one.
    pub fn is_completing(&self) -> bool {
        self.course.is_completing()
    }

    /// When [`Twin::advance_to`] is to be called again: the instant of the next sample or status; not after `now` where
    /// the twin is behind.
    pub fn next_deadline(&self, now: Nanos) -> Nanos {
        let status = self.status.next_deadline(now);
        let Some(response) = self.course.present() else {
            return status;
        };
        if self.course.is_completing() {
            return now;
        }
        let next_impact = self.registry.next_pending().unwrap_or(Nanos::MAX);
        let next_turn = response.timeline().next_deadline(now);
        status.min(next_turn).min(next_impact)
    }

    /// How often [`Twin::advance_to`] is to be called \[ns\], > 0: once per sample during a response, or more often where
    /// samples are rare; otherwise once per status.
    pub fn period(&self) -> u64 {
        let present = self.course.present();
        present.map_or(STATUS_PERIOD.unsigned_abs(), |it| it.timeline().period())
    }

    /// The state of the twin now.
    pub fn status(&self, now: Nanos) -> Status {
        let struck = self.course.present().map(ActiveResponse::plant);
        let critical = self.column.critical_velocities();
        Status::new(
            now,
            self.phase(),
            &self.registry,
            &Judgement {
                at_rest: self.column.plant(),
                life: self.column.life(),
                assessed: self.column.assessed(),
                critical: critical.filter(|_| struck.is_none()),
                range: self.column.judged().and_then(|it| it.range.as_ref()),
                waiting_estimate: self.waiting_estimate(),
            },
            struck,
            self.course.responses(),
        )
    }

    /// The damage to be saved, without what the present response will add.
    pub fn saved_state(&self, now: Nanos) -> SavedState {
        let seen_ids = self.registry.seen_ids();
        self.column.saved_of(self.column.plant(), seen_ids, now)
    }

    fn phase(&self) -> TwinPhase {
        match (&self.column.plant().condition, self.course.present()) {
            (Condition::Collapsed, _) => TwinPhase::Collapsed,
            (Condition::Fractured, _) => TwinPhase::Fractured,
            (Condition::Faulted(_), _) => TwinPhase::Faulted,
            (Condition::Standing, None) => TwinPhase::Idle,
            (Condition::Standing, Some(response)) => {
                let Struck { model, state, .. } = response.plant();
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

    // Forecasts

    /// Whether a forecast is being computed: [`Twin::run_ahead`] carries it on.
    pub fn is_looking_ahead(&self) -> bool {
        self.course.is_looking_ahead()
    }

    /// Whether the forecast of the present response was not given out yet. What remains to be computed after that, its error
    /// and forecasts of earlier responses, is not urgent.
    pub fn awaits_forecast(&self) -> bool {
        let present = self.course.present();
        present.is_some_and(ActiveResponse::awaits_forecast)
    }

    /// Most steps of the response that its forecast may still have to compute before it is given out: what `response.duration`
    /// allows. `None` if [`awaits_forecast`](Self::awaits_forecast) is false.
    pub fn forecast_steps_left(&self) -> Option<u64> {
        let response = self.course.present().filter(|it| it.awaits_forecast())?;
        let impact = response.impact();
        let steps = impact.parameters.response_duration() * 1e9 / impact.step_nanos as f64;
        let reached = response.forecast().step()?;
        Some((steps as u64).saturating_sub(reached))
    }

    /// Carries the forecasts on by at most `max_steps`. Each is given out when the response and the residual capacity are
    /// known, and again when the error of the time step is known. The present response comes first.
    pub fn run_ahead(&mut self, max_steps: u64, now: Nanos, out: &mut impl Outputs) {
        let mut budget = max_steps;
        self.carry_present_forecast(&mut budget, now, out);
        self.course
            .carry_superseded(&mut self.column, &mut budget, now, out);
    }

    fn carry_present_forecast(&mut self, budget: &mut u64, now: Nanos, out: &mut impl Outputs) {
        while let Some(completed) = self
            .course
            .advance_forecast(&mut self.column, budget, now, out)
        {
            // Saved now: if the machine stops before the response is over, the damage is known all the same. Before the forecast, so
            // that who has it finds the damage after a crash.
            let seen_ids = self.registry.seen_ids();
            let saved = self.column.saved_after(completed, seen_ids, now);
            out.put(Output::Save(Arc::new(saved)));
            self.course.give_out_forecast(now, out);
        }
    }

    /// Gives out which accepted impacts will have no forecast because the twin is stopped.
    pub fn abandon_forecasts(&mut self, out: &mut impl Outputs) {
        let reason = "the twin was stopped before the forecast was complete";
        let pending = self.registry.pending();
        self.course
            .give_up_forecasts(pending, ForecastEnd::Stopped, reason);
        self.course.put_withdrawn(out);
    }

    // The response with the clock

    fn clock_jumped_back(&mut self, by: u64, now: Nanos, out: &mut impl Outputs) {
        let by = seconds(by);
        let text = match self.course.present() {
            None => format!("the clock has jumped back by {by} s"),
            Some(response) => format!(
                "the clock has jumped back by {by} s during the response to impact \"{}\", which is carried to its end without \
                 waiting for the clock",
                response.impact().event_id
            ),
        };
        out.notice(NoticeLevel::Warning, now, text);
        self.course.clock_jumped_back();
        self.status.set_changed();
    }

    /// Steps the column to an instant, by at most [`MAX_STEPS_PER_CALL`] steps; `now` is the time of the clock.
    pub(super) fn step_to(&mut self, instant: Nanos, now: Nanos, out: &mut impl Outputs) {
        self.make_steps_to(instant, now, out);
        self.course.put_withdrawn(out);
    }

    fn make_steps_to(&mut self, instant: Nanos, now: Nanos, out: &mut impl Outputs) {
        for _ in 0..MAX_STEPS_PER_CALL {
            let Some(target) = self.arrive(instant, now, out) else {
                return;
            };
            let Some(advanced) = self.course.advance(target) else {
                return;
            };
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
            match self.course.arrive(instant, next_impact, out)? {
                Arrived::GoesOn(target) => return Some(target),
                Arrived::NextImpact(step) => {
                    // There are few of them, and each is taken out: the loop ends.
                    let next = self.registry.take_pending()?;
                    self.hit_moving_column(next, step, NO_REPORT, now, out);
                }
            }
        }
    }

    /// Ends the response. The column is back at rest, and what has waited for this follows.
    fn end(&mut self, end: End, now: Nanos, out: &mut impl Outputs) {
        // A forecast never comes after its report.
        self.carry_present_forecast(&mut u64::MAX.clone(), now, out);
        self.course.finish_superseded(&mut self.column, now, out);
        let Some(verdict) = self.course.end(end, &mut self.column, now, out) else {
            return;
        };
        self.note_change_at_rest();
        self.apply_waiting_parameters(now, out);
        self.column.take_verdict(verdict);
        self.save(now, out);
        while !self.is_responding()
            && let Some(next) = self.registry.take_pending()
        {
            self.begin_pending(self.column.plant().clone(), next, now, out);
            if !self.is_responding() {
                self.save(now, out); // it was rejected: fewer impacts than were saved
            }
        }
        self.course.go_on_completing();
    }

    /// Ends a response whose next step cannot be computed. One impact does not take the twin out of service: it goes on with
    /// the damage that the column had by then.
    fn fail(&mut self, error: &StepError, now: Nanos, out: &mut impl Outputs) {
        if let Some(response) = self.course.present() {
            let text = format!(
                "the response to impact \"{}\" cannot be computed beyond {} s after it: {error}; the column keeps the damage \
                 that it had by then, which may be less than the impact has caused",
                response.impact().event_id,
                response.plant().report(End::NotConverged).end_time,
            );
            out.notice(NoticeLevel::Error, now, text);
        }
        self.end(End::NotConverged, now, out);
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
        assert!(twin.column.plant().is_damaged());
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
