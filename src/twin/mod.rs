//! THE TWIN: one column over its life, from event to event.
//!
//! At rest it is in equilibrium under its load, with all the plastic deformation that it has suffered so far. An
//! [`ImpactEvent`] is checked; then a copy of the column runs ahead ([`Twin::run_ahead`]) to the [`Output::Forecast`],
//! while the column itself is stepped with the clock ([`Twin::advance_to`]) and gives an [`Output::State`] at every
//! instant of `publish_rate`. When the response is over the [`Output::Report`] goes out and the column is at rest again,
//! with its damage.
//!
//! What is deliberately absent: ROS, threads, locks, clocks. Time is passed in, as nanoseconds since the epoch; what
//! leaves goes into [`Outputs`]. Files are touched by [`state_file`] alone, and only when its functions are called.
//! While a response runs, [`Twin::advance_to`] allocates no memory.
//!
//! Rules that are nowhere else:
//! - A sample's stamp is the event's plus a whole number of steps; the period of `publish_rate` is rounded to whole
//!   steps.
//! - A second impact meets the moving column as it was at the last step at or before the impact's stamp. Where it
//!   arrives late, the column is taken back to there, and the samples since are computed anew under the new event. An
//!   impact that lies before the one that the column responds to is refused.
//!   That holds for a response that is over, too, until the next one begins or a parameter of the column changes.
//! - An impact that ends the response to another one takes its place: the other one has no report, or one that no
//!   longer holds, which is said.
//! - Of the parameters, those that say so wait for the end of a response, and with them all others of the same request.
//!   What the column is made of cannot change while it is damaged.
//! - A reset makes the column virgin and forgets the identifiers of its impacts. The last sample of a response that a
//!   reset breaks off has no successor.

mod input;
mod look_ahead;
mod output;
mod parameter_change;
mod present;
mod run;
mod saved_state;
mod seen_ids;
pub mod state_file;
mod status;

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

pub use input::{ImpactEvent, Input, Nanos};
pub use look_ahead::MAX_LOOK_AHEAD_STEPS;
pub use output::{
    Notice, Output, Outputs, ParametersChanged, Refused, RefusedInput, ReportOutput, Severity,
    StateOutput,
};
pub use parameter_change::Change;
pub use present::{Blow, Condition, HEIGHT_TOLERANCE, Prediction, Present};
pub use saved_state::{SavedCondition, SavedState, SavedStateError};
pub use seen_ids::MAX_SEEN_IDS;
pub use status::{Counts, Status, TwinPhase};

use crate::column::{
    End, HINGES, Impact, Model, ModelError, Report, State, StepError, residual_state,
};
use crate::parameters::{Parameters, Value};
use look_ahead::{LookAhead, Outlook};
use parameter_change::{AtRest, Waiting};
use present::{Met, equilibrium, is_damaged};
use run::{Advanced, History, Run};
use seen_ids::SeenIds;

/// A status goes out at least this often \[ns\].
pub const STATUS_PERIOD: Nanos = NANOS_PER_SECOND;

/// Most steps of one call of [`Twin::advance_to`]: some milliseconds of computing, so that a twin that catches up
/// still listens.
pub const MAX_STEPS_PER_CALL: u32 = 2_000;

/// Longest identifier of an event.
pub const MAX_EVENT_ID_CHARS: usize = 255;

/// Most impacts that may lie ahead of a column that responds to another one.
pub const MAX_IMPACTS_AHEAD: usize = 8;

/// Longest reason of a refusal; a longer one is cut.
pub const MAX_REASON_CHARS: usize = 2_000;

const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// What becomes of the report of an impact whose response another impact ends.
const NO_REPORT: &str = "will not come";

/// Tells monotonic nanoseconds: what computing takes is measured with it, nothing else.
pub type Stopwatch = Box<dyn Fn() -> u64 + Send>;

/// One column over its life.
pub struct Twin {
    column_id: Arc<str>,
    parameters: Arc<Parameters>,
    /// Digest of what the column is, as the state file has it.
    fingerprint: Arc<str>,
    waiting_parameters: Option<Waiting>,
    /// The column without motion, as the last response or a reset left it.
    at_rest: AtRest,
    condition: Condition,
    run: Option<Run>,
    ahead: Option<LookAhead>,
    impacts_ahead: Vec<Arriving>,
    /// The last response that is over.
    last: Option<Last>,
    seen: SeenIds,
    life: Life,
    counts: Counts,
    steps: u64,
    corrections: u64,
    last_refusal_reason: Arc<str>,
    last_refusal_event_id: Arc<str>,
    reported: Reported,
    stopwatch: Stopwatch,
}

