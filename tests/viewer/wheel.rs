//! The real viewer from PyPI.

use std::net::{Ipv4Addr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

#[path = "../../crates/alarm/tests/peers/free_port.rs"]
mod free_port;
pub use free_port::free_port;

/// How long a test waits until the viewer listens.
const LISTEN_TIMEOUT: Duration = Duration::from_secs(120);

/// How long a viewer without a screen needs to find its graphics driver.
const STARTING_TIME: Duration = Duration::from_secs(2);

/// The program of the viewer, which is installed if it is missing.
pub fn program() -> PathBuf {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop/viewer.sh");
    let output = Command::new(script)
        .stderr(Stdio::inherit())
        .output()
        .expect("runs");
    assert!(output.status.success(), "viewer.sh: {}", output.status);
    PathBuf::from(String::from_utf8(output.stdout).expect("a path").trim())
}

/// The viewer with a home of its own, in which analytics are disabled.
pub fn viewer(program: &Path) -> Command {
    let venv = program
        .ancestors()
        .find(|it| it.join(".complete").exists())
        .expect("in its environment");
    let mut command = Command::new(program);
    command
        .env("HOME", venv.join("home"))
        .env("XDG_CONFIG_HOME", venv.join("home"))
        .env("XDG_RUNTIME_DIR", venv.join("home"))
        .env("RUST_LOG", "error")
        .stdout(Stdio::null());
    command
}

/// A process that is killed when the test ends.
pub struct Running(Child);

impl Running {
    /// The viewer without a screen.
    pub fn headless(port: u16) -> Self {
        Self::try_headless(port).unwrap_or_else(|reason| panic!("{reason}"))
    }

    /// The viewer without a screen.
    ///
    /// # Errors
    /// It does not run here.
    pub fn try_headless(port: u16) -> Result<Self, String> {
        let mut headless = viewer(&program());
        headless.arg("--headless");
        let mut running = Self::try_start(headless, port)?;
        // Without a driver for graphics it ends shortly after it has begun to listen.
        std::thread::park_timeout(STARTING_TIME);
        running.check()?;
        Ok(running)
    }

    pub fn start(command: Command, port: u16) -> Self {
        Self::try_start(command, port).unwrap_or_else(|reason| panic!("{reason}"))
    }

    fn try_start(mut command: Command, port: u16) -> Result<Self, String> {
        let child = command
            .args(["--bind", "127.0.0.1", "--port", &port.to_string()])
            .spawn()
            .map_err(|error| format!("the viewer does not start: {error}"))?;
        let mut running = Self(child);
        let deadline = Instant::now() + LISTEN_TIMEOUT;
        while TcpStream::connect((Ipv4Addr::LOCALHOST, port)).is_err() {
            running.check()?;
            if Instant::now() >= deadline {
                return Err("the viewer does not listen".to_owned());
            }
            std::thread::park_timeout(Duration::from_millis(50));
        }
        Ok(running)
    }

    /// # Errors
    /// The process has ended.
    pub fn check(&mut self) -> Result<(), String> {
        match self.0.try_wait() {
            Ok(None) => Ok(()),
            Ok(Some(status)) => Err(format!(
                "the viewer has ended ({status}); without a screen it needs a Vulkan driver, such as Debian's mesa-vulkan-drivers"
            )),
            Err(error) => Err(format!("the viewer cannot be watched: {error}")),
        }
    }

    pub fn signal(&self, signal: &str) {
        let status = Command::new("kill")
            .args([format!("-{signal}"), self.0.id().to_string()])
            .status()
            .expect("runs");
        assert!(status.success());
    }

    /// Resident memory of the process \[B\].
    pub fn memory(&self) -> u64 {
        resident(self.0.id())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill(); // it may have ended
        let _ = self.0.wait();
    }
}

/// Resident memory of a process, as the operating system reports it \[B\].
pub fn resident(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
    1024 * kilobytes.unwrap_or(0)
}
