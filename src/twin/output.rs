//! What leaves the twin.

use std::sync::Arc;

use super::input::Nanos;
use super::journal::Journal;
use super::parameter_change::Change;
use super::saved_state::SavedState;
use super::status::{Status, TwinPhase};
use crate::column::{Report, Sample};
use crate::parameters::Parameters;

/// One thing that leaves the twin. All of them are about the twin's one column.
#[derive(Debug, Clone)]
pub enum Output {
    /// The column at one instant of a response.
    State(StateOutput),
    /// What an impact that has just been accepted will do; `stamp` is the event's.
    Forecast(ReportOutput),
    /// What an impact has done; `stamp` is the event's.
    Report(ReportOutput),
    /// How the twin itself is: on every change, and once in [`STATUS_PERIOD`](super::STATUS_PERIOD).
    Status(Status),
    /// Something was refused and has changed nothing.
    Refused(Refused),
    /// Parameters were changed, or wait for the end of the response to be, or go back because they were refused then.
    ParametersChanged(ParametersChanged),
    /// For the log.
    Notice(Notice),
    /// The damage changed: to be kept outside of the thread that drives the twin.
    Save(Arc<SavedState>),
    /// For a recording, so that everything can be computed anew.
    Journal(Journal),
}

/// The column at one instant of a response.
#[derive(Debug, Clone)]
pub struct StateOutput {
    /// The instant: that of the event plus a whole number of steps.
    pub stamp: Nanos,
    /// The impact that the column responds to.
    pub event_id: Arc<str>,
    /// As that of the sample; in the last sample of a response `Rest`, `Collapsed` or `Faulted`.
    pub phase: TwinPhase,
    /// The values. `percussion` is the sum since the sample before.
    pub sample: Sample,
    /// Undeformed lengths of the bars: an impact at another height than the parameters' has moved hinges 1a and 1b.
    /// `None` where only messages are known, which do not say: as the parameters have them.
    pub lengths: Option<Lengths>,
}

/// Undeformed lengths of the two bars \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lengths {
    /// Of the lower one: the height of hinges 1a and 1b above the base.
    pub below: f64,
    /// Of the upper one.
    pub above: f64,
}

/// A forecast or a result.
#[derive(Debug, Clone)]
pub struct ReportOutput {
    /// Stamp of the event.
    pub stamp: Nanos,
    /// The impact.
    pub event_id: Arc<str>,
    /// Its outcome.
    pub report: Report,
    /// What computing it took \[s\].
    pub compute_time: f64,
}

/// What was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusedInput {
    /// An impact event.
    Impact,
    /// A change of parameters.
    Parameters,
}

/// Something that was refused and has changed nothing.
#[derive(Debug, Clone)]
pub struct Refused {
    /// When.
    pub stamp: Nanos,
    /// What.
    pub what: RefusedInput,
    /// Why, for its sender.
    pub reason: Arc<str>,
    /// Of a refused impact, shortened where it is too long; else empty.
    pub event_id: Arc<str>,
    /// Who asked for a change of parameters; else empty.
    pub source: Arc<str>,
}

/// Parameters were changed, or wait for the end of the response to be, or go back because they were refused then.
#[derive(Debug, Clone)]
pub struct ParametersChanged {
    /// When.
    pub stamp: Nanos,
    /// Which of them have new values.
    pub names: Vec<&'static str>,
    /// Applied now, or waiting.
    pub change: Change,
    /// All parameters: as they are now, or as they will be.
    pub parameters: Arc<Parameters>,
    /// Who asked for it.
    pub source: Arc<str>,
}

/// How much a notice matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// Something is not as it should be.
    Warning,
    /// Something was lost, or the twin cannot go on.
    Error,
}

/// A line for the log.
#[derive(Debug, Clone)]
pub struct Notice {
    /// When.
    pub stamp: Nanos,
    /// How much it matters.
    pub severity: Severity,
    /// What there is to say.
    pub text: Arc<str>,
}

/// Takes what leaves the twin. While a response runs it is called once per sample: it must not block, and should not
/// allocate.
pub trait Outputs {
    /// Takes one output.
    fn put(&mut self, output: Output);
}

impl Outputs for Vec<Output> {
    fn put(&mut self, output: Output) {
        self.push(output);
    }
}
