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
    let content = |what: String| StartError::Content {
        path: path.to_owned(),
        what,
    };
    // Before it is opened: opening a pipe waits until somebody writes to it.
    if !path.metadata().map_err(unreadable)?.is_file() {
        let what = "is a folder, a pipe or a device; give the path of a file";
        return Err(content(what.to_owned()));
    }
    // The mode of the open file: another one may have its name a moment later.
    let file = File::open(path).map_err(unreadable)?;
    let mode = file.metadata().map_err(unreadable)?.mode() & 0o7777;
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

#[cfg(test)]
mod tests {
    use std::os::fd::AsRawFd as _;

    use super::*;

    /// The start of the node waited for a writer, without end.
    #[test]
    fn a_pipe_as_a_secret_is_rejected_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        // No program makes it: a child would hold the locks of the other tests for a moment.
        let (reading, _writing) = std::io::pipe().unwrap();
        let pipe = format!("/proc/self/fd/{}", reading.as_raw_fd());
        for place in [Path::new(&pipe), folder.path()] {
            let fault = read_secret(place).unwrap_err().to_string();
            assert!(fault.contains("give the path of a file"), "{fault}");
        }
    }
}
