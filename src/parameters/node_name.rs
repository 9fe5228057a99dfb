//! Names of nodes, and the patterns by which parameter files refer to them.

use std::fmt;

use ros_interface::names::with_slashes;

/// Fully qualified name of a node, such as `/garage/a3/column_twin`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeName(String);

impl NodeName {
    /// From a namespace (`/`, `/garage/a3`) and a name.
    #[must_use]
    pub fn new(namespace: &str, name: &str) -> Self {
        Self(with_slashes(&format!("{namespace}/{name}")))
    }

    /// The name without its namespace.
    #[must_use]
    pub fn bare(&self) -> &str {
        self.0.rsplit('/').next().unwrap_or_default()
    }

    /// Whether a pattern that matches this node names it: its last part is the node's name and not a wildcard.
    #[must_use]
    pub fn is_named_by(&self, pattern: &str) -> bool {
        with_slashes(pattern).rsplit('/').next() == Some(self.bare())
    }

    /// Whether a name or pattern from a parameter file matches this node: `*` matches one part of the name, `**` any
    /// number of parts.
    #[must_use]
    pub fn is_meant_by(&self, pattern: &str) -> bool {
        fn matches(pattern: &[&str], name: &[&str]) -> bool {
            match pattern {
                [] => name.is_empty(),
                ["**", rest @ ..] => {
                    (0..=name.len()).any(|skipped| matches(rest, &name[skipped..]))
                }
                [part, rest @ ..] => match name {
                    [first, others @ ..] => {
                        (*part == "*" || part == first) && matches(rest, others)
                    }
                    [] => false,
                },
            }
        }
        let pattern = with_slashes(pattern);
        let mut pattern: Vec<_> = pattern.split('/').skip(1).collect();
        pattern.dedup_by(|next, last| *next == "**" && *last == "**"); // keeps the search short
        matches(&pattern, &self.0.split('/').skip(1).collect::<Vec<_>>())
    }
}

impl Default for NodeName {
    /// `/column_twin`
    fn default() -> Self {
        Self::new("/", "column_twin")
    }
}

impl fmt::Display for NodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wildcards_match_parts() {
        let node = NodeName::new("/garage//a3/", "column_twin");
        assert_eq!(node.to_string(), "/garage/a3/column_twin");
        assert_eq!(node.bare(), "column_twin");
        for (pattern, meant) in [
            ("/**", true),
            ("/**/**/**", true),
            ("**/column_twin", true),
            ("/garage/**/column_twin", true),
            ("/garage/a3/**/column_twin", true),
            ("/*/*/*", true),
            ("/*", false),
            ("/*/column_twin", false),
            ("column_twin", false),
            ("/garage/a3/column_twin/more", false),
            ("", false),
        ] {
            assert_eq!(node.is_meant_by(pattern), meant, "{pattern}");
        }
        for (pattern, named) in [
            ("/garage/a3/column_twin", true),
            ("/**/column_twin", true),
            ("/*/*/column_twin", true),
            ("/**", false),
            ("/garage/**", false),
            ("/garage/a3/*", false),
        ] {
            assert!(node.is_meant_by(pattern), "{pattern}");
            assert_eq!(node.is_named_by(pattern), named, "{pattern}");
        }
        let long = "/**/*".repeat(10_000);
        assert!(!node.is_meant_by(&long));
    }
}
