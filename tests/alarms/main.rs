//! Alarms and metrics of a running node: what arrives at a broker, what Prometheus reads, what is wrong at the start.
#![cfg(all(feature = "cli", feature = "ros", feature = "alarm"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "../ros/domain.rs"]
mod domain;
#[path = "../ros/program.rs"]
#[allow(dead_code)] // for other tests
mod program;
#[path = "../../crates/alarm/tests/peers/programs.rs"]
#[allow(dead_code)] // for the tests of the crate
mod programs;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use domain::{Domain, PATIENCE};
use program::Program;
use programs::{Lines, Mosquitto, free_port};
use serde_json::Value;
use tempfile::tempdir;

const QUIET: [&str; 6] = [
    "-p",
    "state.directory:=''",
    "-p",
    "real_time.priority:=0",
    "-p",
    "real_time.lock_memory:=false",
];

fn with(arguments: &[String]) -> Vec<&str> {
    let own = arguments.iter().flat_map(|it| ["-p", it.as_str()]);
    QUIET.into_iter().chain(own).collect()
}

fn column_twin(domain: &Domain, arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .expect("the program that was built with this test")
}

fn page(port: u16) -> Option<String> {
    let mut connection = TcpStream::connect(("127.0.0.1", port)).ok()?;
    connection
        .write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .ok()?;
    let mut text = String::new();
    connection.read_to_string(&mut text).ok()?;
    text.split_once("\r\n\r\n").map(|(_, body)| body.to_owned())
}

