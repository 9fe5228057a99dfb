//! The state file: read at the start, and replaced atomically. The only IO of the twin.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bounded_file::read_text_at_most;
use thiserror::Error;

use super::saved_state::SavedState;
use crate::parameters::Parameters;
use crate::state_home;
use printable::Hexadecimal;

/// Maximum size of a state file that is read \[B\]; written files are much smaller.
pub const MAX_STATE_FILE_BYTES: u64 = 4 << 20;

/// Appended to the name of a state file that is being written.
const NEW: &str = ".new";

/// Maximum number of rejected files that are kept.
const MAX_REJECTED: u32 = 100;

/// The outcome of reading a state file.
#[derive(Debug, Clone, PartialEq)]
pub enum Loaded {
    /// There is no file: the column is undamaged.
    Absent,
    /// The saved damage of this column.
    Damage(Box<SavedState>),
    /// The file cannot be used, so the column is undamaged. The caller must report this.
    Rejected {
        /// Why.
        reason: String,
        /// The new name of the file.
        kept_as: PathBuf,
    },
}

/// An error of the state file.
#[derive(Debug, Error)]
pub enum StateFileError {
    /// The file exists, but cannot be read.
    #[error("the state file {path} cannot be read: {source}; check its permissions")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The file cannot be used, and cannot be renamed.
    #[error(
        "the state file {path} cannot be used ({reason}), and cannot be renamed to keep it: {source}; move it away"
    )]
    CannotKeep {
        /// The file.
        path: PathBuf,
        /// Why the file cannot be used.
        reason: String,
        /// The error of the system.
        source: io::Error,
    },
    /// Another twin uses the file.
    #[error(
        "the state file {path} is in use by another running twin of this column, which holds {lock}; two twins would \
         overwrite each other's damage: stop the other one, or start this one with another column_id or state.directory"
    )]
    InUse {
        /// The file.
        path: PathBuf,
        /// The lock file.
        lock: PathBuf,
    },
    /// The folder is in use by another program.
    #[error(
        "the state directory {directory} is in use by {by}, which holds {lock}; two programs would overwrite each other's \
         damage: stop the other one, or set another state.directory"
    )]
    FolderInUse {
        /// The folder.
        directory: PathBuf,
        /// By whom.
        by: &'static str,
        /// The lock file.
        lock: PathBuf,
    },
    /// The lock file cannot be created or locked.
    #[error(
        "the damage cannot be saved, because {lock} cannot be created or locked: {source}; check its permissions, set \
         another state.directory, or set it to '' to run without saving"
    )]
    NotReserved {
        /// The lock file.
        lock: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The file cannot be written; the previous one is unchanged.
    #[error(
        "the state file {path} cannot be written: {source}; a restart would lose the damage since the last successful write"
    )]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
}

/// The path of the state file: `state.directory` and a name for the column; `None` if `state.directory` is empty.
#[must_use]
pub fn path(parameters: &Parameters) -> Option<PathBuf> {
    let settings = parameters.settings();
    let directory = &settings.state.directory;
    (!directory.is_empty())
        .then(|| state_home::resolve(directory).join(file_name(&settings.column_id)))
}

/// A unique file name for a column, which every file system accepts: bytes other than letters, digits, `-` and `_` are
/// written as `%` and two digits; a name that is too long is cut, and a digest is appended.
fn file_name(column_id: &str) -> String {
    use sha2::{Digest, Sha256};
    use std::fmt::Write;
    const MAX_NAME: usize = 200;
    let mut name = String::new();
    for byte in column_id.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' => name.push(char::from(byte)),
            _ => {
                let _ = write!(name, "%{byte:02X}"); // writing to a String cannot fail
            }
        }
    }
    if name.len() > MAX_NAME {
        name.truncate(MAX_NAME);
        let digest = Sha256::digest(column_id);
        let _ = write!(name, "{}", Hexadecimal(&digest[..8])); // writing to a String cannot fail
    }
    name + ".json"
}

/// The exclusive use of a state file, or of a folder of state files, until this value is dropped or the program ends, even by a
/// crash.
#[derive(Debug)]
pub struct Reserved {
    _locks: Vec<File>,
}

