//! Waits for what the recorder has written.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use column_twin::recording::{Message, Reader};

use super::domain::PATIENCE;

/// Waits until a recording in this directory has such a message, which is published before it is written.
pub fn wait_until_written(directory: &Path, what: &str, is: impl Fn(&Message) -> bool) {
    let files_in = |path: &Path| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        entries.map(|it| it.path()).collect()
    };
    let has_it = |file: &PathBuf| {
        let reader = Reader::open(file);
        reader.is_ok_and(|it| it.messages().flatten().any(|it| is(&it)))
    };
    let deadline = Instant::now() + PATIENCE;
    while !files_in(directory)
        .iter()
        .any(|recording| files_in(recording).iter().any(has_it))
    {
        assert!(Instant::now() < deadline, "not written: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}
