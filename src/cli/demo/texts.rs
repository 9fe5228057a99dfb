//! Bounds and texts that both demonstrations use.

use std::time::Duration;

use crate::cli::summary::wrapped;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::words::verdict_in_words;

/// Maximum wait for the node, and for each of its answers.
pub(super) const TIMEOUT: Duration = Duration::from_secs(15);

/// What becomes of the column, in words.
pub(super) fn outcome_text(report: &ImpactReport) -> &'static str {
    match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        ImpactReport::FRACTURED => "a hinge, a web or the base is fractured",
        _ => "the column collapses",
    }
}

/// The action with its reason, in lines that fit into a terminal.
pub(super) fn action_text(report: &ImpactReport) -> String {
    let words = verdict_in_words(report.action, &report.action_reason);
    let mut text = String::new();
    let _ = wrapped(&mut text, "  action", &words); // writing to a String cannot fail
    text
}