/// The lock of a folder, which single twins share and a fleet has for itself. The file of a column always has another name.
const FOLDER_LOCK: &str = "fleet.lock";

/// Reserves a state file for this program, and creates its folder. The lock file is never deleted: otherwise a third
/// program could lock a new file while a second one still holds the deleted one.
///
/// # Errors
/// Another twin uses the file, or the lock file cannot be created.
pub fn reserve(path: &Path) -> Result<Reserved, StateFileError> {
    let directory = folder(path);
    let of_folder = directory.join(FOLDER_LOCK);
    let shared = locked(&of_folder, File::try_lock_shared, || {
        StateFileError::FolderInUse {
            directory: directory.to_owned(),
            by: "a running fleet",
            lock: of_folder.clone(),
        }
    })?;
    let lock = with_suffix(path, ".lock");
    let own = locked(&lock, File::try_lock, || StateFileError::InUse {
        path: path.to_owned(),
        lock: lock.clone(),
    })?;
    Ok(Reserved {
        _locks: vec![own, shared],
    })
}

/// Reserves a folder of state files for a fleet, and creates it: one lock for all columns.
///
/// # Errors
/// A fleet or a twin uses the folder, or the lock file cannot be created.
pub fn reserve_folder(directory: &Path) -> Result<Reserved, StateFileError> {
    let lock = directory.join(FOLDER_LOCK);
    let own = locked(&lock, File::try_lock, || StateFileError::FolderInUse {
        directory: directory.to_owned(),
        by: "another running fleet, or by a running twin of a single column",
        lock: lock.clone(),
    })?;
    Ok(Reserved { _locks: vec![own] })
}

fn locked(
    lock: &Path,
    how: impl FnOnce(&File) -> Result<(), TryLockError>,
    in_use: impl FnOnce() -> StateFileError,
) -> Result<File, StateFileError> {
    let open = || {
        fs::create_dir_all(folder(lock))?;
        let mut options = File::options();
        options.create(true).truncate(false).write(true);
        // Who can open the file can hold the lock, and keep the twin from starting.
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = options.open(lock)?;
        #[cfg(unix)]
        restrict(&file);
        Ok(file)
    };
    let locked = open()
        .map_err(TryLockError::Error)
        .and_then(|file| how(&file).map(|()| file));
    locked.map_err(|error| match error {
        TryLockError::WouldBlock => in_use(),
        TryLockError::Error(source) => StateFileError::NotReserved {
            lock: lock.to_owned(),
            source,
        },
    })
}

/// Restricts a lock file of earlier versions, as far as it is ours.
#[cfg(unix)]
fn restrict(file: &File) {
    use std::os::unix::fs::PermissionsExt;
    // Where it belongs to another user, it stays as that user has made it.
    let _ = file.set_permissions(fs::Permissions::from_mode(0o600));
}

/// Reads the state file for the column with these parameters. A file that cannot be used is kept under another name.
///
/// A program that was killed may have written the newest damage completely, and not yet renamed its file: then it is renamed now.
///
/// # Errors
/// The file exists but cannot be read, or cannot be renamed.
pub fn load(path: &Path, parameters: &Parameters) -> Result<Loaded, StateFileError> {
    complete_write(path, parameters).map_err(|source| StateFileError::Unreadable {
        path: path.to_owned(),
        source,
    })?;
    let text = match read_text_at_most(path, MAX_STATE_FILE_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Loaded::Absent),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => {
            return reject(
                path,
                format!("it is not a state file of column_twin: {error}"),
            );
        }
        Err(source) => {
            return Err(StateFileError::Unreadable {
                path: path.to_owned(),
                source,
            });
        }
    };
    match SavedState::from_json(&text, parameters) {
        Ok(saved) => Ok(Loaded::Damage(Box::new(saved))),
        Err(error) => reject(path, error.to_string()),
    }
}

