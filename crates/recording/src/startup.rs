//! What a recorder does at its start with the recordings that a crash has cut off.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::bag_metadata::METADATA_FILE;
use crate::repair::{TEMPORARY, beside, repair_unless};
use crate::report::RecorderReport;
use crate::retention::{find_recordings, mcap_files};
use crate::session::RecorderOptions;
use crate::storage::is_being_written;

/// Maximum number of recordings that are repaired at a start, the newest first.
const MAX_REPAIRS: usize = 16;

/// Repairs the recordings in the directory that were cut off by a crash.
pub(crate) fn repair_unfinished(options: &RecorderOptions, stop: &AtomicBool) {
    remove_temporary(&options.directory);
    let unfinished: Vec<PathBuf> = find_recordings(&options.application, &options.directory)
        .into_iter()
        .map(|found| found.directory)
        .filter(|directory| is_unfinished(directory))
        .collect();
    for directory in unfinished.into_iter().rev().take(MAX_REPAIRS) {
        let report = match repair_unless(&directory, None, stop) {
            Ok(None) => continue,
            Ok(Some(repaired)) => RecorderReport::Repaired(Box::new(repaired)),
            Err(_) if stop.load(Ordering::Relaxed) => return,
            Err(error) => RecorderReport::NotRepaired {
                directory,
                reason: error.to_string(),
            },
        };
        options.report(&report);
    }
}

fn is_unfinished(directory: &Path) -> bool {
    let files = mcap_files(directory).unwrap_or_default();
    !files.is_empty()
        && !directory.join(METADATA_FILE).exists()
        && !beside(directory).exists()
        && !files.iter().any(|file| is_being_written(file))
}

/// Removes the directories of repairs that were themselves cut off.
fn remove_temporary(parent: &Path) {
    let entries = fs::read_dir(parent).into_iter().flatten().flatten();
    for temporary in entries.filter(|it| it.file_name().to_string_lossy().starts_with(TEMPORARY)) {
        let inside = fs::read_dir(temporary.path())
            .into_iter()
            .flatten()
            .flatten();
        let mut files = inside.flat_map(|it| mcap_files(&it.path()).unwrap_or_default());
        if !files.any(|file| is_being_written(&file)) {
            // If this fails, the next start tries again.
            let _ = fs::remove_dir_all(temporary.path());
        }
    }
}
