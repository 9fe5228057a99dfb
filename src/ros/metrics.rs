//! The metrics of the node: what the publishing thread knows, as a page for Prometheus.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::estimation::{SensorCondition, SensorHealth};
use crate::outgoing::RecordingHealth;
use crate::twin::{Counts, Output, TwinPhase};

use super::counters::NodeCounters;
use super::exposition::{Histogram, Kind, Page};
use super::live_columns::Health;
use super::metrics_server::MetricsServer;
use super::node::NodeError;
use super::standing_action::StandingAction;

/// What one way of delivering alarms has done: its name, whether the last attempt succeeded, and counts by name.
#[cfg_attr(not(feature = "alarm"), allow(dead_code))] // without alarms there is none
pub(super) struct AlarmChannel {
    pub name: &'static str,
    pub works: bool,
    pub waiting: u64,
    pub counts: [(&'static str, u64); 4],
}

/// What the server for Foxglove has done.
#[cfg_attr(not(feature = "foxglove"), allow(dead_code))] // without it there is none
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FoxgloveCounts {
    /// Clients that are connected.
    pub clients: u64,
    /// Connections that were rejected.
    pub rejected: u64,
    /// Messages that clients lost.
    pub dropped: u64,
}

/// What is known besides the outputs of the columns.
pub(super) struct Known<'a> {
    pub health: &'a Health,
    pub counters: &'a NodeCounters,
    pub recording: Option<&'a RecordingHealth>,
    /// The sensors of each column, by its `column_id`.
    pub sensors: &'a [(String, Vec<SensorHealth>)],
    pub alarms: &'a [AlarmChannel],
    pub foxglove: Option<FoxgloveCounts>,
}

/// The metrics of a running node. The publishing thread owns them.
pub(super) struct NodeMetrics {
    server: MetricsServer,
    columns: BTreeMap<String, OfColumn>,
    /// From the stamp of an event to the publication of its first forecast.
    forecasts: Histogram,
}

/// Takes one of the counts of a column.
type CountOf = fn(&Counts) -> u64;

#[derive(Debug, Default)]
struct OfColumn {
    action: Option<u8>,
    residual: f64,
    is_faulted: bool,
    counts: Counts,
    /// The impact whose forecast was counted last; it is given out again when more is known.
    forecast: Option<Arc<str>>,
}

impl NodeMetrics {
    /// Starts the server; `None` if the address is empty.
    pub fn start(address: &str) -> Result<Option<Self>, NodeError> {
        let server = MetricsServer::start(address)?;
        Ok(server.map(|server| Self {
            server,
            columns: BTreeMap::new(),
            forecasts: Histogram::default(),
        }))
    }

    /// Takes what leaves a column at the time `now` \[ns\].
    pub fn note(&mut self, column_id: &str, output: &Output, now: i64) {
        if !matches!(
            output,
            Output::Forecast(_) | Output::Report(_) | Output::Status(_)
        ) {
            return;
        }
        if !self.columns.contains_key(column_id) {
            self.columns
                .insert(column_id.to_owned(), OfColumn::default());
        }
        let Some(column) = self.columns.get_mut(column_id) else {
            return;
        };
        if let Some(action) = StandingAction::of(output) {
            column.action = Some(action.rank);
        }
        match output {
            Output::Forecast(it) if column.forecast.as_ref() != Some(&it.event_id) => {
                column.forecast = Some(Arc::clone(&it.event_id));
                let late = now.saturating_sub(it.stamp).max(0);
                self.forecasts.observe(1e-9 * late as f64);
            }
            Output::Status(status) => {
                column.residual = status.residual_v1;
                column.is_faulted = status.phase == TwinPhase::Faulted;
                column.counts = status.counts;
            }
            _ => {}
        }
    }

    /// Shows the newest values.
    pub fn show(&self, known: &Known<'_>) {
        let mut page = Page::default();
        self.of_columns(&mut page);
        of_node(&mut page, known);
        if !known.sensors.is_empty() {
            of_sensors(&mut page, known.sensors);
        }
        if let Some(recording) = known.recording {
            of_recording(&mut page, recording);
        }
        if !known.alarms.is_empty() {
            of_alarms(&mut page, known.alarms);
        }
        if let Some(foxglove) = known.foxglove {
            of_foxglove(&mut page, foxglove);
        }
        self.server.show(page.into_text());
    }

