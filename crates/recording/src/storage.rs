//! The file under a recording: room is set aside ahead of what is written, so that a disk that fills up is noticed before
//! a record is cut in two, and what ends the file still fits.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::is_no_room;

/// How much room is set aside at a time \[bytes\].
const STEP: u64 = 4 << 20;

/// A file that is written from its beginning to its end. Clones write to the same file.
#[derive(Debug, Clone)]
pub(crate) struct Storage(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    file: File,
    position: AtomicU64,
    reserved: AtomicU64,
    closed: AtomicBool,
}

impl Storage {
    /// A new file, locked against a repair by another program for as long as it is open.
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

    /// Bytes that were written.
    pub fn position(&self) -> u64 {
        self.0.position.load(Ordering::Relaxed)
    }

    /// Sets room aside up to `end` bytes from the beginning, and some more.
    ///
    /// # Errors
    /// There is no room. Where the file system cannot tell beforehand, it is said when writing.
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
            // A file system without this; then it is as if it had been granted.
            Err(_) | Ok(()) => generous,
        };
        self.0.reserved.store(upto, Ordering::Relaxed);
        Ok(())
    }

    /// Gives back the room that was set aside and not used.
    pub fn release(&self) -> io::Result<()> {
        self.0.reserved.store(self.position(), Ordering::Relaxed);
        self.0.file.set_len(self.position())
    }

    /// Writes nothing any more, and cuts off what stands behind `length`.
    pub fn close_at(&self, length: u64) -> io::Result<()> {
        self.0.closed.store(true, Ordering::Relaxed);
        self.0.file.set_len(length)
    }

    /// Waits until what was written would survive a loss of power.
    pub fn sync_data(&self) -> io::Result<()> {
        self.0.file.sync_data()
    }

    /// As [`sync_data`](Self::sync_data), with all that is known of the file.
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
    /// Says where it is; goes nowhere else.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position()),
            _ => Err(io::Error::from(io::ErrorKind::NotSeekable)),
        }
    }
}

/// Not every file system has locks; without one a running recording could be taken for a crashed one.
fn lock(file: &File) {
    // Who looks whether it is locked holds it for a moment.
    const ATTEMPTS: usize = 1000;
    for _ in 0..ATTEMPTS {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => std::thread::yield_now(),
            Ok(()) | Err(TryLockError::Error(_)) => return,
        }
    }
}

/// Whether another program writes this file.
pub(crate) fn is_being_written(path: &Path) -> bool {
    // A lock for reading, which two programs that look at the same time do not refuse each other.
    let Ok(file) = File::open(path) else {
        return false;
    };
    matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock))
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
    fn room_is_set_aside_and_given_back() {
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
