//! `column-twin run` with ROS 2 itself and with a DDS program without ROS. The first run takes a minute or two and needs the
//! network; Python 3.11 is required: `cargo test --release --test ros -- --ignored`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use column_twin::column::{Impact, ImpactSpecification, Report};
use column_twin::messages::column_twin_msgs::{ImpactEvent, ImpactReport};
use column_twin::parameters::Parameters;
use column_twin::ros::qos;
use column_twin::twin::Twin;
use serde::Serialize;
use serde_json::{Map, Value as Json, json};

use super::domain::{Domain, PATIENCE};
use super::loopback::{Outgoing, event, now};
use super::program::Program;
use super::simulation;
use super::transport::{MANY, Sender, report, status};

const MASS: f64 = 1500.0;
const VELOCITY: f64 = 10.0;

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// The Python of the environment with this distribution of ROS 2, which is built if necessary.
fn python(distribution: &str) -> PathBuf {
    let output = Command::new(interop("environment.sh"))
        .arg(distribution)
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert!(output.status.success(), "environment.sh: {}", output.status);
    let environment = String::from_utf8(output.stdout).unwrap();
    Path::new(environment.trim()).join("bin/python")
}

/// Starts a script with ROS 2 Jazzy in the node's domain.
fn script(domain: &Domain, file: &str, expected: Option<&Path>) -> Child {
    script_with("jazzy", domain, file, expected)
}

