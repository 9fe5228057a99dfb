//! The program as a shell and its user meet it: signals, pipes, links and devices.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod program;

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use program::{interrupt, program, run};

/// A heavy and slow vehicle: contact lasts a third of a second, and its history takes many seconds to write.
const LONG: [&str; 10] = [
    "-p",
    "solver.dt:=2.0e-7",
    "-p",
    "shear.model:=none",
    "--mass",
    "1e6",
    "--velocity",
    "0.04",
    "--csv",
    "history.csv",
];

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name())
        .map(|name| name.into_string().expect("a plain name"))
        .collect();
    names.sort();
    names
}

/// Bytes that a process has handed to the system to write.
fn written(child: &Child) -> u64 {
    let counts = fs::read_to_string(format!("/proc/{}/io", child.id())).unwrap_or_default();
    let line = counts.lines().find_map(|line| line.strip_prefix("wchar: "));
    line.and_then(|count| count.parse().ok()).unwrap_or(0)
}

#[test]
fn ctrl_c_while_a_history_is_written_leaves_no_partial_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut arguments = vec!["simulate"];
    arguments.extend(LONG);
    let mut child = program(folder.path(), &arguments)
        .stdout(Stdio::null())
        .spawn()
        .expect("the program");
    while written(&child) < 100_000 {
        assert!(child.try_wait().expect("a child").is_none());
        std::thread::yield_now();
    }
    interrupt(&child);
    assert!(!child.wait().expect("a child").success());
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_history_into_a_pipe_that_head_closes_is_no_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    for target in ["-", "/dev/stdout", "/proc/self/fd/1"] {
        let mut child = program(folder.path(), &["simulate", "--csv", target])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut reader = BufReader::new(child.stdout.take().expect("piped"));
        let mut header = String::new();
        reader.read_line(&mut header).expect("a header");
        assert!(header.starts_with("t_s,"), "{target}: {header}");
        drop(reader);
        let ended = child.wait_with_output().expect("a child");
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(0), "{target}: {errors}");
        // The summary is there, and no complaint.
        assert!(
            errors.contains("Residual") || errors.contains("residual"),
            "{errors}"
        );
        assert!(!errors.contains("Broken pipe"), "{errors}");
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_history_is_written_to_dev_stdout_as_to_a_minus() {
    let folder = tempfile::tempdir().expect("a folder");
    let [minus, device] = ["-", "/dev/stdout"].map(|target| {
        let ended = run(folder.path(), &["simulate", "--csv", target]);
        assert!(ended.status.success());
        ended.stdout
    });
    assert!(minus.starts_with(b"t_s,") && minus == device);
}

#[test]
fn a_history_is_written_into_a_pipe_with_a_name_and_through_a_link() {
    let folder = tempfile::tempdir().expect("a folder");
    let inside = |name: &str| folder.path().join(name);
    assert!(
        run(folder.path(), &["simulate", "--csv", "plain.csv"])
            .status
            .success()
    );
    let plain = fs::read(inside("plain.csv")).expect("a history");

    symlink("target.csv", inside("link.csv")).expect("a link");
    assert!(
        run(folder.path(), &["simulate", "--csv", "link.csv"])
            .status
            .success()
    );
    assert!(inside("link.csv").is_symlink());
    assert!(fs::read(inside("target.csv")).expect("a history") == plain);

    let made = Command::new("mkfifo").arg(inside("pipe")).status();
    assert!(made.expect("mkfifo").success());
    let mut child = program(folder.path(), &["simulate", "--csv", "pipe"])
        .stdout(Stdio::null())
        .spawn()
        .expect("the program");
    let mut piped = Vec::new();
    fs::File::open(inside("pipe"))
        .and_then(|mut pipe| pipe.read_to_end(&mut piped))
        .expect("a history");
    assert!(child.wait().expect("a child").success());
    assert!(piped == plain);
    assert_eq!(
        names(folder.path()),
        ["link.csv", "pipe", "plain.csv", "target.csv"]
    );
}