/// What the column has been through since the last reset, the responses that are over.
#[derive(Debug, Clone, Default)]
struct Life {
    impacts: u32,
    refused: u64,
    plastic_work: f64,
    last_event_id: Arc<str>,
}

/// A response that is over.
#[derive(Debug)]
struct Last {
    run: Run,
    /// Work dissipated before it, while it can still be taken back to where a late impact belongs \[J\].
    resumable: Option<f64>,
}

/// The last status.
#[derive(Debug, Clone, Copy)]
struct Reported {
    at: Nanos,
    phase: TwinPhase,
    /// Something changed since.
    due: bool,
}

/// An accepted impact that has not begun.
#[derive(Debug)]
struct Arriving {
    event_id: Arc<str>,
    stamp: Nanos,
    impact: Impact,
}

/// What the solver has done since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SolverStatistics {
    /// Steps of the responses that were followed with the clock.
    pub steps: u64,
    /// Newton corrections of these steps.
    pub corrections: u64,
}

impl Twin {
    /// The twin of the column that has these parameters: virgin, or with the damage that [`state_file::load`] returned
    /// for the same parameters.
    ///
    /// # Errors
    /// The column is impossible, or does not stand under its load.
    pub fn new(
        parameters: Parameters,
        saved: Option<&SavedState>,
        stopwatch: Stopwatch,
        now: Nanos,
    ) -> Result<Self, ModelError> {
        let model = Model::new(&parameters.column_properties())?;
        let mut twin = Self {
            column_id: parameters.settings().column_id.as_str().into(),
            fingerprint: saved_state::fingerprint(&parameters).into(),
            parameters: Arc::new(parameters),
            waiting_parameters: None,
            at_rest: AtRest {
                model,
                state: State::at_rest(&model),
            },
            condition: Condition::Standing,
            run: None,
            ahead: None,
            impacts_ahead: Vec::with_capacity(MAX_IMPACTS_AHEAD),
            last: None,
            seen: SeenIds::of(saved.map_or(&[], |it| &it.seen_ids)),
            life: Life::default(),
            counts: Counts::default(),
            steps: 0,
            corrections: 0,
            last_refusal_reason: "".into(),
            last_refusal_event_id: "".into(),
            reported: Reported {
                at: now,
                phase: TwinPhase::Idle,
                due: true,
            },
            stopwatch,
        };
        if let Some(saved) = saved {
            twin.restore(saved)?;
        }
        Ok(twin)
    }

    /// The column's name.
    pub fn column_id(&self) -> &Arc<str> {
        &self.column_id
    }

    /// The parameters that apply now.
    pub fn parameters(&self) -> &Arc<Parameters> {
        &self.parameters
    }

    /// What the solver has done since the start.
    pub fn statistics(&self) -> SolverStatistics {
        let corrections = self.run.as_ref().map_or(0, |run| run.state.corrections);
        SolverStatistics {
            steps: self.steps,
            corrections: self.corrections + corrections,
        }
    }

    /// Whether the column responds to an impact.
    pub fn is_responding(&self) -> bool {
        self.run.is_some()
    }

    /// Whether a forecast is being computed: [`Twin::run_ahead`] carries it on.
    pub fn is_looking_ahead(&self) -> bool {
        self.ahead.is_some()
    }

    /// The column as it is now.
    pub fn present(&self) -> Present {
        let (model, state) = match &self.run {
            Some(run) => (run.model, run.state),
            None => (self.at_rest.model, self.at_rest.state),
        };
        Present {
            column_id: Arc::clone(&self.column_id),
            parameters: Arc::clone(&self.parameters),
            model,
            state,
            condition: self.condition.clone(),
        }
    }

