//! `/diagnostics`: the twin, its solver, its queues, its recording, its sensors and the node, for people and aggregators.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::live::QueueStats;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use crate::messages::std_msgs::Header;
use crate::outgoing::RecordingHealth;

use super::counters::NodeCounters;
use super::lifecycle::Lifecycle;
use super::lines::action_word;
use super::live_columns::Health;
use super::metrics::FoxgloveCounts;
use super::security_health::SecurityHealth;
use super::senders::Senders;
use super::sensor_watch::SensorStatus;
use crate::messages::words::{range_in_words, verdict_in_words};
use ros_node::clock_watch::ClockWatch;

/// What the statuses of a node are made of.
pub(super) struct Observed<'a> {
    /// The twin or the fleet.
    pub first: DiagnosticStatus,
    /// What the node is about.
    pub hardware_id: &'a str,
    pub health: &'a Health,
    /// The topics of the single columns of a fleet.
    pub topics: Option<DiagnosticStatus>,
    /// `None` without a recording.
    pub recording: Option<&'a RecordingHealth>,
    /// `None` if security is off.
    pub security: Option<SecurityHealth>,
    /// `None` without alarms.
    #[cfg(feature = "alarm")]
    pub alarms: Option<DiagnosticStatus>,
    /// `None` without a server for Foxglove.
    pub foxglove: Option<FoxgloveCounts>,
    /// `None` without sensors.
    pub sensors: Option<DiagnosticStatus>,
    /// The columns of a fleet that need somebody.
    pub of_columns: Vec<DiagnosticStatus>,
    /// Whether a column responds to an impact.
    pub is_responding: bool,
    pub counters: &'a NodeCounters,
}

/// All statuses of a node.
pub(super) fn diagnostics(header: Header, node: &str, observed: Observed<'_>) -> DiagnosticArray {
    let Observed {
        first,
        hardware_id,
        health,
        topics,
        recording,
        security,
        #[cfg(feature = "alarm")]
        alarms,
        foxglove,
        sensors,
        of_columns,
        is_responding,
        counters,
    } = observed;
    let mut status = vec![
        first,
        solver_status(health),
        queue_status(&health.queues),
        node_status(counters),
    ];
    status.extend(topics);
    status.extend(recording.map(recording_status));
    status.extend(security.map(security_status));
    status.extend(counters.senders.as_deref().map(senders_status));
    status.extend(counters.lifecycle.as_deref().map(lifecycle_status));
    let clock = counters.clock.as_ref();
    status.extend(clock.map(|it| clock_status(it, is_responding)));
    #[cfg(feature = "alarm")]
    status.extend(alarms);
    status.extend(foxglove.map(foxglove_status));
    status.extend(sensors);
    for one in &mut status {
        hardware_id.clone_into(&mut one.hardware_id);
    }
    status.extend(of_columns);
    for one in &mut status {
        one.name = format!("{node}: {}", one.name);
    }
    DiagnosticArray { header, status }
}

/// Whether levels and messages are equal; a change in them, unlike one in the values, is published immediately.
pub(super) fn same_state(one: &DiagnosticArray, other: &DiagnosticArray) -> bool {
    let state = |array: &DiagnosticArray| -> Vec<(u8, String)> {
        let statuses = array.status.iter();
        statuses.map(|it| (it.level, it.message.clone())).collect()
    };
    state(one) == state(other)
}

