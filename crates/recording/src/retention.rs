//! Deletes old recordings to keep within the limits.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::bag_metadata::METADATA_FILE;
use crate::names::directory_time;
use crate::storage::is_being_written;

/// Maximum number of directory entries that are examined.
const MAX_ENTRIES: usize = 1_000_000;

/// Limits of what is kept; `None` is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Number of recordings.
    pub files: Option<u64>,
    /// Size of all recordings together \[bytes\].
    pub total_size: Option<u64>,
    /// Time since a recording began.
    pub age: Option<Duration>,
}

/// A recording on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Found {
    pub directory: PathBuf,
    pub began: SystemTime,
    pub bytes: u64,
}

/// The recordings of `application` in a directory, the oldest first; everything else is ignored.
pub(crate) fn find_recordings(application: &str, parent: &Path) -> Vec<Found> {
    let Ok(entries) = fs::read_dir(parent) else {
        return Vec::new();
    };
    let mut found: Vec<Found> = entries
        .take(MAX_ENTRIES)
        .filter_map(Result::ok)
        .filter_map(|entry| {
            let began = directory_time(application, &entry.file_name().to_string_lossy())?;
            let directory = entry.path();
            let files = files_of(&directory)?;
            let bytes = files
                .iter()
                .filter_map(|file| file.metadata().ok())
                .map(|it| it.len())
                .sum();
            Some(Found {
                directory,
                began,
                bytes,
            })
        })
        .collect();
    found.sort_by(|a, b| (a.began, &a.directory).cmp(&(b.began, &b.directory)));
    found
}

/// Files of a recording; `None` if the directory contains anything else, and so was not written by a recorder.
fn files_of(directory: &Path) -> Option<Vec<PathBuf>> {
    if directory.symlink_metadata().ok()?.file_type().is_symlink() {
        return None;
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).ok()? {
        let path = entry.ok()?.path();
        let ours = path.file_name().is_some_and(|name| name == METADATA_FILE)
            || path
                .extension()
                .is_some_and(|extension| extension == "mcap");
        if !ours || !path.is_file() {
            return None;
        }
        files.push(path);
    }
    Some(files)
}

/// The MCAP files of a recording, sorted by name.
pub(crate) fn mcap_files(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "mcap")
            && path.is_file()
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Deletes the oldest recordings until the limits are kept, but never `current` nor one that is being written.
/// Returns what was deleted.
pub(crate) fn enforce_limits(
    application: &str,
    parent: &Path,
    current: &Path,
    now: SystemTime,
    limits: Limits,
) -> Vec<PathBuf> {
    if limits
        == (Limits {
            files: None,
            total_size: None,
            age: None,
        })
    {
        return Vec::new();
    }
    let found = find_recordings(application, parent);
    let superfluous = superfluous(&found, now, limits);
    let is_idle = |directory: &Path| {
        let files = mcap_files(directory).unwrap_or_default();
        directory != current && !files.iter().any(|file| is_being_written(file))
    };
    let directories = superfluous.into_iter().map(|it| it.directory);
    directories
        .filter(|directory| is_idle(directory) && delete(directory).is_ok())
        .collect()
}

/// The recordings that are too old, and the oldest of those that are too many or too large together.
fn superfluous(found: &[Found], now: SystemTime, limits: Limits) -> Vec<Found> {
    let mut files = found.len() as u64;
    let mut bytes: u64 = found.iter().map(|it| it.bytes).sum();
    let mut superfluous = Vec::new();
    for it in found {
        let age = now.duration_since(it.began).unwrap_or_default();
        let too_much = limits.files.is_some_and(|max| files > max)
            || limits.total_size.is_some_and(|max| bytes > max)
            || limits.age.is_some_and(|max| age > max);
        if too_much {
            files -= 1;
            bytes -= it.bytes;
            superfluous.push(it.clone());
        }
    }
    superfluous
}

/// Removes the files one by one, so that a file of another program that appeared meanwhile is not deleted.
fn delete(directory: &Path) -> io::Result<()> {
    for file in files_of(directory).unwrap_or_default() {
        fs::remove_file(file)?;
    }
    fs::remove_dir(directory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::UNIX_EPOCH;

    const NONE: Limits = Limits {
        files: None,
        total_size: None,
        age: None,
    };

    fn hour(hours: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(3600 * hours)
    }

    fn deleted(limits: Limits) -> Vec<u64> {
        let found: Vec<Found> = (0..5)
            .map(|index| Found {
                directory: PathBuf::from(index.to_string()),
                began: hour(index),
                bytes: 10,
            })
            .collect();
        let name = |it: &Found| it.directory.to_string_lossy().parse().unwrap();
        superfluous(&found, hour(5), limits)
            .iter()
            .map(name)
            .collect()
    }

    #[test]
    fn the_oldest_go_first() {
        assert!(deleted(NONE).is_empty());
        assert_eq!(
            deleted(Limits {
                files: Some(3),
                ..NONE
            }),
            [0, 1]
        );
        assert_eq!(
            deleted(Limits {
                total_size: Some(25),
                ..NONE
            }),
            [0, 1, 2]
        );
        assert_eq!(
            deleted(Limits {
                age: Some(Duration::from_secs(2 * 3600)),
                ..NONE
            }),
            [0, 1, 2]
        );
    }

    #[test]
    fn only_idle_recordings_of_the_application_are_deleted() {
        let parent = tempfile::tempdir().unwrap();
        let make = |name: &str, file: &str| {
            let directory = parent.path().join(name);
            fs::create_dir(&directory).unwrap();
            fs::write(directory.join(file), "x").unwrap();
            directory
        };
        let old = make("column_twin_2026_01_01-00_00_00", "a_0.mcap");
        let current = make("column_twin_2026_01_02-00_00_00", "a_0.mcap");
        make("column_twin_2026_01_03-00_00_00", "notes.txt");
        make("rosbag2_2026_01_01-00_00_00", "a_0.mcap");
        let written = make("column_twin_2026_01_04-00_00_00", "a_0.mcap");
        let file = fs::File::options()
            .write(true)
            .open(written.join("a_0.mcap"))
            .unwrap();
        file.lock().unwrap();
        let limits = Limits {
            files: Some(0),
            ..NONE
        };
        let deleted = enforce_limits(
            "column_twin",
            parent.path(),
            &current,
            SystemTime::now(),
            limits,
        );
        assert_eq!(deleted, std::slice::from_ref(&old));
        assert!(!old.exists());
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 4);
    }
}