    /// Does what it is asked, at the instant `now`. What follows from it with time is left to [`Twin::advance_to`] and
    /// [`Twin::run_ahead`].
    pub fn handle(&mut self, input: Input, now: Nanos, out: &mut impl Outputs) {
        match input {
            Input::Impact(event) => {
                if let Err(reason) = self.take_impact(&event, now, out) {
                    self.refuse_impact(&event.event_id, reason, now, out);
                }
            }
            Input::Parameters {
                changes,
                source,
                reply,
            } => {
                let result = self.take_parameters(&changes, &source, now, out);
                let result = result.map_err(|reason| self.refuse_change(reason, &source, now, out));
                answer(reply.as_ref(), result);
            }
            Input::Reset { source, reply } => {
                self.reset(&source, now, out);
                answer(reply.as_ref(), ());
            }
            Input::Look { reply } => answer(Some(&reply), self.present()),
        }
    }

    /// Steps the column to the instant `now`, [`MAX_STEPS_PER_CALL`] steps at the most: a twin that is further behind
    /// has its [`Twin::next_deadline`] in the past. Samples that are due go out, then what has changed.
    pub fn advance_to(&mut self, now: Nanos, out: &mut impl Outputs) {
        let started = (self.stopwatch)();
        self.step_to(now, out);
        if let Some(run) = &mut self.run {
            run.nanos = run
                .nanos
                .saturating_add((self.stopwatch)().saturating_sub(started));
        }
        self.report_status(now, out);
    }

    /// Carries the forecast on by `most_steps` at the most, and gives it out when it is complete.
    pub fn run_ahead(&mut self, most_steps: u64, now: Nanos, out: &mut impl Outputs) {
        let (Some(run), Some(ahead)) = (&self.run, &mut self.ahead) else {
            return;
        };
        let outlook = ahead.run(most_steps, &self.stopwatch);
        let (event_id, stamp) = (Arc::clone(&run.event_id), run.stamp);
        let compute_time = ahead.compute_time();
        match outlook {
            Outlook::Running => return,
            Outlook::Over { report, residual } => {
                out.put(Output::Forecast(ReportOutput {
                    stamp,
                    event_id,
                    report,
                    compute_time,
                }));
                // Kept now: a machine that stops before the response is over has the damage all the same.
                self.save_forecast(&report, residual, now, out);
            }
            Outlook::Failed(reason) => {
                let text = format!("no forecast of impact \"{event_id}\": {reason}");
                self.notice(Severity::Warning, text, now, out);
            }
        }
        self.ahead = None;
    }

    /// When [`Twin::advance_to`] is to be called again: the instant of the next sample or status; not after `now` where
    /// the twin is behind.
    pub fn next_deadline(&self, now: Nanos) -> Nanos {
        let status = if self.reported.due {
            now
        } else {
            self.reported
                .at
                .saturating_add(STATUS_PERIOD)
                .min(now.saturating_add(STATUS_PERIOD))
        };
        let Some(run) = &self.run else {
            return status;
        };
        if run
            .step_at(now)
            .is_some_and(|step| step > run.state.step + run.steps_per_turn())
        {
            return now;
        }
        let next_turn = run.instant_of(run.next_sample.min(run.state.step + run.steps_per_turn()));
        let next_impact = self
            .impacts_ahead
            .first()
            .map_or(Nanos::MAX, |next| next.stamp);
        status.min(next_turn).min(next_impact)
    }

    /// How often the column is stepped: while it responds once per sample, or more often where samples are rare; else
    /// once per status \[ns\], > 0.
    pub fn period(&self) -> u64 {
        let of = |run: &Run| run.steps_per_turn() * run.model.properties.step_nanos;
        self.run.as_ref().map_or(STATUS_PERIOD.unsigned_abs(), of)
    }

    /// The damage as it is to be kept: without what the present response will add.
    pub fn saved_state(&self, now: Nanos) -> SavedState {
        let condition = match &self.condition {
            Condition::Standing => SavedCondition::Standing,
            Condition::Collapsed => SavedCondition::Collapsed,
            Condition::Faulted(reason) => SavedCondition::Faulted(Arc::clone(reason)),
        };
        SavedState {
            column_id: Arc::clone(&self.column_id),
            fingerprint: Arc::clone(&self.fingerprint),
            stamp: now,
            condition,
            impact_height: self.at_rest.model.properties.length_below,
            displacement: self.at_rest.state.displacement,
            plastic: self.at_rest.state.plastic,
            plastic_work_since_reset: self.life.plastic_work,
            impacts_since_reset: self.life.impacts,
            refused_since_reset: self.life.refused,
            last_event_id: Arc::clone(&self.life.last_event_id),
            seen_ids: self.seen.to_vec(),
        }
    }
}