/// The status of a single twin; `waiting` are the parameters that wait for the end of the response.
pub(super) fn twin_status(twin: &TwinStatus, waiting: &[String]) -> DiagnosticStatus {
    let (level, message) = match twin.phase {
        TwinStatus::FAULTED => (DiagnosticStatus::ERROR, format!("faulted: {}", twin.fault)),
        TwinStatus::COLLAPSED => (
            DiagnosticStatus::ERROR,
            "the column has collapsed; call ~/reset to start with a new one".to_owned(),
        ),
        TwinStatus::FRACTURED => (
            DiagnosticStatus::ERROR,
            "a hinge, a web or the base of the column is fractured; call ~/reset to start with a new one"
                .to_owned(),
        ),
        TwinStatus::IDLE | TwinStatus::REST => (DiagnosticStatus::OK, "at rest".to_owned()),
        _ => (DiagnosticStatus::OK, "response in progress".to_owned()),
    };
    let (level, message) = match action_level(twin.action) {
        DiagnosticStatus::OK => (level, message),
        of_action => {
            // First what to do.
            let verdict = verdict_in_words(twin.action, &twin.action_reason);
            let message = format!("{verdict} ({message})");
            (level.max(of_action), message)
        }
    };
    let values = [
        ("phase", phase_name(twin.phase).to_owned()),
        ("event_id", twin.event_id.clone()),
        ("events accepted", twin.events_accepted.to_string()),
        ("events merged", twin.events_merged.to_string()),
        ("events rejected", twin.events_rejected.to_string()),
        (
            "impact that waits for ~/confirm_estimate",
            twin.waiting_estimate.clone(),
        ),
        (
            "parameter changes accepted",
            twin.parameters_accepted.to_string(),
        ),
        (
            "parameter changes rejected",
            twin.parameters_rejected.to_string(),
        ),
        (
            "parameters that wait for the end of the response",
            waiting.join(", "),
        ),
        ("last rejection", twin.last_rejection_reason.clone()),
        ("impacts since reset", twin.impacts_since_reset.to_string()),
        ("residual v1 [m]", twin.residual_v1.to_string()),
        (
            "plastic work since reset [J]",
            twin.plastic_work_since_reset.to_string(),
        ),
        ("action", action_word(twin.action).to_owned()),
        ("deciding criterion", twin.deciding_criterion.clone()),
        ("action reason", twin.action_reason.clone()),
        (
            "range of the verdict",
            range_in_words(
                twin.range_least,
                twin.range_most,
                twin.range_at_least,
                &twin.range_decided_by,
            )
            .unwrap_or_else(|| "not known".to_owned()),
        ),
        (
            "undamaged capacity [N]",
            twin.undamaged_capacity.to_string(),
        ),
        ("residual capacity [N]", twin.residual_capacity.to_string()),
        ("reserve", twin.reserve.to_string()),
    ];
    entry(
        "twin",
        level,
        message,
        values.map(|(key, value)| (key.to_owned(), value)),
    )
}

/// WARN to inspect or restrict, ERROR to shore or evacuate, or if the column could not be assessed.
pub(super) fn action_level(action: u8) -> u8 {
    match action {
        TwinStatus::ACTION_NONE => DiagnosticStatus::OK,
        TwinStatus::ACTION_INSPECT | TwinStatus::ACTION_RESTRICT => DiagnosticStatus::WARN,
        _ => DiagnosticStatus::ERROR,
    }
}

fn solver_status(health: &Health) -> DiagnosticStatus {
    let (level, message) = match (health.overruns, health.hints.first()) {
        _ if health.has_panicked => (
            DiagnosticStatus::ERROR,
            "a thread of the solver panicked; restart the node and report its log".to_owned(),
        ),
        _ if health.unsaved_states > 0 => (
            DiagnosticStatus::ERROR,
            format!(
                "{} writes of a state file failed, so that damage may be missing after a restart; the log has the reason",
                health.unsaved_states
            ),
        ),
        (0, None) => (DiagnosticStatus::OK, "on time".to_owned()),
        (0, Some(hint)) => (
            DiagnosticStatus::OK,
            format!("on time, but not guaranteed: {hint}"),
        ),
        _ => (DiagnosticStatus::WARN, "periods were skipped".to_owned()),
    };
    let mut values = vec![
        ("deadline overruns".to_owned(), health.overruns.to_string()),
        (
            "worst lateness [s]".to_owned(),
            health.worst_lateness.to_string(),
        ),
    ];
    values.extend(health.statistics.iter().cloned());
    let hints = health.hints.iter();
    values.extend(hints.map(|hint| ("real-time setup".to_owned(), hint.clone())));
    entry("solver", level, message, values)
}

