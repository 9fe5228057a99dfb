//! The file of a recording. Disk space is reserved ahead of the writing, so that a full disk is noticed before a record is cut
//! in two, and the end of the file still fits.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Weak};

use crate::error::{RecordingError, is_no_room};

/// How much space is reserved at a time \[bytes\].
const STEP: u64 = 4 << 20;

/// A file that is written sequentially. Clones write to the same file.
#[derive(Debug, Clone)]
pub(crate) struct Storage(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    file: File,
    position: AtomicU64,
    reserved: AtomicU64,
    closed: AtomicBool,
}

/// Which file this is, whatever its path: a recording that replaces a removed one may have the same path.
#[derive(Debug, Clone)]
pub(crate) struct FileIdentity(Weak<Shared>);

impl PartialEq for FileIdentity {
    fn eq(&self, other: &Self) -> bool {
        self.0.ptr_eq(&other.0)
    }
}

impl Storage {
    /// Creates a file and locks it while it is open, so that no other program repairs it.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).create_new(true).open(path)?;
        lock(&file);
        Ok(Self(Arc::new(Shared {
            file,
            position: AtomicU64::new(0),
            reserved: AtomicU64::new(0),
            closed: AtomicBool::new(false),
        })))
    }

    /// Does not keep the file open.
    pub fn identity(&self) -> FileIdentity {
        FileIdentity(Arc::downgrade(&self.0))
    }

    /// Bytes written so far.
    pub fn position(&self) -> u64 {
        self.0.position.load(Ordering::Relaxed)
    }

    /// Reserves space up to `end` bytes from the beginning, and some more.
    ///
    /// # Errors
    /// There is no room. If the file system cannot reserve space, the write itself reports that.
    pub fn reserve(&self, end: u64) -> io::Result<()> {
        let reserved = self.0.reserved.load(Ordering::Relaxed);
        if end <= reserved {
            return Ok(());
        }
        let generous = end.saturating_add(STEP);
        let upto = match allocate(&self.0.file, reserved, generous) {
            Err(error) if is_no_room(&error) => {
                allocate(&self.0.file, reserved, end)?;
                end
            }
            // The file system cannot reserve space: go on as if it had.
            Err(_) | Ok(()) => generous,
        };
        self.0.reserved.store(upto, Ordering::Relaxed);
        Ok(())
    }

    /// Releases the reserved space that was not used.
    pub fn release(&self) -> io::Result<()> {
        self.0.reserved.store(self.position(), Ordering::Relaxed);
        self.0.file.set_len(self.position())
    }

    /// Rejects further writes, and truncates the file to `length`.
    pub fn close_at(&self, length: u64) -> io::Result<()> {
        self.0.closed.store(true, Ordering::Relaxed);
        self.0.file.set_len(length)
    }

    /// Whether the file is still at this path. One that was removed can be written to, and nobody will ever read it.
    pub fn is_at(&self, path: &Path) -> bool {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            let place = |it: std::fs::Metadata| (it.dev(), it.ino());
            let own = self.0.file.metadata().map(place).ok();
            // Without an answer nothing is known; an error of the disk shows when the next data is written.
            match std::fs::metadata(path) {
                Ok(found) => own.is_none_or(|own| own == place(found)),
                Err(error) => error.kind() != io::ErrorKind::NotFound,
            }
        }
        #[cfg(not(unix))]
        path.exists()
    }

    /// Waits until the written data would survive a loss of power.
    pub fn sync_data(&self) -> io::Result<()> {
        self.0.file.sync_data()
    }

    /// As [`sync_data`](Self::sync_data), with the metadata of the file.
    pub fn sync_all(&self) -> io::Result<()> {
        self.0.file.sync_all()
    }
}

impl Write for Storage {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0.closed.load(Ordering::Relaxed) {
            return Err(io::Error::other("the recording is closed"));
        }
        let written = (&self.0.file).write(bytes)?;
        self.0.position.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Storage {
    /// Reports the position; cannot seek anywhere else.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position()),
            _ => Err(io::Error::from(io::ErrorKind::NotSeekable)),
        }
    }
}

/// Locks the file. Some file systems have no locks; there, a running recording could be mistaken for a crashed one.
fn lock(file: &File) {
    // A program that tests the lock holds it for a moment.
    const ATTEMPTS: usize = 1000;
    for _ in 0..ATTEMPTS {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::yield_now(),
            Ok(()) | Err(TryLockError::Error(_)) => return,
        }
    }
}

/// Whether a program is writing this file.
pub(crate) fn is_being_written(path: &Path) -> bool {
    // A shared lock, so that two programs can test at the same time.
    let Ok(file) = File::open(path) else {
        return false;
    };
    matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock))
}

/// Data that was handed to the operating system and has to reach the disk.
#[derive(Debug, Clone)]
pub(crate) struct Unsynced {
    pub storage: Storage,
    pub path: PathBuf,
    /// The directory, if its entry for the file is new.
    pub directory: Option<PathBuf>,
}

impl Unsynced {
    /// Waits until the data is on the disk.
    pub fn sync(&self) -> Result<(), RecordingError> {
        self.storage
            .sync_data()
            .map_err(|source| RecordingError::io("sync", &self.path, source))?;
        self.directory.as_deref().map_or(Ok(()), sync_directory)
    }
}

/// Makes a new name survive a loss of power, which needs its directory to be synced.
pub(crate) fn sync_directory(directory: &Path) -> Result<(), RecordingError> {
    for folder in [Some(directory), directory.parent()].into_iter().flatten() {
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        File::open(folder)
            .and_then(|opened| opened.sync_all())
            .map_err(|source| RecordingError::io("sync", folder, source))?;
    }
    Ok(())
}

#[cfg(target_os = "linux")]
fn allocate(file: &File, from: u64, to: u64) -> io::Result<()> {
    use rustix::fs::{FallocateFlags, fallocate};
    Ok(fallocate(file, FallocateFlags::KEEP_SIZE, from, to - from)?)
}

#[cfg(not(target_os = "linux"))]
fn allocate(_: &File, _: u64, _: u64) -> io::Result<()> {
    Err(io::Error::from(io::ErrorKind::Unsupported))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn space_is_reserved_and_released() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut storage = Storage::create(&path).unwrap();
        storage.reserve(1000).unwrap();
        storage.write_all(b"content").unwrap();
        assert_eq!(
            (storage.position(), storage.stream_position().unwrap()),
            (7, 7)
        );
        assert_eq!(std::fs::metadata(&path).unwrap().len(), 7);
        storage.release().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"content");
        storage.close_at(3).unwrap();
        assert!(storage.write_all(b"x").is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"con");
    }

    #[test]
    fn a_file_is_locked_while_it_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let storage = Storage::create(&path).unwrap();
        assert!(is_being_written(&path));
        assert!(Storage::create(&path).is_err());
        drop(storage);
        assert!(!is_being_written(&path));
    }
}
