//! Alarms of the node: which outputs of the columns are conditions, and the delivery that the parameters describe.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use column_alarm::{
    Alarms, Condition, Importance, Level, MqttSettings, NODE_STOPPED, Notices, Rules, Settings,
    Statistics, TlsFiles, Tried, Watched, WebhookSettings,
};

use crate::estimation::{SensorCondition, SensorHealth};
use crate::messages::diagnostic_msgs::DiagnosticStatus;
use crate::parameters::{AlarmAction, AlarmSettings};
use crate::state_home;
use crate::twin::Output;

use super::diagnostics::entry;
use super::metrics::AlarmChannel;
use super::node::NodeError;
use super::standing_action::StandingAction;

/// The kind of the alarms about what has to be done with a column.
const ACTION: &str = "action";
/// The kind of the alarms about sensors.
const SENSOR_FAILED: &str = "sensor_failed";
/// A sensor that has sent nothing for so long after the start has failed.
const PATIENCE_AT_THE_START: Duration = Duration::from_secs(60);
/// Longest time to deliver what waits at the end; the rest is delivered after the next start.
const TIME_AT_THE_END: Duration = Duration::from_secs(3);
/// The alarms of a running node. The publishing thread owns it and never waits for it.
pub(super) struct NodeAlarms {
    alarms: Alarms,
    started: Instant,
    /// What was told last, so that a condition that stays the same costs nothing.
    told: HashMap<Watched, (u8, String)>,
}

impl NodeAlarms {
    /// Starts the delivery if the parameters ask for it; `node` is the full name of the node.
    pub fn start(settings: &AlarmSettings, node: &str) -> Result<Option<Self>, NodeError> {
        let Some(settings) = delivery(settings, node) else {
            return Ok(None);
        };
        let notices: Notices = Arc::new(|importance, text| match importance {
            Importance::Info => tracing::info!("{text}"),
            Importance::Warning => tracing::warn!("{text}"),
            Importance::Error => tracing::error!("{text}"),
        });
        let alarms = Alarms::start(&settings, notices)
            .map_err(|fault| NodeError::Alarms(fault.to_string()))?;
        Ok(Some(Self {
            alarms,
            started: Instant::now(),
            told: HashMap::new(),
        }))
    }

    /// Takes what leaves a column.
    pub fn note(&mut self, column_id: &str, output: &Output) {
        if let Some(action) = StandingAction::of(output) {
            self.tell(condition_of_column(column_id, action));
        }
    }

    /// Takes the health of the sensors of a column, which is a sign of life of the node, too.
    pub fn sensors(&mut self, column_id: &str, sensors: &[SensorHealth]) {
        let is_late = self.started.elapsed() > PATIENCE_AT_THE_START;
        for sensor in sensors {
            if let Some(condition) = condition_of_sensor(column_id, sensor, is_late) {
                self.tell(condition);
            }
        }
    }

    /// The node publishes: heartbeats may go on.
    pub fn sign_of_life(&self) {
        self.alarms.sign_of_life();
    }

    fn tell(&mut self, condition: Condition) {
        let state = (condition.level.rank, condition.cause.clone());
        if self.told.get(&condition.watched) != Some(&state) {
            let watched = condition.watched.clone();
            // One that was dropped is told again with the next status.
            if self.alarms.observe(condition) {
                self.told.insert(watched, state);
            }
        }
    }

    /// The status of the delivery.
    pub fn status(&self) -> DiagnosticStatus {
        alarms_status(&self.alarms.statistics())
    }

    /// What became of the messages, for metrics.
    pub fn channels(&self) -> Vec<AlarmChannel> {
        let channels = self.alarms.statistics().channels.into_iter();
        let channel = channels.map(|it| AlarmChannel {
            name: it.name,
            works: it.works != Some(false),
            waiting: it.waiting,
            counts: [
                ("delivered", it.delivered),
                ("failed", it.failed),
                ("rejected", it.rejected),
                ("lost", it.lost),
            ],
        });
        channel.collect()
    }