fn queue_status(queues: &[QueueStats]) -> DiagnosticStatus {
    let losing: Vec<_> = queues
        .iter()
        .filter(|it| it.dropped > 0)
        .map(|it| it.name.as_str())
        .collect();
    let (level, message) = match losing[..] {
        [] => (DiagnosticStatus::OK, "nothing lost".to_owned()),
        _ => (
            DiagnosticStatus::WARN,
            format!("entries lost: {}", losing.join(", ")),
        ),
    };
    let values = queues.iter().map(queue_entry);
    entry("queues", level, message, values)
}

fn queue_entry(queue: &QueueStats) -> (String, String) {
    let QueueStats {
        name,
        capacity,
        len,
        when_full,
        pushed,
        dropped,
    } = queue;
    let value = format!(
        "{len} of {capacity}, {pushed} since the start, {dropped} lost; when full: {}",
        when_full.in_words()
    );
    (name.clone(), value)
}

/// A recording is evidence, so every loss is an error.
fn recording_status(recording: &RecordingHealth) -> DiagnosticStatus {
    let lost = recording.lost;
    let (level, message) = match (&recording.problem, lost) {
        (Some(problem), _) => (
            DiagnosticStatus::ERROR,
            format!("not recording: {problem}; {lost} messages lost"),
        ),
        (None, 0) => (DiagnosticStatus::OK, "recording".to_owned()),
        (None, _) => (
            DiagnosticStatus::ERROR,
            format!("{lost} messages are missing from the recording"),
        ),
    };
    let mut values = vec![
        queue_entry(&recording.queue),
        ("messages lost".to_owned(), lost.to_string()),
    ];
    values.extend(recording.values.iter().cloned());
    entry("recording", level, message, values)
}

fn security_status(security: SecurityHealth) -> DiagnosticStatus {
    entry(
        "security",
        security.level,
        security.message,
        security.values,
    )
}

fn node_status(counters: &NodeCounters) -> DiagnosticStatus {
    let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
    let peers = &counters.lost_peers;
    let losses = [
        ("unreadable messages", count(&counters.unreadable)),
        ("missed messages", count(&counters.missed)),
        ("messages that were too long", counters.given_up.count()),
        ("unpublished messages", count(&counters.unpublished)),
        ("unlogged messages", count(&counters.unlogged)),
        (
            "messages published while a peer was lost",
            peers.published_meanwhile(),
        ),
    ];
    let (level, message) = if losses.iter().all(|(_, count)| *count == 0) {
        (DiagnosticStatus::OK, "nothing lost")
    } else {
        (DiagnosticStatus::WARN, "messages were lost")
    };
    let peers = [
        ("peers that fell silent", peers.losses()),
        ("peers that came back", peers.returns()),
    ];
    let values = losses.into_iter().chain(peers);
    let values = values.map(|(key, count)| (key.to_owned(), count.to_string()));
    entry("ros", level, message.to_owned(), values)
}

fn lifecycle_status(lifecycle: &Lifecycle) -> DiagnosticStatus {
    let (level, message) = match lifecycle.is_active() {
        true => (DiagnosticStatus::OK, "active".to_owned()),
        false => {
            let state = lifecycle.state().label();
            (
                DiagnosticStatus::WARN,
                format!("{state}: impacts are rejected"),
            )
        }
    };
    let rejected = lifecycle.rejected().to_string();
    let values = [("rejected while not active".to_owned(), rejected)];
    entry("lifecycle", level, message, values)
}

/// A client that reads too slowly loses messages of its own, which is no fault of the node.
fn foxglove_status(counts: FoxgloveCounts) -> DiagnosticStatus {
    let FoxgloveCounts {
        clients,
        rejected,
        dropped,
    } = counts;
    let values = [
        ("clients", clients),
        ("rejected connections", rejected),
        ("messages that clients lost", dropped),
    ];
    let values = values.map(|(key, count)| (key.to_owned(), count.to_string()));
    entry(
        "foxglove",
        DiagnosticStatus::OK,
        "serves".to_owned(),
        values,
    )
}

