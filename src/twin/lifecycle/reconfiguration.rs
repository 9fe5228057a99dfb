//! What changes the column other than an impact: other parameters, a correction of its damage, and the reset.

use std::sync::Arc;

use super::Twin;
use crate::parameters::{Parameters, Value};
use crate::time::Nanos;
use crate::time::seconds;
use crate::twin::command::Accepted;
use crate::twin::course::ActiveResponse;
use crate::twin::damage_correction::ResidualMeasurement;
use crate::twin::output::{ForecastEnd, NoticeLevel, Output, Outputs, ParametersChanged};
use crate::twin::plant::Plant;
use crate::twin::registry::RejectedInput;
use crate::twin::rejection::{Rejection, RejectionCode};

/// Maximum length of a response \[steps\] whose end is computed in order to judge a change that waits for it: at most about a
/// second, which the sender of the change has to wait.
const MAX_FORESEEN_STEPS: f64 = 1e6;

/// Steps in which the end of a response is computed.
const FORESEEING_SLICE: u64 = 1024;

impl Twin {
    pub(super) fn set_parameters(
        &mut self,
        changes: &[(String, Value)],
        source: &Arc<str>,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        let planned = self.column.parameter_set().plan(changes)?;
        if planned.names.is_empty() {
            self.registry.accept_change();
            return Ok(Accepted::Unchanged);
        }
        let plant = self.column.with_parameters(&planned.parameters)?;
        let change = if self.is_responding() && planned.must_wait {
            self.check_at_end(&planned.parameters, now, out)?;
            let parameters = self.column.parameter_set_mut();
            parameters.make_wait(&planned.parameters, source);
            Accepted::Waiting
        } else {
            let parameters = self.column.parameter_set_mut();
            parameters.apply(&planned.parameters, changes)?;
            if !self.is_responding() {
                self.replace_column(plant);
                self.column.assess_anew();
            }
            Accepted::Applied
        };
        self.registry.accept_change();
        self.status.set_changed();
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names: planned.names,
            change,
            waiting: self.column.parameter_set().waiting_names(),
            parameters: Arc::clone(self.parameters()),
            source: Arc::clone(source),
        }));
        if change == Accepted::Applied && !self.is_responding() {
            self.save(now, out);
        }
        Ok(change)
    }

    /// Rejects a change at once that the column would not take when the response under way has ended, because of the damage
    /// that it leaves. The forecast is completed for this, so that the answer does not depend on how far it had come. Nothing is
    /// rejected during a response that may be too long, or cannot be computed.
    fn check_at_end(
        &mut self,
        wanted: &Parameters,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<(), Rejection> {
        let Some(response) = self.course.present() else {
            return Ok(());
        };
        let step = seconds(response.plant().model.properties.step_nanos);
        if response.impact().parameters.response_duration() / step > MAX_FORESEEN_STEPS {
            return Ok(());
        }
        let is_unknown =
            |it: &ActiveResponse| it.forecast().predicted().is_none() && it.forecast().is_running();
        while self.course.present().is_some_and(is_unknown) {
            self.run_ahead(FORESEEING_SLICE, now, out);
        }
        let present = self.course.present();
        let Some(predicted) = present.and_then(|it| it.forecast().predicted()) else {
            return Ok(());
        };
        self.column
            .check_change_of(&predicted.at_rest, wanted)
            .map_err(|Rejection { code, reason }| {
                let reason = format!(
                    "the change cannot take effect when the response to the impact ends: by then, {reason}"
                );
                Rejection::new(code, reason)
            })
    }

    /// Replaces the column at rest. The last response can be resumed only if it was that of the same column.
    fn replace_column(&mut self, plant: Plant) {
        if self.column.replace(plant) {
            self.course.forbid_resuming();
        }
    }

    pub(super) fn apply_waiting_parameters(&mut self, now: Nanos, out: &mut impl Outputs) {
        let Some((waiting, names)) = self.column.parameter_set_mut().take_waiting() else {
            return;
        };
        let change = match self.column.with_parameters(&waiting.parameters) {
            Ok(plant) => {
                self.replace_column(plant);
                self.column.parameter_set_mut().replace(waiting.parameters);
                Accepted::Applied
            }
            Err(Rejection { code, reason }) => {
                let reason =
                    format!("the change that waited for the end of the response: {reason}");
                let rejection = Rejection::new(code, reason);
                self.reject_request(
                    RejectedInput::Parameters,
                    rejection,
                    &waiting.source,
                    now,
                    out,
                );
                Accepted::Unchanged
            }
        };
        self.status.set_changed();
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names,
            change,
            waiting: Vec::new(),
            parameters: Arc::clone(self.parameters()),
            source: waiting.source,
        }));
    }

    /// Corrects the damage by a measurement. Where the model agrees with it within its standard deviation, nothing changes.
    ///
    /// # Errors
    /// The column is not at rest or does not stand, or the measurement does not fit to its damage.
    pub(super) fn correct_damage(
        &mut self,
        measured: &ResidualMeasurement,
        now: Nanos,
        out: &mut impl Outputs,
    ) -> Result<Accepted, Rejection> {
        if self.is_responding() {
            let reason = "the column is responding to an impact; measure when it is at rest";
            return Err(Rejection::new(RejectionCode::NotAtRest, reason));
        }
        let (correction, is_changed) = self.column.correct(measured, now)?;
        if is_changed {
            self.course.forbid_resuming();
        }
        let text = format!("by {}: {}", measured.source, correction.in_words());
        out.notice(NoticeLevel::Warning, now, text);
        out.put(Output::DamageCorrected(correction));
        self.note_change_at_rest();
        self.save(now, out);
        Ok(Accepted::DamageCorrected(correction))
    }

    pub(super) fn reset(&mut self, source: &str, now: Nanos, out: &mut impl Outputs) {
        if let Some(response) = self.course.present() {
            let text = format!(
                "a reset ends the response to impact \"{}\"",
                response.impact().event_id
            );
            out.notice(NoticeLevel::Warning, now, text.clone());
            self.course.end_early(ForecastEnd::Reset, text);
        }
        // A reset does not wait for forecasts.
        let reason = "a reset has dropped the impact before it was due";
        let pending = self.registry.pending();
        self.course
            .give_up_forecasts(pending, ForecastEnd::Reset, reason);
        self.course.forbid_resuming();
        if let Some(forgotten) = self.registry.pending_in_words() {
            let text = format!("the reset drops {forgotten}");
            out.notice(NoticeLevel::Warning, now, text);
        }
        self.registry.reset();
        self.estimates.reset(now);
        self.column.reset();
        self.apply_waiting_parameters(now, out);
        self.column.assess_anew();
        let text = format!("reset by {source}: the column is undamaged");
        out.notice(NoticeLevel::Info, now, text);
        self.note_change_at_rest();
        self.save(now, out);
    }
}
