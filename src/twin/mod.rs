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
//!   arrives late, the column is taken back to there, and the samples since are computed anew under the new event. A
//!   response that is over is taken up again in the same way, until the next one begins or a parameter of the column
//!   changes.
//! - An impact that lies before the one that the column responds to is refused. Once that response is over it meets the
//!   column as the response left it: a checkpoint does not know when the last impact was.
//! - An impact that lies ahead is accepted, and refused all the same if the column cannot take it when it comes (it has
//!   collapsed by then): it then counts as refused only.
//! - An impact that ends the response to another one takes its place: the other one has no report, or one that no
//!   longer holds, which is said.
//! - Of the parameters, those that say so wait for the end of a response, and with them all others of the same request.
//!   What the column is made of cannot change while it is damaged.
//! - A reset makes the column virgin and forgets the identifiers of its impacts. The last sample of a response that a
//!   reset breaks off has no successor.

mod changes;
mod exact_number;
mod impacts;
mod input;
mod journal;
mod look_ahead;
mod output;
mod parameter_change;
mod present;
mod run;
mod saved_state;
mod seen_ids;
pub mod state_file;
mod status;
mod stepping;

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

pub use input::{ImpactEvent, Input, Nanos};
pub use journal::{
    CHECKPOINT_PERIOD, Checkpoint, Command, CommandRecord, Journal, NotReached, Position,
    StatusTaken,
};
pub use look_ahead::MAX_LOOK_AHEAD_STEPS;
pub use output::{
    Lengths, Notice, Output, Outputs, ParametersChanged, Refused, RefusedInput, ReportOutput,
    Severity, StateOutput,
};
pub use parameter_change::Change;
pub use present::{Blow, Condition, HEIGHT_TOLERANCE, Prediction, Present};
pub use saved_state::{SavedCondition, SavedState, SavedStateError};
pub use seen_ids::MAX_SEEN_IDS;
pub use status::{Counts, Status, TwinPhase};

use crate::column::{Impact, Model, ModelError, State};
use crate::parameters::Parameters;
use journal::Bookkeeping;
use look_ahead::{LookAhead, Outlook};
use parameter_change::{AtRest, Waiting};
use run::Run;
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
    journal: Bookkeeping,
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
    height: Option<f64>,
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
            journal: Bookkeeping::new(now),
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
        let corrections = self.run.as_ref().map_or(0, |run| run.state.newton_iterations);
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

    /// What a program that ends now takes along although it was accepted, in words: damage that is not kept, impacts that
    /// have not begun.
    #[must_use]
    pub fn lost_by_a_stop(&self) -> Vec<String> {
        let unkept = self.run.as_ref().filter(|run| run.last_step.is_none()).map(|run| {
            format!(
                "the damage by impact \"{}\", which the column responds to and whose forecast is not complete",
                run.event_id
            )
        });
        unkept
            .into_iter()
            .chain(self.named_impacts_ahead())
            .collect()
    }

    /// The impacts that have not begun; `None` if there are none.
    fn named_impacts_ahead(&self) -> Option<String> {
        let names: Vec<_> = self
            .impacts_ahead
            .iter()
            .map(|arriving| format!("\"{}\"", arriving.event_id))
            .collect();
        (!names.is_empty())
            .then(|| format!("accepted impacts that lie ahead: {}", names.join(", ")))
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
        let (given, reply) = match input {
            Input::Look { reply } => return answer(Some(&reply), self.present()),
            Input::Impact(event) => (Command::Impact(event), Reply::None),
            Input::Parameters {
                changes,
                source,
                reply,
            } => (
                Command::Parameters { changes, source },
                Reply::Parameters(reply),
            ),
            Input::RefusedChange { reason, source } => {
                (Command::RefusedChange { reason, source }, Reply::None)
            }
            Input::Reset { source, reply } => (Command::Reset { source }, Reply::Reset(reply)),
        };
        self.report_checkpoint(now, out);
        let position = self.position();
        let result = self.take(&given, now, out);
        let refused = result.as_ref().err().map(Arc::clone);
        self.note(given, refused, position, now, out);
        match reply {
            Reply::None => {}
            Reply::Parameters(reply) => answer(reply.as_ref(), result),
            Reply::Reset(reply) => answer(reply.as_ref(), ()),
        }
    }

    fn take(
        &mut self,
        given: &Command,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Change, Arc<str>> {
        match given {
            Command::Impact(event) => match self.take_impact(event, now, out) {
                Ok(()) => Ok(Change::Applied),
                Err(reason) => {
                    self.refuse_impact(&event.event_id, reason, now, out);
                    Err(Arc::clone(&self.last_refusal_reason))
                }
            },
            Command::Parameters { changes, source } => self
                .take_parameters(changes, source, now, out)
                .map_err(|reason| self.refuse_change(reason, source, now, out)),
            Command::Reset { source } => {
                self.reset(source, now, out);
                Ok(Change::Applied)
            }
            Command::RefusedChange { reason, source } => {
                Err(self.refuse_change(reason.to_string(), source, now, out))
            }
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
        self.report_checkpoint(now, out);
        self.report_status(now, out);
    }

    /// Carries the forecast on by `most_steps` at the most, and gives it out when it is complete.
    pub fn run_ahead(&mut self, most_steps: u64, now: Nanos, out: &mut impl Outputs) {
        let (Some(run), Some(ahead)) = (&mut self.run, &mut self.ahead) else {
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
                run.last_step = Some(ahead.step());
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
        let next_turn = run.instant_of(run.next_turn());
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
}

/// Who waits for a reply.
enum Reply {
    None,
    Parameters(Option<SyncSender<Result<Change, Arc<str>>>>),
    Reset(Option<SyncSender<()>>),
}

fn answer<T>(reply: Option<&SyncSender<T>>, value: T) {
    if let Some(reply) = reply {
        let _ = reply.try_send(value); // whoever does not wait for it does not want it
    }
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / NANOS_PER_SECOND as f64
}