    fn of_columns(&self, page: &mut Page) {
        let help =
            "Time from the stamp of an impact event to the publication of its first forecast.";
        page.histogram(
            "column_twin_forecast_latency_seconds",
            help,
            &self.forecasts,
        );
        let labels: Vec<[(&str, &str); 1]> = self
            .columns
            .keys()
            .map(|id| [("column", id.as_str())])
            .collect();
        let each = || {
            labels
                .iter()
                .map(|it| it.as_slice())
                .zip(self.columns.values())
        };
        page.metric(
            Kind::Gauge,
            "column_twin_action",
            "The required action: 0 none, 1 inspect, 2 restrict, 3 shore, 4 evacuate or not assessed.",
            each().filter_map(|(labels, it)| Some((labels, it.action?))),
        );
        page.metric(
            Kind::Gauge,
            "column_twin_residual_displacement_meters",
            "Residual displacement of the column at the height of the impact.",
            each().map(|(labels, it)| (labels, it.residual)),
        );
        page.metric(
            Kind::Gauge,
            "column_twin_faulted",
            "1 if the twin of the column cannot continue.",
            each().map(|(labels, it)| (labels, u8::from(it.is_faulted))),
        );
        let counters: [(&str, &str, CountOf); 3] = [
            (
                "column_twin_events_accepted_total",
                "Impacts that were accepted.",
                |it| it.events_accepted,
            ),
            (
                "column_twin_events_rejected_total",
                "Impact events that were rejected.",
                |it| it.events_rejected,
            ),
            (
                "column_twin_parameters_rejected_total",
                "Changes of parameters that were rejected.",
                |it| it.parameters_rejected,
            ),
        ];
        for (name, help, count) in counters {
            let values = each().map(|(labels, it)| (labels, count(&it.counts)));
            page.metric(Kind::Counter, name, help, values);
        }
    }
}

fn of_node(page: &mut Page, known: &Known<'_>) {
    let Known {
        health, counters, ..
    } = known;
    let load = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
    page.single(
        Kind::Gauge,
        "column_twin_worst_lateness_seconds",
        "Longest delay of the solver after its deadline since the start.",
        health.worst_lateness,
    );
    page.single(
        Kind::Counter,
        "column_twin_overruns_total",
        "Periods that the solver skipped because it was late.",
        health.overruns,
    );
    let lost = [
        ("inputs", health.dropped_inputs),
        ("states", health.dropped_states),
        ("viewer", health.dropped_viewer),
        ("state_files", health.unsaved_states),
        ("unreadable", load(&counters.unreadable)),
        ("missed", load(&counters.missed)),
        ("too_long", counters.given_up.count()),
        ("unpublished", load(&counters.unpublished)),
        ("unlogged", load(&counters.unlogged)),
        ("senders", counters.rejected_senders()),
    ];
    let lost = lost.map(|(what, count)| ([("what", what)], count));
    page.metric(
        Kind::Counter,
        "column_twin_lost_total",
        "What was lost or not taken, by kind.",
        lost.iter()
            .map(|(labels, count)| (labels.as_slice(), *count)),
    );
    let queues: Vec<_> = health
        .queues
        .iter()
        .map(|it| ([("queue", it.name.as_str())], it.len, it.dropped))
        .collect();
    page.metric(
        Kind::Gauge,
        "column_twin_queue_length",
        "Entries in a queue.",
        queues
            .iter()
            .map(|(labels, len, _)| (labels.as_slice(), *len)),
    );
    page.metric(
        Kind::Counter,
        "column_twin_queue_dropped_total",
        "Entries that a queue dropped or rejected.",
        queues
            .iter()
            .map(|(labels, _, dropped)| (labels.as_slice(), *dropped)),
    );
    page.single(
        Kind::Gauge,
        "column_twin_panicked",
        "1 if a thread of the twin panicked.",
        u8::from(health.has_panicked),
    );
}

fn of_sensors(page: &mut Page, sensors: &[(String, Vec<SensorHealth>)]) {
    let each: Vec<_> = sensors
        .iter()
        .flat_map(|(column, sensors)| {
            let labels = move |it: &'_ SensorHealth| {
                [("column", column.clone()), ("sensor", it.name.to_string())]
            };
            sensors
                .iter()
                .map(move |it| (labels(it), u8::from(it.condition == SensorCondition::Alive)))
        })
        .collect();
    let labels: Vec<[(&str, &str); 2]> = each
        .iter()
        .map(|([column, sensor], _)| [(column.0, column.1.as_str()), (sensor.0, sensor.1.as_str())])
        .collect();
    page.metric(
        Kind::Gauge,
        "column_twin_sensor_alive",
        "1 if the sensor sends readings; 0 if it waits, is stuck or is dead.",
        labels
            .iter()
            .zip(&each)
            .map(|(labels, (_, alive))| (labels.as_slice(), *alive)),
    );
}

fn of_recording(page: &mut Page, recording: &RecordingHealth) {
    page.single(
        Kind::Gauge,
        "column_twin_recording_works",
        "1 while the recorder can write.",
        u8::from(recording.problem.is_none()),
    );
    page.single(
        Kind::Counter,
        "column_twin_recording_lost_total",
        "Messages that are missing in the recording.",
        recording.lost,
    );
}

fn of_alarms(page: &mut Page, channels: &[AlarmChannel]) {
    let labels: Vec<_> = channels.iter().map(|it| [("channel", it.name)]).collect();
    let each = || labels.iter().map(|it| it.as_slice()).zip(channels);
    page.metric(
        Kind::Gauge,
        "column_twin_alarm_delivery_works",
        "0 if the last attempt to deliver an alarm failed.",
        each().map(|(labels, it)| (labels, u8::from(it.works))),
    );
    page.metric(
        Kind::Gauge,
        "column_twin_alarm_messages_waiting",
        "Messages in the spool.",
        each().map(|(labels, it)| (labels, it.waiting)),
    );
    let labels: Vec<_> = channels
        .iter()
        .flat_map(|it| {
            let name = it.name;
            it.counts
                .map(move |(what, count)| ([("channel", name), ("outcome", what)], count))
        })
        .collect();
    page.metric(
        Kind::Counter,
        "column_twin_alarm_messages_total",
        "What became of the messages of alarms.",
        labels
            .iter()
            .map(|(labels, count)| (labels.as_slice(), *count)),
    );
}

fn of_foxglove(page: &mut Page, counts: FoxgloveCounts) {
    page.single(
        Kind::Gauge,
        "column_twin_foxglove_clients",
        "Clients of Foxglove that are connected.",
        counts.clients,
    );
    page.single(
        Kind::Counter,
        "column_twin_foxglove_rejected_total",
        "Connections of clients of Foxglove that were rejected.",
        counts.rejected,
    );
    page.single(
        Kind::Counter,
        "column_twin_foxglove_dropped_total",
        "Messages that clients of Foxglove lost because they read too slowly.",
        counts.dropped,
    );
}
