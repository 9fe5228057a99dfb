//! `--transport zenoh`: what cannot be used is an error at the start. A peer of another make is in `tests/interop/zenoh_peer.py`.
#![cfg(all(feature = "cli", feature = "ros"))]

use std::process::{Command, Output};

/// A command that cannot start; nothing is opened.
fn run(command: &[&str], variables: &[(&str, &str)]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(command)
        .args(["--transport", "zenoh"])
        .env_remove("ROS_SECURITY_ENABLE")
        .env_remove("ZENOH_CONFIG_OVERRIDE")
        .env("ZENOH_SESSION_CONFIG_URI", "/nowhere/session.json5")
        .envs(variables.iter().copied())
        .output()
        .expect("the program that was built with this test")
}

const COMMANDS: [&[&str]; 3] = [&["run"], &["watch"], &["impact", "--velocity", "1"]];

fn check(end: &Output, expected: &str) {
    let text = String::from_utf8_lossy(&end.stderr).into_owned();
    assert_eq!(end.status.code(), Some(2), "{text}");
    assert!(text.contains(expected), "{text}");
}

#[test]
fn security_of_dds_that_would_not_protect_is_rejected() {
    for command in COMMANDS {
        let end = run(command, &[("ROS_SECURITY_ENABLE", "true")]);
        check(&end, "DDS security, which does not protect Zenoh");
    }
}

#[cfg(not(feature = "zenoh"))]
#[test]
fn a_program_without_zenoh_says_how_to_build_it() {
    for command in COMMANDS {
        check(&run(command, &[]), "build it with the feature `zenoh`");
    }
}

#[cfg(feature = "zenoh")]
#[test]
fn a_configuration_that_is_none_is_named() {
    for command in COMMANDS {
        let expected = "ZENOH_SESSION_CONFIG_URI: expected";
        check(&run(command, &[]), expected);
        let no_configuration = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
        let variables = [("ZENOH_SESSION_CONFIG_URI", no_configuration)];
        check(&run(command, &variables), expected);
        let variables = [
            ("ZENOH_SESSION_CONFIG_URI", ""),
            ("ZENOH_CONFIG_OVERRIDE", "no/such/key=1"),
        ];
        check(&run(command, &variables), "ZENOH_CONFIG_OVERRIDE: expected");
    }
}