/// Impacts.
impl Twin {
    fn take_impact(
        &mut self,
        event: &ImpactEvent,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), String> {
        let present = self.present();
        present.check_column(&event.column_id)?;
        self.check_event_id(&event.event_id)?;
        self.check_stamp(event.stamp, now)?;
        let impact = present.impact_of(&event.blow())?;
        let met = present.meet(impact, event.height)?;
        let arriving = Arriving {
            event_id: event.event_id.as_str().into(),
            stamp: event.stamp,
            impact,
        };
        let event_id = Arc::clone(&arriving.event_id);
        match self
            .run
            .as_ref()
            .map(|run| (run.stamp, run.step_at(event.stamp), run.state.step))
        {
            None => match self.resume(arriving.stamp, &met.model) {
                Some(step) => self.hit_moving_column(arriving, step, "no longer holds", now, out),
                None => self.begin(arriving.event_id, arriving.stamp, met, now, out),
            },
            Some((_, Some(step), reached)) if step <= reached => {
                self.hit_moving_column(arriving, step, NO_REPORT, now, out);
            }
            Some((_, Some(_), _)) => self.keep_for_later(arriving)?,
            Some((first, None, _)) => {
                return Err(format!(
                    "its stamp lies {} s before that of the impact that the column responds to; \
                     impacts must come in the order of their stamps",
                    seconds(first.abs_diff(event.stamp))
                ));
            }
        }
        self.seen.remember(event_id);
        self.counts.events_accepted += 1;
        self.life.impacts = self.life.impacts.saturating_add(1);
        self.reported.due = true;
        Ok(())
    }

    fn check_event_id(&self, id: &str) -> Result<(), String> {
        let chars = id.chars().take(MAX_EVENT_ID_CHARS + 1).count();
        if chars == 0 {
            return Err("event_id is empty; give every impact an identifier of its own".to_owned());
        }
        if chars > MAX_EVENT_ID_CHARS || id.chars().take(chars).any(char::is_control) {
            return Err(format!(
                "event_id is too long or has control characters; \
                 allowed: 1 to {MAX_EVENT_ID_CHARS} characters, no control characters"
            ));
        }
        if self.seen.contains(id) {
            return Err("an impact of this event_id was accepted before; \
                 give every impact an identifier of its own"
                .to_owned());
        }
        Ok(())
    }

    fn check_stamp(&self, stamp: Nanos, now: Nanos) -> Result<(), String> {
        let tolerance = &self.parameters.settings().event;
        let off = seconds(stamp.abs_diff(now));
        if stamp <= now && off > tolerance.max_age {
            return Err(format!(
                "its stamp is {off} s old, event.max_age is {} s; \
                 check that sender and twin have the same clock",
                tolerance.max_age
            ));
        }
        if stamp > now && off > tolerance.max_ahead {
            return Err(format!(
                "its stamp is {off} s ahead, event.max_ahead is {} s; \
                 check that sender and twin have the same clock",
                tolerance.max_ahead
            ));
        }
        Ok(())
    }

    fn keep_for_later(&mut self, arriving: Arriving) -> Result<(), String> {
        if self.impacts_ahead.len() == MAX_IMPACTS_AHEAD {
            return Err(format!(
                "{MAX_IMPACTS_AHEAD} impacts lie ahead already; send impacts when they happen"
            ));
        }
        let place = self
            .impacts_ahead
            .partition_point(|other| other.stamp <= arriving.stamp);
        self.impacts_ahead.insert(place, arriving);
        Ok(())
    }

    /// Takes up the last response again where an impact is so late that it belongs into it: the step where it does.
    fn resume(&mut self, stamp: Nanos, model: &Model) -> Option<u64> {
        let last = self.last.as_ref()?;
        let plastic_work = last.resumable?;
        let step = last
            .run
            .step_at(stamp)
            .filter(|&step| step < last.run.state.step)?;
        if last.run.model != *model {
            return None;
        }
        let run = self.last.take()?.run;
        self.life.plastic_work = plastic_work;
        self.corrections -= run.state.corrections;
        self.run = Some(run);
        Some(step)
    }