#[cfg(feature = "record")]
#[test]
fn a_record_stamp_that_no_ros_stamp_can_hold_is_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    for stamp in ["nan", "inf", "-1", "2147483648", "today"] {
        let stamp = format!("--record-stamp={stamp}");
        let ended = run(folder.path(), &["simulate", "--record", "bag", &stamp]);
        assert_eq!(ended.status.code(), Some(2), "{stamp}");
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert!(errors.contains("expected a time from 0"), "{errors}");
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

/// Only the demonstration itself gets the signal, and not its children, as from `kill` and unlike from a terminal.
#[cfg(all(feature = "ros", feature = "record"))]
#[test]
fn a_signal_to_the_demonstration_alone_is_not_ignored() {
    // While the node starts; during the last work before the figures; while the readings are played.
    let cases: [(&[&str], &str); 3] = [
        (&["demo"], "Node started"),
        (&["demo"], "absorbed by the vehicle"),
        (&["demo", "--sensors"], "Sensors started"),
    ];
    for (arguments, line_before) in cases {
        let folder = tempfile::tempdir().expect("a folder");
        let mut child = program(folder.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let found = lines.by_ref().map_while(Result::ok);
        assert!(found.into_iter().any(|line| line.contains(line_before)));
        interrupt(&child);
        assert!(
            lines
                .map_while(Result::ok)
                .all(|line| !line.contains("Finished"))
        );
        let ended = child.wait_with_output().expect("a child");
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(1), "{line_before}: {errors}");
        assert!(errors.contains("interrupted; the files"), "{errors}");
    }
}

/// The node receives no event: it detects the impact in the signal, and its recording holds what it has made of it.
#[cfg(all(feature = "ros", feature = "record"))]
#[test]
fn the_demonstration_with_sensors_detects_estimates_and_verifies() {
    let folder = tempfile::tempdir().expect("a folder");
    let ended = run(folder.path(), &["demo", "--sensors"]);
    let shown = String::from_utf8_lossy(&ended.stdout);
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(0), "{shown}{errors}");
    let has = |text: &str| assert!(shown.contains(text), "{text}: {shown}");
    has("The sensors have detected an impact");
    has("ACCEPTED");
    has("this estimate is final");
    has("Recording verified by recomputation");
    // The mean of the final momentum is near to that of the signal, 1.5 t at 10 m/s.
    let momentum = shown
        .lines()
        .filter_map(|line| line.trim().strip_prefix("momentum"))
        .find_map(|rest| {
            rest.split("kN s")
                .nth(1)?
                .split('(')
                .next()?
                .trim()
                .parse()
                .ok()
        });
    let momentum: f64 = momentum.expect("a final momentum");
    assert!((momentum / 15.0 - 1.0).abs() < 0.2, "{momentum}: {shown}");
    let recomputed = shown
        .lines()
        .find_map(|line| {
            line.strip_suffix(" estimates were computed again from the recorded measurements.")
        })
        .and_then(|counts| counts.split_once(" of "));
    assert!(
        recomputed.is_some_and(|(one, all)| one == all && one != "0"),
        "{recomputed:?}: {shown}"
    );
    let inside = folder.path().join("column_twin_demo");
    let report = fs::read_to_string(inside.join("report.html")).expect("a report");
    assert!(report.contains("id=\"detected\"") && report.contains("by the twin itself"));
    for file in [
        "readings.csv",
        "signal.yaml",
        "sensors.yaml",
        "column.yaml",
        "state",
    ] {
        assert!(inside.join(file).exists(), "{file}");
    }
}

#[cfg(all(feature = "ros", feature = "record"))]
#[test]
fn the_demonstration_with_sensors_plays_its_own_vehicle() {
    let folder = tempfile::tempdir().expect("a folder");
    let ended = run(folder.path(), &["demo", "--sensors", "--mass", "2000"]);
    assert_eq!(ended.status.code(), Some(2));
    assert_eq!(names(folder.path()), [""; 0]);
}

