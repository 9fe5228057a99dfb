//! The definitions and the golden data agree with an installed ROS 2, Jazzy and Kilted. Slow the first time (a few minutes, and
//! network), and only where Python 3.11 is: `cargo test --test messages -- --ignored`.

use std::path::Path;
use std::process::{Command, Stdio};

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rosidl_rclpy_and_rosbags_of_jazzy_agree_with_the_golden_data() {
    check_messages("jazzy", &[]);
}

#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn rosidl_rclpy_and_rosbags_of_kilted_agree_with_the_golden_data() {
    check_messages("kilted", &["--kilted"]);
}

fn check_messages(distribution: &str, arguments: &[&str]) {
    let interop = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop");
    let environment = Command::new(interop.join("environment.sh"))
        .arg(distribution)
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert!(
        environment.status.success(),
        "environment.sh: {}",
        environment.status
    );
    let environment = String::from_utf8(environment.stdout).unwrap();
    let check = Command::new(Path::new(environment.trim()).join("bin/python"))
        .arg(interop.join("check_messages.py"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        check.status.success(),
        "{}",
        String::from_utf8_lossy(&check.stderr)
    );
}
