//! The state file: read at the start, replaced as a whole, never lost half way. The only IO of the twin.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::saved_state::{SavedState, hex};
use crate::parameters::Parameters;

/// Longest state file that is read \[B\]; the longest that is written is well below.
pub const MAX_STATE_FILE_BYTES: u64 = 4 << 20;

/// Most files that are kept aside.
const MAX_REJECTED: u32 = 100;

/// What a state file held.
#[derive(Debug, Clone, PartialEq)]
pub enum Loaded {
    /// There is none: the column is virgin.
    Absent,
    /// The damage of this column.
    Damage(Box<SavedState>),
    /// It cannot be used: the column is virgin. Say so.
    Rejected {
        /// Why.
        reason: String,
        /// Where the file is now.
        kept_as: PathBuf,
    },
}

/// What went wrong with a state file.
#[derive(Debug, Error)]
pub enum StateFileError {
    /// It is there and cannot be read.
    #[error("the state file {path} cannot be read: {source}; check its permissions")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It cannot be used, nor be moved out of the way.
    #[error(
        "the state file {path} cannot be used ({reason}) nor be renamed to keep it: {source}; move it away"
    )]
    CannotKeep {
        /// The file.
        path: PathBuf,
        /// Why it cannot be used.
        reason: String,
        /// What the system says.
        source: io::Error,
    },
    /// Another twin has it.
    #[error(
        "the state file {path} is in use by another running twin of this column (it holds {lock}); two of them would \
         overwrite each other's damage: stop the other one, or give this one a column_id or a state.directory of its own"
    )]
    InUse {
        /// The file.
        path: PathBuf,
        /// The file beside it that is locked.
        lock: PathBuf,
    },
    /// It cannot be reserved for this twin.
    #[error(
        "the damage cannot be kept: {lock} cannot be made or locked: {source}; check the permissions, choose another \
         state.directory, or an empty one for a damage that ends with the program"
    )]
    NotReserved {
        /// The file beside the state file that would be locked.
        lock: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It cannot be written; the one before is still there.
    #[error(
        "the state file {path} cannot be written: {source}; the damage since the last one is lost at a restart"
    )]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// The state file of these parameters: `state.directory` and the column's name, or `None` where the directory is empty.
#[must_use]
pub fn path(parameters: &Parameters) -> Option<PathBuf> {
    let settings = parameters.settings();
    let directory = &settings.state.directory;
    (!directory.is_empty()).then(|| Path::new(directory).join(file_name(&settings.column_id)))
}

/// A name that every file system takes, and another one for every column: other bytes than letters, digits, `-` and
/// `_` are written as `%` and two digits; a name too long is cut and told apart by a digest.
fn file_name(column_id: &str) -> String {
    use sha2::{Digest, Sha256};
    use std::fmt::Write;
    const MAX_NAME: usize = 200;
    let mut name = String::new();
    for byte in column_id.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' => name.push(char::from(byte)),
            _ => {
                let _ = write!(name, "%{byte:02X}"); // a String takes everything
            }
        }
    }
    if name.len() > MAX_NAME {
        name.truncate(MAX_NAME);
        name.push_str(&hex(&Sha256::digest(column_id)[..8]));
    }
    name + ".json"
}

/// A state file that is this twin's alone for as long as this value lives, whatever ends the program.
#[derive(Debug)]
pub struct Reserved {
    _lock: File,
}

/// Reserves a state file against other programs, and makes its folder. The file beside it that is locked stays behind: to
/// delete it would let a third program lock a new one while a second one holds the old.
///
/// # Errors
/// Another twin has it, or it cannot be made.
pub fn reserve(path: &Path) -> Result<Reserved, StateFileError> {
    let lock = with_suffix(path, ".lock");
    let open = || {
        fs::create_dir_all(folder(path))?;
        File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&lock)
    };
    let locked = open()
        .map_err(TryLockError::Error)
        .and_then(|file| file.try_lock().map(|()| file));
    match locked {
        Ok(file) => Ok(Reserved { _lock: file }),
        Err(TryLockError::WouldBlock) => Err(StateFileError::InUse {
            path: path.to_owned(),
            lock,
        }),
        Err(TryLockError::Error(source)) => Err(StateFileError::NotReserved { lock, source }),
    }
}

/// Reads the state file of the column that has these parameters. One that cannot be used is kept aside under another
/// name.
///
/// # Errors
/// It is there and cannot be read, or cannot be kept aside.
pub fn load(path: &Path, parameters: &Parameters) -> Result<Loaded, StateFileError> {
    let text = match read(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Loaded::Absent),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => {
            return keep_aside(path, error.to_string());
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
        Err(error) => keep_aside(path, error.to_string()),
    }
}

fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?
        .take(MAX_STATE_FILE_BYTES + 1)
        .read_to_string(&mut text)?;
    if text.len() as u64 > MAX_STATE_FILE_BYTES {
        let reason =
            format!("it is longer than {MAX_STATE_FILE_BYTES} bytes: no state file of column_twin");
        return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
    }
    Ok(text)
}

fn keep_aside(path: &Path, reason: String) -> Result<Loaded, StateFileError> {
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

/// Replaces the state file: whoever reads it, and whenever the machine stops, finds the old one or the new one.
///
/// # Errors
/// It cannot be written; the old one is then untouched.
pub fn store(path: &Path, saved: &SavedState) -> Result<(), StateFileError> {
    replace(path, saved).map_err(|source| StateFileError::Unwritable {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, saved: &SavedState) -> io::Result<()> {
    let directory = folder(path);
    fs::create_dir_all(directory)?;
    let new = with_suffix(path, ".new");
    let mut file = File::create(&new)?;
    file.write_all(saved.to_json()?.as_bytes())?;
    file.sync_all()?;
    drop(file);
    fs::rename(&new, path)?;
    File::open(directory)?.sync_all() // the rename, too, is to outlive a power cut
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
    fn columns_have_their_own_files() {
        assert_eq!(file_name("garage_A3"), "garage_A3.json");
        assert_eq!(file_name("../a b"), "%2E%2E%2Fa%20b.json");
        let long = |last: &str| file_name(&("ä".repeat(254) + last));
        assert!(long("a").len() < 255 && long("a") != long("b"));
    }
}
