//! Real-time scheduling of `column-twin run`: used if the system grants it, reported if not; the twin runs either way.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::live::SOLVER_THREAD;
use column_twin::ros::ImpactOutcome;

use super::domain::{Domain, PATIENCE};
use super::loopback::impact;
use super::program::Program;

/// `SCHED_FIFO` in `/proc`.
const FIFO: &str = "1";

/// `SCHED_OTHER`.
const NORMAL: &str = "0";

/// A user without privileges, called `nobody` on most systems.
const NOBODY: u32 = 65_534;

const WISHES: [&str; 8] = [
    "-p",
    "real_time.priority:=17",
    "-p",
    "real_time.processors:='0'",
    "-p",
    "real_time.lock_memory:=true",
    "-p",
    "state.directory:=''",
];

/// Policy and priority of a thread, and the processors that it may run on, or none if no thread has this name yet. The system knows the
/// beginning of its name.
fn of_thread(id: u32, name: &str) -> Option<([String; 2], String)> {
    let tasks = fs::read_dir(format!("/proc/{id}/task")).unwrap();
    let thread = tasks.map(|task| task.unwrap().path()).find(|task| {
        fs::read_to_string(task.join("comm")).is_ok_and(|it| name.starts_with(it.trim()))
    })?;
    let stat = fs::read_to_string(thread.join("stat")).unwrap();
    let behind_name = stat.rsplit_once(')').unwrap().1;
    let field = |number: usize| {
        let field = behind_name.split_ascii_whitespace().nth(number - 3);
        field.unwrap().to_owned()
    };
    let status = fs::read_to_string(thread.join("status")).unwrap();
    let processors = line(&status, "Cpus_allowed_list:");
    Some(([field(41), field(40)], processors))
}

/// Waits until a thread has this policy and priority. A thread gives itself its name and its priority, on a loaded machine after the
/// program has said that it is ready.
fn wait_until_scheduled(id: u32, name: &str, expected: [&str; 2]) {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let scheduled = of_thread(id, name).map(|(scheduled, _)| scheduled);
        if scheduled.as_ref().is_some_and(|it| *it == expected) {
            return;
        }
        assert!(
            Instant::now() < deadline,
            "{name}: {scheduled:?} instead of {expected:?}"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn line(status: &str, key: &str) -> String {
    let value = status.lines().find_map(|line| line.strip_prefix(key));
    value.unwrap().trim().to_owned()
}

fn answers(domain: &Domain) {
    let outcome = impact(domain, 1500.0, PATIENCE);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
}

#[test]
fn what_is_granted_is_there() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::ready(&domain, folder.path(), &WISHES);
    let said = |text: &str| program.seen.iter().any(|it| it.contains(text));
    // Where this test may not have it, the next one is the one that counts.
    if !said("SCHED_FIFO not granted") {
        for (name, expected) in [
            (SOLVER_THREAD, [FIFO, "17"]),
            ("column_twin/pub", [FIFO, "16"]),
            ("RustDDS Participant", [FIFO, "15"]),
            ("RustDDS discovery", [NORMAL, "0"]),
        ] {
            wait_until_scheduled(program.id(), name, expected);
        }
    }
    if !said("CPU affinity not granted") {
        let (_, processors) = of_thread(program.id(), SOLVER_THREAD).expect(SOLVER_THREAD);
        assert_eq!(processors, "0");
    }
    if !said("mlockall not granted") {
        let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap();
        assert_ne!(line(&status, "VmLck:"), "0 kB");
    }
    answers(&domain);
    assert!(program.terminate().0.success());
}

#[test]
fn what_is_denied_is_a_warning_with_a_hint() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    // The folder that it was built in may be closed to others.
    let own = folder.path().join("column-twin");
    fs::copy(env!("CARGO_BIN_EXE_column-twin"), &own).unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new("prlimit");
    command
        .args(["--rtprio=0:0", "--memlock=65536:65536"])
        .arg(&own)
        .args(["run", "--ros-args"])
        .args(WISHES);
    if rustix::process::geteuid().is_root() {
        // Limits do not bind root.
        command.uid(NOBODY);
    }
    let mut program = Program::spawn(&domain, folder.path(), command);
    program.wait_for("is ready in domain");
    for (wish, hint) in [
        ("SCHED_FIFO not granted", "/etc/security/limits.conf"),
        ("mlockall not granted", "memlock unlimited"),
    ] {
        assert!(
            program
                .seen
                .iter()
                .any(|it| it.contains("[WARN]") && it.contains(wish) && it.contains(hint)),
            "{wish}: {:#?}",
            program.seen
        );
    }
    answers(&domain);
    assert!(program.terminate().0.success());
}
