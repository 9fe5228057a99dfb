//! A viewer that this program starts.

use std::io;
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};

use super::{RERUN_VERSION, Telling, ViewerError};
use crate::twin::Severity;

/// Name of the viewer's program.
const PROGRAM: &str = "rerun";

/// A viewer's process. It goes on when this program ends, so that one can go on looking.
pub struct Spawned {
    child: Option<Child>,
    telling: Telling,
}

impl Spawned {
    /// Starts a viewer that listens there.
    ///
    /// # Errors
    /// There is no viewer, or it cannot be started.
    pub fn start(
        address: SocketAddr,
        memory_limit: u64,
        telling: Telling,
    ) -> Result<Self, ViewerError> {
        let fault = |reason| ViewerError::Spawn { reason };
        check_version(&telling).map_err(fault)?;
        let mut command = Command::new(PROGRAM);
        command
            .arg(format!("--port={}", address.port()))
            .arg(format!("--bind={}", address.ip()))
            .arg(format!("--server-memory-limit={memory_limit}B"))
            .arg("--expect-data-soon")
            .arg("--hide-welcome-screen")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            // It outlives this program: who reads this program's output would wait for its end.
            .stderr(Stdio::null());
        // Ctrl-C in the terminal is for the twin alone.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command.spawn().map_err(fault)?;
        Ok(Self {
            child: Some(child),
            telling,
        })
    }

    /// Says it when the viewer has ended.
    pub fn look_after(&mut self) {
        let Some(child) = &mut self.child else {
            return;
        };
        if let Ok(Some(status)) = child.try_wait() {
            self.child = None;
            let (severity, text) = if status.success() {
                let text = "the viewer that was started has ended".to_owned();
                (Severity::Info, text)
            } else {
                let text = format!(
                    "the viewer that was started has ended ({status}); start it by hand to see why: {PROGRAM}"
                );
                (Severity::Warning, text)
            };
            (self.telling)(severity, text);
        }
    }
}

/// Another version may show nothing, or the wrong thing.
fn check_version(telling: &Telling) -> io::Result<()> {
    let output = Command::new(PROGRAM)
        .arg("--version")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()?;
    let said = String::from_utf8_lossy(&output.stdout);
    // "rerun-cli 0.36.3 [...]"
    let version = said.split_whitespace().nth(1).unwrap_or("unknown");
    if version != RERUN_VERSION {
        telling(
            Severity::Warning,
            format!(
                "the viewer `{PROGRAM}` is of version {version}, expected {RERUN_VERSION}: it may show nothing; \
                 pip install rerun-sdk=={RERUN_VERSION}"
            ),
        );
    }
    Ok(())
}
