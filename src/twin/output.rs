//! What leaves the twin.

use std::sync::Arc;

use super::assessed::Assessed;
use super::command::Accepted;
use super::damage_correction::DamageCorrection;
use super::estimates::Decision;
use super::journal::Journal;
use super::opinion_state::OpinionState;
use super::registry::Rejected;
use super::saved_state::SavedState;
use super::status::Lengths;
use super::status::{Status, TwinPhase};
use super::striking::Striking;
use super::withdrawn_impact::WithdrawnImpact;
use crate::assessment::{self, NOT_ASSESSED, VerdictRange};
use crate::column::{Report, Sample};
use crate::estimation::{EstimateRecord, EventEvidence};
use crate::parameters::Parameters;
use crate::second_opinion::Movement;
use crate::time::Nanos;

/// One thing that leaves the twin. All of them are about the twin's one column.
#[derive(Debug, Clone)]
pub enum Output {
    /// The column at one instant of a response.
    State(StateOutput),
    /// What an impact that has just been accepted will do; `stamp` is the event's. It is given out again when the error of the
    /// time step is known.
    Forecast(ReportOutput),
    /// What an impact has done; `stamp` is the event's.
    Report(ReportOutput),
    /// A forecast or a report once more, now that the second opinion on it or the range of its verdict is known.
    Supplemented(SupplementedReport),
    /// The forecast of an accepted impact no longer holds, or there will be none; in both cases no report follows.
    Withdrawn(WithdrawnForecast),
    /// What the sensors say about an impact: with every estimate, and when it was decided whether it is an impact of the twin.
    Estimate(EstimateOutput),
    /// The impact with this identifier is another one than was known so far: its estimate has changed. Forecasts and a report
    /// that were given out before no longer hold, and others follow.
    Replaced(Arc<str>),
    /// An event is the same impact as one that the sensors have detected: evidence for its estimate.
    Merged(MergedEvent),
    /// The damage of the column was compared with a measurement.
    DamageCorrected(DamageCorrection),
    /// The state of the twin itself: on every change, and at least once per [`STATUS_PERIOD`](super::STATUS_PERIOD).
    Status(Status),
    /// A command was rejected and has changed nothing.
    Rejected(Rejected),
    /// Parameters were changed, or a change waits for the end of a response, or one that waited was rejected.
    ParametersChanged(ParametersChanged),
    /// For the log.
    Notice(Notice),
    /// The damage has changed: to be saved outside of the thread that drives the twin.
    Save(Arc<SavedState>),
    /// For a recording, so that everything can be recomputed.
    Journal(Journal),
}

/// The column at one instant of a response.
#[derive(Debug, Clone)]
pub struct StateOutput {
    /// The instant: that of the event plus a whole number of steps.
    pub stamp: Nanos,
    /// The impact to which the column is responding.
    pub event_id: Arc<str>,
    /// That of the sample; in the last sample of a response `Rest`, `Collapsed` or `Faulted`.
    pub phase: TwinPhase,
    /// The values. `impact_impulse` is the sum since the sample before.
    pub sample: Sample,
    /// Undeformed lengths of the bars: an impact at another height than the parameters' has moved hinges 1a and 1b.
    /// `None` where only messages are known, which do not contain them: as the parameters have them.
    pub lengths: Option<Lengths>,
    /// The vehicle, for pictures. `None` where only messages are known.
    pub vehicle: Option<StrikingVehicle>,
}

/// Name, mass and direction of the vehicle that hits the column.
#[derive(Debug, Clone, PartialEq)]
pub struct StrikingVehicle {
    /// Its name in the catalogue; empty: the one that the parameters give by numbers.
    pub name: Arc<str>,
    /// Its total mass \[kg\].
    pub mass: f64,
    /// The direction in which it travels \[rad\].
    pub direction: f64,
}

/// A forecast or a result.
#[derive(Debug, Clone)]
pub struct ReportOutput {
    /// Stamp of the event.
    pub stamp: Nanos,
    /// The impact.
    pub event_id: Arc<str>,
    /// What hits the column.
    pub striking: Striking,
    /// Its outcome.
    pub report: Report,
    /// The assessment of the column that it leaves behind; `None` if that column cannot be computed.
    pub assessed: Option<Arc<Assessed>>,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known, or not yet.
    pub error_estimate: Option<f64>,
    /// Length of a time step \[ns\].
    pub step_nanos: u64,
    /// What computing it took \[s\].
    pub compute_time: f64,
    /// It is the forecast of a response that something else has ended; an [`Output::Withdrawn`] follows.
    pub is_superseded: bool,
    /// Between which actions the verdict lies; `None` where it is not known, or not yet.
    pub range: Option<Arc<VerdictRange>>,
    /// Where the second opinion stands: once it is known, `assessed` has it.
    pub opinion: OpinionState,
}

