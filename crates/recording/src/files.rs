//! The files of a recording.

use std::path::{Path, PathBuf};

use crate::bag_metadata::{METADATA_FILE, read_file_names};
use crate::error::RecordingError;
use crate::retention::mcap_files;
use crate::storage::is_being_written;

/// The files of the recording at `path`.
pub(crate) fn files_of(path: &Path) -> Result<Vec<PathBuf>, RecordingError> {
    if !path.exists() {
        return Err(RecordingError::Missing {
            path: path.to_path_buf(),
        });
    }
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let metadata = path.join(METADATA_FILE);
    if !metadata.exists() {
        return Err(no_metadata(path)?);
    }
    let names = read_file_names(&metadata)?;
    names
        .into_iter()
        .map(|name| {
            let file = path.join(&name);
            match file.is_file() {
                true => Ok(file),
                false => Err(RecordingError::MissingFile {
                    path: metadata.clone(),
                    name,
                }),
            }
        })
        .collect()
}

fn no_metadata(path: &Path) -> Result<RecordingError, RecordingError> {
    let files = mcap_files(path).map_err(|source| RecordingError::io("read", path, source))?;
    let path = path.to_path_buf();
    if files.iter().any(|file| is_being_written(file)) {
        return Ok(RecordingError::BeingWritten { path });
    }
    Ok(match files.into_iter().next() {
        Some(file) => RecordingError::NoMetadata { path, file },
        None => RecordingError::NoRecording { path },
    })
}
