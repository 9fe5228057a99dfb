//! The commands of docs/security.md, as a user types them.

use std::path::Path;
use std::process::{Command, Output};

use super::domain::Domain;
use super::program::Program;

/// The commands of every code block.
fn blocks() -> Vec<Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/security.md")).expect("the document");
    let command = |line: &str| {
        let command = line.split("  #").next().unwrap_or_default();
        command.trim().to_owned()
    };
    let commands = |block: &str| {
        let lines = block.strip_prefix("sh\n").expect("shell").lines();
        lines.map(command).collect()
    };
    text.split("```").skip(1).step_by(2).map(commands).collect()
}

/// The beginnings of commands that are not run here, and why.
const ELSEWHERE: [(&str, &str); 3] = [
    ("apt-get install ", ".ci/run installs the packages"),
    ("cargo build ", "it compiles everything again"),
    (
        "ros2 security ",
        "it needs an installed ROS 2; another test compares what it makes of the policy",
    ),
];

/// The beginnings of the commands of the quick start, which has a test of its own.
const QUICK_START: [&str; 4] = [
    "export ",
    "column-twin run ",
    "column-twin watch ",
    "column-twin impact ",
];

#[test]
fn every_command_about_keystores_in_the_documentation_works() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = 0;
    for command in blocks().into_iter().flatten() {
        if !command.starts_with("column-twin keystore ") {
            let mut known = ELSEWHERE
                .iter()
                .map(|(begins, _)| *begins)
                .chain(QUICK_START);
            assert!(
                known.any(|begins| command.starts_with(begins)),
                "`{command}` is documented and not run"
            );
            continue;
        }
        let line = command.replacen("column-twin", env!("CARGO_BIN_EXE_column-twin"), 1);
        let output = Command::new("sh")
            .args(["-c", &line])
            .current_dir(folder.path())
            .output()
            .expect("runs");
        assert!(output.status.success(), "{command}: {output:?}");
        run += 1;
    }
    assert!(run >= 9, "{run}");
}

#[test]
fn the_quick_start_of_the_documentation_works_as_written() {
    let blocks = blocks();
    let commands = blocks
        .iter()
        .find(|block| block[0].contains("keystore create"));
    let Some([create, export, run, watch, impact]) = commands.map(Vec::as_slice) else {
        panic!("expected five commands: {commands:#?}");
    };
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::os::unix::fs::symlink(root.join("config"), folder.path().join("config")).unwrap();
    let program = env!("CARGO_BIN_EXE_column-twin");
    // The second line comes before each, and `exec` so that the program itself receives the signal that ends it.
    let shell = |command: &str, is_secured: bool| {
        let export = if is_secured { export.as_str() } else { "true" };
        let command = command.replacen("column-twin", program, 1);
        let mut shell = Command::new("sh");
        shell
            .args(["-c", &format!("{export} && exec {command} 1>&2")])
            .current_dir(folder.path())
            .env("XDG_STATE_HOME", folder.path())
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        shell
    };
    let output = |command: &str| -> Output { shell(command, true).output().expect("runs") };
    let text = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();

    let made = output(create);
    assert!(made.status.success(), "{made:?}");
    let mut twin = Program::spawn(&domain, folder.path(), shell(run, true));
    twin.wait_for("is ready in domain");
    let mut monitor = Program::spawn(&domain, folder.path(), shell(watch, true));
    monitor.wait_for("watching");
    let mut stranger = Program::spawn(&domain, folder.path(), shell("column-twin watch", false));
    stranger.wait_for("watching");

    let answered = output(impact);
    assert!(answered.status.success(), "{}", text(&answered));
    assert!(text(&answered).contains("forecast"), "{}", text(&answered));
    monitor.wait_for("forecast");

    let rejected = output(&impact.replace("/operator", "/monitor"));
    assert_eq!(rejected.status.code(), Some(1), "{}", text(&rejected));
    let forgotten = output(&watch.replace("--ros-args --enclave /monitor", ""));
    assert_eq!(forgotten.status.code(), Some(2));
    assert!(
        text(&forgotten).contains("Choose an enclave of the keystore with --ros-args --enclave"),
        "{}",
        text(&forgotten)
    );
    let (status, _, log) = stranger.terminate();
    assert!(status.success());
    assert!(
        !log.iter().any(|line| line.contains("forecast")),
        "{log:#?}"
    );
    assert!(monitor.terminate().0.success());
    let (status, _, log) = twin.terminate();
    assert!(status.success());
    for joined in ["CN=/monitor", "CN=/operator"] {
        assert!(
            log.iter().any(|line| line.contains(joined)),
            "{joined}: {log:#?}"
        );
    }
    let accepted = log.iter().filter(|line| line.contains("accepted")).count();
    assert_eq!(accepted, 1, "{log:#?}");
}
