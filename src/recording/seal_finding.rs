//! What the seal of a recording proves, in words.

use std::fmt;
use std::path::{Path, PathBuf};

use rosbag2_mcap::{Predecessor, PublicKey, Reader, RecordingError, Seal};
use serde_json::{Value as Json, json};

use super::instant;

/// The seals of a recording, one for each of its files, and what is demanded of them.
#[derive(Debug, Clone, PartialEq)]
pub struct SealFinding {
    files: Vec<FileSeal>,
    predecessor: Option<Predecessor>,
    trusted: Vec<PublicKey>,
    is_required: bool,
    /// Whether each file must end with its final seal.
    must_be_final: bool,
    /// The recording in the same folder that continues another one than this.
    successor: Option<PathBuf>,
    /// Whether a file ends in the middle of a record, of which other readers may read a part.
    ends_in_record: bool,
}

#[derive(Debug, Clone, PartialEq)]
struct FileSeal {
    name: String,
    seal: Option<Seal>,
}

impl SealFinding {
    /// The seals, with nothing demanded of them.
    #[must_use]
    pub fn of(reader: &Reader) -> Self {
        let pairs = reader.files().iter().zip(reader.seals());
        let files = pairs.map(|(file, seal)| FileSeal {
            name: file
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            seal: seal.clone(),
        });
        Self {
            files: files.collect(),
            predecessor: None,
            trusted: Vec::new(),
            is_required: false,
            must_be_final: false,
            successor: None,
            ends_in_record: reader.wholeness().ends_in_record,
        }
    }

    /// Also looks for the recording before it in the same session, and reads it, and for one after it that continues another.
    #[must_use]
    pub fn with_neighbours(mut self, reader: &Reader) -> Self {
        self.predecessor = Some(reader.predecessor());
        self.successor = reader.contradicting_successor();
        self
    }

    /// Demands that the seals cover every message, and, if keys are given, that they are by one of them.
    #[must_use]
    pub fn required(mut self, trusted: Vec<PublicKey>) -> Self {
        self.is_required = true;
        self.trusted = trusted;
        self
    }

    /// Also demands that each file ends with its final seal: one without it was cut off, by a crash or by a forger.
    #[must_use]
    pub fn to_the_end(mut self) -> Self {
        self.is_required = true;
        self.must_be_final = true;
        self
    }

    /// Whether any file is sealed.
    #[must_use]
    pub fn is_sealed(&self) -> bool {
        self.seals().next().is_some()
    }

    /// Why the seals do not hold, or not as demanded; `None` if nothing is wrong.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        self.files
            .iter()
            .find_map(|file| self.fault_of(file))
            .or_else(|| {
                self.predecessor
                    .as_ref()
                    .filter(|it| it.is_fault())
                    .map(predecessor_text)
            })
            .or_else(|| self.successor.as_deref().map(successor_text))
            .or_else(|| {
                (self.is_required && self.ends_in_record).then(|| {
                    "it ends in the middle of a record, which no seal covers; repair it first, and verify the repaired recording".to_owned()
                })
            })
    }

    fn seals(&self) -> impl Iterator<Item = &Seal> {
        self.files.iter().filter_map(|it| it.seal.as_ref())
    }

    fn fault_of(&self, file: &FileSeal) -> Option<String> {
        let Some(seal) = &file.seal else {
            return self
                .is_required
                .then(|| format!("{} is not sealed, but a seal is required", file.name));
        };
        if let Some(fault) = &seal.fault {
            return Some(format!("the seal of {} does not hold: {fault}", file.name));
        }
        if !self.trusted.is_empty() && !seal.public_key.is_some_and(|it| self.trusted.contains(&it))
        {
            return Some(format!(
                "{} is sealed by the key {}, which is not a trusted key",
                file.name,
                key_text(seal)
            ));
        }
        if self.is_required && seal.uncovered > 0 {
            return Some(format!(
                "the seal of {} does not cover its last {} messages",
                file.name, seal.uncovered
            ));
        }
        (self.must_be_final && !seal.is_final).then(|| {
            format!(
                "{} has no final seal: a crash or a person has cut off its end, and messages may be missing there; without \
                 --require-seal, verify accepts that",
                file.name
            )
        })
    }

    /// The lines about one file.
    fn lines(&self, file: &FileSeal) -> Vec<String> {
        let Some(seal) = &file.seal else {
            return vec!["not sealed".to_owned()];
        };
        let mut lines = vec![match (self.is_trusted(seal), seal.fresh_key) {
            (true, _) => format!("sealed by the trusted key {}", key_text(seal)),
            (false, true) => format!(
                "sealed by the key {}, made for that run only",
                key_text(seal)
            ),
            (false, false) => format!("sealed by the key {}", key_text(seal)),
        }];
        lines.push(extent(seal, self.is_trusted(seal)));
        if seal.holds() && !seal.is_final {
            lines.push(
                "it has no final seal: the recording was cut off, and messages may be missing at its end"
                    .to_owned(),
            );
        }
        if seal.holds() && !self.is_trusted(seal) {
            lines.push(
                match seal.fresh_key {
                    true => "it proves that nothing was changed since, but not who has recorded: compare the key with the recorder's log",
                    false => "it proves that nothing was changed since, but not who has recorded, unless you know the key: --trusted-key",
                }
                .to_owned(),
            );
        }
        lines
    }

    fn is_trusted(&self, seal: &Seal) -> bool {
        seal.public_key.is_some_and(|it| self.trusted.contains(&it))
    }

    /// The findings as lines of text; with several files, each line begins with the name of its file.
    #[must_use]
    pub fn texts(&self) -> Vec<String> {
        let mut texts = Vec::new();
        for file in &self.files {
            for line in self.lines(file) {
                texts.push(match self.files.len() {
                    1 => line,
                    _ => format!("{}: {line}", file.name),
                });
            }
        }
        texts.extend(
            self.predecessor
                .iter()
                .filter(|it| **it != Predecessor::None)
                .map(predecessor_text),
        );
        texts.extend(self.successor.as_deref().map(successor_text));
        texts
    }

    /// The findings as data, one object for each file; null for a file without a seal.
    #[must_use]
    pub fn json(&self) -> Json {
        let seals = self.files.iter().map(|file| {
            file.seal.as_ref().map(|seal| {
                json!({
                    "file": file.name,
                    "holds": seal.holds(),
                    "fault": seal.fault,
                    "public_key": seal.public_key.map(|it| it.to_string()),
                    "fresh_key": seal.fresh_key,
                    "covered_messages": seal.covered,
                    "covered_until": seal.covered_until,
                    "uncovered_messages": seal.uncovered,
                    "final": seal.is_final,
                    "session": seal.session,
                    "recording": seal.recording,
                    "previous": seal.previous.as_ref().map(|it| &it.name),
                })
            })
        });
        Json::Array(seals.map(|it| it.unwrap_or(Json::Null)).collect())
    }
}

