//! What `/diagnostics` has of a fleet besides the health of the node: a summary, its topics, and the columns that need somebody.

use std::cmp::Reverse;
use std::sync::atomic::Ordering;

use crate::fleet::MAX_OPEN_COLUMNS;
use crate::messages::column_twin_msgs::ColumnStatus;
use crate::messages::diagnostic_msgs::DiagnosticStatus;
use crate::messages::words::verdict_in_words;
use crate::ros::diagnostics::{action_level, entry, phase_name};

use super::column_topics::TopicCounts;

/// Most columns that have a status of their own: the worst.
const MAX_SHOWN: usize = 20;

/// The columns of which something is wrong, with the levels of their statuses, the worst first.
fn worst(columns: &[ColumnStatus]) -> Vec<(u8, &ColumnStatus)> {
    let mut worst: Vec<_> = columns
        .iter()
        .map(|it| (level(it), it))
        .filter(|(level, _)| *level > DiagnosticStatus::OK)
        .collect();
    worst.sort_by_key(|(level, it)| Reverse((*level, it.is_out_of_service(), it.action)));
    worst
}

/// The statuses of the worst columns.
pub(super) fn column_statuses(columns: &[ColumnStatus]) -> Vec<DiagnosticStatus> {
    let worst = worst(columns);
    let shown = worst.iter().take(MAX_SHOWN);
    shown
        .map(|(level, column)| column_status(*level, column))
        .collect()
}

/// WARN if somebody listens to a column in its namespace and gets nothing.
pub(super) fn topics_status(topics: &TopicCounts) -> DiagnosticStatus {
    let open = topics.open.load(Ordering::Relaxed);
    let waiting = topics.waiting.load(Ordering::Relaxed);
    let failures = topics.failures.load(Ordering::Relaxed);
    let (level, message) = match (waiting, failures) {
        (0, 0) => (
            DiagnosticStatus::OK,
            "every reader in the namespace of a column is served",
        ),
        (0, _) => (
            DiagnosticStatus::WARN,
            "topics of columns could not be created; the first error is in the log",
        ),
        _ => (
            DiagnosticStatus::WARN,
            "readers in the namespaces of columns wait for others to leave; the shared topics have all columns",
        ),
    };
    let values = [
        ("columns with topics of their own", open.to_string()),
        ("columns whose readers wait", waiting.to_string()),
        ("at most", MAX_OPEN_COLUMNS.to_string()),
        ("failures", failures.to_string()),
    ];
    let values = values.map(|(key, value)| (key.to_owned(), value));
    entry("column topics", level, message.to_owned(), values)
}

/// ERROR if the column is out of service, otherwise the level of its action.
fn level(column: &ColumnStatus) -> u8 {
    match column.is_out_of_service() {
        true => DiagnosticStatus::ERROR,
        false => action_level(column.action),
    }
}

/// What the status of a fleet is made of.
pub(super) struct Summary<'a> {
    pub columns: &'a [ColumnStatus],
    /// Columns that respond or have something to do soon.
    pub active: usize,
    /// Columns at rest whose critical velocities are not computed yet.
    pub uncomputed: usize,
    /// Solver threads.
    pub threads: usize,
    /// Messages for columns that are elsewhere.
    pub ignored: u64,
}

/// The status of the fleet.
pub(super) fn summary(summary: &Summary<'_>) -> DiagnosticStatus {
    let Summary {
        columns,
        active,
        uncomputed,
        threads,
        ignored,
    } = *summary;
    let worst = worst(columns);
    let errors = worst
        .iter()
        .filter(|(level, _)| *level == DiagnosticStatus::ERROR)
        .count();
    let warnings = worst.len() - errors;
    let (level, message) = match (errors, warnings) {
        (0, 0) => (
            DiagnosticStatus::OK,
            format!("{} columns, none needs an action", columns.len()),
        ),
        (0, _) => (
            DiagnosticStatus::WARN,
            format!("{warnings} of {} columns must be inspected", columns.len()),
        ),
        _ => (
            DiagnosticStatus::ERROR,
            format!(
                "{errors} of {} columns are out of service or in danger, {warnings} more must be inspected",
                columns.len()
            ),
        ),
    };
    let values = [
        ("columns", columns.len()),
        ("columns that respond or are computed", active),
        ("columns with an error", errors),
        ("columns with a warning", warnings),
        (
            "columns that are not listed",
            worst.len().saturating_sub(MAX_SHOWN),
        ),
        (
            "columns whose critical velocities are not computed yet",
            uncomputed,
        ),
        ("solver threads", threads),
    ];
    let mut values: Vec<_> = values
        .map(|(key, count)| (key.to_owned(), count.to_string()))
        .to_vec();
    values.push(("messages for other columns".to_owned(), ignored.to_string()));
    entry("fleet", level, message, values)
}

fn column_status(level: u8, column: &ColumnStatus) -> DiagnosticStatus {
    let message = match column.fault.is_empty() {
        true => verdict_in_words(column.action, &column.action_reason),
        false => format!("faulted: {}", column.fault),
    };
    let values = [
        ("phase", phase_name(column.phase).to_owned()),
        ("event_id", column.event_id.clone()),
        (
            "impacts since reset",
            column.impacts_since_reset.to_string(),
        ),
        ("residual v1 [m]", column.residual_v1.to_string()),
        ("deciding criterion", column.deciding_criterion.clone()),
        (
            "residual capacity [N]",
            column.residual_capacity.to_string(),
        ),
        ("reserve", column.reserve.to_string()),
    ];
    let values = values.map(|(key, value)| (key.to_owned(), value));
    let mut status = entry(&column.column_id, level, message, values);
    status.hardware_id.clone_from(&column.column_id);
    status
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::column_twin_msgs::TwinStatus;

    #[test]
    fn the_worst_twenty_columns_are_listed_and_the_rest_counted() {
        let column = |number: u32, phase, action| ColumnStatus {
            column_id: format!("c{number}"),
            phase,
            action,
            ..ColumnStatus::default()
        };
        let mut columns: Vec<_> = (0..100)
            .map(|it| column(it, TwinStatus::IDLE, u8::from(it >= 50)))
            .collect();
        assert!(column_statuses(&columns[..50]).is_empty());
        columns[3] = column(3, TwinStatus::COLLAPSED, TwinStatus::ACTION_EVACUATE);
        let shown = column_statuses(&columns);
        assert_eq!(shown.len(), MAX_SHOWN);
        assert_eq!(shown[0].name, "c3");
        let status = summary(&Summary {
            columns: &columns,
            active: 0,
            uncomputed: 0,
            threads: 1,
            ignored: 0,
        });
        assert_eq!(status.level, DiagnosticStatus::ERROR);
        let value = |key: &str| {
            let found = status.values.iter().find(|it| it.key == key);
            found.map(|it| &*it.value)
        };
        assert_eq!(value("columns that are not listed"), Some("31"));
        assert_eq!(value("columns with a warning"), Some("50"));
    }
}
