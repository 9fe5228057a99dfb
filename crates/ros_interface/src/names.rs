//! What names of nodes, topics and services may look like (<https://design.ros2.org/articles/topic_and_service_names.html>).

/// Normalizes a name: one slash before every part and none elsewhere.
#[must_use]
pub fn with_slashes(name: &str) -> String {
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