    /// Says that the node stops, and delivers what waits, for a moment.
    pub fn stop(self) {
        let reason = "The node was stopped in order.";
        self.alarms.stop(reason, TIME_AT_THE_END);
    }
}

/// Sends a message of the state `test` by each way that the parameters ask for; `None` if they ask for none.
pub(super) fn try_out(
    settings: &AlarmSettings,
    node: &str,
) -> Result<Option<Vec<Tried>>, NodeError> {
    let tried = delivery(settings, node).map(|settings| column_alarm::try_out(&settings));
    let tried = tried.transpose();
    tried.map_err(|fault| NodeError::Alarms(fault.to_string()))
}

/// The delivery that the parameters describe; `None` without a receiver.
fn delivery(settings: &AlarmSettings, node: &str) -> Option<Settings> {
    let AlarmSettings {
        spool,
        heartbeat,
        mqtt,
        webhook,
    } = settings;
    let given = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    let tls = |ca: &str, certificate: &str, key: &str| TlsFiles {
        authorities: given(ca).map(Into::into),
        certificate: given(certificate).map(Into::into),
        key: given(key).map(Into::into),
    };
    let mqtt = given(&mqtt.broker).map(|broker| MqttSettings {
        broker,
        client_id: given(&mqtt.client_id)
            .unwrap_or_else(|| node.trim_start_matches('/').replace('/', "_")),
        topic: mqtt.topic.clone(),
        user: given(&mqtt.user),
        password_file: given(&mqtt.password_file).map(Into::into),
        tls: tls(&mqtt.ca_file, &mqtt.certificate_file, &mqtt.key_file),
        rules: rules(mqtt.action, mqtt.sensor_failed, mqtt.node_stopped),
    });
    let webhook = given(&webhook.url).map(|url| WebhookSettings {
        url,
        key_file: webhook.secret_file.clone().into(),
        tls: tls(
            &webhook.ca_file,
            &webhook.certificate_file,
            &webhook.key_file,
        ),
        rules: rules(webhook.action, webhook.sensor_failed, webhook.node_stopped),
    });
    (mqtt.is_some() || webhook.is_some()).then(|| Settings {
        node: node.to_owned(),
        spool: state_home::resolve(spool),
        heartbeat: (*heartbeat > 0.0).then(|| Duration::from_secs_f64(*heartbeat)),
        mqtt,
        webhook,
    })
}

fn rules(action: AlarmAction, sensor_failed: bool, node_stopped: bool) -> Rules {
    let mut rules = Rules::none();
    if let Some(least) = rank_of(action) {
        rules = rules.with(ACTION, least);
    }
    if sensor_failed {
        rules = rules.with(SENSOR_FAILED, 1);
    }
    if node_stopped {
        rules = rules.with(NODE_STOPPED, 1);
    }
    rules
}

/// The rank of the mildest action that is an alarm, as in [`StandingAction::rank`].
fn rank_of(action: AlarmAction) -> Option<u8> {
    match action {
        AlarmAction::Off => None,
        AlarmAction::Inspect => Some(1),
        AlarmAction::Restrict => Some(2),
        AlarmAction::Shore => Some(3),
        AlarmAction::Evacuate => Some(4),
    }
}

/// The condition of a column.
fn condition_of_column(column_id: &str, action: StandingAction) -> Condition {
    Condition {
        watched: Watched {
            kind: ACTION.to_owned(),
            subject: column_id.to_owned(),
            part: None,
        },
        level: Level::new(action.rank, action.name),
        reason: action.reason,
        cause: action.event_id,
        time: SystemTime::now(),
    }
}

/// `is_late`: whether a sensor should have sent something by now.
fn condition_of_sensor(column_id: &str, sensor: &SensorHealth, is_late: bool) -> Option<Condition> {
    let (rank, level, reason) = match sensor.condition {
        SensorCondition::Waiting if !is_late => return None,
        SensorCondition::Waiting => (1, "silent", "has sent nothing since the start".to_owned()),
        SensorCondition::Alive => (0, "alive", "sends readings".to_owned()),
        SensorCondition::Stuck => (1, "stuck", "repeats one value".to_owned()),
        SensorCondition::Dead(_) => (1, "dead", "sends nothing any more".to_owned()),
    };
    Some(Condition {
        watched: Watched {
            kind: SENSOR_FAILED.to_owned(),
            subject: column_id.to_owned(),
            part: Some(sensor.name.to_string()),
        },
        level: Level::new(rank, level),
        reason: format!("The sensor {} {reason}.", sensor.name),
        // Dead and stuck are two alarms in a row, not one that is told twice.
        cause: level.to_owned(),
        time: SystemTime::now(),
    })
}