/// Completes a write that was interrupted, unless the state file has been replaced since.
fn complete_write(path: &Path, parameters: &Parameters) -> io::Result<()> {
    let new = with_suffix(path, NEW);
    let Ok(text) = read_text_at_most(&new, MAX_STATE_FILE_BYTES) else {
        return Ok(());
    };
    let modified = |path: &Path| fs::metadata(path).and_then(|it| it.modified()).ok();
    let is_newer = modified(&new) >= modified(path);
    if is_newer && SavedState::from_json(&text, parameters).is_ok() {
        fs::rename(&new, path)?;
    }
    Ok(())
}

fn reject(path: &Path, reason: String) -> Result<Loaded, StateFileError> {
    let kept_as = (1..MAX_REJECTED)
        .map(|number| with_suffix(path, &format!(".rejected-{number}")))
        .find(|free| !free.exists())
        .unwrap_or_else(|| with_suffix(path, &format!(".rejected-{MAX_REJECTED}")));
    match fs::rename(path, &kept_as) {
        Ok(()) => Ok(Loaded::Rejected { reason, kept_as }),
        Err(source) => Err(StateFileError::CannotKeep {
            path: path.to_owned(),
            reason,
            source,
        }),
    }
}

/// Replaces the state file atomically: a reader, or a restart after a power failure, finds either the old or the new one.
///
/// # Errors
/// The file cannot be written; the old one is unchanged.
pub fn store(path: &Path, saved: &SavedState) -> Result<(), StateFileError> {
    replace(path, saved).map_err(|source| StateFileError::Unwritable {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, saved: &SavedState) -> io::Result<()> {
    let directory = folder(path);
    fs::create_dir_all(directory)?;
    let new = with_suffix(path, NEW);
    let mut file = File::create(&new)?;
    file.write_all(saved.to_json()?.as_bytes())?;
    file.sync_all()?;
    drop(file);
    fs::rename(&new, path)?;
    File::open(directory)?.sync_all() // so that the rename survives a power failure
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name: OsString = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn other_users_cannot_open_the_lock_files() {
        use std::os::unix::fs::PermissionsExt;
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("column.json");
        // As an earlier version has made it.
        let own = root.path().join("column.json.lock");
        File::create(&own).expect("a file");
        fs::set_permissions(&own, fs::Permissions::from_mode(0o644)).expect("ours");
        let _reserved = reserve(&path).expect("free");
        for lock in [own, root.path().join(FOLDER_LOCK)] {
            let mode = fs::metadata(&lock).expect("a file").permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "{}", lock.display());
        }
    }

    #[test]
    fn a_state_file_has_one_owner() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("state/column.json");
        let first = reserve(&path).expect("free");
        let second = reserve(&path).expect_err("taken").to_string();
        assert!(
            second.contains("in use by another running twin"),
            "{second}"
        );
        drop(first);
        reserve(&path).expect("free again");
        fs::write(root.path().join("file"), "").expect("written");
        let below_a_file = reserve(&root.path().join("file/column.json"));
        assert!(matches!(
            below_a_file,
            Err(StateFileError::NotReserved { .. })
        ));
    }

    #[test]
    fn a_folder_belongs_to_one_fleet_or_to_single_twins() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("state");
        let fleet = reserve_folder(&folder).expect("free");
        for rejected in [
            reserve_folder(&folder),
            reserve(&folder.join("column.json")),
        ] {
            let rejected = rejected.expect_err("taken").to_string();
            assert!(rejected.contains("is in use by"), "{rejected}");
            assert!(
                rejected.contains("set another state.directory"),
                "{rejected}"
            );
        }
        drop(fleet);
        let twins = ["a.json", "b.json"].map(|it| reserve(&folder.join(it)).expect("free"));
        assert!(reserve_folder(&folder).is_err());
        drop(twins);
        reserve_folder(&folder).expect("free again");
    }

    #[test]
    fn columns_have_their_own_files() {
        assert_eq!(file_name("garage_A3"), "garage_A3.json");
        assert_eq!(file_name("../a b"), "%2E%2E%2Fa%20b.json");
        let long = |last: &str| file_name(&("ä".repeat(254) + last));
        assert!(long("a").len() < 255 && long("a") != long("b"));
    }
}
