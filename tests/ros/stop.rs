//! Stops a process for a while, as a debugger, a suspended virtual machine or Ctrl-Z does.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use super::domain::PATIENCE;

/// Who stops it.
#[derive(Debug, Clone, Copy)]
#[allow(dead_code)] // not every test target uses all
pub enum By {
    /// SIGSTOP, then SIGCONT.
    Stop,
    /// SIGTSTP, then SIGCONT, as Ctrl-Z and `fg` do. It needs a process group of its own: the system does not stop orphaned ones.
    Terminal,
    /// A debugger that attaches and detaches.
    Gdb,
    /// A tracer that attaches and detaches.
    Strace,
}

/// Stops a process for a time and lets it continue. A debugger stops it as long as it needs.
pub fn stop_for(process: u32, by: By, time: Duration) {
    match by {
        By::Stop => stop_by_signal(process, Signal::STOP, time),
        By::Terminal => stop_by_signal(process, Signal::TSTP, time),
        By::Gdb => {
            let process = process.to_string();
            let arguments = ["-nx", "-batch", "-p", &process, "-ex", "detach"];
            let output = Command::new("gdb").args(arguments).output();
            let output = output.expect("this test needs gdb");
            let said = String::from_utf8_lossy(&output.stdout);
            assert!(said.contains("detached"), "{output:?}");
        }
        By::Strace => {
            let mut strace = Command::new("strace")
                .args(["-f", "-o", "/dev/null", "-p", &process.to_string()])
                .stderr(Stdio::piped())
                .spawn()
                .expect("this test needs strace");
            let said = BufReader::new(strace.stderr.take().expect("piped")).lines();
            let attached = said.map_while(Result::ok).any(|it| it.contains("attached"));
            assert!(attached, "strace cannot attach");
            send(strace.id(), Signal::INT);
            end(strace);
        }
    }
}

fn stop_by_signal(process: u32, signal: Signal, time: Duration) {
    send(process, signal);
    let deadline = Instant::now() + PATIENCE;
    while state(process) != "T" {
        assert!(Instant::now() < deadline, "{signal:?} does not stop it");
        std::thread::yield_now();
    }
    // The stop is the scenario.
    std::thread::sleep(time);
    send(process, Signal::CONT);
}

fn end(mut child: Child) {
    child.wait().expect("a child");
}

fn send(process: u32, signal: Signal) {
    let process = i32::try_from(process).ok().and_then(Pid::from_raw);
    kill_process(process.expect("a process id"), signal).expect("it runs");
}

/// The letter of proc(5): T while it is stopped by a signal.
fn state(process: u32) -> String {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).expect("it runs");
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    after_name
        .split_whitespace()
        .next()
        .unwrap_or_default()
        .to_owned()
}
