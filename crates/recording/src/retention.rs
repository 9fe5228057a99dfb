//! Which of the old recordings stay.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::bag_metadata::METADATA_FILE;
use crate::names::directory_time;
use crate::storage::is_being_written;

/// Most recordings that are looked at.
const MOST: usize = 1_000_000;

/// What may be kept; `None`: without limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kept {
    /// Recordings.
    pub files: Option<u64>,
    /// Bytes of all together.
    pub total_size: Option<u64>,
    /// Time since the beginning.
    pub age: Option<Duration>,
}

/// A recording of ours on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Found {
    pub directory: PathBuf,
    pub began: SystemTime,
    pub bytes: u64,
}

/// Our recordings in a directory, the oldest first; others are not looked at.
pub(crate) fn find_recordings(application: &str, parent: &Path) -> Vec<Found> {
    let Ok(entries) = fs::read_dir(parent) else {
        return Vec::new();
    };
    let mut found: Vec<Found> = entries
        .take(MOST)
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

/// Files of a recording; `None` where there is anything else, which then is none of ours.
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

/// The MCAP files of a recording, by name.
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

/// Deletes the oldest recordings until no more is kept than may be, but never `current` nor one that another program
/// writes. Says which.
pub(crate) fn delete_what_is_too_much(
    application: &str,
    parent: &Path,
    current: &Path,
    now: SystemTime,
    kept: Kept,
) -> Vec<PathBuf> {
    if kept
        == (Kept {
            files: None,
            total_size: None,
            age: None,
        })
    {
        return Vec::new();
    }
    let found = find_recordings(application, parent);
    let superfluous = superfluous(&found, now, kept);
    let is_idle = |directory: &Path| {
        let files = mcap_files(directory).unwrap_or_default();
        directory != current && !files.iter().any(|file| is_being_written(file))
    };
    let directories = superfluous.into_iter().map(|it| it.directory);
    directories
        .filter(|directory| is_idle(directory) && delete(directory).is_ok())
        .collect()
}

/// Those that are too old, and the oldest of those that are too many or too large together.
fn superfluous(found: &[Found], now: SystemTime, kept: Kept) -> Vec<Found> {
    let mut files = found.len() as u64;
    let mut bytes: u64 = found.iter().map(|it| it.bytes).sum();
    let mut superfluous = Vec::new();
    for it in found {
        let age = now.duration_since(it.began).unwrap_or_default();
        let too_much = kept.files.is_some_and(|most| files > most)
            || kept.total_size.is_some_and(|most| bytes > most)
            || kept.age.is_some_and(|most| age > most);
        if too_much {
            files -= 1;
            bytes -= it.bytes;
            superfluous.push(it.clone());
        }
    }
    superfluous
}

/// Removes the files one by one: should somebody have put something there meanwhile, it stays.
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

    const NONE: Kept = Kept {
        files: None,
        total_size: None,
        age: None,
    };

    fn hour(hours: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(3600 * hours)
    }

    fn deleted(kept: Kept) -> Vec<u64> {
        let found: Vec<Found> = (0..5)
            .map(|index| Found {
                directory: PathBuf::from(index.to_string()),
                began: hour(index),
                bytes: 10,
            })
            .collect();
        let name = |it: &Found| it.directory.to_string_lossy().parse().unwrap();
        superfluous(&found, hour(5), kept)
            .iter()
            .map(name)
            .collect()
    }

    #[test]
    fn the_oldest_go_first() {
        assert!(deleted(NONE).is_empty());
        assert_eq!(
            deleted(Kept {
                files: Some(3),
                ..NONE
            }),
            [0, 1]
        );
        assert_eq!(
            deleted(Kept {
                total_size: Some(25),
                ..NONE
            }),
            [0, 1, 2]
        );
        assert_eq!(
            deleted(Kept {
                age: Some(Duration::from_secs(2 * 3600)),
                ..NONE
            }),
            [0, 1, 2]
        );
    }

    #[test]
    fn nothing_but_idle_recordings_of_ours_is_deleted() {
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
        let kept = Kept {
            files: Some(0),
            ..NONE
        };
        let deleted = delete_what_is_too_much(
            "column_twin",
            parent.path(),
            &current,
            SystemTime::now(),
            kept,
        );
        assert_eq!(deleted, std::slice::from_ref(&old));
        assert!(!old.exists());
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 4);
    }
}
