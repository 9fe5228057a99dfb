//! Runs every command of every page of the book (`docs/SUMMARY.md`) as documented, and compares docs/commands.md with the help of the
//! program. A command that is not run here needs an entry below: either another check runs it, or a reason says why it cannot be run.
#![cfg(all(feature = "ros", feature = "record", feature = "viewer"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "ros/domain.rs"]
mod domain;
#[allow(dead_code)] // the tests of the node use more of it
#[path = "ros/program.rs"]
mod program;

use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::Command;

use domain::Domain;
use program::Program;
use tempfile::TempDir;

/// How a command is treated here.
#[derive(Debug, Clone, Copy)]
enum How {
    /// It is run and must end with code 0.
    Ends,
    /// It is run, must print this text, keeps running during the rest of its block, and must end with code 0 after SIGTERM.
    Stays(&'static str),
    /// Another check runs it: the file, and a text that it contains.
    Elsewhere(&'static str, &'static str),
    /// It cannot be run, for this reason.
    Cannot(&'static str),
    /// The name of a command in a sentence.
    Name,
}
use How::{Cannot, Elsewhere, Ends, Name, Stays};

const NEEDS_ROS: &str = "needs an installed ROS 2; tests/interop does the same with rclpy";
const NEEDS_WORKSPACE: &str = "needs an installed ROS 2; tests/interop/build_workspace.sh and launch_files.py do the same with its packages from PyPI";
const COMPILES: &str = "compiles everything again";
const NEEDS_SCREEN: &str =
    "needs a screen; tests/viewer opens such files with the same viewer without one";

/// The commands by their beginning.
const COMMANDS: &[(&str, How)] = &[
    // Run by other checks.
    (
        "cargo run --release -- demo",
        Elsewhere(".ci/run", "demonstrate_in"),
    ),
    (
        "cargo test --release",
        Elsewhere(".ci/run", "cargo test --release\n"),
    ),
    ("cargo build --release --no-default", Cannot(COMPILES)),
    (
        "cargo build --release --features foxglove",
        Cannot(COMPILES),
    ),
    (
        "column-twin run --transport zenoh",
        Elsewhere("tests/interop/zenoh_peer.py", "\"--transport\", \"zenoh\""),
    ),
    (
        "ZENOH_SESSION_CONFIG_URI=",
        Elsewhere("tests/interop/zenoh_access.py", "ZENOH_SESSION_CONFIG_URI"),
    ),
    (
        "zenohd -c",
        Cannot(
            "the router of another project; `tests/interop/zenoh_access.py` starts one from the same configuration",
        ),
    ),
    (
        "column-twin run --ros-args -p foxglove.mode:=serve",
        Elsewhere("tests/foxglove.rs", "foxglove.mode:=serve"),
    ),
    (
        "column-twin replay impact --foxglove",
        Elsewhere("tests/foxglove.rs", "--foxglove="),
    ),
    (
        "cargo build --release",
        Elsewhere(".ci/run", "cargo build --release"),
    ),
    (
        "cargo run --release --no-default-features",
        Cannot(COMPILES),
    ),
    (
        "cargo install --locked --path .",
        Cannot("writes into the home directory"),
    ),
    (
        "cargo bench",
        Cannot("measures, for minutes; its programs compile with the tests"),
    ),
    (
        "colcon build",
        Elsewhere("tests/interop/build_workspace.sh", "colcon"),
    ),
    (
        "venv=$(tests/interop/environment.sh)",
        Elsewhere(".ci/run", "tests/interop/environment.sh"),
    ),
    (
        "\"$venv/bin/python\" tests/interop/check_messages.py",
        Elsewhere(".ci/run", "tests/interop/check_messages.py"),
    ),
    (
        "chromium --headless",
        Elsewhere("tests/report/pages.rs", "--no-pdf-header-footer"),
    ),
    ("idlc -l c", Elsewhere("tests/interop/check_idl.sh", "idlc")),
    (
        "rerun analytics disable",
        Elsewhere("tests/interop/viewer.sh", "analytics disable"),
    ),
    (
        "docs/pictures.sh",
        Elsewhere("tests/viewer/real_viewer.rs", "pictures_of_four_moments"),
    ),
    (".ci/run", Elsewhere(".ci/run", "passed, 0 failed")),
    (
        "apt-get install libssl-dev",
        Elsewhere(".ci/run", "libssl-dev pkg-config"),
    ),
    (
        "export ROS_SECURITY_ENABLE",
        Elsewhere("tests/security/quick_start.rs", "the_quick_start"),
    ),
    (
        "column-twin run --ros-args --enclave",
        Elsewhere("tests/security/quick_start.rs", "the_quick_start"),
    ),
    (
        "openssl",
        Elsewhere(
            "crates/recording/tests/recording/seal_keys.rs",
            "openssl genpkey -algorithm ed25519",
        ),
    ),
    (
        "column-twin verify RECORDING --trusted-key",
        Elsewhere("tests/evidence/sealed.rs", "--trusted-key"),
    ),
    (
        "column-twin measure",
        Elsewhere("tests/ros/measurements.rs", "\"measure\""),
    ),
    (
        "column-twin sensors check",
        Elsewhere("tests/commissioning.rs", "\"sensors\", \"check\""),
    ),
    ("column-twin demo", Elsewhere(".ci/run", "demonstrate_in")),
    (
        "column-twin keystore",
        Elsewhere(
            "tests/security/commands.rs",
            "a_keystore_is_made_extended_shown_and_renewed",
        ),
    ),
    (
        "crates/python/tests/wheels.sh",
        Elsewhere(".ci/run", "crates/python/tests/wheels.sh"),
    ),
    (
        "cargo test --test tidy",
        Elsewhere(".ci/run", "cargo test --release\n"),
    ),
    (
        "podman ",
        Elsewhere(".ci/long", "packaging/check_container.py"),
    ),
    // Cannot be run.
    ("source install/setup.bash", Cannot(NEEDS_WORKSPACE)),
    ("ros2 run column_twin", Cannot(NEEDS_WORKSPACE)),
    ("ros2 launch", Cannot(NEEDS_WORKSPACE)),
    ("ros2 lifecycle", Cannot(NEEDS_ROS)),
    ("ros2 run tf2_ros", Cannot(NEEDS_ROS)),
    ("ros2 bag", Cannot(NEEDS_ROS)),
    ("ros2 topic", Cannot(NEEDS_ROS)),
    ("ros2 service", Cannot(NEEDS_ROS)),
    ("ros2 param", Cannot(NEEDS_ROS)),
    ("ros2 node", Cannot(NEEDS_ROS)),
    (
        "ros2 security",
        Elsewhere("tests/security/permissions.rs", "column_twin.policy.xml"),
    ),
    ("rviz2", Cannot(NEEDS_ROS)),
    (
        "pip install ./",
        Elsewhere(
            "crates/python/tests/wheels.sh",
            "`pip install` as a user does it",
        ),
    ),
    (
        "pip install \"./crates/python",
        Elsewhere(
            "crates/python/tests/wheels.sh",
            "`pip install` as a user does it",
        ),
    ),
    ("pip install rerun-sdk", Cannot(NEEDS_SCREEN)),
    ("ssh -L", Cannot("needs another machine")),
    ("cpupower", Cannot("needs a tool of the kernel, and root")),
    // Parts of commands in sentences.
    ("cargo run --release --", Name),
    ("column-twin simulate --readings FILE", Name),
    ("column-twin estimate --figures FOLDER", Name),
    ("column-twin impact --vehicle mid_car@0.41", Name),
    ("column-twin verify --trusted-key", Name),
    ("column-twin verify --require-seal", Name),
    // Run here.
    ("export ROS_AUTOMATIC_DISCOVERY_RANGE", Ends),
    (
        "column-twin run --config config/heb220_paper.yaml --ros-args -p viewer.mode:=serve",
        Stays("to watch: rerun"),
    ),
    (
        "column-twin alarm test",
        Elsewhere("tests/alarms/main.rs", r#""alarm", "test""#),
    ),
    ("(umask 077; echo", Cannot("writes below /etc")),
    ("curl ", Elsewhere("tests/alarms/main.rs", "GET /metrics")),
    ("column-twin run", Stays("is ready in domain")),
    ("column-twin fleet", Stays("is ready in domain")),
    ("column-twin watch", Stays("watching")),
    ("awk", Ends),
    ("column-twin impact", Ends),
    ("column-twin simulate", Ends),
    ("column-twin risk", Ends),
    ("column-twin map", Ends),
    ("column-twin estimate", Ends),
    ("cargo run --release -- simulate", Ends),
    ("column-twin replay RECORDING --clock", Ends),
    ("column-twin replay", Ends),
    ("column-twin verify", Ends),
    ("column-twin info", Ends),
    ("column-twin report", Ends),
    ("column-twin repair", Ends),
    ("column-twin export", Ends),
    ("column-twin idl", Ends),
    (
        "column-twin SUBCOMMAND --help",
        Elsewhere(
            "tests/documented_commands.rs",
            "every_help_shows_an_example",
        ),
    ),
];

fn how(command: &str) -> How {
    find(command).unwrap_or_else(|| {
        panic!("`{command}` is documented and not run: add it to tests/documented_commands.rs")
    })
}

/// How a command is treated; `None` if the table does not say.
fn find(command: &str) -> Option<How> {
    // `column-twin verify` in a sentence is a name.
    if command.split(' ').count() < 3
        && ["column-twin", "rerun", "ros2 bag"]
            .iter()
            .any(|it| command.starts_with(it))
    {
        let is_whole =
            ["column-twin run", "column-twin watch", "column-twin idl"].contains(&command);
        if !is_whole {
            return Some(Name);
        }
    }
    let found = COMMANDS
        .iter()
        .filter(|(begins, _)| command.starts_with(begins));
    let longest = found.max_by_key(|(begins, _)| begins.len());
    longest.map(|(_, how)| *how)
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The commands of a document: those of each code block in order, then each of those in sentences.
fn blocks(document: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join(document)).expect("a document");
    let mut blocks = Vec::new();
    let mut sentences = String::new();
    for (index, part) in text.split("```").enumerate() {
        match (index % 2, part.strip_prefix("sh\n")) {
            (0, _) => sentences.push_str(part),
            (_, Some(block)) => {
                let lines = block.replace("\\\n", "");
                let commands = lines.lines().map(|line| {
                    let command = line.split_once("  #").map_or(line, |(command, _)| command);
                    command.split_whitespace().collect::<Vec<_>>().join(" ")
                });
                blocks.push(commands.filter(|it| !it.is_empty()).collect());
            }
            _ => {}
        }
    }
    const PROGRAMS: [&str; 10] = [
        "column-twin ",
        "cargo ",
        "ros2 ",
        "rviz2 ",
        "rerun ",
        "pip ",
        "ssh ",
        "idlc ",
        "cpupower ",
        "docs/pictures.sh",
    ];
    let quoted = sentences.split('`').skip(1).step_by(2);
    let commands = quoted.filter(|it| PROGRAMS.iter().any(|program| it.starts_with(program)));
    blocks.extend(commands.map(|it| vec![it.split_whitespace().collect::<Vec<_>>().join(" ")]));
    blocks
}

/// What `openssl genpkey -algorithm ed25519` writes.
const SEAL_KEY: &str = "\
-----BEGIN PRIVATE KEY-----
MC4CAQAwBQYDK2VwBCIEIGrJEbjRgeB96JKCHzdL3tOtD6suGiIer9pIoWzHeQC5
-----END PRIVATE KEY-----
";

/// The recording that docs/fleet.md verifies.
const RECORDING_OF_A_FLEET: &str =
    "~/.local/state/column_twin/recordings/column_twin_2026_11_21-07_40_00";

/// A folder as a reader of the documents would have it: the files, and the programs in the PATH.
struct Place {
    folder: TempDir,
    viewer_port: u16,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let link =
            |to: PathBuf, name: &str| std::os::unix::fs::symlink(to, at(name)).expect("a link");
        link(root().join("config"), "config");
        // The column of the reader.
        link(root().join("config/heb220_s355.yaml"), "FILE");
        let column = std::fs::read_to_string(at("config/heb220_s355.yaml")).expect("there");
        for name in ["a1", "a2"] {
            let column = column.replace("column_id: heb220_s355", &format!("column_id: {name}"));
            std::fs::write(at(&format!("{name}.yaml")), column).expect("written");
        }
        std::fs::write(at("seal_key.pem"), SEAL_KEY).expect("written");
        std::fs::create_dir(at("bin")).expect("a folder");
        link(env!("CARGO_BIN_EXE_column-twin").into(), "bin/column-twin");
        // The real viewer opens a window; here it is enough that the file exists. tests/viewer opens it.
        std::fs::write(at("bin/rerun"), "#!/bin/sh\ntest -s \"$1\"\n").expect("written");
        let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(at("bin/rerun"), executable).expect("executable");
        let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let viewer_port = free.local_addr().expect("its address").port();
        let place = Self {
            folder,
            viewer_port,
        };
        let domain = Domain::fresh();
        let mut made = place.shell(&domain, "column-twin simulate --record RECORDING");
        assert!(made.status().expect("runs").success());
        place
    }

    /// Leaves one recording of a fleet, in which the column a3 was hit.
    fn record_a_fleet(&self) {
        let domain = Domain::fresh();
        let fleet = "column-twin fleet --params-file config/fleet.yaml --ros-args -p record.mode:=events 1>&2";
        let shell = self.shell(&domain, fleet);
        let mut running = Program::spawn(&domain, self.folder.path(), shell);
        running.wait_for("is ready in domain");
        let hit = "column-twin impact --column a3 --mass 1500 --velocity 5";
        let hit = self.shell(&domain, hit).output().expect("runs");
        assert!(
            hit.status.success(),
            "{}",
            String::from_utf8_lossy(&hit.stderr)
        );
        running.wait_for("result of impact");
        let (status, _, log) = running.terminate();
        assert!(status.success(), "{log:#?}");
        let [made, kept] =
            ["column_twin/recordings", "FLEET"].map(|name| self.folder.path().join(name));
        std::fs::rename(made, kept).expect("a recording");
    }

    /// A command of the document, with writable paths and a free port.
    fn shell(&self, domain: &Domain, command: &str) -> Command {
        let command = command
            // The program that `cargo run` would run.
            .replace("cargo run --release --", "column-twin")
            .replace("FOLDER", "recorded")
            .replace(RECORDING_OF_A_FLEET, "FLEET/*")
            .replace("/var/lib/column_twin", "var")
            .replace(
                "viewer.mode:=serve",
                &format!("viewer.mode:=serve -p viewer.port:={}", self.viewer_port),
            );
        let path = std::env::var("PATH").unwrap_or_default();
        let mut shell = Command::new("sh");
        shell
            .args([
                "-c",
                &format!(
                    "{}{command}",
                    if command.contains("&&") { "" } else { "exec " }
                ),
            ])
            .current_dir(self.folder.path())
            .env(
                "PATH",
                format!("{}:{path}", self.folder.path().join("bin").display()),
            )
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env("XDG_STATE_HOME", self.folder.path())
            .env_remove("ROS_NAMESPACE");
        shell
    }
}

/// Runs the commands of a document, and returns what failed.
fn faults_of(document: &str) -> Vec<String> {
    let place = Place::new();
    if document == "docs/fleet.md" {
        place.record_a_fleet();
    }
    let mut failed = Vec::new();
    for block in blocks(document) {
        let domain = Domain::fresh();
        let mut staying = Vec::new();
        for command in block {
            let how = how(&command);
            println!("{document}: {command}: {how:?}");
            match how {
                Ends if command.starts_with("export ") => {} // set for every command here
                Ends => {
                    let output = place.shell(&domain, &command).output().expect("runs");
                    let errors = String::from_utf8_lossy(&output.stderr);
                    if !output.status.success() {
                        failed.push(format!(
                            "{document}: `{command}` ends with {}: {errors}",
                            output.status
                        ));
                    }
                }
                Stays(says) => {
                    let shell = place.shell(&domain, &format!("{command} 1>&2"));
                    let mut program = Program::spawn(&domain, place.folder.path(), shell);
                    program.wait_for(says);
                    staying.push((command, program));
                }
                Elsewhere(file, text) => {
                    let content = std::fs::read_to_string(root().join(file)).expect(file);
                    assert!(
                        content.contains(text),
                        "`{command}`: {file} has no {text:?}"
                    );
                }
                Cannot(why) => assert!(!why.is_empty()),
                Name => {}
            }
        }
        for (command, program) in staying.into_iter().rev() {
            let (status, _, log) = program.terminate();
            assert!(status.success(), "`{command}` ends with {status}: {log:#?}");
        }
    }
    failed
}

fn run_all_of(document: &str) {
    let faults = faults_of(document);
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn every_command_of_the_readme_is_run() {
    run_all_of("README.md");
}

#[test]
fn every_command_of_the_guide_is_run() {
    run_all_of("docs/guide.md");
}

#[test]
fn every_command_of_the_launch_notes_is_run() {
    run_all_of("launch_notes.md");
}

#[test]
fn every_command_of_the_studies_is_run() {
    run_all_of("docs/study.md");
}

/// The pages of the book, by their paths in the repository.
fn pages() -> Vec<String> {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).expect("the contents");
    let links = summary.split("](").skip(1);
    let pages = links.filter_map(|it| it.split_once(')')).map(|(link, _)| {
        link.strip_prefix("../")
            .map_or_else(|| format!("docs/{link}"), str::to_owned)
    });
    pages.collect()
}

/// The pages with a test of their own, above.
const APART: [&str; 4] = [
    "README.md",
    "docs/guide.md",
    "launch_notes.md",
    "docs/study.md",
];

/// The pages that are no instructions: the history, the help, and docstrings.
const NO_INSTRUCTIONS: [&str; 3] = [
    "CHANGELOG.md",
    "docs/commands.md",
    "docs/python_reference.md",
];

/// The pages whose commands are run.
fn instructions() -> Vec<String> {
    let mut pages = pages();
    pages.retain(|page| !NO_INSTRUCTIONS.contains(&page.as_str()));
    assert!(pages.len() > 20, "{pages:?}");
    pages
}

#[test]
fn every_command_of_the_other_pages_is_run() {
    let pages = instructions();
    let others = pages.iter().filter(|it| !APART.contains(&it.as_str()));
    let faults: Vec<_> = others.flat_map(|page| faults_of(page)).collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Most commands that no check runs, with their reasons in the table above: the tools of an installed ROS 2, long builds and benchmarks.
const MOST_NOT_RUN: usize = 78;

#[test]
fn the_commands_that_no_check_runs_are_counted() {
    let mut counts = [0; 4];
    let (mut not_run, mut unknown) = (Vec::new(), Vec::new());
    for page in &instructions() {
        for command in blocks(page).into_iter().flatten() {
            let Some(how) = find(&command) else {
                unknown.push(format!("{page}: {command}"));
                continue;
            };
            let (slot, reason) = match how {
                Ends | Stays(_) => (0, ""),
                Elsewhere(..) => (1, ""),
                Cannot(reason) => (2, reason),
                Name => (3, ""),
            };
            counts[slot] += 1;
            if slot == 2 {
                not_run.push(format!("{page}: {command}: {reason}"));
            }
        }
    }
    assert!(
        unknown.is_empty(),
        "neither run nor in the table: {unknown:#?}"
    );
    let [here, elsewhere, cannot, names] = counts;
    println!("{here} commands run here, {elsewhere} elsewhere, {cannot} nowhere; {names} names");
    assert!(cannot <= MOST_NOT_RUN, "{cannot}: {not_run:#?}");
    let own: Vec<_> = not_run
        .iter()
        .filter(|it| it.contains(": column-twin "))
        .collect();
    assert!(own.is_empty(), "the program can always be run: {own:#?}");
}

fn help(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments)
        .env_remove("COLUMNS")
        .output();
    String::from_utf8(output.expect("runs").stdout).expect("text")
}

/// The names of the commands.
fn commands() -> Vec<String> {
    let all = help(&["--help"]);
    let listed = all.split_once("Commands:").expect("a list").1;
    let listed = listed.split("\n\n").next().expect("a list");
    let lines = listed
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("    "));
    let names: Vec<_> = lines
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect();
    assert!(names.len() >= 11, "{names:?}");
    names
}

const COMMANDS_PAGE: &str = "\
# Commands and exit codes

This page is generated from the help of the program; do not edit it.
`column-twin SUBCOMMAND --help` prints the same text.

## Exit codes

0 means done: a collapse of the column is a result and no error.
1 means failed, 2 bad input or usage, and 3 done in part: data were lost, the command was interrupted, or a part could not be computed or verified.
The table states the meaning for each command.

";

#[test]
fn the_page_of_the_commands_is_up_to_date() {
    let mut codes = "| command | exit codes |\n|---|---|\n".to_owned();
    let mut texts = format!(
        "\n## column-twin\n\n```text\n{}\n```\n",
        help(&["--help"]).trim()
    );
    for name in commands() {
        let text = help(&[&name, "--help"]);
        let ends = text.split_once("Exit codes: ").expect("exit codes").1;
        let ends = ends.split_whitespace().collect::<Vec<_>>().join(" ");
        codes += &format!("| [`{name}`](#column-twin-{name}) | {ends} |\n");
        let lines: Vec<_> = text.trim().lines().map(str::trim_end).collect();
        texts += &format!(
            "\n## column-twin {name}\n\n```text\n{}\n```\n",
            lines.join("\n")
        );
    }
    let page = format!("{COMMANDS_PAGE}{codes}{texts}");
    let path = root().join("docs/commands.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).expect("the page can be written");
    }
    assert!(
        std::fs::read_to_string(&path).unwrap_or_default() == page,
        "docs/commands.md differs from the help; update it with\n    UPDATE_DOCS=1 cargo test --release --test documented_commands"
    );
}

#[test]
fn every_help_shows_an_example() {
    for name in commands() {
        let text = help(&[&name, "--help"]);
        assert!(text.contains("Example"), "{name}: {text}");
        assert!(
            text.contains(&format!("column-twin {name}")),
            "{name}: {text}"
        );
    }
}
