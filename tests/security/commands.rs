//! `column-twin keystore` as it is typed.

use std::path::Path;
use std::process::Command;

use super::made::{DAY, Made, today};

/// Exit code, standard output and standard error.
fn typed(folder: &Path, line: &str) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .arg("keystore")
        .args(line.split_whitespace())
        .current_dir(folder)
        .env_remove("ROS_DOMAIN_ID")
        .env_remove("ROS_NAMESPACE")
        // As in a shell that is ready for a keystore that does not exist yet.
        .env("ROS_SECURITY_ENABLE", "true")
        .env("ROS_SECURITY_STRATEGY", "Enforce")
        .env("ROS_SECURITY_KEYSTORE", "keystore")
        .output()
        .expect("runs");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (
        output.status.code().expect("an exit code"),
        text(output.stdout),
        text(output.stderr),
    )
}

fn done(folder: &Path, line: &str) -> String {
    let (code, out, errors) = typed(folder, line);
    assert_eq!((code, errors.as_str()), (0, ""), "{line}: {out}");
    out
}

fn rejected(folder: &Path, line: &str) -> String {
    let (code, out, errors) = typed(folder, line);
    assert_eq!((code, out.as_str()), (2, ""), "{line}: {errors}");
    errors
}

#[test]
fn a_keystore_is_made_extended_shown_and_renewed() {
    let folder = tempfile::tempdir().unwrap();
    let made = done(folder.path(), "create keystore --domain 3,7-9");
    for expected in [
        "for domain 3,7-9",
        "/column_twin",
        "column-twin watch --ros-args --enclave /monitor",
        "ROS_SECURITY_STRATEGY=Enforce",
    ] {
        assert!(made.contains(expected), "{expected}: {made}");
    }
    done(
        folder.path(),
        "add keystore /control_room=monitor --days 20",
    );
    let shown = done(folder.path(), "show keystore");
    for expected in [
        "domains     3,7-9; checked for domain 3",
        "CN=/control_room",
        "CN=/control_room",
        "renew it before then",
        "calls       /column_twin/change_state /column_twin/confirm_estimate /column_twin/correct_damage",
        "offers      /column_twin/change_state /column_twin/confirm_estimate /column_twin/correct_damage",
        "DDS topics  ros_discovery_info",
    ] {
        assert!(shown.contains(expected), "{expected}: {shown}");
    }
    let renewed = done(folder.path(), "renew keystore /control_room");
    assert!(renewed.contains("365 days: /control_room"), "{renewed}");
    let shown = done(folder.path(), "show keystore");
    assert!(!shown.contains("renew it before then"), "{shown}");
    assert!(
        done(folder.path(), "renew keystore --authority").contains("the authority's certificate")
    );
    let policy = done(
        folder.path(),
        "policy --namespace /garage --node-name pillar",
    );
    assert!(
        policy.contains("<enclave path=\"/garage/pillar\">"),
        "{policy}"
    );
}

#[test]
fn show_fails_for_an_enclave_that_no_node_can_use() {
    let made = Made::at(today() - 400 * DAY, 365);
    let folder = made.path();
    let (code, out, errors) = typed(folder.parent().unwrap(), "show keystore");
    assert_eq!(code, 1, "{errors}");
    assert!(out.contains("cert.pem (CN=/monitor) expired on"), "{out}");
    assert!(
        errors.contains("no node can use /column_twin, /monitor, /operator"),
        "{errors}"
    );
    let (code, _, _) = typed(folder.parent().unwrap(), "show keystore --domain 5");
    assert_eq!(code, 1);
}

#[test]
fn show_gives_the_commands_that_sign_edited_documents() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), "create keystore");
    let enclaves = folder.path().join("keystore/enclaves");
    for (edited, command) in [
        ("monitor/permissions.xml", "renew DIR /monitor"),
        ("governance.xml", "renew DIR --authority"),
    ] {
        let path = enclaves.join(edited);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("<dds ", "<!-- edited --><dds ")).unwrap();
        let shown = done(folder.path(), "show keystore");
        let command = format!(": column-twin keystore {command}\n");
        assert!(shown.contains(&command), "{command}: {shown}");
    }
}

#[test]
fn bad_input_is_rejected_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    done(path, "create keystore");
    for (line, expected) in [
        ("create keystore", "choose another folder"),
        ("create other --domain 233", "from 0 to 232"),
        ("create other --days 0", "1 to 36500 days"),
        ("create other --days soon", "invalid value"),
        ("create other --enclave /x", "NAME=monitor"),
        (
            "create other --enclave x=monitor",
            "full name of an enclave",
        ),
        ("create other --namespace garage", "must begin with `/`"),
        ("create other --node-name a/b", "not a valid node name"),
        ("create", "FOLDER"),
        ("add keystore /monitor=monitor", "renew DIR /monitor"),
        (
            "add keystore /new=monitor --days 4000",
            "renew DIR --authority",
        ),
        ("add nowhere /new=monitor", "is not a keystore"),
        ("renew keystore /nobody", "there is no enclave /nobody"),
        ("renew keystore /monitor --authority", "cannot be used with"),
        ("show nowhere", "column-twin keystore create nowhere"),
        ("show keystore --domain 300", "0..=232"),
        ("polish", "unrecognized subcommand"),
    ] {
        let errors = rejected(path, line);
        assert!(
            errors.contains(expected),
            "{line}: expected {expected:?} in {errors}"
        );
    }
    let names: Vec<_> = std::fs::read_dir(path).unwrap().collect();
    assert_eq!(names.len(), 1, "nothing is left behind: {names:?}");
}

#[test]
fn domain_and_namespace_of_the_environment_are_the_default() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(["keystore", "create", "keystore"])
        .current_dir(folder.path())
        .env("ROS_DOMAIN_ID", "42")
        .env("ROS_NAMESPACE", "garage")
        .output()
        .expect("runs");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("for domain 42") && text.contains("/garage/column_twin"),
        "{text}"
    );
}
