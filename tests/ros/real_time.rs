//! What `column-twin run` asks the system for: granted it is there, denied it is said, and the twin lives either way.
#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::Command;

use column_twin::live::SOLVER_THREAD;
use column_twin::ros::ImpactOutcome;

use super::domain::{Domain, PATIENCE};
use super::loopback::impact;
use super::program::Program;

/// `SCHED_FIFO` in `/proc`.
const FIFO: &str = "1";

/// A user without any rights, on most systems called `nobody`.
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

/// Policy and priority of the solver's thread, and the processors that it may run on.
fn of_solver(id: u32) -> (String, String, String) {
    let tasks = fs::read_dir(format!("/proc/{id}/task")).unwrap();
    let name = &SOLVER_THREAD[..15];
    let solver = tasks
        .map(|task| task.unwrap().path())
        .find(|task| fs::read_to_string(task.join("comm")).is_ok_and(|it| it.trim() == name))
        .expect("the solver's thread");
    let stat = fs::read_to_string(solver.join("stat")).unwrap();
    let behind_name = stat.rsplit_once(')').unwrap().1;
    let field = |number: usize| {
        let field = behind_name.split_ascii_whitespace().nth(number - 3);
        field.unwrap().to_owned()
    };
    let status = fs::read_to_string(solver.join("status")).unwrap();
    (field(41), field(40), line(&status, "Cpus_allowed_list:"))
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
    let (policy, priority, processors) = of_solver(program.id());
    let said = |text: &str| program.seen.iter().any(|it| it.contains(text));
    // Where this test may not have it, the next one is the one that counts.
    if !said("SCHED_FIFO not granted") {
        assert_eq!((policy.as_str(), priority.as_str()), (FIFO, "17"));
    }
    if !said("CPU affinity not granted") {
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