/// Each took gigabytes of memory, or a minute.
#[test]
fn links_to_endless_files_are_rejected() {
    let folder = tempfile::tempdir().expect("a folder");
    symlink("/dev/zero", folder.path().join("endless")).expect("a link");
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let path = |name: &str| config.join(name).display().to_string();
    let (column, sensors) = (path("heb220_s355.yaml"), path("sensors_industrial.yaml"));
    for (arguments, expected) in [
        (
            vec![
                "estimate",
                "--config",
                &column,
                "--config",
                &sensors,
                "--readings",
                "endless",
            ],
            "a row is longer than 1048576 bytes",
        ),
        (
            vec![
                "measure", "endless", "--config", &column, "--config", &sensors,
            ],
            "a row is longer than 1048576 bytes",
        ),
        (
            vec![
                "risk",
                "--scenario",
                "motorway",
                "--scenarios",
                "endless",
                "--distance",
                "1",
                "--vehicles-per-day",
                "1",
            ],
            "larger than 1048576 bytes",
        ),
        (
            vec!["capacity", "--state", "endless"],
            "larger than 4194304 bytes",
        ),
        (
            vec!["simulate", "--config", "endless"],
            "larger than 1048576 bytes",
        ),
    ] {
        let ended = run(folder.path(), &arguments);
        let said = String::from_utf8_lossy(&ended.stderr);
        // The words of an error are wrapped at the width of the terminal.
        let words: Vec<&str> = said.split_whitespace().filter(|it| *it != "│").collect();
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(words.join(" ").contains(expected), "{arguments:?}: {said}");
    }
}

/// The twin names only a part of such an identifier in its rejection, so that the command waited for an answer in vain.
#[cfg(feature = "ros")]
#[test]
fn an_impact_with_an_identifier_that_no_event_can_have_is_bad_input() {
    let folder = tempfile::tempdir().expect("a folder");
    for wrong in [&"x".repeat(100_000), "a\u{1b}[31m", ""] {
        let arguments = [
            "impact",
            "--mass",
            "10",
            "--velocity",
            "1",
            "--event",
            wrong,
        ];
        let ended = run(folder.path(), &arguments);
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert!(said.contains("--event: event_id is"), "{said}");
    }
}

/// The command waited for a twin, which could only reject such a number.
#[cfg(feature = "ros")]
#[test]
fn an_impact_with_a_number_that_no_twin_accepts_is_bad_input() {
    let folder = tempfile::tempdir().expect("a folder");
    for (further, expected) in [
        (["--velocity", "nan"], "allowed: 1e-6 to 60 m/s"),
        (["--velocity", "61"], "--velocity 61 is out of range"),
        (["--gap", "-1"], "--gap -1 is out of range"),
        (["--direction", "181"], "above -180 to 180 degrees"),
        (["--height", "nan"], "--height NaN is out of range"),
    ] {
        let mut arguments = vec!["impact", "--mass", "10"];
        if further[0] != "--velocity" {
            arguments.extend(["--velocity", "1"]);
        }
        arguments.extend(further);
        let ended = run(folder.path(), &arguments);
        let said = String::from_utf8_lossy(&ended.stderr);
        let words: Vec<&str> = said.split_whitespace().filter(|it| *it != "│").collect();
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert!(words.join(" ").contains(expected), "{said}");
    }
}

/// It aborted where an allocation did not fit.
#[cfg(feature = "ros")]
#[test]
fn a_node_with_too_little_address_space_says_what_it_needs() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = env!("CARGO_BIN_EXE_column-twin");
    let ended = Command::new("sh")
        .args(["-c", "ulimit -v 200000 && exec \"$0\" run", program])
        .current_dir(folder.path())
        .env("XDG_STATE_HOME", folder.path())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{said}");
    let words: Vec<&str> = said.split_whitespace().filter(|it| *it != "│").collect();
    assert!(words.join(" ").contains("needs at least 512 MB"), "{said}");
}

/// As `2>&1 >/dev/null | true` does in a shell.
#[test]
fn a_closed_standard_error_does_not_change_the_exit_code() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in [&["simulate", "-p", "nothing:=1"][..], &["no-command"]] {
        let (reading, writing) = std::io::pipe().expect("a pipe");
        let mut child = program(folder.path(), arguments)
            .stdout(Stdio::null())
            .stderr(writing)
            .spawn()
            .expect("the program");
        drop(reading);
        let ended = child.wait().expect("a child");
        assert_eq!(ended.code(), Some(2), "{arguments:?}");
    }
}
