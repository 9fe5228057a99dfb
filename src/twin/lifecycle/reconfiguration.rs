//! Changes of the parameters, and the reset.

use std::sync::Arc;

use super::Twin;
use crate::parameters::{Parameters, SectionShape, Value};
use crate::time::Nanos;
use crate::time::seconds;
use crate::twin::command::Accepted;
use crate::twin::output::{ForecastEnd, NoticeLevel, Output, Outputs, ParametersChanged};
use crate::twin::plant::{OF_ITS_MAKE, Plant};
use crate::twin::rejection::{Rejection, RejectionCode};

/// Maximum length of a response \[steps\] whose end is computed in order to judge a change that waits for it: at most about a
/// second, which the sender of the change has to wait.
const MAX_FORESEEN_STEPS: f64 = 1e6;

/// Steps in which the end of a response is computed.
const FORESEEING_SLICE: u64 = 1024;

/// A damage belongs to the shape of the section, which the numbers of the two bars need not tell.
fn check_shape(is_damaged: bool, [from, to]: [SectionShape; 2]) -> Result<(), Rejection> {
    match is_damaged && from != to {
        true => Err(Rejection::new(RejectionCode::ColumnDamaged, OF_ITS_MAKE)),
        false => Ok(()),
    }
}

impl Twin {
    pub(super) fn set_parameters(
        &mut self,
        changes: &[(String, Value)],
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        let planned = self.parameters.plan(changes)?;
        if planned.names.is_empty() {
            self.registry.counts.parameters_accepted += 1;
            return Ok(Accepted::Unchanged);
        }
        let column = self.column_with(&planned.parameters)?;
        let change = if self.response.is_some() && planned.must_wait {
            self.check_at_end(&planned.parameters, now, out)?;
            self.parameters.make_wait(&planned.parameters, source);
            Accepted::Waiting
        } else {
            self.parameters.apply(&planned.parameters, changes)?;
            if self.response.is_none() {
                self.replace_column(column);
                self.assess();
                self.forget_other_critical_velocities();
                self.forget_range();
            }
            Accepted::Applied
        };
        self.registry.counts.parameters_accepted += 1;
        self.status.set_changed();
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names: planned.names,
            change,
            waiting: self.parameters.waiting_names(),
            parameters: Arc::clone(self.parameters.current()),
            source: Arc::clone(source),
        }));
        if change == Accepted::Applied && self.response.is_none() {
            self.save(now, out);
        }
        Ok(change)
    }

    /// Rejects a change at once that the column would not take when the response under way has ended, because of the damage
    /// that it leaves.
    fn check_at_end(
        &mut self,
        wanted: &Parameters,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), Rejection> {
        let from = self.parameters.current().column_properties();
        let shapes = self.shapes(wanted);
        let Some(at_rest) = self.predicted_at_rest(now, out) else {
            return Ok(());
        };
        at_rest
            .with_properties(&from, &wanted.column_properties())
            .and_then(|_| check_shape(at_rest.is_damaged(), shapes))
            .map_err(|Rejection { code, reason }| {
                let reason = format!(
                    "the change cannot take effect when the response to the impact ends: by then, {reason}"
                );
                Rejection::new(code, reason)
            })
    }

    /// The column as the response under way will leave it. Its forecast is completed for this, so that the answer does not
    /// depend on how far it had come; `None` for a response that may be too long, or cannot be computed.
    fn predicted_at_rest(&mut self, now: Nanos, out: &mut impl Outputs) -> Option<&Plant> {
        let response = self.response.as_ref()?;
        let step = seconds(response.timeline.plant().model.properties.step_nanos);
        if response.impact.parameters.response_duration() / step > MAX_FORESEEN_STEPS {
            return None;
        }
        let is_unknown = |it: &Self| {
            let response = it.response.as_ref();
            response.is_some_and(|it| it.forecast.predicted().is_none() && it.forecast.is_running())
        };
        while is_unknown(self) {
            self.run_ahead(FORESEEING_SLICE, now, out);
        }
        let predicted = self.response.as_ref()?.forecast.predicted()?;
        Some(&predicted.at_rest)
    }

    /// The column at rest with other parameters.
    fn column_with(&self, wanted: &Parameters) -> Result<Plant, Rejection> {
        let from = self.parameters.current().column_properties();
        let column = self
            .at_rest
            .with_properties(&from, &wanted.column_properties())?;
        let is_damaged = self.at_rest.is_damaged() || !self.registry.life.beam.is_undamaged();
        check_shape(is_damaged, self.shapes(wanted))?;
        Ok(column)
    }

    /// The shape of the section so far, and the one that is wanted.
    fn shapes(&self, wanted: &Parameters) -> [SectionShape; 2] {
        let current: &Parameters = self.parameters.current();
        [current, wanted].map(|it| it.settings().section.shape)
    }

    /// Replaces the column at rest. The last response can be resumed only if it was that of the same column.
    fn replace_column(&mut self, column: Plant) {
        if column.model != self.at_rest.model {
            self.forbid_resuming();
        }
        self.at_rest = column;
    }

    pub(super) fn forbid_resuming(&mut self) {
        if let Some(last) = &mut self.last {
            last.before = None;
        }
    }

    pub(super) fn apply_waiting_parameters(&mut self, now: Nanos, out: &mut impl Outputs) {
        let Some((waiting, names)) = self.parameters.take_waiting() else {
            return;
        };
        let change = match self.column_with(&waiting.parameters) {
            Ok(column) => {
                self.replace_column(column);
                self.parameters.replace(waiting.parameters);
                Accepted::Applied
            }
            Err(Rejection { code, reason }) => {
                let reason =
                    format!("the change that waited for the end of the response: {reason}");
                self.reject_change(Rejection::new(code, reason), &waiting.source, now, out);
                Accepted::Unchanged
            }
        };
        self.status.set_changed();
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names,
            change,
            waiting: Vec::new(),
            parameters: Arc::clone(self.parameters.current()),
            source: waiting.source,
        }));
    }

    pub(super) fn reject_change(
        &mut self,
        rejection: Rejection,
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Rejection {
        self.status.set_changed();
        let rejected = self.registry.reject_change(rejection.clone(), source, now);
        out.put(Output::Rejected(rejected));
        rejection
    }

    pub(super) fn reset(&mut self, source: &str, now: Nanos, out: &mut impl Outputs) {
        if let Some(response) = self.response.take() {
            let text = format!(
                "a reset ends the response to impact \"{}\"",
                response.impact.event_id
            );
            out.notice(NoticeLevel::Warning, now, text.clone());
            self.solver.newton_iterations += response.newton_iterations();
            self.end_early(response, ForecastEnd::Reset, text);
        }
        // A reset does not wait for forecasts.
        self.superseded.abandon();
        for impact in self.registry.pending() {
            let reason = "a reset has dropped the impact before it was due";
            self.superseded
                .take_none(impact.into(), ForecastEnd::Reset, reason);
        }
        self.forbid_resuming();
        if let Some(forgotten) = self.registry.pending_in_words() {
            let text = format!("the reset drops {forgotten}");
            out.notice(NoticeLevel::Warning, now, text);
        }
        self.registry.reset();
        self.estimates.reset(now);
        // The parameters were checked when they came; if they failed now, the old model would still be a column.
        let properties = self.parameters.current().column_properties();
        self.at_rest = Plant::undamaged(&properties)
            .unwrap_or_else(|_| Plant::undamaged_of(self.at_rest.model));
        self.apply_waiting_parameters(now, out);
        self.assess();
        self.forget_other_critical_velocities();
        self.forget_range();
        let text = format!("reset by {source}: the column is undamaged");
        out.notice(NoticeLevel::Info, now, text);
        self.status.set_changed();
        self.journal.set_checkpoint_due();
        self.save(now, out);
    }
}
