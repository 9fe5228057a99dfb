//! Reads small YAML files of texts, one for each name.

use std::path::Path;

use super::fault::ParameterFaults;
use super::file;
use super::yaml::{self, YamlContent};

/// A name and its text, with the line in which it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedText {
    /// Its name.
    pub name: String,
    /// The text, as it was typed; empty for nothing.
    pub text: String,
    /// From 1.
    pub line: usize,
}

/// The texts of a YAML file of the form `name: text`, in their order; the file has at most `max_bytes`.
///
/// # Errors
/// What is wrong, in words, with the line.
pub fn named_texts(path: &Path, max_bytes: u64) -> Result<Vec<NamedText>, String> {
    let source = file::source(path, max_bytes)
        .map_err(|fault| ParameterFaults::of(vec![*fault]).in_one_line())?;
    let parsed = yaml::parse(&source.text)
        .map_err(|error| format!("line {}: {}", error.at.line, error.message))?;
    let Some(root) = parsed else {
        return Ok(Vec::new());
    };
    let entries = match root.content {
        YamlContent::Null => return Ok(Vec::new()),
        YamlContent::Mapping(entries) => entries,
        _ => {
            return Err(format!(
                "line {}: expected lines of the form \"name: text\"",
                root.at.line
            ));
        }
    };
    let texts = entries.into_iter().map(|(key, node)| {
        let text = match node.content {
            YamlContent::Null => String::new(),
            YamlContent::Scalar { text, .. } => text,
            _ => {
                return Err(format!(
                    "line {}: expected a text for {}, found a list or a mapping",
                    node.at.line, key.text
                ));
            }
        };
        Ok(NamedText {
            name: key.text,
            text,
            line: key.at.line,
        })
    });
    texts.collect()
}