impl fmt::Display for SealFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, text) in self.texts().iter().enumerate() {
            let head = if index == 0 { "Seal: " } else { "      " };
            writeln!(f, "{head}{text}")?;
        }
        Ok(())
    }
}

fn key_text(seal: &Seal) -> String {
    seal.public_key
        .map_or_else(|| "(unreadable)".to_owned(), |it| it.to_string())
}

/// How far the seal proves what was recorded.
fn extent(seal: &Seal, is_trusted: bool) -> String {
    let until = seal
        .covered_until
        .map_or_else(String::new, |it| format!(", up to {},", instant(it)));
    match (&seal.fault, seal.covered, seal.uncovered) {
        (Some(fault), 0, _) => format!("it does NOT hold: {fault}"),
        (Some(fault), covered, _) => format!(
            "it does NOT hold: {fault}; only the first {covered} messages{until} are proved to be unchanged"
        ),
        (None, 0, 0) => "it holds, and there is no message".to_owned(),
        (None, 0, uncovered) => format!("it covers none of the {uncovered} messages"),
        // Who does not have the recorder's key can record anything, and seal it.
        (None, covered, 0) => {
            let proved = match is_trusted {
                true => "they were recorded",
                false => "the owner of that key has sealed them",
            };
            format!("it holds: all {covered} messages{until} are as {proved}")
        }
        (None, covered, uncovered) => format!(
            "it holds for the first {covered} messages{until} and does not cover the {uncovered} messages after them"
        ),
    }
}

fn predecessor_text(predecessor: &Predecessor) -> String {
    match predecessor {
        Predecessor::None => "the first recording of its session".to_owned(),
        Predecessor::Found(directory) => {
            format!("it continues {}, whose seal holds", name_of(directory))
        }
        Predecessor::Gone { name } => format!(
            "it continues {name}; neither that recording nor an earlier one of its session is in this folder"
        ),
        Predecessor::Missing { name, earlier } => format!(
            "the recording before it, {name}, is missing from this folder, although an earlier one of the same session, {}, is there",
            name_of(earlier)
        ),
        Predecessor::Changed(directory) => format!(
            "the recording before it, {}, was changed or replaced: its seal does not hold, or does not end where this recording continues",
            name_of(directory)
        ),
    }
}

fn successor_text(successor: &Path) -> String {
    format!(
        "it was changed or put in the place of another recording: {} continues one of this name with another end",
        name_of(successor)
    )
}

fn name_of(directory: &Path) -> String {
    directory
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// A public key as a user gives it: 64 hexadecimal digits, or a file.
///
/// # Errors
/// It is neither, or the file contains something else.
pub fn public_key(text: &str) -> Result<PublicKey, RecordingError> {
    text.parse().or_else(|()| PublicKey::read(Path::new(text)))
}
