//! A fleet with ROS 2 itself. The first run takes a minute or two and needs the network; Python 3.11 is required:
//! `cargo test --release --test fleet -- --ignored`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::domain::Domain;
use super::node::Running;

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// The time is printed: it depends on the machine and its load.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn a_late_rclpy_knows_all_columns_and_their_parameters() {
    const COLUMNS: usize = 1000;
    let environment = Command::new(interop("environment.sh"))
        .stderr(Stdio::inherit())
        .output()
        .expect("a shell");
    assert!(environment.status.success(), "{}", environment.status);
    let environment = String::from_utf8(environment.stdout).expect("a path");
    let domain = Domain::fresh();
    let running = Running::start(&domain, COLUMNS);
    let status = Command::new(Path::new(environment.trim()).join("bin/python"))
        .arg(interop("fleet_with_rclpy.py"))
        .args([&COLUMNS.to_string(), "c3"])
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
        .status()
        .expect("Python");
    assert!(status.success(), "{status}");
    running.node.stop();
}
