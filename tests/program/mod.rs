//! The program as a user starts and interrupts it.

use std::path::Path;
use std::process::{Child, Command, Output};

use rustix::process::{Pid, Signal, kill_process};

/// The program with these arguments, in this folder.
pub fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    // The tests leave nothing in the user's state folder.
    command
        .current_dir(folder)
        .env("XDG_STATE_HOME", folder)
        .args(arguments);
    command
}

/// Runs it to its end.
pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    program(folder, arguments)
        .output()
        .expect("the program that was built with this test")
}

/// Ctrl-C.
pub fn interrupt(child: &Child) {
    let id = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    kill_process(id.expect("a process id"), Signal::INT).expect("a running process");
}