fn senders_status(senders: &Senders) -> DiagnosticStatus {
    let counts = [senders.not_allowed(), senders.too_fast()];
    let (level, message) = match counts {
        [0, 0] => (DiagnosticStatus::OK, "none rejected"),
        [_, 0] => (
            DiagnosticStatus::WARN,
            "senders that are not allowed were rejected",
        ),
        _ => (
            DiagnosticStatus::WARN,
            "senders that are too fast were rejected",
        ),
    };
    let keys = ["rejected, not allowed", "rejected, too fast"];
    let values = keys.iter().zip(counts);
    let values = values.map(|(key, count)| ((*key).to_owned(), count.to_string()));
    entry("senders", level, message.to_owned(), values)
}

/// The status of the sensors of a single twin.
pub(super) fn sensors_status(sensors: SensorStatus) -> DiagnosticStatus {
    let SensorStatus {
        level,
        message,
        values,
    } = sensors;
    entry("sensors", level, message, values)
}

fn clock_status(clock: &ClockWatch, is_responding: bool) -> DiagnosticStatus {
    let count = ("messages on /clock".to_owned(), clock.count().to_string());
    let (level, message) = match (
        clock.problem(Instant::now(), || is_responding),
        clock.count(),
    ) {
        (Some(problem), _) => (DiagnosticStatus::WARN, problem),
        (None, 0) => (DiagnosticStatus::OK, "waiting for /clock".to_owned()),
        (None, _) => (DiagnosticStatus::OK, "simulated time".to_owned()),
    };
    entry("clock", level, message, [count])
}

pub(super) fn phase_name(phase: u8) -> &'static str {
    match phase {
        TwinStatus::IDLE => "IDLE",
        TwinStatus::APPROACH => "APPROACH",
        TwinStatus::CONTACT => "CONTACT",
        TwinStatus::FREE => "FREE",
        TwinStatus::REST => "REST",
        TwinStatus::COLLAPSED => "COLLAPSED",
        TwinStatus::FRACTURED => "FRACTURED",
        TwinStatus::FAULTED => "FAULTED",
        _ => "unknown",
    }
}