    /// The response to another impact ends where the column was at `step`; `becomes` says what becomes of its report.
    fn hit_moving_column(
        &mut self,
        arriving: Arriving,
        step: u64,
        becomes: &str,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(mut run) = self.run.take() else {
            return;
        };
        run.rewind(step);
        self.ahead = None;
        self.life.plastic_work += run.state.ledger.plastic_work;
        self.corrections += run.state.corrections;
        let text = format!(
            "impact \"{}\" hits the column {} s after impact \"{}\", whose report {becomes}",
            arriving.event_id,
            seconds(arriving.stamp.abs_diff(run.stamp)),
            run.event_id,
        );
        self.notice(Severity::Info, text, now, out);
        let present = Present {
            model: run.model,
            state: run.state,
            ..self.present()
        };
        self.last = Some(Last {
            run,
            resumable: None,
        });
        self.begin_arriving(&present, arriving, now, out);
    }

    fn begin_arriving(
        &mut self,
        present: &Present,
        arriving: Arriving,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Arriving {
            event_id,
            stamp,
            impact,
        } = arriving;
        match present.meet(impact, Some(present.model.properties.length_below)) {
            Ok(met) => self.begin(event_id, stamp, met, now, out),
            Err(reason) => self.refuse_impact(&event_id, reason, now, out),
        }
    }

    fn begin(
        &mut self,
        event_id: Arc<str>,
        stamp: Nanos,
        met: Met,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let text = format!("impact \"{event_id}\" accepted");
        self.notice(Severity::Info, text, now, out);
        self.life.last_event_id = Arc::clone(&event_id);
        self.ahead = Some(LookAhead::new(met.clone()));
        let steps = self.steps_per_sample(&met.model);
        let history = self
            .last
            .take()
            .map_or_else(History::default, |it| it.run.into_history());
        self.run = Some(Run::new(event_id, stamp, met, steps, history));
        self.reported.due = true;
    }

    /// The period of `publish_rate` in whole steps.
    fn steps_per_sample(&self, model: &Model) -> u64 {
        let steps =
            1e9 / self.parameters.settings().publish_rate / model.properties.step_nanos as f64;
        steps.round().max(1.0) as u64
    }

    fn refuse_impact(
        &mut self,
        event_id: &str,
        reason: String,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let event_id: Arc<str> = shortened(event_id).into();
        self.counts.events_refused += 1;
        self.life.refused += 1;
        self.refuse(RefusedInput::Impact, &reason, event_id, "".into(), now, out);
    }

    fn refuse(
        &mut self,
        what: RefusedInput,
        reason: &str,
        event_id: Arc<str>,
        source: Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let reason: Arc<str> = cut(reason, MAX_REASON_CHARS).into();
        self.last_refusal_reason = Arc::clone(&reason);
        self.last_refusal_event_id = Arc::clone(&event_id);
        self.reported.due = true;
        out.put(Output::Refused(Refused {
            stamp: now,
            what,
            reason,
            event_id,
            source,
        }));
    }
}

/// The response with the clock.
impl Twin {
    fn step_to(&mut self, now: Nanos, out: &mut impl Outputs) {
        for _ in 0..MAX_STEPS_PER_CALL {
            let Some(run) = &mut self.run else {
                return;
            };
            let Some(now_step) = run.step_at(now) else {
                return;
            };
            let next_impact = self
                .impacts_ahead
                .first()
                .and_then(|next| run.step_at(next.stamp));
            let target = next_impact.unwrap_or(u64::MAX).min(now_step);
            if run.state.step >= run.next_sample {
                put_state(run, None, out);
            }
            if run.state.step >= target {
                if next_impact.is_none_or(|step| step > now_step) {
                    return;
                }
                let next = self.impacts_ahead.remove(0);
                self.hit_moving_column(next, target, NO_REPORT, now, out);
                continue;
            }
            let before = run.state.step;
            let advanced = run.advance(target);
            self.steps += run.state.step - before;
            match advanced {
                Advanced::Running => {}
                Advanced::Over(end) => self.end(end, now, out),
                Advanced::Failed(error) => self.fail(&error, now, out),
            }
        }
    }

