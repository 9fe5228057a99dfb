//! Files that hold secrets or certificates.

use std::fs::File;
use std::io::Read as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use crate::error::StartError;

/// Longest file of a secret, certificate or key \[bytes\].
const MAX_BYTES: u64 = 1 << 20;

/// Reads a file that only its owner may read.
pub(crate) fn read_secret(path: &Path) -> Result<String, StartError> {
    read(path, true)
}

/// Reads a file that anybody may read.
pub(crate) fn read_public(path: &Path) -> Result<String, StartError> {
    read(path, false)
}

fn read(path: &Path, secret: bool) -> Result<String, StartError> {
    let unreadable = |fault| StartError::File {
        path: path.to_owned(),
        fault,
    };
    // The mode of the open file: another one may have its name a moment later.
    let file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    let content = |what: String| StartError::Content {
        path: path.to_owned(),
        what,
    };
    if !metadata.is_file() {
        return Err(content("is not a file".to_owned()));
    }
    let mode = metadata.mode() & 0o7777;
    if secret && mode & 0o077 != 0 {
        return Err(StartError::Mode {
            path: path.to_owned(),
            mode,
        });
    }
    let mut text = String::new();
    file.take(MAX_BYTES + 1)
        .read_to_string(&mut text)
        .map_err(unreadable)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(content(format!("is longer than {MAX_BYTES} bytes")));
    }
    if text.trim().is_empty() {
        return Err(content("is empty".to_owned()));
    }
    Ok(text)
}
