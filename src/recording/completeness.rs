//! Whether anything is missing in a recording, in words.

use super::Reader;

/// What is missing in a recording; `None` if it is complete as far as it can tell.
#[must_use]
pub fn incompleteness(reader: &Reader) -> Option<String> {
    if reader.was_cut_off() {
        return Some(
            "its end was cut off before it was repaired, and the number of lost messages is not known"
                .to_owned(),
        );
    }
    if !reader.wholeness().is_whole() {
        return Some(format!("the file is {}", reader.wholeness()));
    }
    let lost = reader.lost_messages().filter(|lost| *lost > 0)?;
    Some(format!("the recorder has lost {lost} messages"))
}