    fn end(&mut self, end: End, now: Nanos, out: &mut impl Outputs) {
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

    fn fail(&mut self, error: &StepError, now: Nanos, out: &mut impl Outputs) {
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
    fn settle(&mut self, run: Run, residual: Option<State>, now: Nanos, out: &mut impl Outputs) {
        let plastic_work = self.life.plastic_work;
        self.life.plastic_work += run.state.ledger.plastic_work;
        self.corrections += run.state.corrections;
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
        self.apply_waiting_parameters(now, out);
        self.save(now, out);
        while self.run.is_none() && !self.impacts_ahead.is_empty() {
            let next = self.impacts_ahead.remove(0);
            self.begin_arriving(&self.present(), next, now, out);
        }
    }
}

/// Parameters and reset.
impl Twin {
    fn take_parameters(
        &mut self,
        changes: &[(String, Value)],
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Change, String> {
        // What waits already is to go with what comes now.
        let latest = self
            .waiting_parameters
            .as_ref()
            .map_or(&self.parameters, |it| &it.parameters);
        let latest = Arc::clone(latest);
        let wanted = Arc::new(parameter_change::validated(&latest, changes)?);
        let changed = wanted.changed_from(&latest);
        if changed.is_empty() {
            self.counts.parameters_accepted += 1;
            return Ok(Change::Nothing);
        }
        let column = self.column_with(&wanted)?;
        let change = match self.run.is_some() && parameter_change::must_wait(&changed) {
            true => {
                self.waiting_parameters = Some(Waiting {
                    parameters: Arc::clone(&wanted),
                    source: Arc::clone(source),
                });
                Change::Waits
            }
            false => {
                self.apply(&wanted, changes, column)?;
                Change::Applied
            }
        };
        self.counts.parameters_accepted += 1;
        self.reported.due = true;
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names: changed.iter().map(|parameter| parameter.name).collect(),
            change,
            parameters: wanted,
            source: Arc::clone(source),
        }));
        if change == Change::Applied && self.run.is_none() {
            self.save(now, out);
        }
        Ok(change)
    }

    /// The column at rest with other parameters.
    fn column_with(&self, wanted: &Parameters) -> Result<AtRest, String> {
        if self.condition == Condition::Standing {
            return parameter_change::changed_column(&self.at_rest, &self.parameters, wanted);
        }
        let column = |parameters: &Parameters| parameters.column_properties();
        if column(wanted) == column(&self.parameters) {
            return Ok(self.at_rest.clone());
        }
        Err(
            "the column has collapsed or cannot be computed; reset the twin first (~/reset)"
                .to_owned(),
        )
    }

    /// Applies what need not wait. While other changes wait, these are applied to both, the present parameters and the
    /// ones that wait.
    fn apply(
        &mut self,
        wanted: &Arc<Parameters>,
        changes: &[(String, Value)],
        column: AtRest,
    ) -> Result<(), String> {
        match &mut self.waiting_parameters {
            Some(waiting) => {
                self.parameters = Arc::new(parameter_change::validated(&self.parameters, changes)?);
                waiting.parameters = Arc::clone(wanted);
            }
            None => self.parameters = Arc::clone(wanted),
        }
        self.fingerprint = saved_state::fingerprint(&self.parameters).into();
        if self.run.is_none() {
            self.at_rest = column;
            self.forbid_resuming();
        }
        Ok(())
    }

    fn forbid_resuming(&mut self) {
        if let Some(last) = &mut self.last {
            last.resumable = None;
        }
    }

    fn apply_waiting_parameters(&mut self, now: Nanos, out: &mut impl Outputs) {
        let Some(Waiting { parameters, source }) = self.waiting_parameters.take() else {
            return;
        };
        match self.column_with(&parameters) {
            Ok(column) => {
                let names = parameters.changed_from(&self.parameters);
                self.at_rest = column;
                self.forbid_resuming();
                self.parameters = Arc::clone(&parameters);
                self.fingerprint = saved_state::fingerprint(&parameters).into();
                self.reported.due = true;
                out.put(Output::ParametersChanged(ParametersChanged {
                    stamp: now,
                    names: names.iter().map(|parameter| parameter.name).collect(),
                    change: Change::Applied,
                    parameters,
                    source,
                }));
            }
            Err(reason) => {
                let reason =
                    format!("the change that waited for the end of the response: {reason}");
                self.refuse_change(reason, &source, now, out);
            }
        }
    }

