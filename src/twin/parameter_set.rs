//! The parameters that hold, and the ones that wait for the end of a response.

use std::sync::Arc;

use super::rejection::{Rejection, RejectionCode};
use super::saved_state::fingerprint;
use crate::parameters::{Applies, DeclaredParameter, Parameters, Value};

#[derive(Debug)]
pub(super) struct ParameterSet {
    current: Arc<Parameters>,
    /// Digest of the column's make, as the state file has it.
    fingerprint: Arc<str>,
    waiting: Option<Waiting>,
}

/// A valid change that waits for the end of the response.
#[derive(Debug)]
pub(super) struct Waiting {
    pub parameters: Arc<Parameters>,
    /// The last sender.
    pub source: Arc<str>,
}

/// A valid change that has not been made yet.
#[derive(Debug)]
pub(super) struct PlannedChange {
    pub parameters: Arc<Parameters>,
    /// Names of the parameters that have new values.
    pub names: Vec<String>,
    /// Whether any of them applies only when the response has ended.
    pub must_wait: bool,
}

impl ParameterSet {
    pub fn new(parameters: Arc<Parameters>) -> Self {
        Self {
            fingerprint: fingerprint(&parameters).into(),
            current: parameters,
            waiting: None,
        }
    }

    /// Shares the digest of another column, if it is equal.
    pub fn share_fingerprint(&mut self, other: &Self) {
        if self.fingerprint == other.fingerprint {
            self.fingerprint = Arc::clone(&other.fingerprint);
        }
    }

    /// The parameters that hold.
    pub fn current(&self) -> &Arc<Parameters> {
        &self.current
    }

    /// Digest of the column's make.
    pub fn fingerprint(&self) -> &Arc<str> {
        &self.fingerprint
    }

    /// What the changes lead to, on top of what waits already.
    ///
    /// # Errors
    /// The changes are invalid, or for parameters that are read-only while the node runs.
    pub fn plan(&self, changes: &[(String, Value)]) -> Result<PlannedChange, Rejection> {
        let latest = self
            .waiting
            .as_ref()
            .map_or(&self.current, |waiting| &waiting.parameters);
        let parameters = changed(latest, changes)?;
        let changed = parameters.changed_from(latest);
        Ok(PlannedChange {
            names: names_of(&changed),
            must_wait: changed.iter().any(|it| it.row.applies != Applies::AtOnce),
            parameters: Arc::new(parameters),
        })
    }

    /// Makes a planned change wait for the end of the response.
    pub fn make_wait(&mut self, parameters: &Arc<Parameters>, source: &Arc<str>) {
        self.waiting = Some(Waiting {
            parameters: Arc::clone(parameters),
            source: Arc::clone(source),
        });
    }

    /// Applies a planned change. While others wait, it goes into both: the parameters that hold and those that wait.
    ///
    /// # Errors
    /// The changes contradict the parameters that hold.
    pub fn apply(
        &mut self,
        parameters: &Arc<Parameters>,
        changes: &[(String, Value)],
    ) -> Result<(), Rejection> {
        match &mut self.waiting {
            Some(waiting) => {
                let current = Arc::new(changed(&self.current, changes)?);
                waiting.parameters = Arc::clone(parameters);
                self.replace(current);
            }
            None => self.replace(Arc::clone(parameters)),
        }
        Ok(())
    }

    /// Names of the parameters that wait for the end of the response.
    pub fn waiting_names(&self) -> Vec<String> {
        self.waiting.as_ref().map_or_else(Vec::new, |waiting| {
            names_of(&waiting.parameters.changed_from(&self.current))
        })
    }

    /// The change that has waited for the end of the response, with the names of what it changes. It waits no longer.
    pub fn take_waiting(&mut self) -> Option<(Waiting, Vec<String>)> {
        let names = self.waiting_names();
        Some((self.waiting.take()?, names))
    }

    /// Lets other parameters hold.
    pub fn replace(&mut self, parameters: Arc<Parameters>) {
        self.fingerprint = fingerprint(&parameters).into();
        self.current = parameters;
    }
}

fn names_of(parameters: &[DeclaredParameter<'_>]) -> Vec<String> {
    let names = parameters.iter().map(|it| it.name.to_owned());
    names.collect()
}

/// `from` with some values changed, validated as a whole.
fn changed(from: &Parameters, changes: &[(String, Value)]) -> Result<Parameters, Rejection> {
    let changed = from
        .with_changes(changes.iter().cloned())
        .map_err(|faults| Rejection::new(RejectionCode::ParametersInvalid, faults.in_one_line()))?;
    let mut read_only = changed.changed_from(from);
    read_only.retain(|it| it.row.applies == Applies::Restart);
    if read_only.is_empty() {
        return Ok(changed);
    }
    // An added sensor also adds parameters with default values, which the sender did not set.
    read_only.retain(|it| changes.iter().any(|(name, _)| name == it.name));
    let reason = format!(
        "{} cannot be changed while the node runs; restart it with the new value",
        names_of(&read_only).join(", ")
    );
    Err(Rejection::new(RejectionCode::ParametersReadOnly, reason))
}