pub(super) fn entry(
    name: &str,
    level: u8,
    message: String,
    values: impl IntoIterator<Item = (String, String)>,
) -> DiagnosticStatus {
    DiagnosticStatus {
        level,
        name: name.to_owned(),
        message,
        hardware_id: String::new(),
        values: values
            .into_iter()
            .map(|(key, value)| KeyValue { key, value })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use ros_node::clock_watch::CLOCK_TIMEOUT;

    fn levels(twin: &TwinStatus, health: &Health, counters: &NodeCounters) -> Vec<u8> {
        let array = array(twin, health, counters);
        array.status.iter().map(|it| it.level).collect()
    }

    fn array(twin: &TwinStatus, health: &Health, counters: &NodeCounters) -> DiagnosticArray {
        let observed = Observed {
            first: twin_status(twin, &[]),
            hardware_id: "",
            health,
            topics: None,
            recording: None,
            security: None,
            #[cfg(feature = "alarm")]
            alarms: None,
            foxglove: None,
            sensors: None,
            of_columns: Vec::new(),
            is_responding: !twin.is_at_rest(),
            counters,
        };
        diagnostics(Header::default(), "column_twin", observed)
    }

    #[test]
    fn clients_of_foxglove_that_lose_messages_are_counted_and_no_fault() {
        let counts = FoxgloveCounts {
            clients: 2,
            rejected: 1,
            dropped: 7,
        };
        let status = foxglove_status(counts);
        assert_eq!(
            (status.name.as_str(), status.level),
            ("foxglove", DiagnosticStatus::OK)
        );
        let values: Vec<_> = status.values.iter().map(|it| it.value.as_str()).collect();
        assert_eq!(values, ["2", "1", "7"]);
    }

    #[test]
    fn all_is_well_at_the_start() {
        let all = (
            TwinStatus::default(),
            Health::default(),
            NodeCounters::default(),
        );
        assert_eq!(levels(&all.0, &all.1, &all.2), [0, 0, 0, 0]);
    }

    #[test]
    fn a_missing_clock_is_a_warning() {
        let of = |waited: Duration| {
            let started = Instant::now()
                .checked_sub(waited)
                .expect("later than the boot");
            clock_status(&ClockWatch::new(started), false).level
        };
        assert_eq!(of(Duration::ZERO), DiagnosticStatus::OK);
        assert_eq!(of(CLOCK_TIMEOUT), DiagnosticStatus::WARN);
    }

    #[test]
    fn losses_are_warnings_and_a_panic_is_an_error() {
        let queue = QueueStats {
            name: "states to ROS".to_owned(),
            capacity: 4096,
            len: 0,
            when_full: crate::live::WhenFull::DropOldest,
            pushed: 9,
            dropped: 1,
        };
        let health = Health {
            overruns: 1,
            queues: vec![queue],
            ..Health::default()
        };
        let ended = Health {
            has_panicked: true,
            ..Health::default()
        };
        let counters = NodeCounters::default();
        assert_eq!(
            levels(&TwinStatus::default(), &ended, &counters),
            [0, 2, 0, 0]
        );
        NodeCounters::count(&counters.unreadable);
        assert_eq!(
            levels(&TwinStatus::default(), &health, &counters),
            [0, 1, 1, 1]
        );
        for phase in [
            TwinStatus::COLLAPSED,
            TwinStatus::FAULTED,
            TwinStatus::FRACTURED,
        ] {
            let twin = TwinStatus {
                phase,
                ..TwinStatus::default()
            };
            assert_eq!(
                levels(&twin, &health, &counters)[0],
                DiagnosticStatus::ERROR
            );
        }
    }

    #[test]
    fn the_action_is_the_level_of_the_twin_with_its_reason() {
        for (action, level) in [
            (TwinStatus::ACTION_NONE, DiagnosticStatus::OK),
            (TwinStatus::ACTION_INSPECT, DiagnosticStatus::WARN),
            (TwinStatus::ACTION_RESTRICT, DiagnosticStatus::WARN),
            (TwinStatus::ACTION_SHORE, DiagnosticStatus::ERROR),
            (TwinStatus::ACTION_EVACUATE, DiagnosticStatus::ERROR),
            (TwinStatus::ACTION_UNKNOWN, DiagnosticStatus::ERROR),
        ] {
            let twin = TwinStatus {
                action,
                action_reason: "a hinge has turned too far".to_owned(),
                ..TwinStatus::default()
            };
            let status = twin_status(&twin, &[]);
            assert_eq!(status.level, level);
            let is_named = status.message.contains("a hinge has turned too far");
            assert_eq!(
                is_named,
                level != DiagnosticStatus::OK,
                "{}",
                status.message
            );
        }
    }

    #[test]
    fn parameters_that_wait_are_listed() {
        let waiting = ["top.load", "damping.ratio"].map(str::to_owned);
        let status = twin_status(&TwinStatus::default(), &waiting);
        let listed = status
            .values
            .iter()
            .find(|it| it.value == "top.load, damping.ratio");
        let key = listed.map(|it| it.key.as_str());
        assert_eq!(
            key,
            Some("parameters that wait for the end of the response")
        );
    }

    #[test]
    fn counters_do_not_change_the_state() {
        let of = |accepted| {
            let twin = TwinStatus {
                events_accepted: accepted,
                ..TwinStatus::default()
            };
            array(&twin, &Health::default(), &NodeCounters::default())
        };
        assert!(same_state(&of(1), &of(2)));
        assert_ne!(of(1), of(2));
    }

    #[test]
    fn a_loss_of_the_recording_is_an_error() {
        let of = |lost, problem: Option<&str>| {
            let recording = RecordingHealth {
                queue: QueueStats {
                    name: "recording".to_owned(),
                    capacity: 1,
                    len: 0,
                    when_full: crate::live::WhenFull::DropNewest,
                    pushed: 9,
                    dropped: lost,
                },
                lost,
                problem: problem.map(str::to_owned),
                values: Vec::new(),
            };
            recording_status(&recording).level
        };
        assert_eq!(of(0, None), DiagnosticStatus::OK);
        assert_eq!(of(1, None), DiagnosticStatus::ERROR);
        assert_eq!(of(0, Some("no space left")), DiagnosticStatus::ERROR);
    }
}