    fn refuse_change(
        &mut self,
        reason: String,
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Arc<str> {
        self.counts.parameters_refused += 1;
        self.refuse(
            RefusedInput::Parameters,
            &reason,
            "".into(),
            Arc::clone(source),
            now,
            out,
        );
        Arc::clone(&self.last_refusal_reason)
    }

    fn reset(&mut self, source: &str, now: Nanos, out: &mut impl Outputs) {
        if let Some(run) = self.run.take() {
            let text = format!(
                "the response to impact \"{}\" is broken off by a reset",
                run.event_id
            );
            self.notice(Severity::Warning, text, now, out);
            self.corrections += run.state.corrections;
            self.last = Some(Last {
                run,
                resumable: None,
            });
        }
        self.forbid_resuming();
        self.ahead = None;
        self.impacts_ahead.clear();
        self.condition = Condition::Standing;
        // The parameters stood the check when they came; were they to fail now the old model is still a column.
        let virgin = Model::new(&self.parameters.column_properties()).unwrap_or(self.at_rest.model);
        self.at_rest = AtRest {
            model: virgin,
            state: State::at_rest(&virgin),
        };
        self.seen.clear();
        self.life = Life::default();
        self.apply_waiting_parameters(now, out);
        self.notice(
            Severity::Info,
            format!("reset by {source}: the column is virgin"),
            now,
            out,
        );
        self.reported.due = true;
        self.save(now, out);
    }
}

/// What is said and kept.
impl Twin {
    /// As it was when it was saved; where the load is another one now, in its new equilibrium.
    fn restore(&mut self, saved: &SavedState) -> Result<(), ModelError> {
        let mut properties = self.parameters.column_properties();
        parameter_change::move_joint(&mut properties, saved.impact_height);
        let model = Model::new(&properties)?;
        let mut state = State::settled(&model, saved.displacement, saved.plastic);
        self.condition = match &saved.condition {
            SavedCondition::Standing => Condition::Standing,
            SavedCondition::Collapsed => Condition::Collapsed,
            SavedCondition::Faulted(reason) => Condition::Faulted(Arc::clone(reason)),
        };
        if self.condition == Condition::Standing {
            let is_as_saved =
                residual_state(&model, &state).is_some_and(|now| is_same_place(&now, &state));
            match equilibrium(&model, &state) {
                _ if is_as_saved => {}
                Some(now) => state = now,
                None => self.condition = no_equilibrium(),
            }
        }
        self.at_rest = AtRest { model, state };
        self.life = Life {
            impacts: saved.impacts_since_reset,
            refused: saved.refused_since_reset,
            plastic_work: saved.plastic_work_since_reset,
            last_event_id: Arc::clone(&saved.last_event_id),
        };
        Ok(())
    }

    fn save(&self, now: Nanos, out: &mut impl Outputs) {
        out.put(Output::Save(Arc::new(self.saved_state(now))));
    }

    /// The state as it will be when the present response is over.
    fn save_forecast(
        &self,
        report: &Report,
        residual: Option<State>,
        now: Nanos,
        out: &mut impl Outputs,
    ) {
        let Some(run) = &self.run else {
            return;
        };
        let mut saved = self.saved_state(now);
        saved.condition = match condition_after(report, residual.as_ref()) {
            Condition::Standing => SavedCondition::Standing,
            Condition::Collapsed => SavedCondition::Collapsed,
            Condition::Faulted(reason) => SavedCondition::Faulted(reason),
        };
        if let Some(residual) = residual {
            saved.displacement = residual.displacement;
            saved.plastic = residual.plastic;
        }
        saved.impact_height = run.model.properties.length_below;
        saved.plastic_work_since_reset += report.plastic_work;
        out.put(Output::Save(Arc::new(saved)));
    }

    fn notice(&self, severity: Severity, text: String, now: Nanos, out: &mut impl Outputs) {
        out.put(Output::Notice(Notice {
            stamp: now,
            severity,
            text: text.into(),
        }));
    }

