//! The node against ROS 2 itself and against a DDS program that knows no ROS. Slow the first time (a minute or two, and
//! network), and only where Python 3.11 is: `cargo test --test ros -- --ignored`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use column_twin::column::Sample;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin::ImpactEvent;
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{Parameters, Value};
use column_twin::ros::bridge::Twin;
use column_twin::ros::{Names, RosoutQueue, TwinNode, rosout_layer};
use tracing_subscriber::Registry;
use tracing_subscriber::layer::SubscriberExt;

use super::domain::Domain;
use super::scripted_twin::{SAMPLE_PERIOD, ScriptedTwin, response};

const MASS: f64 = 1500.0;
const VELOCITY: f64 = 1.0;
const STAMP: i64 = 1_700_000_000_250_000_000;

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// The environment's Python, which is built when there is none.
fn python() -> PathBuf {
    let output = Command::new(interop("environment.sh"))
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert!(output.status.success(), "environment.sh: {}", output.status);
    let environment = String::from_utf8(output.stdout).unwrap();
    Path::new(environment.trim()).join("bin/python")
}

/// Starts a script in the node's domain.
fn script(domain: &Domain, file: &str, expected: Option<&Path>) -> Child {
    Command::new(python())
        .arg(interop(file))
        .args(expected)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for its end, which its own deadlines bound, and shows what it says.
fn finish(mut child: Child) {
    let output = child.stdout.take().unwrap();
    for line in BufReader::new(output).lines() {
        println!("{}", line.unwrap());
    }
    let status = child.wait().unwrap();
    assert!(status.success(), "{status}");
}

const FIELDS: [&str; 8] = [
    "time",
    "v1",
    "u1",
    "beta1",
    "u2",
    "v1_rate",
    "contact_force",
    "ledger_residual",
];

fn fields(sample: &Sample) -> [f64; 8] {
    [
        sample.time,
        sample.v1,
        sample.u1,
        sample.beta1,
        sample.u2,
        sample.v1_rate,
        sample.contact_force,
        sample.ledger_residual,
    ]
}

/// What must come of the event, written by the simulation alone.
fn expectation(folder: &Path) -> PathBuf {
    let (samples, report) = response(&Parameters::default(), MASS, VELOCITY);
    let samples: Vec<_> = samples
        .iter()
        .map(|sample| {
            let moments = sample.hinges.map(|hinge| hinge.moment);
            let forces = sample.hinges.map(|hinge| hinge.normal_force);
            let all = [moments, forces].concat();
            serde_json::json!({ "state": fields(sample), "forces": all })
        })
        .collect();
    let expected = serde_json::json!({
        "mass": MASS, "velocity": VELOCITY, "stamp": STAMP, "period": SAMPLE_PERIOD, "fields": FIELDS, "samples": samples,
        "max_v1": report.max_v1, "residual_v1": report.residual_v1,
    });
    let path = folder.join("expected.json");
    std::fs::write(&path, expected.to_string()).unwrap();
    path
}

fn start(
    domain: &Domain,
    parameters: Parameters,
    log: Option<RosoutQueue>,
) -> (Arc<ScriptedTwin>, TwinNode) {
    let (twin, outputs) = ScriptedTwin::start(parameters);
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let port = Arc::clone(&twin);
    let node = TwinNode::start(&domain.environment, names, port, outputs, log).unwrap();
    (twin, node)
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_finds_receives_sets_and_is_refused() {
    let (layer, log) = rosout_layer();
    tracing::subscriber::set_global_default(Registry::default().with(layer)).unwrap();
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let (_twin, node) = start(&domain, Parameters::default(), Some(log));
    finish(script(&domain, "node_with_rclpy.py", Some(&expected)));
    node.stop(|| {});
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_sets_the_clock() {
    let domain = Domain::fresh();
    let simulated = Parameters::from_values([("use_sim_time", Value::Bool(true))]).unwrap();
    let (_twin, node) = start(&domain, simulated, None);
    finish(script(&domain, "clock_with_rclpy.py", None));
    node.stop(|| {});
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn cyclonedds_without_ros_receives_the_state() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let expected = expectation(folder.path());
    let (twin, node) = start(&domain, Parameters::default(), None);
    let mut child = script(&domain, "state_with_cyclonedds.py", Some(&expected));
    let mut ready = String::new();
    let output = child.stdout.take().unwrap();
    let mut output = BufReader::new(output);
    output.read_line(&mut ready).unwrap();
    assert_eq!(ready.trim(), "ready");
    twin.submit_impact(ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(STAMP).unwrap(),
            frame_id: String::new(),
        },
        mass: MASS,
        velocity: VELOCITY,
        ..ImpactEvent::default()
    })
    .unwrap();
    child.stdout = Some(output.into_inner());
    finish(child);
    node.stop(|| {});
}
