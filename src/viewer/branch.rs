//! A part of the tree of entities of a Rerun stream: that of one column.

use rerun::external::re_log_types::EntityPathPart;
use rerun::{
    AsComponents, RecordingStream, RecordingStreamResult, SerializedComponentColumn, TimeColumn,
};

/// The entities of a stream below a root. A stream that shows one column has the root `/`.
#[derive(Clone)]
pub(super) struct Branch {
    stream: RecordingStream,
    /// Empty, or with a slash before each part.
    root: String,
}

impl Branch {
    /// All entities of a stream.
    #[must_use]
    pub fn whole(stream: RecordingStream) -> Self {
        Self {
            stream,
            root: String::new(),
        }
    }

    /// The entities below a name such as `/garage/a3`.
    #[must_use]
    pub fn below(stream: RecordingStream, name: &str) -> Self {
        let root = root_of(name);
        Self { stream, root }
    }

    /// The stream.
    #[must_use]
    pub fn stream(&self) -> &RecordingStream {
        &self.stream
    }

    /// The root, with which [`entity`](entity) makes whole paths.
    #[must_use]
    pub fn root(&self) -> &str {
        &self.root
    }

    /// Logs data that have no time.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn log_static(
        &self,
        of: impl AsRef<str>,
        what: &impl AsComponents,
    ) -> RecordingStreamResult<()> {
        self.stream
            .log_static(entity(&self.root, of.as_ref()), what)
    }

    /// Sends rows of data with their times.
    ///
    /// # Errors
    /// The stream rejects the data.
    pub fn send_columns(
        &self,
        of: impl AsRef<str>,
        times: Vec<TimeColumn>,
        data: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> RecordingStreamResult<()> {
        self.stream
            .send_columns(entity(&self.root, of.as_ref()), times, data)
    }
}

/// The root of the entities of a column with this name, whose parts may contain what has a meaning in paths.
#[must_use]
pub(super) fn root_of(name: &str) -> String {
    let parts = name.split('/').filter(|part| !part.is_empty());
    let escaped = parts.map(|part| format!("/{}", EntityPathPart::new(part).escaped_string()));
    escaped.collect()
}

/// The whole path of an entity below a root.
#[must_use]
pub(super) fn entity(root: &str, of: &str) -> String {
    format!("{root}/{}", of.trim_start_matches('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_are_paths_whatever_they_contain() {
        assert_eq!(root_of("/garage/a3"), "/garage/a3");
        assert_eq!(root_of("garage//a3/"), "/garage/a3");
        assert_eq!(
            entity(&root_of("/a b"), "column/steel"),
            "/a\\ b/column/steel"
        );
        assert_eq!(entity("", "column/steel"), "/column/steel");
        let path = rerun::EntityPath::parse_strict(&root_of("/a.b/ü \"x\""));
        assert_eq!(path.expect("a path").len(), 2);
    }
}
