//! What has to be done with a column, as its outputs say it: for alarms and metrics.

use crate::messages::words::not_assessed_in_words;
use crate::twin::{Assessed, Output, ReportOutput, Status, TwinPhase};

/// The rank of a column that cannot be assessed: that of the most severe action.
const NOT_ASSESSED: u8 = 4;

/// What has to be done with a column now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StandingAction {
    /// 0 for nothing, 1 to inspect, 2 to restrict, 3 to shore, 4 to evacuate or not assessed.
    pub rank: u8,
    /// The word for it.
    pub name: String,
    /// Why, in plain words.
    pub reason: String,
    /// The impact.
    pub event_id: String,
}

impl StandingAction {
    /// What an output says about it, if it does.
    pub fn of(output: &Output) -> Option<Self> {
        match output {
            // Another forecast follows.
            Output::Forecast(it) if it.is_superseded => None,
            Output::Forecast(it) => Some(Self::of_report("Forecast", it)),
            Output::Report(it) => Some(Self::of_report("Result", it)),
            Output::Status(status) => Self::of_status(status),
            _ => None,
        }
    }

    fn of_report(kind: &str, report: &ReportOutput) -> Self {
        let begin = format!("{kind} of impact {:?}", &*report.event_id);
        Self::judged(&begin, &report.event_id, report.assessed.as_deref())
    }

    /// During a response, the status shows the column as it was before, and the forecast counts.
    fn of_status(status: &Status) -> Option<Self> {
        let event_id = &status.event_id;
        match (status.phase, &status.assessed) {
            (TwinPhase::Approach | TwinPhase::Contact | TwinPhase::Free, _) => None,
            (TwinPhase::Faulted, _) => {
                let reason = format!("The twin cannot continue: {}", status.fault);
                Some(Self::not_assessed(reason, event_id))
            }
            (_, Some(assessed)) => {
                let begin = match (status.impacts_since_reset, status.corrections_since_reset) {
                    (0, 0) => "The column has no damage",
                    (_, 0) => "The column at rest",
                    _ => "The column at rest, with its measured damage",
                };
                Some(Self::judged(begin, event_id, Some(assessed)))
            }
            (TwinPhase::Collapsed | TwinPhase::Fractured, None) => {
                Some(Self::judged("The column at rest", event_id, None))
            }
            // Not yet assessed: nothing is known that could raise or clear an alarm.
            (TwinPhase::Idle | TwinPhase::Rest, None) => None,
        }
    }

    fn judged(begin: &str, event_id: &str, assessed: Option<&Assessed>) -> Self {
        match assessed {
            Some(Assessed { assessment, .. }) => Self {
                // In the order of the actions.
                rank: assessment.action as u8,
                name: assessment.action.to_string(),
                reason: format!("{begin}: {}", assessment.in_words()),
                event_id: event_id.to_owned(),
            },
            None => {
                let reason = format!("{begin}: {}", not_assessed_in_words());
                Self::not_assessed(reason, event_id)
            }
        }
    }

    fn not_assessed(reason: String, event_id: &str) -> Self {
        Self {
            rank: NOT_ASSESSED,
            name: "not assessed".to_owned(),
            reason,
            event_id: event_id.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::messages::column_twin_msgs::TwinStatus;

    /// The ranks of alarms and metrics are those that the messages have had all along.
    #[test]
    fn ranks_are_the_actions_of_the_messages() {
        let actions = [
            TwinStatus::ACTION_NONE,
            TwinStatus::ACTION_INSPECT,
            TwinStatus::ACTION_RESTRICT,
            TwinStatus::ACTION_SHORE,
            TwinStatus::ACTION_EVACUATE,
        ];
        assert_eq!(actions, [0, 1, 2, 3, super::NOT_ASSESSED]);
    }
}
