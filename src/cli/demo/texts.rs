//! Bounds and texts that both demonstrations use.

use std::time::Duration;

use crate::cli::summary::wrapped;
use column_twin::messages::column_twin::ImpactReport;
use column_twin::ros::severity_word;

/// Maximum wait for the node, and for each of its answers.
pub(super) const TIMEOUT: Duration = Duration::from_secs(15);

/// What becomes of the column, in words.
pub(super) fn outcome_text(report: &ImpactReport) -> &'static str {
    match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        ImpactReport::SEVERED => "a hinge or a web is fractured",
        _ => "the column collapses",
    }
}

/// The severity with its reason, in lines that fit into a terminal.
pub(super) fn severity_text(report: &ImpactReport) -> String {
    let severity = severity_word(report.severity);
    let words = format!("{severity}: {}", report.severity_reason);
    let mut text = String::new();
    let _ = wrapped(&mut text, "  severity", &words); // writing to a String cannot fail
    text
}
