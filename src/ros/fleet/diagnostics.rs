//! `/diagnostics` of a fleet: a summary, the columns that need somebody, and the health of the node.

use std::sync::atomic::Ordering;

use crate::fleet::MAX_OPEN_COLUMNS;
use crate::messages::column_twin_msgs::{ColumnStatus, TwinStatus};
use crate::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use crate::messages::std_msgs::Header;
use crate::outgoing::RecordingHealth;

use super::super::diagnostics::{
    NodeCounters, clock_status, entry, node_status, phase_name, queue_status, recording_status,
    security_status, senders_status, solver_status,
};
use super::super::lines::severity_word;
use super::super::live_twin::Health;
use super::super::security::SecurityHealth;
use super::column_topics::TopicCounts;
use super::sensors::FleetSensors;
use crate::live::SensingStatistics;

/// Most columns that have a status of their own: the worst.
const MAX_SHOWN: usize = 20;

/// What the statuses of a fleet are made of.
pub(super) struct FleetObserved<'a> {
    pub columns: &'a [ColumnStatus],
    /// Columns that respond or have something to do soon.
    pub active: usize,
    /// Columns at rest whose critical velocities are not computed yet.
    pub uncomputed: usize,
    /// Solver threads.
    pub threads: usize,
    pub health: &'a Health,
    /// `None` without a recording.
    pub recording: Option<&'a RecordingHealth>,
    /// `None` if security is off.
    pub security: Option<SecurityHealth>,
    /// `None` without sensors.
    pub sensors: Option<&'a FleetSensors>,
    pub sensing: Option<SensingStatistics>,
    pub counters: &'a NodeCounters,
    pub topics: &'a TopicCounts,
}

/// All statuses of the node of a fleet.
pub(super) fn fleet_diagnostics(
    header: Header,
    node: &str,
    observed: FleetObserved<'_>,
) -> DiagnosticArray {
    let FleetObserved {
        columns,
        active,
        uncomputed,
        threads,
        health,
        recording,
        security,
        sensors,
        sensing,
        counters,
        topics,
    } = observed;
    let mut worst: Vec<_> = columns
        .iter()
        .map(|it| (level(it), it))
        .filter(|(level, _)| *level > DiagnosticStatus::OK)
        .collect();
    worst.sort_by_key(|(level, it)| {
        std::cmp::Reverse((*level, it.is_out_of_service(), it.severity))
    });
    let mut status = vec![
        summary(columns, &worst, active, uncomputed, threads, counters),
        solver_status(health),
        queue_status(&health.queues),
        node_status(counters),
        topics_status(topics),
    ];
    status.extend(recording.map(recording_status));
    status.extend(security.map(security_status));
    status.extend(counters.senders.as_deref().map(senders_status));
    status.extend(counters.clock.as_ref().map(clock_status));
    status.extend(sensors.map(|it| it.status(sensing.unwrap_or_default())));
    for one in &mut status {
        node.clone_into(&mut one.hardware_id);
    }
    let shown = worst.iter().take(MAX_SHOWN);
    status.extend(shown.map(|(level, column)| column_status(*level, column)));
    status.extend(sensors.into_iter().flat_map(FleetSensors::worst));
    for one in &mut status {
        one.name = format!("{node}: {}", one.name);
    }
    DiagnosticArray { header, status }
}

/// WARN if somebody listens to a column in its namespace and gets nothing.
fn topics_status(topics: &TopicCounts) -> DiagnosticStatus {
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

/// ERROR if the column is out of service, has to be propped or evacuated, or could not be assessed; WARN to inspect or restrict.
fn level(column: &ColumnStatus) -> u8 {
    match column.severity {
        _ if column.is_out_of_service() => DiagnosticStatus::ERROR,
        TwinStatus::SEVERITY_NONE => DiagnosticStatus::OK,
        TwinStatus::SEVERITY_INSPECT | TwinStatus::SEVERITY_RESTRICT => DiagnosticStatus::WARN,
        _ => DiagnosticStatus::ERROR,
    }
}

fn summary(
    columns: &[ColumnStatus],
    worst: &[(u8, &ColumnStatus)],
    active: usize,
    uncomputed: usize,
    threads: usize,
    counters: &NodeCounters,
) -> DiagnosticStatus {
    let errors = worst
        .iter()
        .filter(|(level, _)| *level == DiagnosticStatus::ERROR)
        .count();
    let warnings = worst.len() - errors;
    let (level, message) = match (errors, warnings) {
        (0, 0) => (
            DiagnosticStatus::OK,
            format!(
                "{} columns, none damaged so that something has to be done",
                columns.len()
            ),
        ),
        (0, _) => (
            DiagnosticStatus::WARN,
            format!(
                "{warnings} of {} columns have to be inspected",
                columns.len()
            ),
        ),
        _ => (
            DiagnosticStatus::ERROR,
            format!(
                "{errors} of {} columns are out of service or in danger, {warnings} more have to be inspected",
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
    let ignored = counters.ignored.load(Ordering::Relaxed);
    values.push(("messages for other columns".to_owned(), ignored.to_string()));
    entry("fleet", level, message, values)
}

fn column_status(level: u8, column: &ColumnStatus) -> DiagnosticStatus {
    let severity = severity_word(column.severity);
    let message = match column.fault.is_empty() {
        true => format!("severity {severity}: {}", column.severity_reason),
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

    fn diagnostics(columns: &[ColumnStatus]) -> DiagnosticArray {
        let observed = FleetObserved {
            columns,
            active: 0,
            uncomputed: 0,
            threads: 1,
            health: &Health::default(),
            recording: None,
            security: None,
            sensors: None,
            sensing: None,
            counters: &NodeCounters::default(),
            topics: &TopicCounts::default(),
        };
        fleet_diagnostics(Header::default(), "fleet", observed)
    }

    #[test]
    fn the_worst_twenty_columns_are_listed_and_the_rest_counted() {
        let column = |number: u32, phase, severity| ColumnStatus {
            column_id: format!("c{number}"),
            phase,
            severity,
            ..ColumnStatus::default()
        };
        let mut columns: Vec<_> = (0..100)
            .map(|it| column(it, TwinStatus::IDLE, u8::from(it >= 50)))
            .collect();
        let others = diagnostics(&columns[..50]).status.len();
        columns[3] = column(3, TwinStatus::COLLAPSED, TwinStatus::SEVERITY_EVACUATE);
        let array = diagnostics(&columns);
        assert_eq!(array.status.len(), others + MAX_SHOWN);
        assert_eq!(array.status[others].name, "fleet: c3");
        assert_eq!(array.status[0].level, DiagnosticStatus::ERROR);
        let values = &array.status[0].values;
        let value = |key: &str| values.iter().find(|it| it.key == key).map(|it| &*it.value);
        assert_eq!(value("columns that are not listed"), Some("31"));
        assert_eq!(value("columns with a warning"), Some("50"));
    }
}
