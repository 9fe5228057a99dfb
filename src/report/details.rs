//! What an office writes into a report beside the numbers: project, site, author and the like.

use std::path::{Path, PathBuf};

use crate::parameters::{NamedText, named_texts};

/// Maximum size of a file of details \[bytes\].
const MAX_FILE_BYTES: u64 = 64 << 10;

/// Most characters of a detail, so that the first page remains one page.
pub const MAX_DETAIL_CHARS: usize = 80;

/// A field: its name in the file, and what the report calls it.
type Field = (&'static str, &'static str);

/// Every field of the title block.
const FIELDS: [Field; 9] = [
    ("project", "Project"),
    ("site", "Site"),
    ("client", "Client"),
    ("document", "Document"),
    ("revision", "Revision"),
    ("date", "Date"),
    ("author", "Author"),
    ("checker", "Checker"),
    ("hit_direction", "Direction of the hit on site"),
];

/// What an office writes into a report; a field that is not given becomes a line to be filled in by hand.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReportDetails {
    given: Vec<(&'static str, String)>,
}

/// Why a file of details cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot use the details of the report in {}: {reason}", path.display())]
#[diagnostic(help(
    "write a YAML file with lines such as \"project: Car park North\"; known names: {}",
    known_names()
))]
pub struct ReportDetailsError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, and where.
    pub reason: String,
}

fn known_names() -> String {
    FIELDS.map(|(name, _)| name).join(", ")
}

impl ReportDetails {
    /// Reads a YAML file with one line for each field, such as `author: A. Miller`.
    ///
    /// # Errors
    /// The file cannot be read, a field is not known or given twice, or a text is too long or has several lines.
    pub fn read(path: &Path) -> Result<Self, ReportDetailsError> {
        let fault = |reason| ReportDetailsError {
            path: path.to_path_buf(),
            reason,
        };
        let texts = named_texts(path, MAX_FILE_BYTES).map_err(fault)?;
        Self::of(texts).map_err(fault)
    }

    fn of(texts: Vec<NamedText>) -> Result<Self, String> {
        let mut given: Vec<(&'static str, String)> = Vec::new();
        for NamedText { name, text, line } in texts {
            let Some((known, _)) = FIELDS.iter().find(|(known, _)| *known == name) else {
                return Err(format!(
                    "line {line}: expected one of {}; found {name}",
                    known_names()
                ));
            };
            if given.iter().any(|(before, _)| before == known) {
                return Err(format!("line {line}: {name} is given twice"));
            }
            let chars = text.chars().count();
            if chars > MAX_DETAIL_CHARS || text.chars().any(char::is_control) {
                return Err(format!(
                    "line {line}: expected one line of at most {MAX_DETAIL_CHARS} characters for {name}, found {chars}"
                ));
            }
            given.push((known, text));
        }
        Ok(Self { given })
    }

    /// The text of a field; `None` where it is not given or empty.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        let found = self.given.iter().find(|(known, _)| *known == name);
        found
            .map(|(_, text)| text.as_str())
            .filter(|it| !it.is_empty())
    }

    /// What the report calls a field.
    pub(super) fn label(name: &str) -> &'static str {
        let found = FIELDS.iter().find(|(known, _)| *known == name);
        found.map_or("", |(_, label)| label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<ReportDetails, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("details.yaml");
        std::fs::write(&path, text).expect("a file");
        ReportDetails::read(&path).map_err(|fault| fault.reason)
    }

    #[test]
    fn details_are_texts_as_they_were_typed() {
        let read = read("project: Car park North\nrevision: 1\ndate: 2026-11-25\nchecker:\n");
        let details = read.expect("details");
        assert_eq!(details.get("project"), Some("Car park North"));
        assert_eq!(details.get("revision"), Some("1"));
        assert_eq!(details.get("date"), Some("2026-11-25"));
        assert_eq!(details.get("checker"), None);
        assert_eq!(details.get("site"), None);
    }

    #[test]
    fn what_is_wrong_with_details_is_named_with_its_line() {
        for (text, expected) in [
            (
                "project: A\nprojct: B\n",
                "line 2: expected one of project, site",
            ),
            ("site: A\nsite: B\n", "twice"),
            ("author: [A, B]\n", "line 1: expected a text for author"),
            ("- A\n", "line 1: expected lines of the form"),
            (
                "author: \"A\\nB\"\n",
                "expected one line of at most 80 characters",
            ),
        ] {
            let reason = read(text).expect_err(text);
            assert!(reason.contains(expected), "{text}: {reason}");
        }
        let long = format!("author: {}\n", "x".repeat(81));
        assert!(read(&long).expect_err("too long").contains("found 81"));
        assert!(read("").expect("nothing").given.is_empty());
    }
}
