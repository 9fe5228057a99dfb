//! What was changed in a recording is found, and named.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use column_twin::evidence::{Line, LineEntry, RECORDED, Topics, Verification, VerifyError, verify};
use column_twin::messages::cdr;
use column_twin::messages::column_twin::{ColumnState, ImpactReport};
use column_twin::recording::{Entry, Message, Reader, Writer, WriterOptions};
use column_twin::twin::Journal;
use tempfile::TempDir;

use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

/// Two impacts and the time between them.
fn recording() -> Finished {
    let mut twin = RecordedTwin::new(parameters());
    for id in ["a", "b"] {
        twin.hit(event(id, twin.now));
        twin.until_rest();
        twin.advance(100 * MS);
    }
    twin.finish()
}

/// Writes a recording anew; `change` says what becomes of each message.
fn forged(
    original: &Path,
    mut change: impl FnMut(&Message) -> Option<Vec<u8>>,
) -> (TempDir, PathBuf) {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("forged");
    let topics = Topics::of_default_node();
    let declared = topics.declared().unwrap();
    let mut writer = Writer::create(&path, &WriterOptions::default(), &declared).unwrap();
    for message in Reader::open(original).unwrap().messages() {
        let message = message.unwrap();
        let Some(data) = change(&message) else {
            continue;
        };
        let topic = declared.iter().position(|it| *it.name == *message.topic);
        let entry = Entry {
            topic: topic.unwrap(),
            log_time: message.log_time,
            publish_time: message.publish_time,
            data: data.into(),
            checkpoint: false,
        };
        writer.write(&entry).unwrap();
    }
    writer.finish().unwrap();
    (directory, path)
}

/// A copy in which one field of the `which`-th message of a topic was changed.
fn changed<M: column_twin::messages::Message>(
    original: &Path,
    topic: &str,
    which: usize,
    mut change: impl FnMut(&mut M),
) -> Verification {
    let mut count = 0;
    let (_directory, path) = forged(original, |message| {
        if *message.topic == *topic {
            count += 1;
            if count == which {
                let mut value: M = cdr::decode(&message.data).unwrap();
                change(&mut value);
                return Some(cdr::encode(&value).unwrap());
            }
        }
        Some(message.data.clone())
    });
    verify(&path).unwrap()
}

/// A copy in which the last bit of `v1` of the seventh state was changed.
pub fn with_one_bit_flipped(original: &Path) -> (TempDir, PathBuf) {
    let mut count = 0;
    forged(original, |message| {
        count += usize::from(*message.topic == *"/column_state");
        if *message.topic != *"/column_state" || count != 7 {
            return Some(message.data.clone());
        }
        let mut state: ColumnState = cdr::decode(&message.data).unwrap();
        flip(&mut state.v1);
        Some(cdr::encode(&state).unwrap())
    })
}

/// The last bit.
fn flip(number: &mut f64) {
    *number = f64::from_bits(number.to_bits() ^ 1);
}

#[test]
fn a_copy_is_as_good_as_the_original() {
    let original = recording();
    let (_directory, path) = forged(&original.path(), |message| Some(message.data.clone()));
    let found = verify(&path).unwrap();
    assert!(found.is_equal(), "{found}");
}

#[test]
fn one_flipped_bit_is_named() {
    let original = recording();
    let mut stamp = None;
    let found = changed(
        &original.path(),
        "/column_state",
        17,
        |state: &mut ColumnState| {
            flip(&mut state.u2_rate);
            stamp = state.header.stamp.to_nanos();
        },
    );
    assert!(!found.is_equal());
    assert_eq!(found.differences, 1);
    let first = found.first_difference.clone().unwrap();
    assert_eq!(
        (first.topic.as_str(), first.field.as_str()),
        ("/column_state", "u2_rate")
    );
    assert_eq!((first.stamp, first.event_id.as_str()), (stamp, "a"));
    let by = first.by.unwrap().abs();
    assert!(by > 0.0 && by < 1e-12, "{first}");
    assert!(found.to_string().contains("u2_rate"), "{found}");
}

#[test]
fn reports_are_compared_but_for_their_compute_time() {
    let original = recording();
    let found = changed(
        &original.path(),
        "/impact_report",
        2,
        |report: &mut ImpactReport| {
            report.compute_time = 77.0;
        },
    );
    assert!(found.is_equal(), "{found}");
    let found = changed(
        &original.path(),
        "/impact_report",
        2,
        |report: &mut ImpactReport| {
            flip(&mut report.plastic_rotation[3]);
        },
    );
    let first = found.first_difference.unwrap();
    assert_eq!(
        (first.field.as_str(), first.event_id.as_str()),
        ("plastic_rotation[3]", "b")
    );
}

/// The exact state at rest is a witness too.
#[test]
fn a_changed_state_at_rest_is_found() {
    let original = recording();
    let mut points = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if !message.topic.ends_with("/journal") {
            return Some(message.data.clone());
        }
        let mut line = Line::decode(&message.data).unwrap();
        if let LineEntry::Twin(Journal::Checkpoint(point)) = &mut line.entry {
            points += 1;
            if points == 2 {
                let mut other = (**point).clone();
                flip(&mut other.state.plastic.below.rotation[0]);
                *point = other.into();
            }
        }
        Some(line.encode().unwrap())
    });
    let found = verify(&path).unwrap();
    assert!(!found.is_equal());
    let first = found.first_difference.unwrap();
    assert!(first.topic.ends_with("/journal"));
    assert_eq!(first.field, "state.plastic.below.rotation[0]");
}

