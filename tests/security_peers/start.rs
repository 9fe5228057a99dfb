//! How the program starts in every case of `ROS_SECURITY_*`.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

use sros2_keystore::STRICT_FILES;

use super::by_openssl::{Keystore, RECOMMENDED};
use super::domain::Domain;
use super::program::Program;

/// `column-twin run` with these variables and ROS arguments.
fn command(variables: &[(&str, &str)], arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    for name in [
        "ROS_SECURITY_ENABLE",
        "ROS_SECURITY_STRATEGY",
        "ROS_SECURITY_KEYSTORE",
        "ROS_SECURITY_ENCLAVE_OVERRIDE",
    ] {
        command.env_remove(name);
    }
    command
        .args(["run", "--ros-args", "-p", "state.directory:=''"])
        .args(arguments)
        .envs(variables.iter().copied());
    command
}

/// The exit code and the log of a program that does not start.
pub fn rejected(domain: &Domain, variables: &[(&str, &str)], arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let program = Program::spawn(domain, folder.path(), command(variables, arguments));
    let (status, log) = program.end();
    assert_eq!(status.code(), Some(2), "{log:#?}");
    let written: Vec<_> = folder.path().read_dir().unwrap().collect();
    assert!(written.is_empty(), "{written:?}");
    log.join("\n")
}

/// The log of a program that starts, and is stopped as soon as it is ready.
fn started(domain: &Domain, variables: &[(&str, &str)], arguments: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut program = Program::spawn(domain, folder.path(), command(variables, arguments));
    program.wait_for("is ready in domain");
    let (status, _, log) = program.terminate();
    assert!(status.success(), "{log:#?}");
    log.join("\n")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

#[test]
fn enforced_security_without_an_enclave_does_not_start_and_permissive_warns() {
    let (domain, keystore) = (Domain::fresh(), Keystore::new());
    keystore.write(&keystore.unrestricted("/column_twin", &RECOMMENDED));
    let enable = ("ROS_SECURITY_ENABLE", "true");
    let enforce = ("ROS_SECURITY_STRATEGY", "Enforce");
    let path = ("ROS_SECURITY_KEYSTORE", text(keystore.path()));
    let nobody = ["--enclave", "/nobody"];
    let words = format!(
        "SECURITY ERROR: directory '{}/enclaves/nobody' does not exist.",
        keystore.path().display()
    );
    let log = rejected(&domain, &[enable, enforce, path], &nobody);
    assert!(log.contains(&words), "{log}");
    let log = started(&domain, &[enable, path], &nobody);
    assert!(
        log.contains("[WARN]") && log.contains("neither signed nor encrypted"),
        "{log}"
    );
    // The default enclave is the root, which has no files here.
    let log = rejected(&domain, &[enable, enforce, path], &[]);
    assert!(
        log.contains("contains none of the files of an enclave"),
        "{log}"
    );
    let log = rejected(&domain, &[enable, enforce], &[]);
    assert!(log.contains("ROS_SECURITY_KEYSTORE is not set"), "{log}");
    // Security is off: the other variables have no effect, which the node says, unlike rcl.
    let log = started(&domain, &[enforce, path], &nobody);
    assert!(log.contains("Enforce has no effect without"), "{log}");
    let misspelt = ("ROS_SECURITY_ENABLE", "True");
    let log = started(&domain, &[misspelt, enforce, path], &nobody);
    assert!(
        log.contains("[WARN]") && log.contains("found `True`"),
        "{log}"
    );
    let log = started(&domain, &[path], &nobody);
    assert!(!log.contains("security"), "{log}");
}

#[test]
fn a_node_in_its_enclave_says_how_it_is_protected() {
    let (domain, keystore) = (Domain::fresh(), Keystore::new());
    keystore.write(&keystore.unrestricted("/column_twin", &RECOMMENDED));
    let variables = [
        ("ROS_SECURITY_ENABLE", "true"),
        ("ROS_SECURITY_STRATEGY", "Enforce"),
        ("ROS_SECURITY_KEYSTORE", text(keystore.path())),
        ("ROS_SECURITY_ENCLAVE_OVERRIDE", "/column_twin"),
    ];
    let log = started(&domain, &variables, &["--enclave", "/nobody"]);
    for words in [
        "DDS security: enclave /column_twin (CN=/column_twin)",
        "rtps SIGN, discovery ENCRYPT, liveliness ENCRYPT, metadata ENCRYPT, data NONE",
        "expires first, on",
    ] {
        assert!(log.contains(words), "{log}");
    }
    assert!(!log.contains("[WARN]"), "{log}");
}

#[test]
fn broken_files_are_rejected_whatever_the_strategy() {
    let (domain, keystore) = (Domain::fresh(), Keystore::new());
    let mut enclave = keystore.unrestricted("/column_twin", &RECOMMENDED);
    enclave.key = keystore.authority.key.private_key_to_pem_pkcs8().unwrap();
    keystore.write(&enclave);
    for strategy in ["Enforce", "Permissive"] {
        let variables = [
            ("ROS_SECURITY_ENABLE", "true"),
            ("ROS_SECURITY_STRATEGY", strategy),
            ("ROS_SECURITY_KEYSTORE", text(keystore.path())),
        ];
        let log = rejected(&domain, &variables, &["--enclave", "/column_twin"]);
        assert!(
            log.contains("key.pem is not the private key of cert.pem"),
            "{strategy}: {log}"
        );
    }
}

#[test]
fn every_command_that_opens_a_participant_enforces_security() {
    let folder = tempfile::tempdir().unwrap();
    let keystore = text(folder.path());
    for arguments in [
        &["impact", "--mass", "1500", "--velocity", "1"][..],
        &["watch"],
        &["replay", "bag"],
        &["run"],
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
            .args(arguments)
            .args(["--ros-args", "-e", "/nobody"])
            .current_dir(&folder)
            .env("ROS_SECURITY_ENABLE", "true")
            .env("ROS_SECURITY_STRATEGY", "Enforce")
            .env("ROS_SECURITY_KEYSTORE", keystore)
            .env_remove("ROS_SECURITY_ENCLAVE_OVERRIDE")
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains("/enclaves/nobody' does not exist."),
            "{arguments:?}: {error}"
        );
    }
}

/// A keystore of SROS 2 has keys of mode 0644, and must work unchanged; one of ours demands better.
#[test]
fn a_key_that_others_can_read_is_a_warning_and_rejected_where_the_keystore_demands_it() {
    let (domain, keystore) = (Domain::fresh(), Keystore::new());
    let folder = keystore.write(&keystore.unrestricted("/column_twin", &RECOMMENDED));
    let open = std::fs::Permissions::from_mode(0o644);
    std::fs::set_permissions(folder.join("key.pem"), open).unwrap();
    let variables = [
        ("ROS_SECURITY_ENABLE", "true"),
        ("ROS_SECURITY_STRATEGY", "Enforce"),
        ("ROS_SECURITY_KEYSTORE", text(keystore.path())),
    ];
    let arguments = ["--enclave", "/column_twin"];
    let log = started(&domain, &variables, &arguments);
    assert!(log.contains("restrict it with: chmod 600"), "{log}");
    std::fs::write(keystore.path().join(STRICT_FILES), "").unwrap();
    let log = rejected(&domain, &variables, &arguments);
    for part in ["mode 644", "chmod 600", STRICT_FILES] {
        assert!(log.contains(part), "{log}");
    }
}
