#![doc = include_str!("../README.md")]

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Reads all of a file of at most `most` bytes. Whatever the path leads to, such as a device that never ends, no more is read;
/// then the error is [`InvalidData`](io::ErrorKind::InvalidData). A pipe with a name is
/// [`InvalidInput`](io::ErrorKind::InvalidInput).
///
/// # Errors
/// Those of the system; the file is longer; it is a pipe with a name.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if is_named_pipe(path)? {
        let reason = "it is a pipe; expected a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let mut bytes = Vec::new();
    // The length that the system states is no bound: that of a device is zero.
    File::open(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let reason = format!("it is larger than {most} bytes, the most that is read");
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    Ok(bytes)
}

/// Whether opening the path could wait without end for somebody who writes. A pipe among the open files of this process, as the
/// shell passes it for `<(command)`, has a writer.
#[cfg(unix)]
fn is_named_pipe(path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::FileTypeExt as _;
    let is_open = path.starts_with("/dev") || path.starts_with("/proc");
    Ok(!is_open && path.metadata()?.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_named_pipe(_: &Path) -> io::Result<bool> {
    Ok(false)
}

/// Reads all of a text as [`read_at_most`] does.
///
/// # Errors
/// Those of [`read_at_most`]; the bytes are not UTF-8.
pub fn read_text_at_most(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read_at_most(path, most)?).map_err(|error| {
        let reason = format!("not UTF-8 text (byte {})", error.utf8_error().valid_up_to());
        io::Error::new(io::ErrorKind::InvalidData, reason)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_bound() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "12345").unwrap();
        assert_eq!(read_text_at_most(file.path(), 5).unwrap(), "12345");
        let error = read_at_most(file.path(), 4).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        assert!(error.to_string().contains("larger than 4 bytes"), "{error}");
        std::fs::write(file.path(), b"a\xff").unwrap();
        let error = read_text_at_most(file.path(), 5).unwrap_err();
        assert!(error.to_string().contains("byte 1"), "{error}");
    }

    /// The start of the program waited for a writer, without end.
    #[cfg(unix)]
    #[test]
    fn a_pipe_with_a_name_is_rejected_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        // No program makes it: a child would hold the locks of the other tests for a moment.
        let (reading, _writing) = std::io::pipe().unwrap();
        let open = format!(
            "/proc/self/fd/{}",
            std::os::fd::AsRawFd::as_raw_fd(&reading)
        );
        std::os::unix::fs::symlink(open, &pipe).unwrap();
        let error = read_at_most(&pipe, 5).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        assert!(error.to_string().contains("expected a file"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_an_endless_file_is_read_up_to_the_bound() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        let error = read_at_most(&link, 1000).unwrap_err();
        assert!(error.to_string().contains("larger than 1000"), "{error}");
    }
}