/// Starts a script with a distribution of ROS 2 in the node's domain.
fn script_with(distribution: &str, domain: &Domain, file: &str, expected: Option<&Path>) -> Child {
    Command::new(python(distribution))
        .arg(interop(file))
        .args(expected)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for the script, which has its own deadlines, and shows its output.
fn finish(mut child: Child) {
    let output = child.stdout.take().unwrap();
    for line in BufReader::new(output).lines() {
        println!("{}", line.unwrap());
    }
    let status = child.wait().unwrap();
    assert!(status.success(), "{status}");
}

/// The numbers of a message that depend only on the impact; NaN is null.
fn numbers(message: &impl Serialize) -> Map<String, Json> {
    let Ok(Json::Object(mut fields)) = serde_json::to_value(message) else {
        panic!("a message is a structure");
    };
    for told_by_the_node in ["header", "column_id", "event_id", "kind", "compute_time"] {
        fields.remove(told_by_the_node);
    }
    fields
}

/// The report with its assessment and its error estimate, as a prediction for the undamaged column gives them.
fn assessed(report: &Report) -> Map<String, Json> {
    let twin = Twin::new(Parameters::default(), None, Box::new(|| 0), 0).unwrap();
    let impact = ImpactSpecification::from(Impact::rigid(MASS, VELOCITY));
    let impact = ImpactSpecification {
        gap: None,
        restitution: None,
        ..impact
    };
    let predicted = twin.snapshot().predict("", "", &impact, &|| 0).unwrap();
    assert_eq!(predicted.report, *report);
    numbers(&ImpactReport::from(&predicted))
}

/// The expected result of the event, computed by the simulation alone.
fn expectation(folder: &Path) -> PathBuf {
    let (samples, report) = simulation::stream(&Parameters::default(), MASS, VELOCITY);
    let samples: Vec<_> = samples
        .iter()
        .map(|it| json!({ "since": it.since, "state": numbers(&it.state), "forces": numbers(&it.forces) }))
        .collect();
    let report = assessed(&report);
    let expected =
        json!({ "mass": MASS, "velocity": VELOCITY, "samples": samples, "report": report });
    let path = folder.join("expected.json");
    std::fs::write(&path, expected.to_string()).unwrap();
    path
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_finds_receives_sets_and_is_rejected() {
    finds_receives_sets_and_is_rejected("jazzy");
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_of_kilted_finds_receives_sets_and_is_rejected() {
    finds_receives_sets_and_is_rejected("kilted");
}

fn finds_receives_sets_and_is_rejected(distribution: &str) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let program = Program::ready(&domain, folder.path(), &[]);
    let peer = script_with(distribution, &domain, "node_with_rclpy.py", Some(&expected));
    finish(peer);
    let (ended, took, log) = program.terminate();
    println!("ended within {took:?}");
    assert!(ended.success(), "{ended}: {log:#?}");
}

/// `ros2 param`, `ros2 topic echo` and type descriptions, with the functions of rclpy that the tools call.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn the_tools_of_ros_2_set_dump_load_echo_and_describe() {
    set_dump_load_echo_and_describe("jazzy");
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn the_tools_of_kilted_set_dump_load_echo_and_describe() {
    set_dump_load_echo_and_describe("kilted");
}

fn set_dump_load_echo_and_describe(distribution: &str) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::ready(&domain, folder.path(), &[]);
    finish(script_with(
        distribution,
        &domain,
        "tools_with_rclpy.py",
        None,
    ));
    assert!(program.terminate().0.success());
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn a_managed_node_answers_as_one_of_rclpy() {
    answers_as_one_of_rclpy("jazzy");
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn a_managed_node_answers_as_one_of_rclpy_of_kilted() {
    answers_as_one_of_rclpy("kilted");
}

/// The script ends the node by a transition.
fn answers_as_one_of_rclpy(distribution: &str) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    command.args(["run", "--managed"]);
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    let script = "lifecycle_with_rclpy.py";
    finish(script_with(distribution, &domain, script, None));
    let (ended, log) = program.end();
    assert!(ended.success(), "{ended}: {log:#?}");
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_plays_the_clock() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let program = Program::ready(&domain, folder.path(), &["-p", "use_sim_time:=true"]);
    finish(script(&domain, "clock_with_rclpy.py", Some(&expected)));
    assert!(program.terminate().0.success());
}

/// `ros2 topic echo --once /twin_status` showed a status of minutes ago: all that had ever been sent came first.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_joins_late_and_gets_what_is_offered() {
    let domain = Domain::fresh();
    let statuses = Sender::start(&domain, &qos::TWIN_STATUS);
    let forecasts = Sender::start(&domain, &qos::IMPACT_FORECAST);
    for number in 1..=MANY {
        statuses.publisher.publish(status(number)).unwrap();
        forecasts.publisher.publish(report(number)).unwrap();
    }
    let output = script(&domain, "late_joiner_with_rclpy.py", None)
        .wait_with_output()
        .unwrap();
    assert!(output.status.success(), "{}", output.status);
    let last_ten = (MANY - 9..=MANY).map(|it| it.to_string());
    let expected = format!(
        "twin_status {MANY}\nimpact_forecast {}\n",
        Vec::from_iter(last_ten).join(" ")
    );
    assert_eq!(String::from_utf8_lossy(&output.stdout), expected);
}

/// `rmw_cyclonedds` has a mapping of services of its own: its requests were misread, and it never got a reply.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn cyclonedds_calls_services_in_its_own_mapping() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let program = Program::ready(&domain, folder.path(), &[]);
    finish(script(&domain, "cyclone_service.py", Some(&expected)));
    assert!(program.terminate().0.success());
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn cyclonedds_without_ros_receives_the_state() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let program = Program::ready(&domain, folder.path(), &[]);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let mut child = script(&domain, "state_with_cyclonedds.py", Some(&expected));
    let (sender, lines) = channel();
    let output = BufReader::new(child.stdout.take().unwrap()).lines();
    let reading = std::thread::spawn(move || {
        for line in output.map_while(Result::ok) {
            println!("{line}");
            let _ = sender.send(line);
        }
    });
    assert_eq!(lines.recv_timeout(PATIENCE).unwrap(), "found");
    // The publisher has found it when a whole response has come; a light impact leaves no trace.
    // Another one must not follow while a late response to this one is still to come.
    let mut light = (0..9).map(|number| event(&format!("light-{number}"), now(), 10.0, 0.5));
    let ready = light.any(|event| {
        assert!(events.publish(event));
        lines.recv_timeout(Duration::from_secs(3)).is_ok()
    });
    assert!(ready, "no response comes");
    assert!(events.publish(event("e1", now(), MASS, VELOCITY)));
    let status = child.wait().unwrap();
    reading.join().unwrap();
    assert!(status.success(), "{status}");
    assert!(program.terminate().0.success());
}
