//! What the viewer reports to the program that runs it: errors and log lines.

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use crate::twin::NoticeLevel;

/// Version of Rerun that a viewer must have.
pub const RERUN_VERSION: &str = "0.36.3";

/// Takes the log lines of the viewer's thread.
pub type ViewerLogger = Arc<dyn Fn(NoticeLevel, String) + Send + Sync>;

/// Why nothing can be shown.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ViewerError {
    /// Another program uses the port.
    #[error("viewer.port {}: another program listens on {address}", address.port())]
    #[diagnostic(help("stop that program, or choose another port: -p viewer.port:=9877"))]
    PortTaken {
        /// Address and port.
        address: SocketAddr,
    },
    /// The server cannot listen on the address.
    #[error("cannot serve on {address}: {reason}")]
    #[diagnostic(help("serve on this machine: -p viewer.address:=127.0.0.1"))]
    Serve {
        /// Address and port.
        address: SocketAddr,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The address is invalid, or does not belong to this machine.
    #[error("viewer.address is {found:?}; expected {expected}")]
    #[diagnostic(help(
        "give -p viewer.address:=127.0.0.1; to watch from another machine: ssh -L 9876:127.0.0.1:9876 HOST"
    ))]
    Address {
        /// The given address.
        found: String,
        /// What is valid here.
        expected: &'static str,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder with enough free space"))]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: String,
    },
    /// The viewer cannot be started.
    #[error("cannot start the viewer `rerun`: {reason}")]
    #[diagnostic(help(
        "install it: pip install rerun-sdk=={RERUN_VERSION}, or cargo install rerun-cli --version {RERUN_VERSION} --locked"
    ))]
    Spawn {
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The operating system does not start another thread.
    #[error("cannot start the thread of the viewer: {0}")]
    Thread(io::Error),
    /// Rerun's stream rejects the data.
    #[error("cannot write to the viewer: {0}")]
    Stream(String),
}

impl From<rerun::RecordingStreamError> for ViewerError {
    fn from(error: rerun::RecordingStreamError) -> Self {
        Self::Stream(error.to_string())
    }
}