    fn phase(&self) -> TwinPhase {
        match (&self.condition, &self.run) {
            (Condition::Collapsed, _) => TwinPhase::Collapsed,
            (Condition::Faulted(_), _) => TwinPhase::Faulted,
            (Condition::Standing, Some(run)) => run.phase(),
            (Condition::Standing, None) => TwinPhase::Idle,
        }
    }

    /// How the twin is now.
    pub fn status(&self, now: Nanos) -> Status {
        let present = self.at_rest.state.sample(&self.at_rest.model);
        let plastic_work = self
            .run
            .as_ref()
            .map_or(0.0, |run| run.state.ledger.plastic_work);
        let hinges = match &self.run {
            Some(run) => run.state.sample(&run.model).hinges,
            None => present.hinges,
        };
        let mut plastic_rotation = [0.0; HINGES];
        let mut plastic_elongation = [0.0; HINGES];
        for (index, hinge) in hinges.iter().enumerate() {
            plastic_rotation[index] = hinge.plastic_rotation;
            plastic_elongation[index] = hinge.plastic_elongation;
        }
        Status {
            stamp: now,
            phase: self.phase(),
            event_id: Arc::clone(&self.life.last_event_id),
            counts: self.counts,
            last_refusal_reason: Arc::clone(&self.last_refusal_reason),
            last_refusal_event_id: Arc::clone(&self.last_refusal_event_id),
            fault: match &self.condition {
                Condition::Faulted(reason) => Arc::clone(reason),
                Condition::Standing | Condition::Collapsed => Arc::default(),
            },
            impacts_since_reset: self.life.impacts,
            residual_v1: present.v1,
            residual_u2: present.u2,
            plastic_work_since_reset: self.life.plastic_work + plastic_work,
            plastic_rotation,
            plastic_elongation,
        }
    }

    fn report_status(&mut self, now: Nanos, out: &mut impl Outputs) {
        let phase = self.phase();
        let Reported {
            at,
            phase: last,
            due,
        } = self.reported;
        // A clock that was set back must not silence the twin.
        let long_ago = now < at || now.saturating_sub(at) >= STATUS_PERIOD;
        if due || long_ago || phase != last {
            out.put(Output::Status(self.status(now)));
            self.reported = Reported {
                at: now,
                phase,
                due: false,
            };
        }
    }
}

fn put_state(run: &mut Run, phase: Option<TwinPhase>, out: &mut impl Outputs) {
    let sample = run.sample();
    out.put(Output::State(StateOutput {
        stamp: run.instant_of(run.state.step),
        event_id: Arc::clone(&run.event_id),
        phase: phase.unwrap_or(sample.phase.into()),
        sample,
    }));
}

fn condition_after(report: &Report, residual: Option<&State>) -> Condition {
    match (report.end, residual) {
        (End::Collapsed, _) => Condition::Collapsed,
        (_, Some(_)) => Condition::Standing,
        (_, None) => no_equilibrium(),
    }
}

fn no_equilibrium() -> Condition {
    Condition::Faulted("the damaged column finds no equilibrium under its load".into())
}

fn phase_after(condition: &Condition) -> TwinPhase {
    match condition {
        Condition::Standing => TwinPhase::Rest,
        Condition::Collapsed => TwinPhase::Collapsed,
        Condition::Faulted(_) => TwinPhase::Faulted,
    }
}

/// Whether two equilibria are one, found twice: nearer to each other than anybody can measure.
fn is_same_place(a: &State, b: &State) -> bool {
    const NEAR: f64 = 1e-9; // m and rad
    let (a, b) = (&a.displacement, &b.displacement);
    [a.v1 - b.v1, a.u1 - b.u1, a.beta1 - b.beta1, a.u2 - b.u2]
        .iter()
        .all(|off| off.abs() < NEAR)
}

fn answer<T>(reply: Option<&SyncSender<T>>, value: T) {
    if let Some(reply) = reply {
        let _ = reply.try_send(value); // whoever does not wait for it does not want it
    }
}

/// A name from outside as it may stand in a message: not too long, and nothing that a terminal would obey.
fn shortened(name: &str) -> String {
    cut(name, MAX_EVENT_ID_CHARS)
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

fn cut(text: &str, most_chars: usize) -> String {
    match text.char_indices().nth(most_chars) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / NANOS_PER_SECOND as f64
}