/// The status of the delivery in `/diagnostics`: an alarm that is lost is an error.
fn alarms_status(statistics: &Statistics) -> DiagnosticStatus {
    let lost: u64 = statistics.dropped + statistics.channels.iter().map(|it| it.lost).sum::<u64>();
    let problems: Vec<String> = statistics
        .channels
        .iter()
        .filter(|it| it.works == Some(false))
        .map(|it| format!("{}: {}", it.name, it.problem))
        .collect();
    let (level, message) = match (lost, problems.is_empty()) {
        (0, true) => (DiagnosticStatus::OK, "delivered".to_owned()),
        (0, false) => (DiagnosticStatus::WARN, problems.join("; ")),
        _ => (
            DiagnosticStatus::ERROR,
            format!("{lost} messages or conditions were lost; the log has the reason"),
        ),
    };
    let mut values = vec![(
        "dropped conditions".to_owned(),
        statistics.dropped.to_string(),
    )];
    for it in &statistics.channels {
        let counts = [
            ("delivered", it.delivered),
            ("waiting", it.waiting),
            ("active alarms", it.active),
            ("failed attempts", it.failed),
            ("rejected by the receiver", it.rejected),
            ("lost", it.lost),
            ("heartbeats", it.heartbeats),
        ];
        let counts = counts.map(|(what, count)| (format!("{} {what}", it.name), count.to_string()));
        values.extend(counts);
    }
    entry("alarms", level, message, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;

    fn settings(overrides: &[&str]) -> Option<Settings> {
        let overrides = overrides
            .iter()
            .map(|it| crate::parameters::parse_override(it));
        let overrides: Vec<_> = overrides.collect();
        let parameters = Parameters::load(&[], &overrides).expect("admissible");
        delivery(&parameters.settings().alarm, "/garage/column_twin")
    }

    #[test]
    fn without_a_receiver_there_is_no_delivery() {
        assert!(settings(&["alarm.heartbeat:=5.0"]).is_none());
    }

    #[test]
    fn the_parameters_describe_the_delivery() {
        let found = settings(&[
            "alarm.mqtt.broker:=mqtt://127.0.0.1:1883",
            "alarm.mqtt.action:=restrict",
            "alarm.mqtt.sensor_failed:=false",
            "alarm.heartbeat:=0.0",
        ]);
        let found = found.expect("a broker is given");
        assert_eq!((found.heartbeat, found.webhook.is_none()), (None, true));
        let mqtt = found.mqtt.expect("a broker is given");
        assert_eq!(mqtt.client_id, "garage_column_twin");
        let expected = Rules::none().with(ACTION, 2).with(NODE_STOPPED, 1);
        assert_eq!(mqtt.rules, expected);
        assert_eq!(mqtt.tls, TlsFiles::default());
    }

    #[test]
    fn a_sensor_that_fails_and_comes_back_is_told() {
        let sensor = |condition| SensorHealth {
            name: "mid".into(),
            condition,
            counts: Default::default(),
            clock_offset: 0,
            clock_correction: 0,
            last_rejection: None,
        };
        let rank = |condition, is_late| {
            condition_of_sensor("a3", &sensor(condition), is_late).map(|it| it.level.rank)
        };
        assert_eq!(rank(SensorCondition::Waiting, false), None);
        assert_eq!(rank(SensorCondition::Waiting, true), Some(1));
        assert_eq!(rank(SensorCondition::Dead(5), true), Some(1));
        assert_eq!(rank(SensorCondition::Stuck, true), Some(1));
        assert_eq!(rank(SensorCondition::Alive, true), Some(0));
    }
}
