//! Names of nodes, and the patterns by which parameter files refer to them.

use std::fmt;

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

/// Normalizes a name: one slash before every part and none elsewhere.
pub(super) fn with_slashes(name: &str) -> String {
    name.split('/')
        .filter(|part| !part.is_empty())
        .flat_map(|part| ["/", part])
        .collect()
}

/// Longest namespace \[bytes\], as in rmw (`RMW_NAMESPACE_MAX_LENGTH`).
const MAX_NAMESPACE: usize = 245;

/// Why a node cannot have this namespace; `None` if it can.
#[must_use]
pub fn namespace_fault(namespace: &str) -> Option<&'static str> {
    match namespace {
        "/" => None,
        _ if namespace.len() > MAX_NAMESPACE => Some("a namespace has at most 245 characters"),
        _ => full_name_fault(namespace),
    }
}

/// Why a topic, service or node cannot have this full name; `None` if it can.
#[must_use]
pub fn full_name_fault(name: &str) -> Option<&'static str> {
    let Some(rest) = name.strip_prefix('/') else {
        return Some("it must begin with `/`");
    };
    if rest.ends_with('/') {
        return Some("it must not end with `/`");
    }
    rest.split('/').find_map(part_fault)
}

/// Why a name cannot have this part between its slashes; `None` if it can.
#[must_use]
pub fn part_fault(part: &str) -> Option<&'static str> {
    if part.is_empty() {
        Some("there must be a name before and after each `/`")
    } else if part.starts_with(|c: char| c.is_ascii_digit()) {
        Some("no part may begin with a digit")
    } else if !part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        Some("only letters, digits and underscores are allowed between `/`")
    } else if part.contains("__") {
        Some("underscores must not be repeated")
    } else {
        None
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
