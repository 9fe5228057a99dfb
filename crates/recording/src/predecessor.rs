//! The recording before a sealed one. A recorder that begins a new recording notes what the last seal of the one before has
//! signed, so that the removal of a recording from the middle of a session can be noticed.

use std::fs;
use std::path::{Path, PathBuf};

use mcap::records::Record;

use crate::reader::Reader;
use crate::records::RecordReader;
use crate::retention::mcap_files;
use crate::seal::{BEGIN, Beginning};
use crate::seal_check::Seal;

/// Maximum number of directory entries that are examined.
const MAX_ENTRIES: usize = 100_000;

/// Maximum number of records that are read to find the beginning of a seal; a recorder declares its topics before it.
const MAX_RECORDS: usize = 10_000;

/// What is in the folder of a sealed recording of the recording before it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Predecessor {
    /// The recording is the first of its session.
    None,
    /// The recording before it, up to its last seal.
    Found(PathBuf),
    /// Neither the recording before it nor an earlier one of the session: they were deleted to keep within the limits, or are
    /// in another place.
    Gone {
        /// Name of the recording before it.
        name: String,
    },
    /// The recording before it is missing, although an earlier one of the session is there.
    Missing {
        /// Name of the recording before it.
        name: String,
        /// An earlier recording.
        earlier: PathBuf,
    },
    /// A recording that claims to be the one before it, and ends with something else than this recording continues.
    Changed(PathBuf),
}

impl Predecessor {
    /// Whether a recording was removed, changed or replaced.
    #[must_use]
    pub fn is_fault(&self) -> bool {
        matches!(self, Self::Missing { .. } | Self::Changed(_))
    }
}

/// Looks for the recording before the one in `file` with this seal, in the folder that contains its directory.
pub(crate) fn find(file: &Path, seal: &Seal) -> Predecessor {
    let Some(previous) = &seal.previous else {
        return Predecessor::None;
    };
    let name = previous.name.clone();
    let whole = fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
    let Some(folder) = whole.parent().and_then(Path::parent) else {
        return Predecessor::Gone { name };
    };
    let (mut earlier, mut changed) = (None, None);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for directory in entries.take(MAX_ENTRIES).map(|it| it.path()) {
        let Some(other) = beginning_of(&directory) else {
            continue;
        };
        if crate::chain::to_hex(&other.session) != seal.session || other.recording >= seal.recording
        {
            continue;
        }
        if other.recording + 1 < seal.recording {
            earlier.get_or_insert(directory);
        } else if ends_with(&directory, |it| it.head == previous.head) {
            return Predecessor::Found(directory);
        } else {
            changed.get_or_insert(directory);
        }
    }
    // A recording of another run has a different session, even with the same key: it replaced the predecessor.
    let in_its_place = named(folder, &name).filter(|it| beginning_of(it).is_some());
    match (changed.or(in_its_place), earlier) {
        (Some(directory), _) => Predecessor::Changed(directory),
        (None, Some(earlier)) => Predecessor::Missing { name, earlier },
        (None, None) => Predecessor::Gone { name },
    }
}

/// Looks in the folder that contains the directory of `file` for a recording by the same key that continues a recording with the
/// name of this directory, but not the one with this seal: that was replaced.
pub(crate) fn contradicting_successor(file: &Path, seal: &Seal) -> Option<PathBuf> {
    let whole = fs::canonicalize(file).ok()?;
    let own = whole.parent()?;
    let name = own.file_name()?.to_str()?;
    let follows_other = |next: &Beginning| {
        let previous = next.previous.as_ref().filter(|it| it.name == name);
        previous.is_some_and(|previous| {
            Some(next.public_key) == seal.public_key
                && (previous.head != seal.head
                    || crate::chain::to_hex(&next.session) != seal.session)
        })
    };
    let entries = fs::read_dir(own.parent()?).ok()?.flatten();
    let directories = entries.take(MAX_ENTRIES).map(|it| it.path());
    directories
        .filter(|it| it != own && beginning_of(it).is_some_and(|next| follows_other(&next)))
        // Only its owner can have sealed it with the key.
        .find(|it| ends_with(it, |_| true))
}

/// The directory with this name in a folder, if the name is one.
fn named(folder: &Path, name: &str) -> Option<PathBuf> {
    let is_plain = Path::new(name).file_name().is_some_and(|it| it == name);
    is_plain.then(|| folder.join(name)).filter(|it| it.is_dir())
}

/// Whether the recording in this directory holds, and its last seal is as expected.
fn ends_with(directory: &Path, expected: impl Fn(&Seal) -> bool) -> bool {
    let opened = mcap_files(directory).map(|files| Reader::open_files(directory, files));
    let Ok(Ok(reader)) = opened else {
        return false;
    };
    matches!(reader.seals(), [Some(seal)] if seal.holds() && expected(seal))
}

/// The beginning of the seal of the recording in this directory.
fn beginning_of(directory: &Path) -> Option<Beginning> {
    let file = mcap_files(directory).ok()?.into_iter().next()?;
    let mut records = RecordReader::open(&file).ok()?;
    for _ in 0..MAX_RECORDS {
        match records.next().ok()?? {
            Record::Metadata(it) if it.name == BEGIN => return Beginning::parse(&it.metadata).ok(),
            Record::Metadata(_) | Record::Message { .. } => return None,
            _ => {}
        }
    }
    None
}
