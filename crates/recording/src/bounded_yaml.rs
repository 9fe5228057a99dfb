//! YAML from recordings of unknown origin. The time that libyaml takes grows with the square of what is nested, of directives
//! and of anchors, none of which rosbag2 writes.

use serde::de::DeserializeOwned;

/// Maximum number of brackets that a text may open and not close.
const MAX_OPEN_BRACKETS: usize = 100;

/// Maximum number of block entries that one line may begin.
const MAX_INDICATORS: usize = 100;

/// Reads a text as `T`.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    check(text)?;
    serde_yaml_ng::from_str(text).map_err(|error| error.to_string())
}

fn check(text: &str) -> Result<(), String> {
    let mut open = 0_usize;
    for (index, line) in text.lines().enumerate() {
        let wrong = |what: &str| Err(format!("line {}: {what}", index + 1));
        if line.starts_with('%') {
            return wrong("expected no directive, found one");
        }
        // Brackets in a quoted text count, too: no metadata has a hundred more of one kind than of the other.
        for byte in line.bytes() {
            match byte {
                b'[' | b'{' => open += 1,
                b']' | b'}' => open = open.saturating_sub(1),
                _ => {}
            }
            if open > MAX_OPEN_BRACKETS {
                return wrong(&format!(
                    "expected at most {MAX_OPEN_BRACKETS} brackets inside each other, found more"
                ));
            }
        }
        let indicators = line
            .split_whitespace()
            .filter(|it| matches!(*it, "-" | "?" | ":"));
        if indicators.take(MAX_INDICATORS + 1).count() > MAX_INDICATORS {
            return wrong(&format!(
                "expected at most {MAX_INDICATORS} entries inside each other, found more"
            ));
        }
    }
    Ok(())
}
