//! A viewer process that this program starts.

use std::io;
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};

use super::error::{RERUN_VERSION, ViewerError, ViewerLogger};
use crate::twin::NoticeLevel;

/// Name of the viewer's program.
const PROGRAM: &str = "rerun";

/// The process of a viewer. It keeps running when this program ends, so that the user can go on watching.
pub struct Spawned {
    child: Option<Child>,
    log: ViewerLogger,
}

impl Spawned {
    /// Starts a viewer that listens at `address`.
    ///
    /// # Errors
    /// The viewer is not installed, or cannot be started.
    pub fn start(
        address: SocketAddr,
        memory_limit: u64,
        log: ViewerLogger,
    ) -> Result<Self, ViewerError> {
        let fault = |reason| ViewerError::Spawn { reason };
        check_version(&log).map_err(fault)?;
        let child = command(address, memory_limit).spawn().map_err(fault)?;
        Ok(Self {
            child: Some(child),
            log,
        })
    }

    /// Reports the end of the viewer.
    pub fn check(&mut self) {
        let Some(child) = &mut self.child else {
            return;
        };
        if let Ok(Some(status)) = child.try_wait() {
            self.child = None;
            let (level, text) = if status.success() {
                let text = "the viewer has been closed".to_owned();
                (NoticeLevel::Info, text)
            } else {
                let text = format!(
                    "the viewer ended with {status}; start it by hand to see the reason: {PROGRAM}"
                );
                (NoticeLevel::Warning, text)
            };
            (self.log)(level, text);
        }
    }
}

fn command(address: SocketAddr, memory_limit: u64) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .arg(format!("--port={}", address.port()))
        // Without it, the viewer listens on every interface.
        .arg(format!("--bind={}", address.ip()))
        .arg(format!("--server-memory-limit={memory_limit}B"))
        .arg("--expect-data-soon")
        .arg("--hide-welcome-screen")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        // The viewer outlives this program: a reader of an inherited stream would wait for the viewer's end.
        .stderr(Stdio::null());
    // Ctrl-C in the terminal stops the twin only.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

/// Warns if the installed viewer has another version: it may show nothing, or something wrong.
fn check_version(log: &ViewerLogger) -> io::Result<()> {
    let output = Command::new(PROGRAM)
        .arg("--version")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()?;
    let printed = String::from_utf8_lossy(&output.stdout);
    // "rerun-cli 0.36.3 [...]"
    let version = printed.split_whitespace().nth(1).unwrap_or("unknown");
    if version != RERUN_VERSION {
        log(
            NoticeLevel::Warning,
            format!(
                "the viewer `{PROGRAM}` has version {version}, expected {RERUN_VERSION}, and may show nothing; install the \
                 right one: pip install rerun-sdk=={RERUN_VERSION}"
            ),
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_viewer_that_the_node_starts_listens_on_the_address_of_the_parameter_only() {
        for address in ["127.0.0.1:9877", "[::1]:9877"] {
            let address: SocketAddr = address.parse().expect("valid");
            let command = command(address, 1_000_000);
            let arguments: Vec<_> = command.get_args().collect();
            let bind = format!("--bind={}", address.ip());
            assert!(arguments.contains(&bind.as_ref()), "{arguments:?}");
            assert!(arguments.contains(&"--port=9877".as_ref()), "{arguments:?}");
        }
    }
}
