//! The log of what leaves the columns: rejections and notices, and at the level `debug` every output and where it leaves late.

use std::collections::HashMap;
use std::sync::Arc;

use crate::twin::{BeamResult, Command, Journal, Notice, Output, Rejected, RejectedInput};

use super::live_columns::LiveColumns;
use super::notice_log::log;

/// States that are published later than this are logged at the level `debug` \[ns\].
const LATE: i64 = 2_000_000;

/// Logs the outputs of the columns.
pub(super) struct OutputLog {
    columns: Arc<LiveColumns>,
    /// The stamps of the last states, at the level `debug`.
    last_states: HashMap<u32, i64>,
}

impl OutputLog {
    pub fn new(columns: Arc<LiveColumns>) -> Self {
        Self {
            columns,
            last_states: HashMap::new(),
        }
    }

    /// Tells what leaves a column, and where it leaves late.
    pub fn note(&mut self, column: u32, output: &Output) {
        match output {
            Output::Rejected(rejected) => return self.rejection(column, rejected),
            Output::Notice(notice) => return self.notice(column, notice),
            _ if !tracing::enabled!(tracing::Level::DEBUG) => return,
            _ => {}
        }
        let of = self.columns.face().words("of", column);
        match output {
            Output::State(state) => {
                let last = self.last_states.insert(column, state.stamp);
                let gap = last.map_or(0, |last| state.stamp.saturating_sub(last));
                let late = self.columns.now().saturating_sub(state.stamp);
                if late > LATE {
                    tracing::debug!(
                        "state{of} {:.6} s after the one before leaves {:.6} s late",
                        1e-9 * gap as f64,
                        1e-9 * late as f64
                    );
                }
            }
            Output::Forecast(forecast) => tracing::debug!(
                "forecast of impact {:?}{of} leaves {:.6} s after its stamp, {:.6} s of computing, error estimate {:?}",
                forecast.event_id,
                1e-9 * self.columns.now().saturating_sub(forecast.stamp) as f64,
                forecast.compute_time,
                forecast.error_estimate,
            ),
            Output::Withdrawn(it) => tracing::debug!(
                "no result of impact {:?}{of}: {}",
                it.impact.event_id,
                it.reason
            ),
            Output::Report(it) => tracing::debug!(
                "report of impact {:?}{of}, {:.6} s of computing",
                it.event_id,
                it.compute_time
            ),
            Output::Supplemented(it) => tracing::debug!(
                "impact {:?}{of} once more: second opinion {:?}, range of the verdict {:?}",
                it.report.event_id,
                it.report.opinion,
                it.report.range
            ),
            Output::Status(status) => tracing::debug!("status{of}: {:?}", status.phase),
            Output::Journal(Journal::Checkpoint(it)) => {
                tracing::debug!(
                    "checkpoint {}{of} after response {}",
                    it.number,
                    it.response
                );
            }
            Output::Journal(Journal::Command(it)) => {
                let kind = match &it.command {
                    Command::Impact(impact) => format!("impact {:?}", impact.event_id),
                    Command::SetParameters { changes, .. } => {
                        format!("change of {} parameters", changes.len())
                    }
                    Command::RejectedChange { .. } => "change that cannot be read".to_owned(),
                    Command::Reset { .. } => "reset".to_owned(),
                    Command::ClockJumpedBack { .. } => "jump of the clock".to_owned(),
                    Command::CriticalVelocities { vehicles } => {
                        format!("critical velocities of {} vehicles", vehicles.len())
                    }
                    Command::SecondOpinion(found) => match &**found {
                        BeamResult::Answer(_) => "second opinion".to_owned(),
                        BeamResult::None(reason) => reason.to_string(),
                    },
                    Command::VerdictRange(range) => format!("range of the verdict: {range}"),
                    Command::Estimate(it) => format!("estimate {} of {:?}", it.update, it.event_id),
                    Command::DecideEstimate(it) => match it.accept {
                        true => format!("confirmation of {:?}", it.event_id),
                        false => format!("rejection of {:?}", it.event_id),
                    },
                    Command::CorrectDamage(it) => format!("correction by a {}", it.quantity),
                };
                let outcome = it
                    .rejection
                    .as_ref()
                    .map_or("accepted", |it| it.code.name());
                let at = it.position;
                tracing::debug!("command {}{of}: {kind} at {at:?}: {outcome}", it.number);
            }
            Output::Estimate(it) => tracing::debug!(
                "estimate {} of {:?}{of}: {} kg, {} m/s, {:?}",
                it.record.update,
                it.record.event_id,
                it.record.estimate.mass.mean,
                it.record.estimate.velocity.mean,
                it.decision
            ),
            Output::Journal(Journal::Status(_))
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::Rejected(_)
            | Output::ParametersChanged(_)
            | Output::Notice(_)
            | Output::Save(_) => {}
        }
    }

    fn rejection(&self, column: u32, rejected: &Rejected) {
        let Rejected {
            rejection,
            event_id,
            source,
            ..
        } = rejected;
        let of = self.columns.face().words("of", column);
        match rejected.what {
            RejectedInput::Impact => {
                let for_column = self.columns.face().words("for", column);
                tracing::warn!("impact event {event_id:?}{for_column} was rejected: {rejection}");
            }
            RejectedInput::Parameters => {
                tracing::warn!("a change of parameters{of} by {source} was rejected: {rejection}");
            }
            RejectedInput::Estimate => {
                tracing::warn!(
                    "a decision about an estimate{of} by {source} was rejected: {rejection}"
                );
            }
            RejectedInput::DamageCorrection => {
                tracing::warn!(
                    "a correction of the damage{of} by {source} was rejected: {rejection}"
                );
            }
        }
    }

    fn notice(&self, column: u32, notice: &Notice) {
        let text = match self.columns.face().recorded(column) {
            Some(column_id) => &format!("column {column_id:?}: {}", notice.text),
            None => &*notice.text,
        };
        log(notice.level, text);
    }
}