/// The page, as soon as it has this line.
fn page_with(port: u16, line: &str) -> String {
    let began = Instant::now();
    loop {
        let found = page(port).unwrap_or_default();
        if found.lines().any(|it| it == line) {
            return found;
        }
        assert!(began.elapsed() < PATIENCE, "no {line:?} in\n{found}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_running_node_shows_its_metrics() {
    let (domain, folder) = (Domain::fresh(), tempdir().unwrap());
    let port = free_port();
    let address = [
        format!("metrics.address:='127.0.0.1:{port}'"),
        "column_id:=a3".to_owned(),
    ];
    let _node = Program::ready(&domain, folder.path(), &with(&address));
    page_with(port, "column_twin_action{column=\"a3\"} 0");
    let hit = column_twin(
        &domain,
        &[
            "impact",
            "--mass",
            "10000",
            "--velocity",
            "15",
            "--column",
            "a3",
        ],
    );
    assert!(hit.status.success(), "{hit:?}");
    let found = page_with(port, "column_twin_action{column=\"a3\"} 4");
    for line in [
        "column_twin_forecast_latency_seconds_count 1",
        "column_twin_events_accepted_total{column=\"a3\"} 1",
        "column_twin_lost_total{what=\"unreadable\"} 0",
    ] {
        page_with(port, line);
    }
    assert!(!found.contains("NaN"), "{found}");
}

#[test]
fn what_cannot_work_is_an_error_at_the_start() {
    let (domain, folder) = (Domain::fresh(), tempdir().unwrap());
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap();
    let broker = "alarm.mqtt.broker:=mqtt://127.0.0.1:1";
    for (arguments, expected) in [
        (
            vec![format!("metrics.address:='{taken}'")],
            "metrics.address",
        ),
        (
            vec!["alarm.mqtt.broker:=broker".to_owned()],
            "is not the address of a broker",
        ),
        (
            vec![
                broker.to_owned(),
                "alarm.mqtt.topic:='a/+/{subject}/{kind}'".to_owned(),
            ],
            "does not allow",
        ),
        (
            vec!["alarm.webhook.url:=http://example.org/".to_owned()],
            "https://",
        ),
        (
            vec![
                "alarm.webhook.url:=https://127.0.0.1/".to_owned(),
                "alarm.webhook.secret_file:=/nowhere".to_owned(),
            ],
            "/nowhere",
        ),
    ] {
        let mut command = vec!["run", "--ros-args"];
        let own = with(&arguments);
        command.extend(own);
        let ended = Command::new(env!("CARGO_BIN_EXE_column-twin"))
            .args(&command)
            .current_dir(folder.path())
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{told}");
        assert!(told.contains(expected), "{told}");
    }
}

/// A broker that is away is a warning, and the twin works on.
#[test]
fn a_broker_that_is_away_does_not_stop_the_twin() {
    let (domain, folder) = (Domain::fresh(), tempdir().unwrap());
    let arguments = [
        format!("alarm.mqtt.broker:=mqtt://127.0.0.1:{}", free_port()),
        format!("alarm.spool:={}", folder.path().display()),
        "column_id:=a3".to_owned(),
    ];
    let mut node = Program::ready(&domain, folder.path(), &with(&arguments));
    if !node.seen.iter().any(|line| line.contains("alarm by mqtt")) {
        node.wait_for("alarm by mqtt");
    }
    let hit = column_twin(
        &domain,
        &[
            "impact",
            "--mass",
            "1500",
            "--velocity",
            "2",
            "--column",
            "a3",
        ],
    );
    assert!(hit.status.success(), "{hit:?}");
    assert_eq!(
        column_twin(&domain, &["alarm", "test"]).status.code(),
        Some(2)
    );
    let tried = column_twin(
        &domain,
        &["alarm", "test", "--ros-args", "-p", &arguments[0]],
    );
    assert_eq!(tried.status.code(), Some(1), "{tried:?}");
}

fn next(lines: &Lines, kind: &str, state: &str) -> Value {
    loop {
        let line = lines.next();
        let payload = line.splitn(3, ' ').nth(2).unwrap_or_default();
        let message: Value = serde_json::from_str(payload).unwrap_or_default();
        if message["kind"] == kind && message["state"] == state {
            return message;
        }
    }
}

#[test]
#[ignore = "needs mosquitto"]
fn the_alarm_of_an_impact_arrives_and_is_cleared() {
    let (domain, folder) = (Domain::fresh(), tempdir().unwrap());
    let broker = Mosquitto::started(folder.path(), "");
    let lines = broker.subscriber();
    let arguments = [
        format!("alarm.mqtt.broker:={}", broker.address()),
        format!("alarm.spool:={}", folder.path().join("spool").display()),
        "alarm.heartbeat:=1.0".to_owned(),
        "column_id:=a3".to_owned(),
    ];
    let node = Program::ready(&domain, folder.path(), &with(&arguments));
    next(&lines, "heartbeat", "alive");
    let hit = [
        "impact",
        "--mass",
        "10000",
        "--velocity",
        "15",
        "--column",
        "a3",
        "--event",
        "gate 17",
    ];
    let hit = column_twin(&domain, &hit);
    assert!(hit.status.success(), "{hit:?}");
    let raised = next(&lines, "action", "raised");
    assert_eq!(
        (&raised["subject"], &raised["rank"]),
        (&"a3".into(), &4.into())
    );
    let reason = raised["reason"].as_str().unwrap_or_default();
    assert!(
        reason.starts_with("Forecast of impact \"gate 17\": "),
        "{reason}"
    );
    let mut try_out = vec!["alarm", "test", "--ros-args"];
    let own = with(&arguments);
    try_out.extend(own);
    let tried = column_twin(&domain, &try_out);
    assert_eq!(
        String::from_utf8_lossy(&tried.stdout),
        "mqtt: acknowledged\n",
        "{tried:?}"
    );
    next(&lines, "test", "test");
    node.terminate();
    next(&lines, "node_stopped", "raised");
    // Without a state file, the column is a new one.
    let _node = Program::ready(&domain, folder.path(), &with(&arguments));
    next(&lines, "node_stopped", "cleared");
    let cleared = next(&lines, "action", "cleared");
    assert_eq!(cleared["alarm"], raised["alarm"]);
}

#[test]
#[ignore = "needs promtool"]
fn promtool_accepts_metrics_rules_and_dashboard() {
    let promtool = |arguments: &[&str], input: &str| {
        let mut child = Command::new("promtool")
            .args(arguments)
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/config/prometheus"))
            .stdin(Stdio::piped())
            .spawn()
            .expect("Debian's package prometheus is installed");
        child
            .stdin
            .take()
            .unwrap()
            .write_all(input.as_bytes())
            .unwrap();
        assert!(child.wait().unwrap().success(), "{arguments:?}");
    };
    promtool(&["check", "rules", "column_twin.rules.yaml"], "");
    promtool(&["test", "rules", "column_twin.test.yaml"], "");
    let (domain, folder) = (Domain::fresh(), tempdir().unwrap());
    let port = free_port();
    let arguments = [
        format!("metrics.address:='127.0.0.1:{port}'"),
        format!("alarm.mqtt.broker:=mqtt://127.0.0.1:{}", free_port()),
        format!("alarm.spool:={}", folder.path().display()),
        "record.mode:=always".to_owned(),
        "column_id:=a3".to_owned(),
        "sensors.names:=['mid']".to_owned(),
        "sensors.mid.quantity:=axial_strain".to_owned(),
        "sensors.mid.height:=1.5".to_owned(),
    ];
    let _node = Program::ready(&domain, folder.path(), &with(&arguments));
    page_with(port, "column_twin_action{column=\"a3\"} 0");
    let found = page_with(port, "column_twin_alarm_delivery_works{channel=\"mqtt\"} 0");
    promtool(&["check", "metrics"], &found);
    // Every metric that the rules and the dashboard ask for is on the page.
    let texts = ["column_twin.rules.yaml", "grafana_dashboard.json"].map(|name| {
        std::fs::read_to_string(format!(
            "{}/config/prometheus/{name}",
            env!("CARGO_MANIFEST_DIR")
        ))
        .unwrap()
    });
    let mut asked = 0;
    for text in &texts {
        let words = text.split(|it: char| !(it.is_ascii_alphanumeric() || it == '_'));
        for word in words.filter(|it| it.starts_with("column_twin_")) {
            asked += 1;
            assert!(
                found.contains(&format!("\n{word}")),
                "{word} is not in\n{found}"
            );
        }
    }
    assert!(asked > 20, "{asked}");
}
