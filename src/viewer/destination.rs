//! Where the pictures of a running twin go, as `viewer.mode` says.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jiff::Timestamp;
use rerun::RecordingStreamBuilder;

use super::blueprint::APPLICATION;
use super::connection::{self, Connection};
use super::film::{Budget, Film, FilmOptions};
use super::item::Item;
use super::plots::Ranges;
use super::server;
use super::spawned::Spawned;
use super::{Telling, ViewerError};
use crate::parameters::{Parameters, ViewerMode};
use crate::twin::Severity;

/// Shortest time between two pictures of the scene \[ns\].
const PICTURE_PERIOD: i64 = 1_000_000;

/// How long curves wait for more of them \[ns\]: each piece costs about as much, however long it is. The end of an impact waits
/// for nothing.
const CURVES_PERIOD: i64 = 200_000_000;

/// Pictures of the scene in the long run \[1/s\].
const PICTURES_PER_SECOND: f64 = 60.0;

/// Pictures that an impact may have at once: two ordinary ones, millisecond by millisecond.
const SAVED_PICTURES: f64 = 120.0;

/// A place that takes what there is to show.
pub enum Destination {
    /// A file, or viewers that connect to this program.
    Stream(Box<Film>),
    /// A viewer that runs.
    Connection(Box<Connection>),
    /// A viewer that was started.
    Spawned(Spawned, Box<Connection>),
}

impl Destination {
    /// The destination that the parameters name; `None` where they say off.
    ///
    /// # Errors
    /// It cannot be had.
    pub fn open(
        parameters: &Arc<Parameters>,
        now: i64,
        telling: &Telling,
    ) -> Result<Option<Self>, ViewerError> {
        let viewer = &parameters.settings().viewer;
        let options = FilmOptions {
            picture_period: PICTURE_PERIOD,
            budget: Some(Budget::new(PICTURES_PER_SECOND, SAVED_PICTURES)),
            curves_period: CURVES_PERIOD,
            follows: true,
            ranges: Ranges::foreseen(parameters, None, None),
        };
        let film = |stream| Film::new(stream, Arc::clone(parameters), options.clone());
        let connection = |address| {
            let parameters = Arc::clone(parameters);
            Connection::new(address, parameters, options.clone(), Arc::clone(telling))
        };
        Ok(Some(match viewer.mode {
            ViewerMode::Off => return Ok(None),
            ViewerMode::Save => {
                let path = new_file(Path::new(&viewer.directory), parameters, now)?;
                let stream = saving(&path)?;
                telling(
                    Severity::Info,
                    format!("pictures go into {}", path.display()),
                );
                Self::Stream(Box::new(film(stream)?))
            }
            ViewerMode::Serve => {
                let address = server::loopback(&viewer.address, viewer.port)?;
                let stream = server::stream(address, viewer.memory_limit)?;
                let url = server::url(address);
                telling(Severity::Info, format!("to look: rerun {url}"));
                Self::Stream(Box::new(film(stream)?))
            }
            ViewerMode::Connect => {
                let address = connection::resolve(&viewer.address, viewer.port)?;
                Self::Connection(Box::new(connection(address)))
            }
            ViewerMode::Spawn => {
                let address = server::loopback(&viewer.address, viewer.port)?;
                let telling = Arc::clone(telling);
                let spawned = Spawned::start(address, viewer.memory_limit, telling)?;
                let connection = connection(address).awaiting_start();
                Self::Spawned(spawned, Box::new(connection))
            }
        }))
    }

    /// Shows some items; may wait for as long as the destination takes nothing.
    ///
    /// # Errors
    /// The destination takes nothing any more.
    pub fn show(&mut self, items: Vec<Item>) -> Result<(), ViewerError> {
        match self {
            Self::Stream(film) => film.show(items)?,
            Self::Connection(connection) => connection.show(items),
            Self::Spawned(spawned, connection) => {
                spawned.look_after();
                connection.show(items);
            }
        }
        Ok(())
    }
}

fn saving(path: &Path) -> Result<rerun::RecordingStream, ViewerError> {
    RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .batcher_config(connection::batches())
        .save(path)
        .map_err(|error| ViewerError::File {
            path: path.to_owned(),
            reason: error.to_string(),
        })
}

/// A file that is not there yet, named after the column and the time.
fn new_file(folder: &Path, parameters: &Parameters, now: i64) -> Result<PathBuf, ViewerError> {
    fs::create_dir_all(folder).map_err(|error| ViewerError::File {
        path: folder.to_owned(),
        reason: error.to_string(),
    })?;
    let column = file_name(&parameters.settings().column_id);
    // No clock is beyond the year 9999.
    let time = Timestamp::from_nanosecond(now.into()).unwrap_or_default();
    let time = time.strftime("%Y%m%dT%H%M%SZ");
    let free = (0..).map(|number: u32| {
        let again = if number == 0 {
            String::new()
        } else {
            format!("_{number}")
        };
        folder.join(format!("{column}_{time}{again}.rrd"))
    });
    let found = free.take(1000).find(|path| !path.exists());
    found.ok_or_else(|| ViewerError::File {
        path: folder.to_owned(),
        reason: "every name of this second is taken".to_owned(),
    })
}

/// Only what every file system takes.
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
        let parameters = Parameters::from_values([(
            "column_id",
            crate::parameters::Value::from("../garage a3"),
        )])
        .expect("admissible");
        let new =
            || new_file(folder.path(), &parameters, 1_800_000_000_000_000_000).expect("a name");
        let first = new();
        assert_eq!(first.parent(), Some(folder.path()));
        let name = first.file_name().and_then(|it| it.to_str());
        assert_eq!(name, Some("___garage_a3_20270115T080000Z.rrd"));
        fs::write(&first, "").expect("written");
        assert_ne!(new(), first);
        let error = new_file(&first, &parameters, 0).expect_err("a file is no folder");
        assert!(matches!(error, ViewerError::File { .. }));
    }
}
