//! What an engineer sees: the deformed column, what hit it, where it yields and how far it is from failing, in the Rerun
//! viewer (feature `viewer`).
//!
//! [`Item`]s are what there is to show, from a running twin, a simulation or a recording. A [`Film`] writes them into a
//! Rerun stream: the scene ([`Drawing`], pure numbers), the curves ([`plots`]), the log, the blueprint. [`write_rrd`] makes a
//! file of them, [`serve`] shows them to viewers that connect, and [`LiveViewer`] follows a running twin in a thread of its
//! own: `viewer.mode` says where to.
//!
//! Nothing flows back: a viewer that is slow, stopped or gone costs pictures, which are counted, and the solver never knows.
//! What was learned of Rerun 0.36.3, and is guarded against here: a client without a viewer buffers and then blocks for ever,
//! in its destructor too; it never connects again; a server on a port that is taken fails silently; the defaults listen on
//! every interface.

mod blueprint;
mod colour;
mod connection;
mod destination;
mod events;
mod file;
mod film;
mod fixtures;
mod item;
mod live_viewer;
mod pictures;
pub mod plots;
mod recorded_message;
mod scene;
mod server;
mod spawned;
mod timeline;

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

pub use blueprint::APPLICATION;
pub use events::{Event, Events, summary};
pub use file::{from_samples, write_rrd};
pub use film::{Budget, Film, FilmOptions};
pub use item::{Announcement, Item};
pub use live_viewer::{LiveViewer, Telling, VIEWER_QUEUE, VIEWER_THREAD, output_queue};
pub use recorded_message::{RecordedMessage, from_messages};
pub use scene::{Arrow, Body, Drawing, FULL_ARC, HingeMark, Scene, VEHICLE};
pub use server::{Served, serve};
pub use timeline::{IMPACT_TIME, Moment, Placed, STEP, Timeline, WALL_CLOCK};

/// Version of Rerun that a viewer must have.
pub const RERUN_VERSION: &str = "0.36.3";

/// Why there is nothing to see.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ViewerError {
    /// Somebody else has the port.
    #[error("viewer.port {}: another program listens on {address}", address.port())]
    #[diagnostic(help("end that program, or choose another port: -p viewer.port:=9877"))]
    PortTaken {
        /// Where.
        address: SocketAddr,
    },
    /// Nothing can be served there.
    #[error("cannot serve on {address}: {reason}")]
    #[diagnostic(help("serve on this machine: -p viewer.address:=127.0.0.1"))]
    Serve {
        /// Where.
        address: SocketAddr,
        /// What the system says.
        reason: io::Error,
    },
    /// The address is none, or not of this machine.
    #[error("viewer.address is {found:?}; expected {expected}")]
    #[diagnostic(help(
        "-p viewer.address:=127.0.0.1; to look from another machine: ssh -L 9876:127.0.0.1:9876"
    ))]
    Address {
        /// As it was given.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {reason}", path.display())]
    #[diagnostic(help("name a file in a folder that exists, can be written to and has room"))]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The viewer cannot be started.
    #[error("cannot start the viewer `rerun`: {reason}")]
    #[diagnostic(help(
        "install it: pip install rerun-sdk=={RERUN_VERSION}, or cargo install rerun-cli --version {RERUN_VERSION} --locked"
    ))]
    Spawn {
        /// What the system says.
        reason: io::Error,
    },
    /// No thread.
    #[error("no thread for the viewer: {0}")]
    Thread(io::Error),
    /// The stream takes nothing.
    #[error("cannot write to the viewer: {0}")]
    Stream(String),
}

impl From<rerun::RecordingStreamError> for ViewerError {
    fn from(error: rerun::RecordingStreamError) -> Self {
        Self::Stream(error.to_string())
    }
}