#[test]
fn messages_that_were_taken_out_are_missed() {
    let original = recording();
    for topic in [
        "/column_state",
        "/hinge_forces",
        "/impact_report",
        "/twin_status",
        "/markers",
    ] {
        let mut count = 0;
        let (_directory, path) = forged(&original.path(), |message| {
            count += usize::from(*message.topic == *topic);
            (*message.topic != *topic || count != 2).then(|| message.data.clone())
        });
        let found = verify(&path).unwrap();
        // The last report has nothing behind it that shows that it is missing, but its own status has.
        assert_eq!(
            (found.missing(), found.is_equal()),
            (1, false),
            "{topic}: {found}"
        );
    }
}

#[test]
fn messages_that_were_put_in_are_found() {
    let original = recording();
    let mut twice = false;
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("forged");
    let declared = Topics::of_default_node().declared().unwrap();
    let mut writer = Writer::create(&path, &WriterOptions::default(), &declared).unwrap();
    for message in Reader::open(&original.path()).unwrap().messages() {
        let message = message.unwrap();
        let topic = declared
            .iter()
            .position(|it| *it.name == *message.topic)
            .unwrap();
        let is_report = RECORDED[topic].name == "impact_report";
        let entry = Entry {
            topic,
            log_time: message.log_time,
            publish_time: message.publish_time,
            data: message.data.into(),
            checkpoint: false,
        };
        writer.write(&entry).unwrap();
        if is_report && !twice {
            twice = true;
            writer.write(&entry).unwrap();
        }
    }
    writer.finish().unwrap();
    let found = verify(&path).unwrap();
    assert!(!found.is_equal(), "{found}");
    assert_eq!(found.topics[3].foreign, 1, "{found}");
}

#[test]
fn what_cannot_be_checked_is_said() {
    let original = recording();
    // Without its first checkpoint.
    let mut points = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal")
            && Line::decode(&message.data).unwrap().is_checkpoint()
        {
            points += 1;
            if points == 1 {
                return None;
            }
        }
        Some(message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(
        found.is_equal() && found.unchecked_messages() > 20,
        "{found}"
    );
    assert!(
        found.unchecked[0].contains("before the first checkpoint"),
        "{found}"
    );
    assert!(found.compared() > 20, "{found}");
    assert!(
        found
            .to_string()
            .contains("Equal as far as it could be checked: "),
        "{found}"
    );
    // Without an input.
    let mut inputs = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            let line = Line::decode(&message.data).unwrap();
            if matches!(line.entry, LineEntry::Twin(Journal::Command(_))) {
                inputs += 1;
                if inputs == 1 {
                    return None;
                }
            }
        }
        Some(message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(!found.is_equal(), "{found}");
    assert_eq!(found.missing_entries, 1, "{found}");
}

/// Each entry that the twin numbers, but the last, which nothing shows to be missing, and the first checkpoint, from
/// which a recording may also begin.
#[test]
fn an_entry_of_the_journal_that_was_taken_out_is_missed() {
    let original = recording();
    let numbered = |message: &Message| {
        message.topic.ends_with("/journal")
            && !matches!(
                Line::decode(&message.data).unwrap().entry,
                LineEntry::Twin(Journal::Status(_))
            )
    };
    let reader = Reader::open(&original.path()).unwrap();
    let count = reader
        .messages()
        .filter(|it| numbered(it.as_ref().unwrap()))
        .count();
    assert_eq!(count, 5, "three states at rest and two inputs");
    for taken_out in 1..count - 1 {
        let mut index = 0;
        let (_directory, path) = forged(&original.path(), |message| {
            index += usize::from(numbered(message));
            let is_it = numbered(message) && index == taken_out + 1;
            (!is_it).then(|| message.data.clone())
        });
        let found = verify(&path).unwrap();
        assert!(!found.is_equal(), "{taken_out}: {found}");
        assert_eq!(found.missing_entries, 1, "{taken_out}: {found}");
    }
}

/// However many entries are said to be missing, they are more than none.
#[test]
fn a_number_beyond_all_others_is_not_equal() {
    let original = recording();
    let mut inputs = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            let mut line = Line::decode(&message.data).unwrap();
            if let LineEntry::Twin(Journal::Command(handled)) = &mut line.entry {
                inputs += 1;
                if inputs == 2 {
                    Arc::make_mut(handled).number = u64::MAX;
                    return Some(line.encode().unwrap());
                }
            }
        }
        Some(message.data.clone())
    });
    assert!(inputs >= 2);
    let found = verify(&path).unwrap();
    assert!(!found.is_equal() && found.missing() > 1_000_000, "{found}");
}

/// Nothing but the first checkpoint is left of what the journal said of it.
#[test]
fn messages_of_which_none_can_be_compared_are_not_equal() {
    let original = recording();
    let mut entries = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            entries += 1;
            return (entries == 1).then(|| message.data.clone());
        }
        (*message.topic == *"/column_state").then(|| message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(found.is_unchecked() && !found.is_equal(), "{found}");
    assert!(
        found.to_string().contains("Nothing could be checked"),
        "{found}"
    );
}

#[test]
fn a_recording_without_a_journal_is_none_to_verify() {
    let original = recording();
    let (_directory, path) = forged(&original.path(), |message| {
        (!message.topic.ends_with("/journal")).then(|| message.data.clone())
    });
    assert!(matches!(
        verify(&path),
        Err(VerifyError::NoCheckpoint { .. })
    ));
    assert!(matches!(
        verify(Path::new("nothing/there")),
        Err(VerifyError::Recording(_))
    ));
}
