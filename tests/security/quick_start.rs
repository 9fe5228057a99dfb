//! The quick start of docs/security.md, as a user types it.

use std::path::Path;
use std::process::{Command, Output};

use super::domain::Domain;
use super::program::Program;

/// The commands of the first code block after this heading.
fn commands(heading: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/security.md")).expect("the document");
    let (_, section) = text.split_once(heading).expect(heading);
    let block = section.split("```").nth(1).expect("a code block");
    let lines = block.strip_prefix("sh\n").expect("shell").lines();
    lines
        .map(|line| {
            line.split("  #")
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned()
        })
        .collect()
}

#[test]
fn the_quick_start_of_the_documentation_works_as_written() {
    let commands = commands("## Quick start");
    let [create, export, run, watch, impact] = commands.as_slice() else {
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

    let refused = output(&impact.replace("/operator", "/monitor"));
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused));
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
