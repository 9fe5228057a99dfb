//! An impact whose response has begun, and the report about it.

use std::sync::Arc;

use super::assessed::{Assessed, LastImpact};
use super::opinion_state::OpinionState;
use super::output::ReportOutput;
use super::striking::Striking;
use crate::assessment::BaseDemand;
use crate::column::Report;
use crate::parameters::Parameters;
use crate::time::Nanos;
use crate::time::seconds;

/// An impact whose response has begun.
#[derive(Debug, Clone)]
pub(super) struct BegunImpact {
    /// Of the event: the instant of step 0.
    pub stamp: Nanos,
    pub event_id: Arc<str>,
    pub striking: Striking,
    /// Those that held when it began, so that forecast and result are assessed alike.
    pub parameters: Arc<Parameters>,
    pub step_nanos: u64,
    /// What earlier impacts have put into the base.
    pub base_before: Option<BaseDemand>,
    /// Where the second opinion on it stands.
    pub opinion: OpinionState,
}

impl BegunImpact {
    /// The impact once its response has ended with this report.
    pub fn last_impact(&self, report: &Report, error_estimate: Option<f64>) -> LastImpact {
        let base_before = self.base_before.as_ref();
        LastImpact::new(&self.striking, report, error_estimate, base_before)
    }

    pub fn report_output(
        &self,
        report: Report,
        assessed: Option<Arc<Assessed>>,
        error_estimate: Option<f64>,
        compute_nanos: u64,
    ) -> ReportOutput {
        ReportOutput {
            stamp: self.stamp,
            event_id: Arc::clone(&self.event_id),
            striking: self.striking.clone(),
            report,
            assessed,
            error_estimate,
            step_nanos: self.step_nanos,
            compute_time: seconds(compute_nanos),
            is_superseded: false,
            range: None,
            opinion: self.opinion.clone(),
        }
    }
}
