//! The rows of the table about alarms, metrics and Foxglove.

use super::parameter::{Admissible, Applies, DefaultValue, Parameter};

/// The rows, in the order of the documentation.
pub(super) const ROWS: [Parameter; 21] = [
    Parameter {
        name: "alarm.spool",
        unit: "",
        default: DefaultValue::Text("$XDG_STATE_HOME/column_twin/alarms"),
        admissible: Admissible::Text {
            min_chars: 1,
            max_chars: 4096,
        },
        applies: Applies::Restart,
        meaning: "directory of the alarms that wait for delivery; each node needs one of its own; `$XDG_STATE_HOME` as for `state.directory`",
    },
    Parameter {
        name: "alarm.heartbeat",
        unit: "s",
        default: DefaultValue::Double(60.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 86_400.0,
            zero: "no heartbeats",
        },
        applies: Applies::Restart,
        meaning: "time between two heartbeats, whose absence shows the receiver that the node does not run or cannot be reached",
    },
    text(
        "alarm.mqtt.broker",
        "",
        "broker of MQTT 5, such as mqtts://broker.example:8883; empty: no alarms by MQTT",
    ),
    text(
        "alarm.mqtt.client_id",
        "",
        "name by which the broker identifies the node; two nodes with the same one disconnect one another; \
        empty: from the name of the node",
    ),
    text(
        "alarm.mqtt.topic",
        "column_twin/{node}/{subject}/{kind}",
        "template of the topics, with the fields {node}, {subject} (the \
        column, or column/sensor) and {kind} (action, sensor_failed, node_stopped, heartbeat or test)",
    ),
    text("alarm.mqtt.user", "", "user, if the broker asks for one"),
    text(
        "alarm.mqtt.password_file",
        "",
        "file with the password of the user, which nobody else may read (mode 0600)",
    ),
    text(
        "alarm.mqtt.ca_file",
        "",
        "certificates of the authorities that are trusted (PEM); empty: the authorities of the system",
    ),
    text(
        "alarm.mqtt.certificate_file",
        "",
        "certificate of the node with its chain (PEM), if the broker asks for one",
    ),
    text(
        "alarm.mqtt.key_file",
        "",
        "private key of this certificate (PEM, mode 0600)",
    ),
    action("alarm.mqtt.action"),
    switch("alarm.mqtt.sensor_failed", SENSOR_FAILED),
    switch("alarm.mqtt.node_stopped", NODE_STOPPED),
    text(
        "alarm.webhook.url",
        "",
        "address that alarms are posted to, such as https://alarms.example/column; http:// for this machine \
        only; empty: no webhook",
    ),
    text(
        "alarm.webhook.secret_file",
        "",
        "file with the key of the signatures: whsec_ and at least 24 bytes in Base64 (Standard \
        Webhooks, mode 0600)",
    ),
    text(
        "alarm.webhook.ca_file",
        "",
        "certificates of the authorities that are trusted (PEM); empty: the authorities of the system",
    ),
    text(
        "alarm.webhook.certificate_file",
        "",
        "certificate of the node with its chain (PEM), if the receiver asks for one",
    ),
    text(
        "alarm.webhook.key_file",
        "",
        "private key of this certificate (PEM, mode 0600)",
    ),
    action("alarm.webhook.action"),
    switch("alarm.webhook.sensor_failed", SENSOR_FAILED),
    switch("alarm.webhook.node_stopped", NODE_STOPPED),
];

/// Where Prometheus reads.
pub(super) const METRICS_ADDRESS: Parameter = text(
    "metrics.address",
    "",
    "address and port from which Prometheus reads, such as 127.0.0.1:9464; empty: no metrics",
);

/// Live topics for Foxglove.
pub(super) const FOXGLOVE: [Parameter; 4] = [
    Parameter {
        name: "foxglove.mode",
        unit: "",
        default: DefaultValue::Text("off"),
        admissible: Admissible::Choice(&["off", "serve"]),
        applies: Applies::Restart,
        meaning: "off: no live topics for Foxglove; serve: Foxglove connects to this program, past DDS and its security",
    },
    text(
        "foxglove.address",
        "127.0.0.1:8765",
        "address and port to serve on; everybody who reaches an address that is not loopback sees the topics",
    ),
    Parameter {
        name: "foxglove.origins",
        unit: "",
        default: DefaultValue::Texts(&["https://app.foxglove.dev"]),
        admissible: Admissible::List {
            of: &Admissible::Text {
                min_chars: 1,
                max_chars: 256,
            },
            min_len: 0,
            max_len: 16,
        },
        applies: Applies::Restart,
        meaning: "web pages that may connect, by their origins; programs, which send no origin, and pages of this machine always may",
    },
    Parameter {
        name: "foxglove.control",
        unit: "",
        default: DefaultValue::Bool(false),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "whether Foxglove may set parameters and reset columns; `senders.*` does not limit it",
    },
];

const SENSOR_FAILED: &str = "whether a sensor that is dead or stuck is an alarm";
const NODE_STOPPED: &str = "whether it is an alarm that the node stops, in order or not";

const fn text(name: &'static str, default: &'static str, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "",
        default: DefaultValue::Text(default),
        admissible: Admissible::Text {
            min_chars: 0,
            max_chars: 4096,
        },
        applies: Applies::Restart,
        meaning,
    }
}

const fn switch(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning,
    }
}

const fn action(name: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "",
        default: DefaultValue::Text("inspect"),
        admissible: Admissible::Choice(&["off", "inspect", "restrict", "shore", "evacuate"]),
        applies: Applies::Restart,
        meaning: "mildest action that is an alarm; off: none is",
    }
}
