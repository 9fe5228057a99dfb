//! A fleet with ROS 2 itself. The first run takes a minute or two and needs the network; Python 3.11 is required:
//! `cargo test --release --test fleet -- --ignored`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::column_topics;
use super::domain::Domain;
use super::node::Running;

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// Lets Python run a file of tests/interop in a domain.
fn python(domain: &Domain, file: &str, arguments: &[&str]) {
    let environment = Command::new(interop("environment.sh"))
        .stderr(Stdio::inherit())
        .output()
        .expect("a shell");
    assert!(environment.status.success(), "{}", environment.status);
    let environment = String::from_utf8(environment.stdout).expect("a path");
    let status = Command::new(Path::new(environment.trim()).join("bin/python"))
        .arg(interop(file))
        .args(arguments)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
        .status()
        .expect("Python");
    assert!(status.success(), "{status}");
}

/// The time is printed: it depends on the machine and its load.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn a_late_rclpy_knows_all_columns_and_their_parameters() {
    const COLUMNS: usize = 1000;
    let domain = Domain::fresh();
    let running = Running::start(&domain, COLUMNS);
    let arguments = [&*COLUMNS.to_string(), "c3"];
    python(&domain, "fleet_with_rclpy.py", &arguments);
    running.node.stop();
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rclpy_finds_the_topics_of_a_column_as_long_as_it_listens() {
    let domain = Domain::fresh();
    let running = column_topics::start(&domain, 5);
    python(&domain, "column_topics_with_rclpy.py", &["/hall/c3", "c3"]);
    running.node.stop();
}