/// A forecast or a result with what was computed behind it: the second opinion, and with it the verdict of both models, or the range
/// of the verdict. Nothing else differs from what was given out before.
#[derive(Debug, Clone)]
pub struct SupplementedReport {
    /// With it.
    pub report: ReportOutput,
    /// Whether it is a result.
    pub is_result: bool,
    /// How the fibre beam has moved, for drawings, where the second opinion has just become known.
    pub movement: Option<Arc<Movement>>,
}

/// The forecast of an accepted impact no longer holds, or there will be none.
#[derive(Debug, Clone)]
pub struct WithdrawnForecast {
    /// The impact.
    pub impact: WithdrawnImpact,
    /// Whether a forecast was given out.
    pub was_known: bool,
    /// Estimated relative error of its `max_v1`, if it was given out again with it.
    pub error_estimate: Option<f64>,
    /// For programs.
    pub end: ForecastEnd,
    /// For people.
    pub reason: Arc<str>,
}

/// What the sensors say about an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimateOutput {
    /// Its mean instant of contact.
    pub stamp: Nanos,
    /// The newest estimate, and what made it so.
    pub record: Arc<EstimateRecord>,
    /// What has become of it.
    pub decision: Decision,
    /// The event that is the same impact, if there is one: the impact itself if the decision is [`Decision::Merged`].
    pub merged_event_id: Option<Arc<str>>,
}

/// An event that is the same impact as one that the sensors have detected.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedEvent {
    /// Its identifier.
    pub event_id: Arc<str>,
    /// That of the estimate.
    pub estimate_id: Arc<str>,
    /// Its instant of contact.
    pub contact: Nanos,
    /// What its sender saw.
    pub striking: Striking,
    /// How that counts for the estimate.
    pub evidence: EventEvidence,
}

/// Why a forecast no longer holds, or why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForecastEnd {
    /// Another impact has hit the moving column; its forecast and its report include what this one did.
    Superseded,
    /// A reset has made the column undamaged.
    Reset,
    /// The twin was stopped.
    Stopped,
    /// When the impact was due, the column could not take it.
    Rejected,
    /// It cannot be computed.
    NotComputed,
}

/// Parameters were changed, or a change waits for the end of a response, or one that waited was rejected.
#[derive(Debug, Clone)]
pub struct ParametersChanged {
    /// When.
    pub stamp: Nanos,
    /// The parameters that have new values, or will have; of a rejected change, those that keep theirs.
    pub names: Vec<String>,
    /// Whether the new values apply now or wait; `Unchanged` if the change had waited and was rejected.
    pub change: Accepted,
    /// The parameters that wait for the end of the response now.
    pub waiting: Vec<String>,
    /// All parameters as they hold now.
    pub parameters: Arc<Parameters>,
    /// The sender of the change.
    pub source: Arc<str>,
}

/// How much a notice matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoticeLevel {
    /// Worth knowing.
    Info,
    /// Something is not as it should be.
    Warning,
    /// Something was lost, or the twin cannot continue.
    Error,
}

/// A line for the log.
#[derive(Debug, Clone)]
pub struct Notice {
    /// When.
    pub stamp: Nanos,
    /// How much it matters.
    pub level: NoticeLevel,
    /// The text.
    pub text: Arc<str>,
}

/// Takes what leaves the twin. While a response runs it is called once per sample: it must not block, and should not
/// allocate.
pub trait Outputs {
    /// Takes one output.
    fn put(&mut self, output: Output);

    /// Takes a notice for the log.
    fn notice(&mut self, level: NoticeLevel, stamp: Nanos, text: String) {
        self.put(Output::Notice(Notice {
            stamp,
            level,
            text: text.into(),
        }));
    }
}

/// The lines of the log about the action of a forecast or a result.
pub(super) trait Verdicts {
    /// Takes what an impact will have done, or has done, to the column.
    fn verdict(&mut self, kind: &str, event_id: &str, assessed: Option<&Assessed>, now: Nanos);
}

impl<O: Outputs> Verdicts for O {
    fn verdict(&mut self, kind: &str, event_id: &str, assessed: Option<&Assessed>, now: Nanos) {
        let Some(Assessed { assessment, .. }) = assessed else {
            let text = format!(
                "{kind} of impact \"{event_id}\": the column cannot be assessed. {NOT_ASSESSED}"
            );
            return self.notice(NoticeLevel::Error, now, text);
        };
        let action = match assessment.action {
            assessment::Action::None => NoticeLevel::Info,
            assessment::Action::Inspect | assessment::Action::Restrict => NoticeLevel::Warning,
            assessment::Action::Shore | assessment::Action::Evacuate => NoticeLevel::Error,
        };
        let text = format!("{kind} of impact \"{event_id}\": {}", assessment.in_words());
        self.notice(action, now, text);
    }
}

impl Outputs for Vec<Output> {
    fn put(&mut self, output: Output) {
        self.push(output);
    }
}
