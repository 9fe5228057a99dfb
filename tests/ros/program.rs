//! Runs `column-twin run` as a separate process and reads its log.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::domain::{Domain, PATIENCE};

/// A running `column-twin run`, which is killed when dropped.
pub struct Program {
    child: Child,
    log: Receiver<String>,
    reading: Option<JoinHandle<()>>,
    /// All lines of the log that have been read.
    pub seen: Vec<String>,
}

impl Program {
    /// Starts it in a working folder with these ROS arguments.
    pub fn start(domain: &Domain, folder: &Path, ros_arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command.args(["run", "--ros-args"]).args(ros_arguments);
        Self::spawn(domain, folder, command)
    }

    /// Starts it with another command. The state folder of the user is the working folder, unless the command has set it.
    pub fn spawn(domain: &Domain, folder: &Path, mut command: Command) -> Self {
        if command.get_envs().all(|(name, _)| name != "XDG_STATE_HOME") {
            command.env("XDG_STATE_HOME", folder);
        }
        let mut child = command
            .current_dir(folder)
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program that was built with this test");
        let (sender, log) = channel();
        let lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let reading = std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        Self {
            child,
            log,
            reading: Some(reading),
            seen: Vec::new(),
        }
    }

    /// As [`start`](Self::start), and waits until it is ready.
    pub fn ready(domain: &Domain, folder: &Path, ros_arguments: &[&str]) -> Self {
        let mut program = Self::start(domain, folder, ros_arguments);
        program.wait_for("is ready in domain");
        program
    }

    /// The process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Resident memory \[MB\].
    #[allow(dead_code)] // for the tests of the transport
    pub fn megabytes(&self) -> f64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.id()));
        let status = status.expect("the program runs");
        let line = status.lines().find(|line| line.starts_with("VmRSS:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().nth(1));
        let kilobytes = kilobytes.and_then(|it| it.parse::<u32>().ok());
        f64::from(kilobytes.expect("a number")) / 1024.0
    }

    /// Waits for a line of the log that contains this text.
    pub fn wait_for(&mut self, text: &str) -> String {
        loop {
            let line = self.log.recv_timeout(PATIENCE);
            let line = line.unwrap_or_else(|_| panic!("no `{text}` in the log: {:#?}", self.seen));
            self.seen.push(line.clone());
            if line.contains(text) {
                return line;
            }
        }
    }

    /// Whether a line of the log that contains this text comes within a time.
    #[allow(dead_code)] // the tests of stopped processes use it
    pub fn shows(&mut self, text: &str, within: Duration) -> bool {
        let deadline = Instant::now() + within;
        while let Some(rest) = deadline.checked_duration_since(Instant::now()) {
            let Ok(line) = self.log.recv_timeout(rest) else {
                return false;
            };
            let is_it = line.contains(text);
            self.seen.push(line);
            if is_it {
                return true;
            }
        }
        false
    }

    /// All lines of the log until now.
    #[allow(dead_code)] // the tests of security use it
    pub fn log_so_far(&mut self) -> &[String] {
        self.seen.extend(self.log.try_iter());
        &self.seen
    }

    /// Sends SIGTERM and waits for the end; returns the exit status, the time until the end and the whole log.
    pub fn terminate(mut self) -> (ExitStatus, Duration, Vec<String>) {
        let before = Instant::now();
        let pid = i32::try_from(self.child.id()).expect("a process id");
        let pid = rustix::process::Pid::from_raw(pid).expect("not 0");
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).expect("it runs");
        let status = self.child.wait().expect("a child");
        let took = before.elapsed();
        (status, took, self.rest())
    }

    /// Waits until the program ends by itself, and with it the log.
    pub fn end(mut self) -> (ExitStatus, Vec<String>) {
        loop {
            match self.log.recv_timeout(PATIENCE) {
                Ok(line) => self.seen.push(line),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => panic!("it does not end: {:#?}", self.seen),
            }
        }
        let status = self.child.wait().expect("a child");
        (status, self.rest())
    }

    fn rest(&mut self) -> Vec<String> {
        if let Some(reading) = self.reading.take() {
            reading.join().expect("no panic");
        }
        let rest = self.log.try_iter().collect::<Vec<_>>();
        self.seen.extend(rest);
        std::mem::take(&mut self.seen)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
