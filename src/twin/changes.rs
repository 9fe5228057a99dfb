//! Parameters and reset.

use std::sync::Arc;

use super::input::Nanos;
use super::output::{Output, Outputs, ParametersChanged, RefusedInput, Severity};
use super::parameter_change::{self, AtRest, Change, Waiting};
use super::present::Condition;
use super::{Last, Life, Twin, saved_state};
use crate::column::{Model, State};
use crate::parameters::{Parameters, Value};

impl Twin {
    pub(super) fn take_parameters(
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
    pub(super) fn column_with(&self, wanted: &Parameters) -> Result<AtRest, String> {
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
    pub(super) fn apply(
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
            self.take_column(column);
        }
        Ok(())
    }

    /// The column at rest is this one from now on. The last response can be taken up again only if it is that of the
    /// same column.
    fn take_column(&mut self, column: AtRest) {
        if column.model != self.at_rest.model {
            self.forbid_resuming();
        }
        self.at_rest = column;
    }

    pub(super) fn forbid_resuming(&mut self) {
        if let Some(last) = &mut self.last {
            last.resumable = None;
        }
    }

    pub(super) fn apply_waiting_parameters(&mut self, now: Nanos, out: &mut impl Outputs) {
        let Some(Waiting { parameters, source }) = self.waiting_parameters.take() else {
            return;
        };
        let names = parameters.changed_from(&self.parameters);
        match self.column_with(&parameters) {
            Ok(column) => {
                self.take_column(column);
                self.fingerprint = saved_state::fingerprint(&parameters).into();
                self.parameters = parameters;
            }
            Err(reason) => {
                let reason =
                    format!("the change that waited for the end of the response: {reason}");
                self.refuse_change(reason, &source, now, out);
            }
        }
        // Refused, they go back to what they were: their change was told already.
        self.reported.due = true;
        out.put(Output::ParametersChanged(ParametersChanged {
            stamp: now,
            names: names.iter().map(|parameter| parameter.name).collect(),
            change: Change::Applied,
            parameters: Arc::clone(&self.parameters),
            source,
        }));
    }

    pub(super) fn refuse_change(
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

    pub(super) fn reset(&mut self, source: &str, now: Nanos, out: &mut impl Outputs) {
        if let Some(run) = self.run.take() {
            let text = format!(
                "the response to impact \"{}\" is broken off by a reset",
                run.event_id
            );
            self.notice(Severity::Warning, text, now, out);
            self.corrections += run.state.newton_iterations;
            self.last = Some(Last {
                run,
                resumable: None,
            });
        }
        self.forbid_resuming();
        self.ahead = None;
        if let Some(forgotten) = self.named_impacts_ahead() {
            let text = format!("forgotten with a reset: {forgotten}");
            self.notice(Severity::Warning, text, now, out);
        }
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
        self.journal.due = true;
        self.save(now, out);
    }
}
