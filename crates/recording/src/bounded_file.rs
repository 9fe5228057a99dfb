//! Reads a file that is expected to be short. Whatever the path leads to, such as a device that never ends, no more is read.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Reads all of a file of at most `most` bytes.
pub(crate) fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // The length that the system states is no bound: that of a device is zero.
    File::open(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let reason = format!("expected at most {most} bytes, found more");
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    Ok(bytes)
}
