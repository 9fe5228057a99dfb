//! The destination of the frames of a running twin, selected by `viewer.mode`.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jiff::Timestamp;
use rerun::RecordingStreamBuilder;

use super::blueprint::APPLICATION;
use super::connection::{self, Connection};
use super::error::{ViewerError, ViewerLogger};
use super::frame_budget::FrameBudget;
use super::guard::Guard;
use super::picture::Picture;
use super::plots::Ranges;
use super::rerun_types::batching;
use super::server;
use super::spawned::Spawned;
use super::stream::StreamOptions;
use crate::parameters::{ViewerMode, ViewerSettings};
use crate::state_home;
use crate::twin::NoticeLevel;

/// Minimum time between two frames of the scene \[ns\].
const FRAME_PERIOD: i64 = 1_000_000;

/// How long states are collected before their curves are sent \[ns\]: a piece of a curve costs about the same whatever its
/// length. The end of an impact is sent at once.
const CURVES_PERIOD: i64 = 200_000_000;

/// Mean rate of frames of the scene \[1/s\].
const FRAMES_PER_SECOND: f64 = 60.0;

/// Number of frames that can be saved up: enough for two ordinary impacts at one frame per millisecond.
const SAVED_FRAMES: f64 = 120.0;

/// Where items are shown.
pub enum Destination<P: Picture> {
    /// A file.
    Stream(Box<P>),
    /// A server for viewers.
    Served {
        /// Lets viewers in.
        _guard: Guard,
        /// What they see.
        stream: Box<P>,
    },
    /// A running viewer.
    Connection(Box<Connection<P>>),
    /// A viewer that this program started.
    Spawned(Spawned, Box<Connection<P>>),
}

/// Options for a running twin or fleet.
#[must_use]
pub fn live_options(ranges: Ranges) -> StreamOptions {
    StreamOptions {
        frame_period: FRAME_PERIOD,
        budget: Some(FrameBudget::new(FRAMES_PER_SECOND, SAVED_FRAMES)),
        curves_period: CURVES_PERIOD,
        follows: true,
        ranges,
    }
}

impl<P: Picture + Send + 'static> Destination<P> {
    /// Opens the destination that the parameters select; `None` if the viewer is off. A file is named after `name` and the time.
    ///
    /// # Errors
    /// The file, the server or the viewer is not available.
    pub fn open(
        viewer: &ViewerSettings,
        name: &str,
        subject: P::Subject,
        options: StreamOptions,
        now: i64,
        log: &ViewerLogger,
    ) -> Result<Option<Self>, ViewerError> {
        let memory_limit = viewer.memory_limit;
        let connection = |address, subject, options| {
            Connection::new(address, subject, memory_limit, options, Arc::clone(log))
        };
        Ok(Some(match viewer.mode {
            ViewerMode::Off => return Ok(None),
            ViewerMode::Save => {
                let path = new_file(&state_home::resolve(&viewer.directory), name, now)?;
                let stream = saving(&path)?;
                log(
                    NoticeLevel::Info,
                    format!("the viewer file is {}", path.display()),
                );
                Self::Stream(Box::new(P::open(stream, &subject, options)?))
            }
            ViewerMode::Serve => {
                let address = server::loopback(&viewer.address, viewer.port)?;
                let (stream, guard) = server::stream(address, memory_limit, log)?;
                let url = server::url(address);
                log(NoticeLevel::Info, format!("to watch: rerun {url}"));
                Self::Served {
                    _guard: guard,
                    stream: Box::new(P::open(stream, &subject, options)?),
                }
            }
            ViewerMode::Connect => {
                let address = connection::resolve(&viewer.address, viewer.port)?;
                Self::Connection(Box::new(connection(address, subject, options)))
            }
            ViewerMode::Spawn => {
                let address = server::loopback(&viewer.address, viewer.port)?;
                let spawned = Spawned::start(address, memory_limit, Arc::clone(log))?;
                let connection = connection(address, subject, options).awaiting_start();
                Self::Spawned(spawned, Box::new(connection))
            }
        }))
    }

    /// Shows some items; blocks while the destination accepts nothing.
    ///
    /// # Errors
    /// The destination has failed.
    pub fn show(&mut self, items: Vec<P::Item>) -> Result<(), ViewerError> {
        match self {
            Self::Stream(stream) | Self::Served { stream, .. } => stream.show_items(items)?,
            Self::Connection(connection) => connection.show(items),
            Self::Spawned(spawned, connection) => {
                spawned.check();
                connection.show(items);
            }
        }
        Ok(())
    }
}

fn saving(path: &Path) -> Result<rerun::RecordingStream, ViewerError> {
    RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .batcher_config(batching())
        .save(path)
        .map_err(|error| ViewerError::File {
            path: path.to_owned(),
            reason: error.to_string(),
        })
}

/// A new file, named after the column or the fleet and the time.
fn new_file(folder: &Path, name: &str, now: i64) -> Result<PathBuf, ViewerError> {
    fs::create_dir_all(folder).map_err(|error| ViewerError::File {
        path: folder.to_owned(),
        reason: error.to_string(),
    })?;
    let name = file_name(name);
    // 64 bits of nanoseconds end before the year 9999.
    let time = Timestamp::from_nanosecond(now.into()).unwrap_or_default();
    let time = time.strftime("%Y%m%dT%H%M%SZ");
    let free = (0..).map(|number: u32| {
        let suffix = if number == 0 {
            String::new()
        } else {
            format!("_{number}")
        };
        folder.join(format!("{name}_{time}{suffix}.rrd"))
    });
    let found = free.take(1000).find(|path| !path.exists());
    found.ok_or_else(|| ViewerError::File {
        path: folder.to_owned(),
        reason: "a thousand files of this second exist already".to_owned(),
    })
}

/// Keeps only characters that every file system accepts.
fn file_name(id: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    id.chars().map(plain).take(64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_is_overwritten_and_no_name_leaves_its_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let new =
            || new_file(folder.path(), "../garage a3", 1_800_000_000_000_000_000).expect("a name");
        let first = new();
        assert_eq!(first.parent(), Some(folder.path()));
        let name = first.file_name().and_then(|it| it.to_str());
        assert_eq!(name, Some("___garage_a3_20270115T080000Z.rrd"));
        fs::write(&first, "").expect("written");
        assert_ne!(new(), first);
        let error = new_file(&first, "a3", 0).expect_err("a file is not a folder");
        assert!(matches!(error, ViewerError::File { .. }));
    }
}
